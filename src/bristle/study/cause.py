"""What varies from run to run: a quantity with a distribution, or all that a fit drew together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle.study.distribution import Distribution
from bristle.study.target import Target

__all__ = ["Cause", "Drawn", "Joint"]


@dataclass(frozen=True)
class Drawn:
    """A quantity that is drawn by itself."""

    target: Target
    distribution: Distribution

    @property
    def name(self) -> str:
        """Name of the cause."""
        return self.target.path

    @property
    def units(self) -> dict[str, str]:
        """Unit of each value by dotted key."""
        return {self.target.path: self.target.unit}

    def values(self, unit_numbers: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values by dotted key for numbers between 0 and 1, shape (draw,)."""
        return {self.target.path: self.distribution.values(unit_numbers)}


@dataclass(frozen=True)
class Joint:
    """Quantities that were drawn together: whole rows of a table, each as often as any other."""

    name: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]

    @property
    def count(self) -> int:
        """How many rows there are."""
        return len(next(iter(self.columns.values())))

    def values(self, unit_numbers: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values by dotted key for numbers between 0 and 1, shape (draw,) or (draw, element)."""
        rows = np.minimum((unit_numbers * self.count).astype(int), self.count - 1)
        return {path: values[rows] for path, values in self.columns.items()}


Cause = Drawn | Joint
