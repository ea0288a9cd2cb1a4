"""What is known of the channels of a log in time, and what is done with it: the effort moved to where it acted.

An effort that lags is moved back by fractions of a sample. One that a channel filtered, more than the position, is put
before that filter; one that runs ahead of a filter, as a command does of the drive behind it, passes it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bristle.identification.dataset import Dataset, derivative

__all__ = ["Alignment", "aligned", "differentiated", "shifted", "through_filter"]


@dataclass(frozen=True)
class Alignment:
    """How the effort of a log stands in time to its position, and the inertia that was found with it.

    Parameters
    ----------
    delay, delay_half_width : float or None
        By which the effort lags the position, and half of its 95 % interval [s]; None where the log does not show it.
    smoothing, smoothing_half_width : float or None
        Time constant of a first-order filter that the effort passed more than the position did; negative where it
        passed less [s]. None where none is seen.
    mass, mass_half_width : float or None
        Inertia, and half of its 95 % interval [kg or kg*m^2]; None where the log shows none.
    slow : float
        Cut-off of what the equations were weighed with [Hz].
    sought : bool
        Whether the delay was looked for.
    """

    delay: float | None = None
    delay_half_width: float | None = None
    smoothing: float | None = None
    smoothing_half_width: float | None = None
    mass: float | None = None
    mass_half_width: float | None = None
    slow: float = 0.0
    sought: bool = True

    def as_data(self) -> dict[str, float]:
        """Return what is known of it, as the treatment of a log tells it."""
        data = {
            "delay": self.delay, "delay_half_width": self.delay_half_width,
            "smoothing": self.smoothing, "smoothing_half_width": self.smoothing_half_width,
            "mass": self.mass, "mass_half_width": self.mass_half_width, "slow": self.slow,
        }  # fmt: skip
        return {name: value for name, value in data.items() if value}


def aligned(dataset: Dataset, alignment: Alignment) -> Dataset:
    """Return the rows of a log whose channels stand in time as they were found to."""
    moved = shifted(dataset, alignment.delay or 0.0, alignment.smoothing or 0.0)
    moved = differentiated(moved) if alignment.slow else moved
    return replace(moved, alignment=alignment)


def shifted(dataset: Dataset, delay: float, smoothing: float = 0.0) -> Dataset:
    """Return the rows of a log whose effort lags by `delay`, filtered by `smoothing` in that [s], mended."""
    if not delay and not smoothing:
        return dataset
    moved = []
    for segment in dataset.segments:
        sharp = segment.effort if not smoothing else through_filter(segment.effort, -smoothing, dataset.sample_time)
        moved.append(replace(segment, effort=at(segment.time + delay, segment.time, sharp)))
    return replace(dataset, segments=tuple(moved), delay=delay)


def at(instants: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return a signal, shape (..., sample), between its samples; beyond its ends it stays."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, values, axis=-1)(np.clip(instants, time[0], time[-1])))


def through_filter(signal: np.ndarray, lag: float, dt: float) -> np.ndarray:
    """Return a signal, shape (..., sample), behind a first-order filter of this time constant [s], its delay taken out.

    Before one where the time constant is negative.
    """
    from scipy.signal import lfilter

    time = dt * np.arange(signal.shape[-1])
    if lag < 0.0:
        return at(time + lag, time, signal - lag * derivative(signal, dt))
    gain = dt / (2.0 * lag + dt)
    first = signal[..., :1]
    behind, _ = lfilter([gain, gain], [1.0, (dt - 2.0 * lag) / (dt + 2.0 * lag)], signal, zi=(1.0 - gain) * first)
    return at(time + lag, time, np.asarray(behind))


def differentiated(dataset: Dataset) -> Dataset:
    """Return the rows of a log whose acceleration is true to the fourth order of the step."""
    dt, moved = dataset.sample_time, []
    for segment in dataset.segments:
        acceleration = derivative(derivative(segment.position - segment.position[0], dt), dt)
        moved.append(replace(segment, acceleration=acceleration))
    return replace(dataset, segments=tuple(moved))
