"""Closed loop of a log: the effort of its controller on a plant with friction, along the reference."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Axis, Diagnostic, InputError, Status
from bristle.core.contracts import NOT_KNOWN, Model, Reference
from bristle.core.experiment import substeps_for
from bristle.core.packing import pack
from bristle.engine import LoopTrace, Trace, run_closed_loop, run_open_loop, settled
from bristle.engine.loop import begun
from bristle.engine.loop_derivatives import Sensitive, closed_loop_with_derivatives
from bristle.logs.log import Log
from bristle.models.controllers.limits import within_drive
from bristle.models.plants.terms import effort_of_columns
from bristle.models.sensors import encoder
from bristle.simulation.recorded.open_loop import finer, open_loop_of

START_SAMPLES = 20  # over which the initial velocity is estimated


@dataclass(frozen=True)
class Beginning:
    """Motion at a sample: position [m or rad], velocity and acceleration."""

    x: float
    v: float = 0.0
    acceleration: float = 0.0
    moves: bool = False

    def state(self, friction: Model) -> dict[str, Any]:
        """Return position, velocity, and the state of a friction model in steady motion."""
        if not self.moves:
            return {"x": self.x, "v": 0.0}
        state, memory = settled(friction, self.v)
        return {"x": self.x, "v": self.v, "state": state, "memory": memory}


def beginning_of(log: Log, first: int, resolution: float | None) -> Beginning:
    """Return the motion at a sample of a log."""
    # Velocity and acceleration come from a cubic through as few samples as move by a hundred counts of the encoder: a single
    # difference has an error of a count per sample, and many samples would smooth the start of a motion.
    dt = log.sample_time
    x = float(log.position.values[first])
    for count in range(8, 2 * START_SAMPLES + 1):
        low = max(first - count // 2, 0)
        position = log.position.values[low : low + count]
        if np.ptp(position) >= 100.0 * (resolution or 0.0) > 0.0:
            break
    else:
        low = max(first - START_SAMPLES, 0)
        position = log.position.values[low : low + 2 * START_SAMPLES + 1]
    if np.ptp(position) <= 1.5 * (resolution or 0.0):
        return Beginning(x)
    t = dt * (np.arange(position.size) + low - first)
    *_, half_acceleration, velocity, _ = (
        float(coefficient) for coefficient in np.polyfit(t, position - x, 3)
    )
    return Beginning(x, velocity, 2.0 * half_acceleration, moves=True)


@dataclass(frozen=True)
class ClosedLoop:
    """A stretch of a log with its controller, ready to run with any model."""

    controller: Model
    desired: np.ndarray
    injected: np.ndarray
    sample_time: float
    beginning: Beginning
    limit: float
    resolution: float
    lag: float = 0.0
    effort_before: float = 0.0
    resumed_effort: float | None = None

    @property
    def count(self) -> int:
        """Samples of the stretch."""
        return self.desired.shape[1]

    def moved_by(self, distance: float) -> ClosedLoop:
        """Return the loop at another position of the axis [m or rad], with other steps of its encoder."""
        desired = self.desired.copy()
        desired[0] += distance
        return replace(
            self, desired=desired, beginning=replace(self.beginning, x=self.beginning.x + distance)
        )

    def run(
        self,
        plant: Model,
        friction: Model,
        sensor: Model | None = None,
        *,
        lag: float | None = None,
        disturbance: np.ndarray | None = None,
    ) -> LoopTrace:
        """Run the loop, by default with its encoder and the lag of its drive."""
        if sensor is None:
            sensor = encoder(kind=plant.kind, resolution=self.resolution)
        if lag is None:
            lag = self.lag
        return run_closed_loop(
            plant,
            friction,
            self.controller,
            sensor,
            self.desired,
            self.sample_time,
            steps=substeps_for(self.sample_time),
            injected=self.injected,
            disturbance=disturbance,
            limit=self.limit,
            lag=lag,
            effort_before=self.effort_before,
            resumed_effort=self.resumed_effort,
            acceleration=self.beginning.acceleration,
            **self.beginning.state(friction),
        )

    def begun(self, friction: Model) -> tuple[np.ndarray, np.ndarray]:
        """Return the packed initial state and the memory of friction."""
        start = self.beginning.state(friction)
        component = friction.component
        p = friction.parameters
        return pack(start.get("state", component.initial_state(p))), start.get(
            "memory", component.new_memory(p)
        )

    def with_derivatives(
        self, plant: Sensitive, friction: Sensitive, lag: float | None, lag_tangents: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the effort of the controller with a perfect encoder, and its derivatives, shape (sample, direction)."""
        if lag is None:
            lag = self.lag
        start = self.beginning
        motion = start.x, start.v, start.acceleration
        law_state = begun(
            self.controller,
            Reference(*self.desired[:, 0]),
            *motion,
            self.resumed_effort,
            self.sample_time,
        )
        start_of_contact = {
            name: part
            for name, part in start.state(friction.model).items()
            if name in ("state", "memory")
        }
        return closed_loop_with_derivatives(
            plant,
            friction._replace(**start_of_contact),
            self.controller,
            law_state,
            self.desired,
            self.injected,
            np.zeros(self.count),
            dt=self.sample_time,
            steps=substeps_for(self.sample_time),
            limit=self.limit,
            effort_before=self.effort_before,
            lag=lag,
            lag_tangents=lag_tangents,
            x=start.x,
            v=start.v if start.moves else 0.0,
        )


def resumed_effort_at(
    controller: Model, desired: np.ndarray, log: Log, first: int, beginning: Beginning
) -> float | None:
    """Return the effort of a controller at a sample of a log, including its integral, without known inputs added behind it."""
    # It is the mean difference of the recorded effort and that of the law along the log with an empty integral.
    if log.effort is None:
        return None
    component = controller.component
    p = controller.parameters
    dt = log.sample_time
    part = slice(first, first + min(START_SAMPLES, desired.shape[1]))
    law = component.start(beginning.x, beginning.v, beginning.acceleration, dt, p)
    if component.resume is not None:
        law = component.resume(law, Reference(*desired[:, 0]), beginning.x, NOT_KNOWN, dt, p)
    efforts = []
    for sample, measured in zip(
        desired[:, :START_SAMPLES].T.tolist(), log.position.values[part].tolist(), strict=False
    ):
        effort, law = component.step(law, Reference(*sample), measured, dt, p)
        efforts.append(effort)
    return efforts[0] + float(
        np.mean(log.effort.values[part] - log.injected_effort[part] - np.array(efforts))
    )


def desired_of(reference: np.ndarray, dt: float) -> np.ndarray:
    """Return position, velocity and acceleration of a recorded reference, with zero feedforward."""
    velocity = np.gradient(reference, dt)
    return np.stack([reference, velocity, np.gradient(velocity, dt), np.zeros(reference.size)])


def closed_loop_of(
    log: Log,
    axis: Axis,
    part: slice,
    purpose: str = "to predict the closed loop",
    instead: str = "use --mode inverse",
) -> ClosedLoop:
    """Return the closed loop of a stretch of a log."""
    if not isinstance(axis.controller, Model):
        raise InputError(
            f"is needed {purpose}",
            path="axis.controller",
            mend=f"Describe the controller of the recorded axis under [controller] of the axis file, or {instead}",
        )
    if log.reference is None:
        raise InputError(
            "has no reference to follow",
            path="log",
            mend=f"Name the column of the reference under [columns] of the axis file, or {instead}",
        )
    desired = desired_of(log.reference.values[part], log.sample_time)
    limit = axis.effort_limit or math.inf
    first = part.indices(len(log))[0]
    injected = log.injected_effort[part]
    law = within_drive(axis.controller, limit, injected)
    beginning = beginning_of(log, first, axis.resolution)
    effort_before = 0.0
    if log.effort is not None:
        effort_before = float(log.effort.values[first])
    return ClosedLoop(
        law,
        desired,
        injected,
        log.sample_time,
        beginning,
        limit,
        axis.resolution or 0.0,
        axis.lag,
        effort_before,
        resumed_effort_at(law, desired, log, first, beginning),
    )


LOOPS = ("closed-loop", "open-loop")


class Course(NamedTuple):
    """Simulation of a stretch of a log: position [m or rad] and effort [N or N*m], cut short if it diverged."""

    position: np.ndarray
    command: np.ndarray
    status: Status
    diagnostics: tuple[Diagnostic, ...] = ()

    @classmethod
    def of(cls, trace: Trace) -> Course:
        """Return the course of a simulation."""
        return cls(trace.measured, trace.command, trace.status)


def can_be_simulated(log: Log, axis: Axis, loop: str) -> bool:
    """Return whether a log and its axis have the data to simulate a loop."""
    if log.effort is None:
        return False
    return loop == "open-loop" or (isinstance(axis.controller, Model) and log.reference is not None)


@dataclass(frozen=True)
class Stretch:
    """Samples of a log of an axis, simulated in a loop, ``closed-loop`` or ``open-loop``."""

    log: Log
    axis: Axis
    loop: str
    samples: slice

    @classmethod
    def of(cls, log: Log, axis: Axis, loop: str, part: slice) -> Stretch:
        """Return the simulated part of a log: from the first known velocity or from rest."""
        first, last, _ = part.indices(len(log))
        if loop == "open-loop" and not axis.at_rest:
            first += START_SAMPLES
        return cls(log, axis, loop, slice(first, last))

    @property
    def count(self) -> int:
        """Number of samples; negative if the part is shorter than its left-out start."""
        return self.samples.stop - self.samples.start

    @property
    def position(self) -> np.ndarray:
        """Measured position [m or rad], shape (sample,)."""
        return self.log.position.values[self.samples]

    def run(self, plant: Model, friction: Model, unseen: np.ndarray) -> Course:
        """Return the simulation with a mechanism, and a force against the effort [N or N*m], shape (sample,)."""
        beside = effort_of_columns(
            plant, [column.values[self.samples] for column in self.log.regressors]
        )
        if beside is not None:
            unseen = unseen + beside
        if self.loop == "closed-loop":
            return Course.of(
                closed_loop_of(self.log, self.axis, self.samples).run(
                    plant, friction, disturbance=unseen
                )
            )
        assert self.log.effort is not None
        command = self.log.effort.values[self.samples]
        if self.axis.at_rest:
            loop = open_loop_of(self.log, self.axis, self.samples)
            position, status = loop.position(plant, friction, unseen)
            return Course(position[np.isfinite(position)], command, status, (loop.diagnostic,))
        start = beginning_of(self.log, self.samples.start, self.axis.resolution).state(friction)
        effort = command - unseen
        dt = self.log.sample_time
        steps = substeps_for(self.log.sample_time)
        if self.axis.hold != "band_limited":
            return Course.of(
                run_open_loop(
                    plant, friction, effort, dt, steps=steps, hold=self.axis.hold or "zero", **start
                )
            )
        trace = run_open_loop(
            plant,
            friction,
            finer(effort, steps, periodic=False),
            dt / steps,
            hold="linear",
            **start,
        )
        return Course(trace.position[::steps], effort, trace.status)
