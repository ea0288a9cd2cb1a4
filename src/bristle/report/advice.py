"""What to measure next, for each parameter that a log did not determine."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bristle.identification.result import Fit

__all__ = ["WRITTEN_BY", "next_measurements"]

WRITTEN_BY = " Written by: "  # between the motion that is needed and the command for it

# The purposes of a motion (`bristle excite --for`) that serves.
MOTIONS = {
    "sliding": "stribeck",
    "speed": "stribeck",
    "stribeck": "stribeck",
    "presliding": "presliding,break-away,damping",
    "acceleration": "stribeck",
}
ADVICE = {
    "sliding": "Move in both directions, at least ten reversals, each with a stretch of steady motion after it.",
    "speed": "Move at several steady speeds between a tenth and all of the working speed, in both directions.",
    "stribeck": (
        "Move slowly and steadily, in both directions: at least five speeds below the one at which friction is least, "
        "down to where the axis begins to stick."
    ),
    "presliding": (
        "Reverse gently and often, at amplitudes of the break-away distance and below (slow triangles of a few "
        "encoder counts to some ten times that), sampled so that a reversal lasts at least fifty samples."
    ),
    "displacement": (
        "Move at several amplitudes, up to the largest that matters and through the resonance if there is one, so that "
        "the force yields or hardens visibly."
    ),
    "acceleration": "Accelerate harder, or weigh the moving mass and give it in the axis file.",
}


def next_measurements(fit: Fit) -> list[tuple[str, str]]:
    """Return which motion to record so that a log determines the parameters that this one did not."""
    variables = fit.plant.component.variables | fit.friction.component.variables
    open_: dict[str, list[str]] = {}
    for estimate in fit.estimates:
        if estimate.status in ("unidentifiable", "at_edge") and estimate.name in variables:
            open_.setdefault(variables[estimate.name].excitation, []).append(estimate.name)
    return [(", ".join(names), _advice_text(needed)) for needed, names in open_.items() if needed in ADVICE]


def _advice_text(needed: str) -> str:
    if needed not in MOTIONS:
        return ADVICE[needed]
    return f"{ADVICE[needed]}{WRITTEN_BY}`bristle excite AXIS.toml --for {MOTIONS[needed]}`"
