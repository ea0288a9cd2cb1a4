"""Scatter of the friction level in prediction errors: whitening by half-cycles, and their starts."""

import numpy as np
import pytest

from bristle.identification.level_scatter import LevelScatter, starts_of

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
    assert matrix @ covariance @ matrix.T == pytest.approx(noise**2 * np.eye(COLUMN.size), abs=1e-12)


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
