"""Replicates of a log of which a simulation was fitted: what its axis would have recorded, had the model been true.

All that disturbs a log is small beside its signal, so each cause changes the signal by itself: the encoder as far as
it shows in the loop, friction whose level is another one in each half-cycle, and what the model leaves over besides,
block by block with a sign drawn by chance. Their sum is what a fit to a replicate would be asked to explain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.identification.disturbance import signs_of
from bristle.identification.outputs import Output, Reading
from bristle.identification.problem import Disturbance

if TYPE_CHECKING:
    from bristle.identification.output_error import OutputError

__all__ = ["SignalReplicates"]

FAR = 1e12  # of a signal that left the finite numbers


@dataclass(frozen=True)
class Changed:
    """The same fit to a signal that is changed, shape (sample,)."""

    error: OutputError
    pure: np.ndarray
    change: np.ndarray
    solution: Mapping[str, float]

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return what these parameters leave of the changed signal; at the solution of the fit it is the change."""
        if all(free[name] == value for name, value in self.solution.items()):
            return self.change
        simulated = self.error.simulated(self.error.parameters.complete(free))
        return self.pure + self.change - np.where(np.isfinite(simulated), simulated, FAR)


@dataclass(frozen=True)
class SignalReplicates:
    """A fitted simulation and what disturbs its log.

    Parameters
    ----------
    error : OutputError
        What was fitted.
    values : mapping
        All parameters [SI].
    disturbance : Disturbance
        Scatter, encoder, and the share of the residual that is neither.
    slope, left : ndarray, shape (sample,)
        By how much the signal rises with the level of friction; what the fit left over.
    """

    error: OutputError
    values: Mapping[str, float]
    disturbance: Disturbance
    slope: np.ndarray
    left: np.ndarray

    def disturbed(self, **changes: float) -> SignalReplicates:
        """Return the same with another disturbance."""
        return replace(self, disturbance=self.disturbance._replace(**changes))

    def draw(self, rng: np.random.Generator, ratio: float = 1.0, side: float = 1.0) -> Changed:
        """Return the same fit to a log drawn anew, with `ratio` times the scatter, or to its mirror image (-1)."""
        levels = (ratio * self.disturbance.scatter * rng.standard_normal(self.error.half_cycles.count))[
            self.error.half_cycles.index
        ]
        reading = Reading(self.disturbance.resolution, self.disturbance.jitter)
        changes, first = [], 0
        for one, pure, leaning in self._pure:
            push = levels[first : first + pure.size] * leaning
            change = np.nan_to_num(one.read(*self._models, self.values, pure, push, reading, rng))
            part = slice(first, first + pure.size)
            changes.append(change + self.disturbance.unexplained * signs_of(pure.size, rng) * self.left[part])
            first += pure.size
        solution = {name: self.values[name] for name in self.error.parameters.free}
        return Changed(
            self.error, np.concatenate([pure for _, pure, _ in self._pure]), side * np.concatenate(changes), solution
        )

    @cached_property
    def _pure(self) -> list[tuple[Output, np.ndarray, np.ndarray]]:
        """Each segment, its signal without disturbance, and what a level of friction that is higher adds to it."""
        found, first = [], 0
        for one in self.error.outputs:
            slope = self.slope[first : first + one.measured.size]
            leaning = np.nan_to_num(one.leaning(*self._models, self.values, slope))
            found.append((one, one.simulated(*self._models, self.values), leaning))
            first += slope.size
        return found

    @property
    def _models(self) -> tuple[Model, Model]:
        return self.error.inverse.plant(self.values), self.error.inverse.model(self.values)
