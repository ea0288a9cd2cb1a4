"""An identification in brief, as a terminal shows it: labelled lines, the verdict last."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core import Axis, Diagnostic, number, typeset, unit_of
from bristle.prediction import drive_units, level_values
from bristle.report.cards import Line, labelled, no_gain
from bristle.report.compensation import gain_of
from bristle.report.judgement import (
    DOUBTS,
    comparison_with,
    feedforward_of,
    is_one_sided,
    ruling_of,
)
from bristle.report.messages import advice_of, terms_in
from bristle.report.model_tables import WITH_CONSTANT, parameter_table
from bristle.report.page import Ruling
from bristle.report.sentences import SENTENCES
from bristle.report.table import capital, fixed, percent_text
from bristle.report.two_masses import two_masses_lines

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit, Identification
    from bristle.prediction import Following
    from bristle.simulation import SimulationResult

HALF_SAMPLE = 0.5  # a smaller delay is not worth a line
PARAMETERS, WARNINGS, REASONS = 5, 3, 3  # shown at most


def brief(
    identification: Identification,
    simulation: SimulationResult | None,
    following: Following | None,
    axis: Axis | None = None,
) -> list[Line]:
    """Return model, parameters, values to type in, gain, warnings and verdict of an identification; of two encoders, of both sides."""
    fit, masses = identification.best, two_masses_lines(identification)
    ruling = ruling_of(identification, following)
    lines = [*_model(identification), *_parameters(fit), *_warnings(fit, following), *masses]
    # Their fits are not those of one mass.
    if identification.two_masses is not None and identification.two_masses.load is not None:
        lines = [
            *masses,
            *labelled("One mass", [f"{fit.name}: model error {percent_text(fit.error_percent)}"]),
        ]
    if ruling.level != "measure_again":
        lines += [*_to_type_in(fit, axis), *_gain(simulation, following, axis)]
    return [*lines, Line("Feedforward", feedforward_of(identification)), verdict(ruling)]


def first_answer(identification: Identification) -> list[Line]:
    """Return model, parameters and verdict of the first of several models, marked as provisional."""
    lines = [
        *_model(identification),
        *_parameters(identification.best),
        verdict(ruling_of(identification)),
    ]
    return [
        Line(
            "Provisional",
            "first of the models, the others follow; intervals from simulated logs may be wider",
        ),
        *lines,
    ]


def advice_to_record(fit: Fit) -> str:
    """Return how to record the axis again, if the log is faulty or moves in one direction only; else an empty text."""
    codes = [diagnostic.code for diagnostic in fit.diagnostics if diagnostic.severity == "error"]
    codes += ["one_direction"] if is_one_sided(fit) else []
    return next((f"{capital(advice)}, and identify again." for advice in advice_of(codes)), "")


def verdict(ruling: Ruling) -> Line:
    """Return the verdict with its first reasons."""
    reasons, more = list(ruling.reasons[:REASONS]), len(ruling.reasons) - REASONS
    reasons += [f"{more} more reason{'s' * (more > 1)} (-v)"] if more > 0 else []
    return Line(
        "Verdict", f"{ruling.words}{': ' if reasons else ''}{'; '.join(reasons)}.", ruling.level
    )


def _model(identification: Identification) -> list[Line]:
    fit, further = identification.best, len(identification.fits) - 1
    held_out = (
        "" if fit.held_out is None else f", {percent_text(fit.held_out.mean_percent)} held out"
    )
    lines = list[Line]()
    if identification.explanation is not None:
        lines.append(Line("Effort", identification.explanation.verdict))
    lines.append(
        Line("Model", f"{fit.name}: model error {percent_text(fit.error_percent)}{held_out}")
    )
    for numbers in (
        diagnostic.numbers for diagnostic in fit.diagnostics if diagnostic.code == "delay_found"
    ):
        samples, delay = numbers["samples"], numbers["delay"]
        if isinstance(samples, float) and isinstance(delay, float) and abs(samples) >= HALF_SAMPLE:
            lines.append(
                Line(
                    "",
                    f"bristle removed a delay of {fixed(delay, 's')} between effort and position",
                )
            )
    lines += [Line("", f"best of {further + 1} models (compare them: -v)")] if further else []
    return lines + ([Line("Axis", second)] if (second := terms_in(fit)) else [])


def _parameters(fit: Fit) -> list[Line]:
    """Return the free parameters as aligned lines, those with the largest share of the friction force first where there are many."""
    free = [
        estimate for estimate in (*fit.estimates, *fit.combinations) if estimate.status != "held"
    ]
    first = sorted(free, key=lambda estimate: (estimate is not fit.inertia, -estimate.takes))
    first = first[:PARAMETERS] if len(free) > PARAMETERS + 1 else free
    names = [estimate.name for estimate in free if estimate in first]
    table = parameter_table(fit)
    columns = {head: place for place, head in enumerate(table.heads)}
    rows = [
        [row[columns[head]] if head in columns else "" for head in COLUMNS]
        for row in table.rows
        if row[0] in names
    ]
    widths = [max((len(row[place]) for row in rows), default=0) for place in range(len(COLUMNS))]
    lines = []
    for name, value, unit, half, remark in rows:
        remark = PLAIN.get(remark.partition("; ")[0], remark.partition("; ")[0])
        quantity = f"{value:>{widths[1]}} {'' if unit == '–' else unit:<{widths[2]}}"
        width = f"{'' if half == '–' else half + ' %':<{widths[3] + 2}}"
        lines.append(f"{name:<{widths[0]}}  {quantity}  {width}  {remark}".rstrip())
    more = len(free) - len(names)
    if lines:
        lines.append(f"(± half-width of the 95 % interval{f'; {more} more: -v' if more else ''})")
    return labelled("Parameters", lines)


PLAIN = {
    "effective": "valid for similar motions",
    WITH_CONSTANT: "relies on the given constant force",
}
COLUMNS = ("Parameter", "Value", "Unit", "95 % interval [%]", "Remark")


def _to_type_in(fit: Fit, axis: Axis | None) -> list[Line]:
    """Return mass and level of friction with their half-widths, in SI and in the unit of the drive."""
    levels, kind, inertia = level_values(fit), fit.plant.kind, fit.inertia
    if levels is None:
        return []
    lines, unit = [], unit_of("force", kind)
    if inertia is not None and inertia.status != "unidentifiable" and levels.inertia:
        source = " (given)" if inertia.status == "held" else _width([inertia])
        lines.append(
            f"{'inertia' if kind == 'rotational' else 'mass'} {fixed(levels.inertia, unit_of('mass', kind))}{source}"
        )
    assert levels.forward is not None  # or the log is to be recorded again
    assert levels.backward is not None
    identified = [
        estimate
        for estimate in fit.estimates
        if estimate.name in fit.levels and estimate.status == "identified"
    ]
    friction = f"friction {fixed(levels.forward, unit)} forward, {fixed(levels.backward, unit)} backward{_width(identified)}"
    is_known = all(
        estimate.status in ("identified", "held")
        for estimate in fit.estimates
        if estimate.name == "offset"
    )
    lines.append(
        friction
        + (
            f", constant force {fixed(levels.constant, unit)}"
            if levels.constant and is_known
            else ""
        )
    )
    for drive_unit in drive_units(axis, kind).efforts:
        values = (
            number(float(f"{drive_unit.of(level):.3g}"), digits=3)
            for level in (levels.forward, levels.backward)
        )
        lines.append(f"  in {typeset(drive_unit.name)}: {', '.join(values)}")
    return labelled("Type in", lines)


def _width(estimates: list[Estimate]) -> str:
    """Return the largest half-width of these parameters."""
    halves = [
        estimate.interval_percent for estimate in estimates if estimate.interval_percent is not None
    ]
    return f" ± {number(max(halves), digits=2)}\u00a0%" if halves else ""


def _gain(
    simulation: SimulationResult | None, following: Following | None, axis: Axis | None
) -> list[Line]:
    """Return the following error without and with friction feedforward."""
    if simulation is None:
        return [
            Line(
                "Gain", f"not simulated: {no_gain(simulation, following, axis, usable=True).remark}"
            )
        ]
    gain = gain_of(simulation)
    if (
        gain is None
        or not gain.steps
        or (following is not None and following.contradiction is not None)
    ):
        return [
            Line(
                "Gain", f"not predicted: {no_gain(simulation, following, axis, usable=True).remark}"
            )
        ]
    return [
        Line("Gain", gain.headline, "gain"),
        Line("", "(following error, simulated: confirm on the machine)"),
    ]


def _warnings(fit: Fit, following: Following | None) -> list[Line]:
    """Return the gravest warnings with their codes."""
    doubts = [diagnostic for diagnostic in fit.diagnostics if diagnostic.severity != "note"]
    if following is not None and following.contradiction is not None:
        doubts.append(following.contradiction)
    matter, ranks = (
        {estimate.name for estimate in fit.estimates if estimate.matters},
        {code: rank for rank, code in enumerate(DOUBTS)},
    )
    doubts.sort(
        key=lambda doubt: (
            doubt.severity != "error",
            ranks.get(doubt.code, len(ranks)),
            bool(doubt.parameter) and doubt.parameter not in matter,
        )
    )
    lines = dict.fromkeys(f"{_named(diagnostic)} [{diagnostic.code}]" for diagnostic in doubts)
    more = len(lines) - WARNINGS
    lines = [*lines][:WARNINGS] + (
        [f"{f'{more} more: -v. ' if more > 0 else ''}To explain a warning: bristle explain CODE"]
        if lines
        else []
    )
    models = dict.fromkeys(
        str(diagnostic.numbers["model"]) for diagnostic in doubts if diagnostic.numbers.get("model")
    )
    proposed = [Line("Try", comparison_with(fit, [*models][:1]))] if models else []
    return [*labelled("Warnings", lines), *proposed]


def _named(diagnostic: Diagnostic) -> str:
    """Return the meaning of a warning, after the parameter that it concerns."""
    means = SENTENCES[diagnostic.code].means
    return f"{diagnostic.parameter}: {means}" if diagnostic.parameter else capital(means)
