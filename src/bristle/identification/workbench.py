"""What the fits of all models to one log share, and how each of them is made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError
from bristle.core.interruption import UNFINISHED, obey
from bristle.core.least_squares import unbounded
from bristle.friction import base_of, find, gms, maxwell_slip
from bristle.friction.slots import SlottedModel
from bristle.identification.dataset import Dataset
from bristle.identification.diagnostics.repetition import about_repeated_logs, about_repetition
from bristle.identification.elements import Elements, of_one_speed
from bristle.identification.fitted import fit_of
from bristle.identification.held_out import held_out_error
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.output_error import refuse_elements
from bristle.identification.parameters import Scales, scales_of
from bristle.identification.refinement import Refinement, held_out_output
from bristle.identification.request import PriorKnowledge, refuse_reversed_effort, parameters_of
from bristle.identification.resampling.assessment import assessed
from bristle.identification.resampling.output_assessment import assessed_output
from bristle.identification.resampling.refit import coordinates_around, space_of
from bristle.identification.result import Fit, HeldOut
from bristle.identification.search import Report, Search
from bristle.identification.settings import DEFAULT, Settings
from bristle.identification.shaped import in_lists, shaped
from bristle.identification.slot_parameters import pitch_in
from bristle.identification.solution import Solution, solve_linear
from bristle.identification.stribeck_elements import StribeckElements
from bristle.logs.log import Log

__all__ = ["Simulated", "Workbench"]

START, SEARCH, REFINED = 0.2, 0.6, 0.8  # of the work, where each ends
OF_THIS_SHAPE = Diagnostic("element-shape", severity="note")
LEAST_LEVEL = 0.01  # of the effort: a Coulomb force that says nothing of the magnitude of friction


class Simulated(NamedTuple):
    """What output error simulates: the logs, and the ``"open"`` or ``"closed"`` loop of each."""

    logs: Sequence[Log]
    axes: Sequence[Axis | None]
    loop: str


Assessment = Callable[[Fit, int, Report], Fit]


@dataclass(frozen=True)
class Workbench:
    """What the fits of all models to one log share.

    Parameters
    ----------
    dataset : Dataset
        The rows of inverse dynamics.
    known : Known
        What is known of the axis beforehand.
    sliding : dict
        Coulomb and viscous friction with the plant, as a linear fit finds them [SI].
    scales : Scales
        Typical magnitudes of the log.
    everywhere : bool
        Whether the whole range of each parameter is looked at.
    refinement : Refinement or None
        The search for the least output error, where that is asked for.
    found : dict
        How the intervals of each model fitted so far are found, by its name.
    settings : Settings
        The thresholds of what is said of a fit.
    """

    dataset: Dataset
    known: PriorKnowledge
    sliding: dict[str, float]
    scales: Scales
    everywhere: bool = False
    refinement: Refinement | None = None
    found: dict[str, Assessment] = field(default_factory=dict)
    settings: Settings = DEFAULT

    @classmethod
    def of(
        cls, dataset: Dataset, known: PriorKnowledge, simulated: Simulated | None = None, *, everywhere: bool = False
    ) -> Workbench:
        """Fit Coulomb and viscous friction first: it checks the sign of the effort and sets the scale of all else.

        Raises
        ------
        InputError
            If the effort is zero, or pushes the other way.
        """
        effort = float(np.sqrt(np.mean(dataset.effort**2)))
        if effort == 0.0:
            raise InputError("is zero throughout", path="log.effort", mend="Check which column holds the effort")
        # A mass that is known must not hide that the effort pushes the other way.
        refuse_reversed_effort(dataset, _unbounded(dataset, PriorKnowledge(plant=known.plant)))
        parameters = parameters_of(find("coulomb_viscous"), known, dataset)
        bounded = parameters.complete(solve_linear(InverseDynamics(dataset, parameters)).values)
        if bounded["F_C"] <= LEAST_LEVEL * effort:
            # Pre-sliding over much of the stroke looks viscous: its level is that of all friction.
            friction = bounded["F_v"] * dataset.velocity + bounded["F_C"] * np.sign(dataset.velocity)
            bounded["F_C"] = max(float(np.sqrt(np.mean(friction**2))), bounded["F_C"])
        scales = scales_of(dataset, max(bounded["F_C"], 0.01 * effort))
        refinement = Refinement(*simulated, scales, bounded, everywhere) if simulated else None
        return cls(dataset, known, bounded, scales, everywhere, refinement)

    def fit(self, component: FrictionModel, blocks: int, report: Report) -> Fit:
        """Fit one model."""
        report(0.0)
        if self.refinement is not None:
            refuse_elements(component)
        if "pitch" in component.variables and self.known.pitch is None:
            known = replace(self.known, pitch=self._pitch())
            return replace(self, known=known).fit(component, blocks, report)
        if isinstance(component, SlottedModel) and base_of(component) is maxwell_slip:
            return self._fit_elements(component, blocks, report)
        if isinstance(component, SlottedModel) and base_of(component) is gms:
            return self._fit_stribeck_elements(component, blocks, report)
        problem = InverseDynamics(self.dataset, parameters_of(component, self.known, self.dataset))
        if self.refinement is not None:
            start = self._start(problem, lambda share, remark="": report(START * share, remark))
            if start.unfinished:
                return self._finished(
                    fit_of(problem, start, self.scales, settings=self.settings), None, unfinished=True
                )
            return self._finished(*self._refined(self.refinement, problem, start, blocks, report))
        if component.linear and not component.relations:
            solution = solve_linear(problem)

            def on_rows(rows: np.ndarray) -> Solution:
                return solve_linear(problem, rows)
        else:
            search = Search(problem, self.scales, self.sliding)
            solution = search.solve(lambda share, remark="": report(SEARCH * share, remark), everywhere=self.everywhere)

            def on_rows(rows: np.ndarray) -> Solution:
                return search.refit(solution.values, rows)

        def predicted(rows: np.ndarray) -> np.ndarray:
            return problem.predicted(problem.parameters.complete(on_rows(rows).values))

        space = space_of(problem, solution, self.scales)
        self.found[component.name] = lambda fit, draws, told: assessed(fit, problem, space, draws, self.settings, told)
        fit = fit_of(problem, solution, self.scales, settings=self.settings)
        if not blocks or solution.unfinished:
            return self._finished(fit, None, unfinished=solution.unfinished)
        try:
            held_out = held_out_error(
                self.dataset,
                predicted,
                blocks,
                lambda share: report(SEARCH + (1.0 - SEARCH) * share),
                self.settings,
            )
        except KeyboardInterrupt as error:
            obey(error)
            return self._finished(fit, None, unfinished=True)
        report(1.0)
        return self._finished(fit, held_out)

    def assessed(self, fit: Fit, draws: int, report: Report) -> Fit:
        """Return a fit of this bench with its intervals from simulated logs."""
        return self.found[fit.name](fit, draws, report) if fit.name in self.found else fit

    def _start(self, problem: InverseDynamics, report: Report) -> Solution:
        """Return the solution of inverse dynamics from which the simulation goes on."""
        component = problem.parameters.component
        if component.linear and not component.relations:
            return solve_linear(problem)
        return Search(problem, self.scales, self.sliding, simulates=True).solve(report)

    def _refined(
        self, refinement: Refinement, inverse: InverseDynamics, start: Solution, blocks: int, report: Report
    ) -> tuple[Fit, HeldOut | None, bool]:
        """Return the fit of least output error, from where inverse dynamics ended; and whether it was interrupted."""

        def told(share: float, remark: str = "") -> None:
            report(START + (REFINED - START) * share, remark)

        solution, error = refinement.of(inverse, start, told)
        residual = error.residual(solution.values)
        fit = replace(
            fit_of(error.inverse, solution, self.scales, residual, error.diagnostic, self.settings),
            **error.told(solution.values),
        )
        if solution.unfinished:
            return fit, None, True
        space = coordinates_around(error.parameters, solution, self.scales)
        self.found[fit.name] = lambda fit, draws, said: assessed_output(fit, error, space, draws, self.settings, said)
        if not blocks:
            return fit, None, False
        try:
            held_out = held_out_output(
                error, space, blocks, lambda share, remark="": report(REFINED + (1.0 - REFINED) * share)
            )
        except KeyboardInterrupt as interruption:
            obey(interruption)
            return fit, None, True
        report(1.0)
        return fit, held_out, False

    def _fit_elements(self, component: SlottedModel, blocks: int, report: Report) -> Fit:
        """Fit elements that slip: their shape comes with the solution."""
        prototype = shaped(component, np.ones(1), np.ones(1))
        parameters = of_one_speed(parameters_of(prototype, self.known, self.dataset), self.dataset)
        elements = Elements(self.dataset, component, parameters)

        def predicted(rows: np.ndarray) -> np.ndarray:
            there, best = elements.solution(rows)
            return there.predicted(there.parameters.complete(best.values))

        problem, solution = elements.solution()
        parts = elements.space()
        self.found[component.name] = lambda fit, draws, told: assessed(fit, *parts, draws, self.settings, told)
        report(0.5)
        return self._of_elements(
            fit_of(problem, solution, self.scales, settings=self.settings), predicted, blocks, report
        )

    def _fit_stribeck_elements(self, component: SlottedModel, blocks: int, report: Report) -> Fit:
        """Fit elements that slip by a curve: shape and curve in turn."""
        problems = StribeckElements(self.dataset, component, self.known, self.scales, self.sliding)
        problem, solution, elements = problems.solve(lambda share, remark="": report(0.5 * share, remark))

        def predicted(rows: np.ndarray) -> np.ndarray:
            there, best = problems.on_rows(elements, solution, rows)
            return there.predicted(there.parameters.complete(best.values))

        parts = problems.space(problem, solution)
        self.found[component.name] = lambda fit, draws, told: assessed(fit, *parts, draws, self.settings, told)
        fit = fit_of(problem, solution, self.scales, settings=self.settings)
        fit = replace(fit, diagnostics=(*fit.diagnostics, OF_THIS_SHAPE))
        return self._of_elements(fit, predicted, blocks, report)

    def _of_elements(
        self, fit: Fit, predicted: Callable[[np.ndarray], np.ndarray], blocks: int, report: Report
    ) -> Fit:  # fmt: skip
        """Return a fit with its elements in lists and, where asked for, its error on held-out blocks."""
        held_out, unfinished = None, False
        try:
            if blocks:
                held_out = held_out_error(
                    self.dataset, predicted, blocks, lambda share: report(0.5 + 0.5 * share), self.settings
                )
            report(1.0)
        except KeyboardInterrupt as error:
            obey(error)
            unfinished = True
        friction = in_lists(fit.friction)
        # Level and stiffness count among the parameters.
        further = max(len(friction.values["k_i"]) - 2, 0)
        return self._finished(replace(fit, friction=friction, further=further), held_out, unfinished)

    def _finished(self, fit: Fit, held_out: HeldOut | None, unfinished: bool = False) -> Fit:
        repeated = ()
        if held_out is not None and held_out.of == "logs":
            repeated = about_repeated_logs(self.dataset, self.settings)
        elif held_out is not None and fit.position_error_percent is None:
            repeated = about_repetition(self.dataset, self.settings)
        said = (UNFINISHED,) if unfinished else ()
        return replace(fit, held_out=held_out, unfinished=unfinished, diagnostics=(*said, *fit.diagnostics, *repeated))

    def _pitch(self) -> float:
        """Return the pitch of the screw, found in what Coulomb and viscous friction leave."""
        problem = InverseDynamics(self.dataset, parameters_of(find("coulomb_viscous"), self.known, self.dataset))
        return pitch_in(problem, self.sliding)


def _unbounded(dataset: Dataset, known: PriorKnowledge) -> dict[str, float]:
    """Return the parameters of Coulomb and viscous friction without their bounds."""
    parameters = parameters_of(find("coulomb_viscous"), known, dataset)
    problem = InverseDynamics(dataset, parameters)
    free = unbounded(problem.columns, dataset.effort - problem.fixed_effort)
    return parameters.complete(dict(zip(parameters.free, free.tolist(), strict=True)))
