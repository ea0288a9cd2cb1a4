"""The twin of a log of which a simulation was fitted: what its axis would have recorded, had the model been the truth.

All that disturbs a log is small beside its signal, so each cause changes the signal by itself: the encoder as far as
it shows in the loop, friction whose level is another one in each half-cycle, and what the model leaves over besides,
block by block with a sign drawn by chance. Their sum is what a fit to a twin would be asked to explain.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bristle.core.contracts import Model
from bristle.identification.output_error import Output, OutputError, Reading
from bristle.identification.resampling.half_cycles import DEVIATIONS, NUDGE, STEPS, Groups, turns_of
from bristle.identification.resampling.levels import scaled
from bristle.identification.resampling.twin import Disturbance, signs_of

__all__ = ["OutputTwin", "level_slope_of", "moves_of"]


@dataclass(frozen=True)
class Change:
    """What a fit to a twin is asked to explain beyond the model itself, shape (sample,)."""

    signal: np.ndarray

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return it: the fit is linear around the solution, and goes nowhere else."""
        return self.signal


@dataclass(frozen=True)
class OutputTwin:
    """A fitted simulation and what disturbs its log.

    Parameters
    ----------
    error : OutputError
        What was fitted.
    values : mapping
        All parameters [SI].
    groups : Groups
        The half-cycles of the log.
    disturbance : Disturbance
        Scatter, encoder, and the share of the residual that is neither.
    slope, left : ndarray, shape (sample,)
        By how much the signal rises with the level of friction; what the fit left over.
    """

    error: OutputError
    values: Mapping[str, float]
    groups: Groups
    disturbance: Disturbance
    slope: np.ndarray
    left: np.ndarray

    def disturbed(self, **changes: float) -> OutputTwin:
        """Return the same with another disturbance."""
        return replace(self, disturbance=replace(self.disturbance, **changes))

    def drawn(self, rng: np.random.Generator, ratio: float = 1.0) -> Change:
        """Return what a twin drawn anew has in its signal, with `ratio` times the scatter."""
        levels = ratio * self.disturbance.scatter * rng.standard_normal(self.groups.count)
        signal = levels[self.groups.index] * self.slope
        signal += np.concatenate([self._read(one, pure, rng) for one, pure in self._pure])
        sizes = [one.measured.size for one in self.error.outputs]
        signs = np.concatenate([signs_of(size, rng) for size in sizes])
        return Change(signal + self.disturbance.unexplained * signs * self.left)

    def _read(self, one: Output, pure: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return what the encoder adds to the signal; nobody knows where its steps lie."""
        reading = Reading(self.disturbance.resolution, self.disturbance.jitter)
        return np.nan_to_num(one.read(*self._models, self.values, pure, reading, rng))

    @cached_property
    def _pure(self) -> list[tuple[Output, np.ndarray]]:
        return [(one, one.simulated(*self._models, self.values)) for one in self.error.outputs]

    @property
    def _models(self) -> tuple[Model, Model]:
        return self.error.inverse.plant(self.values), self.error.inverse.model(self.values)


def level_slope_of(error: OutputError, values: Mapping[str, float]) -> np.ndarray:
    """Return by how much the signal of each sample rises with the level of friction, shape (sample,)."""
    nudged = scaled(error.unknowns.component, values, 1.0 + NUDGE)
    return np.nan_to_num((error.simulated(nudged) - error.simulated(values)) / NUDGE)


def moves_of(error: OutputError) -> Groups:
    """Return the samples of each half-cycle of the logs, trembles and steps of the encoder left out."""
    regression, parts, before = error.inverse.regression, [], 0
    least = max(STEPS * regression.resolution, DEVIATIONS * regression.noise)
    for one in error.outputs:
        steps = np.sign(np.diff(one.position, prepend=one.position[0]))
        moving = np.flatnonzero(steps)
        turned = moving[1:][steps[moving[1:]] != steps[moving[:-1]]]
        # A sample whose step goes the other way comes after the turn.
        starts = [0, *turns_of(one.position, (turned - 1).tolist(), least)]
        parts.append(before + np.searchsorted(starts, np.arange(one.position.size), side="right") - 1)
        before += len(starts)
    return Groups(np.concatenate(parts))
