"""What a fit leaves over says of the model, and the treatment of the log of the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.core.normal import NORMAL_95
from bristle.friction import is_static
from bristle.identification.covariance import CLUSTERS
from bristle.identification.dataset import Dataset
from bristle.identification.half_cycles import neighbour_correlation
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Role, name_of, names_of
from bristle.identification.result import Estimate
from bristle.identification.settings import Settings

__all__ = ["about_alignment", "about_held_effort", "about_noise", "about_residual", "about_rise", "about_treatment", "noisy_inertia"]

FALLS_WITH = 5.0  # power of the cut-off that the noise of the acceleration grows with
MENDED = 0.1  # of the share of noise that is told
DIRECTIONS = {1: ("",), 2: ("forward", "backward")}


def about_residual(problem: InverseDynamics, values: Mapping[str, float], percent: float, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where the model leaves much of the effort [%] over, and where it lacks pre-sliding."""
    residual = problem.dataset.effort - problem.predicted(values)
    if percent >= settings.reversal_error and _lacks_presliding(problem, values, residual, settings):
        code = "no_presliding"
    elif percent >= settings.poor_error:
        code = "unexplained"
    elif percent >= settings.coloured_error and neighbour_correlation(residual) > settings.coloured_correlation:
        code = "coloured_residual"
    else:
        return ()
    return (Diagnostic(code, numbers={"percent": percent}),)


def _lacks_presliding(problem: InverseDynamics, values: Mapping[str, float], residual: np.ndarray, settings: Settings) -> bool:
    """Return whether a static model errs mostly around reversals, and there by friction that lags behind it."""
    dataset, total = problem.dataset, float(residual @ residual)
    near = dataset.samples_from_reversal < settings.reversal_periods / (dataset.cutoff * dataset.sample_time)
    if not is_static(problem.model(values)) or not near.any() or total == 0.0:
        return False
    friction = np.abs(problem.friction(values))
    if not friction.any():
        return False
    share = float(residual[near] @ residual[near]) / total
    behind = -float(np.mean(residual[near] * np.sign(dataset.velocity[near]))) / float(np.mean(friction))
    much = max(settings.reversal_share, settings.reversal_excess * float(np.mean(near)))
    return share > much and behind > settings.reversal_lag


def about_rise(problem: InverseDynamics, values: Mapping[str, float]) -> tuple[Diagnostic, ...]:
    """Return a remark where friction rises with speed before it levels off, which no break-away force does."""
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
            {"first": values[first], "level": values[level], "speed": values[speed], "direction": direction},
            problem.dataset.kind,
        )
        for first, level, direction in zip(firsts, levels, DIRECTIONS.get(len(firsts), ()), strict=False)
        if values[first] < values[level]
    )


def about_held_effort(problem: InverseDynamics, estimates: Sequence[Estimate], settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where half a sample between effort and position decides on the damping of the bristles."""
    dataset, variables = problem.dataset, problem.parameters.variables

    def identified(role: Role) -> dict[str, float]:
        names = names_of(role, variables)
        return {one.name: one.value for one in estimates if one.status == "identified" and one.name in names}

    shift = 0.5 * dataset.sample_time * max(identified(Role.STIFFNESS).values(), default=0.0)
    touched = tuple(name for name, damping in identified(Role.MICRO_DAMPING).items() if shift > settings.half_sample_damping * abs(damping))
    aligned = dataset.alignment is not None and dataset.alignment.delay is not None
    if dataset.held is not None or aligned or not touched:
        return ()
    return (Diagnostic("half_sample", touched[0], "warning", {"names": touched, "shift": shift}, dataset.kind),)


def about_noise(problem: InverseDynamics, estimates: Sequence[Estimate], settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where noise of the position makes the inertia too small, but not so much that it is unknown."""
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
    """Return by how much noise of the position makes the inertia too small, and the cut-off that would mend it."""
    share = dataset.acceleration_noise_share
    enough = dataset.bandwidth * (MENDED * settings.acceleration_noise / share) ** (1.0 / FALLS_WITH)
    return Diagnostic("noisy_acceleration", name, "warning", {"percent": 100.0 * share, "cutoff": enough})


def about_alignment(problem: InverseDynamics, solution: Solution, residual: np.ndarray, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return what was found of the channels in time, and where all rows want another inertia than was found with it."""
    dataset, alignment, about = problem.dataset, problem.dataset.alignment, list[Diagnostic]()
    if alignment is None:
        return ()
    if alignment.delay is not None:
        half_width = alignment.delay_half_width or 0.0
        numbers = {"delay": alignment.delay, "samples": alignment.delay / dataset.sample_time, "half_width": half_width}
        rough = half_width > settings.delay_rough * dataset.sample_time
        code, severity = ("delay_rough", "warning") if rough else ("delay_found", "note")
        about.append(Diagnostic(code, severity=severity, numbers=numbers))
    elif alignment.sought:
        about.append(Diagnostic("delay_unknown"))
    if alignment.smoothing is not None:
        numbers = {
            "lag": abs(alignment.smoothing),
            "half_width": alignment.smoothing_half_width or 0.0,
            "channel": "effort" if alignment.smoothing > 0.0 else "position" if alignment.of_position else "command",
        }
        about.append(Diagnostic("filter_suspect", numbers=numbers))
    if alignment.filter_open and alignment.delay is not None:
        feeling = Role.STIFFNESS, Role.MICRO_DAMPING
        touched = tuple(name for role in feeling for name in names_of(role, problem.parameters.variables))
        numbers = {"delay": abs(alignment.delay), "names": touched}
        about.append(Diagnostic("delay_or_filter", severity="warning" if touched else "note", numbers=numbers))
    inertia = name_of(Role.INERTIA, problem.parameters.plant.variables) or ""
    held = problem.parameters.fixed.get(inertia)
    if held is not None and held.half_width is not None:
        change, error = _preferred(problem, inertia, solution, residual)
        joint = float(np.hypot(held.half_width / NORMAL_95, error))
        least = (settings.stages_apart + 2.0 * dataset.acceleration_noise_share) * held.value
        if abs(change) > max(settings.stages_differ * joint, least):
            numbers = {"first": held.value, "value": held.value + change}
            about.append(Diagnostic("stages_differ", inertia, "warning", numbers, dataset.kind))
    return tuple(about)


def _preferred(problem: InverseDynamics, name: str, solution: Solution, residual: np.ndarray) -> tuple[float, float]:
    """Return by how much all rows would change a parameter of the plant, and the standard error of that."""
    column = problem.mechanical(problem.unit(name))
    basis = np.linalg.qr(solution.jacobian)[0]
    apart = column - basis @ (basis.T @ column)
    square = float(apart @ apart)
    if square <= 0.0:
        return 0.0, np.inf
    scores = [float(np.sum(part)) for part in np.array_split(apart * residual, CLUSTERS)]
    return float(apart @ residual) / square, float(np.sum(np.square(scores))) ** 0.5 / square


def about_treatment(dataset: Dataset) -> tuple[Diagnostic, ...]:
    """Return what was done to a log before a model was fitted to it."""
    remarks: dict[str, dict[str, float]] = {
        "filtered": {"cutoff": dataset.cutoff, "dropped": dataset.dropped, "decimation": dataset.decimation}
    }
    if dataset.calmed_from:
        remarks["rows_calmed"] = {"percent": 100.0 * dataset.calmed_from, "decimation": dataset.decimation}
    if dataset.rest_share > 0.0 and not dataset.keeps_rests:
        remarks["rests_left_out"] = {"percent": 100.0 * dataset.rest_share}
    if dataset.creeping:
        remarks["creeps"] = {"resolution": dataset.resolution}
    remarks["standard_errors"] = {}
    return tuple(Diagnostic(code, severity="note", numbers=numbers) for code, numbers in remarks.items())
