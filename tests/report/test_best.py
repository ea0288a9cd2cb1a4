"""The best variant and its gain, with differences within the scatter ignored."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.report.pages import Page
from tests.report.test_compensation import with_error
from tests.report.test_pages import simulation_page
from tests.stand_ins import Loop

from bristle.core import Status
from bristle.report.compensation import closing_sentences, gain_of, pair_in, standing
from bristle.simulation.result import SimulationResult
from bristle.simulation.statistics import Statistics


def variant(name, peak, spread=0.0, status=Status.OK):
    error = Statistics(peak, 0.0, 0.0, 0.0, 0.0, peak)
    scatter = {"following_error": {"peak_to_peak": spread}} if spread else {}
    runs = 3 if spread else 1
    return Loop(name=name, following_error=error, spread=scatter, runs=runs, status=status)


def message(*variants, refused=()):
    fed = SimpleNamespace(friction=None)
    shown = [SimpleNamespace(name=item.name, reference=None, feedforward=fed) for item in variants]
    experiment = SimpleNamespace(kind="translational", variants=shown)
    result = SimulationResult(experiment, {item.name: item for item in variants}, dict.fromkeys(refused, "unstable"))
    return " ".join(closing_sentences(result)).replace("\u00a0", " ")


WILD = Status.NOT_FINITE


@pytest.mark.parametrize(
    ("variants", "refused", "words"),
    [
        (
            [variant("base", 2e-6), variant("worse", 3e-6), variant("best", 5e-7), variant("good", 1e-6)],
            [],
            "0.500 µm (best) instead of 2 µm (base) peak to peak, 75 % less.",
        ),
        # The base is the variant of this name, or the first.
        (
            [variant("base", 2e-6), variant("best", 5e-9)],
            [],
            "0.00500 µm (best) instead of 2 µm (base) peak to peak, smaller by more than a factor of 100.",
        ),
        (
            [variant("a", 5e-6), variant("base", 2e-6), variant("best", 1e-6)],
            [],
            "1 µm (best) instead of 2 µm (base) peak to peak, 50 % less.",
        ),
        ([variant("a", 5e-6), variant("b", 2e-6), variant("best", 1e-6)], [], "1 µm (best) instead of 5 µm (a) peak to peak, 80 % less."),
        (
            [variant("a", 20e-6), variant("b", 2e-6), variant("best", 1e-6)],
            [],
            "1 µm (best) instead of 20 µm (a) peak to peak, smaller by a factor of 20.",
        ),
        # A difference within the scatter is no gain.
        (
            [variant("base", 1.2e-6, 2e-7), variant("best", 1e-6, 1e-7)],
            [],
            "1 µm (best) instead of 1.2 µm (base) peak to peak, hardly less.",
        ),
        # An incomplete variant is neither the best nor the base.
        (
            [variant("base", 2e-6), variant("best", 1e-6), variant("wild", 1e-9, status=WILD)],
            [],
            "1 µm (best) instead of 2 µm (base) peak to peak, 50 % less.",
        ),
        (
            [variant("base", 1e-6), variant("best", 0.0)],
            [],
            "0 m (best) instead of 1 µm (base) peak to peak, smaller by more than a factor of 100.",
        ),
        ([variant("base", 1e-6), variant("worse", 3e-6), variant("worst", 4e-6)], [], "1 µm"),
        ([variant("base", 0.0), variant("best", 1e-6)], [], "0 m"),
        ([variant("base", 1e-6), variant("b", float("nan"))], [], "1 µm"),
        ([variant("base", 1e-9, status=WILD), variant("a", 2e-6), variant("b", 1e-6)], [], ""),
        ([variant("a", 2e-6), variant("b", 1e-6)], ["base"], ""),
        ([variant("base", 1e-6)], [], ""),
    ],
)
def test_best_variant_is_compared_with_the_base(variants, refused, words):
    head = "The best variant is best: following error " if "(best)" in words else "No variant is better than base: "
    tail = "" if "(best)" in words else " peak to peak."
    assert message(*variants, refused=refused) == (words and head + words + tail)


@pytest.mark.usefixtures("undrawn")
def test_page_and_terminal_end_with_the_same_sentences(stage):
    sentences = closing_sentences(stage.looped)
    assert sentences[-1] == gain_of(stage.looped).caveat
    assert sentences[-2] == f"The best variant is compensated: {standing(stage.looped).instead}."
    words = Page(simulation_page(stage)).words
    assert all(" ".join(sentence.split()) in words for sentence in sentences)


def test_gain_belongs_to_the_best_compensator(stage):
    experiment = stage.looped.experiment
    compensated = experiment.variants[-1]
    other = replace(compensated, name="finer")
    result = replace(
        stage.looped,
        experiment=replace(experiment, variants=(*experiment.variants, other)),
        variants={**stage.looped.variants, "finer": replace(stage.looped.variants["compensated"], name="finer")},
    )
    wave = np.sin(40.0 * stage.looped.variants["feedforward"].time)
    for name, error in (("feedforward", 1e-5), ("compensated", 8e-6), ("finer", 2e-6)):
        result = with_error(result, name, lambda _, error=error: error * wave)
    assert [item.name for item in pair_in(result)] == ["feedforward", "finer"]
    assert re.search(r"\(feedforward\) to .*\(finer\) peak to peak, by a factor of 5.0", gain_of(result).sentences()[0])
    wild = replace(result.variants["finer"], status=Status.NOT_FINITE)
    assert pair_in(replace(result, variants={**result.variants, "finer": wild}))[1].name == "compensated"


def test_gain_of_another_law_is_not_credited_to_feedforward(stage):
    experiment = stage.looped.experiment
    as_recorded, *rest = experiment.variants
    stiffer = replace(as_recorded, controller=as_recorded.controller.with_values(k_p=1.0))
    changed = replace(stage.looped, experiment=replace(experiment, variants=(stiffer, *rest)))
    told = [" ".join(gain_of(result).sentences()) for result in (stage.looped, changed)]
    assert ["With all feedforward" in words for words in told] == [True, False]
