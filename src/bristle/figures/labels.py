"""What stands at the axes of a figure: words and units of the kind of axis, in a fitting multiple."""

from __future__ import annotations

import numpy as np

from bristle.core.typography import Scale, scale_of
from bristle.core.variable import Kind, unit_of


def effort_word(kind: Kind) -> str:
    """Return what effort is called on this kind of axis."""
    return {"rotational": "Torque", "magnetic": "Moment", "piezo": "Displacement"}.get(kind, "Force")


def position_word(kind: Kind) -> str:
    """Return what position is called on this kind of axis."""
    return {"rotational": "Angle", "magnetic": "Field", "piezo": "Voltage"}.get(kind, "Position")


def largest(*signals: np.ndarray) -> float:
    """Return the largest absolute value among signals, what is not finite left out; 0 for none."""
    tops = [np.max(np.abs(signal[np.isfinite(signal)]), initial=0.0) for signal in map(np.asarray, signals)]
    return float(max(tops, default=0.0))


def scale_for(quantity: str, kind: Kind, *signals: np.ndarray) -> Scale:
    """Return the multiple of the unit of a generalised quantity in which all these signals are read best."""
    return scale_of(unit_of(quantity, kind), largest(*signals))


def effort_scale(kind: Kind, *signals: np.ndarray) -> tuple[Scale, str]:
    """Return the multiple of the unit for these efforts, and what they are called."""
    return scale_for("force", kind, *signals), effort_word(kind)


def time_scale(time: np.ndarray) -> Scale:
    """Return the unit of a time axis: milliseconds for less than half a second, counted from zero."""
    return scale_of("s", 1.0 if largest(time) >= 0.5 else largest(time))
