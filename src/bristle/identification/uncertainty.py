"""How sure a fit is: intervals from replicates of the log, a cross-check, and what the log does not see.

It is the same for every problem, whatever the signal that it makes small.
"""

import math
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle.core.cores import Abreast
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.identification.bootstrap import Bootstrap, bootstrap
from bristle.identification.estimate import MATTERS, Estimate
from bristle.identification.estimation import Estimation
from bristle.identification.half_cycles import BLOCKS, correlation_time, within_cycles
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Role, names_of
from bristle.identification.problem import Problem
from bristle.identification.refit import Refit
from bristle.identification.result import Fit, Resampling
from bristle.identification.settings import Settings
from bristle.identification.simulated_bands import Bands, half_width

IN_DOUBT = 2.5  # times the scatter of replicates: what it takes to hold where the treatment is in doubt, as measured
AT_REVERSALS = ("presliding", "stribeck")
TREATMENT_DOUBTS = frozenset({"delay_unknown", "delay_rough", "delay_or_filter", "filter_suspect", "stages_differ"})
MOST_SCALE = 2.0  # of errors, of a model that lacks a force: what that was measured for


def with_uncertainty(
    fit: Fit, estimation: Estimation, draws: int, settings: Settings, report: Callable[[float], None] = lambda share: None
) -> Fit:
    """Return a fit with what so many replicates of its log say of it; `report` is told the share of the work done."""
    problem, solution = estimation.resampled
    # A share of a force that would not matter is not asked about.
    variables = estimation.inverse.parameters.variables
    clear = frozenset(
        estimate.name
        for estimate in fit.estimates
        if estimate.status == "identified"
        and estimate.larger_std is not None
        and (MOVED * estimate.takes > MATTERS or variables[estimate.name].quantity != "force")
    )
    lost = unidentifiable(problem, solution, clear, settings)
    # What is only weakly seen stays free: held, it would make the others look surer than they are.
    flat = {parameter.name for parameter in lost if parameter.flat}
    free = np.array([name not in flat for name in solution.space.names])
    linear = problem.refits_linearly(fit.friction)
    scale, unsure = birge_ratio(fit), _unsure(fit.diagnostics, estimation)
    wide = np.array([IN_DOUBT if name in unsure else 1.0 for name in solution.space.reported]) if unsure else None
    replicates = bootstrap(problem, solution, draws, free=free, linear=linear, scale=scale, wide=wide, report=report)
    bands, resolution = _bands(replicates, estimation), replicates.disturbance.resolution
    blurred = any(estimate.reason is not None and estimate.reason.code == "coarse_elements" for estimate in fit.estimates)
    resampling = Resampling(
        bands=replace(bands, inflation=_inflation(bands, fit, estimation, free, linear=linear)),
        scatter=replicates.scatter,
        half_cycles=problem.half_cycles.count,
        resolution=resolution,
        curve=replicates.curve,
        curve_from=settings.zone_counts * resolution if blurred else 0.0,
    )
    reasons = {parameter.name: parameter.diagnostic for parameter in lost}
    reasons |= _without_stiffness(fit.estimates, reasons, estimation.inverse)
    judged = (
        replace(estimate, status="unidentifiable", reason=reasons[name]) if name in reasons else estimate
        for name, estimate in fit.parameters.items()
    )
    estimates, about = zip(*(_with_interval(estimate, replicates, estimation.inverse) for estimate in judged), strict=True)
    diagnostics = [*fit.diagnostics, *reasons.values(), *(diagnostic for diagnostic in about if diagnostic is not None)]
    if unsure:
        diagnostics.append(Diagnostic("widened", severity="note", numbers={"names": unsure, "times": IN_DOUBT}))
    # What disturbed the replicates, and what of the residual is none of it.
    numbers = {
        "draws": bands.count,
        "resolution": resolution,
        "scatter_percent": 100.0 * replicates.scatter.value,
        "half_cycles": resampling.half_cycles,
        "unexplained": replicates.unexplained,
        "noise": bands.noise,
        **({"loop": 1} if problem.in_loop else {}),
    }
    diagnostics.append(Diagnostic(problem.intervals_code, "", "note", numbers, fit.friction.kind))
    return replace(fit, estimates=estimates, resampling=resampling, diagnostics=tuple(diagnostics))


def birge_ratio(fit: Fit) -> float:
    """Return how many times as large as by chance the errors of a fit are whose model lacks a force, at least 1.

    Replicates know of what chance leaves over alone. R. T. Birge, Physical Review 40(2), 1932, doi:10.1103/PhysRev.40.207
    """
    structures = (diagnostic.numbers for diagnostic in fit.diagnostics if diagnostic.code == "structure")
    missing, chance = next(((numbers["missing"], numbers["chance"]) for numbers in structures), (0.0, 1.0))
    assert isinstance(missing, float)
    assert isinstance(chance, float)
    return min(math.hypot(missing, chance) / max(chance, np.finfo(float).tiny), MOST_SCALE)


def _unsure(diagnostics: Sequence[Diagnostic], estimation: Estimation) -> tuple[str, ...]:
    """Return the parameters that show where friction turns, where it is in doubt how a log is to be treated."""
    # A replicate is treated as it is made, so that replicates know nothing of such a doubt.
    problem, solution = estimation.resampled
    variables, doubts = problem.parameters.variables, TREATMENT_DOUBTS.intersection(diagnostic.code for diagnostic in diagnostics)
    turning = (name for name in solution.space.reported if name in variables and variables[name].excitation in AT_REVERSALS)
    return tuple(turning) if doubts else ()


def _identified(estimates: Sequence[Estimate]) -> list[str]:
    return [estimate.name for estimate in estimates if estimate.status == "identified"]


def _without_stiffness(estimates: Sequence[Estimate], lost: Container[str], problem: InverseDynamics) -> dict[str, Diagnostic]:
    """Return why what damps a stiffness is not identified, where no stiffness is: beside another one it is another."""
    variables, kind = problem.parameters.variables, problem.dataset.kind
    names = [estimate.name for estimate in estimates if estimate.status in ("identified", "held") and estimate.name not in lost]
    stiff = names_of(Role.STIFFNESS, variables)
    damping = set(names).intersection(names_of(Role.MICRO_DAMPING, variables))
    if not stiff or not set(stiff).isdisjoint(names):
        return {}
    numbers: dict[str, Number] = {"stiffness": stiff[0]}
    return {name: Diagnostic("unseen", name, "warning", numbers, kind) for name in damping}


def _bands(replicates: Bootstrap, estimation: Estimation) -> Bands:
    """Return what a band around an effort is made of; what a position lacks is none of it."""
    problem, _ = estimation.resampled
    members = [estimation.finished(member) for member in replicates.members]
    lacking, rest = replicates.unexplained if problem.is_effort else 0.0, replicates.residual
    jitter = replicates.disturbance.jitter  # until a loop is simulated, the least that it leaves over
    if replicates.scatter.value > 0.0:
        rest = within_cycles(problem.half_cycles, replicates.slope, rest)
    return Bands(
        draws={name: np.array([member[name] for member in members]) for name in members[0] if name not in problem.parameters.loop},
        scatter=replicates.scatter.value,
        noise=replicates.disturbance.noise,
        unexplained=lacking,
        lasting=correlation_time(rest, problem.row_time, lacking),
        left_in_closed_loop=jitter,
        left_in_open_loop=jitter,
    )


def _inflation(bands: Bands, fit: Fit, estimation: Estimation, free: np.ndarray, *, linear: bool) -> float:
    """Return the factor that makes bands hold 95 % of the rows of parts that were held out, at least 1."""
    problem, solution = estimation.resampled
    width, share = half_width(bands, fit.plant, fit.friction, problem.dataset), []
    for fold in problem.folds(BLOCKS)[1]:
        if fold.fitted.any() and fold.of_dataset.any():
            theta, residual = Refit(solution, free, fold.fitted, linear).solve(problem, solution.theta)
            rows = problem.effort_residual(solution.space.values(theta), residual)
            share.append(np.abs(rows[fold.of_dataset]) / width[fold.of_dataset])
    return max(float(np.quantile(np.concatenate(share), 0.95)), 1.0) if share else 1.0


def _with_interval(estimate: Estimate, replicates: Bootstrap, problem: InverseDynamics) -> tuple[Estimate, Diagnostic | None]:
    """Return an estimate with its 95 % interval, where it was fitted to replicates; what was fitted lies in it."""
    low, high = replicates.interval(estimate.name) if estimate.name in replicates.reported else (0.0, 0.0)
    if low == high:  # Where all replicates end on the edge where the fit ended, there is no interval.
        return estimate, None
    warning, alignment = None, problem.dataset.alignment
    variable = problem.parameters.plant.variables.get(estimate.name)
    if alignment is not None and alignment.mass is not None and alignment.mass_half_width is not None:
        first = alignment.mass - alignment.mass_half_width, alignment.mass + alignment.mass_half_width
        # That of an inertia reaches over that of the first stage where both have nothing in common.
        if variable is not None and Role.INERTIA.fits(variable) and (high < first[0] or first[1] < low):
            numbers = {"first": alignment.mass, "value": estimate.value}
            warning = Diagnostic("stages_differ", estimate.name, "warning", numbers, problem.dataset.kind)
            low, high = min(first[0], low), max(first[1], high)
    return replace(estimate, interval=(min(low, estimate.value), max(high, estimate.value))), warning


MOVED = 0.3  # share by which a parameter is moved away; A. Raue et al., Bioinformatics 25(15), 2009, doi:10.1093/bioinformatics/btp358
BEYOND_DOUBT = 100.0  # times the threshold, in the linear fit
CHUNKS = 40


@dataclass(frozen=True)
class Unidentifiable:
    """A parameter that the log does not see, and by how much it was changed [%]."""

    name: str
    rise: float
    flat: bool
    instead: tuple[str, ...]
    percent: float

    @property
    def diagnostic(self) -> Diagnostic:
        """Why."""
        others: dict[str, Number] = {"instead": self.instead} if self.instead else {}
        return Diagnostic("unseen", self.name, numbers={"percent": self.percent, **others})


def unidentifiable(problem: Problem, solution: Solution, candidates: frozenset[str], settings: Settings) -> tuple[Unidentifiable, ...]:
    r"""Return the parameters that a log does not see, each with those found before it held.

    A parameter is changed by 30 %, up and down, and all others are fitted again, on three quarters of the rows in turn.
    If the error on the last quarter rises in neither case by more than the 95 % threshold of a likelihood ratio,

    .. math:: \sum_\text{quarters} \left(\|r'\|^2 - \|r\|^2\right) < \chi^2_{1,\,0.95}\; s^2,

    the log does not see that parameter. With it held where it is, the others are asked again: of a product of two, only
    one is not seen. Where the rise is a hundred times that in the linear fit around the solution, nobody needs to ask.
    Only `candidates` are asked about; those that are zero, or on an edge, have no 30 %.
    """
    names = solution.space.names
    free = np.ones(len(names), dtype=bool)
    lost: list[Unidentifiable] = []
    doubtful = [name for name in names if name in candidates and solution.values[name] != 0.0]
    followed = _Followed(problem, solution, free)
    # Where the linear fit makes sure that a parameter is seen, nobody asks.
    linear = {name: min(followed.linear_rise(name, change) for change in followed.changes) for name in doubtful}
    doubtful = [name for name, rise in linear.items() if not rise >= BEYOND_DOUBT * settings.seen_rise]
    while doubtful:
        around = _Followed(problem, solution, free)
        with Abreast() as pool:
            rises = dict(zip(doubtful, pool.map(around.without, doubtful), strict=True))
        least = min(doubtful, key=lambda name: rises[name].rise)
        if rises[least].rise >= settings.seen_rise:
            break
        lost.append(rises[least])
        free[names.index(least)] = False
        # Those that are clearly seen now are seen with one parameter less to follow, too.
        doubtful = [name for name in doubtful if name != least and rises[name].rise < settings.seen_rise]
    return tuple(lost)


@dataclass(frozen=True)
class _Followed:
    """One parameter after another moved away, the others that are `free`, shape (coordinate,) of bool, in pursuit."""

    problem: Problem
    solution: Solution
    free: np.ndarray

    @property
    def changes(self) -> tuple[float, float]:
        """Times by which a parameter is moved."""
        return 1.0 + MOVED, 1.0 - MOVED

    def without(self, name: str) -> Unidentifiable:
        """Return by how much the error rises where one parameter is changed, and which made up for the change."""
        names, starts = self.solution.space.names, [self.moved(name, change) for change in self.changes]
        followers, ends = self.free & (np.array(names) != name), []
        for fitted, judged, before in self._trials:
            refit = Refit(self.solution, followers, fitted)
            solved = [refit.solve(self.problem, start) for start in starts]
            ends.append(([theta for theta, _ in solved], [float(np.sum(after[judged] ** 2)) - before for _, after in solved]))
        (thetas, rises), *held_out = ends
        then, others = self.solution.values, [self.solution.space.values(theta) for theta in thetas]
        asked = [part for part in names if part != name and then.get(part)]  # those that are zero have no share to change by
        instead = tuple(part for part in asked if any(abs(now[part] - then[part]) > 0.1 * abs(then[part]) for now in others))
        return Unidentifiable(
            name,
            rise=float(np.max(np.sum([quarter for _, quarter in held_out], axis=0))) / self._variance,
            flat=max(rises) < 0.1 * self._variance,
            instead=instead,
            percent=100.0 * MOVED,
        )

    @cached_property
    def _trials(self) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Rows that are fitted, rows that are judged, and the squared error there: all of them, then each quarter."""
        count = self.solution.jacobian.shape[0]
        quarter = (np.random.default_rng(CHUNKS).permutation(CHUNKS) % 4)[np.arange(count) * CHUNKS // count]
        rows = np.ones(count, dtype=bool)
        trials = [(rows, rows), *((quarter != number, quarter == number) for number in range(4))]
        return [
            (
                fitted,
                judged,
                float(np.sum(Refit(self.solution, self.free, fitted).solve(self.problem, self.solution.theta)[1][judged] ** 2)),
            )
            for fitted, judged in trials
        ]

    @cached_property
    def _variance(self) -> float:
        start = self.problem.residual(self.solution.values)
        return float(start @ start) / max(start.size - len(self.solution.space.names), 1)

    def linear_rise(self, name: str, change: float) -> float:
        """Return the rise of the error, over its variance, of a linear fit in which a parameter is another one."""
        index = self.solution.space.names.index(name)
        # The Jacobian in coordinates of its own range is as good for lengths, and much smaller.
        triangle = np.asarray(np.linalg.qr(self.solution.jacobian, mode="r"))
        own, rest = triangle[:, index], np.delete(triangle, index, axis=1)
        alone = own - rest @ unbounded(rest, own)
        way = self.moved(name, change)[index] - self.solution.theta[index]
        return float(alone @ alone) * way**2 / self._variance if self._variance > 0.0 else np.inf

    def moved(self, name: str, change: float) -> np.ndarray:
        """Return the coordinates at which only this parameter is another one."""
        space, theta, goal = self.solution.space, self.solution.theta.copy(), change * self.solution.values[name]
        index = space.names.index(name)
        for _ in range(30):
            value, nudge, nudged = space.values(theta)[name], 1e-6 * max(abs(theta[index]), 1e-3), theta.copy()
            nudged[index] += nudge
            slope = (space.values(nudged)[name] - value) / nudge
            if slope == 0.0:
                break
            step = (goal - value) / slope
            theta[index] = np.clip(theta[index] + step, space.low[index], space.high[index])
            if abs(step * slope) <= 1e-9 * abs(goal):
                break
        return theta
