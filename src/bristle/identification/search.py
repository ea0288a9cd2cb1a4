"""Bounded nonlinear least squares from several starts, for models that are not linear in their parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from bristle.core.interruption import BestSoFar, obey
from bristle.core.variable import Variable
from bristle.identification.differences import STEP, Differences
from bristle.identification.global_search import EVOLUTION_SEED, box_of, evolved
from bristle.identification.inverse_dynamics import Sought
from bristle.identification.parameters import Transform, Scales, transforms_of, natural_derivative
from bristle.identification.solution import Solution

__all__ = ["Report", "Search", "silent"]

CANDIDATES = 24
STARTS = 3
EVALUATIONS = 60
SEED = 20_240_229
STARTS_SHARE = 0.3  # of the work, where the whole range is looked at too
FAR = 1e6  # times a typical residual: a model that left the finite numbers, or nearly
DIFFERENCE = float(np.sqrt(np.finfo(float).eps))  # of a coordinate, for a derivative
SIMULATED = 1e-7  # relative change of the cost that ends a search whose differences are coarse
HELD_OUT = 1e-6  # the same, of a search on some rows: errors on the others are told to a thousandth
EDGE = 1e-3  # in coordinates: of a typical magnitude, or of a factor e


class _KnownError(Exception):
    """A descent has come to a minimum that is known."""


class Report(Protocol):
    """What a search tells of its progress: the share of the work done, and a remark."""

    def __call__(self, share: float, remark: str = "") -> None:
        """Take note."""
        ...


def silent(share: float, remark: str = "") -> None:
    """Tell nobody."""


@dataclass(frozen=True)
class Search:
    """The search for the parameters of one model.

    Parameters
    ----------
    problem : InverseDynamics
        What is minimised: the sum of squares of its residual.
    scales : Scales
        Typical magnitudes of the log, which bound the parameters of unknown magnitude.
    guess : mapping of str to float
        ``M``, ``F_C``, ``F_v``, ``offset`` and what else the plant has, of a Coulomb and viscous fit to the same log
        [SI].
    unit : float, optional
        Typical magnitude of the residual; that of the friction force where not given.
    simulates : bool
        Whether each residual takes a simulation: then all cores share a Jacobian.
    """

    problem: Sought
    scales: Scales
    guess: Mapping[str, float]
    unit: float = 0.0
    simulates: bool = False

    def solve(self, report: Report = silent, *, everywhere: bool = False) -> Solution:
        """Return the best solution from several starts; `report` is told the share of the work done.

        Where it is to look `everywhere`, it goes on in the whole range of each parameter.

        One that a person interrupts is the best found until then, and says so.
        """
        coordinates = transforms_of(self.problem.parameters, self.scales)
        best = BestSoFar()
        first = STARTS_SHARE if everywhere else 1.0
        try:
            self._from_several(coordinates, best, lambda share, remark="": report(first * share, remark))
            if everywhere:
                found = self.explored(
                    self.values_of(best.result.x), best,
                    lambda share, remark="": report(first + (1.0 - first) * share, remark),
                )  # fmt: skip
                best.take(self._descend(coordinates, self.theta_of(found), slice(None), EVALUATIONS, best))
            best.whole = True
        except KeyboardInterrupt as error:
            obey(error, anything=best.at is not None)
            if best.result is None or best.cost < best.result.cost:
                best.result = self._descend(coordinates, np.asarray(best.at), slice(None), 1)
        return replace(self._solution(coordinates, best.result), unfinished=not best.whole)

    def _from_several(self, coordinates: tuple[Transform, ...], best: BestSoFar, report: Report) -> None:
        rng = np.random.default_rng(SEED)
        candidates = [self._start(coordinates, rng) for _ in range(CANDIDATES)]
        costs = [float(np.sum(self._residual(coordinates, theta) ** 2)) for theta in candidates]
        for number, index in enumerate(np.argsort(costs)[:STARTS]):
            report((number + 0.3) / (STARTS + 0.3), f"best so far {self.percent(best.cost):.3g} %" if number else "")
            # A start that comes to where another one ended would end there, too.
            with suppress(_KnownError):
                best.take(self._descend(coordinates, candidates[index], slice(None), EVALUATIONS, best, again=False))

    def percent(self, cost: float) -> float:
        """Return what half a sum of squares is of the measured signal [%]."""
        return 100.0 * math.sqrt(2.0 * cost) * self._unit / max(self.problem.norm, np.finfo(float).tiny)

    def refit(
        self, start: Mapping[str, float], rows: np.ndarray | None = None, limit: int = EVALUATIONS // 3,
        best: BestSoFar | None = None,
    ) -> Solution:  # fmt: skip
        """Return the solution from a start nearby; `best` takes note.

        Where `rows` are given, it is that of them only, as closely as the error on all others is judged.
        """
        coordinates = transforms_of(self.problem.parameters, self.scales)
        theta, some = self.theta_of(start), slice(None) if rows is None else rows
        tolerance = 0.0 if rows is None else HELD_OUT
        return self._solution(coordinates, self._descend(coordinates, theta, some, limit, best, tolerance))

    def explored(
        self, start: Mapping[str, float], best: BestSoFar, report: Report = silent, seed: int = EVOLUTION_SEED
    ) -> dict[str, float]:
        """Return the best place in the whole range of each parameter, without a descent; `start` is one of them."""
        theta = self.theta_of(start)
        box = box_of(transforms_of(self.problem.parameters, self.scales), theta)

        def told(share: float) -> None:
            report(share, f"looking everywhere, best so far {self.percent(best.cost):.3g} %")

        return self.values_of(evolved(self.cost_at, box, theta, best, told, seed))

    def cost_at(self, theta: np.ndarray) -> float:
        """Return half the sum of squares at some coordinates."""
        residual = self._residual(transforms_of(self.problem.parameters, self.scales), theta)
        return 0.5 * float(residual @ residual)

    def values_of(self, theta: np.ndarray) -> dict[str, float]:
        """Return the free parameters [SI] at some coordinates."""
        return self._values(transforms_of(self.problem.parameters, self.scales), theta)

    def theta_of(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the coordinates of some parameters, put inside their range."""
        coordinates = transforms_of(self.problem.parameters, self.scales)
        return np.array([one.theta(values[one.name], values) for one in coordinates])

    def _values(self, coordinates: tuple[Transform, ...], theta: np.ndarray) -> dict[str, float]:
        values = self.problem.parameters.complete({})
        for coordinate, one in zip(coordinates, theta.tolist(), strict=True):
            values[coordinate.name] = coordinate.value(one, values)
        return {coordinate.name: values[coordinate.name] for coordinate in coordinates}

    def _residual(
        self, coordinates: tuple[Transform, ...], theta: np.ndarray, problem: Sought | None = None
    ) -> np.ndarray:
        with np.errstate(over="ignore", invalid="ignore"):
            residual = (problem or self.problem).residual(self._values(coordinates, theta)) / self._unit
        return np.clip(np.nan_to_num(residual, nan=FAR, posinf=FAR, neginf=-FAR), -FAR, FAR)

    @property
    def _unit(self) -> float:
        return self.unit or self.scales.force

    def _descend(
        self, coordinates: tuple[Transform, ...], theta: np.ndarray, rows: np.ndarray | slice, limit: int,
        best: BestSoFar | None = None, tolerance: float = 0.0, *, again: bool = True,
    ) -> Any:  # fmt: skip
        """Return a minimum nearby; where it is not to be found `again`, a known one raises _KnownError."""
        from scipy.optimize import least_squares

        low = np.array([one.low for one in coordinates])
        high = np.array([one.high for one in coordinates])
        step = STEP if self.simulates else DIFFERENCE
        shared = Differences(lambda x: self._residual(coordinates, x)[rows], high, step)

        def residual(x: np.ndarray) -> np.ndarray:
            found = shared(x)
            if best is not None:
                best.see(x, 0.5 * float(found @ found))
                if not again and best.is_known(x):
                    raise _KnownError
            return found

        # The method needs a start strictly inside.
        width = np.minimum(high - low, 1.0)
        theta = np.clip(theta, low + 1e-4 * width, high - 1e-4 * width)
        smooth = self._is_smooth(coordinates, theta)
        jacobian: Any = shared.jacobian if smooth else self._jacobian_of_held(coordinates, rows, high)
        return least_squares(
            residual, theta, jac=jacobian, bounds=(low, high), max_nfev=limit,
            ftol=max(SIMULATED if self.simulates else 1e-9, tolerance), xtol=1e-7, gtol=1e-10,
        )  # fmt: skip

    def _jacobian_of_held(
        self, coordinates: tuple[Transform, ...], rows: np.ndarray | slice, high: np.ndarray
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Return the Jacobian with what is found on the way held: a state that is searched for bends it."""

        def jacobian(x: np.ndarray) -> np.ndarray:
            values = self._values(coordinates, x)
            near = self.problem.near(values)
            there = Differences(lambda at: self._residual(coordinates, at, near)[rows], high, DIFFERENCE)
            return near.without_found(there.jacobian(x), values, rows)

        return jacobian

    def _is_smooth(self, coordinates: tuple[Transform, ...], theta: np.ndarray) -> bool:
        return self.problem.near(self._values(coordinates, theta)) is self.problem

    def _solution(self, coordinates: tuple[Transform, ...], found) -> Solution:
        theta, at_edge = found.x.copy(), {}
        for index, coordinate in enumerate(coordinates):
            if theta[index] - coordinate.low < EDGE:
                theta[index], at_edge[coordinate.name] = coordinate.low, "smallest"
            elif coordinate.high - theta[index] < EDGE:
                theta[index], at_edge[coordinate.name] = coordinate.high, "largest"
        values = self._values(coordinates, theta)
        return Solution(
            values, at_edge, -found.jac * self._unit, natural_derivative(coordinates, values), float(found.cost)
        )

    def _start(self, coordinates: tuple[Transform, ...], rng: np.random.Generator) -> np.ndarray:
        """Return a start: the sliding part from the linear fit, all else drawn from the range it is sought in."""
        variables = self.problem.parameters.variables
        values = self.problem.parameters.complete({})
        for coordinate in coordinates:
            drawn = self._draw(coordinate, variables[coordinate.name], rng)
            inside = coordinate.theta(drawn + (values[coordinate.above] if coordinate.above else 0.0), values)
            values[coordinate.name] = coordinate.value(inside, values)
        return np.array([one.theta(values[one.name], values) for one in coordinates])

    def _draw(self, coordinate: Transform, variable: Variable, rng: np.random.Generator) -> float:
        if coordinate.name == "k":
            # Friction in front of its first slip is stiff too: both share what the log shows.
            return self.guess["k"] * rng.uniform(0.2, 1.0)
        if coordinate.name in ("M", "c", "offset"):
            return self.guess[coordinate.name]
        if variable.excitation in ("place", "load", "temperature"):
            return 0.0
        if coordinate.form == "excess":
            return self.guess["F_C"] * rng.exponential(0.3)
        if variable.quantity == "force":
            return self.guess["F_C"]
        if variable.excitation == "speed":
            return self.guess["F_v"]
        if coordinate.form == "log":
            return math.exp(rng.uniform(coordinate.low, coordinate.high))
        return self.scales.magnitude(variable) * 10.0 ** rng.uniform(-2.0, 1.0)
