"""The report of a loop that is designed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bristle.core.typography import number, with_unit
from bristle.core.variable import unit_of
from bristle.loop import PHASE_ENOUGH, Verdict, doubts_of, verdict_of
from bristle.loop.tuning import UNSTATED
from bristle.report.design_tables import (
    budget_table,
    circle_table,
    controller_text,
    delay_table,
    least_phase,
    loop_name,
    margin_table,
    proposal_table,
)
from bristle.report.front import length_text
from bristle.report.fronts.design import LESS, MORE, best_of, counts_much, design_front, design_ruling, peak_of
from bristle.report.further import further_figures
from bristle.report.messages import as_data, message, whole_sentence
from bristle.report.page import Picture, picture, render

if TYPE_CHECKING:
    from bristle.core.variable import Kind
    from bristle.figures.report_figure import ReportFigure
    from bristle.loop import Budget, Design, Proposal

__all__ = ["design_report", "design_sentences", "design_summary"]

NO_LESS = 0.05  # of an error: what a cause takes away from it that is as good as nothing


def design_report(design: Design, *, command: str, provenance: Mapping[str, str], figures: Sequence[ReportFigure] = ()) -> str:
    """Return the report of a loop that is designed as one HTML page."""
    return render(
        "design.html",
        provenance=provenance,
        command=command,
        banner=None,
        front=design_front(design, _loops_picture(design)),
        name=design.experiment.name,
        verdict=design_sentences(design),
        margins=margin_table(design),
        delays=delay_table(design.delays),
        budget=None if design.budget is None else budget_table(design.budget, design),
        proposals=proposal_table(design),
        laws=[(proposal.name, controller_text(proposal.variant)) for proposal in design.proposals[1:]],
        circles=circle_table(design.circles, design) if design.circles else None,
        circle=_circle_words(design),
        pictures=_pictures(design),
        further=further_figures(figures, {"design": design}),
    )


def design_sentences(design: Design) -> list[str]:
    """Return what matters most of a design, in words."""
    assessment = design.assessment
    lines = [f"{design.variant.name}: {message(verdict_of(assessment))}."]
    lines += [whole_sentence(doubt) for doubt in doubts_of(assessment)]
    delays = design.delays
    lines.append(
        f"The loop has {with_unit(delays.total, 's')} of delay. As a rule of thumb that allows the sum of its two "
        f"bandwidths, such as λ + K_1, {number(0.5 / delays.total, digits=2)} 1/s."
    )
    lines += _about_the_lag(design)
    lines += _about_a_count(design)
    if design.budget is not None and design.budget.entries:
        lines.append(_about_causes(design.budget, design.experiment.kind))
    return lines + _advice(design)


def _about_causes(budget: Budget, kind: Kind) -> str:
    """Return what a loop errs by and the cause without which it errs least, where one stands out."""
    first, whole = budget.entries[0], budget.all_causes.peak_to_peak
    total = f"It errs by {length_text(whole, kind)} peak to peak."
    if first.without.peak_to_peak < (1.0 - NO_LESS) * whole:
        without = length_text(first.without.peak_to_peak, kind)
        return f"{total} No cause weighs more than this one, {first.cause}: without it, that is {without}."
    largest = max(budget.entries, key=lambda entry: entry.alone.peak_to_peak)
    alone = length_text(largest.alone.peak_to_peak, kind)
    return (
        f"{total} To take a single cause away makes that no smaller: causes cancel each other, or several make the "
        f"same error. Alone, {largest.cause} makes the most of all, {alone}."
    )


def _about_the_lag(design: Design) -> list[str]:
    """Return what a lag that nobody stated means for the margins, and the question for it."""
    late = design.late
    if late is None:
        return []
    least, most = (1e3 * lag for lag in UNSTATED)
    phase = least_phase(late)
    own = f"is unstable with {most:g} ms"
    if late.verdict is Verdict.STABLE and phase is not None:
        own = f"has a phase margin of {number(phase, digits=3)}° with {most:g} ms"
    return [
        f"How late is the current loop? No file states its lag, and it is not zero. The gains proposed keep their "
        f"margins from {least:g} to {most:g} ms; {design.variant.name} {own}. Write the lag of the drive into the axis "
        'file, such as lag = "0.4 ms" under [effort], or current_lag under [run].'
    ]


def _about_a_count(design: Design) -> list[str]:
    present, kind = design.proposals[0], design.experiment.kind
    if not counts_much(design):
        return []
    effort, friction = (with_unit(force, unit_of("force", kind)) for force in (present.count_effort, design.friction))
    return [
        f"One count of the encoder calls up {effort}, {number(present.count_effort / design.friction, digits=2)} times "
        f"the friction ({friction}): much of the effort is noise. A finer encoder, a lower cut-off of the velocity or "
        "less gain lowers it."
    ]


def _advice(design: Design) -> list[str]:
    best, present = best_of(design), design.proposals[0].following_error
    if best is None:
        return []
    error = length_text(peak_of(best), design.experiment.kind)
    if present is not None and peak_of(best) > MORE * present.peak_to_peak:
        return ["None of the loops proposed errs as little in the simulation. They keep wider margins: weigh that against the error."]
    if present is not None and peak_of(best) > LESS * present.peak_to_peak:
        return [
            f"The loop {best.name} ({best.variant.controller.name}, gains below) errs about as little in the "
            f"simulation, {error}, with margins kept."
        ]
    return [
        f"The loop {best.name} ({best.variant.controller.name}, gains below) errs by {error} "
        "in the simulation, with margins kept. Friction fed forward along the desired motion and an observer for what "
        "the model leaves are a good start for any axis."
    ]


def _circle_words(design: Design) -> str:
    if not design.circles:
        return ""
    circle, kind = design.circles[0], design.experiment.kind
    radius, feed = (with_unit(circle.radius, unit_of("length", kind)), with_unit(circle.feed, unit_of("length/time", kind)))
    return (
        f"Two axes like this one run a circle of {radius} at {feed}; the second of two revolutions. A glitch is the "
        "swing of the deviation within 30° of the place where an axis reverses."
    )


def _loops_picture(design: Design) -> Picture:
    from bristle import figures

    loops = design.proposals
    errors = [None if loop.following_error is None else loop.following_error.peak_to_peak for loop in loops]
    return picture(
        "loops",
        lambda: figures.loops_proposed(
            [loop_name(loop.name, design) for loop in loops],
            errors,
            [loop.effort_rms for loop in loops],
            [least_phase(loop.assessment) for loop in loops],
            PHASE_ENOUGH,
            design.experiment.kind,
        ),
        "Following error, effort and smallest phase margin of the loop as it is and of those proposed",
        f"Simulated following error and effort, and the smallest phase margin without friction: {design.variant.name} "
        "is the loop as it is, the others are proposed.",
    )


def _pictures(design: Design) -> dict[str, Picture]:
    from bristle import figures

    kind = design.experiment.kind
    pictures = {
        "margins": picture(
            "margins",
            lambda: figures.margins(design.assessment),
            "Gain and phase of the open loop over frequency, and the poles of the closed loop",
            "The open loop without friction, and the phase margin where its gain crosses 1 (thick). Poles outside the "
            "circle grow; close inside it they ring.",
        )
    }
    if design.budget is not None and design.budget.entries:
        budget = design.budget
        pictures["budget"] = picture(
            "budget",
            lambda: figures.error_budget(budget, kind),
            "Following error with each cause of error alone and without each",
            "A cause whose dark bar is long errs by itself; one whose light bar is far below the dashed line is worth "
            "removing first. The bars do not add up: causes go together, and a peak is not a sum.",
        )
    if design.circles:
        named = tuple(replace(circle, variant=loop_name(circle.variant, design)) for circle in design.circles)
        pictures["circles"] = picture(
            "circles",
            lambda: figures.circles(named, kind),
            "Radial deviation of the circle, around it and unrolled",
            "How far from round the two axes run, magnified, around the grey circle on the left. At each of the four "
            "reversals friction changes sides, and the path bulges.",
        )
    return pictures


def design_summary(design: Design, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a design in numbers, in SI of the axis."""
    kind, budget = design.experiment.kind, design.budget
    return {
        "name": design.experiment.name,
        "kind": kind,
        "variant": design.variant.name,
        "stable": design.is_stable,
        "error_unit": unit_of("length", kind),
        "effort_unit": unit_of("force", kind),
        "verdict": design_ruling(design).as_data(),
        "sentences": design_sentences(design),
        "loops": {assessment.name: _loop(assessment) for assessment in design.assessments},
        "delay": design.delays._asdict() | {"total": design.delays.total},
        "budget": None
        if budget is None
        else {
            "everything": vars(budget.all_causes),
            "nothing": vars(budget.no_cause),
            "runs": budget.runs,
            "causes": {
                entry.cause: {"description": entry.description, "alone": vars(entry.alone), "without": vars(entry.without)}
                for entry in budget.entries
            },
        },
        "proposals": {proposal.name: _proposal(proposal) for proposal in design.proposals},
        "circles": {
            circle.variant: {"radius": circle.radius, "feed": circle.feed, "peak_to_peak": circle.peak_to_peak, "glitches": circle.glitches}
            for circle in design.circles
        },
        "provenance": provenance,
    }


def _loop(assessment: Any) -> dict[str, Any]:
    verdict, doubts = verdict_of(assessment), doubts_of(assessment)
    return {
        "verdict": assessment.verdict.value,
        "sentence": message(verdict),
        "remarks": [message(doubt) for doubt in doubts],
        "diagnostics": as_data((verdict, *doubts)),
        "points": [
            {
                "motions": point.motions.value,
                "friction": point.friction.value,
                "spectral_radius": point.loop.spectral_radius,
                "poles": [[pole.real, pole.imag] for pole in point.loop.poles.tolist()],
                "phase_margin": point.margins.phase,
                "gain_margin": point.margins.gain,
                "delay_margin": point.margins.delay,
                "crossover": point.margins.crossover,
                "sensitivity": point.margins.sensitivity,
            }
            for point in assessment.points
        ],
    }


def _proposal(proposal: Proposal) -> dict[str, Any]:
    error = proposal.following_error
    return {
        "controller": proposal.variant.controller.name,
        "bandwidth": proposal.bandwidth,
        "parameters": proposal.variant.controller.values,
        "mass_fed_forward": proposal.variant.feedforward.mass,
        "stiffness": proposal.stiffness,
        "count_effort": proposal.count_effort,
        "verdict": proposal.assessment.verdict.value,
        "following_error": None if error is None else vars(error),
        "effort_rms": proposal.effort_rms,
    }
