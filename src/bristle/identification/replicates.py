"""Replicates of a log: what the same axis would have recorded, had the fitted model been the truth.

On the motion of the log act the friction of the model, whose level scatters from reversal to reversal, and the inertia;
the effort is read with noise, the position through the axis's own encoder, of which nobody knows where its steps lie.
What the filters, the encoder and the scatter do to an estimate, they do to one from a replicate alike. What the model
leaves over beyond that is added again block by block, each with a sign drawn by chance (wild bootstrap [1]_).

Of a simulation, all that disturbs a log is small beside its signal, so each cause changes the signal by itself: the
encoder as far as it shows in the loop, the level of friction, and what the model leaves over.

References
----------
.. [1] A. C. Cameron, J. B. Gelbach, D. L. Miller, "Bootstrap-based improvements for inference with clustered errors",
   Review of Economics and Statistics 90(3), 2008. doi:10.1162/rest.90.3.414
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.core.variable import unit_of
from bristle.identification.dataset import Dataset, Segment, low_passed, mechanical
from bristle.identification.disturbance import Disturbance, force_with_scatter, signs
from bristle.identification.half_cycles import half_cycle_starts
from bristle.identification.outputs import Reading
from bristle.identification.preprocessing import treat
from bristle.logs.log import Channel, Log

if TYPE_CHECKING:
    from bristle.identification.inverse_dynamics import InverseDynamics
    from bristle.identification.output_error import OutputError

__all__ = ["RowReplicates", "SignalReplicates"]

FAR = 1e12  # of a signal that left the finite numbers


@dataclass(frozen=True)
class RowReplicates:
    """Replicates of the rows of inverse dynamics: `problem` as it was fitted, and all its parameters `values` [SI]."""

    problem: InverseDynamics
    values: Mapping[str, float]

    def draw(self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0) -> InverseDynamics:
        """Return the same problem on a log drawn anew, or on its mirror image (-1)."""
        dataset, log = self.problem.dataset, self.log(disturbance, rng, side)
        axis = Axis(kind=dataset.kind, resolution=dataset.resolution)
        drawn = treat(log, axis, dataset.cutoff, dataset.decimation, like=dataset)
        segments = tuple(
            replace(new, load=old.load, temperature=old.temperature, first_cycle=old.first_cycle, log=old.log)
            for new, old in zip(drawn.segments, dataset.segments, strict=True)
        )
        return replace(self.problem, dataset=replace(drawn, segments=segments))

    def log(self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0) -> Log:
        """Return a log drawn anew: the segments of the motion, one after the other."""
        dataset = self.problem.dataset
        scatter, noise, jitter = (side * size for size in (disturbance.scatter, disturbance.noise, disturbance.jitter))
        efforts, positions, segments, first = [], [], [], 0
        for segment, starts, residual in zip(self._motion, self._starts, self._residual, strict=True):
            pure = force_with_scatter(self._friction, segment, starts, dataset.sample_time, scatter, rng)
            pure += mechanical(self._plant, segment)
            pure += side * disturbance.unexplained * signs(pure.size, rng) * residual
            efforts.append(pure + noise * rng.standard_normal(pure.size))
            positions.append(segment.position + jitter * rng.standard_normal(pure.size))
            segments.append(slice(first, first + pure.size))
            first += pure.size
        position, step = np.concatenate(positions), disturbance.resolution
        if step > 0.0:
            phase = side * rng.uniform(0.0, step)
            position = step * np.round((position + phase) / step) - phase
        length, force = (unit_of(quantity, dataset.kind) for quantity in ("length", "force"))
        return Log(
            time=Channel(np.concatenate([segment.time for segment in dataset.segments]), "s", "time"),
            position=Channel(position, length, "position"),
            effort=Channel(np.concatenate(efforts), force, "effort"),
            sample_time=dataset.sample_time,
            segments=tuple(segments),
            kind=dataset.kind,
        )

    @cached_property
    def _friction(self) -> Model:
        return self.problem.model(self.values)

    @cached_property
    def _plant(self) -> Model:
        return self.problem.plant(self.values)

    @cached_property
    def _starts(self) -> tuple[tuple[int, ...], ...]:
        return half_cycle_starts(self.problem.dataset)

    @cached_property
    def _motion(self) -> tuple[Segment, ...]:
        """The motion of the log, with what the filter took from its corners put back once."""
        return tuple(_sharpened(segment, self.problem.dataset) for segment in self.problem.dataset.segments)

    @cached_property
    def _residual(self) -> tuple[np.ndarray, ...]:
        """What the model leaves over along each segment [N or N*m]."""
        dataset = self.problem.dataset
        explained = dataset.explained(self._plant, self._friction)
        return tuple(segment.effort - effort for segment, effort in zip(dataset.segments, explained, strict=True))


def _sharpened(segment: Segment, dataset: Dataset) -> Segment:
    dt, origin = dataset.sample_time, segment.position[0]
    lost = segment.position - origin - low_passed(segment.position - origin, dataset.cutoff, dt)
    position = segment.position + lost
    velocity = np.gradient(position - origin, dt)
    at_rest = segment.velocity == 0.0
    return replace(
        segment, position=position, velocity=np.where(at_rest, segment.velocity, velocity),
        acceleration=np.gradient(velocity, dt),
    )  # fmt: skip


@dataclass(frozen=True)
class SignalReplicates:
    """Replicates of the signal of a simulation: `error` as it was fitted, and all its parameters `values` [SI].

    `slope` is by how much the signal rises with the level of friction, `left` what the fit left over, shape (sample,).
    """

    error: OutputError
    values: Mapping[str, float]
    slope: np.ndarray
    left: np.ndarray

    def draw(self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0) -> Changed:
        """Return the same fit to a log drawn anew, or to its mirror image (-1)."""
        cycles = self.error.half_cycles
        levels = self._split((disturbance.scatter * rng.standard_normal(cycles.count))[cycles.index])
        reading = Reading(disturbance.resolution, disturbance.jitter)
        pure, changes = [pure for pure, _ in self._pure], []
        for output, (signal, leaning), level, left in zip(
            self.error.outputs, self._pure, levels, self._split(self.left), strict=True
        ):
            change = output.read(*self._models, self.values, signal, level * leaning, reading, rng)
            lacking = disturbance.unexplained * signs(signal.size, rng) * left
            changes.append(np.nan_to_num(change) + lacking)
        return Changed(self, np.concatenate(pure), side * np.concatenate(changes))

    @cached_property
    def _pure(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Signal of each segment without disturbance, and what a level of friction that is higher adds to it."""
        return [
            (output.simulated(*self._models, self.values),
             np.nan_to_num(output.leaning(*self._models, self.values, slope)))
            for output, slope in zip(self.error.outputs, self._split(self.slope), strict=True)
        ]  # fmt: skip

    def _split(self, signal: np.ndarray) -> list[np.ndarray]:
        """Return the samples of each segment."""
        return np.split(signal, np.cumsum([output.measured.size for output in self.error.outputs])[:-1])

    @property
    def _models(self) -> tuple[Model, Model]:
        return self.error.inverse.plant(self.values), self.error.inverse.model(self.values)


@dataclass(frozen=True)
class Changed:
    """The same fit to its own signal with a change, shape (sample,)."""

    replicates: SignalReplicates
    pure: np.ndarray
    change: np.ndarray

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return what these parameters leave of the changed signal; at the solution of the fit it is the change."""
        error, values = self.replicates.error, self.replicates.values
        if all(free[name] == values[name] for name in error.parameters.free):
            return self.change
        simulated = error.simulated(error.parameters.complete(free))
        return self.pure + self.change - np.where(np.isfinite(simulated), simulated, FAR)
