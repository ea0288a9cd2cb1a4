"""What noise and what the model leaves over do to a fit, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from bristle.core.typography import with_unit
from bristle.friction import is_static
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.result import Estimate

__all__ = ["about_held_effort", "about_noise", "about_residual", "about_rise"]

NOISY = 0.01  # share of noise in the mean square of the acceleration
HALF_SAMPLE = 0.1  # share of a damping from which half a sample of the stiffness matters
SMALL_PERCENT, COLOURED_PERCENT, POOR_PERCENT = 5.0, 15.0, 40.0  # force error
COLOURED = 0.8  # correlation of the residual from row to row
NEAR_PERIODS = 3.0  # of the cut-off, around a reversal
AT_REVERSALS = 0.25  # share of the residual there that is much,
TIMES_THE_ROWS = 3.0  # if it is so many times the share of the rows
LAGGING = 0.1  # of the friction force, by which friction is still behind there


def about_held_effort(problem: InverseDynamics, estimates: Sequence[Estimate]) -> tuple[str, ...]:
    """Return a warning where half a sample between effort and position decides on the damping of the bristles."""
    dataset, variables = problem.dataset, problem.parameters.variables
    shown = [one for one in estimates if one.status == "identified" and variables[one.name].excitation == "presliding"]
    stiffness = max((one.value for one in shown if variables[one.name].quantity == "force/length"), default=0.0)
    shift = 0.5 * dataset.sample_time * stiffness
    touched = [
        one
        for one in shown
        if variables[one.name].quantity == "force*time/length" and shift > HALF_SAMPLE * abs(one.value)
    ]
    if dataset.held is not None or not touched:
        return ()
    return (
        f"{', '.join(one.name for one in touched)} may be too large by {with_unit(shift, touched[0].unit)} and more: "
        "an effort that the controller holds until its next sample leads the position by half a sample. Write "
        "`held = true` under [effort] of the axis file if it does so, `held = false` if not",
    )


def about_noise(problem: InverseDynamics) -> tuple[str, ...]:
    """Return a warning where noise of the position makes the inertia too small."""
    dataset = problem.dataset
    share = dataset.acceleration_noise_share
    if "M" not in problem.parameters.free or share < NOISY:
        return ()
    enough = dataset.bandwidth * (0.1 * NOISY / share) ** 0.2
    return (
        f"M is too small by about {100.0 * share:.2g} %: so much of the acceleration is noise of the position; lower "
        f"the cut-off to {enough:.0f} Hz",
    )


def about_residual(problem: InverseDynamics, values: Mapping[str, float], percent: float) -> tuple[str, ...]:
    """Return a warning where the model leaves much of the effort [%] over, and where it lacks pre-sliding."""
    residual = problem.dataset.effort - problem.predicted(values)
    if percent >= SMALL_PERCENT and _lacks_presliding(problem, values, residual):
        return (
            f"the model leaves {percent:.0f} % of the effort unexplained, much of it around reversals, where friction "
            "builds up over a distance that this model does not have: its parameters may be biased beyond "
            "their intervals. Add `lugre` or `dahl` to the comparison, or leave slow and short reversals out",
        )
    if percent >= POOR_PERCENT:
        return (
            f"the model leaves {percent:.0f} % of the effort unexplained: check units, signs, the delay between the "
            "channels and the mass in the axis file",
        )
    if percent >= COLOURED_PERCENT and _from_row_to_row(residual) > COLOURED:
        return (
            f"the model leaves {percent:.0f} % of the effort unexplained, and that is no noise but lasts from row to "
            "row: compare it with models that know more, and take the intervals for too narrow",
        )
    return ()


def about_rise(problem: InverseDynamics, values: Mapping[str, float]) -> tuple[str, ...]:
    """Return a remark where friction rises with speed before it levels off, which no break-away force does."""
    variables = problem.parameters.variables
    found = []
    for side in ("", "_pos", "_neg"):
        first, level = values.get(f"F_0{side}"), values.get(f"F_C{side}")
        if first is not None and level is not None and "v_S" in values and first < level:
            unit = variables[f"F_0{side}"].unit(problem.dataset.kind)
            where = {"_pos": ", moving forward", "_neg": ", moving backward"}.get(side, "")
            speed = with_unit(values["v_S"], variables["v_S"].unit(problem.dataset.kind))
            found.append(
                f"friction rises from {with_unit(first, unit)} to {with_unit(level, unit)} over the first "
                f"{speed}{where}: no Stribeck effect, whose force falls"
            )
    return tuple(found)


def _from_row_to_row(residual: np.ndarray) -> float:
    whole = float(residual @ residual)
    return float(residual[1:] @ residual[:-1]) / whole if whole > 0.0 else 0.0


def _lacks_presliding(problem: InverseDynamics, values: Mapping[str, float], residual: np.ndarray) -> bool:
    """Return whether a static model errs mostly around reversals, and there by friction that lags behind it."""
    whole = float(residual @ residual)
    if not is_static(problem.model(values)) or not problem.dataset.reversals or whole == 0.0:
        return False
    dataset = problem.dataset
    near = dataset.samples_from_reversal < NEAR_PERIODS / (dataset.cutoff * dataset.sample_time)
    if not near.any():
        return False
    share = float(residual[near] @ residual[near]) / whole
    friction = np.abs(problem.friction(values))
    if not friction.any():
        return False
    behind = -float(np.mean(residual[near] * np.sign(dataset.velocity[near]))) / float(np.mean(friction))
    return share > max(AT_REVERSALS, TIMES_THE_ROWS * float(np.mean(near))) and behind > LAGGING
