"""The report of a loop design: verdict, margins, errors, proposed gains and their cost."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from markupsafe import Markup

from bristle.apps.design import Design
from bristle.core import number, unit_of, with_unit
from bristle.exports import promise_of_law
from bristle.report.cards import COMPARE, Card, Step
from bristle.report.compensation import NO_CHANGE, change_text
from bristle.report.loops import controller_text, law_lines
from bristle.report.messages import as_data, message, picked, whole_sentence
from bristle.report.page import Block, Figures, Front, Ruling, Section, about, report_page
from bristle.report.table import MICROMETRE, Quantity, Table, capital, fixed, length_text, short_text, stiffness_text


def margin_table(design: Design) -> Table:
    """Return poles and margins of each loop; variants with the same loop share its rows."""
    heads = ("Motions", "Friction", "Largest pole", "Phase margin [°]", "Gain margin", "Delay margin [samples]", "Crossover [Hz]")
    loops: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for assessment in design.assessments:
        rows = []
        for point in assessment.points:
            margins, turns = point.margins, None if point.margins.crossover is None else point.margins.crossover / (2.0 * math.pi)
            cells = (number(point.loop.spectral_radius), *map(_cell, (margins.phase, margins.gain, margins.delay, turns)))
            rows.append((point.motions.value, point.friction.value, *cells))
        loops.setdefault(tuple(rows), []).append(assessment.name)
    table_rows = [(", ".join(names) if index == 0 else "", *row) for rows, names in loops.items() for index, row in enumerate(rows)]
    return Table("Poles and margins of the sampled loop", ("Variant", *heads), table_rows)


def _cell(value: float | None) -> str:
    return "–" if value is None else short_text(value)


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
    return Table("Delay of the loop", ("Part", "[ms]"), [*rows, ("all", number(1e3 * delays.total, 1e-2))])


def _lengths(design: Design, values: list[float]) -> Quantity:
    return Quantity.of(unit_of("length", design.experiment.kind), [*values, MICROMETRE], digits=4)


def budget_table(design: Design) -> Table | None:
    """Return the error budget; None if the loop was not simulated."""
    if (budget := design.budget) is None:
        return None
    errors = [error for entry in budget.entries for error in (entry.alone.peak_to_peak, entry.without.peak_to_peak)]
    length = _lengths(design, [budget.all_causes.peak_to_peak, *errors])
    heads = ("Cause", length.head("This cause alone"), length.head("All but this cause"), "Description")
    rows = [
        (entry.cause, length.cell(entry.alone.peak_to_peak), length.cell(entry.without.peak_to_peak), entry.description)
        for entry in budget.entries
    ]
    is_nothing = budget.no_cause.peak_to_peak <= NO_CHANGE * budget.all_causes.peak_to_peak
    left = "error of the control law and its sampling, such as a delayed velocity"
    rows += [
        ("all of them", length.cell(budget.all_causes.peak_to_peak), "–", ""),
        ("none of them", length.cell(budget.no_cause.peak_to_peak), "–", "" if is_nothing else left),
    ]
    return Table("Error budget: following error, peak to peak", heads, rows)


def proposal_table(design: Design) -> Table:
    """Return the present and the proposed loops: margins, stiffness, effort of a count, simulated error."""
    kind, proposals = design.experiment.kind, design.proposals
    length = _lengths(design, [proposal.following_error.peak_to_peak for proposal in proposals if proposal.following_error])
    effort = Quantity.of(unit_of("force", kind), [proposal.effort_rms for proposal in proposals if proposal.effort_rms])
    count = Quantity.of(unit_of("force", kind), [proposal.count_effort for proposal in proposals])
    rows = [
        {
            "Loop": loop_name(proposal.name, design),
            "Law": proposal.variant.controller.name,
            "Bandwidth [1/s]": _cell(proposal.bandwidth),
            "Smallest phase margin [°]": _cell(proposal.assessment.least_phase),
            "Stiffness": "∞" if math.isinf(proposal.stiffness) else stiffness_text(proposal.stiffness, kind).replace(" ", "\u00a0"),
            count.head("Effort of one count"): count.cell(proposal.count_effort),
            length.head("Following error, peak to peak"): "–"
            if proposal.following_error is None
            else length.cell(proposal.following_error.peak_to_peak),
            effort.head("Effort, rms"): "–" if proposal.effort_rms is None else effort.cell(proposal.effort_rms),
        }
        for proposal in proposals
    ]
    return Table.of("The present loop and the proposed loops", rows)


def loop_name(name: str, design: Design) -> str:
    """Return the name of a loop: for the present loop the name in the experiment."""
    return design.variant.name if name == design.proposals[0].name else name


def circle_table(design: Design) -> Table:
    """Return the circularity of each loop."""
    circles = design.circles
    length = _lengths(design, [circle.peak_to_peak for circle in circles])
    rows = [
        {"Loop": loop_name(circle.variant, design), length.head("Deviation, peak to peak"): length.cell(circle.peak_to_peak)}
        | {length.head(f"Glitch at {90 * quarter}°"): length.cell(glitch) for quarter, glitch in enumerate(circle.glitches)}
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
    budget, causes = budget_table(design), None
    if design.budget is not None and design.budget.entries:
        errors = {f"no {entry.cause}": entry.without.peak_to_peak for entry in design.budget.entries}
        causes = {"all causes": design.budget.all_causes.peak_to_peak} | errors
    laws = [
        block
        for proposal in design.proposals[1:]
        for block in (Markup("<p>{}:</p>").format(proposal.name), Block("code", controller_text(proposal.variant)))
    ]
    runs = 1 if design.budget is None else design.budget.runs
    basis = "bristle simulated the loop with each cause alone, and with all causes but one"
    errs = [] if budget is None else [f"{basis}: {'one run' if runs == 1 else f'{runs} runs'} each.", budget]
    chosen = design.chosen.variant
    values = [f"The values of the loop {loop_name(design.chosen.name, design)}:", Block("items", law_lines(chosen, promise_of_law(chosen)))]
    circles: list[object] = []
    if design.circles:
        circle, kind = design.circles[0], design.experiment.kind
        radius, feed = with_unit(circle.radius, unit_of("length", kind)), with_unit(circle.feed, unit_of("length/time", kind))
        circles = [
            f"Two axes with the same loop run a circle of radius {radius} at {feed}. The results are those of the second of two "
            "revolutions. A glitch is the swing of the deviation within 30° of the reversal of an axis.",
            circle_table(design),
        ]
    sections = [
        Section("gains", "Gains", [GAINS, proposal_table(design), *values, *laws]),
        Section("budget", "Causes of the error", errs, "Causes"),
        Section("results", "Results", design_sentences(design), "Causes"),
        Section("margins", "Poles and margins", [MARGINS, margin_table(design), Figures("margins"), delay_table(design)], "Margins"),
        Section("circle", "A circle", circles, "Circle"),
    ]
    facts = {
        "design": design,
        "kind": design.experiment.kind,
        "assessment": design.assessment,
        "causes": causes,
        "circles": tuple(replace(circle, variant=loop_name(circle.variant, design)) for circle in design.circles) or None,
        "names": [loop_name(loop.name, design) for loop in design.proposals],
        "enough": design.usual_phase,
        "phases": [loop.assessment.least_phase for loop in design.proposals],
    }
    return report_page("design", facts, _front(design), sections, **options)


def design_sentences(design: Design) -> list[str]:
    """Return the main results of a design, in sentences."""
    delay, kind, late = design.delays.total, design.experiment.kind, design.late
    lines = [f"{design.variant.name}: {message(design.assessment.finding)}."]
    lines += [whole_sentence(doubt) for doubt in design.assessment.doubts]
    lines.append(
        f"The loop has {with_unit(delay, 's')} of delay. As a rule of thumb, the sum of its two bandwidths, such as λ + K_1, may be up "
        f"to {number(0.5 / delay, digits=2)} 1/s."
    )
    if late is not None:
        (least, most), phase = (1e3 * lag for lag in design.unstated_lags), late.least_phase
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
        effort, friction = (with_unit(force, unit_of("force", kind)) for force in (count, design.friction))
        lines.append(
            f"Much of the effort is noise: one encoder count causes an effort of {effort}, {number(count / design.friction, digits=2)} "
            f"times the friction ({friction}). Use a finer encoder, a lower cut-off of the velocity, or less gain."
        )
    if design.budget is not None and design.budget.entries:
        entries, error = design.budget.entries, design.budget.all_causes.peak_to_peak
        first, largest = entries[0], max(entries, key=lambda entry: entry.alone.peak_to_peak)
        without, alone = (length_text(peak, kind) for peak in (first.without.peak_to_peak, largest.alone.peak_to_peak))
        about_causes = (
            "Removing a single cause does not reduce this error, because causes cancel or several causes make the same error. The largest "
            f"single cause is {largest.cause}: alone, it makes an error of {alone}."
        )
        if first.without.peak_to_peak < (1.0 - NO_CHANGE) * error:
            about_causes = f"The main cause is {first.cause}: without it, the error is {without}."
        lines.append(f"The following error is {length_text(error, kind)} peak to peak. {about_causes}")
    return [*lines, *([f"{capital(_choice(design))}."] if design.best is not None else [])]


def _choice(design: Design) -> str:
    """Return the recommended loop and its following error, compared with the present loop."""
    chosen, present, kind = design.chosen, design.proposals[0], design.experiment.kind
    if chosen is present:
        return "no proposed loop reduces the following error by a fifth or more"
    instead = "" if present.following_error is None else f" instead of {length_text(present.peak_to_peak, kind)}"
    error = length_text(chosen.peak_to_peak, kind)
    return f"the loop {chosen.name} has a following error of {error}{instead}, and keeps the margins"


def design_ruling(design: Design) -> Ruling:
    """Return the verdict on a loop, with its reasons."""
    chosen, present, doubts = design.chosen, design.proposals[0], tuple(message(doubt) for doubt in design.assessment.doubts)
    if not design.is_stable:
        return Ruling("no", "Do not run it", (message(design.assessment.finding), *doubts))
    if chosen is not present:
        return Ruling("with_care", "Change the gains", (_choice(design), *doubts))
    if doubts:
        return Ruling("with_care", "Keep it, with care", doubts)
    return Ruling("usable", "Keep it", (_margin_text(present.assessment.least_phase), _choice(design)))


def _margin_text(phase: float | None) -> str:
    return "no crossover, so no phase margin" if phase is None else f"phase margin {short_text(phase)}°"


def _front(design: Design) -> Front:
    kind, chosen, present = design.experiment.kind, design.chosen, design.proposals[0]
    force, rows, is_present = unit_of("force", kind), [], chosen is present
    old, new = (loop.assessment.least_phase for loop in (present, chosen))
    title = capital(_margin_text(old)) if design.is_stable else "The present loop is unstable"
    if not is_present and chosen.following_error is not None and present.following_error is not None:
        change = change_text(present.peak_to_peak, chosen.peak_to_peak, partial(length_text, kind=kind), "peak to peak")
        title = f"Gains {chosen.name}: {change}"
    if chosen.following_error is not None:
        rows.append(("Following error", length_text(chosen.peak_to_peak, kind), ""))
    if design.budget is not None and design.budget.entries:
        first = design.budget.entries[0]
        rows.append(("Main cause", first.cause, f"without it {length_text(first.without.peak_to_peak, kind)}"))
    if new is not None:
        rows.append(("Phase margin", f"{short_text(new)}°", f"usual least {design.usual_phase:g}°" if new == old else f"now {_cell(old)}°"))
    if chosen.effort_rms is not None:
        rows.append(("Effort, rms", fixed(chosen.effort_rms, force), f"one count {fixed(chosen.count_effort, force)}"))
    return Front(
        f"{design.experiment.name}: the loop",
        about(f"variant {design.variant.name}", f"law {design.variant.controller.name}"),
        design_ruling(design) if is_present else design_ruling(design).beyond_title,
        title=title,
        basis="(simulated)",
        cards=[Card(*row) for row in rows],
        next=Step.of(MEASURE if is_present else COPY),
    )


def design_summary(design: Design, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a design in numbers, in SI units of the axis."""
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
        "proposals": {
            loop.name: picked(loop, "bandwidth", "stiffness", "count_effort", "effort_rms")
            | {
                "controller": loop.variant.controller.name,
                "parameters": loop.variant.controller.values,
                "mass_fed_forward": loop.variant.feedforward.mass,
                "verdict": loop.assessment.verdict.value,
                "following_error": None if loop.following_error is None else vars(loop.following_error),
            }
            for loop in design.proposals
        },
        "circles": {circle.variant: picked(circle, "radius", "feed", "peak_to_peak", "glitches") for circle in design.circles},
        "provenance": provenance,
    }


def _loop(assessment: Any) -> dict[str, Any]:
    verdict, doubts = assessment.finding, assessment.doubts
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
