"""Degrees of freedom of estimated squares, and the effect of an outlier."""

import numpy as np
import pytest

from bristle.identification.bootstrap import CERTAIN, ChiSquare

MEAN = 0.0025


def squares(freedom: int, count: int) -> np.ndarray:
    """Mean squares of so many normal numbers."""
    return MEAN * np.mean(np.random.default_rng(freedom).standard_normal((count, freedom)) ** 2, axis=1)


@pytest.mark.parametrize("freedom", [3, 10, 40])
def test_mean_and_freedom_are_recovered(freedom):
    result = ChiSquare.of(squares(freedom, 20_000))
    assert result.mean == pytest.approx(MEAN, rel=0.02)
    assert result.freedom == pytest.approx(freedom, rel=0.06)


@pytest.mark.parametrize("freedom", [10, 40])
def test_share_of_deviations_below_a_quantile_is_right(freedom):
    drawn = squares(freedom, 20_000)
    result = ChiSquare.of(drawn)
    for share in (0.025, 0.5, 0.975):
        below = np.mean(np.sqrt(drawn / MEAN) < result.deviation(share))
        assert below == pytest.approx(share, abs=0.008)


def test_an_outlier_in_a_hundred_changes_little():
    drawn = squares(40, 100)
    result = ChiSquare.of(drawn)
    drawn[7] *= 1e4
    astray = ChiSquare.of(drawn)
    assert astray.mean == pytest.approx(result.mean, rel=0.05)
    assert astray.freedom == pytest.approx(result.freedom, rel=0.25)
    # By moments there would be hardly one degree of freedom left.
    assert 2.0 * np.mean(drawn) ** 2 / np.var(drawn) < 0.1


def test_equal_estimates_have_no_uncertainty():
    assert ChiSquare.of(np.zeros(5)) == CERTAIN
    assert ChiSquare.of(np.full(5, MEAN)).deviation(0.975) == 1.0
