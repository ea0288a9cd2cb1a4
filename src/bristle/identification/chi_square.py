r"""Squares of standard deviations that were estimated: nearly a chi-square distribution, whatever a few of them do.

.. math:: S^2 \sim \mu\, \chi^2_\nu / \nu

with as many degrees of freedom :math:`\nu` as the variance of the logarithm asks for [1]_, which is
:math:`\psi_1(\nu / 2)`. An estimate that went astray counts for no more than one at the edge of the others.

References
----------
.. [1] M. S. Bartlett, D. G. Kendall, "The statistical analysis of variance-heterogeneity and the logarithmic
   transformation", Supplement to the Journal of the Royal Statistical Society 8(1), 1946. doi:10.2307/2983618
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bristle.core.normal import DEVIATION_OVER_MEDIAN

__all__ = ["CERTAIN", "ChiSquare"]

EDGE = 3.0  # standard deviations


class ChiSquare(NamedTuple):
    """A mean, and degrees of freedom; infinitely many where all estimates are the same."""

    mean: float
    freedom: float

    @classmethod
    def of(cls, squares: np.ndarray) -> ChiSquare:
        """Return the distribution of squares, shape (estimate,); nothing but zero where one of them is zero."""
        from scipy.special import psi

        if not np.all(squares > 0.0):
            return CERTAIN
        logs = _kept_in(np.log(squares))
        variance, middle = float(np.var(logs, ddof=1)), float(np.mean(logs))
        if variance == 0.0:
            return cls(math.exp(middle), math.inf)
        # The trigamma function of h is nearly 1/h + 1/(2 h^2).
        half = (1.0 + (1.0 + 2.0 * variance) ** 0.5) / (2.0 * variance)
        return cls(half * math.exp(middle - float(psi(half))), 2.0 * half)

    def deviation(self, share: float) -> float:
        """Return below which ratio to the true one a share of the estimated standard deviations lies."""
        from scipy.special import chdtri

        return float(chdtri(self.freedom, 1.0 - share) / self.freedom) ** 0.5 if math.isfinite(self.freedom) else 1.0


def _kept_in(logs: np.ndarray) -> np.ndarray:
    middle = np.median(logs)
    reach = EDGE * DEVIATION_OVER_MEDIAN * np.median(np.abs(logs - middle))
    return np.clip(logs, middle - reach, middle + reach)


CERTAIN = ChiSquare(0.0, math.inf)
