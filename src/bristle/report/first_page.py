"""The first page of a report: is it good, what to type in, what it gains and costs, can it be trusted, what next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.typography import number, typeset
from bristle.core.variable import Kind, unit_of
from bristle.identification.parameters import Role, name_of
from bristle.prediction.drive_table import LevelValues, level_values, never_slid, reversal_distance
from bristle.prediction.drive_units import DriveUnits, drive_units, length_units
from bristle.report.advice import WRITTEN_BY
from bristle.report.front import about, answered, fixed, length_text, percent_text
from bristle.report.messages import message, sentence_of, why_effective

if TYPE_CHECKING:
    from bristle.core.axis import Axis
    from bristle.identification.result import Estimate, Fit, Identification
    from bristle.prediction.following import Following
    from bristle.simulation.result import SimulationResult, VariantResult

__all__ = ["answers", "facts"]

NAMES_MAX = 8  # parameters whose intervals stand on the first page


def facts(identification: Identification) -> str:
    """Return what the page is about: its log, the model, and when it was made."""
    log, further = identification.log, len(identification.further_logs)
    logs = f"{log.source.name.strip('<>')} and {further} more" if further else log.source.name.strip("<>")
    return about(f"log {logs}, {fixed(log.duration, 's')}", f"model {identification.best.name}")


def answers(
    identification: Identification,
    simulation: SimulationResult | None,
    following: Following | None,
    next_measurements: Sequence[tuple[str, str]],
    axis: Axis | None = None,
    *,
    usable: bool = True,
) -> list[tuple[str, list[str]]]:
    """Return the five questions of a person who has an axis, each with its answer in a few lines."""
    fit = identification.best
    typed = _typed_in(fit, axis) if usable else ["nothing yet: measure again first"]
    return answered(_quality(fit), typed, _gain(fit, simulation, following), _trust(fit), _next(fit, next_measurements, usable=usable))


def _quality(fit: Fit) -> list[str]:
    if fit.position_rmse is not None:
        line = f"misses the position of the log by {length_text(fit.position_rmse, fit.plant.kind)}"
    elif fit.loop_rmse is not None:
        line = f"misses the effort of the loop by {fixed(fit.loop_rmse, unit_of('force', fit.plant.kind))}"
    else:
        line = f"misses {percent_text(fit.force_error_percent)} of the effort of the log, "
        line += f"{percent_text(fit.friction_alone_error_percent)} of what friction takes"
    if fit.held_out is None:
        return [line, "nothing was held out"]
    return [line, f"on {fit.held_out.of} that it was not fitted to: {percent_text(fit.held_out.mean_percent)}"]


def _typed_in(fit: Fit, axis: Axis | None) -> list[str]:
    levels, unit = level_values(fit), unit_of("force", fit.plant.kind)
    if not any(estimate.status in ("identified", "held") for estimate in fit.estimates if estimate.value):
        return ["nothing: no parameter was identified"]
    if levels is None and never_slid(fit):
        return ["nothing: the log never slides, so that no level of friction was seen; record motion that slides"]
    if levels is None:
        return ["nothing: a plant on a spring does not move on steadily"]
    mass = "inertia" if fit.plant.kind == "rotational" else "mass"
    sides = {"F+": levels.forward, "F\u2212": levels.backward}
    words = [f"{name}\u00a0{fixed(value, unit)}" for name, value in sides.items() if value is not None]
    words += [f"constant {fixed(levels.constant, unit)}"] if levels.constant else []
    words += _viscous_words(levels, fit.plant.kind)
    weighed = fixed(levels.inertia, unit_of("mass", fit.plant.kind))
    inertia, units = name_of(Role.INERTIA, fit.plant.component.variables), drive_units(axis, fit.plant.kind)
    is_open = inertia in fit.parameters and fit.parameters[inertia].status == "unidentifiable"
    return [
        f"{mass}: not identified" if is_open else f"{mass} {weighed}",
        f"{', '.join(words)}: never above the steady friction, up to {fixed(levels.deviation, unit)} below it",
        *_in_drive_units(levels, units._replace(inertias=()) if is_open else units),
        *_after_reversal(fit, axis),
        "or the table for the drive, below",
    ]


def _viscous_words(levels: LevelValues, kind: Kind) -> list[str]:
    """Return the viscous friction beside the levels: one value where both directions have the same."""
    unit = unit_of("force*time/length", kind)
    sides = {"forward": levels.viscous_forward, "backward": levels.viscous_backward}
    known = {name: fixed(value, unit) for name, value in sides.items() if value}
    if len(set(known.values())) == 1:
        return [f"viscous {next(iter(known.values()))}"]
    return [f"viscous {name} {text}" for name, text in known.items()]


def _in_drive_units(levels: LevelValues, units: DriveUnits) -> list[str]:
    """Return inertia and levels in each unit that the drive may want them in."""
    lines = [f"that is {fixed(unit.of(levels.inertia), 'kg*m^2')} at the motor" for unit in units.inertias]
    named = {"F+": levels.forward, "F\u2212": levels.backward, "constant": levels.constant or None}
    for unit in units.efforts:
        told = (f"{name}\u00a0{number(unit.of(value), digits=3)}" for name, value in named.items() if value is not None)
        lines.append(f"in {typeset(unit.name)}: {', '.join(told)}")
    return lines


def _after_reversal(fit: Fit, axis: Axis | None) -> list[str]:
    """Return over which distance friction turns, in the units of the drive too; nothing where it turns at once."""
    distance = reversal_distance(fit.friction, float(np.max(np.abs(fit.traces.velocity))))
    if distance == 0.0:
        return []
    motor = [unit for unit in length_units(axis, fit.plant.kind) if "motor" in unit.name]
    beside = "".join(f" ({number(unit.of(distance), digits=2)} {unit.name})" for unit in motor)
    far = length_text(distance, fit.plant.kind)
    return [f"after a reversal 95 % of the friction turns within {far}{beside}"]


def _gain(fit: Fit, simulation: SimulationResult | None, following: Following | None) -> list[str]:
    kind = fit.plant.kind
    if following is None:
        return ["not simulated: that takes a log with a reference, and a controller in the axis file"]
    lines = [f"following error, peak to peak: {length_text(following.measured.peak_to_peak, kind)} in the log"]
    if following.contradiction is not None:
        return [*lines, f"no gain is promised: {message(following.contradiction)}"]
    if following.simulated is not None and following.compensated is not None:
        pair = (following.simulated, following.compensated)
        before, after = (length_text(error.peak_to_peak, kind) for error in pair)
        lines.append(f"simulated: {before} as recorded, {after} compensated")
    if simulation is not None and (efforts := _efforts(simulation)):
        before, after = (fixed(effort, unit_of("force", kind)) for effort in efforts)
        lines.append(f"effort, root mean square: {before} as recorded, {after} compensated")
    return lines


def _efforts(simulation: SimulationResult) -> tuple[float, float] | None:
    """Return the effort of the loop as it is and of its last variant, root mean square; None where one diverged."""
    names = [variant.name for variant in simulation.experiment.variants]
    sides = [simulation.variants[name] for name in (names[0], names[-1])]
    return None if any(not np.all(np.isfinite(side.effort)) for side in sides) else (_rms(sides[0]), _rms(sides[1]))


def _rms(variant: VariantResult) -> float:
    return float(np.sqrt(np.mean(variant.effort**2)))


def _trust(fit: Fit) -> list[str]:
    sought = [estimate for estimate in fit.estimates if estimate.status != "held"]
    identified = [estimate for estimate in sought if estimate.status == "identified"]
    if not identified:
        return ["no parameter was identified"]
    lines = [f"{len(identified)} of {len(sought)} parameters identified; 95 % intervals:"]
    more = f" and {len(identified) - NAMES_MAX} more, below" if len(identified) > NAMES_MAX else ""
    lines.append(", ".join(_precise(estimate) for estimate in identified[:NAMES_MAX]) + more)
    return lines + ([f"they are effective: {why_effective(fit)}"] if fit.effective else [])


def _precise(estimate: Estimate) -> str:
    half = estimate.interval_percent
    told = "–" if half is None else f"± {number(half, digits=2)}\u00a0%" if half < 100.0 else "≈ 0"
    return f"{estimate.name} {told}"


def _next(fit: Fit, next_measurements: Sequence[tuple[str, str]], *, usable: bool) -> list[str]:
    grave = (sentence_of(doubt.code).advice for doubt in fit.diagnostics if doubt.severity == "error")
    mends = [advice for advice in dict.fromkeys(grave) if advice != "nothing"]
    models = [str(doubt.numbers["model"]) for doubt in fit.diagnostics if doubt.numbers.get("model")]
    lines = [f"fit what this model lacks: `--model {','.join(dict.fromkeys(models))}`"] if models else []
    by_motion: dict[str, list[str]] = {}
    for names, motion in next_measurements:
        sentence, _, command = motion.partition(WRITTEN_BY)
        by_motion.setdefault(f"{command}, which writes the motion" if command else sentence, []).append(names)
    lines += [f"for {', '.join(names)}: {motion}" for motion, names in by_motion.items()]
    lines = mends + lines
    if not usable:
        return lines or ["record the axis again, in both directions and at several speeds"]
    return lines or ["try it on the machine, record again, and let `bristle compare` tell what it gained"]
