"""The signals of a log that a model simulates: the position of an open loop, the effort of a closed one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.packing import pack
from bristle.engine import LoopTrace
from bristle.engine.loop_derivatives import Sensitive
from bristle.identification.half_cycles import Disturbance
from bristle.identification.parameters import offset_of
from bristle.identification.sensitivities import Perturbed
from bristle.logs.log import Log
from bristle.models.friction import with_presliding
from bristle.models.plants.terms import effort_of_columns
from bristle.models.sensors import encoder
from bristle.simulation.recorded.closed_loop import ClosedLoop, closed_loop_of
from bristle.simulation.recorded.open_loop import FINE, OpenLoop, open_loop_of

LAG = "lag"
COARSE = 4  # steps for one sample of an open loop during a search
SEEDS = 2**31


def slices_of(log: Log) -> tuple[slice, ...]:
    """Return the segments of a log; the whole log without segments."""
    return log.segments or (slice(0, len(log)),)


class Mechanism(NamedTuple):
    """A plant with friction, and all parameters of both and of their loop by name [SI]."""

    plant: Model
    friction: Model
    values: Mapping[str, float]


@dataclass(frozen=True)
class Output(ABC):
    """A segment of a log that a model simulates: the `measured` signal and the `position` [m or rad], shape (sample,) each."""

    measured: np.ndarray
    position: np.ndarray
    regressors: tuple[np.ndarray, ...] = field(default=(), kw_only=True)

    signal: ClassVar[str]
    code: ClassVar[str]
    away_evaluations: ClassVar[int]  # of a descent from a further start
    is_refined: ClassVar[bool] = (
        False  # whether a simulation is integrated more finely at the end of a search
    )

    @classmethod
    @abstractmethod
    def of(cls, log: Log, axis: Axis, part: slice, *, fine: bool = False) -> Output:
        """Return a segment of a log, simulated quickly, or finely for the end of a search."""

    @staticmethod
    def excerpt(log: Log, axis: Axis) -> Log:
        """Return the part of a log for the start by inverse dynamics."""
        return log

    @property
    @abstractmethod
    def period(self) -> int:
        """Samples of a period, or of the log."""

    @property
    def phase(self) -> np.ndarray:
        """Phase of each sample in its period or log, from 0 to 1."""
        return np.arange(self.measured.size) % self.period / self.period

    @abstractmethod
    def simulated(self, mechanism: Mechanism) -> np.ndarray:
        """Return the signal of the model, NaN after it diverges, shape (sample,)."""

    @abstractmethod
    def with_derivatives(
        self, plant: Perturbed, friction: Perturbed, lag: float | None, by_lag: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return that signal and its derivatives; `by_lag` is the derivative of the lag by each parameter."""

    @abstractmethod
    def read(
        self,
        mechanism: Mechanism,
        pure: np.ndarray,
        push: np.ndarray,
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> np.ndarray:
        """Return the change of the `pure` signal by a push against the motion and an encoder with a random phase of its steps."""

    @abstractmethod
    def leaning(self, mechanism: Mechanism, slope: np.ndarray) -> np.ndarray:
        """Return the push of `read` for twice the friction, shape (sample,), from the derivative `slope` of the signal by the level."""


@dataclass(frozen=True)
class Position(Output):
    """The position [m or rad] under the recorded effort in open loop."""

    loop: OpenLoop

    signal = "position"
    code = "output_error_open"
    away_evaluations = 15
    is_refined = True

    @classmethod
    def of(cls, log: Log, axis: Axis, part: slice, *, fine: bool = False) -> Position:
        """Return a segment, integrated with a few steps per sample."""
        position = log.position.values[part]
        columns = tuple(column.values[part] for column in log.regressors)
        return cls(
            position,
            position,
            open_loop_of(log, axis, part, FINE if fine else COARSE),
            regressors=columns,
        )

    @staticmethod
    def excerpt(log: Log, axis: Axis) -> Log:
        """Return a log without repetitions of its first period."""
        parts = []
        for part in slices_of(log):
            loop, first = open_loop_of(log, axis, part, 1), part.start or 0
            parts.append(slice(first, first + loop.effort.size) if loop.periodic else part)
        return replace(log, segments=tuple(parts))

    @property
    def period(self) -> int:
        """Samples in a period of the effort."""
        return self.loop.effort.size // self.loop.steps

    def simulated(self, mechanism: Mechanism) -> np.ndarray:
        """Return the position of the model [m or rad]."""
        return self.loop.position(
            *mechanism[:2], effort_of_columns(mechanism.plant, self.regressors)
        )[0]

    def with_derivatives(
        self, plant: Perturbed, friction: Perturbed, lag: float | None, by_lag: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the position [m or rad] with its derivatives."""
        virgin = friction.slopes(lambda near: pack(near.component.initial_state(near.parameters)))
        moving = Sensitive(friction.model, friction.parameters(), state_tangents=virgin)
        return self.loop.with_derivatives(Sensitive(plant.model, plant.parameters()), moving)

    def read(
        self,
        mechanism: Mechanism,
        pure: np.ndarray,
        push: np.ndarray,
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> np.ndarray:
        """Return the change of that position by an encoder and a push, a change of the position [m or rad]."""
        change = push + disturbance.jitter * rng.standard_normal(self.measured.size)
        if disturbance.resolution <= 0.0:
            return change
        phase = rng.uniform(0.0, disturbance.resolution)
        return (
            disturbance.resolution * np.round((pure + change + phase) / disturbance.resolution)
            - phase
            - pure
        )

    def leaning(self, mechanism: Mechanism, slope: np.ndarray) -> np.ndarray:
        """Return the slope as a change of the position [m or rad], without a new simulation."""
        return slope


@dataclass(frozen=True)
class Effort(Output):
    """The effort [N or N*m] of the controller in closed loop, always integrated finely.

    The simulation has a perfect encoder: encoder steps would be additional noise, and the signal would have no derivative.
    """

    loop: ClosedLoop
    presliding: float = 0.0

    signal = "loop"
    code = "output_error_closed"
    away_evaluations = 5  # the controller keeps a closed loop near its minimum

    @classmethod
    def of(cls, log: Log, axis: Axis, part: slice, *, fine: bool = False) -> Effort:
        """Return a segment."""
        assert log.effort is not None
        loop = closed_loop_of(
            log, axis, part, "to fit the closed loop", 'write loop = "open" under [identification]'
        )
        columns = tuple(column.values[part] for column in log.regressors)
        return cls(
            log.effort.values[part],
            log.position.values[part],
            loop,
            axis.presliding or 0.0,
            regressors=columns,
        )

    @property
    def period(self) -> int:
        """All samples: a log in closed loop counts as a single period."""
        return self.loop.count

    def simulated(self, mechanism: Mechanism) -> np.ndarray:
        """Return the effort of the controller [N or N*m]."""
        return self._whole(self._run(mechanism).command)

    def with_derivatives(
        self, plant: Perturbed, friction: Perturbed, lag: float | None, by_lag: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return that effort [N or N*m] with its derivatives."""

        def turned(near: Model) -> Model:
            return with_presliding(near, self.presliding)

        def begun(near: Model) -> np.ndarray:
            return np.concatenate(self.loop.begun(turned(near)))

        states = self.loop.begun(turned(friction.model))[0].size
        by_state, by_memory = np.split(friction.slopes(begun), [states])
        parameters = friction.slopes(lambda near: pack(turned(near).parameters))
        moving = Sensitive(
            turned(friction.model), parameters, state_tangents=by_state, memory_tangents=by_memory
        )
        return self.loop.with_derivatives(
            Sensitive(plant.model, plant.parameters()), moving, lag, by_lag
        )

    def read(
        self,
        mechanism: Mechanism,
        pure: np.ndarray,
        push: np.ndarray,
        disturbance: Disturbance,
        rng: np.random.Generator,
    ) -> np.ndarray:
        """Return the change of that effort by both [N or N*m]; the controller sees the position through the encoder."""
        moved = self.loop.moved_by(rng.uniform(0.0, disturbance.resolution))
        seed = int(rng.integers(SEEDS))
        sensor = encoder(
            kind=mechanism.plant.kind,
            resolution=disturbance.resolution,
            noise=disturbance.jitter,
            seed=seed,
        )
        return self._whole(self._run(mechanism, moved, sensor, push).command) - pure

    def leaning(self, mechanism: Mechanism, slope: np.ndarray) -> np.ndarray:
        """Return the friction force in the loop [N or N*m], without its constant part.

        While the body sticks, this is the static friction: with a higher level it breaks away later.
        """
        return self._whole(
            self._run(mechanism).friction
            - offset_of(mechanism.friction.component.variables, mechanism.values)
        )

    def _run(
        self,
        mechanism: Mechanism,
        loop: ClosedLoop | None = None,
        sensor: Model | None = None,
        push: np.ndarray | None = None,
    ) -> LoopTrace:
        """Run this loop or another loop, by default with a perfect encoder."""
        plant, friction, values = mechanism
        beside = effort_of_columns(plant, self.regressors)
        if beside is not None:
            push = beside if push is None else push + beside
        sensor, friction = (
            sensor or encoder(kind=plant.kind, resolution=0.0),
            with_presliding(friction, self.presliding),
        )
        return (loop or self.loop).run(
            plant, friction, sensor, lag=values.get(LAG), disturbance=push
        )

    def _whole(self, signal: np.ndarray) -> np.ndarray:
        """Return a signal of all samples, NaN after the loop diverged."""
        return np.concatenate([signal, np.full(self.loop.count - signal.size, np.nan)])
