r"""From a log to friction models with their uncertainty, by inverse dynamics.

.. math:: u = M \ddot q + F(\dot q, \dots) + \text{offset}

holds in every row of a regression; the parameters minimise the sum of squares of what is left over. No simulation is
involved, and the controller that was running does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.errors import InputError
from bristle.friction import base_of, find, gms, maxwell_slip
from bristle.friction.slots import SlottedModel
from bristle.identification.asked import Known, freed, known_of, models_of, refuse_reversed_effort, unknowns_of
from bristle.identification.break_away import break_aways
from bristle.identification.elements import Elements, of_one_speed
from bristle.identification.findings import fit_of
from bristle.identification.given import logs_and_axes, none_or_more, treatment_of
from bristle.identification.held_out import held_out_error
from bristle.identification.information import with_information
from bristle.identification.interruption import UNFINISHED, obey
from bristle.identification.output_error import OutputError, held_out_position, one_period, refined
from bristle.identification.places import pitch_in
from bristle.identification.problem import Problem
from bristle.identification.ranking import in_order
from bristle.identification.regression import Regression
from bristle.identification.repetition import about_repeated_logs, about_repetition
from bristle.identification.resampling.assessment import assessed
from bristle.identification.resampling.refit import Space, space_of
from bristle.identification.result import Fit, HeldOut, Identification
from bristle.identification.search import Report, Search
from bristle.identification.several import treat_all
from bristle.identification.shaped import in_lists, shaped
from bristle.identification.solution import Solution, solve_linear
from bristle.identification.stribeck_elements import StribeckElements
from bristle.identification.unknowns import Scales, scales_of
from bristle.logs.log import Log
from bristle.simulation.result import relative_error_percent

__all__ = ["identify"]

FEWEST_DRAWS = 20
OF_THIS_SHAPE = "errors and intervals are those for elements of this shape: their shares do not vary in them"
LEAST_LEVEL = 0.01  # of the effort: a Coulomb force that says nothing of the magnitude of friction

Progress = Callable[[float, str], None]


def identify(
    log: Log | str | PathLike[str] | Sequence[Log | str | PathLike[str]], model: Any = "coulomb_viscous", *,
    axis: Axis | str | PathLike[str] | Sequence[Axis | str | PathLike[str]] | None = None,
    cutoff: float | str | None = None, decimation: int | None = None, blocks: int = 5,
    offset: float | str | None = None, mass: float | str | None = None, free: str | Sequence[str] = (),
    draws: int = 200, progress: Progress | None = None,
) -> Identification:  # fmt: skip
    """Identify one friction model or several from a log, with the inertia, and rank them.

    Parameters
    ----------
    log : Log or path-like, or list of either
        Position and effort, or the file that holds them. Of several logs, each is held out in turn.
    model : str, FrictionModel, or list of either
        ``"lugre"``, ``"coulomb_viscous,stribeck+asymmetry"``, a model of your own.
    axis : Axis or path-like, or list of either, optional
        One for all logs, or one for each. What is known, or the file that says it: mass, offset, encoder resolution,
        cut-off and decimation.
    cutoff : float or str, optional
        Cut-off of the zero-phase filter [Hz], or text such as ``"100 Hz"``; a tenth of the sampling frequency by
        default.
    decimation : int, optional
        Of how many samples one row is kept; 10 by default.
    blocks : int
        Contiguous time blocks, each held out in turn, by whose error models are ranked; 0 for none.
    offset : float, str or "identify", optional
        Constant part of the force [N or N*m] if known, or text with a unit; the axis decides where it is not given.
    mass : float or str, optional
        Moving mass [kg] or inertia [kg*m^2] if known, or text with a unit; the axis decides where it is not given.
    free : str or sequence of str
        Shapes that are identified too, instead of being kept at their default: ``"exponent"`` of the Dahl model;
        several separated by commas.
    draws : int
        Logs that are simulated with the best model and fitted again, for its 95 % intervals; 0 for none.
    progress : callable, optional
        Called with the share of the work done and what is being done.

    Returns
    -------
    Identification
        The models, best first.

    Raises
    ------
    InputError
        If the log or the axis does not serve, or there is no such model.

    References
    ----------
    .. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
       identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
    """
    given = logs_and_axes(log, axis)
    logs, axes = [log for log, _ in given], [axis for _, axis in given]
    components = models_of(model)
    blocks, draws = none_or_more(blocks, "blocks", 2), none_or_more(draws, "draws", FEWEST_DRAWS)
    _refuse_without_effort(logs)
    kind = logs[0].kind
    known = replace(known_of(axes[0], mass, offset, kind), free=freed(free, components))
    by_output = any(axis is not None and axis.method == "output_error" for axis in axes)
    treated = [one_period(log, axis) for log, axis in zip(logs, axes, strict=True)] if by_output else logs
    regression = treat_all(treated, axes, *treatment_of(cutoff, decimation, kind))
    workbench = _Workbench.of(regression, known, tuple(zip(logs, axes, strict=True)) if by_output else ())
    count = len(components) + bool(draws)
    fits = _fits(workbench, components, blocks, lambda number, what: _share(progress, number, count, what))
    first, *others = (replace(fit, rank=rank) for rank, fit in enumerate(with_information(in_order(fits)), 1))
    unfinished = _unfinished(fits, [one.name for one in components])
    if draws and not unfinished:
        report = _share(progress, len(components), count, f"fitting {first.name} to simulated logs")
        try:
            first = workbench.assessed(first, draws, report)
        except KeyboardInterrupt as error:
            obey(error)
            unfinished = "interrupted: the intervals are not those of simulated logs"
    return Identification(
        (first, *others), logs[0], _treatment(regression), tuple(logs[1:]), unfinished,
        break_aways(regression, first.plant, first.friction),
    )  # fmt: skip


def _fits(
    workbench: _Workbench, components: Sequence[FrictionModel], blocks: int, share: Callable[[int, str], Report]
) -> list[Fit]:
    """Return the fits of several models, as many as a person waits for."""
    fits: list[Fit] = []
    for number, component in enumerate(components):
        try:
            fits.append(workbench.fit(component, blocks, share(number, f"fitting {component.name}")))
        except KeyboardInterrupt as error:
            obey(error, anything=bool(fits))
            break
        if fits[-1].unfinished:
            break
    return fits


def _treatment(regression: Regression) -> dict[str, float]:
    found = {
        "cutoff": regression.cutoff,
        "decimation": float(regression.decimation),
        "dropped": float(regression.dropped),
        "rows": float(regression.effort.size),
        "rest_percent": 100.0 * regression.rest_share,
        "velocity_max": float(np.max(np.abs(regression.velocity))),
    }
    return found | ({"delay": regression.delay} if regression.delay else {})


def _refuse_without_effort(logs: Sequence[Log]) -> None:
    for one in logs:
        if one.effort is None:
            raise InputError("has no effort, which inverse dynamics needs", path=f"log {one.source.name}".strip(),
                             mend="Name the column of force, torque or current in the axis file")  # fmt: skip


def _unfinished(fits: Sequence[Fit], asked: Sequence[str]) -> str:
    """Return what was interrupted, in words; nothing where all was done."""
    missing = asked[len(fits) :]
    said = [f"{fit.name} is the best found until then" for fit in fits if fit.unfinished]
    said += [f"{', '.join(missing)} {'was' if len(missing) == 1 else 'were'} not fitted"] if missing else []
    return f"interrupted: {'; '.join(said)}" if said else ""


def _share(progress: Progress | None, number: int, count: int, what: str) -> Report:
    def report(share: float, remark: str = "") -> None:
        if progress is not None:
            progress((number + share) / count, f"{what}{remark and f', {remark}'}")

    return report


def _unbounded(regression: Regression, known: Known) -> dict[str, float]:
    """Return the parameters of Coulomb and viscous friction without their bounds."""
    unknowns = unknowns_of(find("coulomb_viscous"), known, regression)
    problem = Problem(regression, unknowns)
    free = np.linalg.lstsq(problem.columns, regression.effort - problem.held_effort, rcond=None)[0]
    return unknowns.complete(dict(zip(unknowns.free, free.tolist(), strict=True)))


@dataclass(frozen=True)
class _Workbench:
    """What the fits of all models to one log share."""

    regression: Regression
    known: Known
    sliding: dict[str, float]
    scales: Scales
    simulated: tuple[tuple[Log, Axis | None], ...] = ()
    found: dict[str, tuple[Problem, Space]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, regression: Regression, known: Known, simulated: tuple[tuple[Log, Axis | None], ...] = ()
    ) -> _Workbench:
        """Fit Coulomb and viscous friction first: it checks the sign of the effort and sets the scale of all else."""
        effort = float(np.sqrt(np.mean(regression.effort**2)))
        if effort == 0.0:
            raise InputError("is zero throughout", path="log.effort", mend="Check which column holds the effort")
        # A mass that is known must not hide that the effort pushes the other way.
        refuse_reversed_effort(regression, _unbounded(regression, Known(plant=known.plant)))
        unknowns = unknowns_of(find("coulomb_viscous"), known, regression)
        bounded = unknowns.complete(solve_linear(Problem(regression, unknowns)).values)
        if bounded["F_C"] <= LEAST_LEVEL * effort:
            # Pre-sliding over much of the stroke looks viscous: its level is that of all friction.
            friction = bounded["F_v"] * regression.velocity + bounded["F_C"] * np.sign(regression.velocity)
            bounded["F_C"] = max(float(np.sqrt(np.mean(friction**2))), bounded["F_C"])
        return cls(regression, known, bounded, scales_of(regression, max(bounded["F_C"], 0.01 * effort)), simulated)

    def fit(self, component: FrictionModel, blocks: int, report: Report) -> Fit:
        """Fit one model."""
        report(0.0)
        if "pitch" in component.variables and self.known.pitch is None:
            known = replace(self.known, pitch=self._pitch())
            return replace(self, known=known).fit(component, blocks, report)
        if isinstance(component, SlottedModel) and base_of(component) is maxwell_slip:
            return self._fit_elements(component, blocks, report)
        if isinstance(component, SlottedModel) and base_of(component) is gms:
            return self._fit_stribeck_elements(component, blocks, report)
        problem = Problem(self.regression, unknowns_of(component, self.known, self.regression))
        if component.linear and not component.relations:
            solution = solve_linear(problem)

            def on_rows(rows: np.ndarray):
                return solve_linear(problem, rows)
        else:
            search = Search(problem, self.scales, self.sliding)
            solution = search.solve(lambda share, remark="": report((0.2 if self.simulated else 0.6) * share, remark))

            def on_rows(rows: np.ndarray):
                return search.refit(solution.values, rows)

        if self.simulated and not solution.unfinished:
            return self._by_output(problem, solution, blocks, report)

        def predicted(rows: np.ndarray) -> np.ndarray:
            return problem.predicted(problem.unknowns.complete(on_rows(rows).values))

        self.found[component.name] = problem, space_of(problem, solution, self.scales)
        fit = fit_of(problem, solution, self.scales)
        if not blocks or solution.unfinished:
            return self._finished(fit, None, unfinished=solution.unfinished)
        try:
            held_out = held_out_error(self.regression, predicted, blocks, lambda share: report(0.6 + 0.4 * share))
        except KeyboardInterrupt as error:
            obey(error)
            return self._finished(fit, None, unfinished=True)
        report(1.0)
        return self._finished(fit, held_out)

    def assessed(self, fit: Fit, draws: int, report: Report) -> Fit:
        """Return a fit of this bench with its intervals from simulated logs."""
        return assessed(fit, *self.found[fit.name], draws, report) if fit.name in self.found else fit

    def _by_output(self, problem: Problem, start: Solution, blocks: int, report: Report) -> Fit:
        """Fit one model to the position, from where inverse dynamics ended."""
        logs, axes = [log for log, _ in self.simulated], [axis for _, axis in self.simulated]
        solution, fine, coarse = refined(
            problem,
            start,
            logs,
            axes,
            self.scales,
            self.sliding,
            lambda share, remark="": report(0.2 + 0.6 * share, remark),
        )
        assert isinstance(fine.problem, OutputError)
        measured, residual = fine.problem.measured, fine.problem.residual(solution.values)
        fit = replace(
            fit_of(problem, solution, self.scales, residual),
            position_error_percent=relative_error_percent(measured, measured - residual),
            position_rmse=float(np.sqrt(np.mean(residual**2))),
            held_out=held_out_position(coarse, solution.values, blocks) if blocks and not solution.unfinished else None,
        )
        report(1.0)
        return self._finished(fit, fit.held_out, unfinished=solution.unfinished)

    def _fit_elements(self, component: SlottedModel, blocks: int, report: Report) -> Fit:
        """Fit elements that slip: their shape comes with the solution."""
        prototype = shaped(component, np.ones(1), np.ones(1))
        unknowns = of_one_speed(unknowns_of(prototype, self.known, self.regression), self.regression)
        elements = Elements(self.regression, component, unknowns)

        def predicted(rows: np.ndarray) -> np.ndarray:
            there, best = elements.solution(rows)
            return there.predicted(there.unknowns.complete(best.values))

        problem, solution = elements.solution()
        self.found[component.name] = elements.space()
        report(0.5)
        return self._of_elements(fit_of(problem, solution, self.scales), predicted, blocks, report)

    def _fit_stribeck_elements(self, component: SlottedModel, blocks: int, report: Report) -> Fit:
        """Fit elements that slip by a curve: shape and curve in turn."""
        problems = StribeckElements(self.regression, component, self.known, self.scales, self.sliding)
        problem, solution, elements = problems.solve(lambda share, remark="": report(0.5 * share, remark))

        def predicted(rows: np.ndarray) -> np.ndarray:
            there, best = problems.on_rows(elements, solution, rows)
            return there.predicted(there.unknowns.complete(best.values))

        self.found[component.name] = problems.space(problem, solution)
        fit = fit_of(problem, solution, self.scales)
        fit = replace(fit, assumptions=(*fit.assumptions, OF_THIS_SHAPE))
        return self._of_elements(fit, predicted, blocks, report)

    def _of_elements(
        self, fit: Fit, predicted: Callable[[np.ndarray], np.ndarray], blocks: int, report: Report
    ) -> Fit:  # fmt: skip
        """Return a fit with its elements in lists and, where asked for, its error on held-out blocks."""
        held_out = None
        if blocks:
            held_out = held_out_error(self.regression, predicted, blocks, lambda share: report(0.5 + 0.5 * share))
        report(1.0)
        friction = in_lists(fit.friction)
        # Level and stiffness count among the parameters.
        further = max(len(friction.values["k_i"]) - 2, 0)
        return self._finished(replace(fit, friction=friction, further=further), held_out)

    def _finished(self, fit: Fit, held_out: HeldOut | None, *, unfinished: bool = False) -> Fit:
        repeated = ()
        if held_out is not None and held_out.of == "logs":
            repeated = about_repeated_logs(self.regression)
        elif held_out is not None and not self.simulated:
            repeated = about_repetition(self.regression)
        said = (UNFINISHED,) if unfinished else ()
        return replace(fit, held_out=held_out, unfinished=unfinished, warnings=(*said, *fit.warnings, *repeated))

    def _pitch(self) -> float:
        """Return the pitch of the screw, found in what Coulomb and viscous friction leave."""
        problem = Problem(self.regression, unknowns_of(find("coulomb_viscous"), self.known, self.regression))
        return pitch_in(problem, self.sliding)
