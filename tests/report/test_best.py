"""Which variant is best, and by how much: said of all variants, never of a difference that the runs do not bear out."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.report.pages import Page
from tests.report.test_compensation import with_error
from tests.report.test_pages import simulation_page

from bristle.core import Status
from bristle.report.compensation import best_sentences, closing_sentences, gain_of, pair_in
from bristle.simulation.result import SimulationResult, Statistics


def variant(name, peak, spread=0.0, status=Status.OK):
    error = Statistics(peak, 0.0, 0.0, 0.0, 0.0, peak)
    scatter = {"following_error": {"peak_to_peak": spread}} if spread else {}
    return SimpleNamespace(name=name, kind="translational", following_error=error, spread=scatter, runs=3 if spread else 1, status=status)


def said(*variants, refused=()):
    experiment = SimpleNamespace(kind="translational", variants=[SimpleNamespace(name=one.name) for one in variants])
    result = SimulationResult(experiment, {one.name: one for one in variants}, dict.fromkeys(refused, "unstable"))
    return " ".join(best_sentences(result))


def test_the_best_of_all_is_named_and_measured_against_the_base():
    words = said(variant("base", 2e-6), variant("worse", 3e-6), variant("best", 5e-7), variant("good", 1e-6))
    assert words == "Of 4 variants, best errs least: 500 nm peak to peak, 75 % less than base with 2 µm."


def test_the_base_is_that_of_this_name_else_the_first():
    assert "99.75 % less than base with" in said(variant("base", 2e-6), variant("best", 5e-9))
    assert "50 % less than base with" in said(variant("a", 5e-6), variant("base", 2e-6), variant("best", 1e-6))
    assert "80 % less than a with" in said(variant("a", 5e-6), variant("b", 2e-6), variant("best", 1e-6))


def test_runs_tell_how_sure_it_is():
    words = said(variant("base", 2e-6, 4e-8), variant("best", 1e-6, 2e-8))
    assert "best errs least: 1.000 ± 0.020 µm peak to peak" in words
    assert "than base with 2.000 ± 0.040 µm (mean ± standard deviation over 3 runs)" in words
    # Two independent scatters of two percent each.
    percent, spread = re.search(r"([\d.]+) ± ([\d.]+) % less", words).groups()
    assert float(percent) == 50.0
    assert float(spread) == pytest.approx(50.0 * 2.0**0.5 * 0.02, rel=0.05)


def test_a_difference_within_the_scatter_is_no_gain():
    words = said(variant("base", 1.2e-6, 2e-7), variant("best", 1e-6, 1e-7))
    assert "hardly less than base" in words
    assert "% less" not in words


def test_those_that_err_about_as_little_are_named():
    words = said(variant("base", 2e-6), variant("best", 1e-6), variant("near", 1.02e-6), variant("far", 1.2e-6))
    assert words.endswith("About as little errs near.")
    many = [variant(f"v{k}", 1.001e-6) for k in range(6)]
    assert said(variant("base", 2e-6), variant("best", 1e-6), *many).endswith("v0, v1, v2, v3 and 2 more.")


def test_where_nothing_is_better_nothing_is_called_better():
    words = said(variant("base", 1e-6), variant("worse", 3e-6), variant("worst", 4e-6))
    assert words == ("No variant errs less than base: 1 µm peak to peak. The nearest, worse, errs by 3 µm, 200 % more than that.")
    assert "about as much as that" in said(variant("base", 1e-6), variant("near", 1.01e-6))


def test_what_did_not_complete_is_not_the_best_and_no_measure():
    words = said(variant("base", 2e-6), variant("best", 1e-6), variant("wild", 1e-9, status=Status.NOT_FINITE))
    assert words.startswith("Of 2 variants, best errs least")
    words = said(variant("base", 1e-9, status=Status.NOT_FINITE), variant("a", 2e-6), variant("b", 1e-6))
    assert words == "Of 2 variants, b errs least: 1 µm peak to peak. base, against which it would be measured, did not complete."
    assert "base, against which" in said(variant("a", 2e-6), variant("b", 1e-6), refused=["base"])
    assert said(variant("base", 1e-6)) == said(variant("base", 1e-6), variant("b", float("nan"))) == ""


def test_an_error_of_nothing_is_the_least():
    assert "0 m peak to peak, 100 % less" in said(variant("base", 1e-6), variant("best", 0.0))
    assert "0 m" in said(variant("base", 0.0), variant("best", 1e-6))


def test_the_page_and_the_terminal_close_with_it(stage):
    sentences = closing_sentences(stage.looped)
    best = best_sentences(stage.looped)
    assert best
    assert sentences[-1 - len(best) : -1] == best
    assert sentences[-1] == gain_of(stage.looped).caveat
    words = Page(simulation_page(stage)).words
    for one in sentences:
        assert " ".join(one.split()) in words


def test_the_gain_of_compensation_is_that_of_the_best_compensator(stage):
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
    assert [one.name for one in pair_in(result)] == ["feedforward", "finer"]
    first = gain_of(result).sentences()[0]
    assert "(feedforward) to" in first
    assert "(finer) peak to peak, by a factor of 5.0" in first
    wild = replace(result.variants["finer"], status=Status.NOT_FINITE)
    assert pair_in(replace(result, variants={**result.variants, "finer": wild}))[1].name == "compensated"


def test_what_another_law_gains_is_not_credited_to_what_is_fed_forward(stage):
    experiment = stage.looped.experiment
    as_recorded, *rest = experiment.variants
    stiffer = replace(as_recorded, controller=as_recorded.controller.with_values(k_p=1.0))
    changed = replace(stage.looped, experiment=replace(experiment, variants=(stiffer, *rest)))
    assert "with all that is fed forward" in " ".join(gain_of(stage.looped).sentences())
    assert "with all that is fed forward" not in " ".join(gain_of(changed).sentences())
