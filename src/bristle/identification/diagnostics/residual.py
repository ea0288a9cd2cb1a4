"""What the part of the effort that a model leaves over says of the model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bristle.core.diagnostic import Diagnostic
from bristle.friction import is_static
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.roles import Role, name_of, names_of
from bristle.identification.settings import Settings

__all__ = ["about_residual", "about_rise"]

DIRECTIONS = {1: ("",), 2: ("forward", "backward")}


def about_residual(
    problem: InverseDynamics, values: Mapping[str, float], percent: float, settings: Settings
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """Return a warning where the model leaves much of the effort [%] over, and where it lacks pre-sliding."""
    residual = problem.dataset.effort - problem.predicted(values)
    if percent >= settings.reversal_error and _lacks_presliding(problem, values, residual, settings):
        code = "no-presliding"
    elif percent >= settings.poor_error:
        code = "unexplained"
    elif percent >= settings.coloured_error and _from_row_to_row(residual) > settings.coloured_correlation:
        code = "coloured-residual"
    else:
        return ()
    return (Diagnostic(code, numbers={"percent": percent}),)


def about_rise(problem: InverseDynamics, values: Mapping[str, float]) -> tuple[Diagnostic, ...]:
    """Return a remark where friction rises with speed before it levels off, which no break-away force does."""
    variables, kind = problem.parameters.component.variables, problem.dataset.kind
    firsts, levels = names_of(Role.BREAK_AWAY, variables), names_of(Role.LEVEL, variables)
    speed = name_of(Role.FALL, variables)
    if speed is None or len(firsts) != len(levels):
        return ()
    diagnostics = []
    for first, level, direction in zip(firsts, levels, DIRECTIONS.get(len(firsts), ()), strict=False):
        if values[first] < values[level]:
            numbers = {
                "first": values[first], "level": values[level], "speed": values[speed], "direction": direction,
            }  # fmt: skip
            diagnostics.append(Diagnostic("rising-friction", first, "warning", numbers, kind))
    return tuple(diagnostics)


def _from_row_to_row(residual: np.ndarray) -> float:
    total = float(residual @ residual)
    return float(residual[1:] @ residual[:-1]) / total if total > 0.0 else 0.0


def _lacks_presliding(
    problem: InverseDynamics, values: Mapping[str, float], residual: np.ndarray, settings: Settings
) -> bool:  # fmt: skip
    """Return whether a static model errs mostly around reversals, and there by friction that lags behind it."""
    total = float(residual @ residual)
    if not is_static(problem.model(values)) or not any(problem.dataset.reversals) or total == 0.0:
        return False
    dataset = problem.dataset
    near = dataset.samples_from_reversal < settings.reversal_periods / (dataset.cutoff * dataset.sample_time)
    if not near.any():
        return False
    share = float(residual[near] @ residual[near]) / total
    friction = np.abs(problem.friction(values))
    if not friction.any():
        return False
    behind = -float(np.mean(residual[near] * np.sign(dataset.velocity[near]))) / float(np.mean(friction))
    much = max(settings.reversal_share, settings.reversal_excess * float(np.mean(near)))
    return share > much and behind > settings.reversal_lag
