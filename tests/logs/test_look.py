"""What rules measure of a log: work, ways, lines, the sign of an effort, a recorded velocity, the mass."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import log_of, sines

from bristle.core.axis import Axis
from bristle.logs.channel import Channel
from bristle.logs.check import RECORDED, checked, parted
from bristle.logs.look import DEFAULT, CheckThresholds, Look, likeness_of

MOTION = sines(8.0)
SIDE = np.sign(MOTION.velocity)
RNG = np.random.default_rng(1)


def effort_of(mass=12.0, level=8.0, viscous=30.0, noise=0.05, **more):
    return mass * MOTION.acceleration + level * SIDE + viscous * MOTION.velocity + noise * RNG.standard_normal(SIDE.size)


def look_at(effort=None, axis=None, motion=MOTION, settings=DEFAULT, velocity=None):
    log = log_of(motion, effort_of() if effort is None else effort, step=1e-6)
    log = log if velocity is None else replace(log, velocity=Channel(velocity, "m/s", "v"))
    return Look(log, axis or Axis(), settings, 1e-6, np.zeros(0, dtype=int))


def codes(effort=None, axis=None, velocity=None, **settings):
    look = look_at(effort, velocity=velocity)
    return {remark.code: remark.numbers for remark in checked(look.log, axis, CheckThresholds(**settings))}


def test_a_known_mass_that_contradicts_the_log_is_reported():
    assert look_at(axis=Axis(mass=12.0)).mass is None
    assert look_at(axis=Axis(mass=13.0)).mass is None
    mass, ratio = look_at(axis=Axis(mass=24.0)).mass
    assert (mass, ratio) == (pytest.approx(12.0, rel=0.02), pytest.approx(2.0, rel=0.02))
    assert look_at(axis=Axis(mass=6.0)).mass[1] == pytest.approx(0.5, rel=0.02)
    assert look_at(axis=Axis()).mass is None
    assert look_at(effort_of(mass=0.2), axis=Axis(mass=24.0)).mass is None  # friction takes nearly all
    result = codes(axis=Axis(mass=24.0))
    assert result["mass_contradicts"]["known"] == 24.0
    assert result["mass_contradicts"]["ratio"] == pytest.approx(2.0, rel=0.02)
    assert result["gear_suspect"]["gear"] == "2"


def test_changes_of_friction_are_measured_over_time_and_position():
    time = (MOTION.time - 4.0) / 4.0
    level, shares = look_at(effort_of() + 2.0 * time * SIDE).changes
    assert set(shares) == {-2}
    assert shares[-2] * level == pytest.approx(4.0, rel=0.1)  # from its first value to its last
    level, shares = look_at(effort_of() - 2.0 * SIDE * MOTION.position / np.max(np.abs(MOTION.position))).changes
    assert set(shares) == {-1}
    assert shares[-1] * level == pytest.approx(-4.0, rel=0.2)
    assert look_at().changes[1] == {}
    assert codes(effort_of() + 2.0 * time * SIDE)["level_drifts"]["percent"] == pytest.approx(100.0 * 4.0 / 8.5, rel=0.2)


def test_an_effort_without_its_sign_visits_zero_again_and_again():
    assert look_at(np.abs(effort_of(level=0.0, noise=0.0))).is_unsigned
    assert look_at(-np.abs(effort_of(level=0.0, noise=0.0))).is_unsigned
    assert not look_at().is_unsigned
    assert not look_at(np.abs(effort_of()) + 5.0).is_unsigned
    off = np.abs(effort_of(level=0.0, noise=0.0))
    off[:3000] = 0.0  # the drive was off
    assert not look_at(off).is_unsigned


def test_a_recorded_velocity_is_compared_in_scale_likeness_and_delay():
    assert look_at(velocity=MOTION.velocity).velocity is None
    scale, likeness, delay = look_at(velocity=1.2 * MOTION.velocity).velocity
    assert (scale, likeness) == (pytest.approx(1.2, rel=0.01), pytest.approx(1.0, abs=1e-3))
    assert delay == 0.0
    late = np.interp(MOTION.time - 0.01, MOTION.time, MOTION.velocity)
    assert look_at(velocity=late).velocity[2] == pytest.approx(0.01, rel=0.1)
    scale, likeness, _ = look_at(velocity=MOTION.position).velocity
    assert likeness < 0.5
    assert look_at(velocity=-MOTION.velocity).velocity[0] == pytest.approx(-1.0, rel=0.01)
    result = codes(velocity=60.0 * MOTION.velocity)
    assert result["velocity_contradicts"]["ratio"] == pytest.approx(60.0, rel=0.02)
    assert result["gear_suspect"]["gear"] == "60"


def test_a_saturating_channel_reads_its_largest_value_too_low():
    true = effort_of(noise=0.01)
    top = float(np.max(np.abs(true)))
    bent, hardly = (true - share * top * (true / top) ** 3 for share in (0.35, 0.1))
    assert look_at(true).bend is None
    assert look_at(hardly).bend is None  # clear, and less than a fifth
    assert look_at(bent).bend > 0.2


def test_a_drive_whose_command_no_longer_acts_reads_its_largest_too_large():
    acts = effort_of(noise=0.01)
    top = 1.15 * float(np.max(np.abs(acts)))
    share = look_at(top * np.arctanh(acts / top)).bend
    assert share < -0.2
    assert codes(top * np.arctanh(acts / top))["saturates"]["percent"] == pytest.approx(100.0 * share)
    assert look_at(effort_of(noise=5.0)).bend is None  # noise of the effort itself
    wave = 5.0 * np.sin(2.0 * np.pi * 2.7 * MOTION.time)
    assert look_at(top * np.arctanh(acts / top) + wave).bend is None  # most of what is left over is another force


@pytest.mark.parametrize("change", [0.1, -0.1])
def test_a_step_of_the_scale_has_its_time_and_is_no_drift_of_the_level(change):
    true = effort_of(noise=0.02)
    stepped = codes(np.where(MOTION.time > 5.0, 1.0 + change, 1.0) * true)
    assert stepped["scale_steps"]["time"] == pytest.approx(5.0, abs=0.5)
    assert stepped["scale_steps"]["percent"] == pytest.approx(100.0 * change, rel=0.25)
    assert "level_drifts" not in stepped
    warmer = codes(true + np.where(MOTION.time > 5.0, 2.0, 0.0) * SIDE)  # friction alone
    assert "scale_steps" not in warmer
    assert "level_drifts" in warmer
    assert "scale_steps" not in codes(true)
    loaded = effort_of(noise=0.02) + np.where(
        MOTION.time > 5.0, 0.6 * 12.0 * MOTION.acceleration + 0.1 * (8.0 * SIDE + 30.0 * MOTION.velocity), 0.0
    )
    assert "scale_steps" not in codes(loaded)  # a load: inertia and friction grow, but not alike


@pytest.mark.parametrize("cutoff", [0.1, 0.4])
def test_a_high_passed_effort_has_its_cutoff_and_is_not_reversed(cutoff):
    true, keep = effort_of(noise=0.02), np.exp(-2.0 * np.pi * cutoff * (MOTION.time[1] - MOTION.time[0]))
    passed = lfilter([0.5 * (1.0 + keep), -0.5 * (1.0 + keep)], [1.0, -keep], true)
    told = codes(passed)
    assert told["high_passed"]["cutoff"] == pytest.approx(cutoff, rel=0.35)
    assert "sign_reversed" not in told
    assert "high_passed" not in codes(true)
    assert "sign_reversed" in codes(-true)
    assert "high_passed" not in codes(-true)
    slow = np.exp(-2.0 * np.pi * 0.003 * (MOTION.time[1] - MOTION.time[0]))
    hardly = lfilter([0.5 * (1.0 + slow), -0.5 * (1.0 + slow)], [1.0, -slow], effort_of(noise=1e-3))
    assert "high_passed" not in codes(hardly)  # clear, and little beside friction


def test_a_reference_as_the_position_is_reported():
    log = log_of(MOTION, effort_of(), step=1e-6)
    copied, followed = (
        {remark.code for remark in checked(replace(log, reference=Channel(values, "m", "r")))}
        for values in (log.position.values + 1e-12, 0.999 * log.position.values)
    )
    assert "reference_recorded" in copied
    assert "reference_recorded" not in followed
    assert "reference_recorded" not in codes()
    still = replace(log, position=Channel(np.zeros(SIDE.size), "m", "q"), reference=Channel(np.zeros(SIDE.size), "m", "r"))
    assert "reference_recorded" not in {remark.code for remark in checked(still)}


def test_strokes_reach_from_reversal_to_reversal():
    look = look_at()
    (ways,) = look.ways
    assert np.sum(ways) == pytest.approx(MOTION.position[-1] - MOTION.position[0], abs=1e-5)
    assert np.all(ways[1:] * ways[:-1] < 0.0)
    assert look.way == pytest.approx(float(np.median(np.abs(ways[1:-1]))))
    straight = MOTION._replace(position=0.1 * MOTION.time)
    assert look_at(motion=straight).way == pytest.approx(np.ptp(straight.position), abs=1e-5)


def test_one_direction_and_one_speed_have_numbers():
    ahead = MOTION._replace(position=0.1 * MOTION.time)
    result = {remark.code: remark.numbers for remark in checked(log_of(ahead, 8.0 + 0.0 * ahead.time, step=1e-6))}
    assert result["one_direction"] == {"percent": 0.0, "direction": "forward"}
    back = {
        remark.code: remark.numbers for remark in checked(log_of(ahead._replace(position=-ahead.position), 0.0 * ahead.time, step=1e-6))
    }
    assert back["one_direction"]["direction"] == "backward"
    triangle = MOTION._replace(position=0.05 * np.abs(((MOTION.time / 0.8) % 2.0) - 1.0))
    result = {remark.code: remark.numbers for remark in checked(log_of(triangle, SIDE, step=1e-6))}
    assert result["one_speed"]["slowest"] == pytest.approx(0.0625, rel=0.02)
    assert result["motion_repeats"]["every"] == pytest.approx(1.6, rel=0.02)
    assert "one_speed" not in codes()


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
    assert [(part.start, part.stop) for part in log.segments] == [(0, 3000), (3000, 5197), (5197, 7994)]
    whole = log_of(MOTION, SIDE, step=1e-7)
    assert parted(whole) is whole


def test_likeness_is_that_of_two_directions():
    assert likeness_of(np.array([1.0, 0.0]), np.array([3.0, 0.0])) == 1.0
    assert likeness_of(np.array([1.0, 0.0]), np.array([1.0, 1.0])) == pytest.approx(0.5**0.5)
    assert likeness_of(np.zeros(2), np.ones(2)) == 0.0


@pytest.mark.parametrize("fall", [0.1, 0.02])
def test_a_line_bends_with_friction_that_falls_over_a_tenth_or_a_fiftieth_of_the_largest_speed(fall):
    drop = SIDE * np.exp(-np.abs(MOTION.velocity) / (fall * np.max(np.abs(MOTION.velocity))))
    assert 1.0 - look_at(effort_of(noise=0.0) + 20.0 * drop).plain.explained < 2.6e-4  # of the filter; with a fall over 0.2 it is 4e-4


@pytest.mark.parametrize("origin", [0.0, 0.3])
def test_an_effort_proportional_to_position_means_a_stuck_axis_for_any_zero(origin):
    moved = MOTION._replace(position=MOTION.position + origin)

    def sticking(effort):
        (result,) = [item.numbers for item in checked(look_at(effort + 1e3 * origin, motion=moved).log) if item.code == "never_slides"]
        return result

    stuck = sticking(1e4 * MOTION.position + 20.0 * SIDE)
    assert stuck["correlation"] == pytest.approx(np.corrcoef(1e4 * MOTION.position + 20.0 * SIDE, MOTION.position)[0, 1], abs=1e-3)
    assert stuck["reach"] == pytest.approx(0.5 * np.ptp(MOTION.position), rel=1e-3)
    assert 0.0 < stuck["percent"] < 30.0
    heavy = look_at(effort_of(level=0.5, viscous=0.0) + 1e3 * origin, motion=moved)
    assert "never_slides" not in {item.code for item in checked(heavy.log)}


@pytest.mark.parametrize(
    ("ratio", "gear"), [(2.1, "2"), (2.13, None), (0.48, "1/2"), (59.0, "60"), (3.2, "pi"), (1.1, None), (1000.0, "1000")]
)
def test_a_ratio_is_that_of_a_gear_within_six_hundredths(ratio, gear):
    assert codes(velocity=ratio * MOTION.velocity).get("gear_suspect", {}).get("gear") == gear
