"""Filters whose delay is none, or taken out, and the derivative that goes with them; signals of shape (..., sample)."""

import math
from functools import cache

import numpy as np


def low_passed(signal: np.ndarray, cutoff: float, sample_time: float) -> np.ndarray:
    """Return signals, shape (..., sample), behind the zero-phase Butterworth filter of fourth order, cut-off in Hz."""
    from scipy.signal import sosfilt, sosfiltfilt

    sections, settled, edge, _ = butterworth(cutoff, sample_time)
    if signal.shape[-1] <= edge:
        return sosfiltfilt(sections, signal)  # which says what is too short
    # To the bit what that returns, without solving for the settled state of the same filter at each call.
    settled = settled.reshape(len(sections), *[1] * (signal.ndim - 1), 2)
    before = 2.0 * signal[..., :1] - signal[..., edge:0:-1]
    after = 2.0 * signal[..., -1:] - signal[..., -2 : -(edge + 2) : -1]
    passed = np.concatenate((before, signal, after), axis=-1)
    for _ in range(2):  # forward, and backward
        passed = np.asarray(sosfilt(sections, passed, zi=settled * passed[..., :1])[0])[..., ::-1]
    return passed[..., edge:-edge]


@cache
def butterworth(cutoff: float, sample_time: float) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Return sections, settled state, and by how many samples a signal is extended and a start dies out to rounding."""
    from scipy.signal import butter, sosfilt_zi

    sections = np.asarray(butter(4, cutoff, fs=1.0 / sample_time, output="sos"))
    taps = 2 * len(sections) + 1 - min((sections[:, 2] == 0.0).sum(), (sections[:, 5] == 0.0).sum())
    slowest = max(np.abs(np.roots(section[3:])).max() for section in sections)
    return sections, sosfilt_zi(sections), 3 * int(taps), math.ceil(math.log(np.finfo(float).eps) / math.log(slowest))


def derivative(signal: np.ndarray, dt: float) -> np.ndarray:
    """Return the derivative of a signal, shape (..., sample), true to the fourth order of the step.

    Of the second order, as `numpy.gradient` is, the acceleration of 10 Hz at 500 samples a second is 0.5 % small.
    """
    if signal.shape[-1] < 5:
        return np.asarray(np.gradient(signal, dt, axis=-1))
    near, far = signal[..., 3:-1] - signal[..., 1:-3], signal[..., 4:] - signal[..., :-4]
    first, last = (np.gradient(part, dt, axis=-1) for part in (signal[..., :3], signal[..., -3:]))
    return np.concatenate([first[..., :2], (8.0 * near - far) / (12.0 * dt), last[..., 1:]], axis=-1)


def through_filter(signal: np.ndarray, lag: float, dt: float) -> np.ndarray:
    """Return a signal, shape (..., sample), behind, or before if negative, a filter of this time constant [s], not delayed."""
    from scipy.signal import lfilter

    if lag < 0.0:
        return ahead(signal - lag * derivative(signal, dt), lag / dt)
    gain = dt / (2.0 * lag + dt)
    behind, _ = lfilter([gain, gain], [1.0, (dt - 2.0 * lag) / (dt + 2.0 * lag)], signal, zi=(1.0 - gain) * signal[..., :1])
    return ahead(np.asarray(behind), lag / dt)


def ahead(signal: np.ndarray, samples: float) -> np.ndarray:
    """Return a signal, shape (..., sample), so many samples earlier, as a cubic spline tells it; beyond its ends it stays."""
    from scipy.ndimage import spline_filter1d

    return at_spline(spline_filter1d(signal), samples)


def at_spline(coefficients: np.ndarray, samples: float) -> np.ndarray:
    """Return the signal of the coefficients of a spline, shape (..., sample), so many samples earlier."""
    from scipy.ndimage import correlate1d

    whole, part = math.floor(samples), samples - math.floor(samples)
    # B-splines of third order, at four samples around an instant.
    weights = [0.0, (1.0 - part) ** 3, 4.0 + 3.0 * part**2 * (part - 2.0), 1.0 + 3.0 * part * (1.0 + part - part**2), part**3]
    moved = correlate1d(coefficients, np.array(weights) / 6.0, mode="mirror")
    last = coefficients.shape[-1] - 1
    return moved[..., np.clip(np.arange(last + 1) + whole, 0, last)]
