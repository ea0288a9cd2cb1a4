"""Segments of a log, the rows of signals along them, what hides in them, and periodic motions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    Motion,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    strokes,
)
from tests.identification.rigid import identify

from bristle.core import Axis, InputError
from bristle.engine import force_along
from bristle.identification.dataset import Alignment
from bristle.identification.preprocessing import (
    aligned,
    calmed,
    differentiated,
    shifted,
    treat,
    treat_all,
)
from bristle.logs import Log
from bristle.logs.filters import low_passed
from bristle.models.friction import coulomb_viscous, find, with_slots
from bristle.models.plants import inertia

MOTION = sines()


def test_derivatives_follow_a_known_motion():
    regression = treat(log_of(MOTION, sliding_effort(MOTION)), None)
    inner = regression.without_edges(np.arange(MOTION.time.size))
    velocity = regression.all_velocities
    acceleration = regression.without_edges(regression.segments[0].acceleration)
    # A central difference errs by (w dt)^2/6 relative, 6e-5 at 3.1 Hz, and twice that for the second derivative.
    assert np.max(np.abs(velocity - MOTION.velocity[inner])) < 1e-4 * np.max(
        np.abs(MOTION.velocity)
    )
    assert np.max(np.abs(acceleration - MOTION.acceleration[inner])) < 3e-4 * np.max(
        np.abs(MOTION.acceleration)
    )


@pytest.mark.parametrize("decimation", [1, 4, 10])
@pytest.mark.parametrize("weight", [-3.7, 0.2])
def test_rows_superpose_and_keep_a_constant(weight, decimation):
    motion = sines(duration=3.0)
    regression = treat(log_of(motion, sliding_effort(motion)), None, decimation=decimation)
    item, other = [motion.velocity], [np.sign(motion.velocity)]
    both = regression.rows_of([item[0] + weight * other[0]])
    assert np.allclose(
        both, regression.rows_of(item) + weight * regression.rows_of(other), atol=1e-12
    )
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
    fit = identify(
        log_of(motion, sliding_effort(motion, noise=0.1)),
        "coulomb_viscous",
        cutoff=cutoff,
        blocks=0,
        draws=0,
    ).best
    for name, rel in {"M": 2e-3, "F_C": 5e-3, "F_v": 8e-3, "offset": 1e-2}.items():
        assert fit.parameters[name].value == pytest.approx(TRUTH[name], rel=rel), name
    # Filtering the position alone leaves 8 % at 20 Hz and 13 % at 10 Hz, whatever the parameters are.
    assert fit.force_error_percent < 1.0


@pytest.mark.parametrize("noise", [0.0, 2e-7])
def test_rest_is_found_and_omitted(noise):
    motion = strokes()
    shaken = motion._replace(
        position=motion.position + np.random.default_rng(0).normal(0.0, noise, motion.time.size)
    )
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


def test_segments_are_treated_separately():
    gap = log_of(
        MOTION,
        sliding_effort(MOTION),
        segments=(slice(0, 300), slice(300, 4000), slice(4000, 10_000)),
    )
    regression = treat(gap, None)
    assert [stretch.time.size for stretch in regression.segments] == [3700, 6000]
    assert regression.effort.size == regression.time.size == (3700 - 100) // 10 + (6000 - 100) // 10
    assert regression.segment_of_row.max() == 1


def test_noise_of_the_position_is_measured():
    shaken = MOTION._replace(
        position=MOTION.position + np.random.default_rng(0).normal(0.0, 1e-6, MOTION.time.size)
    )
    regression = treat(log_of(shaken, sliding_effort(MOTION)), None)
    assert regression.noise == pytest.approx(1e-6, rel=0.15)
    quiet = treat(log_of(MOTION, sliding_effort(MOTION)), None)
    excess = np.mean(regression.acceleration**2) - np.mean(quiet.acceleration**2)
    assert regression.acceleration_noise_share * np.mean(
        regression.acceleration**2
    ) == pytest.approx(excess, rel=0.5)


def test_removal_of_a_position_filter_keeps_the_rests():
    motion, lag = strokes(repeats=3), 4e-3
    behind = motion.position + 0.7 - lag * motion.velocity + lag**2 * motion.acceleration
    late = treat(
        log_of(motion._replace(position=behind), sliding_effort(motion)), Axis(keeps_rests=True)
    )
    (segment,), (before,) = shifted(late, 0.0, 0.0, lag).segments, late.segments
    # A filter of first order delays by its time constant, which stays: it is part of the delay.
    present = np.interp(motion.time - lag, motion.time, motion.position + 0.7)[300:-300]
    assert segment.recorded[300:-300] == pytest.approx(present, abs=2e-5)
    assert segment.position[300:-300] == pytest.approx(present, abs=2e-5)
    assert np.max(np.abs(before.recorded[300:-300] - present)) > 1.5 * np.max(
        np.abs(segment.recorded[300:-300] - present)
    )
    resting = before.velocity == 0.0
    assert np.count_nonzero(resting) > 1000
    assert not np.any(segment.velocity[resting])
    assert np.array_equal(
        np.signbit(segment.velocity[resting]), np.signbit(before.velocity[resting])
    )


@pytest.mark.parametrize("cutoff", [50.0, 100.0, 200.0, 300.0])
def test_noise_of_the_effort_is_corrected_for_the_filter(cutoff):
    # No corners, of which a filter takes something away as well.
    effort = sliding_effort(MOTION, noise=0.3, F_C=0.0)
    assert treat(log_of(MOTION, effort), None, cutoff=cutoff).effort_noise == pytest.approx(
        0.3, rel=0.04
    )


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


@pytest.mark.slow
def test_a_motion_too_slow_to_distinguish_from_rest_is_fitted_whole_with_a_remark():
    time = 1e-3 * np.arange(40_000)
    phase = 2.0 * np.pi * 0.025 * time
    coarse, fine = (np.round(3e-6 * np.sin(phase), digits) for digits in (6, 7))
    log = Log(time=time, position=fine, effort=4e6 * fine + np.cos(phase), sample_time=1e-3)
    with pytest.raises(InputError, match="the position hardly changes"):
        treat(Log(time=time, position=coarse, effort=4e6 * fine, sample_time=1e-3), None)
    dataset = treat(log, None)
    assert dataset.time.size == dataset.in_motion.size == 3_990
    codes = {
        diagnostic.code
        for diagnostic in identify(log, "dahl", axis=STATED, draws=0, blocks=0).best.diagnostics
    }
    assert {"rests", "never_slides"} <= codes


@pytest.mark.parametrize("shape", [(16,), (400,), (3, 60), (2, 3, 40)])
def test_the_zero_phase_filter_is_that_of_scipy_to_the_bit(shape):
    signal = np.random.default_rng(4).normal(size=shape).cumsum(axis=-1)
    expected = sosfiltfilt(butter(4, 35.0, fs=1000.0, output="sos"), signal)
    assert np.array_equal(low_passed(signal, 35.0, 1e-3), expected)


def test_a_signal_shorter_than_the_filter_is_rejected():
    with pytest.raises(InputError, match="too short for the filter"):
        low_passed(np.zeros(15), 35.0, 1e-3)


LONG = sines(
    60.0, amplitudes=(0.02, 0.004, 0.0015), frequencies=(0.5, 3.1, 7.3), phases=(0.3, 1.1, 2.5)
)


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
    # Of whole samples
    assert calmed(replace(noisy, decimation=rows))[1] == pytest.approx(0.03, rel=0.1)


@pytest.mark.parametrize(("seconds", "expected"), [(60.0, 59), (25.0, 24), (9.0, 10)])
def test_at_least_a_thousand_rows_remain(seconds, expected):
    motion = type(LONG)(*(signal[: round(seconds / 1e-3)] for signal in LONG))
    rows = treat(log_of(motion, sliding_effort(motion, noise=0.0)), STATED, 100.0, 10)
    rows = hiding(replace(rows, alignment=Alignment(mass=TRUTH["M"], slow=20.0), noise=1e-6), 100.0)
    assert calmed(rows)[0] == expected


def test_an_unknown_inertia_hides_no_friction(long_rows):
    assert calmed(replace(long_rows, alignment=None)) == (10, 0.0)
    assert calmed(replace(long_rows, alignment=Alignment(slow=20.0))) == (10, 0.0)


SHORT = sines(4.0)
DT = 1e-3
LINK = replace(STATED, gravity=True, kind="translational")


def dataset_of(motion=SHORT, effort=None, cutoff=100.0, decimation=10, axis=STATED, **passed):
    return treat(
        log_of(motion, sliding_effort(motion, noise=0.0) if effort is None else effort, **passed),
        axis,
        cutoff,
        decimation,
    )


@pytest.fixture(scope="module")
def dataset():
    return dataset_of()


def test_rows_are_decimated_samples_without_the_edges(dataset):
    assert dataset.dropped == 50  # five periods of the cut-off
    assert np.allclose(np.diff(dataset.time), 0.01)
    assert dataset.sampled([np.arange(4000)]).tolist() == list(range(50, 3950, 10))
    assert dataset.effort.size == dataset.time.size == 390


def test_weights_of_samples_in_a_row_keep_a_constant(dataset):
    response = dataset.response
    assert response == pytest.approx(response[::-1], abs=1e-4)
    assert np.argmax(response) == response.size // 2
    assert dataset.rows_of([np.full(4000, 3.0)]) == pytest.approx(3.0)
    assert (dataset.reach, dataset.bandwidth) == (2 + 10, 50.0)
    assert (replace(dataset, decimation=1).reach, replace(dataset, decimation=4).bandwidth) == (
        20,
        100.0,
    )


def test_distances_from_reversals_and_rests_count_samples(dataset):
    (turns,) = dataset.reversals
    truth = np.flatnonzero(np.diff(np.sign(SHORT.velocity))) + 1
    inside = truth[(truth > 50) & (truth < 3950)]
    assert np.abs(np.array(turns) - inside).max() <= 3
    sample = np.round(dataset.time / DT).astype(int)
    expected = np.min(np.abs(sample[:, None] - np.array(turns)), axis=1)
    assert dataset.samples_from_reversal.tolist() == expected.tolist()
    assert dataset.samples_from_rest.tolist() == expected.tolist()
    one_way = dataset_of(SHORT._replace(position=0.1 * SHORT.time, velocity=0.1 + 0.0 * SHORT.time))
    assert np.all(np.isinf(one_way.samples_from_reversal))


def test_rests_are_not_rows_unless_kept():
    motion = strokes(2)
    moving = dataset_of(motion)
    assert moving.rest_share == pytest.approx(0.44, abs=0.08)
    kept = dataset_of(motion, axis=replace(STATED, keeps_rests=True))
    assert kept.time.size > 1.5 * moving.time.size
    assert kept.rest_share == moving.rest_share
    assert np.all(np.abs(moving.velocity) > 0.0)
    assert np.max(moving.samples_from_rest) < np.max(moving.samples_from_reversal)


def test_noise_of_the_position_counts_by_the_fifth_power_of_the_bandwidth(dataset):
    noisy = replace(dataset, noise=1e-6)
    share = noisy.acceleration_noise_share
    # Of white noise, twice differentiated, what is below 50 Hz.
    square = np.trapezoid(
        2.0 * DT * 1e-12 * (2.0 * np.pi * np.linspace(0.0, 50.0, 1000)) ** 4,
        np.linspace(0.0, 50.0, 1000),
    )
    assert share == pytest.approx(square / np.mean(dataset.acceleration**2), rel=0.03)
    assert replace(noisy, noise=2e-6).acceleration_noise_share == pytest.approx(4.0 * share)
    assert replace(noisy, noise=1e3).acceleration_noise_share == 1.0


def test_plant_and_friction_explain_the_effort_made_with_them(dataset):
    plant, friction = (
        inertia(M=12.0),
        with_slots(coulomb_viscous, [])(F_C=8.0, F_v=30.0, offset=1.5),
    )
    (explained,) = dataset.explained(plant, friction)
    np.testing.assert_allclose(explained[100:-100], dataset.segments[0].effort[100:-100], atol=0.6)
    assert dataset.contacts(friction, plant) == (None,)
    np.testing.assert_allclose(
        dataset.mechanical_rows(plant), 12.0 * dataset.acceleration, atol=1e-9
    )


def test_a_periodic_motion_runs_through_its_first_cycle():
    motion = sines(4.0, amplitudes=(0.02,), frequencies=(0.5,), phases=(0.3,))
    segment = dataset_of(motion, axis=replace(STATED, in_cycle=True)).segments[0]
    assert segment.first_cycle == pytest.approx(2000, abs=2)
    signals = segment.signals(DT)
    assert signals["v"].size == 4000 + segment.first_cycle
    assert signals["v"][segment.first_cycle :].tolist() == segment.velocity.tolist()
    np.testing.assert_allclose(
        signals["x"][segment.first_cycle :],
        segment.position + 0.5 * DT * segment.velocity,
        rtol=1e-12,
    )


def test_logs_follow_each_other_in_time_and_noise_is_their_root_mean_square():
    logs = [
        log_of(SHORT, sliding_effort(SHORT, seed=seed, noise=noise), step=1e-6)
        for seed, noise in ((1, 0.3), (2, 0.9))
    ]
    parts = [treat(log, STATED, 100.0, 10) for log in logs]
    both = treat_all(logs, [STATED, STATED], 100.0, 10)
    assert np.all(np.diff(both.time) > 0.0)
    assert both.segments[1].time[0] == pytest.approx(both.segments[0].time[-1] + DT)
    assert both.log_of_row.tolist() == [0] * parts[0].time.size + [1] * parts[1].time.size
    for name in ("effort_noise", "noise"):
        assert getattr(both, name) == pytest.approx(
            np.hypot(*(getattr(part, name) for part in parts)) / 2.0**0.5
        )


@pytest.mark.parametrize("delay", [0.004, -0.0035])
def test_a_lagging_effort_is_shifted_back(dataset, delay):
    late = np.interp(SHORT.time - delay, SHORT.time, SHORT.position)
    moved = shifted(dataset_of(effort=late), delay)
    np.testing.assert_allclose(
        moved.segments[0].effort[100:-100], dataset.segments[0].position[100:-100], atol=2e-6
    )
    assert moved.delay == delay
    assert shifted(dataset, 0.0) is dataset


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_filter_of_the_position_is_removed_from_all_derived_signals(dataset, way):
    (segment,) = aligned(
        dataset, Alignment(delay=0.0, smoothing=-way * 3e-3, of_position=True)
    ).segments
    # A first-order filter without its delay hardly turns slow sines, and makes the fastest one smaller.
    change = np.std(segment.acceleration[200:-200]) / np.std(
        dataset.segments[0].acceleration[200:-200]
    )
    assert change == pytest.approx((1.0 + (2.0 * np.pi * 3.1 * 3e-3) ** 2) ** (0.5 * way), rel=2e-3)
    np.testing.assert_allclose(segment.effort, dataset.segments[0].effort)


def test_a_derivative_of_fourth_order_is_that_of_a_fast_sine():
    fast = sines(1.0, dt=2e-3, amplitudes=(0.01,), frequencies=(10.0,), phases=(0.4,))
    coarse, truth = dataset_of(fast, cutoff=200.0, decimation=1), fast.acceleration[60:-60]
    accelerations = [
        item.segments[0].acceleration[60:-60] for item in (coarse, differentiated(coarse))
    ]
    error = [np.max(np.abs(acceleration - truth)) / np.max(truth) for acceleration in accelerations]
    assert 4e-3 < error[0] < 8e-3
    assert error[1] < 5e-4


def test_data_of_an_alignment_contain_only_known_values():
    known = {
        "delay": 2e-3,
        "delay_half_width": 1e-4,
        "smoothing": -3e-3,
        "smoothing_half_width": 1e-3,
        "mass": 12.0,
        "slow": 5.0,
    }
    assert Alignment(**known).as_data() == known
    assert (
        Alignment(**known, of_position=True).as_data().items()
        >= {"position_smoothing": 3e-3, "position_smoothing_half_width": 1e-3}.items()
    )
    assert Alignment().as_data() == {}


@pytest.mark.parametrize(
    ("motion", "axis", "stated", "expected"),
    [
        (SHORT, Axis(), (), (100.0, 10)),
        (SHORT, Axis(cutoff=60.0, decimation=5), (), (60.0, 5)),
        (SHORT, Axis(cutoff=60.0, decimation=5), (70.0, 4), (70.0, 4)),
        (SHORT, Axis(cutoff=50.0), (80.0,), (80.0, 10)),
        (SHORT, LINK, (100.0,), (100.0, 10)),
        (sines(2.0), LINK, (100.0,), (100.0, 5)),
    ],
)
def test_a_cutoff_is_a_tenth_of_the_sampling_frequency_and_short_logs_keep_rows_by_default(
    motion, axis, stated, expected
):
    treated = treat(log_of(motion, sliding_effort(motion)), axis, *stated)
    assert (treated.cutoff, treated.decimation) == expected
    assert treated.dropped == pytest.approx(5.0 / (treated.cutoff * DT), abs=1)


def test_a_zero_order_hold_delays_the_effort_by_half_a_sample(dataset):
    ramp = np.arange(4000.0)
    plain, held = dataset_of(effort=ramp), dataset_of(effort=ramp, axis=replace(STATED, held=True))
    np.testing.assert_allclose(
        (plain.segments[0].effort - held.segments[0].effort)[200:-200], 0.5, atol=1e-6
    )


SLIPPING = {"F_C": 20.0, "nu_i": [0.3, 0.4, 0.3], "k_i": [3e6, 8e6 / 6.0, 0.4e6]}


def one_amplitude(length=60e-6):
    motion = strokes(5, length=length, move=0.6, dwell=0.3)
    friction = force_along(find("maxwell_slip")(**SLIPPING), motion.velocity, 1e-3, motion.position)
    return log_of(motion, friction + np.random.default_rng(0).normal(0.0, 0.05, friction.size))


def test_a_log_that_starts_within_a_cycle_is_run_in():
    whole = one_amplitude()
    first = 1800 + 130  # early in the stroke there, of the second cycle
    part = {
        name: replace(getattr(whole, name), values=getattr(whole, name).values[first:])
        for name in ("time", "position", "effort")
    }
    cut = replace(whole, **part, segments=(slice(0, len(whole) - first),))
    errors = {}
    for in_cycle in (False, True):
        axis = Axis(
            seeks_delay=False,
            mass=1e-3,
            cutoff=200.0,
            decimation=2,
            in_cycle=in_cycle,
            keeps_rests=True,
        )
        errors[in_cycle] = identify(
            cut, "maxwell_slip", axis=axis, blocks=0, draws=0
        ).best.force_error_percent
    assert errors[True] < 1.5
    assert errors[False] > 3.0 * errors[True]
    away = sines(
        2.0, amplitudes=(0.02, 0.0, 0.0), frequencies=(0.05, 1.0, 1.0), phases=(0.0, 0.0, 0.0)
    )
    with pytest.raises(InputError, match="never returns to its first value"):
        treat(log_of(away, np.ones(2000)), Axis(in_cycle=True), decimation=1)
