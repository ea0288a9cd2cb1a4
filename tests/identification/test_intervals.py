"""Intervals are valid for residuals correlated over time, as with any model error."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle.identification.estimate import Estimate

SETTLING = 2000  # samples after which the coloured noise has forgotten how it began


def coloured(seed: int, correlation_time: float, count: int, dt: float = 1e-3) -> np.ndarray:
    """Noise of first order with a standard deviation of 1."""
    pole = math.exp(-dt / correlation_time)
    white = np.random.default_rng(seed).normal(size=count + SETTLING)
    return lfilter([math.sqrt(1.0 - pole * pole)], [1.0, -pole], white)[SETTLING:]


@pytest.mark.parametrize("correlation_time", [pytest.param(time, marks=pytest.mark.slow) for time in (0.02, 0.05)])
def test_intervals_cover_the_truth_with_coloured_residuals(correlation_time):
    inside, inside_plain = [], []
    for seed in range(60):
        motion = sines(phases=tuple(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)))
        effort = sliding_effort(motion, noise=0.0) + 0.5 * coloured(seed, correlation_time, motion.time.size)
        parameters = identify(log_of(motion, effort), "coulomb_viscous", blocks=0, draws=0).best.parameters
        for name, truth in TRUTH.items():
            error = abs(parameters[name].value - truth)
            inside.append(100.0 * error < parameters[name].interval_percent * abs(parameters[name].value))
            inside_plain.append(error < 1.96 * parameters[name].std)
    # Of 240 intervals of 95 %, fewer than 90 % hold the truth once in a thousand times.
    assert 0.90 < np.mean(inside) < 0.99
    assert np.mean(inside_plain) < 0.75


@pytest.mark.parametrize(("std", "robust", "larger"), [(0.1, 0.3, 0.3), (0.2, 0.1, 0.2), (0.2, None, 0.2)])
def test_the_interval_uses_the_larger_error(std, robust, larger):
    estimate = Estimate("F_C", "N", "level", -4.0, std, robust_std=robust)
    assert estimate.relative_std_percent == pytest.approx(25.0 * std)
    assert estimate.interval_percent == pytest.approx(1.96 * 25.0 * larger)
