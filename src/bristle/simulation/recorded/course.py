"""What becomes of a stretch of a log in a simulated loop, closed or open, with any mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic
from bristle.core.experiment import substeps_for
from bristle.core.status import Status
from bristle.engine import Trace, run_open_loop
from bristle.friction import is_static, with_presliding
from bristle.logs.log import Log
from bristle.plants.terms import effort_of_columns
from bristle.simulation.recorded.between_samples import finer
from bristle.simulation.recorded.closed_loop import START_SAMPLES, beginning_of, closed_loop_of
from bristle.simulation.recorded.open_loop import open_loop_of

__all__ = ["LOOPS", "Course", "Stretch", "can_be_simulated"]

LOOPS = ("closed-loop", "open-loop")


class Course(NamedTuple):
    """What became of one stretch of a log: position [m or rad] and effort [N or N*m], shorter where it diverged."""

    position: np.ndarray
    command: np.ndarray
    status: Status
    diagnostics: tuple[Diagnostic, ...] = ()

    @classmethod
    def of(cls, trace: Trace) -> Course:
        """Return that of a simulation."""
        return cls(trace.measured, trace.command, trace.status)


def can_be_simulated(log: Log, axis: Axis, loop: str) -> bool:
    """Return whether a log and its axis hold what the simulation of a loop needs."""
    if log.effort is None:
        return False
    return loop == "open-loop" or (isinstance(axis.controller, Model) and log.reference is not None)


@dataclass(frozen=True)
class Stretch:
    """Samples of a log of an axis that are simulated in a loop, ``closed-loop`` or ``open-loop``."""

    log: Log
    axis: Axis
    loop: str
    samples: slice

    @classmethod
    def of(cls, log: Log, axis: Axis, loop: str, part: slice) -> Stretch:
        """Return what of a part of a log is simulated.

        An open loop that does not begin at rest begins where the velocity is known from both sides.
        """
        first, last, _ = part.indices(len(log))
        first += START_SAMPLES if loop == "open-loop" and not axis.at_rest else 0
        return cls(log, axis, loop, slice(first, last))

    @property
    def count(self) -> int:
        """Number of samples; negative where the part is shorter than what is left out of it."""
        return self.samples.stop - self.samples.start

    @property
    def position(self) -> np.ndarray:
        """What was measured [m or rad], shape (sample,)."""
        return self.log.position.values[self.samples]

    def dressed(self, friction: Model) -> Model:
        """Return a friction model as it is simulated: one that turns at once over the distance that the axis tells."""
        static = self.axis.presliding and is_static(friction)
        return with_presliding(friction, self.axis.presliding) if static else friction

    def run(self, plant: Model, friction: Model, unseen: np.ndarray) -> Course:
        """Return what becomes of it with a mechanism, and a force against the effort [N or N*m], shape (sample,)."""
        beside = effort_of_columns(plant, [column.values[self.samples] for column in self.log.regressors])
        unseen = unseen if beside is None else unseen + beside
        run = _closed_loop if self.loop == "closed-loop" else _from_rest if self.axis.at_rest else _open_loop
        return run(self.log, self.axis, self.samples, plant, friction, unseen)


def _closed_loop(log: Log, axis: Axis, part: slice, plant: Model, friction: Model, unseen: np.ndarray) -> Course:
    return Course.of(closed_loop_of(log, axis, part).run(plant, friction, disturbance=unseen))


def _open_loop(log: Log, axis: Axis, part: slice, plant: Model, friction: Model, unseen: np.ndarray) -> Course:
    assert log.effort is not None
    start = beginning_of(log, part.start, axis.resolution).state(friction)
    effort, steps = log.effort.values[part] - unseen, substeps_for(log.sample_time)
    if axis.hold != "band_limited":
        hold = axis.hold or "zero"
        return Course.of(run_open_loop(plant, friction, effort, log.sample_time, steps=steps, hold=hold, **start))
    fine = finer(effort, steps, periodic=False)
    trace = run_open_loop(plant, friction, fine, log.sample_time / steps, steps=1, hold="linear", **start)
    return Course(trace.position[::steps], effort, trace.status)


def _from_rest(log: Log, axis: Axis, part: slice, plant: Model, friction: Model, unseen: np.ndarray) -> Course:
    loop = open_loop_of(log, axis, part)
    position, status = loop.position(plant, friction, unseen)
    assert log.effort is not None
    return Course(position[np.isfinite(position)], log.effort.values[part], status, (loop.diagnostic,))
