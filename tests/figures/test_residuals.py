"""Whether residuals are white."""

import numpy as np
import pytest

from bristle.figures.fit import autocorrelation


def test_white_noise_stays_within_its_band():
    rng = np.random.default_rng(0)
    correlation, count = autocorrelation(np.arange(4000.0), rng.normal(size=4000))
    outside = np.mean(np.abs(correlation[1:]) > 1.96 / np.sqrt(count))
    assert correlation[0] == 1.0
    assert outside <= 0.15


def test_a_first_order_process_decays_by_its_pole():
    noise = np.random.default_rng(1).normal(size=40_000)
    signal = np.empty(noise.size)
    last = 0.0
    for k, kick in enumerate(noise):
        last = 0.8 * last + kick
        signal[k] = last
    correlation, _ = autocorrelation(np.arange(signal.size, dtype=float), signal)
    assert correlation[1:6] == pytest.approx(0.8 ** np.arange(1, 6), abs=0.03)


def test_no_product_is_taken_across_a_gap():
    signal = np.random.default_rng(2).normal(size=500)
    signal -= signal.mean()
    t = np.arange(500.0)
    alone, _ = autocorrelation(t, signal)
    twice, count = autocorrelation(np.concatenate([t, 1000.0 + t]), np.concatenate([signal, -signal]))
    assert count == 1000
    assert twice == pytest.approx(alone, abs=1e-12)


def test_zero_residuals_have_no_autocorrelation():
    correlation, _ = autocorrelation(np.arange(100.0), np.zeros(100))
    assert np.all(correlation == 0.0)
