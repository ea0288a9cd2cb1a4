"""Whether a model has the structure of the axis: which force it lacks, by name, and which model has it."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.variable import KINDS
from bristle.friction import is_static
from bristle.friction.next_model import SLOT_OF, goes_by_name, model_with
from bristle.identification.estimation import Estimation
from bristle.identification.missing_force import Missing, missing_forces, play_at_flanks
from bristle.identification.missing_rows import Rows
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.identification.slow_force import slow_forces

__all__ = ["missing_in", "next_models", "with_structure"]

CODES = {
    "speed": "missing_speed",
    "direction": "missing_direction",
    "lag": "missing_lag",
    "play": "missing_play",
    "presliding": "missing_presliding",
    "position": "missing_position",
    "ripple": "missing_ripple",
    "gravity": "missing_gravity",
    "transmitted": "missing_transmitted",
    "flanks": "missing_flanks",
    "load": "missing_load",
    "temperature": "missing_temperature",
}
"""The code of each cause; the others are further channels of the log."""
LEVEL, DAMPED = "coulomb+", "coulomb_viscous+"
WITHOUT_MODEL = ("gravity", "flanks")  # told by what to write or to look for
NEARLY = 0.1  # of a turn, by which a period may miss a whole number of times
AMPLITUDE = 2.0**0.5  # of waves, over their root mean square


def missing_in(fit: Fit, estimation: Estimation, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a fit along the measured motion lacks, and what noise and scatter leave [N or N*m]."""
    problem, solution = estimation.inverse, estimation.solution
    if fit.unfinished or estimation.simulates or solution.jacobian.shape[0] != fit.traces.residual.size:
        return (), 0.0
    values = problem.parameters.complete(solution.values)
    rows = Rows.of(
        problem.dataset,
        problem.half_cycles,
        fit.traces.residual,
        solution.jacobian,
        fit.traces.predicted - fit.traces.mechanical,
        problem.friction_slope(values),
    )
    for test in (missing_forces, slow_forces, play_at_flanks):
        missing, left = test(rows, settings)
        if missing:
            return missing, left
    return (), 0.0


def with_structure(fit: Fit, estimation: Estimation, settings: Settings, lead: float | None = None, compared: Collection[str] = ()) -> Fit:
    """Return a fit with what its model lacks before all else that is to be known of it.

    A `lead` [m or rad] is that of the axis file: of its turns cogging is told. Nobody is sent to models that were
    `compared` and are no better. Parameters are effective however small the force is; a warning is what may matter to
    the use of the model.
    """
    if any(diagnostic.code == "never_slides" for diagnostic in fit.diagnostics) and is_static(fit.friction):
        return _with_presliding(fit, compared)
    missing, left = missing_in(fit, estimation, settings)
    if not missing:
        return fit
    kind, friction = fit.friction.kind, fit.traces.predicted - fit.traces.mechanical
    level = float(np.sqrt(np.mean(friction**2)))
    lacking = float(np.sqrt(sum(force.force**2 for force in missing)))
    names = tuple(estimate.name for estimate in fit.estimates if estimate.status == "identified")
    numbers: dict[str, Number] = {
        "missing": lacking,
        "percent": 100.0 * lacking / level,
        "chance": left,
        "names": names,
        "causes": tuple(force.cause for force in missing),
        "small": int(lacking < settings.missing_force * level),
    }
    named = [_diagnostic(force, level, fit.friction, lead, compared) for force in missing]
    structure = (Diagnostic("structure", "", "warning", numbers, kind), *named)
    if numbers["small"]:
        structure = tuple(replace(diagnostic, severity="note") for diagnostic in structure)
    return replace(fit, diagnostics=(*structure, *fit.diagnostics))


def next_models(fit: Fit, estimation: Estimation, settings: Settings) -> tuple[str, ...]:
    """Return the models with one more slot to try beside a fit: both directions apart, and what its residual names.

    A slot of a level alone is tried beside a damping as well, which what was missing may have hidden. Beside what is a
    person's own nothing is tried.
    """
    if not goes_by_name(fit.friction.component):
        return ()
    causes = ("direction", *(_slot_cause(force) for force in missing_in(fit, estimation, settings)[0]))
    names = (model_with(cause, fit.friction) for cause in causes if cause in SLOT_OF)
    named = [name for name in names if name]
    damped = [name.replace(LEVEL, DAMPED, 1) for name in named if name.startswith(LEVEL)]
    return tuple(dict.fromkeys([*named, *damped]))


def _with_presliding(fit: Fit, compared: Collection[str]) -> Fit:
    """Return the fit of a static model to a log that never slides: all that it leaves over builds up over a distance.

    Such a force lies over the position as much as over the way since a reversal, and would be taken for one of the
    place.
    """
    kind, friction = fit.friction.kind, fit.traces.predicted - fit.traces.mechanical
    level, left = (float(np.sqrt(np.mean(signal**2))) for signal in (friction, fit.traces.residual))
    numbers: dict[str, Number] = {
        "force": left,
        "percent": 100.0 * left / level if level > 0.0 else 100.0,
        "share_percent": 100.0,
        **_next("hysteresis", fit.friction, compared),
    }
    return replace(fit, diagnostics=(Diagnostic(CODES["presliding"], "", "warning", numbers, kind), *fit.diagnostics))


def _next(cause: str, friction: Model, compared: Collection[str]) -> dict[str, Number]:
    """Return the model to try next, or the one of those compared that it would be."""
    name = model_with(cause, friction)
    return {"model": "", "compared": name} if name in compared else {"model": name, "compared": ""}


def _slot_cause(missing: Missing) -> str:
    """Return what a slot is named after that has a force: a ripple that turns with the motion is one of the level."""
    return "level" if missing.cause == "ripple" and missing.alike is False else missing.cause


def _diagnostic(missing: Missing, level: float, friction: Model, lead: float | None, compared: Collection[str]) -> Diagnostic:
    # A static model has no distance over which its force turns: what builds up there is pre-sliding before it is play.
    cause = "presliding" if missing.cause == "play" and is_static(friction) else missing.cause
    numbers: dict[str, Number] = {"force": missing.force, "percent": 100.0 * missing.force / level, "share_percent": 100.0 * missing.share}
    if cause not in WITHOUT_MODEL:
        numbers |= _next(_slot_cause(missing) if cause == "ripple" else cause, friction, compared)
    if cause == "ripple":
        numbers |= {"period": missing.period, "amplitude": AMPLITUDE * missing.force}
        numbers |= _turns_of(missing, friction, lead)
    if cause == "gravity":
        numbers |= {"amplitude": missing.amplitude}
    if cause == "flanks":
        numbers |= {"ratio": missing.ratio}
    if cause not in CODES:
        numbers |= {"channel": cause}
    return Diagnostic(CODES.get(cause, "missing_channel"), "", "warning", numbers, friction.kind)


def _turns_of(ripple: Missing, friction: Model, lead: float | None) -> dict[str, Number]:
    """Return in which directions a ripple pulls, and how often it comes back in a turn: what cogging is written with.

    Of a turn nobody told, the period of the ripple is one.
    """
    pulls = {True: "alike", False: "turning", None: ""}[ripple.alike]
    turn = lead if lead is not None else 2.0 * math.pi if friction.kind == KINDS[1] else None
    orders = np.array(ripple.overtones) * (turn / ripple.period if turn else 1.0)
    integral = orders.size > 0 and bool(np.all(orders > 0.5)) and bool(np.all(np.abs(orders - np.round(orders)) < NEARLY))
    harmonics = tuple(int(order) for order in np.round(orders)) if integral else ()
    turner = "screw" if turn else "motor"
    return {"pulls": pulls, "harmonics": harmonics, "turner": turner, "travel": turn or ripple.period}
