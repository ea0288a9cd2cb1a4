"""Tables of a loop that is designed: poles and margins, delays, error budget, gains, circles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.typography import number, stiffness_text
from bristle.core.variable import unit_of
from bristle.report.compensation import NO_CHANGE
from bristle.report.table import MICROMETRE, Quantity, Table, short_text

if TYPE_CHECKING:
    from bristle.loop import Assessment, Budget, Circle, Delays, Design


def margin_table(design: Design) -> Table:
    """Return poles and margins of each loop; variants that are one loop share its rows."""
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


def delay_table(delays: Delays) -> Table:
    """Return where the delay of a loop comes from."""
    words = {
        "hold": "effort held over a sample: half of it",
        "computation": "computation",
        "drive": "current control of the drive",
        "velocity": "estimate of the velocity",
    }
    rows = [(text, number(1e3 * getattr(delays, name), 1e-2)) for name, text in words.items()]
    return Table("Delay of the loop", ("Part", "[ms]"), [*rows, ("all", number(1e3 * delays.total, 1e-2))])


def _lengths(design: Design, values: list[float]) -> Quantity:
    return Quantity.of(unit_of("length", design.experiment.kind), [*values, MICROMETRE], digits=4)


def budget_table(budget: Budget, design: Design) -> Table:
    """Return the error budget."""
    errors = [error for entry in budget.entries for error in (entry.alone.peak_to_peak, entry.without.peak_to_peak)]
    length = _lengths(design, [budget.all_causes.peak_to_peak, *errors])
    heads = ("Cause", length.head("This cause alone"), length.head("All but this cause"), "What it is")
    rows = [
        (entry.cause, length.cell(entry.alone.peak_to_peak), length.cell(entry.without.peak_to_peak), entry.description)
        for entry in budget.entries
    ]
    is_nothing = budget.no_cause.peak_to_peak <= NO_CHANGE * budget.all_causes.peak_to_peak
    left = "left by the law itself and its sampling, such as a velocity that is late where the desired one is not"
    rows += [
        ("all of them", length.cell(budget.all_causes.peak_to_peak), "–", ""),
        ("none of them", length.cell(budget.no_cause.peak_to_peak), "–", "" if is_nothing else left),
    ]
    return Table("Error budget: following error, peak to peak", heads, rows)


def proposal_table(design: Design) -> Table:
    """Return the loop as it is and as proposed: margins, stiffness, what a count does, simulated error."""
    kind, proposals = design.experiment.kind, design.proposals
    length = _lengths(design, [proposal.following_error.peak_to_peak for proposal in proposals if proposal.following_error])
    effort = Quantity.of(unit_of("force", kind), [proposal.effort_rms for proposal in proposals if proposal.effort_rms])
    count = Quantity.of(unit_of("force", kind), [proposal.count_effort for proposal in proposals])
    rows = [
        {
            "Loop": loop_name(proposal.name, design),
            "Law": proposal.variant.controller.name,
            "Bandwidth [1/s]": _cell(proposal.bandwidth),
            "Smallest phase margin [°]": _cell(least_phase(proposal.assessment)),
            "Stiffness": "∞" if math.isinf(proposal.stiffness) else stiffness_text(proposal.stiffness, kind).replace(" ", "\u00a0"),
            count.head("Effort of one count"): count.cell(proposal.count_effort),
            length.head("Following error, peak to peak"): "–"
            if proposal.following_error is None
            else length.cell(proposal.following_error.peak_to_peak),
            effort.head("Effort, rms"): "–" if proposal.effort_rms is None else effort.cell(proposal.effort_rms),
        }
        for proposal in proposals
    ]
    return Table.of("The loop as it is, and what is proposed", rows)


def loop_name(name: str, design: Design) -> str:
    """Return what a loop is called: as in the experiment where it is that of the variant that was designed."""
    return design.variant.name if name == design.proposals[0].name else name


def least_phase(assessment: Assessment) -> float | None:
    """Return the smallest phase margin of a loop without friction [°]."""
    phases = [point.margins.phase for point in assessment.bare]
    return min((phase for phase in phases if phase is not None), default=None)


def circle_table(circles: tuple[Circle, ...], design: Design) -> Table:
    """Return how round the circles are."""
    length = _lengths(design, [circle.peak_to_peak for circle in circles])
    rows = [
        {"Loop": loop_name(circle.variant, design), length.head("Deviation, peak to peak"): length.cell(circle.peak_to_peak)}
        | {length.head(f"Glitch at {90 * quarter}°"): length.cell(glitch) for quarter, glitch in enumerate(circle.glitches)}
        for circle in circles
    ]
    return Table.of("The circle", rows)
