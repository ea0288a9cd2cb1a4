"""Segments of a log, and the rows of signals along them."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, strokes

from bristle.core import Axis
from bristle.friction import coulomb_viscous, with_slots
from bristle.identification.dataset import Alignment, Segment
from bristle.identification.preprocessing import aligned, differentiated, shifted, treat, treat_all
from bristle.plants import inertia

MOTION = sines(4.0)
DT = 1e-3
LINK = replace(STATED, gravity=True, kind="translational")


def dataset_of(motion=MOTION, effort=None, cutoff=100.0, decimation=10, axis=STATED, **passed):
    return treat(log_of(motion, sliding_effort(motion, noise=0.0) if effort is None else effort, **passed), axis, cutoff, decimation)


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
    assert dataset.reach == 2 + 10
    assert replace(dataset, decimation=1).reach == 20
    assert dataset.bandwidth == 50.0
    assert replace(dataset, decimation=4).bandwidth == 100.0


def test_distances_from_reversals_and_rests_count_samples(dataset):
    (turns,) = dataset.reversals
    truth = np.flatnonzero(np.diff(np.sign(MOTION.velocity))) + 1
    inside = truth[(truth > 50) & (truth < 3950)]
    assert np.abs(np.array(turns) - inside).max() <= 3
    sample = np.round(dataset.time / DT).astype(int)
    expected = np.min(np.abs(sample[:, None] - np.array(turns)), axis=1)
    assert dataset.samples_from_reversal.tolist() == expected.tolist()
    assert dataset.samples_from_rest.tolist() == expected.tolist()
    one_way = dataset_of(MOTION._replace(position=0.1 * MOTION.time, velocity=0.1 + 0.0 * MOTION.time))
    assert np.all(np.isinf(one_way.samples_from_reversal))


def test_rests_are_not_rows_unless_kept():
    motion = strokes(2)
    moving = dataset_of(motion)
    assert moving.rest_share == pytest.approx(0.44, abs=0.08)
    assert dataset_of(motion, axis=replace(STATED, keeps_rests=True)).time.size > 1.5 * moving.time.size
    assert np.all(np.abs(moving.velocity) > 0.0)
    assert np.max(moving.samples_from_rest) < np.max(moving.samples_from_reversal)


def test_noise_of_the_position_counts_by_the_fifth_power_of_the_bandwidth(dataset):
    noisy = replace(dataset, noise=1e-6)
    share = noisy.acceleration_noise_share
    # Of white noise, twice differentiated, what is below 50 Hz.
    square = np.trapezoid(2.0 * DT * 1e-12 * (2.0 * np.pi * np.linspace(0.0, 50.0, 1000)) ** 4, np.linspace(0.0, 50.0, 1000))
    assert share == pytest.approx(square / np.mean(dataset.acceleration**2), rel=0.03)
    assert replace(noisy, noise=2e-6).acceleration_noise_share == pytest.approx(4.0 * share)
    assert replace(noisy, noise=1e3).acceleration_noise_share == 1.0


def test_plant_and_friction_explain_the_effort_made_with_them(dataset):
    plant, friction = inertia(M=12.0), with_slots(coulomb_viscous, [])(F_C=8.0, F_v=30.0, offset=1.5)
    (explained,) = dataset.explained(plant, friction)
    np.testing.assert_allclose(explained[100:-100], dataset.segments[0].effort[100:-100], atol=0.6)
    assert dataset.contacts(friction, plant) == (None,)
    np.testing.assert_allclose(dataset.mechanical_rows(plant), 12.0 * dataset.acceleration, atol=1e-9)


def test_a_periodic_motion_runs_through_its_first_cycle():
    motion = sines(4.0, amplitudes=(0.02,), frequencies=(0.5,), phases=(0.3,))
    segment = dataset_of(motion, axis=replace(STATED, in_cycle=True)).segments[0]
    assert segment.first_cycle == pytest.approx(2000, abs=2)
    signals = segment.signals(DT)
    assert signals["v"].size == 4000 + segment.first_cycle
    assert signals["v"][segment.first_cycle :].tolist() == segment.velocity.tolist()
    np.testing.assert_allclose(signals["x"][segment.first_cycle :], segment.position + 0.5 * DT * segment.velocity, rtol=1e-12)


def test_logs_follow_each_other_in_time_and_noise_is_their_root_mean_square():
    logs = [log_of(MOTION, sliding_effort(MOTION, seed=seed, noise=noise), step=1e-6) for seed, noise in ((1, 0.3), (2, 0.9))]
    parts = [treat(log, STATED, 100.0, 10) for log in logs]
    both = treat_all(logs, [STATED, STATED], 100.0, 10)
    assert np.all(np.diff(both.time) > 0.0)
    assert both.segments[1].time[0] == pytest.approx(both.segments[0].time[-1] + DT)
    assert both.log_of_row.tolist() == [0] * parts[0].time.size + [1] * parts[1].time.size
    for name in ("effort_noise", "noise"):
        assert getattr(both, name) == pytest.approx(np.hypot(*(getattr(part, name) for part in parts)) / 2.0**0.5)


@pytest.mark.parametrize("delay", [0.004, -0.0035])
def test_a_lagging_effort_is_shifted_back(dataset, delay):
    late = np.interp(MOTION.time - delay, MOTION.time, MOTION.position)
    moved = shifted(dataset_of(effort=late), delay)
    np.testing.assert_allclose(moved.segments[0].effort[100:-100], dataset.segments[0].position[100:-100], atol=2e-6)
    assert moved.delay == delay
    assert shifted(dataset, 0.0) is dataset


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_filter_of_the_position_is_removed_from_all_derived_signals(dataset, way):
    (segment,) = aligned(dataset, Alignment(delay=0.0, smoothing=-way * 3e-3, of_position=True)).segments
    # A first-order filter without its delay hardly turns slow sines, and makes the fastest one smaller.
    change = np.std(segment.acceleration[200:-200]) / np.std(dataset.segments[0].acceleration[200:-200])
    assert change == pytest.approx((1.0 + (2.0 * np.pi * 3.1 * 3e-3) ** 2) ** (0.5 * way), rel=2e-3)
    np.testing.assert_allclose(segment.effort, dataset.segments[0].effort)


def test_a_derivative_of_fourth_order_is_that_of_a_fast_sine():
    fast = sines(1.0, dt=2e-3, amplitudes=(0.01,), frequencies=(10.0,), phases=(0.4,))
    coarse, truth = dataset_of(fast, cutoff=200.0, decimation=1), fast.acceleration[60:-60]
    accelerations = [item.segments[0].acceleration[60:-60] for item in (coarse, differentiated(coarse))]
    error = [np.max(np.abs(acceleration - truth)) / np.max(truth) for acceleration in accelerations]
    assert 4e-3 < error[0] < 8e-3
    assert error[1] < 5e-4


def test_data_of_an_alignment_contain_only_known_values():
    known = {"delay": 2e-3, "delay_half_width": 1e-4, "smoothing": -3e-3, "smoothing_half_width": 1e-3, "mass": 12.0, "slow": 5.0}
    assert Alignment(**known).as_data() == known
    assert (
        Alignment(**known, of_position=True).as_data().items()
        >= {"position_smoothing": 3e-3, "position_smoothing_half_width": 1e-3}.items()
    )
    assert Alignment().as_data() == {}


@pytest.mark.parametrize(
    ("motion", "axis", "stated", "expected"),
    [
        (MOTION, Axis(), (), (100.0, 10)),
        (MOTION, Axis(cutoff=60.0, decimation=5), (), (60.0, 5)),
        (MOTION, Axis(cutoff=60.0, decimation=5), (70.0, 4), (70.0, 4)),
        (MOTION, LINK, (100.0,), (100.0, 10)),
        (sines(2.0), LINK, (100.0,), (100.0, 5)),
    ],
)
def test_a_cutoff_is_a_tenth_of_the_sampling_frequency_and_short_logs_keep_rows_by_default(motion, axis, stated, expected):
    treated = treat(log_of(motion, sliding_effort(motion)), axis, *stated)
    assert (treated.cutoff, treated.decimation) == expected


def test_a_zero_order_hold_delays_the_effort_by_half_a_sample(dataset):
    ramp = np.arange(4000.0)
    plain, held = dataset_of(effort=ramp), dataset_of(effort=ramp, axis=replace(STATED, held=True))
    np.testing.assert_allclose((plain.segments[0].effort - held.segments[0].effort)[200:-200], 0.5, atol=1e-6)


def test_segments_too_short_for_the_filter_are_omitted():
    cut = dataset_of(segments=(slice(0, 300), slice(300, 2000), slice(2000, 4000)))
    assert [segment.time[0] for segment in cut.segments] == pytest.approx([0.3, 2.0])
    assert cut.segment_of_row.max() == 1
    assert isinstance(cut.segments[0], Segment)
