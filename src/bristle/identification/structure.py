"""The structure of a model: missing forces by name, and models that contain them."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.least_squares import apart_from
from bristle.core.normal import NORMAL_95
from bristle.identification.dataset import Dataset
from bristle.identification.elasticity import Elastic
from bristle.identification.estimate import Estimate
from bristle.identification.estimation import Estimation
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.missing_force import Missing, missing_forces
from bristle.identification.missing_rows import Rows
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Role, name_of, names_of
from bristle.identification.play import play_at_flanks
from bristle.identification.problem import CLUSTERS
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.models.friction import is_static
from bristle.models.friction.next_model import goes_by_name, model_with

CODES = {
    "speed": "missing_speed",
    "direction": "missing_direction",
    "lag": "missing_lag",
    "play": "missing_play",
    "presliding": "missing_presliding",
}
"""The code of each cause."""
LEVEL, DAMPED = "coulomb+", "coulomb_viscous+"
WITHOUT_MODEL = ("play",)  # causes without a model to try next
# Causes around reversals, also found with a drive that is not rigid.
AS_OF_A_DRIVE = ("speed", "lag", "presliding")
LOOKS_LIKE = "filter_suspect"  # diagnostic that a drive that is not rigid causes
MOST_ROWS = 120_000  # of a log, in the search for missing forces


def missing_in(
    fit: Fit, estimation: Estimation, settings: Settings, coupling: Elastic | None = None
) -> tuple[tuple[Missing, ...], float]:
    """Return the forces missing in a fit along the measured motion, and the remaining residual [N or N*m]."""
    if not estimation.missing:  # the search takes seconds on a long log
        estimation.missing.append(_missing_in(fit, estimation, settings, coupling))
    return estimation.missing[0]


def _missing_in(
    fit: Fit, estimation: Estimation, settings: Settings, coupling: Elastic | None
) -> tuple[tuple[Missing, ...], float]:
    problem, solution = estimation.inverse, estimation.solution
    if (
        fit.unfinished
        or estimation.simulates
        or solution.jacobian.shape[0] != fit.traces.residual.size
    ):
        return (), 0.0
    rows = Rows.of(
        problem.dataset,
        problem.half_cycles,
        fit.traces.residual,
        solution.jacobian,
        fit.traces.predicted - fit.traces.mechanical,
        problem.friction_slope(problem.parameters.complete(solution.values)),
    ).pieces(MOST_ROWS)
    missing, left = missing_forces(rows, settings, static=is_static(fit.friction))
    if missing and missing[0].cause not in AS_OF_A_DRIVE:
        return missing, left
    drive, rest = play_at_flanks(rows, settings)
    if drive and (not missing or drive[0].share > missing[0].share):
        return drive, rest
    # An elastic drive causes such forces: they do not show that friction has them.
    return tuple(
        force for force in missing if coupling is None or force.cause not in AS_OF_A_DRIVE
    ), left


def with_structure(
    fit: Fit,
    estimation: Estimation,
    settings: Settings,
    compared: Collection[str] = (),
    coupling: Elastic | None = None,
) -> Fit:
    """Return a fit with diagnostics of an elastic coupling and missing forces first; `compared` models are not suggested as the next."""
    if coupling is not None:
        further = tuple(
            diagnostic
            for diagnostic in fit.diagnostics
            if diagnostic.code not in (LOOKS_LIKE, "delay_or_filter")
        )
        fit = replace(
            fit, diagnostics=(about_coupling(coupling, estimation.inverse.dataset.cutoff), *further)
        )
    kind, friction = fit.friction.kind, fit.traces.predicted - fit.traces.mechanical
    level = float(np.sqrt(np.mean(friction**2)))
    if (
        coupling is None
        and "never_slides" in map(attrgetter("code"), fit.diagnostics)
        and is_static(fit.friction)
    ):
        # The residual of a static model builds up over a distance. Such a force depends on the position as much as on the way
        # since a reversal, and would be taken for a force over the position.
        left = float(np.sqrt(np.mean(fit.traces.residual**2)))
        percent = 100.0 * left / level if level > 0.0 else 100.0
        numbers = {
            "force": left,
            "percent": percent,
            "share_percent": 100.0,
            **_next("hysteresis", fit.friction, compared),
        }
        return replace(
            fit,
            diagnostics=(
                Diagnostic(CODES["presliding"], "", "warning", numbers, kind),
                *fit.diagnostics,
            ),
        )
    missing, left = missing_in(fit, estimation, settings, coupling)
    if not missing:
        return fit
    lacking = float(np.sqrt(sum(force.force**2 for force in missing)))
    names = tuple(estimate.name for estimate in fit.estimates if estimate.status == "identified")
    numbers: dict[str, Number] = {
        "missing": lacking,
        "percent": 100.0 * lacking / level,
        "chance": left,
        "names": names,
        "causes": tuple(map(attrgetter("cause"), missing)),
        "small": int(lacking < settings.missing_force * level),
    }
    named = [_diagnostic(force, level, fit.friction, compared) for force in missing]
    structure = (Diagnostic("structure", "", "warning", numbers, kind), *named)
    if numbers["small"]:
        structure = tuple(replace(diagnostic, severity="note") for diagnostic in structure)
    drive = any(force.cause == "play" for force in missing)
    further = [
        diagnostic for diagnostic in fit.diagnostics if not drive or diagnostic.code != LOOKS_LIKE
    ]
    first = int(coupling is not None)
    return replace(fit, diagnostics=(*further[:first], *structure, *further[first:]))


def about_coupling(coupling: Elastic, cutoff: float) -> Diagnostic:
    """Return the diagnostic of an elastic coupling, for rows up to a cut-off [Hz]."""
    numbers: dict[str, Number] = {
        **coupling.facts,
        "cutoff": cutoff,
        "one_mass": int(cutoff <= coupling.one_mass),
    }
    return Diagnostic("elastic_load", "", "warning", numbers)


def next_models(fit: Fit, causes: Sequence[str]) -> tuple[str, ...]:
    """Return the models with one more slot to try after a fit, for some causes; empty for models of a user."""
    if not goes_by_name(fit.friction.component):
        return ()
    names = [model_with(cause, fit.friction) for cause in ("direction", *causes)]
    damped = [name.replace(LEVEL, DAMPED, 1) for name in names if name.startswith(LEVEL)]
    return tuple(dict.fromkeys(name for name in (*names, *damped) if name))


def _next(cause: str, friction: Model, compared: Collection[str]) -> dict[str, Number]:
    """Return the model to try next, or its name as `compared` if it was already fitted."""
    name = model_with(cause, friction)
    return {"model": "", "compared": name} if name in compared else {"model": name, "compared": ""}


def _diagnostic(
    missing: Missing, level: float, friction: Model, compared: Collection[str]
) -> Diagnostic:
    cause = missing.cause
    numbers: dict[str, Number] = {
        "force": missing.force,
        "percent": 100.0 * missing.force / level,
        "share_percent": 100.0 * missing.share,
    }
    if cause not in WITHOUT_MODEL:
        numbers |= _next(cause, friction, compared)
    if cause == "play":
        numbers["ratio"] = missing.ratio
    return Diagnostic(CODES[cause], "", "warning", numbers, friction.kind)


FALLS_WITH = 5.0  # the noise of the acceleration grows with this power of the cut-off
DIRECTIONS = {1: ("",), 2: ("forward", "backward")}


def about_residual(percent: float, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning if the residual is a large part of the effort [%]."""
    return (
        (Diagnostic("unexplained", numbers={"percent": percent}),)
        if percent >= settings.poor_error
        else ()
    )


def about_rise(problem: InverseDynamics, values: Mapping[str, float]) -> tuple[Diagnostic, ...]:
    """Return a warning if friction rises with speed before it levels off: then F_S is not a break-away force."""
    variables = problem.parameters.component.variables
    firsts, levels = names_of(Role.BREAK_AWAY, variables), names_of(Role.LEVEL, variables)
    speed = name_of(Role.FALL, variables)
    if speed is None or len(firsts) != len(levels):
        return ()
    return tuple(
        Diagnostic(
            "rising_friction",
            first,
            "warning",
            {
                "first": values[first],
                "level": values[level],
                "speed": values[speed],
                "direction": direction,
            },
            problem.dataset.kind,
        )
        for first, level, direction in zip(
            firsts, levels, DIRECTIONS.get(len(firsts), ()), strict=False
        )
        if values[first] < values[level]
    )


def about_noise(
    problem: InverseDynamics, estimates: Sequence[Estimate], settings: Settings
) -> tuple[Diagnostic, ...]:
    """Return a warning if position noise biases the inertia, but leaves it identifiable."""
    share = problem.dataset.acceleration_noise_share
    inertia = name_of(Role.INERTIA, problem.parameters.plant.variables)
    identified = {estimate.name for estimate in estimates if estimate.status == "identified"}
    if (
        inertia not in identified.intersection(problem.parameters.free)
        or not settings.acceleration_noise <= share <= settings.noisy_inertia
    ):
        return ()
    return (noisy_inertia(problem.dataset, inertia, settings),)


def noisy_inertia(dataset: Dataset, name: str, settings: Settings) -> Diagnostic:
    """Return a warning with the bias of the inertia by position noise, and a cut-off that avoids it."""
    share = dataset.acceleration_noise_share
    # Of the reported share of noise.
    enough = dataset.bandwidth * (0.1 * settings.acceleration_noise / share) ** (1.0 / FALLS_WITH)
    return Diagnostic(
        "noisy_acceleration", name, "warning", {"percent": 100.0 * share, "cutoff": enough}
    )


def about_alignment(
    problem: InverseDynamics, solution: Solution, residual: np.ndarray, settings: Settings
) -> tuple[Diagnostic, ...]:
    """Return diagnostics of delay and filter, and a warning if the rows contradict the measured inertia."""
    dataset, alignment, about = problem.dataset, problem.dataset.alignment, list[Diagnostic]()
    if alignment is None:
        return ()
    if alignment.delay is not None:
        about.append(
            about_delay(
                alignment.delay, alignment.delay_half_width or 0.0, dataset.sample_time, settings
            )
        )
    elif alignment.sought:
        about.append(Diagnostic("delay_unknown"))
    if alignment.smoothing is not None:
        numbers = {
            "lag": abs(alignment.smoothing),
            "half_width": alignment.smoothing_half_width or 0.0,
            "channel": "effort"
            if alignment.smoothing > 0.0
            else "position"
            if alignment.of_position
            else "command",
        }
        about.append(Diagnostic("filter_suspect", numbers=numbers))
    if alignment.filter_open and alignment.delay is not None:
        touched = tuple(
            name
            for role in (Role.STIFFNESS, Role.MICRO_DAMPING)
            for name in names_of(role, problem.parameters.variables)
        )
        numbers = {"delay": abs(alignment.delay), "names": touched}
        about.append(
            Diagnostic(
                "delay_or_filter", severity="warning" if touched else "note", numbers=numbers
            )
        )
    inertia = name_of(Role.INERTIA, problem.parameters.plant.variables) or ""
    held = problem.parameters.fixed.get(inertia)
    if held is not None and held.half_width is not None:
        column = problem.mechanical(problem.unit(inertia))
        apart = apart_from(np.linalg.qr(solution.jacobian)[0], column)
        square = float(apart @ apart)
        if square <= 0.0:
            change, error = 0.0, np.inf
        else:
            scores = [float(np.sum(part)) for part in np.array_split(apart * residual, CLUSTERS)]
            change, error = (
                float(apart @ residual) / square,
                float(np.sum(np.square(scores))) ** 0.5 / square,
            )
        joint = float(np.hypot(held.half_width / NORMAL_95, error))
        least = (settings.stages_apart + 2.0 * dataset.acceleration_noise_share) * held.value
        if abs(change) > max(settings.stages_differ * joint, least):
            about.append(
                Diagnostic(
                    "stages_differ",
                    inertia,
                    "warning",
                    {"first": held.value, "value": held.value + change},
                    dataset.kind,
                )
            )
    return tuple(about)


def about_delay(delay: float, half_width: float, dt: float, settings: Settings) -> Diagnostic:
    """Return the diagnostic of the delay of the effort with its half-width [s]."""
    code, severity = (
        ("delay_rough", "warning")
        if half_width > settings.delay_rough * dt
        else ("delay_found", "note")
    )
    return Diagnostic(
        code,
        severity=severity,
        numbers={"delay": delay, "samples": delay / dt, "half_width": half_width},
    )


def about_treatment(dataset: Dataset) -> tuple[Diagnostic, ...]:
    """Return notes about the treatment of a log before the fits."""
    treated = {
        "cutoff": dataset.cutoff,
        "dropped": dataset.dropped,
        "decimation": dataset.decimation,
    }
    remarks: list[tuple[str, dict[str, float]]] = [("filtered", treated)]
    if dataset.calmed_from:
        remarks.append(
            ("filtered", {"percent": 100.0 * dataset.calmed_from, "decimation": dataset.decimation})
        )
    if dataset.rest_share > 0.0 and not dataset.keeps_rests:
        remarks.append(("rests", {"percent": 100.0 * dataset.rest_share}))
    if dataset.creeping:
        remarks.append(("rests", {"resolution": dataset.resolution}))
    return tuple(
        Diagnostic(code, severity="note", numbers=numbers)
        for code, numbers in (*remarks, ("standard_errors", {}))
    )
