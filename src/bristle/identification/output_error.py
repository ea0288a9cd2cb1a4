r"""Output error: the parameters with which the simulated signal matches the measured signal.

.. math:: \hat\theta = \arg\min_\theta \sum_k \left[y_k - \hat y_k(\theta)\right]^2

In open loop `y` is the position of the model under the measured effort. In closed loop it is the effort of the
controller: the controller keeps the position near its reference for any model, and errors of the model appear in the
effort. The measured position is never differentiated, so its noise does not bias the parameters as in inverse
dynamics.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Self

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import BestSoFar, Diagnostic
from bristle.core.edge import between
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.variable import Variable
from bristle.engine.translation.scope import NotExportableError
from bristle.identification.dataset import Dataset
from bristle.identification.estimation import Context, Estimation
from bristle.identification.half_cycles import (
    NUDGE,
    TIME,
    Disturbance,
    Groups,
    least_way,
    scaled,
    signs,
)
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Report, Search, linear
from bristle.identification.outputs import LAG, Effort, Mechanism, Output, Position, slices_of
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import ParameterSet
from bristle.identification.problem import Away, Fold, has_own
from bristle.identification.refit import Refit
from bristle.identification.sensitivities import Perturbed, warn_of_differences
from bristle.identification.settings import Settings
from bristle.logs.log import Log
from bristle.logs.turns import half_cycle_numbers, turning_points
from bristle.simulation.statistics import relative_error_percent

AWAY = 0.3  # standard deviation of the logarithm of further starts about the first
FURTHER_STARTS = 2
FIRST_EVALUATIONS, LAST_EVALUATIONS = 40, 12
SEED = 7_110_601
START = 0.25  # share of the work for the start of a simulation


@dataclass(frozen=True)
class OutputError:
    """The error of a simulation, with the parameters of `inverse`; the segments of the logs are its `outputs`."""

    inverse: InverseDynamics  # the same model as inverse dynamics
    outputs: tuple[Output, ...]

    @classmethod
    def of(
        cls,
        loop: type[Output],
        inverse: InverseDynamics,
        logs: Sequence[Log],
        axes: Sequence[Axis],
        *,
        fine: bool = False,
    ) -> Self:
        """Return the problem of several logs, simulated quickly, or finely for the end of a search."""
        if any(axis.seeks_lag for axis in axes):
            time, parameters = logs[0].sample_time, inverse.parameters
            description = "lag of the drive behind its controller"
            # Samples
            lag = Variable(
                "time", description, min=0.0, max=20.0 * time, nominal=time, excitation="drive"
            )
            inverse = replace(
                inverse,
                parameters=replace(parameters, free=(*parameters.free, LAG), loop={LAG: lag}),
            )
        pairs = zip(logs, axes, strict=True)
        return cls(
            inverse,
            tuple(
                loop.of(log, axis, part, fine=fine)
                for log, axis in pairs
                for part in slices_of(log)
            ),
        )

    @property
    def loop(self) -> type[Output]:
        """The simulated loop."""
        return type(self.outputs[0])

    @property
    def parameters(self) -> ParameterSet:
        """The free and fixed parameters."""
        return self.inverse.parameters

    @property
    def dataset(self) -> Dataset:
        """The log as rows of inverse dynamics."""
        return self.inverse.dataset

    @cached_property
    def measured(self) -> np.ndarray:
        """The signal of all segments, shape (sample,)."""
        return np.concatenate([output.measured for output in self.outputs])

    @property
    def magnitude(self) -> float:
        """Typical magnitude of the signal."""
        return float(np.std(self.measured))

    @property
    def row_time(self) -> float:
        """Time from sample to sample [s]."""
        return self.dataset.sample_time

    def excerpt(self) -> None:
        """Return None: a simulation starts from the result of inverse dynamics."""

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus simulated signal of each sample."""
        return self.measured - self.simulated(self.parameters.complete(free))

    def effort_residual(self, free: Mapping[str, float], residual: np.ndarray) -> np.ndarray:
        """Return measured minus predicted effort along the measured motion, of each row of the data set [N or N*m]."""
        return self.inverse.residual(free)

    def simulated(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the simulated signal of each sample, from all parameters."""
        mechanism = self.mechanism(values)
        return np.concatenate([output.simulated(mechanism) for output in self.outputs])

    def mechanism(self, values: Mapping[str, float]) -> Mechanism:
        """Return the simulated models, from all parameters."""
        return Mechanism(self.inverse.plant(values), self.inverse.model(values), values)

    def linearised(self, free: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray | None]:
        """Return the residual, shape (sample,), and the derivatives of the signal, (sample, free), if available."""
        values, names, inverse = self.parameters.complete(free), self.parameters.free, self.inverse
        if has_own(self, OutputError, "residual", "simulated", "mechanism") or any(
            output.regressors for output in self.outputs
        ):
            return self.residual(free), None
        plant, friction = (
            Perturbed(inverse.plant, values, names),
            Perturbed(inverse.model, values, names),
        )
        lag = values.get(LAG), np.array([float(name == LAG) for name in names])
        try:
            parts = [output.with_derivatives(plant, friction, *lag) for output in self.outputs]
        except NotExportableError as error:
            warn_of_differences(self.parameters.component, error)
            return self.residual(free), None
        signal, derivatives = (np.concatenate(part) for part in zip(*parts, strict=True))
        return self.measured - signal, derivatives

    def errors(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return the minimised errors of a fit, and the lag of the drive if it was sought."""
        residual, measured = self.residual(free), self.measured
        errors = {
            f"{self.loop.signal}_error_percent": relative_error_percent(
                measured, measured - residual
            ),
            f"{self.loop.signal}_rmse": float(np.sqrt(np.mean(residual**2))),
        }
        return errors | ({LAG: free[LAG]} if LAG in free else {})

    @cached_property
    def half_cycles(self) -> Groups:
        """The samples of each half-cycle of the logs, without trembles and encoder steps."""
        least = least_way(self.dataset.resolution, self.dataset.noise)
        positions = [output.position for output in self.outputs]
        # The step between two samples has the number of the first: there the motion turns.
        turns = [turning_points(position, least) for position in positions]
        return Groups(
            np.concatenate(half_cycle_numbers(turns, [position.size for position in positions]))
        )

    @cached_property
    def away(self) -> Away:
        """No rows: each reversal affects all later samples of a simulated signal."""
        return Away.nowhere(self.measured.size)

    def friction_slope(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the derivative of the signal of each sample by the relative friction level, shape (sample,)."""
        return np.nan_to_num(
            (
                self.simulated(scaled(self.parameters.component, values, 1.0 + NUDGE))
                - self.simulated(values)
            )
            / NUDGE
        )

    def replicates(
        self, values: Mapping[str, float], slope: np.ndarray, residual: np.ndarray
    ) -> SignalReplicates:
        """Return the replicates of the fitted model."""
        return SignalReplicates(self, values, slope, residual)

    def folds(self, count: int, settings: Settings | None = None) -> tuple[str, list[Fold]]:
        """Return `count` parts of the logs, or of their periods if they are periodic: a part has a block of each log."""
        rows, of_sample = (
            self.dataset,
            np.concatenate([np.floor(output.phase * count).astype(int) for output in self.outputs]),
        )
        of_row = None
        # A segment may be long enough for a simulation, and too short for the filters of the rows.
        if len(rows.segments) == len(self.outputs):
            begin = np.array([segment.time[0] for segment in rows.segments])[rows.segment_of_row]
            period = (
                rows.sample_time
                * np.array([output.period for output in self.outputs])[rows.segment_of_row]
            )
            of_row = np.floor((rows.time - begin) / period % 1.0 * count).astype(int)
        all_rows = np.ones(rows.effort.size, dtype=bool)
        return TIME, [
            Fold(of_sample == k, of_sample != k, all_rows if of_row is None else of_row == k)
            for k in range(count)
        ]


def loop_of(logs: Sequence[Log], axes: Sequence[Axis | None]) -> type[Output]:
    """Return the loop to simulate: that of the axis, else closed if possible; reject axes that disagree."""
    requested = {axis.loop for axis in axes if axis is not None} or {None}
    if len(requested) > 1:
        raise InputError(
            "differs between axes",
            path="identification.loop",
            mend="Write the same loop in all axis files",
        )
    closed = all(
        axis is not None and axis.controller is not None and log.reference is not None
        for log, axis in zip(logs, axes, strict=True)
    )
    loop = {"open": Position, "closed": Effort}[requested.pop() or ("closed" if closed else "open")]
    if loop is Position and any(axis is not None and axis.seeks_lag for axis in axes):
        raise InputError(
            "can be identified in a closed loop only",
            path="effort.lag",
            value="identify",
            mend="Describe [controller] and the column of the reference in the axis file",
        )
    return loop


@dataclass(frozen=True)
class SignalReplicates:
    """Replicates of the signal of a simulation, as a sum of small disturbances: encoder, friction level and residual."""

    error: OutputError  # fitted problem
    values: Mapping[str, float]  # all its parameters [SI]
    slope: np.ndarray  # derivative by the friction level, shape (sample,)
    left: np.ndarray  # residual of the fit, shape (sample,)

    doubt = 0.0

    def draw(
        self, disturbance: Disturbance, rng: np.random.Generator, side: float = 1.0
    ) -> Changed:
        """Return the same fit to a new random log."""
        cycles = self.error.half_cycles
        levels = self._split(
            (disturbance.scatter * rng.standard_normal(cycles.count))[cycles.index]
        )
        pure, changes = [pure for pure, _ in self._pure], []
        for output, (signal, leaning), level, left in zip(
            self.error.outputs, self._pure, levels, self._split(self.left), strict=True
        ):
            change = output.read(self._mechanism, signal, level * leaning, disturbance, rng)
            changes.append(
                np.nan_to_num(change) + disturbance.unexplained * signs(signal.size, rng) * left
            )
        return Changed(self, np.concatenate(pure), side * np.concatenate(changes))

    def made_with(self, values: Mapping[str, float]) -> SignalReplicates:
        """Return replicates of the same model with other parameters."""
        return replace(self, values=values)

    @cached_property
    def _pure(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Signal of each segment without disturbance, and its change per relative friction level."""
        return [
            (
                output.simulated(self._mechanism),
                np.nan_to_num(output.leaning(self._mechanism, slope)),
            )
            for output, slope in zip(self.error.outputs, self._split(self.slope), strict=True)
        ]

    def _split(self, signal: np.ndarray) -> list[np.ndarray]:
        """Return the samples of each segment."""
        return np.split(
            signal, np.cumsum([output.measured.size for output in self.error.outputs])[:-1]
        )

    @property
    def _mechanism(self) -> Mechanism:
        return self.error.mechanism(self.values)


@dataclass(frozen=True)
class Changed:
    """The same fit to the simulated signal plus a change, shape (sample,)."""

    replicates: SignalReplicates
    pure: np.ndarray
    change: np.ndarray

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return the residual of the changed signal; at the solution of the fit it is the change."""
        error, values = self.replicates.error, self.replicates.values
        if all(free[name] == values[name] for name in error.parameters.free):
            return self.change
        simulated = error.simulated(error.parameters.complete(free))
        # For a signal that diverged.
        return self.pure + self.change - np.where(np.isfinite(simulated), simulated, 1e12)


@dataclass(frozen=True)
class Simulation:
    """The estimator of least output error, started from inverse dynamics."""

    logs: Sequence[Log]
    axes: Sequence[Axis]
    loop: type[Output]

    @property
    def excerpts(self) -> list[Log]:
        """The parts of the logs for the start by inverse dynamics."""
        return [
            self.loop.excerpt(log, axis) for log, axis in zip(self.logs, self.axes, strict=True)
        ]

    def error(self, inverse: InverseDynamics, *, fine: bool = False) -> OutputError:
        """Return the problem, simulated quickly, or finely for the end of a search."""
        return OutputError.of(self.loop, inverse, self.logs, self.axes, fine=fine)

    def __call__(self, context: Context, component: FrictionModel, report: Report) -> Estimation:
        """Return the estimation of one model, or that of its start if the start is interrupted."""
        problem = context.problem(component)
        if problem.parameters.is_linear:
            start = linear(problem)
        else:
            start = context.search(problem, simulates=True).solve(between(report, 0.0, START))
        if start.unfinished:
            return Estimation(
                problem,
                start,
                problem,
                (problem, start),
                lambda rows: problem.residual(start.values),
            )
        return self.estimate(context, problem, start, between(report, START, 1.0))

    def estimate(
        self, context: Context, inverse: InverseDynamics, start: Solution, report: Report
    ) -> Estimation:
        """Return the estimation of a model from the solution `start` of inverse dynamics."""
        error = self.error(inverse)
        search = context.search(error, error.magnitude, simulates=True)
        first = {LAG: 0.2 * self.logs[0].sample_time} | start.values  # samples
        solution = search.as_far_as_it_came(partial(self._from_several, search, first, report))
        if self.loop.is_refined:
            error = self.error(inverse, fine=True)
            fine = context.search(error, error.magnitude, simulates=True)
            ended = fine.refit(
                solution.values, limit=1 if solution.unfinished else LAST_EVALUATIONS
            )
            solution = replace(ended, unfinished=solution.unfinished)
        return Estimation(
            error.inverse,
            solution,
            error,
            (error, solution),
            lambda rows: Refit(solution, rows).solve(error, solution.theta)[1],
            diagnostics=(Diagnostic(self.loop.code, severity="note"),),
        )

    def _from_several(
        self, search: Search, first: dict[str, float], report: Report, best: BestSoFar
    ) -> None:
        def report_start(number: float) -> None:
            report(
                number / (FURTHER_STARTS + 2.0), f"best so far {search.percent(best.cost):.3g} %"
            )

        rng = np.random.default_rng(SEED)
        best.take(search.refit(first, limit=FIRST_EVALUATIONS, best=best))
        for number in range(FURTHER_STARTS):
            report_start(number + 1.0)
            away = {
                name: value * float(np.exp(rng.normal(0.0, AWAY)))
                for name, value in best.result.values.items()
            }
            best.take(search.refit(away, limit=self.loop.away_evaluations, best=best))
        report_start(FURTHER_STARTS + 1.0)
