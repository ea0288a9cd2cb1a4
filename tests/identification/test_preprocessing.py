from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt
from tests.identification.known_logs import STATED, TRUTH, Motion, log_of, sines, sliding_effort, sliding_log, strokes

from bristle.core import Axis, InputError
from bristle.identification import identify
from bristle.identification.dataset import Alignment
from bristle.identification.preprocessing import calmed, shifted, treat
from bristle.logs import Log
from bristle.logs.filters import low_passed

pytestmark = pytest.mark.usefixtures("of_one_mass")
MOTION = sines()


def test_derivatives_follow_a_known_motion():
    regression = treat(log_of(MOTION, sliding_effort(MOTION)), None)
    inner = regression.without_edges(np.arange(MOTION.time.size))
    velocity = regression.all_velocities
    acceleration = regression.without_edges(regression.segments[0].acceleration)
    # A central difference errs by (w dt)^2/6 relative, 6e-5 at 3.1 Hz, and twice that for the second derivative.
    assert np.max(np.abs(velocity - MOTION.velocity[inner])) < 1e-4 * np.max(np.abs(MOTION.velocity))
    assert np.max(np.abs(acceleration - MOTION.acceleration[inner])) < 3e-4 * np.max(np.abs(MOTION.acceleration))


def test_every_turning_point_is_a_reversal():
    regression = treat(log_of(MOTION, sliding_effort(MOTION)), None)
    side = np.sign(regression.without_edges(MOTION.velocity))
    assert len(regression.reversals[0]) == np.count_nonzero(np.diff(side))


@settings(max_examples=20, deadline=None)
@given(weight=st.floats(-5.0, 5.0), decimation=st.sampled_from([1, 4, 10]))
def test_rows_superpose_and_keep_a_constant(weight, decimation):
    motion = sines(duration=3.0)
    regression = treat(log_of(motion, sliding_effort(motion)), None, decimation=decimation)
    item, other = [motion.velocity], [np.sign(motion.velocity)]
    both = regression.rows_of([item[0] + weight * other[0]])
    assert np.allclose(both, regression.rows_of(item) + weight * regression.rows_of(other), atol=1e-12)
    assert np.allclose(regression.rows_of([np.full(motion.time.size, 7.0)]), 7.0, rtol=1e-12)


def trapezoids(duration: float = 10.0, dt: float = 1e-3) -> Motion:
    """Back and forth with a constant acceleration of 2 m/s^2 at the turns, whose steps a filter rounds."""
    t = dt * np.arange(round(duration / dt))
    v = np.clip(2.0 * (np.abs(t % 1.3 - 0.65) - 0.325), -0.2, 0.2)
    q = np.concatenate([[0.0], np.cumsum(0.5 * dt * (v[1:] + v[:-1]))])
    return Motion(t, q, v, np.gradient(v, dt))


@pytest.mark.parametrize("cutoff", [10.0, 20.0, 50.0, 100.0, 200.0])
def test_the_truth_does_not_depend_on_the_cutoff(cutoff):
    motion = trapezoids()
    fit = identify(log_of(motion, sliding_effort(motion, noise=0.1)), "coulomb_viscous", cutoff=cutoff, blocks=0, draws=0).best
    for name, rel in {"M": 2e-3, "F_C": 5e-3, "F_v": 8e-3, "offset": 1e-2}.items():
        assert fit.parameters[name].value == pytest.approx(TRUTH[name], rel=rel), name
    # Filtering the position alone leaves 8 % at 20 Hz and 13 % at 10 Hz, whatever the parameters are.
    assert fit.force_error_percent < 1.0


@pytest.mark.parametrize("noise", [0.0, 2e-7])
def test_rest_is_found_and_omitted(noise):
    motion = strokes()
    shaken = motion._replace(position=motion.position + np.random.default_rng(0).normal(0.0, noise, motion.time.size))
    regression = treat(log_of(shaken, sliding_effort(motion), step=0.0 if noise else 1e-6), None)
    truly = np.mean(np.abs(motion.velocity) < 1e-5)
    assert regression.rest_share == pytest.approx(truly, abs=0.06)
    # A stroke peaks at 100 mm/s; what is lost beside a rest is what the filter mixes with it.
    assert np.min(np.abs(regression.velocity)) < 4e-3
    assert regression.effort.size < (1.05 - truly) * motion.time.size / 10


def test_rest_keeps_the_side_of_the_last_motion():
    motion = strokes(repeats=2)
    velocity = treat(log_of(motion, sliding_effort(motion), step=1e-6), None).segments[0].velocity
    at_far_end = (motion.position > 0.05 - 1e-9) & (velocity == 0.0)
    at_near_end = (motion.position < 1e-9) & (velocity == 0.0) & (motion.time > 1.0)
    assert np.count_nonzero(at_far_end) > 1000
    assert np.count_nonzero(at_near_end) > 1000
    assert not np.any(np.signbit(velocity[at_far_end]))
    assert np.all(np.signbit(velocity[at_near_end]))


def test_axis_and_arguments_override_the_defaults():
    log = sliding_log()
    plain = treat(log, None)
    assert (plain.cutoff, plain.decimation, plain.dropped) == (pytest.approx(100.0), 10, 50)
    by_axis = treat(log, Axis(cutoff=50.0, decimation=5))
    assert (by_axis.cutoff, by_axis.decimation, by_axis.dropped) == (50.0, 5, 100)
    assert treat(log, Axis(cutoff=50.0), cutoff=80.0).cutoff == 80.0


def test_segments_are_treated_separately():
    gap = log_of(MOTION, sliding_effort(MOTION), segments=(slice(0, 4000), slice(4000, 10_000), slice(9990, 9995)))
    regression = treat(gap, None)
    assert [stretch.time.size for stretch in regression.segments] == [4000, 6000]
    assert regression.effort.size == regression.time.size == (4000 - 100) // 10 + (6000 - 100) // 10


def test_noise_of_the_position_is_measured():
    shaken = MOTION._replace(position=MOTION.position + np.random.default_rng(0).normal(0.0, 1e-6, MOTION.time.size))
    regression = treat(log_of(shaken, sliding_effort(MOTION)), None)
    assert regression.noise == pytest.approx(1e-6, rel=0.15)
    quiet = treat(log_of(MOTION, sliding_effort(MOTION)), None)
    excess = np.mean(regression.acceleration**2) - np.mean(quiet.acceleration**2)
    assert regression.acceleration_noise_share * np.mean(regression.acceleration**2) == pytest.approx(excess, rel=0.5)


def test_removal_of_a_position_filter_keeps_the_rests():
    motion, lag = strokes(repeats=3), 4e-3
    behind = motion.position + 0.7 - lag * motion.velocity + lag**2 * motion.acceleration
    late = treat(log_of(motion._replace(position=behind), sliding_effort(motion)), Axis(keeps_rests=True))
    (segment,), (before,) = shifted(late, 0.0, 0.0, lag).segments, late.segments
    # A filter of first order delays by its time constant, which stays: it is part of the delay.
    present = np.interp(motion.time - lag, motion.time, motion.position + 0.7)[300:-300]
    assert segment.recorded[300:-300] == pytest.approx(present, abs=2e-5)
    assert segment.position[300:-300] == pytest.approx(present, abs=2e-5)
    assert np.max(np.abs(before.recorded[300:-300] - present)) > 1.5 * np.max(np.abs(segment.recorded[300:-300] - present))
    resting = before.velocity == 0.0
    assert np.count_nonzero(resting) > 1000
    assert not np.any(segment.velocity[resting])
    assert np.array_equal(np.signbit(segment.velocity[resting]), np.signbit(before.velocity[resting]))


@pytest.mark.parametrize("cutoff", [50.0, 100.0, 200.0, 300.0])
def test_noise_of_the_effort_is_corrected_for_the_filter(cutoff):
    effort = sliding_effort(MOTION, noise=0.3, F_C=0.0)  # no corners, of which a filter takes something away as well
    assert treat(log_of(MOTION, effort), None, cutoff=cutoff).effort_noise == pytest.approx(0.3, rel=0.04)


@pytest.mark.parametrize(
    ("arguments", "path"),
    [
        ({"cutoff": 0.0}, "cutoff"),
        ({"cutoff": 500.0}, "cutoff"),
        ({"cutoff": float("nan")}, "cutoff"),
        ({"decimation": 400}, "log"),
        ({"cutoff": 0.5}, "log"),
    ],
)
def test_unusable_arguments_are_named(arguments, path):
    with pytest.raises(InputError) as caught:
        treat(sliding_log(), None, **arguments)
    assert caught.value.path == path
    assert caught.value.allowed


@pytest.mark.parametrize(
    ("position", "told"),
    [
        (
            np.where(MOTION.time == MOTION.time[4321], np.nan, MOTION.position),
            "position: contains values that are not finite.* at index 4321",
        ),
        (np.full(MOTION.time.size, 0.3), "the position hardly changes"),
    ],
)
def test_an_unusable_position_is_rejected(position, told):
    with pytest.raises(InputError, match=told):
        treat(log_of(MOTION._replace(position=position), sliding_effort(MOTION)), None)


@pytest.mark.parametrize(("cutoff", "decimation"), [(None, 1), (None, 10), (20.0, 4)])
def test_a_log_of_the_shortest_length_is_accepted_and_one_sample_less_is_not(cutoff, decimation):
    with pytest.raises(InputError, match="too short") as caught:
        treat(short(MOTION, 20), None, cutoff, decimation)
    least = int(caught.value.allowed.split()[-1])
    assert treat(short(MOTION, least), None, cutoff, decimation).time.size == 50
    with pytest.raises(InputError, match="too short"):
        treat(short(MOTION, least - 1), None, cutoff, decimation)


def short(motion, count):
    return log_of(type(motion)(*(item[:count] for item in motion)), np.ones(count))


@pytest.mark.parametrize("decimation", [1, 3, 10])
def test_a_sample_affects_rows_within_the_reach_of_the_filters(decimation):
    dataset = treat(log_of(MOTION, np.ones(MOTION.time.size)), None, 50.0, decimation)
    impulse = np.zeros(MOTION.time.size)
    impulse[5000] = 1.0
    shown = np.abs(dataset.rows_of([dataset.filtered(impulse)]))
    first, last = np.flatnonzero(shown > 1e-2 * np.max(shown))[[0, -1]]
    assert (last - first) / 2 <= dataset.reach <= 2 * (last - first) + 10


def test_a_motion_too_slow_to_distinguish_from_rest_is_fitted_whole_with_a_remark():
    time = 1e-3 * np.arange(40_000)
    phase = 2.0 * np.pi * 0.025 * time
    coarse, fine = (np.round(3e-6 * np.sin(phase), digits) for digits in (6, 7))
    log = Log(time=time, position=fine, effort=4e6 * fine + np.cos(phase), sample_time=1e-3)
    with pytest.raises(InputError, match="the position hardly changes"):
        treat(Log(time=time, position=coarse, effort=4e6 * fine, sample_time=1e-3), None)
    dataset = treat(log, None)
    assert dataset.time.size == dataset.in_motion.size == 3_990
    codes = {diagnostic.code for diagnostic in identify(log, "dahl", axis=STATED, draws=0, blocks=0).best.diagnostics}
    assert {"rests", "never_slides"} <= codes


@pytest.mark.parametrize("shape", [(16,), (400,), (3, 60), (2, 3, 40)])
def test_the_zero_phase_filter_is_that_of_scipy_to_the_bit(shape):
    signal = np.random.default_rng(4).normal(size=shape).cumsum(axis=-1)
    expected = sosfiltfilt(butter(4, 35.0, fs=1000.0, output="sos"), signal)
    assert np.array_equal(low_passed(signal, 35.0, 1e-3), expected)


def test_a_signal_shorter_than_the_filter_is_rejected():
    with pytest.raises(ValueError, match="padlen"):
        low_passed(np.zeros(15), 35.0, 1e-3)


LONG = sines(60.0, amplitudes=(0.02, 0.004, 0.0015), frequencies=(0.5, 3.1, 7.3), phases=(0.3, 1.1, 2.5))


@pytest.fixture(scope="module")
def long_rows():
    rows = treat(log_of(LONG, sliding_effort(LONG, noise=0.0)), STATED, 100.0, 10)
    return replace(rows, alignment=Alignment(mass=TRUTH["M"], slow=20.0), noise=1e-6)


def hiding(rows, share):
    """The same rows with so much noise of the position that inertia takes a share of friction by it."""
    return replace(rows, noise=rows.noise * share / calmed(rows)[1])


def test_noise_hides_as_much_friction_as_its_inertial_force(long_rows):
    # White noise, differentiated twice up to the 50 Hz of the rows, times the inertia.
    frequency = np.fft.rfftfreq(LONG.time.size, 1e-3)
    white = 1e-6 * np.sqrt(np.mean(np.where(frequency < 50.0, (2.0 * np.pi * frequency) ** 4, 0.0)))
    friction = np.std(TRUTH["F_C"] * np.sign(LONG.velocity) + TRUTH["F_v"] * LONG.velocity)
    rows, share = calmed(long_rows)
    assert share == pytest.approx(TRUTH["M"] * white / friction, rel=0.05)
    assert rows == 10


def test_rows_are_kept_if_noise_hides_less_than_three_tenths_of_friction(long_rows):
    assert calmed(hiding(long_rows, 0.29)) == (10, pytest.approx(0.29))
    rows, share = calmed(hiding(long_rows, 0.31))
    assert (rows > 10, share) == (True, pytest.approx(0.31))


@pytest.mark.parametrize("share", [0.4, 1.0, 2.0])
def test_rows_are_reduced_until_noise_hides_three_hundredths_of_friction(long_rows, share):
    noisy = hiding(long_rows, share)
    rows, _ = calmed(noisy)
    assert calmed(replace(noisy, decimation=rows))[1] == pytest.approx(0.03, rel=0.1)  # of whole samples


@pytest.mark.parametrize(("seconds", "expected"), [(60.0, 59), (25.0, 24), (9.0, 10)])
def test_at_least_a_thousand_rows_remain(seconds, expected):
    motion = type(LONG)(*(signal[: round(seconds / 1e-3)] for signal in LONG))
    rows = treat(log_of(motion, sliding_effort(motion, noise=0.0)), STATED, 100.0, 10)
    rows = hiding(replace(rows, alignment=Alignment(mass=TRUTH["M"], slow=20.0), noise=1e-6), 100.0)
    assert calmed(rows)[0] == expected


def test_an_unknown_inertia_hides_no_friction(long_rows):
    assert calmed(replace(long_rows, alignment=None)) == (10, 0.0)
    assert calmed(replace(long_rows, alignment=Alignment(slow=20.0))) == (10, 0.0)
