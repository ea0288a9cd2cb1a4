"""The error of a fit on what was not fitted."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["HeldOut"]


@dataclass(frozen=True)
class HeldOut:
    """Error on time blocks, or whole logs, that were not fitted: 100 ||y - y_hat|| / ||y|| one by one [%]."""

    block_errors_percent: tuple[float, ...]
    mean_percent: float
    std_percent: float
    of: str = "time blocks"
