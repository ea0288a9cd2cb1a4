"""Filters without a delay: what they pass, what they stop, and what a lag makes of a signal."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from bristle.logs.filters import ahead, derivative, low_passed, through_filter

DT = 1e-3
TIME = DT * np.arange(2000)


def inner(signal, edge=200):
    """What lies far from both ends."""
    return signal[..., edge:-edge]


@pytest.mark.parametrize(("frequency", "gain"), [(1.0, 1.0), (40.0, 0.5), (400.0, 0.0)])
def test_a_sine_passes_below_the_cutoff_by_half_at_it_and_not_far_above(frequency, gain):
    sine = np.sin(2.0 * np.pi * frequency * TIME + 0.3)
    # Forward and backward: 3 dB twice.
    assert inner(low_passed(sine, 40.0, DT)) == pytest.approx(gain * inner(sine), abs=2e-4)


def test_a_constant_passes_unchanged_and_a_ramp_far_from_its_ends():
    assert low_passed(np.full(300, 4.0), 40.0, DT) == pytest.approx(4.0)
    ramp = 2.0 - 5.0 * TIME[:600]
    assert inner(low_passed(ramp, 40.0, DT)) == pytest.approx(inner(ramp), abs=1e-6)
    assert low_passed(ramp, 40.0, DT) == pytest.approx(ramp, abs=0.01)


def test_a_derivative_is_exact_for_a_polynomial_of_the_fourth_order():
    time = 0.1 * np.arange(12)
    signal = np.stack([time**4 - 2.0 * time**2 + time, 3.0 * time])
    expected = np.stack([4.0 * time**3 - 4.0 * time + 1.0, np.full(12, 3.0)])
    assert derivative(signal, 0.1)[..., 2:-2] == pytest.approx(expected[..., 2:-2])
    assert derivative(signal, 0.1)[1] == pytest.approx(3.0)
    assert derivative(signal, 0.2) == pytest.approx(0.5 * derivative(signal, 0.1))


@pytest.mark.parametrize("samples", [0.0, 0.4, 12.0, 12.7, -0.6, -31.2])
def test_between_its_samples_a_signal_is_smooth_and_beyond_its_ends_it_stays(samples):
    signal = np.stack(
        [
            np.sin(5.0 * TIME),
            2.0 * TIME,
            np.cumsum(np.random.default_rng(5).standard_normal(TIME.size)),
        ]
    )
    instants = TIME + samples * DT
    moved, expected = ahead(signal, samples), CubicSpline(TIME, signal, axis=-1)(instants)
    assert inner(moved, 80) == pytest.approx(inner(expected, 80), abs=1e-10)
    ends = np.clip(instants, *TIME[[0, -1]])[[0, -1]]
    assert moved[:2, [0, -1]] == pytest.approx(np.stack([np.sin(5.0 * ends), 2.0 * ends]), abs=0.01)


@pytest.mark.parametrize("frequency", [2.0, 20.0])
def test_a_lag_makes_a_sine_smaller_and_its_delay_is_taken_out(frequency):
    lag, w = 2e-3, 2.0 * np.pi * frequency
    sine = np.stack([np.sin(w * TIME), np.cos(w * TIME)])
    gain = 1.0 / np.hypot(1.0, w * lag)
    late = np.arctan(w * lag) - w * lag  # of a first order, less the time constant: what stays
    expected = gain * np.stack([np.sin(w * TIME - late), np.cos(w * TIME - late)])
    assert inner(through_filter(sine, lag, DT)) == pytest.approx(inner(expected), abs=2e-3)
    again = through_filter(through_filter(sine, lag, DT), -lag, DT)
    assert inner(again) == pytest.approx(inner(sine), abs=2e-3)


def test_a_constant_and_a_ramp_pass_a_lag_without_its_delay():
    for lag in (3e-3, -3e-3):
        assert through_filter(np.full(300, 4.0), lag, DT) == pytest.approx(4.0)
        assert inner(through_filter(5.0 * TIME[:600], lag, DT), 50) == pytest.approx(
            inner(5.0 * TIME[:600], 50), abs=1e-6
        )


@pytest.mark.parametrize("count", [2, 3, 4, 5, 9])
def test_the_derivative_of_a_short_signal_has_its_samples_and_the_slope_of_a_line(count):
    assert derivative(3.0 * np.arange(float(count)), 0.5) == pytest.approx(np.full(count, 6.0))
