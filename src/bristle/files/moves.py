"""A list of moves as files: a table for a motion controller, and a program for an NC."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bristle.core.axis import Axis
from bristle.core.units import factor
from bristle.files.motion import motion_columns

if TYPE_CHECKING:
    from bristle.excitation.motion import Move

__all__ = ["gcode_of", "moves_table"]

NC = {"translational": ("X", "mm", "G21 (mm)"), "rotational": ("A", "deg", "(degrees)")}
"""By kind of axis the letter of the axis in an NC program, the unit of its positions, and what its head says."""


def moves_table(moves: Sequence[Move], axis: Axis) -> str:
    """Return the moves as comma-separated values, in the units of the axis file."""
    heads = {name: head for name, head in motion_columns(axis).items() if name != "time"}
    lines = [",".join(["purpose", "dwell [s]", *(head for head, _ in heads.values())])]
    position, velocity, acceleration = (scale for _, scale in heads.values())
    lines += [
        f"{move.purpose},{move.dwell:.6g},{move.target / position:.9g},{move.velocity / abs(velocity):.6g},"
        f"{move.acceleration / abs(acceleration):.6g}"
        for move in moves
    ]
    return "\n".join([*lines, ""])


def gcode_of(moves: Sequence[Move], axis: Axis, left_out: Sequence[str]) -> str:
    """Return the moves as a program for an NC: millimetres and mm/min, or degrees and degrees a minute."""
    letter, unit, head = NC[axis.kind]
    si = factor(unit, "m" if unit == "mm" else "rad")
    lines = [
        "(motion for the identification of friction, written by bristle)",
        f"(rename the axis {letter} to yours; dwells G4 P are in seconds: some controls take milliseconds)",
        *(f"(left out, as it is no list of moves: {name})" for name in left_out),
        f"G90 G94 {head}",
    ]
    for move in moves:
        lines += [f"G4 P{move.dwell:.3f}"] if move.dwell else []
        lines.append(f"G1 {letter}{move.target / si:.6f} F{60.0 * move.velocity / si:.4f}")
    return "\n".join([*lines, "M30", ""])
