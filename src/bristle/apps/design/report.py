"""The report of a loop design: verdict, margins, errors, proposed gains and their cost."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from markupsafe import Markup

from bristle.apps.design import Budget, Design, Proposal, WorkingPoint
from bristle.core import Kind, number, unit_of, with_unit
from bristle.exports import promise_of_law
from bristle.report.cards import COMPARE, Card, Step
from bristle.report.compensation import NO_CHANGE, change_text
from bristle.report.loops import controller_text, law_lines
from bristle.report.messages import as_data, message, picked, whole_sentence
from bristle.report.page import Block, Figures, Front, Ruling, Section, about, report_page
from bristle.report.table import (
    MICROMETRE,
    Quantity,
    Table,
    capital,
    fixed,
    length_text,
    short_text,
    stiffness_text,
)


def margin_table(design: Design) -> Table:
    """Return poles and margins of each loop; variants with the same loop share its rows."""
    heads = (
        "Motions",
        "Friction",
        "Largest pole",
        "Phase margin [°]",
        "Gain margin",
        "Delay margin [samples]",
        "Crossover [Hz]",
    )
    loops: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for assessment in design.assessments:
        rows = tuple(map(_margin_cells, assessment.points))
        loops.setdefault(rows, []).append(assessment.name)
    table_rows = [
        (", ".join(names) if index == 0 else "", *row)
        for rows, names in loops.items()
        for index, row in enumerate(rows)
    ]
    return Table("Poles and margins of the sampled loop", ("Variant", *heads), table_rows)


def _margin_cells(point: WorkingPoint) -> tuple[str, ...]:
    """Return the cells of a point of linearization, without the name of its variant."""
    margins = point.margins
    crossover = margins.crossover
    if crossover is not None:
        crossover = crossover / (2.0 * math.pi)
    return (
        point.motions.value,
        point.friction.value,
        number(point.loop.spectral_radius),
        _cell(margins.phase),
        _cell(margins.gain),
        _cell(margins.delay),
        _cell(crossover),
    )


def _cell(value: float | None, text: Callable[[float], str] = short_text) -> str:
    """Return a value as text, or a dash if it is unknown."""
    if value is None:
        return "–"
    return text(value)


def delay_table(design: Design) -> Table:
    """Return the parts of the delay of a loop."""
    delays = design.delays
    words = {
        "hold": "zero-order hold: half a sample",
        "computation": "computation",
        "drive": "current control of the drive",
        "velocity": "estimate of the velocity",
    }
    rows = [(text, number(1e3 * getattr(delays, name), 1e-2)) for name, text in words.items()]
    return Table(
        "Delay of the loop", ("Part", "[ms]"), [*rows, ("all", number(1e3 * delays.total, 1e-2))]
    )


def _lengths(design: Design, values: list[float]) -> Quantity:
    return Quantity.of(unit_of("length", design.experiment.kind), [*values, MICROMETRE], digits=4)


def budget_table(design: Design) -> Table | None:
    """Return the error budget; None if the loop was not simulated."""
    budget = design.budget
    if budget is None:
        return None
    errors = [
        error
        for entry in budget.entries
        for error in (entry.alone.peak_to_peak, entry.without.peak_to_peak)
    ]
    length = _lengths(design, [budget.all_causes.peak_to_peak, *errors])
    heads = (
        "Cause",
        length.head("This cause alone"),
        length.head("All but this cause"),
        "Description",
    )
    rows = [
        (
            entry.cause,
            length.cell(entry.alone.peak_to_peak),
            length.cell(entry.without.peak_to_peak),
            entry.description,
        )
        for entry in budget.entries
    ]
    left = "error of the control law and its sampling, such as a delayed velocity"
    if budget.no_cause.peak_to_peak <= NO_CHANGE * budget.all_causes.peak_to_peak:
        left = ""
    rows += [
        ("all of them", length.cell(budget.all_causes.peak_to_peak), "–", ""),
        ("none of them", length.cell(budget.no_cause.peak_to_peak), "–", left),
    ]
    return Table("Error budget: following error, peak to peak", heads, rows)


def proposal_table(design: Design) -> Table:
    """Return the present and the proposed loops: margins, stiffness, effort of a count, simulated error."""
    kind = design.experiment.kind
    proposals = design.proposals
    length = _lengths(
        design,
        [
            proposal.following_error.peak_to_peak
            for proposal in proposals
            if proposal.following_error
        ],
    )
    effort = Quantity.of(
        unit_of("force", kind),
        [proposal.effort_rms for proposal in proposals if proposal.effort_rms],
    )
    count = Quantity.of(unit_of("force", kind), [proposal.count_effort for proposal in proposals])
    rows = [
        {
            "Loop": loop_name(proposal.name, design),
            "Law": proposal.variant.controller.name,
            "Bandwidth [1/s]": _cell(proposal.bandwidth),
            "Smallest phase margin [°]": _cell(proposal.assessment.least_phase),
            "Stiffness": "∞"
            if math.isinf(proposal.stiffness)
            else stiffness_text(proposal.stiffness, kind).replace(" ", "\u00a0"),
            count.head("Effort of one count"): count.cell(proposal.count_effort),
            length.head("Following error, peak to peak"): "–"
            if proposal.following_error is None
            else length.cell(proposal.peak_to_peak),
            effort.head("Effort, rms"): _cell(proposal.effort_rms, effort.cell),
        }
        for proposal in proposals
    ]
    return Table.of("The present loop and the proposed loops", rows)


def loop_name(name: str, design: Design) -> str:
    """Return the name of a loop: for the present loop the name in the experiment."""
    if name == design.proposals[0].name:
        return design.variant.name
    return name


def circle_table(design: Design) -> Table:
    """Return the circularity of each loop."""
    circles = design.circles
    length = _lengths(design, [circle.peak_to_peak for circle in circles])
    rows = [
        {
            "Loop": loop_name(circle.variant, design),
            length.head("Deviation, peak to peak"): length.cell(circle.peak_to_peak),
        }
        | {
            length.head(f"Glitch at {90 * quarter}°"): length.cell(glitch)
            for quarter, glitch in enumerate(circle.glitches)
        }
        for circle in circles
    ]
    return Table.of("The circle", rows)


COPY = "copy these gains: `bristle run EXPERIMENT.toml`"
MEASURE = f"record the machine before and after: {COMPARE}"
GAINS = """“Tuned” is the present law with new gains. They give a phase margin of 40° and a gain margin of two, for small and large
motions. “With an observer” is a proportional-derivative law with a disturbance observer and the same margins. Both loops use
feedforward along the desired motion. Both assume that the real axis has the friction of the model."""
MARGINS = """The sampled loop includes the zero-order hold, computation delay, lag of the drive, and the velocity estimate of the
law. Poles determine its stability, margins the distance to instability. Small motions are inside a boundary layer or dead band
of the law, large motions far outside it. Stuck friction acts as a spring. Sliding friction acts as the slope of its curve at the
largest speed of the reference. The only resonances are those of the plant in the experiment file."""


def design_report(design: Design, **options: Any) -> str:
    """Return the report of a loop design as an HTML page; options as in `report_page`."""
    laws = [
        block
        for proposal in design.proposals[1:]
        for block in (
            Markup("<p>{}:</p>").format(proposal.name),
            Block("code", controller_text(proposal.variant)),
        )
    ]
    chosen = design.chosen.variant
    values = [
        f"The values of the loop {loop_name(design.chosen.name, design)}:",
        Block("items", law_lines(chosen, promise_of_law(chosen))),
    ]
    sections = [
        Section("gains", "Gains", [GAINS, proposal_table(design), *values, *laws]),
        Section("budget", "Causes of the error", _blocks_of_budget(design), "Causes"),
        Section("results", "Results", design_sentences(design), "Causes"),
        Section(
            "margins",
            "Poles and margins",
            [MARGINS, margin_table(design), Figures("margins"), delay_table(design)],
            "Margins",
        ),
        Section("circle", "A circle", _blocks_of_circle(design), "Circle"),
    ]
    named_circles = tuple(
        replace(circle, variant=loop_name(circle.variant, design)) for circle in design.circles
    )
    facts = {
        "design": design,
        "kind": design.experiment.kind,
        "assessment": design.assessment,
        "causes": _error_without_each_cause(design),
        "circles": named_circles or None,
        "names": [loop_name(loop.name, design) for loop in design.proposals],
        "enough": design.usual_phase,
        "phases": [loop.assessment.least_phase for loop in design.proposals],
    }
    return report_page("design", facts, _front(design), sections, **options)


def _error_without_each_cause(design: Design) -> dict[str, float] | None:
    """Return the following error with all causes and without each cause, peak to peak; None without an error budget."""
    if design.budget is None or not design.budget.entries:
        return None
    return {
        "all causes": design.budget.all_causes.peak_to_peak,
        **{f"no {entry.cause}": entry.without.peak_to_peak for entry in design.budget.entries},
    }


def _blocks_of_budget(design: Design) -> list[object]:
    """Return the basis of the error budget, and its table."""
    table = budget_table(design)
    if design.budget is None or table is None:
        return []
    runs = f"{design.budget.runs} runs"
    if design.budget.runs == 1:
        runs = "one run"
    return [
        f"bristle simulated the loop with each cause alone, and with all causes but one: {runs} each.",
        table,
    ]


def _blocks_of_circle(design: Design) -> list[object]:
    """Return the description of the simulated circle, and its table."""
    if not design.circles:
        return []
    circle = design.circles[0]
    kind = design.experiment.kind
    radius = with_unit(circle.radius, unit_of("length", kind))
    feed = with_unit(circle.feed, unit_of("length/time", kind))
    return [
        f"Two axes with the same loop run a circle of radius {radius} at {feed}. The results are those of the second of two "
        "revolutions. A glitch is the swing of the deviation within 30° of the reversal of an axis.",
        circle_table(design),
    ]


def design_sentences(design: Design) -> list[str]:
    """Return the main results of a design, in sentences."""
    delay = design.delays.total
    kind = design.experiment.kind
    late = design.late
    lines = [f"{design.variant.name}: {message(design.assessment.finding)}."]
    lines += [whole_sentence(doubt) for doubt in design.assessment.doubts]
    lines.append(
        f"The loop has {with_unit(delay, 's')} of delay. As a rule of thumb, the sum of its two bandwidths, such as λ + K_1, may be up "
        f"to {number(0.5 / delay, digits=2)} 1/s."
    )
    if late is not None:
        least, most = (1e3 * lag for lag in design.unstated_lags)
        phase = late.least_phase
        own = f"is unstable with a lag of {most:g} ms"
        if late.is_stable and phase is not None:
            own = f"has a phase margin of {short_text(phase)}° with a lag of {most:g} ms"
        lines.append(
            f"The lag of the current loop is unknown. The proposed gains keep their margins for lags from {least:g} to {most:g} ms. "
            f"{design.variant.name} {own}. Write the lag of the drive into the axis file, such as "
            'lag = "0.4 ms" under [effort], or current_lag under [run].'
        )
    if design.antiresonance is not None:
        lines.append(
            f"The load is coupled elastically, with an antiresonance at {with_unit(design.antiresonance, 'Hz')}. The proposed bandwidths "
            "stay below it, and the gains keep their margins with both masses."
        )
    count = design.proposals[0].count_effort
    # The smallest effort of a count for a remark.
    if design.friction > 0.0 and count > 0.5 * design.friction:
        effort, friction = (
            with_unit(force, unit_of("force", kind)) for force in (count, design.friction)
        )
        lines.append(
            f"Much of the effort is noise: one encoder count causes an effort of {effort}, {number(count / design.friction, digits=2)} "
            f"times the friction ({friction}). Use a finer encoder, a lower cut-off of the velocity, or less gain."
        )
    if design.budget is not None and design.budget.entries:
        error = length_text(design.budget.all_causes.peak_to_peak, kind)
        lines.append(
            f"The following error is {error} peak to peak. {_about_causes(design.budget, kind)}"
        )
    if design.best is not None:
        lines.append(f"{capital(_choice(design))}.")
    return lines


def _about_causes(budget: Budget, kind: Kind) -> str:
    """Return the main cause of the error, or the largest single cause if no removal reduces the error."""
    first = budget.entries[0]
    if first.without.peak_to_peak < (1.0 - NO_CHANGE) * budget.all_causes.peak_to_peak:
        return f"The main cause is {first.cause}: without it, the error is {length_text(first.without.peak_to_peak, kind)}."
    largest = max(budget.entries, key=lambda entry: entry.alone.peak_to_peak)
    return (
        "Removing a single cause does not reduce this error, because causes cancel or several causes make the same error. The largest "
        f"single cause is {largest.cause}: alone, it makes an error of {length_text(largest.alone.peak_to_peak, kind)}."
    )


def _choice(design: Design) -> str:
    """Return the recommended loop and its following error, compared with the present loop."""
    chosen = design.chosen
    present = design.proposals[0]
    kind = design.experiment.kind
    if chosen is present:
        return "no proposed loop reduces the following error by a fifth or more"
    instead = ""
    if present.following_error is not None:
        instead = f" instead of {length_text(present.peak_to_peak, kind)}"
    error = length_text(chosen.peak_to_peak, kind)
    return (
        f"the loop {chosen.name} has a following error of {error}{instead}, and keeps the margins"
    )


def design_ruling(design: Design) -> Ruling:
    """Return the verdict on a loop, with its reasons."""
    chosen = design.chosen
    present = design.proposals[0]
    doubts = tuple(message(doubt) for doubt in design.assessment.doubts)
    if not design.is_stable:
        return Ruling("no", "Do not run it", (message(design.assessment.finding), *doubts))
    if chosen is not present:
        return Ruling("with_care", "Change the gains", (_choice(design), *doubts))
    if doubts:
        return Ruling("with_care", "Keep it, with care", doubts)
    return Ruling(
        "usable", "Keep it", (_margin_text(present.assessment.least_phase), _choice(design))
    )


def _margin_text(phase: float | None) -> str:
    if phase is None:
        return "no crossover, so no phase margin"
    return f"phase margin {short_text(phase)}°"


def _front(design: Design) -> Front:
    chosen = design.chosen
    present = design.proposals[0]
    ruling = design_ruling(design)
    step = MEASURE
    if chosen is not present:
        ruling = ruling.beyond_title
        step = COPY
    return Front(
        f"{design.experiment.name}: the loop",
        about(f"variant {design.variant.name}", f"law {design.variant.controller.name}"),
        ruling,
        title=_title(design, chosen, present),
        basis="(simulated)",
        cards=_cards(design, chosen, present),
        next=Step.of(step),
    )


def _title(design: Design, chosen: Proposal, present: Proposal) -> str:
    """Return the gain of the chosen loop if both loops were simulated, else the margin of the present loop."""
    if (
        chosen is not present
        and chosen.following_error is not None
        and present.following_error is not None
    ):
        change = change_text(
            present.peak_to_peak,
            chosen.peak_to_peak,
            partial(length_text, kind=design.experiment.kind),
            "peak to peak",
        )
        return f"Gains {chosen.name}: {change}"
    if not design.is_stable:
        return "The present loop is unstable"
    return capital(_margin_text(present.assessment.least_phase))


def _cards(design: Design, chosen: Proposal, present: Proposal) -> list[Card]:
    """Return error, main cause, phase margin and effort of the chosen loop, as far as they are known."""
    kind = design.experiment.kind
    force = unit_of("force", kind)
    old, new = (loop.assessment.least_phase for loop in (present, chosen))
    cards = []
    if chosen.following_error is not None:
        cards.append(Card("Following error", length_text(chosen.peak_to_peak, kind), ""))
    if design.budget is not None and design.budget.entries:
        first = design.budget.entries[0]
        cards.append(
            Card(
                "Main cause",
                first.cause,
                f"without it {length_text(first.without.peak_to_peak, kind)}",
            )
        )
    if new is not None:
        compared = f"now {_cell(old)}°"
        if new == old:
            compared = f"usual least {design.usual_phase:g}°"
        cards.append(Card("Phase margin", f"{short_text(new)}°", compared))
    if chosen.effort_rms is not None:
        cards.append(
            Card(
                "Effort, rms",
                fixed(chosen.effort_rms, force),
                f"one count {fixed(chosen.count_effort, force)}",
            )
        )
    return cards


def design_summary(design: Design, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a design in numbers, in SI units of the axis."""
    kind = design.experiment.kind
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
        "budget": _budget(design.budget),
        "proposals": {
            loop.name: picked(loop, "bandwidth", "stiffness", "count_effort", "effort_rms")
            | {
                "controller": loop.variant.controller.name,
                "parameters": loop.variant.controller.values,
                "mass_fed_forward": loop.variant.feedforward.mass,
                "verdict": loop.assessment.verdict.value,
                "following_error": None
                if loop.following_error is None
                else vars(loop.following_error),
            }
            for loop in design.proposals
        },
        "circles": {
            circle.variant: picked(circle, "radius", "feed", "peak_to_peak", "glitches")
            for circle in design.circles
        },
        "provenance": provenance,
    }


def _budget(budget: Budget | None) -> dict[str, object] | None:
    if budget is None:
        return None
    return {
        "everything": vars(budget.all_causes),
        "nothing": vars(budget.no_cause),
        "runs": budget.runs,
        "causes": {
            entry.cause: {
                "description": entry.description,
                "alone": vars(entry.alone),
                "without": vars(entry.without),
            }
            for entry in budget.entries
        },
    }


def _loop(assessment: Any) -> dict[str, Any]:
    verdict = assessment.finding
    doubts = assessment.doubts
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
