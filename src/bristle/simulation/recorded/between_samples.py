r"""What an effort does between its samples, and whether a log repeats itself.

A sampled controller holds its effort; a measured force runs about straight on; a signal without content above half the
sampling frequency is known everywhere from its samples (Whittaker, Shannon): the only interpolation that does not
falsify a structure that is excited at a tenth of the sampling frequency. Of a periodic record it is exact: the
spectrum of one period, evaluated on a finer grid.
"""

from __future__ import annotations

import numpy as np

from bristle.core.least_squares import unbounded

__all__ = ["closes", "finer", "period_of"]

EQUAL = 1e-9  # of the largest value: a difference of two periods that is none
BEYOND = 4096  # samples that a record is continued by before it is interpolated
ORDER = 24  # samples that the next one is predicted from
LEARNT = 5000  # samples that the prediction is learnt from
SEAM = 2.0  # times the largest error of the prediction inside a record: a seam that does not show


def finer(effort: np.ndarray, steps: int, *, periodic: bool) -> np.ndarray:
    """Return a band-limited effort on a grid that is finer, the samples among its points."""
    from scipy.signal import resample

    if periodic:
        return np.asarray(resample(effort, effort.size * steps))
    beyond = min(effort.size - 1, BEYOND)
    before = 2.0 * effort[0] - effort[beyond:0:-1]
    after = 2.0 * effort[-1] - effort[-2 : -2 - beyond : -1]
    fade = 0.5 * (1.0 - np.cos(np.pi * np.arange(1, beyond + 1) / (beyond + 1)))
    faded = np.concatenate([fade * before, effort, fade[::-1] * after])
    fine = np.asarray(resample(faded, faded.size * steps))
    return fine[beyond * steps : (beyond + effort.size) * steps]


def period_of(effort: np.ndarray) -> int | None:
    """Return the period of a record that holds at least two equal ones, in samples; None for any other record."""
    size = effort.size
    if size < 4 or not np.any(effort != effort[0]):
        return None
    tolerance = EQUAL * float(np.max(np.abs(effort)))
    swing = effort - effort.mean()
    spectrum = np.fft.rfft(swing, 2 * size)
    overlap = np.arange(size, 0, -1)
    alike = np.fft.irfft(np.abs(spectrum) ** 2)[:size] / overlap
    # Shifted by a period, a record is as much like itself as unshifted.
    for period in np.flatnonzero(alike[: size // 2 + 1] > (1.0 - 1e-6) * alike[0]).tolist():
        if period >= 2 and np.all(np.abs(effort[period:] - effort[:-period]) <= tolerance):
            return period
    return None


def closes(signal: np.ndarray) -> bool:
    """Return whether a record goes on from its end to its beginning as it goes on inside: it is a whole period.

    Inside, each sample follows from those before it, as well as a linear prediction does. Across the seam of whole
    periods it is as good; across any other it fails.
    """
    if signal.size < 8 * ORDER or not np.any(signal != signal[0]):
        return False
    rows = np.lib.stride_tricks.sliding_window_view(signal - signal.mean(), ORDER + 1)
    learnt = rows[:: max(rows.shape[0] // LEARNT, 1)]
    weights = unbounded(learnt[:, :-1], learnt[:, -1], rcond=1e-12)
    seam = np.concatenate([signal[-ORDER:], signal[:ORDER]]) - signal.mean()
    across = np.lib.stride_tricks.sliding_window_view(seam, ORDER + 1)
    inside, across_seam = (float(np.max(np.abs(windows[:, -1] - windows[:, :-1] @ weights))) for windows in (rows, across))
    return across_seam <= SEAM * inside
