"""The conditions: what changes on the rig after its compensator was identified, which nobody tells it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core.contracts import Model
from bristle.paper.robust.truths import Truth

__all__ = ["CONDITIONS", "MEANINGS", "NOMINAL", "under"]

NOMINAL = "nominal"
SCATTER = 0.1
WAVE, LENGTH = 0.2, 0.75  # of the level, and of the amplitude of the motion
CREEP, TAU = 10.0, 5.0  # force of the branch at the amplitude, were it no branch but a spring [N]; its time [s]


def _scattering(truth: Truth) -> dict[str, Any]:
    name = "scatter" if "scatter" in truth.friction.values else "unevenness"
    return {name: SCATTER}


CONDITIONS: dict[str, Callable[[Truth], dict[str, Any]]] = {
    NOMINAL: lambda truth: {},
    "level_0.7": lambda truth: {"level": 0.7},
    "level_1.3": lambda truth: {"level": 1.3},
    "level_1.6": lambda truth: {"level": 1.6},
    "scatter_10": _scattering,
    "position_wave": lambda truth: {"wave": WAVE, "wavelength": LENGTH * truth.amplitude},
    "creep": lambda truth: {"k_creep": CREEP / truth.amplitude, "tau": TAU},
}
"""Parameters of the layer around a truth, by condition."""
MEANINGS = {
    NOMINAL: "as when the log for the compensator was made",
    "level_0.7": "friction 0.7 times as large",
    "level_1.3": "friction 1.3 times as large",
    "level_1.6": "friction 1.6 times as large",
    "scatter_10": "the level scatters by 10 % from reversal to reversal",
    "position_wave": "the level waves by 20 % over three quarters of the amplitude",
    "creep": "beside it a spring and a damper in series, 10 N over the amplitude, 5 s",
}


def under(condition: str, truth: Truth) -> Model:
    """Return the friction of a truth under a condition."""
    changes = CONDITIONS[condition](truth)
    return truth.friction.with_values(**changes) if changes else truth.friction
