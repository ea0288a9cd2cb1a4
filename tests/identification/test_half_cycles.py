"""Half-cycles of a log: reversals, levels, noise, held-out blocks, and unfiltered motions."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import (
    STATED,
    Motion,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    strokes,
)
from tests.identification.rigid import identify

from bristle.core import Axis
from bristle.identification.half_cycles import (
    FINER,
    SHORT,
    TIME,
    Groups,
    beside,
    between_samples,
    blocks_for,
    correlation_time,
    disturbance_of,
    force_with_scatter,
    half_cycle_starts,
    half_cycles,
    independent_rows,
    least_way,
    neighbour_correlation,
    noise_density,
    recovered,
    room_for_blocks,
    scaled,
    scatter_in,
    signs,
    time_blocks,
    within_cycles,
)
from bristle.identification.level_scatter import LevelScatter, starts_of
from bristle.identification.preprocessing import treat
from bristle.identification.settings import DEFAULT
from bristle.models.friction import coulomb, coulomb_viscous, lugre, with_slots

RNG = np.random.default_rng(1)
MOTION = sines(4.0)


@pytest.fixture(scope="module")
def dataset():
    return treat(log_of(MOTION, sliding_effort(MOTION), step=1e-6), STATED, 100.0, 10)


def test_groups_are_counted_among_those_with_rows():
    groups = Groups(np.array([2, 2, 5, 5, 5, 9]))
    assert (groups.index.tolist(), groups.first.tolist(), groups.count) == (
        [0, 0, 1, 1, 1, 2],
        [0, 2, 5],
        3,
    )
    assert groups.summed(np.arange(6.0)).tolist() == [1.0, 9.0, 5.0]


def test_a_way_within_two_steps_or_eight_times_the_noise_is_rest():
    assert (least_way(1.0, 0.1), least_way(1.0, 0.5)) == (2.0, 4.0)


@pytest.mark.parametrize(
    ("rows", "correlation", "independent"),
    [
        pytest.param(RNG.standard_normal(20_000), 0.0, 20_000, id="white"),
        pytest.param(
            lfilter([1.0], [1.0, -0.5], RNG.standard_normal(20_000)),
            0.5,
            20_000 / 3.0,
            id="lasting",
        ),
        # No more than there are.
        pytest.param(np.tile([1.0, -1.0], 50), -1.0, 100.0, id="alternating"),
        pytest.param(np.zeros(5), 0.0, 5.0, id="none"),
        # A correlation counts as 0.999 at most.
        pytest.param(np.ones(1000), 1.0, 1000 / 1999.0, id="constant"),
    ],
)
def test_correlated_rows_count_as_fewer(rows, correlation, independent):
    assert neighbour_correlation(rows) == pytest.approx(correlation, abs=0.03)
    assert independent_rows(rows) == pytest.approx(independent, rel=0.06)


def test_the_level_within_each_half_cycle_is_removed():
    groups, slope = Groups(np.array([0, 0, 1, 1])), np.array([1.0, 1.0, -1.0, -2.0])
    assert within_cycles(groups, slope, np.array([3.0, 5.0, 2.0, 4.0])) == pytest.approx(
        [-1.0, 1.0, 0.0, 0.0]
    )
    assert within_cycles(groups, 0.0 * slope, np.ones(4)) == pytest.approx(1.0)


def test_five_blocks_are_held_out_if_there_is_room(dataset):
    assert room_for_blocks(dataset, DEFAULT) == dataset.effort.size // (20 + 2 * dataset.reach)
    two = rows_like(dataset.velocity, dataset.reach, np.arange(dataset.velocity.size) > 50)
    asked = (
        (dataset, None, 20.0),
        (dataset, 3, 20.0),
        (dataset, None, 120.0),
        (dataset, None, 200.0),
        (two, None, 200.0),
    )
    assert [
        blocks_for(rows, blocks, replace(DEFAULT, held_out_rows=least))
        for rows, blocks, least in asked
    ] == [5, 3, 2, 0, 2]


def rows_like(velocity, reach=2, log=None):
    return SimpleNamespace(
        effort=velocity,
        velocity=velocity,
        reach=reach,
        log_of_row=np.zeros(velocity.size) if log is None else log,
    )


def test_blocks_are_contiguous_unless_a_block_has_exclusive_speeds():
    even = np.where(np.arange(1000) % 20 < 10, 0.1, -0.1)
    of, parts = time_blocks(rows_like(even), 4)
    assert of == TIME
    assert [np.flatnonzero(part)[[0, -1]].tolist() for part in parts] == [
        [0, 249],
        [250, 499],
        [500, 749],
        [750, 999],
    ]
    grown = np.where(np.arange(1000) < 750, 0.1, 10.0)
    of, parts = time_blocks(rows_like(grown), 4)
    assert of == SHORT
    assert np.sum(parts, axis=0).tolist() == [1] * 1000
    assert all(part[750:].any() for part in parts)
    # Each of two pieces of each part is four times the reach of the filters at either end.
    assert [time_blocks(rows_like(grown, reach=reach), 4)[0] for reach in (15, 16, 500)] == [
        SHORT,
        TIME,
        TIME,
    ]


@pytest.mark.parametrize(
    ("sizes", "reach", "of", "rows"),
    [
        pytest.param((400, 560), 2, SHORT, [[80, 112]] * 5, id="a block of each log, in pieces"),
        pytest.param((400, 600), 25, TIME, [[80, 120]] * 5, id="a block of each log"),
        pytest.param(
            (100, 600),
            25,
            TIME,
            [[100, 120], [0, 120], [0, 120], [0, 120], [0, 120]],
            id="a short log is one block",
        ),
        pytest.param((60, 50, 70), 25, TIME, [[12, 10, 14]] * 5, id="short logs"),
    ],
)
def test_each_part_has_blocks_of_all_logs(sizes, reach, of, rows):
    log = np.repeat(np.arange(len(sizes)), sizes)
    alone = np.where(np.arange(log.size) < 80, 10.0, 0.1)  # a speed of the first part alone
    name, parts = time_blocks(rows_like(alone, reach, log), 5)
    assert (name, [np.bincount(log[part], minlength=len(sizes)).tolist() for part in parts]) == (
        of,
        rows,
    )


def test_rounding_is_not_jitter():
    facts = SimpleNamespace(noise=0.37e-6, resolution=1e-6, effort_noise=0.2)
    assert disturbance_of(facts, 0.1) == (0.1, 0.2, 1e-6, 0.0, 0.0)
    facts.noise = 1e-6
    assert disturbance_of(facts, 0.1).jitter == pytest.approx(np.sqrt(1.0 - 0.37**2) * 1e-6)


def test_signs_last_over_a_fortieth_of_a_segment():
    drawn = signs(4000, np.random.default_rng(2))
    assert set(drawn) == {-1.0, 1.0}
    assert np.all(np.diff(drawn).reshape(-1)[np.arange(3999) % 100 != 99] == 0.0)
    assert signs(7, np.random.default_rng(2)).size == 7


def test_an_unexplained_force_has_the_time_over_which_it_does_not_average_out():
    lasting = np.repeat(np.random.default_rng(3).choice([-1.0, 1.0], 40), 100)  # blocks of 100 rows
    assert [correlation_time(lasting, 0.01, size) for size in (1.0, 2.0, 0.0)] == pytest.approx(
        [1.0, 0.25, 0.0]
    )
    assert correlation_time(RNG.standard_normal(4000), 0.01, 1.0) < 0.05


def test_forces_are_scaled_and_offset_and_stiffness_are_not():
    component = with_slots(lugre, [])
    values = {"F_C": 4.0, "F_S": 5.0, "v_S": 1e-3, "sigma_0": 1e5, "offset": 2.0}
    assert scaled(component, values, 3.0) == {
        "F_C": 12.0,
        "F_S": 15.0,
        "v_S": 1e-3,
        "sigma_0": 1e5,
        "offset": 2.0,
    }


def scattered(dataset, model, scatter):
    return force_with_scatter(
        model,
        dataset.segments[0],
        (0, *dataset.reversals[0]),
        1e-3,
        scatter,
        np.random.default_rng(4),
    )


def test_each_half_cycle_has_a_random_level(dataset):
    turns, velocity = np.array(dataset.reversals[0]), dataset.segments[0].velocity
    middle, levels = (
        (turns[1:] + turns[:-1]) // 2,
        np.random.default_rng(4).standard_normal(turns.size + 1)[1:-1],
    )
    plain, none, wild = (
        scattered(dataset, coulomb(F_C=8.0), scatter) for scatter in (0.1, 0.0, 50.0)
    )
    assert plain[middle] == pytest.approx(8.0 * (1.0 + 0.1 * levels) * np.sign(velocity[middle]))
    assert np.abs(none[middle]) == pytest.approx(8.0)
    assert np.min(np.abs(wild[middle])) == pytest.approx(0.05 * 8.0)
    # Viscous friction does not scatter with the level.
    assert scattered(dataset, coulomb_viscous(F_C=8.0, F_v=30.0), 0.1) - plain == pytest.approx(
        30.0 * velocity, abs=1e-9
    )


def test_a_finer_grid_has_a_first_cycle_of_as_many_more_samples(dataset):
    assert between_samples(replace(dataset.segments[0], first_cycle=7), 1e-3).first_cycle == 35


DT = 1e-3


def treated(motion, step=0.0, noise=0.0):
    shaken = motion._replace(
        position=motion.position + noise * np.random.default_rng(2).normal(size=motion.time.size)
    )
    return treat(
        log_of(shaken, sliding_effort(motion), step=step), Axis(resolution=step or None), 50.0, 5
    )


@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.0), (1e-5, 0.0), (0.0, 2e-6)])
def test_each_reversal_of_a_sine_begins_a_half_cycle(step, noise):
    dataset = treated(sines(10.0, DT, (0.01,), (0.5,), (0.0,)), step, noise)
    (starts,) = half_cycle_starts(dataset)
    # Ten turns in ten seconds, the first half of a second before the first one.
    assert len(starts) == half_cycles(dataset).count == 11
    np.testing.assert_allclose(DT * np.array(starts[1:]), 0.5 + np.arange(10), atol=0.02)
    # No row belongs to a half-cycle with another one that goes the other way.
    for velocity in np.split(dataset.velocity, half_cycles(dataset).first[1:]):
        assert abs(np.sum(np.sign(velocity))) >= velocity.size - 2


def test_a_rest_in_noise_is_not_a_reversal():
    t = DT * np.arange(6000)
    present = np.clip(t - 1.0, 0.0, 1.0) - np.clip(t - 4.0, 0.0, 1.0)
    motion = Motion(t, 0.01 * present, np.gradient(0.01 * present, DT), np.zeros(t.size))
    assert len(half_cycle_starts(treated(motion, step=1e-6, noise=1e-6))[0]) == 2


def test_a_known_scatter_is_recovered_despite_one_long_stroke():
    t = DT * np.arange(12_000)
    # One long stroke, then many short ones.
    x = np.where(
        t < 4.0, 0.01 * (1.0 - t / 4.0), 0.01 * 0.02 * np.abs((t - 4.0) / 0.4 % 1.0 * 2.0 - 1.0)
    )
    dataset = treated(Motion(t, x, np.gradient(x, DT), np.zeros(t.size)))
    rng, slope, cycles = np.random.default_rng(8), np.sign(dataset.velocity), half_cycles(dataset)
    rows = np.bincount(cycles.index)
    assert rows.max() > 5.0 * np.median(rows)
    assert rows.size > 20
    noise = 0.01 * rng.standard_normal((400, slope.size))
    levels = 0.05 * rng.standard_normal((400, rows.size))
    seen = np.array(
        [
            scatter_in(cycles, slope, level[cycles.index] * slope + item)
            for level, item in zip(levels, noise, strict=True)
        ]
    )
    assert np.sqrt(np.mean(seen**2)) == pytest.approx(0.05, rel=0.03)
    assert np.std(seen) / np.mean(seen) == pytest.approx((2.0 * rows.size) ** -0.5, rel=0.15)


@pytest.mark.parametrize("scatter", [0.0, 0.1])
def test_a_motion_that_reverses_at_once_shows_no_level(scatter):
    # An axis that rings where it stops: after each stroke of 60 rows, three turns of 2 rows, wrong by their filter.
    rng, sizes = np.random.default_rng(1), np.tile([60, 2, 2, 2], 24)
    groups = Groups(np.repeat(np.arange(sizes.size), sizes))
    slope = np.where(groups.of_rows % 2, -9.0, 9.0)
    short = np.repeat(sizes == 2, sizes)
    level = np.where(sizes == 60, scatter * rng.standard_normal(sizes.size), 0.0)[groups.of_rows]
    residual = level * slope + 0.02 * rng.standard_normal(slope.size)
    wrong = residual + short * 8.0 * rng.standard_normal(slope.size)
    assert scatter_in(groups, slope, wrong) == pytest.approx(scatter, rel=0.3, abs=0.03)
    # Where all turn back as soon, they are all that there is.
    assert scatter_in(Groups(np.arange(slope.size) // 2), slope, wrong) > 0.15


def designed_log():
    """Slow motion first, fast motion at the end, as in a log of several experiments."""
    slow = sines(16.0, amplitudes=(2e-3, 1e-3), frequencies=(0.4, 1.1), phases=(0, 1))
    fast = sines(4.0, amplitudes=(0.05, 0.01), frequencies=(1.0, 3.0), phases=(0, 1))
    parts = [np.concatenate([a, b]) for a, b in zip(slow, fast, strict=True)]
    parts[1][slow.time.size :] += slow.position[-1] - fast.position[0]
    motion = type(slow)(1e-3 * np.arange(parts[0].size), *parts[1:])
    return log_of(motion, sliding_effort(motion))


@pytest.mark.parametrize(("log", "what"), [(sliding_log(), TIME), (designed_log(), SHORT)])
@pytest.mark.parametrize("count", [3, 5])
def test_each_row_is_in_one_part_and_all_parts_have_equal_length(log, what, count):
    regression = treat(log, None)
    of, parts = time_blocks(regression, count)
    assert of == what
    assert np.all(np.sum(parts, axis=0) == 1)
    assert max(map(np.sum, parts)) < 1.3 * min(map(np.sum, parts))
    pieces = [int(np.sum(np.diff(part.astype(int), prepend=0) == 1)) for part in parts]
    assert min(pieces) == max(pieces) == 1 if what == TIME else min(pieces) > 3


def test_other_parts_reach_the_speeds_of_each_short_part():
    regression = treat(designed_log(), None)
    speed = np.abs(regression.velocity)
    for part in time_blocks(regression, 5)[1]:
        assert np.max(speed[~part]) > 0.9 * np.max(speed[part])
    assert np.max(speed[:1500]) < 0.1 * np.max(speed[1700:]), (
        "in contiguous blocks it would be another matter"
    )


def test_rows_that_share_samples_with_a_part_are_not_fitted():
    part = np.zeros(12, dtype=bool)
    part[[4, 5, 11]] = True
    assert np.flatnonzero(beside(part, 2)).tolist() == [0, 1, 8]
    assert np.flatnonzero(beside(part, 0)).tolist() == [0, 1, 2, 3, 6, 7, 8, 9, 10]
    assert not beside(part, 20).any()


@pytest.mark.slow
def test_speeds_of_a_single_part_are_spread_over_all_parts():
    identification = identify(designed_log(), "coulomb_viscous,coulomb", draws=20)
    assert identification.best.name == "coulomb_viscous"
    assert identification.best.held_out.of == SHORT
    assert identification.best.held_out.mean_percent < 1.5 * identification.best.force_error_percent
    assert identification.best.resampling.bands.inflation < 1.5


NOISE = 2e-7


def rows_of(position, step=1e-9):
    velocity = np.gradient(position, DT)
    motion = Motion(DT * np.arange(position.size), position, velocity, np.gradient(velocity, DT))
    return treat(log_of(motion, velocity, step=step), STATED)


def noisy(position, seed=0):
    return position + np.random.default_rng(seed).normal(0.0, NOISE, position.size)


def triangle():
    """A motion that turns at once, every quarter of a second, and where it does."""
    time, turn = DT * np.arange(6000), 0.25
    beyond = np.abs(np.mod(time + 0.5 * turn, turn) - 0.5 * turn)
    return 0.01 * np.abs(np.mod(time / turn, 2.0) - 1.0), beyond


@pytest.fixture(scope="module")
def corners():
    position, beyond = triangle()
    rows = rows_of(noisy(position))
    (segment,) = rows.segments
    return position, beyond, segment, recovered(segment, rows)


def off(position, truth, where):
    return float(np.sqrt(np.mean((position - truth)[where] ** 2)))


def test_visible_corners_are_recovered(corners):
    truth, beyond, segment, motion = corners
    near = (beyond < 5e-3) & (segment.time > 0.1) & (segment.time < 5.9)
    assert off(segment.position, truth, near) > 20.0 * NOISE
    assert off(motion.segment.position, truth, near) < 0.5 * off(segment.position, truth, near)
    assert np.min(motion.visible[near]) == 1.0


def test_elsewhere_a_motion_is_as_smooth_as_filtered(corners):
    truth, beyond, segment, motion = corners
    far = (beyond > 0.06) & (segment.time > 0.2) & (segment.time < 5.8)
    assert np.max(motion.visible[far]) == 0.0
    assert off(motion.segment.position, truth, far) < 1.3 * off(segment.position, truth, far)
    assert np.std(np.diff(motion.segment.velocity)[far[1:]]) < 1.5 * np.std(
        np.diff(segment.velocity)[far[1:]]
    )


def test_the_velocity_is_that_of_the_position_and_zero_at_rest():
    rows = rows_of(noisy(strokes().position))
    segment = replace(
        rows.segments[0],
        velocity=np.where(strokes().velocity == 0.0, 0.0, rows.segments[0].velocity),
    )
    motion = recovered(segment, rows).segment
    moves = segment.velocity != 0.0
    assert 0.3 < np.mean(moves) < 0.7
    assert np.all(motion.velocity[~moves] == 0.0)
    inner = moves & (np.arange(moves.size) > 5) & (np.arange(moves.size) < moves.size - 5)
    assert (
        np.corrcoef(motion.velocity[inner], np.gradient(motion.position, DT)[inner])[0, 1] > 0.999
    )


def test_hidden_corners_are_as_sharp_as_in_the_filtered_motion():
    triangles, beyond = triangle()
    truth = 0.01 * triangles
    rows = rows_of(noisy(truth))
    (segment,) = rows.segments
    motion = recovered(segment, rows)
    hidden = (beyond < 1e-9) & (motion.visible < 0.1)
    hidden[:200] = hidden[-200:] = False
    outwards = np.sign(truth - np.mean(truth))
    taken, left = (
        np.mean((outwards * (truth - item.position))[hidden]) for item in (segment, motion.segment)
    )
    assert taken > 1e-7
    assert 0.75 * taken < left < 0.9 * taken


def test_noise_alone_is_not_a_corner():
    shown = []
    for seed in range(5):
        rows = rows_of(noisy(sines(6.0, DT).position, seed))
        shown.append(np.mean(recovered(rows.segments[0], rows).visible))
    assert np.mean(shown) < 0.02


def test_a_corner_of_a_few_times_the_noise_is_visible():
    # What the filter takes of one is 1.5 and 15 standard deviations of the noise.
    position, beyond = triangle()
    seen = []
    for size in (0.01, 0.1):
        rows = rows_of(noisy(size * position))
        seen.append(np.mean(recovered(rows.segments[0], rows).visible[beyond < 2e-3]))
    assert seen[0] < 0.3
    assert seen[1] > 0.9


@pytest.mark.parametrize("size", [2e-7, 5e-6])
def test_the_noise_of_an_encoder_is_separated_from_the_motion(size):
    position = sines(6.0, DT).position + np.random.default_rng(2).normal(0.0, size, 6000)
    assert noise_density(position, 0.0, DT) == pytest.approx(2.0 * DT * size**2, rel=0.15)


def test_noise_is_at_least_that_of_rounding():
    step = 1e-5
    rounding = np.random.default_rng(3).uniform(-0.5 * step, 0.5 * step, 6000)
    assert noise_density(rounding, 0.0, DT) == pytest.approx(
        noise_density(np.zeros(6000), step, DT), rel=0.15
    )


def test_a_motion_between_samples_is_interpolated():
    rows = rows_of(sines(6.0, DT).position)
    (segment,) = rows.segments
    fine = between_samples(segment, DT)
    exact = sines(6.0, DT / FINER)
    inner = slice(100 * FINER, 5900 * FINER)
    np.testing.assert_allclose(fine.time[inner], exact.time[inner], atol=1e-9)
    # Means over a step.
    np.testing.assert_allclose(fine.position[inner], exact.position[inner], atol=2e-8)
    np.testing.assert_allclose(fine.velocity[inner], exact.velocity[inner], atol=2e-4)
    np.testing.assert_array_equal(fine.effort[::FINER], segment.effort)


STARTS, COLUMN = np.array([0, 3, 8]), np.array([1.0, 2.0, 0.5, -1.0, -3.0, 2.0, 0.1, 1.0, 0.0, 0.0])


def whitening(scatter, noise):
    """The whitening of all rows as a matrix."""
    return LevelScatter.of(STARTS, COLUMN, scatter, noise).whitened(np.eye(COLUMN.size))


@pytest.mark.parametrize(("scatter", "noise"), [(0.03, 0.1), (0.3, 0.01), (2.0, 1.0)])
def test_whitening_of_a_scattering_level_gives_white_errors(scatter, noise):
    half_cycle = np.searchsorted(STARTS, np.arange(COLUMN.size), side="right")
    together = half_cycle[:, None] == half_cycle
    covariance = noise**2 * np.eye(COLUMN.size) + scatter**2 * np.outer(COLUMN, COLUMN) * together
    matrix = whitening(scatter, noise)
    assert matrix @ covariance @ matrix.T == pytest.approx(
        noise**2 * np.eye(COLUMN.size), abs=1e-12
    )


def test_a_half_cycle_without_information_on_the_level_is_unchanged():
    matrix = whitening(0.5, 0.1)
    assert np.array_equal(matrix[8:], np.eye(COLUMN.size)[8:])
    assert np.array_equal(whitening(0.0, 0.1), np.eye(COLUMN.size))


def test_half_cycles_begin_where_the_motion_turns():
    dt, settled = 1e-3, 300
    t = dt * np.arange(4000)
    triangle = 1e-3 * np.abs((t + 0.25) % 1.0 - 0.5)  # turns at 0.25 s, 0.75 s, ...
    starts = starts_of([triangle, triangle[:2000]], settled, dt)
    assert np.isin([0, t.size - settled], starts).all()
    expected = np.array([0.75, 1.25, 1.75, 2.25, 2.75, 3.25, 3.75]) / dt - settled
    inner = starts[(starts > 50) & (starts < t.size - settled - 50)]
    assert inner == pytest.approx(expected, abs=5)
