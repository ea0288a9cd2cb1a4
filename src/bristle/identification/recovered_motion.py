r"""The motion of a log as a replicate of it goes: with the corners that the filter of the treatment rounds.

A model is fitted along a motion that was filtered. Friction acted along the one that was not, and between the samples,
too. What a replicate is to show of that, it must have: octave by octave beyond the cut-off, what the position shows
there is put back where it stands out of the noise of the encoder, and only there. A corner that noise hides is made as
sharp as the filtered motion lets it be: what the filter takes from that is put back once.

.. math:: q + \sum_b w_b(t)\,(L_{b+1} - L_b)\,q, \qquad w_b = 1 \;\text{where}\;
    \left|(L_{b+1} - L_b)\,q\right| > 4 \sqrt{n\,(f_{b+1} - f_b)}

with filters `L` of the cut-offs :math:`f_b = 2^b f_c`, and the spectral density `n` of the noise of the position.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.identification.dataset import Dataset, Segment
from bristle.logs.filters import derivative, low_passed

FINER = 5  # steps of a sample
ABOVE = 4.0  # standard deviations of the noise
FLOOR = 0.4  # of the sampling frequency, from which on nothing is filtered, and the noise is read
WINDOW = 512  # samples


class Recovered(NamedTuple):
    """A segment along the motion before the filter, and how much of its corners is visible, shape (sample,), 0 to 1."""

    segment: Segment
    visible: np.ndarray


def noise_density(position: np.ndarray, resolution: float, dt: float) -> float:
    """Return the spectral density of the noise of a position [m^2/Hz or rad^2/Hz], at least that of rounding."""
    from scipy.signal import welch

    bent = np.diff(position, 2)
    frequencies, density = welch(bent, fs=1.0 / dt, nperseg=min(WINDOW, bent.size), detrend="constant")
    top = frequencies >= FLOOR / dt
    of_second_difference = (2.0 * np.sin(np.pi * frequencies[top] * dt)) ** 4
    return max(float(np.median(density[top] / of_second_difference)), 2.0 * dt * resolution**2 / 12.0)


def recovered(segment: Segment, dataset: Dataset) -> Recovered:
    """Return a segment along the motion before the filter, as far as its noise lets it be seen."""
    from scipy.ndimage import maximum_filter1d, uniform_filter1d

    dt, origin, cutoff = dataset.sample_time, segment.position[0], dataset.cutoff
    raw, smooth = segment.recorded - origin, segment.position - origin
    density = noise_density(raw, dataset.resolution, dt)
    position, below, visible = smooth, low_passed(raw, cutoff, dt), np.zeros(0)
    while below is not raw:
        wide = 2.0 * cutoff
        above = raw if wide >= FLOOR / dt else low_passed(raw, wide, dt)
        noise = (density * (min(wide, 0.5 / dt) - cutoff)) ** 0.5
        # 1 within the reach of what stands out, less beside it.
        stands_out, reach = np.abs(above - below) > ABOVE * noise, max(round(0.5 / (dataset.cutoff * dt)), 1)
        share = uniform_filter1d(maximum_filter1d(stands_out.astype(float), 4 * reach + 1), 2 * reach + 1)
        position = position + share * (above - below)
        visible = share if not visible.size else visible
        cutoff, below = wide, above
    position = position + (1.0 - visible) * (smooth - low_passed(smooth, dataset.cutoff, dt))
    velocity = derivative(position, dt)
    at_rest = segment.velocity == 0.0
    moved = replace(
        segment, position=position + origin, velocity=np.where(at_rest, segment.velocity, velocity), acceleration=derivative(velocity, dt)
    )
    return Recovered(moved, visible)


def between_samples(segment: Segment, dt: float, finer: int = FINER) -> Segment:
    """Return a segment on a grid that is finer by so many steps of a sample, the samples among its points.

    The velocity of a point is the mean over the step around it.
    """
    from scipy.interpolate import CubicSpline

    h, origin = dt / finer, segment.position[0]
    count = (segment.position.size - 1) * finer + 1
    along = CubicSpline(dt * np.arange(segment.position.size), segment.position - origin)
    edges = along(h * (np.arange(count + 1) - 0.5))
    at_rest = np.repeat(segment.velocity, finer)[:count] == 0.0
    signed = np.repeat(segment.velocity, finer)[:count]
    samples, points = np.arange(segment.position.size), np.arange(count) / finer

    def fine(signal: np.ndarray) -> np.ndarray:
        return np.interp(points, samples, signal)

    return replace(
        segment,
        time=fine(segment.time),
        position=0.5 * (edges[1:] + edges[:-1]) + origin,
        velocity=np.where(at_rest, signed, np.diff(edges) / h),
        acceleration=fine(segment.acceleration),
        effort=fine(segment.effort),
        recorded=fine(segment.recorded),
        first_cycle=segment.first_cycle * finer,
        surroundings={name: fine(values) for name, values in segment.surroundings.items()},
        regressors=tuple(fine(column) for column in segment.regressors),
    )
