"""Half-cycles of a log: rows, levels, noise, held-out blocks, and unfiltered motions."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort

from bristle.friction import coulomb, coulomb_viscous, lugre, with_slots
from bristle.identification.half_cycles import (
    SHORT,
    TIME,
    Groups,
    beside,
    between_samples,
    blocks_for,
    correlation_time,
    disturbance_of,
    force_with_scatter,
    independent_rows,
    least_way,
    neighbour_correlation,
    room_for_blocks,
    scaled,
    signs,
    time_blocks,
    within_cycles,
)
from bristle.identification.preprocessing import treat
from bristle.identification.settings import DEFAULT

RNG = np.random.default_rng(1)
MOTION = sines(4.0)


@pytest.fixture(scope="module")
def dataset():
    return treat(log_of(MOTION, sliding_effort(MOTION), step=1e-6), STATED, 100.0, 10)


def test_groups_are_counted_among_those_with_rows():
    groups = Groups(np.array([2, 2, 5, 5, 5, 9]))
    assert (groups.index.tolist(), groups.first.tolist(), groups.count) == ([0, 0, 1, 1, 1, 2], [0, 2, 5], 3)
    assert groups.summed(np.arange(6.0)).tolist() == [1.0, 9.0, 5.0]


def test_a_way_within_two_steps_or_eight_times_the_noise_is_rest():
    assert (least_way(1.0, 0.1), least_way(1.0, 0.5)) == (2.0, 4.0)


@pytest.mark.parametrize(
    ("rows", "correlation", "independent"),
    [
        pytest.param(RNG.standard_normal(20_000), 0.0, 20_000, id="white"),
        pytest.param(lfilter([1.0], [1.0, -0.5], RNG.standard_normal(20_000)), 0.5, 20_000 / 3.0, id="lasting"),
        pytest.param(np.tile([1.0, -1.0], 50), -1.0, 100.0, id="alternating"),  # no more than there are
        pytest.param(np.zeros(5), 0.0, 5.0, id="none"),
        pytest.param(np.ones(1000), 1.0, 1000 / 1999.0, id="constant"),  # a correlation counts as 0.999 at most
    ],
)
def test_correlated_rows_count_as_fewer(rows, correlation, independent):
    assert neighbour_correlation(rows) == pytest.approx(correlation, abs=0.03)
    assert independent_rows(rows) == pytest.approx(independent, rel=0.06)


def test_the_level_within_each_half_cycle_is_removed():
    groups, slope = Groups(np.array([0, 0, 1, 1])), np.array([1.0, 1.0, -1.0, -2.0])
    assert within_cycles(groups, slope, np.array([3.0, 5.0, 2.0, 4.0])) == pytest.approx([-1.0, 1.0, 0.0, 0.0])
    assert within_cycles(groups, 0.0 * slope, np.ones(4)) == pytest.approx(1.0)


def test_five_blocks_are_held_out_if_there_is_room(dataset):
    assert room_for_blocks(dataset, DEFAULT) == dataset.effort.size // (20 + 2 * dataset.reach)
    two = SimpleNamespace(log_of_row=np.array([0, 1]), effort=dataset.effort, reach=dataset.reach)
    asked = ((dataset, None, 20.0), (dataset, 3, 20.0), (dataset, None, 120.0), (dataset, None, 200.0), (two, None, 200.0))
    assert [blocks_for(rows, blocks, replace(DEFAULT, held_out_rows=least)) for rows, blocks, least in asked] == [5, 3, 2, 0, 5]


def rows_like(velocity, reach=2):
    return SimpleNamespace(effort=velocity, velocity=velocity, reach=reach)


def test_blocks_are_contiguous_unless_a_block_has_exclusive_speeds():
    even = np.where(np.arange(1000) % 20 < 10, 0.1, -0.1)
    of, parts = time_blocks(rows_like(even), 4)
    assert of == TIME
    assert [np.flatnonzero(part)[[0, -1]].tolist() for part in parts] == [[0, 249], [250, 499], [500, 749], [750, 999]]
    grown = np.where(np.arange(1000) < 750, 0.1, 10.0)
    of, parts = time_blocks(rows_like(grown), 4)
    assert of == SHORT
    assert np.sum(parts, axis=0).tolist() == [1] * 1000
    assert all(part[750:].any() for part in parts)
    # Each of two pieces of each part is four times the reach of the filters at either end.
    assert [time_blocks(rows_like(grown, reach=reach), 4)[0] for reach in (15, 16, 500)] == [SHORT, TIME, TIME]


def test_rows_next_to_a_part_share_no_sample_with_it():
    part = np.zeros(12, dtype=bool)
    part[5:7] = True
    assert np.flatnonzero(~beside(part, 2)).tolist() == [3, 4, 5, 6, 7, 8]
    assert np.flatnonzero(~beside(part, 0)).tolist() == [5, 6]


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
    assert [correlation_time(lasting, 0.01, size) for size in (1.0, 2.0, 0.0)] == pytest.approx([1.0, 0.25, 0.0])
    assert correlation_time(RNG.standard_normal(4000), 0.01, 1.0) < 0.05


def test_forces_are_scaled_and_offset_and_stiffness_are_not():
    component = with_slots(lugre, [])
    values = {"F_C": 4.0, "F_S": 5.0, "v_S": 1e-3, "sigma_0": 1e5, "offset": 2.0}
    assert scaled(component, values, 3.0) == {"F_C": 12.0, "F_S": 15.0, "v_S": 1e-3, "sigma_0": 1e5, "offset": 2.0}


def scattered(dataset, model, scatter):
    return force_with_scatter(model, dataset.segments[0], (0, *dataset.reversals[0]), 1e-3, scatter, np.random.default_rng(4))


def test_each_half_cycle_has_a_random_level(dataset):
    turns, velocity = np.array(dataset.reversals[0]), dataset.segments[0].velocity
    middle, levels = (turns[1:] + turns[:-1]) // 2, np.random.default_rng(4).standard_normal(turns.size + 1)[1:-1]
    plain, none, wild = (scattered(dataset, coulomb(F_C=8.0), scatter) for scatter in (0.1, 0.0, 50.0))
    assert plain[middle] == pytest.approx(8.0 * (1.0 + 0.1 * levels) * np.sign(velocity[middle]))
    assert np.abs(none[middle]) == pytest.approx(8.0)
    assert np.min(np.abs(wild[middle])) == pytest.approx(0.05 * 8.0)
    # Viscous friction does not scatter with the level.
    assert scattered(dataset, coulomb_viscous(F_C=8.0, F_v=30.0), 0.1) - plain == pytest.approx(30.0 * velocity, abs=1e-9)


def test_a_finer_grid_has_a_first_cycle_of_as_many_more_samples(dataset):
    assert between_samples(replace(dataset.segments[0], first_cycle=7), 1e-3).first_cycle == 35
