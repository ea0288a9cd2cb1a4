"""The twin of a log: what the same axis would have recorded, had the fitted model been the truth.

The motion is that of the log. On it act the friction of the model, whose level scatters from reversal to reversal, and
the inertia; the effort is read with noise, the position through the axis's own encoder, of which nobody knows where its
steps lie. What the filters, the encoder and the scatter do to an estimate, they do to one from a twin alike. What the
model leaves over beyond all that is added again block by block, each with a sign drawn by chance (wild bootstrap [1]_).

References
----------
.. [1] A. C. Cameron, J. B. Gelbach, D. L. Miller, "Bootstrap-based improvements for inference with clustered errors",
   Review of Economics and Statistics 90(3), 2008. doi:10.1162/rest.90.3.414
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.lazy import cached_property
from bristle.identification.dataset import Dataset, Segment, low_passed, mechanical
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.preprocessing import treat
from bristle.identification.resampling.friction_scale import FrictionScale
from bristle.identification.resampling.half_cycles import Groups, HalfCycles
from bristle.logs.log import Channel, Log

__all__ = ["Disturbance", "Replicates", "disturbance_of", "lasting_of", "signs_of"]

ROUNDING = 0.37  # of an encoder step: what the robust measure of noise says of rounding alone
BLOCKS = 40  # of a segment, in which what the model lacks keeps its sign


@dataclass(frozen=True)
class Disturbance:
    """What keeps two logs of one motion from being the same.

    Parameters
    ----------
    scatter : float
        Standard deviation of the scale of friction from reversal to reversal, as a share of it.
    noise : float
        Standard deviation of the noise of the effort, sample by sample [N or N*m].
    resolution : float
        Step of the position encoder [m or rad].
    jitter : float
        Standard deviation of the noise of the position besides [m or rad].
    unexplained : float
        Share of the residual, in amplitude, that is none of these: what the model lacks.
    """

    scatter: float
    noise: float
    resolution: float
    jitter: float = 0.0
    unexplained: float = 0.0


def disturbance_of(dataset: Dataset, scatter: float) -> Disturbance:
    """Return what disturbs a log: its encoder, its noise, and a scatter that is known from elsewhere."""
    # Rounding alone looks like noise, too.
    jitter = max(dataset.noise**2 - (ROUNDING * dataset.resolution) ** 2, 0.0) ** 0.5
    return Disturbance(scatter, dataset.effort_noise, dataset.resolution, jitter)


@dataclass(frozen=True)
class Replicates:
    """A fitted model and the motion that it is run on again.

    Parameters
    ----------
    problem : InverseDynamics
        What was fitted.
    cycles : HalfCycles
        Half-cycles of its log.
    values : mapping
        All parameters [SI].
    disturbance : Disturbance
        Scatter, noise and encoder.
    """

    problem: InverseDynamics
    cycles: HalfCycles
    values: Mapping[str, float]
    disturbance: Disturbance

    @property
    def groups(self) -> Groups:
        """The rows of each half-cycle."""
        return self.cycles.groups

    def disturbed(self, **changes: float) -> Replicates:
        """Return the same with another disturbance."""
        return replace(self, disturbance=replace(self.disturbance, **changes))

    def drawn(self, rng: np.random.Generator, ratio: float = 1.0, side: float = 1.0) -> InverseDynamics:
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
        for segment, starts, left in zip(self._motion, self.cycles.starts, self._left, strict=True):
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


def signs_of(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return a sign for each of several blocks of samples: what is left over keeps its course, not its side."""
    blocks = np.minimum(np.arange(count) * BLOCKS // count, BLOCKS - 1)
    return rng.choice([-1.0, 1.0], BLOCKS)[blocks]


def lasting_of(residual: np.ndarray, row_time: float, unexplained: float) -> float:
    """Return how long what a model lacks keeps its side [s].

    All that does not average out over a block is put down to it; longer than a block it is not followed.

    Parameters
    ----------
    residual : ndarray, shape (row,)
        What the model leaves over, each half-cycle at its own level.
    row_time : float
        Time from row to row [s].
    unexplained : float
        Root mean square of what the model lacks, in the unit of the residual.
    """
    slow = float(np.mean([np.mean(part) ** 2 for part in np.array_split(residual, BLOCKS)]))
    share = min(slow / unexplained**2, 1.0) if unexplained > 0.0 else 0.0
    return share * row_time * residual.size / BLOCKS


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
