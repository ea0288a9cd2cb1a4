"""Sentences about the gain of compensation, from loops with known errors."""

import re
from dataclasses import replace
from types import SimpleNamespace, SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.known import errors
from tests.report.pages import Page
from tests.report.test_pages import simulation_page
from tests.stand_ins import Loop

from bristle import controllers, friction, plants, references
from bristle.core import Diagnostic, Status
from bristle.prediction.following import Following
from bristle.report import simulation as simulation_module
from bristle.report.compensation import (
    Errors,
    Gain,
    _errors,
    about_loop,
    closing_sentences,
    gain_of,
    is_alike,
    names_text,
    pair_in,
    standing,
)
from bristle.simulation import SimulationResult, compensation_experiment, simulate, statistics_of


def with_error(result, name, error):
    """The result with a given following error in a variant."""
    item = result.variants[name]
    values = np.asarray(error(item), dtype=float)
    changed = replace(item, measured=item.reference - values, following_error=statistics_of(values))
    return replace(result, variants={**result.variants, name: changed})


def velocity_of(item):
    return np.gradient(item.reference, item.time[1] - item.time[0])


def test_no_gain_without_a_compensated_variant(stage):
    experiment = replace(stage.looped.experiment, variants=stage.looped.experiment.variants[:2])
    assert gain_of(replace(stage.looped, experiment=experiment)) is None


def test_error_proportional_to_velocity_is_lag(stage):
    for name in ("feedforward", "compensated"):
        result = with_error(stage.looped, name, lambda item: 2.5e-3 * velocity_of(item))
    step = gain_of(result).steps[-1]
    assert (step.lag, step.lag_share, step.beyond_lag) == pytest.approx(
        (2.5e-3, 1.0, 0.0), abs=1e-12
    )
    assert "a lag of 2.5 ms" in " ".join(gain_of(result).sentences())


def test_error_of_friction_is_not_lag(stage):
    noise = np.random.default_rng(0).normal(size=stage.looped.variants["compensated"].time.size)
    result = with_error(stage.looped, "compensated", lambda _: 1e-6 * noise)
    assert "lag of" not in " ".join(gain_of(result).sentences())


def test_diverged_loop_has_no_gain(stage):
    changed = replace(stage.looped.variants["compensated"], status=Status.NOT_FINITE)
    result = replace(stage.looped, variants={**stage.looped.variants, "compensated": changed})
    assert gain_of(result).steps == ()
    assert "gain of compensation is unknown" in gain_of(result).sentences()[0]


def test_caveat_states_the_limits_of_the_simulation(stage):
    def caveat(**changes):
        experiment = stage.looped.experiment
        variants = tuple(replace(variant, **changes) for variant in experiment.variants)
        return gain_of(
            replace(stage.looped, experiment=replace(experiment, variants=variants))
        ).caveat

    assert "upper limit" in caveat(
        friction=stage.looped.experiment.variants[-1].feedforward.friction
    )
    assert "includes the unexplained force" in caveat(disturbance=np.zeros(6000))
    assert caveat() == "This is a simulation: confirm the gain on the machine."


def test_pair_with_further_differences_is_not_credited_to_friction(stage):
    experiment = stage.looped.experiment
    two = replace(experiment, variants=(experiment.variants[0], experiment.variants[2]))
    gain = gain_of(replace(stage.looped, experiment=two))
    assert [gain.alone, gain_of(stage.looped).alone] == [False, True]
    assert "differ in more than friction feedforward" in gain.sentences()[0]


def test_present_velocity_feedforward_is_not_advised(stage):
    result = with_error(stage.looped, "compensated", lambda item: 2.5e-3 * velocity_of(item))
    assert gain_of(result).velocity_fed
    assert "viscous friction of the compensator, F_v" in " ".join(gain_of(result).sentences())


def test_viscous_friction_without_feedforward_is_named_as_cause(stage):
    """The loop has feedforward of velocity and Coulomb friction, so viscous friction remains."""
    film = friction.coulomb_viscous(F_C=8.0, F_v=200.0)
    law = controllers.cascade(k_p=80.0, k_v=3000.0)
    experiment = compensation_experiment(
        plants.inertia(M=12.0),
        film,
        friction.coulomb(F_C=8.0),
        law,
        stage.log.reference.values,
        1e-3,
    )
    gain = gain_of(simulate(experiment))
    assert gain.steps[-1].lag_share > 0.9
    assert "viscous friction without feedforward" in " ".join(gain.sentences())


def step(name, peak, beyond=1e-6, lag=2e-3, share=0.0):
    return Errors(name, peak, beyond, lag, share)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            8e-6,
            2e-6,
            "lowers the following error from 8 µm (plain) to 2 µm (fed) peak to peak, by a factor of 4.0.",
        ),
        (
            8e-6,
            7.5e-6,
            "lowers the following error from 8 µm (plain) to 7.5 µm (fed) peak to peak, by a factor of 1.1.",
        ),
        (
            8e-6,
            7.7e-6,
            "hardly changes the following error: 8 µm (plain) without it, 7.7 µm (fed) with it.",
        ),
        (
            8e-6,
            8.3e-6,
            "hardly changes the following error: 8 µm (plain) without it, 8.3 µm (fed) with it.",
        ),
        (
            8e-6,
            8.5e-6,
            "raises the following error from 8 µm (plain) to 8.5 µm (fed) peak to peak. Do not use this compensation.",
        ),
        (8e-6, 0.0, "lowers the following error from 8 µm (plain) to 0 m (fed) peak to peak."),
    ],
)
def test_gain_of_friction_feedforward_has_error_before_and_after(before, after, words):
    gain = Gain((step("plain", before), step("fed", after)), "translational", "Confirm.")
    assert gain.sentences() == [f"In simulation, friction feedforward {words}", "Confirm."]


def test_first_loop_is_compared_with_all_feedforward():
    steps = step("base", 20e-6), step("plain", 8e-6), step("fed", 2e-6)
    assert Gain(steps, "rotational", "Confirm.").sentences()[1] == (
        "With all feedforward, the following error goes from 20 µrad (base) to 2 µrad, by a factor of 10."
    )


@pytest.mark.parametrize(("share", "told"), [(0.49, False), (0.5, True), (0.625, True)])
def test_lag_is_reported_from_half_of_the_mean_square_on(share, told):
    steps = step("plain", 8e-6, 5e-6), step("fed", 2e-6, 1.234e-6, 2.5e-3, share)
    lines = Gain(steps, "translational", "Confirm.").sentences()
    begin = f"{100.0 * share:.3g} % of the mean square of the remaining error is proportional to velocity, like a lag of 2.5 ms."
    end = "Without this lag, compensation changes the error from 5.00 to 1.23 µm peak to peak."
    assert [
        re.fullmatch(f"{begin} Likely cause: .*{end}", line) is not None for line in lines[1:-1]
    ] == [True] * told


NOTHING = np.zeros(2)
FOLLOWED = Following(NOTHING, NOTHING, errors(9e-6, 3e-6), errors(8e-6, 2e-6), errors(4e-6, 1e-6))


def test_measured_error_is_followed_by_the_simulated_error():
    gain = Gain((), "translational", "")
    assert about_loop(None, None, "translational") == []
    assert about_loop(gain, None, "translational") == gain.sentences()
    first, *rest = about_loop(gain, FOLLOWED, "translational")
    assert first == (
        "In the log, the following error is 9 µm peak to peak and 3 µm root mean square. In simulation, it is 8 µm peak to peak and 2 µm "
        "root mean square."
    )
    assert rest == gain.sentences()
    alone = about_loop(None, replace(FOLLOWED, simulated=None), "rotational")
    assert alone == [
        "In the log, the following error is 9 µrad peak to peak and 3 µrad root mean square."
    ]


def test_no_gain_is_predicted_if_the_log_contradicts_the_loop():
    contradicted = replace(FOLLOWED, contradiction=Diagnostic("switching_law"))
    (line,) = about_loop(Gain((), "translational", ""), contradicted, "translational")
    assert line.startswith("bristle predicts no gain: the control law chatters around rest")


def variant(name, peak, spread=0.0, status=Status.OK):
    scatter = {"following_error": {"peak_to_peak": spread}} if spread else {}
    runs = 3 if spread else 1
    return Loop(name=name, following_error=errors(peak), spread=scatter, runs=runs, status=status)


@pytest.mark.parametrize(
    ("best", "other", "alike"),
    [
        (variant("a", 0.96e-6), variant("b", 1e-6), True),
        (variant("a", 0.94e-6), variant("b", 1e-6), False),
        (variant("a", 0.94e-6, 3e-8), variant("b", 1e-6, 4e-8), True),
        (variant("a", 0.94e-6, 3e-8), variant("b", 1e-6, 2e-8), False),
    ],
)
def test_variants_are_equal_within_five_percent_or_their_scatter(best, other, alike):
    assert is_alike(best, other) is alike


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["abcd"], "a, b, c, d"),
        (["abcdef"], "a, b, c, d and 2 more"),
        (["abc", 2], "a, b and 1 more"),
    ],
)
def test_long_lists_of_names_are_shortened(arguments, text):
    assert names_text(*arguments) == text


def test_error_is_split_into_lag_and_rest():
    time = 1e-3 * np.arange(4000)
    reference = np.sin(6.0 * time)
    velocity = np.gradient(reference, 1e-3)
    run = Some(settle=1.0, sample_time=1e-3)
    late = Loop(
        reference=reference,
        measured=reference - 2e-3 * velocity - 1e-4 * np.where(time < 1.0, 50.0, 1.0) * reference,
    )
    late.following_error = errors(1e-2, 0.0)
    parts = _errors(Some(name="a", run=run), late)
    assert (parts.name, parts.peak_to_peak) == ("a", 1e-2)
    assert (parts.lag, parts.beyond_lag) == (
        pytest.approx(2e-3, rel=0.01),
        pytest.approx(2e-4, rel=0.05),
    )
    assert 0.99 < parts.lag_share < 1.0
    # The reference of a motor that leads by the wind-up is not that of the load.
    leading = Loop(
        at_load=True,
        reference=reference,
        load_reference=0.9 * reference,
        measured=late.measured,
        position=0.9 * late.measured,
    )
    leading.true_error = errors(3e-3, 0.0)
    parts = _errors(Some(name="a", run=run), leading)
    assert (parts.peak_to_peak, parts.lag) == (3e-3, pytest.approx(1.8e-3, rel=0.01))
    still = Loop(reference=np.ones(4000), measured=np.ones(4000), following_error=errors(0.0, 0.0))
    assert _errors(Some(name="a", run=run), still)[3:] == (0.0, 0.0)


# --- The best variant and its gain, with differences within the scatter ignored


def message(*variants, refused=(), unstable=()):
    fed = SimpleNamespace(friction=None)
    shown = [SimpleNamespace(name=item.name, reference=None, feedforward=fed) for item in variants]
    experiment = SimpleNamespace(kind="translational", variants=shown)
    result = SimulationResult(
        experiment,
        {item.name: item for item in variants},
        dict.fromkeys(refused, "unstable"),
        unstable,
    )
    return " ".join(closing_sentences(result)).replace("\u00a0", " ")


WILD = Status.NOT_FINITE


@pytest.mark.parametrize(
    ("variants", "refused", "words"),
    [
        (
            [
                variant("base", 2e-6),
                variant("worse", 3e-6),
                variant("best", 5e-7),
                variant("good", 1e-6),
            ],
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
        (
            [variant("a", 5e-6), variant("b", 2e-6), variant("best", 1e-6)],
            [],
            "1 µm (best) instead of 5 µm (a) peak to peak, 80 % less.",
        ),
        (
            [variant("a", 20e-6), variant("b", 2e-6), variant("best", 1e-6)],
            [],
            "1 µm (best) instead of 20 µm (a) peak to peak, smaller by a factor of 20.",
        ),
        # A large gain is a factor, up to a hundred.
        *(
            (
                [variant("base", 2e-6), variant("best", best)],
                [],
                f"{text} (best) instead of 2 µm (base) peak to peak, {words}.",
            )
            for best, text, words in (
                (2.2e-7, "0.220 µm", "89 % less"),
                (1.9e-7, "0.190 µm", "smaller by a factor of 11"),
                (2e-8, "0.0200 µm", "smaller by a factor of 100"),
                (1.9e-8, "0.0190 µm", "smaller by more than a factor of 100"),
            )
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
    head = (
        "The best variant is best: following error "
        if "(best)" in words
        else "No variant is better than base: "
    )
    tail = "" if "(best)" in words else " peak to peak."
    assert message(*variants, refused=refused) == (words and head + words + tail)


@pytest.mark.parametrize(
    ("unstable", "best"), [((), "wild"), (("wild",), "base"), (("base", "wild"), "base")]
)
def test_an_unstable_loop_is_never_the_best(unstable, best):
    words = "The best variant is wild" if best == "wild" else "No variant is better than base"
    assert message(variant("base", 2e-6), variant("wild", 1e-6), unstable=unstable).startswith(
        words
    )


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
        variants={
            **stage.looped.variants,
            "finer": replace(stage.looped.variants["compensated"], name="finer"),
        },
    )
    wave = np.sin(40.0 * stage.looped.variants["feedforward"].time)
    for name, error in (("feedforward", 1e-5), ("compensated", 8e-6), ("finer", 2e-6)):
        result = with_error(result, name, lambda _, error=error: error * wave)
    assert [item.name for item in pair_in(result)] == ["feedforward", "finer"]
    assert re.search(
        r"\(feedforward\) to .*\(finer\) peak to peak, by a factor of 5.0",
        gain_of(result).sentences()[0],
    )
    wild = replace(result.variants["finer"], status=Status.NOT_FINITE)
    assert (
        pair_in(replace(result, variants={**result.variants, "finer": wild}))[1].name
        == "compensated"
    )


def test_gain_of_another_law_is_not_credited_to_feedforward(stage):
    experiment = stage.looped.experiment
    as_recorded, *rest = experiment.variants
    stiffer = replace(as_recorded, controller=as_recorded.controller.with_values(k_p=1.0))
    changed = replace(stage.looped, experiment=replace(experiment, variants=(stiffer, *rest)))
    told = [" ".join(gain_of(result).sentences()) for result in (stage.looped, changed)]
    assert ["With all feedforward" in words for words in told] == [True, False]


# --- The verdict on simulated loops and the title of their first page: which loop is better, and by what


def looped(stage, *sizes):
    """The loop of the stage with given following errors, peak to peak [m]."""
    result = stage.looped
    for name, size in zip(result.variants, sizes, strict=True):
        result = with_error(
            result, name, lambda item, size=size: 0.5 * size * np.sin(40.0 * item.time)
        )
    return result


@pytest.mark.parametrize(
    ("sizes", "level", "words", "change", "gain"),
    [
        ((20e-6, 9e-6, 4e-6), "usable", "Compensation helps", "9 → 4", ", ×2.2"),
        (
            (20e-6, 19.5e-6, 19.4e-6),
            "with_care",
            "Compensation hardly helps",
            "19.5 → 19.4",
            ": no improvement",
        ),
        ((4e-6, 9e-6, 20e-6), "no", "Compensation does not help", "9 → 20", ": no improvement"),
        ((20e-6, 4e-6, 9e-6), "usable", "Another loop helps", "4 → 9", ": no improvement"),
        ((20e-6, 4.05e-6, 4e-6), "usable", "Another loop helps", "4.05 → 4", ": no improvement"),
    ],
)
def test_verdict_of_a_run_follows_the_errors(stage, sizes, level, words, change, gain):
    result = looped(stage, *sizes)
    assert simulation_module.simulation_ruling(result)[:2] == (level, words)
    assert (
        simulation_module._front(result, ()).title.replace("\u00a0", " ")
        == f"Friction feedforward: {change} µm peak to peak{gain}"
    )


def test_variants_with_another_motion_are_not_compared_with_the_base(stage):
    result = looped(stage, 20e-6, 19.5e-6, 4e-6)
    *first, last = result.experiment.variants
    other = replace(last, reference=references.sine(amplitude=1e-3, frequency=1.0))
    moved = replace(result, experiment=replace(result.experiment, variants=(*first, other)))
    assert simulation_module.simulation_ruling(result).words == "Compensation helps"
    assert simulation_module.simulation_ruling(moved).level == "with_care"
