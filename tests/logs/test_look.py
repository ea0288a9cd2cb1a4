"""What rules measure of a log: work, ways, lines, the sign of an effort, a recorded velocity, the mass."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import log_of, sines

from bristle.core.axis import Axis
from bristle.logs.channel import Channel
from bristle.logs.check import RECORDED, checked, checked_together, parted
from bristle.logs.look import DEFAULT, CheckThresholds, Look, likeness_of

MOTION = sines(8.0)
SIDE = np.sign(MOTION.velocity)
RNG = np.random.default_rng(1)


def effort_of(mass=12.0, level=8.0, viscous=30.0, noise=0.05, **more):
    return (
        mass * MOTION.acceleration
        + level * SIDE
        + viscous * MOTION.velocity
        + noise * RNG.standard_normal(SIDE.size)
    )


def look_at(effort=None, axis=None, motion=MOTION, settings=DEFAULT, velocity=None):
    log = log_of(motion, effort_of() if effort is None else effort, step=1e-6)
    log = log if velocity is None else replace(log, velocity=Channel(velocity, "m/s", "v"))
    return Look(log, axis or Axis(), settings, 1e-6, np.zeros(0, dtype=int))


def codes(effort=None, axis=None, velocity=None, **settings):
    look = look_at(effort, velocity=velocity)
    return {
        remark.code: remark.numbers
        for remark in checked(look.log, axis, CheckThresholds(**settings))
    }


@pytest.mark.parametrize(
    ("known", "effort", "found"),
    [
        (12.0, None, None),
        (13.0, None, None),
        (24.0, None, (pytest.approx(12.0, rel=0.02), pytest.approx(2.0, rel=0.02))),
        (6.0, None, (pytest.approx(12.0, rel=0.02), pytest.approx(0.5, rel=0.02))),
        (None, None, None),
        (24.0, effort_of(mass=0.2), None),  # friction takes nearly all
    ],
)
def test_a_known_mass_that_contradicts_the_log_is_reported(known, effort, found):
    assert look_at(effort, axis=Axis(mass=known)).mass == found


def test_a_contradicting_mass_is_named_with_the_gear_of_its_ratio():
    result = codes(axis=Axis(mass=24.0))
    assert (result["mass_contradicts"]["known"], result["mass_contradicts"]["ratio"]) == (
        24.0,
        pytest.approx(2.0, rel=0.02),
    )
    assert result["gear_suspect"]["gear"] == "2"


def test_changes_of_friction_are_measured_over_time_and_position():
    time = (MOTION.time - 4.0) / 4.0
    level, shares = look_at(effort_of() + 2.0 * time * SIDE).changes
    # From its first value to its last.
    assert {place: share * level for place, share in shares.items()} == {
        -2: pytest.approx(4.0, rel=0.1)
    }
    level, shares = look_at(
        effort_of() - 2.0 * SIDE * MOTION.position / np.max(np.abs(MOTION.position))
    ).changes
    assert {place: share * level for place, share in shares.items()} == {
        -1: pytest.approx(-4.0, rel=0.2)
    }
    assert look_at().changes[1] == {}
    warmer = codes(effort_of() + 3.0 * SIDE * MOTION.position / np.max(np.abs(MOTION.position)))
    assert warmer["level_over_position"]["percent"] > 0.0
    assert codes(effort_of() + 2.0 * time * SIDE)["level_drifts"]["percent"] == pytest.approx(
        100.0 * 4.0 / 8.5, rel=0.2
    )


SMOOTH = np.abs(effort_of(level=0.0, noise=0.0))


@pytest.mark.parametrize(
    ("effort", "is_unsigned"),
    [
        (SMOOTH, True),
        (-SMOOTH, True),
        (effort_of(), False),
        (np.abs(effort_of()) + 5.0, False),
        (np.where(np.arange(SMOOTH.size) < 3000, 0.0, SMOOTH), False),  # the drive was off
    ],
)
def test_an_effort_without_its_sign_visits_zero_again_and_again(effort, is_unsigned):
    assert look_at(effort).is_unsigned is is_unsigned
    assert ("effort_unsigned" in codes(effort)) is is_unsigned


V = MOTION.velocity


@pytest.mark.parametrize(
    ("velocity", "scale", "likeness", "delay"),
    [
        (1.2 * V, 1.2, 1.0, 0.0),
        (-V, -1.0, -1.0, 0.0),
        (np.interp(MOTION.time - 0.01, MOTION.time, V), 1.0, 1.0, 0.01),
    ],
)
def test_a_recorded_velocity_is_compared_in_scale_likeness_and_delay(
    velocity, scale, likeness, delay
):
    assert look_at(velocity=velocity).velocity == pytest.approx(
        (scale, likeness, delay), rel=0.1, abs=1e-3
    )
    assert look_at(velocity=V).velocity is None


def test_another_signal_is_unlike_the_velocity():
    assert look_at(velocity=MOTION.position).velocity[1] < 0.5


def test_a_velocity_of_another_unit_is_named_with_the_gear_of_its_ratio():
    result = codes(velocity=60.0 * V)
    assert (result["velocity_contradicts"]["ratio"], result["gear_suspect"]["gear"]) == (
        pytest.approx(60.0, rel=0.02),
        "60",
    )


TRUE = effort_of(noise=0.01)
TOP = float(np.max(np.abs(TRUE)))
COMMANDED = 1.15 * TOP * np.arctanh(TRUE / (1.15 * TOP))


@pytest.mark.parametrize(
    ("effort", "bend"),
    [
        (TRUE, None),
        (TRUE - 0.1 * TOP * (TRUE / TOP) ** 3, None),  # clear, and less than a fifth
        (TRUE - 0.35 * TOP * (TRUE / TOP) ** 3, 0.2),
        (COMMANDED, -0.2),  # the command of a drive no longer acts
        (effort_of(noise=5.0), None),  # noise of the effort itself
        # Most of what is left over is another force.
        (COMMANDED + 5.0 * np.sin(2.0 * np.pi * 2.7 * MOTION.time), None),
    ],
)
def test_a_saturating_channel_reads_its_largest_value_wrong_by_a_fifth(effort, bend):
    found = look_at(effort).bend
    assert found is None if bend is None else found / bend > 1.0
    assert codes(effort).get("saturates", {}).get("percent") == (
        found and pytest.approx(100.0 * found)
    )


STILL, LATER = effort_of(noise=0.02), MOTION.time > 5.0
GROWN = 0.6 * 12.0 * MOTION.acceleration + 0.1 * (8.0 * SIDE + 30.0 * MOTION.velocity)


@pytest.mark.parametrize("change", [0.1, -0.1])
def test_a_step_of_the_scale_has_its_time_and_is_no_drift_of_the_level(change):
    stepped = codes(np.where(LATER, 1.0 + change, 1.0) * STILL)
    numbers = stepped["scale_steps"]
    assert (numbers["time"], numbers["percent"]) == (
        pytest.approx(5.0, abs=0.5),
        pytest.approx(100.0 * change, rel=0.25),
    )
    assert "level_drifts" not in stepped


@pytest.mark.parametrize(
    ("effort", "drifts"),
    [
        (STILL, False),
        (STILL + np.where(LATER, 2.0, 0.0) * SIDE, True),  # friction alone
        # A load: inertia and friction grow, but not alike.
        (STILL + np.where(LATER, GROWN, 0.0), None),
    ],
)
def test_a_change_of_friction_or_of_a_load_is_no_step_of_the_scale(effort, drifts):
    result = codes(effort)
    assert "scale_steps" not in result
    assert drifts is None or ("level_drifts" in result) is drifts


def high_passed(effort, cutoff):
    keep = np.exp(-2.0 * np.pi * cutoff * (MOTION.time[1] - MOTION.time[0]))
    return lfilter([0.5 * (1.0 + keep), -0.5 * (1.0 + keep)], [1.0, -keep], effort)


@pytest.mark.parametrize(
    ("effort", "cutoff", "is_reversed"),
    [
        (high_passed(STILL, 0.1), 0.1, False),
        (high_passed(STILL, 0.4), 0.4, False),
        (STILL, None, False),
        (-STILL, None, True),
        # Clear, and little beside friction.
        (high_passed(effort_of(noise=1e-3), 0.003), None, False),
    ],
)
def test_a_high_passed_effort_has_its_cutoff_and_is_not_reversed(effort, cutoff, is_reversed):
    result = codes(effort)
    assert result.get("high_passed", {}).get("cutoff") == (
        cutoff and pytest.approx(cutoff, rel=0.35)
    )
    assert ("sign_reversed" in result) is is_reversed


LOG = log_of(MOTION, effort_of(), step=1e-6)
NO_MOTION = Channel(np.zeros(SIDE.size), "m", "q")


@pytest.mark.parametrize(
    ("log", "is_told"),
    [
        (replace(LOG, reference=Channel(LOG.position.values + 1e-12, "m", "r")), True),
        (replace(LOG, reference=Channel(0.999 * LOG.position.values, "m", "r")), False),
        (LOG, False),
        (replace(LOG, position=NO_MOTION, reference=NO_MOTION), False),
    ],
)
def test_a_reference_as_the_position_is_reported(log, is_told):
    assert ("reference_recorded" in {remark.code for remark in checked(log)}) is is_told


def test_strokes_reach_from_reversal_to_reversal():
    look = look_at()
    (ways,) = look.ways
    assert np.sum(ways) == pytest.approx(MOTION.position[-1] - MOTION.position[0], abs=1e-5)
    assert np.all(ways[1:] * ways[:-1] < 0.0)
    assert look.way == pytest.approx(float(np.median(np.abs(ways[1:-1]))))
    straight = MOTION._replace(position=0.1 * MOTION.time)
    assert look_at(motion=straight).way == pytest.approx(np.ptp(straight.position), abs=1e-5)


AHEAD = MOTION._replace(position=0.1 * MOTION.time)
TRIANGLE = MOTION._replace(position=0.05 * np.abs(((MOTION.time / 0.8) % 2.0) - 1.0))


@pytest.mark.parametrize(
    ("motion", "effort", "code", "numbers"),
    [
        (AHEAD, 8.0 + 0.0 * SIDE, "one_direction", {"percent": 0.0, "direction": "forward"}),
        (
            AHEAD._replace(position=-AHEAD.position),
            0.0 * SIDE,
            "one_direction",
            {"percent": 0.0, "direction": "backward"},
        ),
        (TRIANGLE, SIDE, "one_speed", {"slowest": pytest.approx(0.0625, rel=0.02)}),
        (TRIANGLE, SIDE, "motion_repeats", {"every": pytest.approx(1.6, rel=0.02)}),
        (MOTION, effort_of(), "one_speed", None),
        (MOTION, effort_of(), "one_direction", None),
    ],
)
def test_one_direction_and_one_speed_have_numbers(motion, effort, code, numbers):
    found = {
        remark.code: remark.numbers for remark in checked(log_of(motion, effort, step=1e-6))
    }.get(code)
    assert (found if found is None else {name: found[name] for name in numbers or found}) == numbers


REST = MOTION._replace(position=0.0 * MOTION.time)
SLOWER = TRIANGLE._replace(position=0.5 * TRIANGLE.position)


@pytest.mark.parametrize(
    ("motions", "lacking"),
    [
        ([AHEAD, AHEAD], {"one_direction", "one_speed"}),
        ([AHEAD, AHEAD._replace(position=-AHEAD.position)], {"one_speed"}),
        ([AHEAD, TRIANGLE], set()),
        ([TRIANGLE, SLOWER], {"motion_repeats"}),
        ([TRIANGLE, REST], {"one_speed", "motion_repeats"}),
        ([REST, REST], {"below_resolution"}),
    ],
)
def test_a_motion_that_one_log_lacks_may_be_in_another(motions, lacking):
    found = checked_together(
        [(log_of(motion, SIDE, step=1e-6), Axis(resolution=1e-6)) for motion in motions]
    )
    assert {"one_direction", "one_speed", "motion_repeats", "below_resolution"} & {
        finding.code for finding in found
    } == lacking


def test_thresholds_decide_on_findings():
    assert "mass_contradicts" not in codes(axis=Axis(mass=24.0), mass_ratio=2.5)
    assert "mass_contradicts" in codes(axis=Axis(mass=14.5))
    reversed_sign = codes(-effort_of())
    assert reversed_sign["sign_reversed"]["percent"] > 50.0
    assert "sign_reversed" in RECORDED


def test_a_log_is_parted_before_missing_rows():
    kept = np.delete(np.arange(8000), [3000, 3001, 3002, 5200, 5201, 5202])
    motion = type(MOTION)(*(signal[kept] for signal in MOTION))
    motion = motion._replace(time=1e-3 * np.arange(kept.size))
    log = parted(log_of(motion, np.sign(motion.velocity), step=1e-7))
    assert [(part.start, part.stop) for part in log.segments] == [
        (0, 3000),
        (3000, 5197),
        (5197, 7994),
    ]
    whole = log_of(MOTION, SIDE, step=1e-7)
    assert parted(whole) is whole


@pytest.mark.parametrize(
    ("one", "other", "likeness"),
    [
        ([1.0, 0.0], [3.0, 0.0], 1.0),
        ([1.0, 0.0], [1.0, 1.0], pytest.approx(0.5**0.5)),
        ([0.0, 0.0], [1.0, 1.0], 0.0),
    ],
)
def test_likeness_is_that_of_two_directions(one, other, likeness):
    assert likeness_of(np.array(one), np.array(other)) == likeness


@pytest.mark.parametrize("fall", [0.1, 0.02])
def test_a_line_bends_with_friction_that_falls_over_a_tenth_or_a_fiftieth_of_the_largest_speed(
    fall,
):
    drop = SIDE * np.exp(-np.abs(MOTION.velocity) / (fall * np.max(np.abs(MOTION.velocity))))
    # Of the filter; with a fall over 0.2 it is 4e-4
    assert 1.0 - look_at(effort_of(noise=0.0) + 20.0 * drop).plain.explained < 2.6e-4


@pytest.mark.parametrize("origin", [0.0, 0.3])
def test_an_effort_proportional_to_position_means_a_stuck_axis_for_any_zero(origin):
    moved = MOTION._replace(position=MOTION.position + origin)

    def sticking(effort):
        (result,) = [
            item.numbers
            for item in checked(look_at(effort + 1e3 * origin, motion=moved).log)
            if item.code == "never_slides"
        ]
        return result

    stuck = sticking(1e4 * MOTION.position + 20.0 * SIDE)
    assert stuck["correlation"] == pytest.approx(
        np.corrcoef(1e4 * MOTION.position + 20.0 * SIDE, MOTION.position)[0, 1], abs=1e-3
    )
    assert stuck["reach"] == pytest.approx(0.5 * np.ptp(MOTION.position), rel=1e-3)
    assert 0.0 < stuck["percent"] < 30.0
    heavy = look_at(effort_of(level=0.5, viscous=0.0) + 1e3 * origin, motion=moved)
    assert "never_slides" not in {item.code for item in checked(heavy.log)}


@pytest.mark.parametrize(
    ("ratio", "gear"),
    [
        (2.1, "2"),
        (2.13, None),
        (0.48, "1/2"),
        (59.0, "60"),
        (3.2, "pi"),
        (1.1, None),
        (1000.0, "1000"),
        (6.28, "2 pi"),
        (30.0 / np.pi, "30/pi"),
    ],
)
def test_a_ratio_is_that_of_a_gear_within_six_hundredths(ratio, gear):
    assert codes(velocity=ratio * MOTION.velocity).get("gear_suspect", {}).get("gear") == gear
