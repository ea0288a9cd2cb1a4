"""One identified parameter: its value, its uncertainty and its share of the friction force."""

import math
from dataclasses import dataclass

from bristle.core.diagnostic import Diagnostic
from bristle.core.normal import NORMAL_95

OPEN = 100.0  # half-width of an interval that does not identify a parameter [%]
ROUGH = 0.5  # half-width over the value, above which a parameter is known only roughly
MATTERS = 0.02  # smallest share of the friction force that matters in use


@dataclass(frozen=True)
class Estimate:
    """One parameter: its value and uncertainty.

    Parameters
    ----------
    name : str
        Name of the parameter.
    unit : str
        SI unit for the kind of axis.
    description : str
        Meaning of the parameter.
    value : float
        The value in `unit`.
    std : float or None
        Standard error in `unit` for independent residuals; None if the parameter is held constant, at an edge of its
        range or not determined.
    status : {"identified", "held", "at_edge", "unidentifiable"}
        ``held``: held constant at a given value; ``at_edge``: at an edge of its range; ``unidentifiable``: not determined
        by the log.
    reason : Diagnostic or None
        Reason for a status other than ``identified``; else None.
    robust_std : float or None
        Standard error in `unit`, valid for residuals correlated over time.
    interval : tuple of float or None
        Low and high end of the 95 % interval in `unit`, from fits to replicates of the log; None without replicates. With a
        cable in the effort, the interval of a friction force includes the error by which both are told apart.
    effect : float
        Rms change of the effort per `unit` of this parameter alone, over the rms friction force of the log; infinite if
        not computed.
    """

    name: str
    unit: str
    description: str
    value: float
    std: float | None
    status: str = "identified"
    reason: Diagnostic | None = None
    robust_std: float | None = None
    interval: tuple[float, float] | None = None
    effect: float = math.inf

    @property
    def relative_std_percent(self) -> float | None:
        """Standard error as a percentage of the value; None without a standard error."""
        if self.std is None or self.value == 0.0:
            return None
        return 100.0 * abs(self.std / self.value)

    @property
    def larger_std(self) -> float | None:
        """The larger of `std` and `robust_std` in `unit`; None without a standard error."""
        return max((std for std in (self.std, self.robust_std) if std is not None), default=None)

    @property
    def ends(self) -> tuple[float, float] | None:
        """Ends of the 95 % interval in `unit`; without `interval` from the larger standard error, None without both."""
        if self.interval is not None or self.larger_std is None:
            return self.interval
        return self.value - NORMAL_95 * self.larger_std, self.value + NORMAL_95 * self.larger_std

    @property
    def interval_percent(self) -> float | None:
        """Half-width of `ends` as a percentage of the value."""
        if self.value == 0.0 or self.ends is None:
            return None
        return 50.0 * (self.ends[1] - self.ends[0]) / abs(self.value)

    @property
    def is_rough(self) -> bool:
        """Whether the half-width exceeds half of the value, and the parameter matters to the force."""
        if self.status != "identified" or self.ends is None:
            return False
        half_width = 0.5 * (self.ends[1] - self.ends[0])
        return half_width > ROUGH * abs(self.value) and self.effect * half_width > MATTERS

    @property
    def takes(self) -> float:
        """Rms force due to this parameter over the rms friction force of the log."""
        return self.effect * abs(self.value) if self.value else 0.0

    @property
    def matters(self) -> bool:
        """Whether a model without this parameter would lack a share of friction that matters in use."""
        return self.takes > MATTERS


def half_width(estimate: Estimate) -> float:
    """Return the half-width of the interval of a parameter [%], at most that of an open interval."""
    half = estimate.interval_percent
    if estimate.status != "identified" or half is None:
        return OPEN
    return min(half, OPEN)
