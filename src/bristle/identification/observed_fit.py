r"""A fit with the contact parameters of observers, and their intervals.

.. math:: V' = V + e\,e^T

with the covariance :math:`V` of a ladder of observers (`bristle.identification.ladder`) and the difference :math:`e`
from inverse dynamics in the parameters of steady sliding. Replicates of the log show whether the model predicts the
log as well as noise permits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.cores import Abreast
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.edge import between
from bristle.core.errors import InputError
from bristle.core.normal import NORMAL_95
from bristle.engine import run_closed_loop
from bristle.engine.motion import along
from bristle.identification.bootstrap import curve_of
from bristle.identification.dataset import Dataset
from bristle.identification.estimate import Estimate
from bristle.identification.estimation import Context, Estimation
from bristle.identification.fitting import fit_of
from bristle.identification.half_cycles import Disturbance
from bristle.identification.ladder import Ladder
from bristle.identification.least_squares import Report, silent
from bristle.identification.observed_elements import SpreadModel, gathered
from bristle.identification.observer import (
    BEND,
    DELAY,
    PredictionErrors,
    Recorded,
    Rung,
    climb,
    climbed,
    observable,
)
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed, Role, names_of
from bristle.identification.problem import Covariance
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.identification.structure import about_delay
from bristle.identification.uncertainty import IN_DOUBT, birge_ratio
from bristle.logs.filters import low_passed, through_filter
from bristle.logs.log import Log
from bristle.models.controllers import cascade
from bristle.models.friction.slots import OFFSET, directional
from bristle.models.plants.terms import effort_of_columns
from bristle.models.sensors import encoder

# 97.5 % quantile of Student's t of one degree of freedom less, over that of the normal distribution
STUDENT = 2.045 / NORMAL_95
WORSE = (
    1.35  # times the prediction error of replicates: above, the model does not explain the motion
)
REPLICATES, REFITTED, SEED = 4, 8, 20_261_126  # evaluations of a refit
# Hz: low-pass of the motion that a replicate follows; bandwidth of its loop; damping of the loop.
HELD_AT, LED_AT, DAMPED = (25.0, 25.0, 0.7)
APART_MOST = 3.0  # standard errors: largest difference from inverse dynamics
SHOWN_BY_SLIDING = ("sliding", "speed")
SIDED = (Role.LEVEL, Role.VISCOUS)
REPLACED = (
    "widened",
    "coarse_elements",
    "delay_found",
    "delay_rough",
    "delay_unknown",
    "delay_or_filter",
)
"""Codes about intervals of inverse dynamics and the delay of the first stage, replaced by those of the observer."""
FILTERED = "filter_suspect"
DRAWS = 400  # for the intervals
CLIMBED = 0.4  # share of the time until the replicates


class Observed(NamedTuple):
    """The result of observers: the parameters, and the covariance of their coordinates."""

    solution: Solution
    matrix: np.ndarray

    @property
    def covariance(self) -> Covariance:
        """The standard errors of the reported parameters."""
        solution = self.solution
        matrix = solution.derivative @ self.matrix @ solution.derivative.T
        std = np.sqrt(np.maximum(np.diag(matrix), 0.0))
        errors = np.where(
            [name not in solution.at_edge for name in solution.space.reported], std, np.nan
        )
        scale, length = np.where(std > 0.0, std, np.nan), np.linalg.norm(solution.jacobian, axis=0)
        condition = float(np.linalg.cond(solution.jacobian[:, length > 0.0] / length[length > 0.0]))
        return Covariance(errors, errors, matrix / np.outer(scale, scale), condition)

    def draws(self, count: int = DRAWS) -> np.ndarray:
        """Return random coordinates compatible with the log, shape (draw, coordinate), each followed by its mirror image."""
        values, vectors = np.linalg.eigh(self.matrix)
        half = np.random.default_rng(SEED).standard_normal((-(-count // 2), values.size)) * np.sqrt(
            np.maximum(values, 0.0)
        )
        drawn = (
            self.solution.theta
            + np.stack([half, -half], axis=1).reshape(-1, values.size)[:count] @ vectors.T
        )
        return np.clip(drawn, self.solution.space.low, self.solution.space.high)


def variance_of(ladder: Ladder, inverse: Mapping[str, float], scale: float) -> np.ndarray:
    """Return the covariance of the coordinates, with the difference from inverse dynamics [SI]; `scale` multiplies the errors."""
    apart = _apart(ladder, np.sqrt(np.diag(ladder.covariance)), inverse)
    return (STUDENT * scale) ** 2 * (ladder.covariance + np.diag(apart**2))


def _apart(ladder: Ladder, errors: np.ndarray, inverse: Mapping[str, float]) -> np.ndarray:
    """Return the difference of inverse dynamics in each coordinate of steady sliding, clipped to a multiple of the errors."""
    solution, variables = ladder.solution, ladder.best.problem.parameters.variables
    apart = np.zeros(solution.theta.size)
    for place, name in enumerate(solution.space.names):
        if name in inverse and variables[name].excitation in SHOWN_BY_SLIDING:
            apart[place] = (inverse[name] - solution.values[name]) / solution.derivative[
                place, place
            ]
    return np.clip(apart, -APART_MOST * errors, APART_MOST * errors)


def with_observer(
    fit: Fit, estimation: Estimation, context: Context, ladder: Ladder, scale: float
) -> Fit:
    """Return a fit with the parameters and intervals of a ladder; reject parameters that the model does not allow."""
    of_inverse = {estimate.name: estimate.value for estimate in fit.estimates}
    inverse, solution = ladder.best.problem.inverse, ladder.solution
    if isinstance(inverse.parameters.component, SpreadModel):
        inverse, solution = gathered(inverse, solution)
        estimation = replace(
            estimation, further=max(len(solution.space.names) - len(solution.space.reported), 0)
        )
    observed = Observed(solution, variance_of(ladder, of_inverse, scale))
    of_observer = replace(
        estimation, inverse=inverse, solution=solution, covariance=observed.covariance
    )
    better, thetas, space = fit_of(of_observer, context), observed.draws(), solution.space
    draws = np.array([space.numbers(theta) for theta in thetas])
    renewed = {
        estimate.name: _with_interval(estimate, solution, draws) for estimate in better.estimates
    }
    # Diagnostics of inverse dynamics about these parameters no longer apply.
    observed_names = set(space.reported).difference((DELAY, BEND))
    about = [
        diagnostic
        for diagnostic in fit.diagnostics
        if diagnostic.parameter not in observed_names and diagnostic.code not in REPLACED
    ]
    # The removal of a filter is no longer in doubt: the log is predicted as well as its replicates.
    about = [
        replace(diagnostic, severity="note") if diagnostic.code == FILTERED else diagnostic
        for diagnostic in about
    ]
    dataset = inverse.dataset
    if dataset.alignment is not None and dataset.alignment.sought:
        about.append(_about_delay(dataset, draws[:, space.reported.index(DELAY)], context.settings))
    about += [
        diagnostic for diagnostic in better.diagnostics if diagnostic.parameter in observed_names
    ]
    resampling = fit.resampling
    if resampling is not None:
        members = [
            estimation.finished(space.member(theta))
            for theta in observed.draws(resampling.bands.count)
        ]
        columns = {
            name: np.array([member[name] for member in members])
            for name in members[0]
            if name not in (DELAY, BEND)
        }
        bands = replace(resampling.bands, draws={**resampling.bands.draws, **columns})
        resampling = replace(
            resampling,
            bands=bands,
            curve=curve_of(space, solution.theta, draws) or resampling.curve,
        )
    return replace(
        fit,
        plant=better.plant,
        friction=better.friction,
        estimates=tuple(
            renewed[old.name] if old.name in space.reported else old for old in fit.estimates
        ),
        combinations=better.combinations,
        correlation=better.correlation,
        correlation_names=better.correlation_names,
        condition_number=better.condition_number,
        traces=better.traces,
        force_error_percent=better.force_error_percent,
        diagnostics=tuple(about),
        resampling=resampling,
        further=better.further,
    )


def _about_delay(dataset: Dataset, draws: np.ndarray, settings: Settings) -> Diagnostic:
    """Return the delay of the effort from an observer, and its half-width from draws [s]."""
    low, middle, high = np.percentile(draws, [2.5, 50.0, 97.5]).tolist()
    delay = middle + 0.5 * dataset.sample_time * bool(dataset.held)
    return about_delay(delay, 0.5 * (high - low), dataset.sample_time, settings)


def _with_interval(estimate: Estimate, solution: Solution, draws: np.ndarray) -> Estimate:
    """Return an estimate with its interval."""
    if estimate.status != "identified" or estimate.name not in solution.space.reported:
        return estimate
    low, high = np.percentile(
        draws[:, solution.space.reported.index(estimate.name)], [2.5, 97.5]
    ).tolist()
    return replace(estimate, interval=(low, high))


def foreseen(
    fit: Fit, estimation: Estimation, context: Context, logs: Sequence[Log], report: Report = silent
) -> Fit:
    """Return a fit with the parameters of the best observer, or the fit with a remark why it keeps its parameters."""

    def with_remark(fit: Fit, numbers: dict[str, Number]) -> Fit:
        return replace(
            fit,
            diagnostics=(
                *fit.diagnostics,
                Diagnostic("prediction_error", "", "note", numbers, fit.friction.kind),
            ),
        )

    if not observable(estimation.inverse, estimation.solution.values):
        return fit
    held, climbing = held_in(fit, estimation), between(report, 0.0, CLIMBED)
    scatter = 0.0 if fit.resampling is None else fit.resampling.scatter.value
    rungs = climb(
        estimation.inverse,
        estimation.solution.values,
        logs,
        context,
        held,
        levels_in(fit),
        scatter,
        climbing,
    )
    if not rungs:
        return with_remark(
            fit, {"why": "no segment of the log lasts a second, or the observer loses the motion"}
        )
    ladder = Ladder.of(rungs)
    errors = errors_of_replicates(ladder.best, context, scatter, between(report, CLIMBED, 1.0))
    times = ladder.best.error / float(np.median(errors)) if errors.size else np.inf
    numbers: dict[str, Number] = {
        "bandwidth": ladder.best.problem.bandwidth,
        "error": ladder.best.error,
        "times": times,
    }
    if times > WORSE:
        return with_remark(fit, numbers | {"unexplained": 1})
    try:
        scale = (
            max(times, 1.0)
            * birge_ratio(fit)
            * (IN_DOUBT if _filtered_unseen(context.dataset) else 1.0)
        )
        better = with_observer(fit, estimation, context, ladder, scale)
    except InputError as error:
        return with_remark(fit, {"why": error.message})
    # If the elements of the observer explain the force less well, a missing force was taken for stiffness.
    miss = better.force_error_percent / max(fit.force_error_percent, np.finfo(float).tiny)
    if better.further and miss > WORSE:
        return with_remark(
            fit, {"why": f"with its elements, {miss:.2g} times as much of the force is unexplained"}
        )
    return with_remark(better, numbers)


def _filtered_unseen(dataset: Dataset) -> bool:
    """Return whether the position passed an unknown filter: the effort may have passed it too."""
    return dataset.off_grid and not (
        dataset.alignment is not None and dataset.alignment.of_position
    )


def held_in(fit: Fit, estimation: Estimation) -> dict[str, Fixed]:
    """Return the parameters kept from inverse dynamics: the plant, and directional forces, which an observer absorbs."""
    parameters = estimation.inverse.parameters
    component, values = parameters.component, parameters.complete(estimation.solution.values)
    sided = [
        name
        for name in directional(component)
        for role in SIDED
        if role.fits(component.variables[name])
    ]
    held = dict[str, Fixed]()
    for name in (*parameters.plant.variables, *names_of(OFFSET, component.variables), *sided):
        low, high = fit.parameters[name].interval or (values[name], values[name])
        held[name] = parameters.fixed.get(name) or Fixed(
            values[name], reason="", half_width=0.5 * (high - low)
        )
    return held


def levels_in(fit: Fit) -> dict[str, tuple[float, float]]:
    """Return the friction levels of inverse dynamics, with their standard errors [SI]."""
    estimates = [fit.parameters[name] for name in fit.levels]
    return {
        estimate.name: (estimate.value, 0.5 * (estimate.ends[1] - estimate.ends[0]) / NORMAL_95)
        for estimate in estimates
        if estimate.status == "identified" and estimate.ends is not None
    }


def errors_of_replicates(
    rung: Rung, context: Context, scatter: float, report: Report = silent
) -> np.ndarray:
    """Return the prediction errors of fits to replicates of a log, shape (replicate,) [m or rad]."""
    first, *seeds = np.random.SeedSequence(SEED).spawn(REPLICATES + 1)
    dataset = rung.problem.inverse.dataset
    unseen = unseen_in(rung, Disturbance(scatter, dataset.effort_noise, dataset.resolution), first)

    def error(seed: np.random.SeedSequence) -> float | None:
        problem = replicate(rung, unseen, np.random.default_rng(seed))
        return (
            None
            if problem is None
            else climbed(problem.of_size(rung.error), rung.solution.values, context, REFITTED).error
        )

    errors = list[float]()
    with Abreast() as pool:
        for number, end in enumerate(pool.map(error, seeds)):
            errors += [] if end is None else [end]
            report((number + 1) / REPLICATES)
    return np.array(errors)


def unseen_in(rung: Rung, most: Disturbance, seed: np.random.SeedSequence) -> Disturbance:
    """Return disturbances, at `most` these, with which a replicate has the prediction error of the log: steps first, then noise."""

    def square(unseen: Disturbance) -> float:
        drawn = replicate(rung, unseen, np.random.default_rng(seed))
        return (
            np.inf
            if drawn is None
            else float(np.mean(drawn.residual(rung.solution.values)[: drawn.settled_rows] ** 2))
        )

    def share(low: float, high: float) -> float:
        return (
            min(max((rung.error**2 - low) / (high - low), 0.0), 1.0) ** 0.5 if high > low else 1.0
        )

    smooth, quiet = (
        square(Disturbance(0.0, 0.0, 0.0)),
        square(Disturbance(0.0, 0.0, most.resolution)),
    )
    noisy, loud = square(most._replace(scatter=0.0)), square(most)
    # An error that smooth positions also have is not due to steps.
    step = most.resolution * (share(smooth, quiet) if smooth < rung.error**2 else 1.0)
    return Disturbance(most.scatter * share(noisy, loud), most.noise * share(quiet, noisy), step)


def replicate(rung: Rung, unseen: Disturbance, rng: np.random.Generator) -> PredictionErrors | None:
    """Return the same problem on a simulated log of the identified axis along the same motion; None if it diverged."""
    problem, inverse = rung.problem, rung.problem.inverse
    values = inverse.parameters.complete(rung.solution.values)
    channel = Channel(values[DELAY], values[BEND], problem.lag)
    axis = IdentifiedAxis(
        inverse.plant(values),
        inverse.model(values),
        inverse.dataset,
        problem.dt,
        problem.steps,
        channel,
    )
    parts = [axis.replicate(part, unseen, rng) for part in problem.parts]
    recorded = tuple(part for part in parts if part is not None)
    return replace(problem, parts=recorded) if len(recorded) == len(parts) else None


class Channel(NamedTuple):
    """Delay and smoothing of the effort of a log, and the filter removed from it [s, s^2, s]."""

    delay: float
    bend: float
    lag: float


class IdentifiedAxis(NamedTuple):
    """The identified axis: its models, its log, and the channel of its effort."""

    plant: Model
    friction: Model
    dataset: Dataset
    dt: float
    steps: int
    channel: Channel

    def replicate(
        self, part: Recorded, unseen: Disturbance, rng: np.random.Generator
    ) -> Recorded | None:
        """Return the record of this axis along the motion of a segment, through its encoder; None if it diverged."""
        dt, count, (delay, bend, lag), step = (
            self.dt,
            part.position.size,
            self.channel,
            unseen.resolution,
        )
        smooth = (
            low_passed(part.position - part.position[0], min(HELD_AT, 0.2 / dt), dt)
            + part.position[0]
        )
        velocity = np.gradient(smooth, dt)
        acted = part.efforts(delay, bend, dt)[0, :count]
        # Held until the next sample.
        commanded = np.append(0.5 * (acted[1:] + acted[:-1]), acted[-1:])
        _, slope = self.plant.component.port(
            self.plant.component.State(smooth[0], velocity[0]), 0.0, dt, self.plant.parameters
        )
        omega, mass = 2.0 * np.pi * LED_AT, -0.5 * dt / slope
        unforeseen, pulls = (
            unseen.scatter * self._leaning(smooth, velocity, rng),
            effort_of_columns(self.plant, part.columns),
        )
        trace = run_closed_loop(
            self.plant,
            self.friction,
            cascade(
                kind=self.plant.kind,
                k_p=omega / (2.0 * DAMPED),
                k_v=2.0 * DAMPED * omega * mass,
                k_ff=1.0,
            ),
            encoder(kind=self.plant.kind, resolution=0.0),
            np.stack([smooth, velocity, np.zeros(count), np.zeros(count)]),
            dt,
            steps=self.steps,
            injected=commanded,
            disturbance=unforeseen if pulls is None else unforeseen + pulls,
            x=float(smooth[0]),
            v=float(velocity[0]),
        )
        if trace.position.size < count:
            return None
        # An effort held until the next sample acts half a sample later, and smoothed.
        recorded = Recorded(trace.position, trace.effort, ()).efforts(
            -delay - 0.5 * dt, -bend - dt**2 / 24.0, dt
        )[0, :count]
        noise = unseen.noise * rng.standard_normal(count)
        phase = rng.uniform(0.0, step)
        position = (
            step * np.round((trace.position + phase) / step) - phase
            if step > 0.0
            else trace.position
        )
        return Recorded(
            position, recorded + (through_filter(noise, lag, dt) if lag else noise), part.columns
        )

    def _leaning(
        self, position: np.ndarray, velocity: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """Return friction along a motion, times a standard normal number for each half-cycle."""
        turns = np.cumsum(np.diff(np.signbit(velocity), prepend=velocity[0] < 0.0))
        force = along(self.friction, v=velocity, x=position, dt=self.dt)
        return rng.standard_normal(int(turns[-1]) + 1)[turns] * force
