"""Innovations: each observation against least squares of those before it, as independent normal numbers."""

import numpy as np
import pytest
from scipy import stats

from bristle.fleet.innovations import CLIP, Innovations


def design(count, rng):
    return np.column_stack([np.ones(count), rng.standard_normal(count)])


def test_residuals_are_those_of_least_squares_on_what_came_before():
    rng = np.random.default_rng(1)
    x, r = design(12, rng), rng.uniform(1.0, 4.0, 12)
    y = x @ [3.0, -2.0] + np.sqrt(r) * rng.standard_normal(12)
    residuals = Innovations(x, r).residuals(y)
    for i in range(4, 12):
        weights = 1.0 / np.sqrt(r[:i])
        earlier = x[:i] * weights[:, None]
        coefficients = np.linalg.lstsq(earlier, y[:i] * weights, rcond=None)[0]
        spread = np.sqrt(r[i] + x[i] @ np.linalg.inv(earlier.T @ earlier) @ x[i])
        assert residuals[i] == pytest.approx((y[i] - x[i] @ coefficients) / spread, rel=1e-4)


def test_from_the_first_on_they_are_independent_normal_numbers():
    rng = np.random.default_rng(2)
    early, pairs = [], []
    for _ in range(1500):
        scores = Innovations(design(12, rng), np.ones(12)).scores(100.0 + 7.0 * rng.standard_normal(12))
        assert not scores[:4].any()
        early += scores[4:].tolist()
        pairs.append(scores[4] * scores[5])
    early = np.array(early)
    inside = early[np.abs(early) < CLIP]
    assert np.mean(np.abs(early) >= CLIP) == pytest.approx(2.0 * stats.norm.sf(CLIP), rel=0.15)
    assert stats.kstest(inside, stats.truncnorm(-CLIP, CLIP).cdf).pvalue > 0.01
    assert np.mean(pairs) == pytest.approx(0.0, abs=0.08)


def test_scale_and_place_of_the_values_make_no_difference():
    rng = np.random.default_rng(3)
    x, y = design(30, rng), rng.standard_normal(30)
    plain, moved = (Innovations(x, np.ones(30)).scores(values) for values in (y, 1e6 + 1e-3 * y + 5.0 * x[:, 1]))
    assert moved[5:] == pytest.approx(plain[5:], abs=1e-3)


def test_values_that_are_all_alike_say_nothing():
    assert not Innovations(np.ones((20, 1)), np.ones(20)).scores(np.full(20, 4.0)).any()
