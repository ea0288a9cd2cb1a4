r"""Innovations of a regression: each observation against what those before it predict, as independent normal numbers.

An observation is :math:`y_i = x_i^\top\beta + \sigma\sqrt{r_i}\,\varepsilon_i`, with a constant and,
where there is one, the temperature in :math:`x_i`, and a relative variance :math:`r_i` that is known. With the
coefficients that the observations before it give, its recursive residual is

.. math:: w_i = \frac{y_i - x_i^\top\hat\beta_{i-1}}{\sqrt{r_i + x_i^\top P_{i-1} x_i}}

For independent normal errors all of these are independent, with one variance. Over the standard deviation of those
before, each follows the distribution of Student with as many degrees of freedom as there were residuals; through that
distribution it becomes a normal number :math:`u_i`, however few observations the baseline has. The uncertainty of the
baseline, and that of the temperature coefficient, is in them. Beyond `CLIP` a number counts no more: heavy tails, and a
log that went wrong, make no alarm by themselves.

Sources: recursive residuals, Brown, Durbin and Evans 1975 (doi:10.1111/j.2517-6161.1975.tb01532.x); charts that begin
by themselves, Hawkins 1987 (doi:10.2307/2348827).
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri, stdtr

__all__ = ["CLIP", "Innovations"]

CLIP = 2.0  # standard deviations
DIFFUSE = 1e8  # variance of the coefficients before anything was seen, over that of an observation
FEWEST = 2  # residuals that tell a standard deviation
_EDGE = 1e-300


class Innovations:
    """Innovations of a series that grows, and what a change of a given course would add to each of them."""

    def __init__(self, regressors: np.ndarray, variances: np.ndarray) -> None:
        self.count, self.order = regressors.shape
        self._x, self._r = regressors, variances
        self._gains = np.empty((self.count, self.order))
        self._scales = np.empty(self.count)
        covariance = DIFFUSE * np.eye(self.order)
        for i, x in enumerate(regressors):
            reach = covariance @ x
            variance = variances[i] + x @ reach
            self._gains[i], self._scales[i] = reach / variance, np.sqrt(variance)
            covariance -= np.outer(reach, reach) / variance

    def filter(self, series: int) -> Filter:
        """Return what makes recursive residuals of so many series, observation by observation."""
        return Filter(self._x, self._gains, self._scales, series)

    def residuals(self, values: np.ndarray) -> np.ndarray:
        """Return the recursive residuals of a series."""
        course = self.filter(1)
        return np.array([float(course.next(np.array([value]))[0]) for value in values])

    def scores(self, values: np.ndarray) -> np.ndarray:
        """Return the innovations of a series as standard normal numbers, cut at `CLIP`; zero while nothing is known."""
        centred = values - values[0]
        size = float(np.max(np.abs(centred), initial=0.0)) or 1.0
        residuals = self.residuals(centred / size)
        past = np.concatenate([[0.0], np.cumsum(residuals**2)[:-1]])
        freedom = np.arange(self.count) - self.order
        scored = (freedom >= FEWEST) & (past > 0.0)
        scores = np.zeros(self.count)
        ratios = residuals[scored] / np.sqrt(past[scored] / freedom[scored])
        tails = np.maximum(stdtr(freedom[scored], -np.abs(ratios)), _EDGE)
        scores[scored] = -np.sign(ratios) * ndtri(tails)
        return np.clip(scores, -CLIP, CLIP)


class Filter:
    """Recursive residuals of several series at once, an observation after the other."""

    def __init__(self, regressors: np.ndarray, gains: np.ndarray, scales: np.ndarray, series: int) -> None:
        self._x, self._gains, self._scales = regressors, gains, scales
        self._coefficients = np.zeros((series, regressors.shape[1]))
        self._count = 0

    def forget(self, places: slice) -> None:
        """Begin some of the series anew, as if they had been zero until now."""
        self._coefficients[places] = 0.0

    def next(self, values: np.ndarray) -> np.ndarray:
        """Return the recursive residual of the next observation of each series, shape (series,)."""
        i = self._count
        self._count += 1
        errors = values - self._coefficients @ self._x[i]
        self._coefficients += errors[:, None] * self._gains[i]
        return errors / self._scales[i] if i >= self._x.shape[1] else np.zeros_like(errors)
