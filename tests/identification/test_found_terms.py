"""Forces beside friction are told from it before the models are fitted: in the plant, in a slot, or out of the effort."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, slow_log
from tests.identification.rigid import identify
from tests.identification.test_structure import LEVEL, WEIGHT, swinging, with_scatter

from bristle import explain
from bristle.core import Axis
from bristle.core.axis import KnownColumn
from bristle.identification import intervals
from bristle.identification.dataset import Alignment
from bristle.identification.dictionary import grid_of
from bristle.identification.explanation import Interval
from bristle.identification.found_terms import (
    Beside,
    Force,
    cogging_of,
    is_settled,
    is_wide,
    terms_of,
    with_explained,
    with_split,
)
from bristle.identification.intervals import Passed
from bristle.identification.settings import DEFAULT
from bristle.identification.work import Work
from bristle.identification.work_rate import motion_of
from bristle.logs import Channel
from bristle.models.friction import find
from bristle.report.messages import terms_in

WAVE = 0.01


@pytest.fixture(scope="module")
def motion():
    return sines(20.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))


def sliding(motion, force, axis=STATED, kind="translational", step=1e-7):
    log = log_of(motion, with_scatter(motion, force, share=0.0), step=step, kind=kind)
    return log, identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=0)


def lines_of(result):
    if result.second_pass is None:
        return {}
    return {line.key: line.value for line in result.second_pass.lines}


@pytest.mark.parametrize(
    ("lead", "turner", "harmonics"), [(None, "motor", (1, 2)), (0.03, "screw", (3, 6))]
)
def test_cogging_of_a_screw_has_the_orders_of_its_lead(motion, lead, turner, harmonics):
    phase = 2.0 * np.pi * motion.position / WAVE
    force = 0.1 * LEVEL * np.sin(phase + 1.0) + 0.05 * LEVEL * np.cos(2.0 * phase)
    _, result = sliding(motion, force, replace(STATED, pitch=lead))
    lines = lines_of(result)
    assert (lines["turner"], lines["harmonics"]) == (turner, harmonics)
    assert lines["travel"] == pytest.approx(lead or WAVE, rel=2e-3)
    assert result.best.parameters["F_C"].value == pytest.approx(LEVEL, rel=2e-3)


def test_a_ripple_of_friction_is_no_cogging(motion):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    force = 0.1 * LEVEL * np.sin(2.0 * np.pi * motion.position / WAVE) * side
    _, result = sliding(motion, force)
    assert lines_of(result) == {}
    assert re.search(r"friction ripple (9\.99|10) mm \(", terms_in(result.best))
    assert result.best.parameters["F_C"].value == pytest.approx(LEVEL, rel=2e-3)


@pytest.mark.parametrize(
    ("force", "key", "value"),
    [
        (lambda q: WEIGHT * np.sin(q - 0.4), "gravity", "link"),
        (lambda q: WEIGHT * q, "spring", "linear"),
        (lambda q: WEIGHT * (q + 0.3 * q**3), "spring", "cubic"),
    ],
)
def test_gravity_of_a_link_is_told_from_a_spring(force, key, value):
    motion = swinging()
    _, result = sliding(motion, force(motion.position), kind="rotational", step=1e-6)
    assert lines_of(result) == {key: value}


def level_along(motion):
    return 0.3 * LEVEL * motion.position / np.ptp(motion.position) * np.sign(motion.velocity)


def test_a_level_along_the_axis_is_out_of_the_effort_of_a_model_without_it(motion):
    log, result = sliding(motion, level_along(motion))
    assert "along the axis (" in terms_in(result.best)
    assert result.best.parameters["F_C"].value == pytest.approx(LEVEL, rel=5e-3)
    assert "F_C" not in result.best.effective
    # The log itself keeps its effort.
    assert result.log.effort.values is log.effort.values


def test_a_model_with_a_slot_keeps_the_level_in_its_effort(motion):
    log = log_with(motion, level_along(motion))
    model = "coulomb_viscous+position"
    best = identify(log, model, axis=STATED, blocks=0, draws=0).best
    assert terms_in(best) == ""
    # The slot changes viscous friction as well.
    assert best.parameters["p_1"].value == pytest.approx(0.15, rel=0.25)


def test_a_spring_of_the_axis_has_no_double_in_the_slot(motion):
    log = log_with(motion, level_along(motion))
    axis = replace(STATED, spring="cubic")
    best = identify(log, "coulomb_viscous+position", axis=axis, blocks=0, draws=0).best
    assert [best.parameters[name].status for name in ("a_1", "a_2")] == ["held", "held"]


def test_a_repeated_sine_tells_no_term_from_friction_and_inertia():
    motion = sines(30.0, amplitudes=(2e-3,), frequencies=(0.5,), phases=(0.0,))
    log = log_of(motion, with_scatter(motion, 0.0, share=0.0))
    assert terms_of([(log, STATED)]).explanation.terms == []


@pytest.mark.parametrize(
    ("frequencies", "axis", "expected"),
    [
        ([100.0, 250.0], Axis(), ("motor", 0.01, {100.0: 1})),
        ([100.0, 300.0], Axis(pitch=0.02), ("screw", 0.02, {100.0: 2, 300.0: 6})),
        ([130.0], Axis(pitch=0.01), ("motor", 0.0076923, {130.0: 1})),
        ([2.0 / np.pi], Axis(kind="rotational"), ("screw", 2.0 * np.pi, {2.0 / np.pi: 4})),
        ([], Axis(), ("screw", 0.0, {})),
    ],
)
def test_waves_belong_to_a_turn_by_their_whole_orders(frequencies, axis, expected):
    assert cogging_of(frequencies, axis) == expected


def log_with(motion, force, **channels):
    effort = with_scatter(motion, force, share=0.0)
    return replace(log_of(motion, effort, step=1e-7), **channels)


def test_friction_over_a_recorded_temperature_is_a_term_of_its_slot(motion):
    warmth = 293.15 + 10.0 * np.sin(0.4 * motion.time)
    force = 0.02 * (warmth - 293.15) * LEVEL * np.sign(motion.velocity)
    log = log_with(motion, force, temperature=Channel(warmth, "K", "temperature"))
    terms = terms_of([(log, STATED)])
    assert {name: force.slot for name, force in terms.forces.items()} == {
        "channel temperature": "temperature"
    }
    assert "with temperature" in terms.explanation.verdict
    assert terms.beside(find("coulomb_viscous")) == ("channel temperature",)
    assert terms.beside(find("coulomb_viscous+temperature")) == ()


def test_a_known_column_is_no_term(motion):
    pull = motion.position / np.ptp(motion.position)
    column = KnownColumn("pull", "pull")
    log = log_with(motion, LEVEL * pull, regressors=(Channel(pull, "1", "pull"),))
    explained = explain(log, replace(STATED, regressors=(column,)))
    assert explained.terms == []
    assert explained.M.value == pytest.approx(12.0, rel=5e-3)


def test_another_level_in_a_second_log_is_no_warm_up(motion):
    side = np.sign(motion.velocity)
    logs = [log_with(motion, level * side) for level in (0.0, 2.0)]
    names = [part.name for part in explain(logs, [STATED, STATED]).terms]
    assert "warmup" not in names


def test_a_stated_delay_is_kept(motion):
    explained = explain(log_with(motion, 0.0), STATED)
    assert not STATED.seeks_delay
    assert explained.delay.value == 0.0


def test_a_term_is_as_late_as_the_effort(motion):
    log = log_with(motion, level_along(motion))
    late = replace(log.effort, values=np.roll(log.effort.values, 20))
    axis = replace(STATED, seeks_delay=True)
    best = identify(replace(log, effort=late), "coulomb_viscous", axis=axis, blocks=0, draws=0).best
    assert "along the axis (" in terms_in(best)
    assert best.error_percent < 2.0


def test_the_error_of_a_cable_widens_the_interval_of_friction(motion):
    log, result = sliding(motion, 0.0)
    fit = result.best
    terms = replace(
        terms_of([(log, STATED)]),
        explanation=replace(result.explanation, F_C=Interval(8.0, 0.8)),
        forces={"cable": Force((np.zeros(len(log)),), "")},
    )
    beside = Beside(terms, [log], lambda logs: None)
    (before, after) = (entry.parameters for entry in (fit, with_split(fit, beside)))
    assert after["F_C"].interval_percent == pytest.approx(10.0, rel=0.01)
    assert after["M"].ends == before["M"].ends


def known(**changes):
    """The numbers of an explanation."""
    numbers = {"M": Interval(12.0, 0.1), "F_C": Interval(8.0, 0.1), "delay": Interval(1e-3, 1e-4)}
    return SimpleNamespace(**numbers | {"doubts": ()} | changes)


@pytest.mark.parametrize(
    ("changes", "settled"),
    [
        ({}, True),
        ({"F_C": None, "doubts": ("loaded",)}, True),
        ({"M": None}, False),
        ({"M": Interval(12.0, 3.0)}, False),
        ({"F_C": Interval(0.0, 1.0)}, False),
        # A term that may be there widens it, but hides no other term.
        ({"F_C": Interval(8.0, 9.0)}, True),
        ({"doubts": ("not_saturated",)}, False),
    ],
)
def test_terms_are_told_only_beside_inertia_and_friction(changes, settled):
    assert is_settled(known(**changes)) is settled


SEEN = Alignment(mass=11.0, mass_half_width=0.5, slow=50.0, sought=True)


@pytest.mark.parametrize(
    ("explanation", "alignment", "delay", "mass"),
    [
        (known(), SEEN, 1e-3, 12.0),
        (known(doubts=("loaded",)), SEEN, None, 11.0),
        (known(delay=Interval(1e-3, 1e-2)), SEEN, None, 12.0),
        (known(M=Interval(12.0, 0.6)), SEEN, 1e-3, 11.0),
        (known(), replace(SEEN, delay=2e-3), 2e-3, 12.0),
        (known(), replace(SEEN, sought=False), None, 12.0),
        (known(), replace(SEEN, too_small=0.1), 1e-3, 11.0),
    ],
)
def test_the_explanation_gives_what_the_first_stage_knows_less_well(
    explanation, alignment, delay, mass
):
    result = with_explained(alignment, explanation, 4e-3)
    assert (result.delay, result.mass) == (delay, mass)


@pytest.mark.parametrize(("place", "wide"), [(0, False), (-1, True)])
def test_memory_up_to_the_longest_threshold_is_no_place_for_a_cable(motion, place, wide):
    grid = grid_of(motion_of([(log_with(motion, 0.0), STATED)]))
    weights = np.zeros(grid.narrow.size)
    weights[place] = 8.0
    group = SimpleNamespace(columns=np.ones((3, weights.size)))
    search = SimpleNamespace(grid=grid)
    final = SimpleNamespace(
        choice=SimpleNamespace(search=search), named={"stop": group}, weights=lambda _: weights
    )
    assert is_wide(final) is wide


def test_memory_of_slow_friction_is_no_cable():
    law = find("lugre")(F_C=8.0, F_S=11.0, v_S=10.0, sigma_0=3e5, sigma_1=600.0, sigma_2=0.0)
    terms = terms_of([(slow_log(law), STATED)])
    assert [part.name for part in terms.explanation.terms] == ["cable"]
    assert terms.forces == {}


def test_checks_of_the_level_give_way_to_the_explanation(motion):
    log, result = sliding(motion, 1.5 * level_along(motion))
    whole = identify(
        log, "coulomb_viscous", axis=STATED, blocks=0, draws=0, settings={"lines_gain": 1.0}
    ).best
    assert "level_over_position" in {item.code for item in whole.diagnostics}
    assert "level_over_position" not in {item.code for item in result.best.diagnostics}


def test_an_observer_predicts_the_logs_without_the_terms(monkeypatch):
    seen = list[object]()
    fit = SimpleNamespace(name="a")
    estimation = SimpleNamespace(inverse=SimpleNamespace(parameters=SimpleNamespace(component="a")))
    beside = SimpleNamespace(logs_for=lambda component: [f"without for {component}"])
    context = SimpleNamespace(beside=beside, of=lambda _: "context", dataset=None)
    passed = Passed([fit], {"a": estimation}, {}, "", False, context, [("whole", None)], None)
    monkeypatch.setattr(intervals, "durations_of", lambda *_: (1.0, 1.0))
    monkeypatch.setattr(intervals, "with_uncertainty", lambda fit, *_: fit)
    monkeypatch.setattr(intervals, "is_observed", lambda *_: True)
    monkeypatch.setattr(intervals, "within_the_log", lambda fit, _: fit)
    monkeypatch.setattr(intervals, "with_loops", lambda fit, _: fit)
    monkeypatch.setattr(
        intervals, "foreseen", lambda fit, _, context, logs, __: seen.append((context, logs)) or fit
    )
    work = Work(lambda *_: None)
    assert intervals.with_intervals(passed, 20, DEFAULT, [], work)[1] == ""
    assert seen == [("context", ["without for a"])]
