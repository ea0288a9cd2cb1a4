r"""Whether a level has changed, since when, and how: a likelihood ratio over every onset, at every observation.

Were there a change :math:`\delta\,g_\tau(t)` since the onset :math:`\tau`, a step or a drift, the innovation of
observation i would be shifted by :math:`\delta\,e_i(\tau)/\sigma`, where :math:`e_i(\tau)` are the recursive residuals
of the course :math:`g_\tau` itself. The generalised likelihood ratio of such a change, with its size estimated, is at
observation n

.. math:: z_n = \max_\tau \left|\frac{\sum_{i\le n} u_i\,e_i(\tau)}{\sqrt{\sum_{i\le n} e_i(\tau)^2}}\right|

over both courses and the onsets within `WINDOW` observations. An alarm is the first n at which it exceeds a threshold.

Sources: change detection with a bound on false alarms, Lorden 1971 (doi:10.1214/aoms/1177693055); the generalised
likelihood ratio over the onset, Siegmund and Venkatraman 1995 (doi:10.1214/aos/1176324466), within a window, Lai 1998
(doi:10.1109/18.737522).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bristle.fleet.innovations import Innovations

__all__ = ["COURSES", "WINDOW", "LevelChange", "course_of_change", "largest_ratios"]

COURSES = ("step", "drift")
WINDOW = 400  # observations
LEAST = 1e-12


class LevelChange(NamedTuple):
    """A change: which observation it begins with, and which course it takes."""

    onset: int
    course: str


def course_of_change(change: LevelChange, time: np.ndarray) -> np.ndarray:
    """Return the course of a change, of size one a step, of slope one a drift."""
    since = np.arange(time.size) >= change.onset
    if change.course == "step":
        return since.astype(float)
    before = time[max(change.onset - 1, 0)]
    return np.where(since, time - before, 0.0)


def largest_ratios(innovations: Innovations, time: np.ndarray, scores: np.ndarray) -> np.ndarray:
    """Return the largest likelihood ratio over courses and onsets, at each observation, from those until then."""
    series = scores.reshape(len(scores), -1)
    scored = np.any(series != 0.0, axis=1)
    largest = np.zeros(series.shape)
    days = (time - time[0]) / (float(time[-1] - time[0]) or 1.0)
    shifts, energy = innovations.filter(len(COURSES) * WINDOW), np.zeros(len(COURSES) * WINDOW)
    sums, begins = np.zeros((energy.size, series.shape[1])), np.zeros(WINDOW)
    onsets = np.full(WINDOW, -1)
    for i in range(len(series)):
        place = i % WINDOW  # the oldest onset makes room for this one
        fresh = slice(place, None, WINDOW)
        onsets[place], begins[place] = i, days[max(i - 1, 0)]
        energy[fresh], sums[fresh] = 0.0, 0.0
        shifts.forget(fresh)
        added = np.concatenate([onsets >= 0, np.where(onsets >= 0, days[i] - begins, 0.0)])
        shift = shifts.next(added)
        if not scored[i]:
            continue
        energy += shift**2
        sums += shift[:, None] * series[i]
        weighed = energy > LEAST
        ratios = np.abs(sums) / np.sqrt(np.where(weighed, energy, 1.0))[:, None] * weighed[:, None]
        largest[i] = np.max(ratios, axis=0)
    return largest.reshape(scores.shape)
