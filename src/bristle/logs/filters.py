"""Filters whose delay is none, or taken out, and the derivative that goes with them; signals of shape (..., sample)."""

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise

import numpy as np

LONG = 2**18  # samples of a signal that one spline goes through
BESIDE = 50  # samples beside a part of a signal that its slopes depend on, to rounding


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
    """Return the sections of the filter, their settled state, by how much a signal is extended, and when a start has died out.

    Both in samples, the latter to rounding.
    """
    from scipy.signal import butter, sosfilt_zi

    sections = np.asarray(butter(4, cutoff, fs=1.0 / sample_time, output="sos"))
    taps = 2 * len(sections) + 1 - min((sections[:, 2] == 0.0).sum(), (sections[:, 5] == 0.0).sum())
    slowest = max(np.abs(np.roots(section[3:])).max() for section in sections)
    return sections, sosfilt_zi(sections), 3 * int(taps), math.ceil(math.log(np.finfo(float).eps) / math.log(slowest))


def derivative(signal: np.ndarray, dt: float) -> np.ndarray:
    """Return the derivative of a signal, shape (..., sample), true to the fourth order of the step.

    Of the second order, as `numpy.gradient` is, the acceleration of 10 Hz at 500 samples a second is 0.5 % small.
    """
    slope = np.gradient(signal, dt, axis=-1)
    near, far = signal[..., 3:-1] - signal[..., 1:-3], signal[..., 4:] - signal[..., :-4]
    slope[..., 2:-2] = (8.0 * near - far) / (12.0 * dt)
    return slope


def between(time: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return a signal, shape (..., sample), as a function of time; beyond its ends it stays.

    A cubic spline; of a long signal one for each part, whose slopes see the samples around it: those further away do not matter.
    """
    from scipy.interpolate import CubicHermiteSpline, CubicSpline

    if time.size <= LONG:
        spline = CubicSpline(time, values, axis=-1)
        return lambda instants: np.asarray(spline(np.clip(instants, time[0], time[-1])))
    bounds, slopes = np.linspace(0, time.size - 1, -(-time.size // LONG) + 1).astype(int), np.empty(values.shape)
    parts = [slice(first, last + 1) for first, last in pairwise(bounds.tolist())]
    for part in parts:
        around = slice(max(part.start - BESIDE, 0), part.stop + BESIDE)
        slopes[..., part] = CubicSpline(time[around], values[..., around], axis=-1)(time[part], 1)

    def interpolated(instants: np.ndarray) -> np.ndarray:
        instants = np.clip(instants, time[0], time[-1])
        of, signal = np.searchsorted(time[bounds[1:-1]], instants, side="right"), np.empty((*values.shape[:-1], instants.size))
        for number, part in enumerate(parts):
            spline = CubicHermiteSpline(time[part], values[..., part], slopes[..., part], axis=-1)
            signal[..., of == number] = spline(instants[of == number])
        return signal

    return interpolated


def at(instants: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a signal, shape (..., sample), at these instants, as `between` tells it."""
    return between(time, values)(instants)


def through_filter(signal: np.ndarray, lag: float, dt: float) -> np.ndarray:
    """Return a signal, shape (..., sample), behind a first-order filter of this time constant [s], its delay taken out.

    Before one where the time constant is negative.
    """
    from scipy.signal import lfilter

    time = dt * np.arange(signal.shape[-1])
    if lag < 0.0:
        return at(time + lag, time, signal - lag * derivative(signal, dt))
    gain = dt / (2.0 * lag + dt)
    behind, _ = lfilter([gain, gain], [1.0, (dt - 2.0 * lag) / (dt + 2.0 * lag)], signal, zi=(1.0 - gain) * signal[..., :1])
    return at(time + lag, time, np.asarray(behind))
