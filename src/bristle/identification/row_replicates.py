"""Replicates of a log: what the same axis would have recorded, had the fitted model been the truth.

The motion is that of the log. On it act the friction of the model, whose level scatters from reversal to reversal, and
the inertia; the effort is read with noise, the position through the axis's own encoder, of which nobody knows where its
steps lie. What the filters, the encoder and the scatter do to an estimate, they do to one from a replicate alike. What
the model leaves over beyond that is added again block by block, each with a sign drawn by chance (wild bootstrap [1]_).

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
from bristle.identification.dataset import Dataset, Segment, low_passed, mechanical
from bristle.identification.disturbance import signs_of
from bristle.identification.friction_scale import FrictionScale
from bristle.identification.half_cycles import HalfCycles
from bristle.identification.preprocessing import treat
from bristle.identification.problem import Disturbance
from bristle.logs.log import Channel, Log

if TYPE_CHECKING:
    from bristle.identification.inverse_dynamics import InverseDynamics

__all__ = ["RowReplicates"]


@dataclass(frozen=True)
class RowReplicates:
    """A fitted model and the motion that it is run on again.

    Parameters
    ----------
    problem : InverseDynamics
        What was fitted.
    values : mapping
        All parameters [SI].
    disturbance : Disturbance
        Scatter, noise and encoder.
    """

    problem: InverseDynamics
    values: Mapping[str, float]
    disturbance: Disturbance

    def disturbed(self, **changes: float) -> RowReplicates:
        """Return the same with another disturbance."""
        return replace(self, disturbance=self.disturbance._replace(**changes))

    def draw(self, rng: np.random.Generator, ratio: float = 1.0, side: float = 1.0) -> InverseDynamics:
        """Return the same problem on a log that is drawn anew.

        Parameters
        ----------
        rng : Generator
            Draws it.
        ratio : float
            By how much the scatter is another than the estimated one.
        side : {1.0, -1.0}
            The mirror image of a log has all its disturbances reversed.
        """
        dataset = self.problem.dataset
        log = self.log(rng, ratio, side)
        axis = Axis(kind=dataset.kind, resolution=dataset.resolution)
        again = treat(log, axis, dataset.cutoff, dataset.decimation, like=dataset)
        segments = tuple(
            replace(one, load=old.load, temperature=old.temperature, first_cycle=old.first_cycle, log=old.log)
            for one, old in zip(again.segments, dataset.segments, strict=True)
        )
        return replace(self.problem, dataset=replace(again, segments=segments))

    def log(self, rng: np.random.Generator, ratio: float = 1.0, side: float = 1.0) -> Log:
        """Return a log that is drawn anew: the segments of the motion, one after the other."""
        dataset, disturbance = self.problem.dataset, self.disturbance
        scatter, noise, jitter = (
            side * one for one in (ratio * disturbance.scatter, disturbance.noise, disturbance.jitter)
        )
        efforts, positions, segments, first = [], [], [], 0
        for segment, starts, left in zip(self._motion, self._starts, self._left, strict=True):
            force = self._levels.force(segment, starts, dataset.sample_time, scatter, rng)
            pure = force + mechanical(self._plant, segment.position, segment.velocity, segment.acceleration)
            pure += side * disturbance.unexplained * signs_of(pure.size, rng) * left
            efforts.append(pure + noise * rng.standard_normal(pure.size))
            positions.append(segment.position + jitter * rng.standard_normal(pure.size))
            segments.append(slice(first, first + pure.size))
            first += pure.size
        position, step = np.concatenate(positions), disturbance.resolution
        if step > 0.0:
            phase = side * rng.uniform(0.0, step)
            position = step * np.round((position + phase) / step) - phase
        unit = {"translational": ("m", "N"), "rotational": ("rad", "N*m")}[dataset.kind]
        return Log(
            time=Channel(self._time, "s", "time"),
            position=Channel(position, unit[0], "position"),
            effort=Channel(np.concatenate(efforts), unit[1], "effort"),
            sample_time=dataset.sample_time,
            segments=tuple(segments),
            kind=dataset.kind,
        )

    @cached_property
    def _starts(self) -> tuple[tuple[int, ...], ...]:
        return HalfCycles(self.problem.dataset).starts

    @cached_property
    def _motion(self) -> tuple[Segment, ...]:
        """The motion of the log, with what the filter took from its corners put back once."""
        return tuple(_sharpened(one, self.problem.dataset) for one in self.problem.dataset.segments)

    @cached_property
    def _left(self) -> tuple[np.ndarray, ...]:
        """What the model leaves over along each segment [N or N*m]."""
        explained = self.problem.dataset.explained(self._plant, self.problem.model(self.values))
        return tuple(one.effort - part for one, part in zip(self.problem.dataset.segments, explained, strict=True))

    @cached_property
    def _plant(self) -> Model:
        return self.problem.plant(self.values)

    @cached_property
    def _time(self) -> np.ndarray:
        return np.concatenate([one.time for one in self.problem.dataset.segments])

    @cached_property
    def _levels(self) -> FrictionScale:
        return FrictionScale(self.problem.parameters.component, self.values, self.problem.dataset.kind)


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
