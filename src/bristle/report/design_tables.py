"""Tables of a loop that is designed: poles and margins, delays, error budget, gains, circles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bristle.core.typography import number, stiffness_text
from bristle.core.variable import unit_of
from bristle.files.components import key_of
from bristle.report.table import Quantity, Table

if TYPE_CHECKING:
    from bristle.core.experiment import Variant
    from bristle.loop import Assessment, Budget, Circle, Delays, Design

NEARLY_NOTHING = 0.01  # of what a loop errs by
MICROMETRE = 1e-6  # the errors of servos are told in no smaller unit

__all__ = ["at_the_motor", "budget_table", "circle_table", "controller_text", "delay_table", "margin_table", "proposal_table"]


def margin_table(design: Design) -> Table:
    """Return poles and margins of each loop; variants that are one loop share its rows."""
    heads = (
        "Variant",
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
        rows = []
        for point in assessment.points:
            phase, gain, crossover, delay, _ = point.margins
            hertz = None if crossover is None else crossover / (2.0 * math.pi)
            cells = (_cell(phase), _cell(gain), _cell(delay), _cell(hertz))
            rows.append((point.motions.value, point.friction.value, number(point.loop.spectral_radius), *cells))
        loops.setdefault(tuple(rows), []).append(assessment.name)
    table_rows = [(", ".join(names) if index == 0 else "", *row) for rows, names in loops.items() for index, row in enumerate(rows)]
    return Table("Poles and margins of the sampled loop", heads, table_rows)


def _cell(value: float | None) -> str:
    return "–" if value is None else number(value, digits=3)


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
    length = Quantity.of(unit_of("length", design.experiment.kind), [budget.all_causes.peak_to_peak, *errors, MICROMETRE], digits=4)
    heads = ("Cause", length.head("This cause alone"), length.head("All but this cause"), "What it is")
    rows = [
        (entry.cause, length.cell(entry.alone.peak_to_peak), length.cell(entry.without.peak_to_peak), entry.description)
        for entry in budget.entries
    ]
    rows += [
        ("all of them", length.cell(budget.all_causes.peak_to_peak), "–", ""),
        ("none of them", length.cell(budget.no_cause.peak_to_peak), "–", _about_the_rest(budget)),
    ]
    return Table("Error budget: following error, peak to peak", heads, rows)


def _about_the_rest(budget: Budget) -> str:
    """Return what a loop errs by that errs by none of its causes; nothing where that is nearly nothing."""
    if not budget.no_cause.peak_to_peak > NEARLY_NOTHING * budget.all_causes.peak_to_peak:
        return ""
    return "left by the law itself and its sampling, such as a velocity that is late where the desired one is not"


def proposal_table(design: Design) -> Table:
    """Return the loop as it is and as proposed: margins, stiffness, what a count does, simulated error."""
    kind, proposals = design.experiment.kind, design.proposals
    simulated = [proposal.following_error.peak_to_peak for proposal in proposals if proposal.following_error]
    length = _lengths(design, simulated)
    effort = Quantity.of(unit_of("force", kind), [proposal.effort_rms for proposal in proposals if proposal.effort_rms])
    count = Quantity.of(unit_of("force", kind), [proposal.count_effort for proposal in proposals])
    heads = (
        "Loop",
        "Law",
        "Bandwidth [1/s]",
        "Smallest phase margin [°]",
        "Stiffness",
        count.head("Effort of one count"),
        length.head("Following error, peak to peak"),
        effort.head("Effort, rms"),
    )
    rows = [
        (
            loop_name(proposal.name, design),
            proposal.variant.controller.name,
            _cell(proposal.bandwidth),
            _cell(least_phase(proposal.assessment)),
            "∞" if math.isinf(proposal.stiffness) else stiffness_text(proposal.stiffness, kind).replace(" ", "\u00a0"),
            count.cell(proposal.count_effort),
            "–" if proposal.following_error is None else length.cell(proposal.following_error.peak_to_peak),
            "–" if proposal.effort_rms is None else effort.cell(proposal.effort_rms),
        )
        for proposal in proposals
    ]
    return Table("The loop as it is, and what is proposed", heads, rows)


def loop_name(name: str, design: Design) -> str:
    """Return what a loop is called: as in the experiment where it is that of the variant that was designed."""
    return design.variant.name if name == design.proposals[0].name else name


def least_phase(assessment: Assessment) -> float | None:
    """Return the smallest phase margin of a loop without friction [°]."""
    phases = [point.margins.phase for point in assessment.bare]
    return min((phase for phase in phases if phase is not None), default=None)


def controller_text(variant: Variant) -> str:
    """Return control law and inertia fed forward of a loop as the tables of an experiment file that describe them."""
    controller, mass = variant.controller, variant.feedforward.mass
    lines = ["[controller]", f'model = "{controller.name}"']
    for name, value in controller.values.items():
        unit = controller.component.variables[name].unit(controller.kind)
        if isinstance(value, str):
            lines.append(f'{key_of(name)} = "{value}"')
        elif isinstance(value, int) or unit == "1":
            lines.append(f"{key_of(name)} = {value}")
        elif math.isfinite(value):
            lines.append(f'{key_of(name)} = "{value:.6g} {unit}"{_as_comment(value, unit, variant)}')
    if mass > 0.0:
        unit = unit_of("mass", controller.kind)
        lines += ["", "[controller.feedforward]", f'mass = "{mass:.6g} {unit}"']
    return "\n".join(lines)


MOTOR = {"N*s/m": "N*m*s/rad", "N/m": "N*m/rad", "N/(m*s)": "N*m/(rad*s)"}
"""By its unit on a carriage, the unit of a gain at the motor."""


def at_the_motor(value: float, unit: str, variant: Variant) -> str:
    """Return a gain as the drive of a motor behind a screw has it; nothing where there is no screw."""
    arm = None if variant.axis is None else variant.axis.arm
    return f"{value * arm * arm:.4g} {MOTOR[unit]} at the motor" if arm and unit in MOTOR else ""


def _as_comment(value: float, unit: str, variant: Variant) -> str:
    text = at_the_motor(value, unit, variant)
    return f"  # {text}" if text else ""


def circle_table(circles: tuple[Circle, ...], design: Design) -> Table:
    """Return how round the circles are."""
    length = Quantity.of(unit_of("length", design.experiment.kind), [MICROMETRE, *(circle.peak_to_peak for circle in circles)], digits=4)
    reversals = [length.head(f"Glitch at {angle}°") for angle in (0, 90, 180, 270)]
    heads = ("Loop", length.head("Deviation, peak to peak"), *reversals)
    rows = [
        (loop_name(circle.variant, design), length.cell(circle.peak_to_peak), *(length.cell(glitch) for glitch in circle.glitches))
        for circle in circles
    ]
    return Table("The circle", heads, rows)
