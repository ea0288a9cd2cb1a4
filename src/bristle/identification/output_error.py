r"""Output error: the parameters that make the simulated motion the measured one.

.. math:: \hat\theta = \arg\min_\theta \sum_k \left[q_k - \hat q_k(u, \theta)\right]^2

The position is never differentiated, so its noise does not bias the parameters as it does in inverse dynamics; but the
sum has many minima. Inverse dynamics finds the start, coarse steps the way from there, fine steps the end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.interruption import obey
from bristle.identification.open_loop import FINE, OpenLoop, open_loop_of
from bristle.identification.problem import Problem
from bristle.identification.result import HeldOut
from bristle.identification.search import Report, Search, silent
from bristle.identification.solution import Solution
from bristle.identification.unknowns import Scales, Unknowns
from bristle.logs.log import Log
from bristle.simulation.result import relative_error_percent

__all__ = ["OutputError", "held_out_position", "one_period", "refined"]

COARSE = 4  # steps for one sample, on the way
AWAY = 0.3  # standard deviation of the logarithm by which further starts are away from the first
FURTHER_STARTS = 2
ALIKE = 1.05  # ratio of the sums of squares of two starts that end in one minimum
COARSE_EVALUATIONS, AWAY_EVALUATIONS, FINE_EVALUATIONS = 40, 15, 12
SEED = 7_110_601


@dataclass(frozen=True)
class OutputError:
    """The error of the position as a least-squares problem.

    Parameters
    ----------
    inverse : Problem
        The same model as inverse dynamics; it knows what is free and what is held.
    loops : tuple of OpenLoop
        The stretches of the logs.
    measured : ndarray, shape (sample,)
        Their position [m or rad].
    """

    inverse: Problem
    loops: tuple[OpenLoop, ...]
    measured: np.ndarray

    @classmethod
    def of(cls, inverse: Problem, logs: Sequence[Log], axes: Sequence[Axis | None], steps: int) -> OutputError:
        """Return the problem of several logs, integrated with so many steps for one sample."""
        loops, measured = [], []
        for log, axis in zip(logs, axes, strict=True):
            for part in log.segments or (slice(0, len(log)),):
                loops.append(open_loop_of(log, axis or Axis(kind=log.kind), part, steps))
                measured.append(log.position.values[part])
        return cls(inverse, tuple(loops), np.concatenate(measured))

    @property
    def unknowns(self) -> Unknowns:
        """What is free and what is held."""
        return self.inverse.unknowns

    @property
    def phase(self) -> np.ndarray:
        """How far each sample is on its way through its period or its log, from 0 to 1."""
        found = []
        for loop in self.loops:
            period = loop.effort.size // loop.steps
            found.append(np.arange(loop.count) % period / period)
        return np.concatenate(found)

    @property
    def log_of_sample(self) -> np.ndarray:
        """Which stretch each sample is from."""
        return np.repeat(np.arange(len(self.loops)), [loop.count for loop in self.loops])

    @property
    def norm(self) -> float:
        """Root of the sum of squares of the position [m or rad]."""
        return float(np.linalg.norm(self.measured))

    @property
    def magnitude(self) -> float:
        """Typical magnitude of the position [m or rad]."""
        return float(np.std(self.measured))

    def near(self, free: Mapping[str, float]) -> OutputError:
        """Return the problem itself: its simulations begin where the log says."""
        return self

    def without_found(self, columns: np.ndarray, free: Mapping[str, float], rows: np.ndarray | slice) -> np.ndarray:
        """Return the derivatives as they are: nothing is found on the way."""
        return columns

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus simulated position of each sample [m or rad], from the free parameters."""
        values = self.unknowns.complete(free)
        plant, friction = self.inverse.plant(values), self.inverse.model(values)
        return self.measured - np.concatenate([loop.position(plant, friction)[0] for loop in self.loops])


def refined(
    inverse: Problem, start: Solution, logs: Sequence[Log], axes: Sequence[Axis | None], scales: Scales,
    guess: Mapping[str, float], report: Report = silent,
) -> tuple[Solution, Search, Search]:  # fmt: skip
    """Return the solution of least output error, the search that found it, and a coarser one.

    Parameters
    ----------
    inverse, start : Problem, Solution
        Inverse dynamics, and its solution.
    logs, axes : sequence of Log, of Axis or None
        The logs.
    scales, guess : Scales, mapping
        As for the search of inverse dynamics.
    report : callable
        Is told the share of the work done.
    """
    coarse = OutputError.of(inverse, logs, axes, COARSE)
    search = Search(coarse, scales, guess, coarse.magnitude)
    rng = np.random.default_rng(SEED)
    best, interrupted = start, False
    try:
        best = search.refit(start.values, limit=COARSE_EVALUATIONS)
        for number in range(FURTHER_STARTS):
            report((number + 1.0) / (FURTHER_STARTS + 2.0), f"best so far {search.percent(best.cost):.3g} %")
            away = {name: value * float(np.exp(rng.normal(0.0, AWAY))) for name, value in best.values.items()}
            found = search.refit(away, limit=AWAY_EVALUATIONS)
            best = min((best, found), key=lambda one: one.cost)
    except KeyboardInterrupt as error:
        obey(error, anything=best is not start)
        interrupted = True
    report((FURTHER_STARTS + 1.0) / (FURTHER_STARTS + 2.0), f"best so far {search.percent(best.cost):.3g} %")
    fine = Search(OutputError.of(inverse, logs, axes, FINE), scales, guess, coarse.magnitude)
    last = fine.refit(best.values, limit=1 if interrupted else FINE_EVALUATIONS)
    return replace(last, unfinished=interrupted), fine, search


def held_out_position(search: Search, start: Mapping[str, float], blocks: int) -> HeldOut:
    """Return the error of the position on what was not fitted: on each of several logs, else parts of one.

    The parts of a record that repeats itself are parts of its period: another period would only be the same again.
    """
    problem = search.problem
    assert isinstance(problem, OutputError)
    if len(problem.loops) > 1:
        which, count, of = problem.log_of_sample, len(problem.loops), "logs"
    else:
        which, count, of = np.floor(problem.phase * blocks).astype(int), blocks, "time blocks"
    errors = []
    for number in range(count):
        left = which == number
        values = search.refit(start, ~left, FINE_EVALUATIONS).values
        measured = problem.measured[left]
        errors.append(relative_error_percent(measured, measured - problem.residual(values)[left]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), of)


def one_period(log: Log, axis: Axis | None) -> Log:
    """Return a log without what only repeats its first period, for a start."""
    whole = log.segments or (slice(0, len(log)),)
    loops = [open_loop_of(log, axis or Axis(kind=log.kind), part, 1) for part in whole]
    cut = [
        slice(part.start or 0, (part.start or 0) + loop.effort.size) if loop.periodic else part
        for part, loop in zip(whole, loops, strict=True)
    ]
    return replace(log, segments=tuple(cut))
