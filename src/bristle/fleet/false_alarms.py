"""How often a healthy axis may alarm, and the threshold that keeps to it.

Innovations of a healthy axis are independent normal numbers whatever its baseline, so that one table serves all: the
largest likelihood ratio of `bristle.fleet.change` was simulated on them, cut as they are, over 1000 observations, and
the threshold is the one that a share 1 - exp(-1000 rate) of 20 000 runs exceeds. ``python -m
benchmarks.watch_thresholds`` makes the table. Several quantities of an axis share the rate between them (Bonferroni):
what they have in common makes false alarms rarer, never more frequent.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from bristle.core.errors import InputError

__all__ = ["RATES", "THRESHOLDS", "FalseAlarms", "false_alarms_from", "threshold_for"]

RATES = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2)
"""False alarms in an observation."""
THRESHOLDS = (4.48, 4.23, 3.95, 3.68, 3.37, 3.04, 2.66)
"""Likelihood ratios, in standard deviations."""
_RATE = re.compile(r"(\d{1,9}(?:\.\d{1,6})?)\s*(?:per|in|/)\s*(\d{1,9}(?:\.\d{1,6})?)\s*(days?|logs?)")


class FalseAlarms(NamedTuple):
    """A rate of false alarms of one axis: how many, in how many days or logs."""

    times: float
    among: float
    unit: str

    @property
    def words(self) -> str:
        """The rate as a person says it."""
        return f"{self.times:g} in {self.among:g} axis-{self.unit}"

    def per_observation(self, days: float | None, quantities: int) -> float:
        """Return the rate of one quantity in one observation."""
        step = 1.0 if self.unit == "logs" or days is None else days
        return self.times / self.among * step / quantities


def false_alarms_from(text: str, path: str = "--false-alarms") -> FalseAlarms:
    """Return the rate that a text says, such as ``"1 in 1000 days"``.

    Examples
    --------
    >>> false_alarms_from("1 per 1000 days").words
    '1 in 1000 axis-days'
    """
    match = _RATE.fullmatch(text.strip())
    if match is None or not float(match[1]) > 0.0 or not float(match[2]) > 0.0:
        raise InputError("is no rate", path=path, value=text, allowed='"1 in 1000 days", "1 in 500 logs"')
    return FalseAlarms(float(match[1]), float(match[2]), f"{match[3].rstrip('s')}s")


def threshold_for(rate: float, path: str = "--false-alarms") -> float:
    """Return the likelihood ratio that a healthy quantity exceeds this often."""
    if not RATES[0] <= rate <= RATES[-1]:
        raise InputError(
            "is a rate that was not simulated",
            path=path,
            value=f"{rate:.3g}",
            allowed=f"{RATES[0]:g} to {RATES[-1]:g} in an observation of a quantity",
        )
    return float(np.sqrt(np.interp(np.log(rate), np.log(RATES), np.square(THRESHOLDS))))
