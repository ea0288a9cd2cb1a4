r"""A fit with the parameters of a contact as an observer foresees them, and their intervals.

.. math:: V = A^{-1} \Bigl(\sum_b g_b g_b^T\Bigr) A^{-1} + d\,d^T + S + b\,b^T

with the information :math:`A` of the believed observer, the scores :math:`g_b` of blocks of time, what the next stiffer
observer says else :math:`d`, and spread :math:`S` and bias :math:`b` of the same fit to replicates of the log: a stiffer
observer errs by other things than a looser one, and a replicate by those that both have in common.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.controllers import cascade
from bristle.core.contracts import Model
from bristle.core.cores import Abreast
from bristle.core.diagnostic import Diagnostic, Number, Severity
from bristle.core.errors import InputError
from bristle.engine import run_closed_loop
from bristle.identification.dataset import Segment
from bristle.identification.estimation import Context, Estimation
from bristle.identification.fitting import fit_of
from bristle.identification.least_squares import Report, between, silent
from bristle.identification.observer import BEND, DELAY, Ladder, PredictionErrors, Recorded, Rung, climb, climbed
from bristle.identification.parameter_space import Solution
from bristle.identification.problem import Covariance
from bristle.identification.result import Estimate, Fit
from bristle.logs.filters import through_filter
from bristle.logs.log import Log
from bristle.sensors import encoder

BLOCKS, STUDENT = 30, 2.045  # of time; the 97.5 % quantile of Student's t of one degree of freedom less
WORSE = 1.5  # times the prediction error of replicates: what the model does not explain
MOVE_MOST = 3.0  # standard errors: what a stiffer observer may say else
REPLICATES, SEED = 10, 20_261_126
HELD_AT, DAMPED = 25.0, 0.7  # Hz and damping of the loop that leads a replicate along the motion
DRAWS = 400
"""Sets of parameters that stand for what a log allows."""


class Observed(NamedTuple):
    """What an observer says of a fit: its ladder, and the covariance of its coordinates."""

    ladder: Ladder
    matrix: np.ndarray

    @property
    def solution(self) -> Solution:
        """Where the believed rung ended."""
        return self.ladder.believed.solution

    def draws(self, count: int = DRAWS) -> np.ndarray:
        """Return sets of coordinates that the log allows, shape (draw, coordinate), the mirror image of each behind it."""
        values, vectors = np.linalg.eigh(self.matrix)
        half = np.random.default_rng(SEED).standard_normal((count // 2, values.size)) * np.sqrt(np.maximum(values, 0.0))
        drawn = self.solution.theta + np.vstack([half, -half]) @ vectors.T
        return np.clip(drawn, self.solution.space.low, self.solution.space.high)


def sandwich(rung: Rung) -> np.ndarray:
    """Return the covariance of the coordinates from the scores of blocks of time, shape (coordinate, coordinate)."""
    jacobian, count = rung.solution.jacobian, rung.problem.settled_rows
    residual = rung.problem.residual(rung.solution.values)
    scale = np.linalg.norm(jacobian, axis=0)
    columns = jacobian / np.where(scale > 0.0, scale, 1.0)
    inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True)
    starts = np.linspace(0, count, BLOCKS, endpoint=False).astype(int)
    scores = np.add.reduceat(columns[:count] * residual[:count, None], starts, axis=0)
    weights = np.array([one.weight for one in rung.problem.expected])
    known = columns[count:] * (rung.problem.unit * np.sqrt(weights))[:, None]  # what is expected has an error of its own
    matrix = inverse @ (BLOCKS / (BLOCKS - 1) * (scores.T @ scores) + known.T @ known) @ inverse
    return matrix / np.where(scale > 0.0, scale, np.inf)[:, None] / np.where(scale > 0.0, scale, np.inf)


def observed(ladder: Ladder, replicates: np.ndarray | None = None) -> Observed:
    """Return what a ladder says, with the coordinates of fits to replicates, shape (replicate, coordinate), where there are any."""
    believed = ladder.believed
    matrix = sandwich(believed)
    if ladder.place > 0:
        most = MOVE_MOST * np.sqrt(np.diag(matrix))
        move = np.clip(believed.solution.theta - ladder.rungs[ladder.place - 1].solution.theta, -most, most)
        matrix = matrix + np.outer(move, move)
    if replicates is not None:
        bias = np.median(replicates, axis=0) - believed.solution.theta
        matrix = matrix + np.cov(replicates, rowvar=False) + np.outer(bias, bias)
    return Observed(ladder, matrix)


def covariance_of(seen: Observed) -> Covariance:
    """Return the standard errors of what is reported."""
    solution = seen.solution
    matrix = solution.derivative @ seen.matrix @ solution.derivative.T
    std = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    at_edge = np.array([name in solution.at_edge for name in solution.space.reported])
    correlation = matrix / np.outer(np.where(std > 0.0, std, np.nan), np.where(std > 0.0, std, np.nan))
    scale = np.linalg.norm(solution.jacobian, axis=0)
    condition = float(np.linalg.cond(solution.jacobian[:, scale > 0.0] / scale[scale > 0.0]))
    return Covariance(np.where(at_edge, np.nan, std), np.where(at_edge, np.nan, std), correlation, condition)


def with_observer(fit: Fit, estimation: Estimation, context: Context, ladder: Ladder, replicates: np.ndarray | None = None) -> Fit:
    """Return a fit with the parameters of the believed rung, and with intervals."""
    believed, seen = ladder.believed, observed(ladder, replicates)
    of_observer = replace(
        estimation,
        inverse=believed.problem.inverse,
        solution=believed.solution,
        problem=believed.problem,
        resampled=(believed.problem, believed.solution),
        covariance=covariance_of(seen),
    )
    try:
        better = fit_of(of_observer, context)
    except InputError:  # what a model does not allow
        return fit
    draws = np.array([believed.solution.space.numbers(theta) for theta in seen.draws()])
    seen_here = {one.name: _with_interval(one, believed.solution, draws) for one in better.estimates}
    estimates = tuple(seen_here[one.name] if one.name in believed.solution.space.reported else one for one in fit.estimates)
    bands = None
    if fit.resampling is not None:
        columns = {name: draws[:, place] for place, name in enumerate(believed.solution.space.reported) if name not in (DELAY, BEND)}
        bands = replace(fit.resampling, bands=replace(fit.resampling.bands, draws=columns))
    return replace(
        fit,
        plant=better.plant,
        friction=better.friction,
        estimates=estimates,
        combinations=better.combinations,
        correlation=better.correlation,
        correlation_names=better.correlation_names,
        condition_number=better.condition_number,
        traces=better.traces,
        force_error_percent=better.force_error_percent,
        resampling=bands,
    )


def _with_interval(estimate: Estimate, solution: Solution, draws: np.ndarray) -> Estimate:
    """Return an estimate with its interval: Student's t for the normal distribution of draws."""
    if estimate.status != "identified" or estimate.name not in solution.space.reported:
        return estimate
    drawn = draws[:, solution.space.reported.index(estimate.name)]
    low, high = np.percentile(drawn, [2.5, 97.5])
    wider = STUDENT / 1.96
    return replace(estimate, interval=(estimate.value + wider * (low - estimate.value), estimate.value + wider * (high - estimate.value)))


def foreseen(fit: Fit, estimation: Estimation, context: Context, logs: Sequence[Log], draws: int, report: Report = silent) -> Fit:
    """Return a fit with the parameters with which an observer foresees its logs best; intervals are those of replicates, too."""
    ladder = climb(estimation.inverse, estimation.solution.values, logs, context, between(report, 0.0, 0.4))
    believed, thetas, scale = ladder.believed, None, {}
    if draws:
        scatter = 0.0 if fit.resampling is None else fit.resampling.scatter.value
        thetas, errors = fits_to_replicates(ladder, context, scatter, between(report, 0.4, 1.0))
        scale = {"times": believed.error / float(np.median(errors))}
    numbers: dict[str, Number] = {"bandwidth": believed.problem.bandwidth, "error": believed.error, **scale}
    severity: Severity = "warning" if numbers.get("times", 0.0) > WORSE else "note"
    about = Diagnostic("prediction_error", severity=severity, numbers=numbers, kind=fit.friction.kind)
    return with_observer(replace(fit, diagnostics=(*fit.diagnostics, about)), estimation, context, ladder, thetas)


def fits_to_replicates(ladder: Ladder, context: Context, scatter: float, report: Report = silent) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates of fits to replicates of a log, shape (replicate, coordinate), and their prediction errors [m or rad]."""
    believed = ladder.believed
    first, *seeds = np.random.SeedSequence(SEED).spawn(REPLICATES + 1)
    scatter = scatter_of(believed, scatter, first)

    def fitted(seed: np.random.SeedSequence) -> tuple[np.ndarray, float]:
        problem = replicate(believed, scatter, np.random.default_rng(seed))
        rung = climbed(problem, believed.solution.values, context)
        return rung.solution.theta, rung.error

    ends = list[tuple[np.ndarray, float]]()
    with Abreast() as pool:
        for number, end in enumerate(pool.map(fitted, seeds)):
            ends.append(end)
            report((number + 1) / REPLICATES)
    thetas, errors = zip(*ends, strict=True)
    return np.array(thetas), np.array(errors)


def scatter_of(rung: Rung, most: float, seed: np.random.SeedSequence) -> float:
    """Return the scatter of the level, as a share of it, with which a replicate is foreseen as badly as the log was; at `most` this."""
    if most <= 0.0:
        return 0.0

    def square(scatter: float) -> float:
        drawn = replicate(rung, scatter, np.random.default_rng(seed))
        return float(np.mean(drawn.residual(rung.solution.values)[: drawn.settled_rows] ** 2))

    quiet, loud = square(0.0), square(most)
    share = (rung.error**2 - quiet) / (loud - quiet) if loud > quiet else 1.0
    return most * min(max(share, 0.0), 1.0) ** 0.5


def replicate(rung: Rung, scatter: float, rng: np.random.Generator) -> PredictionErrors:
    """Return the same problem on a log that the identified axis made: along the same motion, read by its encoder."""
    problem, inverse = rung.problem, rung.problem.inverse
    values = inverse.parameters.complete(rung.solution.values)
    plant, friction = inverse.plant(values), inverse.model(values)
    mass = float(next(values[name] for name in inverse.parameters.variables if name == "M"))
    parts, dataset = list[Recorded](), inverse.dataset
    for part, segment in zip(problem.parts, dataset.segments, strict=True):
        parts.append(_replicated(part, segment, plant, friction, mass, values, scatter, problem, rng))
    return replace(problem, parts=tuple(parts))


def _replicated(
    part: Recorded,
    segment: Segment,
    plant: Model,
    friction: Model,
    mass: float,
    values: Mapping[str, float],
    scatter: float,
    problem: PredictionErrors,
    rng: np.random.Generator,
) -> Recorded:
    dataset, dt, omega = problem.inverse.dataset, problem.dt, 2.0 * np.pi * HELD_AT
    count = part.position.size
    acted = part.efforts(values[DELAY], values[BEND], dt)[0, :count]
    commanded = np.append(0.5 * (acted[1:] + acted[:-1]), acted[-1])  # what is held until the next sample
    reference = np.zeros((4, count))
    reference[0], reference[1], reference[2] = segment.position, segment.velocity, segment.acceleration
    level = np.zeros(count)
    if scatter > 0.0:
        turns = np.cumsum(np.diff(np.signbit(segment.velocity), prepend=segment.velocity[0] < 0.0))
        level = scatter * rng.standard_normal(int(turns[-1]) + 1)[turns] * segment.friction(friction, dt)
    controller = cascade(kind=plant.kind, k_p=omega / (2.0 * DAMPED), k_v=2.0 * DAMPED * omega * mass, k_ff=1.0)
    trace = run_closed_loop(
        plant,
        friction,
        controller,
        encoder(kind=plant.kind, resolution=0.0),
        reference,
        dt,
        steps=problem.steps,
        injected=commanded,
        disturbance=level,
        x=float(segment.position[0]),
        v=float(segment.velocity[0]),
    )
    if trace.position.size < count:
        return part
    # What is held until the next sample acts half of one later, and smoothed by that.
    told = Recorded(trace.position, trace.effort, ()).efforts(-values[DELAY] - 0.5 * dt, -values[BEND] - dt**2 / 24.0, dt)[0, :count]
    noise = dataset.effort_noise * rng.standard_normal(count)
    effort = told + (through_filter(noise, problem.lag, dt) if problem.lag else noise)
    phase = rng.uniform(0.0, dataset.resolution)
    position = trace.position
    if dataset.resolution > 0.0:
        position = dataset.resolution * np.round((position + phase) / dataset.resolution) - phase
    return Recorded(position, effort, part.columns)
