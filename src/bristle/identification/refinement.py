"""From the solution of inverse dynamics to that of least output error: several starts, or a look at the whole range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.axis import Axis
from bristle.core.interruption import BestSoFar, obey
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.output_error import COARSE, OutputError
from bristle.identification.outputs import LAG
from bristle.identification.parameters import Scales
from bristle.identification.resampling.refit import Refit, Space
from bristle.identification.result import HeldOut
from bristle.identification.search import Report, Search, silent
from bristle.identification.solution import Solution
from bristle.identification.time_blocks import TIME
from bristle.logs.log import Log
from bristle.simulation.recorded.open_loop import FINE
from bristle.simulation.result import relative_error_percent

__all__ = ["Refinement", "held_out_output"]

AWAY = 0.3  # standard deviation of the logarithm by which further starts are away from the first
FURTHER_STARTS = 2
COARSE_EVALUATIONS, FINE_EVALUATIONS = 40, 12
AWAY_EVALUATIONS = {"open": 15, "closed": 5}  # the controller keeps a closed loop near its minimum
LAG_AT_FIRST = 0.2  # samples
EVERYWHERE = 0.7  # of the work, where the whole range is looked at
SEED = 7_110_601


@dataclass(frozen=True)
class Refinement:
    """The search for the parameters of least output error.

    Parameters
    ----------
    logs, axes : sequence of Log, of Axis or None
        The logs.
    loop : {"open", "closed"}
        What is simulated.
    scales, guess : Scales, mapping
        As for the search of inverse dynamics.
    everywhere : bool
        Whether the whole range of each parameter is looked at first.
    """

    logs: Sequence[Log]
    axes: Sequence[Axis | None]
    loop: str
    scales: Scales
    guess: Mapping[str, float]
    everywhere: bool = False

    def of(self, inverse: InverseDynamics, start: Solution, report: Report = silent) -> tuple[Solution, OutputError]:
        """Return the solution of least output error, and the problem it solves.

        Parameters
        ----------
        inverse, start : InverseDynamics, Solution
            Inverse dynamics, and its solution.
        report : callable
            Is told the share of the work done.
        """
        coarse = self._search(inverse, COARSE)
        first = self._at_first(start.values)
        solution = self._searched(coarse, first, report)
        if self.loop == "closed":
            # It is integrated as finely all the way.
            return solution, _problem(coarse)
        fine = self._search(inverse, FINE)
        last = fine.refit(solution.values, limit=1 if solution.unfinished else FINE_EVALUATIONS)
        return replace(last, unfinished=solution.unfinished), _problem(fine)

    def _search(self, inverse: InverseDynamics, steps: int) -> Search:
        error = OutputError.of(inverse, self.logs, self.axes, self.loop, steps)
        return Search(error, self.scales, self.guess, error.magnitude, simulates=True)

    def _at_first(self, values: Mapping[str, float]) -> dict[str, float]:
        return {LAG: LAG_AT_FIRST * self.logs[0].sample_time} | dict(values)

    def _searched(self, search: Search, first: dict[str, float], report: Report) -> Solution:
        """Return the best of several searches; one that a person interrupts, or what it had come to."""
        best = BestSoFar()
        try:
            self._from_several(search, first, best, report)
        except KeyboardInterrupt as error:
            obey(error, anything=best.at is not None)
            if best.result is None or best.cost < best.result.cost:
                best.result = search.refit(search.values_of(np.asarray(best.at)), limit=1)
        return replace(best.result, unfinished=not best.whole)

    def _from_several(self, search: Search, first: dict[str, float], best: BestSoFar, report: Report) -> None:
        before = EVERYWHERE if self.everywhere else 0.0

        def told(number: float) -> None:
            share = before + (1.0 - before) * number / (FURTHER_STARTS + 2.0)
            report(share, f"best so far {search.percent(best.cost):.3g} %")

        rng = np.random.default_rng(SEED)
        best.take(search.refit(first, limit=COARSE_EVALUATIONS, best=best))
        if self.everywhere:
            found = self._explored(search, best, lambda share, remark="": report(before * share, remark))
            best.take(search.refit(found, limit=COARSE_EVALUATIONS, best=best))
        for number in range(FURTHER_STARTS):
            told(number + 1.0)
            away = {name: value * float(np.exp(rng.normal(0.0, AWAY))) for name, value in best.result.values.items()}
            best.take(search.refit(away, limit=AWAY_EVALUATIONS[self.loop], best=best))
        told(FURTHER_STARTS + 1.0)
        best.whole = True

    @staticmethod
    def _explored(search: Search, best: BestSoFar, report: Report) -> dict[str, float]:
        """Return the best place in the whole range of each parameter, as a rough simulation finds it."""
        rough, seen = replace(search, problem=_problem(search).rough), BestSoFar()
        try:
            return rough.explored(best.result.values, seen, report)
        except KeyboardInterrupt:
            if seen.at is not None:
                best.see(seen.at, search.cost_at(seen.at))
            raise


def _problem(search: Search) -> OutputError:
    assert isinstance(search.problem, OutputError)
    return search.problem


def held_out_output(error: OutputError, space: Space, blocks: int, report: Report = silent) -> HeldOut:
    """Return the error on what was not fitted: on each of several logs, else parts of one.

    The parts of a record that repeats itself are parts of its period: another period would only be the same again.

    Parameters
    ----------
    error : OutputError
        What was fitted.
    space : Space
        The coordinates of its solution.
    blocks : int
        Parts of a single log.
    report : callable
        Is told the share of the work done.
    """
    if len(error.outputs) > 1:
        which, count, of = error.segment_of_sample, len(error.outputs), "logs"
    else:
        which, count, of = np.floor(error.phase * blocks).astype(int), blocks, TIME
    errors, every, measured = [], np.ones(len(space.names), dtype=bool), error.measured
    for number in range(count):
        report(number / count)
        left = which == number
        _, residual = Refit(space, every, ~left).solve(error, space.theta)
        errors.append(relative_error_percent(measured[left], (measured - residual)[left]))
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), of)
