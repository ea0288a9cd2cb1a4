"""Write motions, moves and logs as files in the units of the axis."""

import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core import Axis, Column, Readable, factor, unit_of
from bristle.files.single import write_whole
from bristle.logs.readers import read_table
from bristle.logs.table import NONE, split_unit

QUANTITIES = {
    "time": "time",
    "position": "length",
    "velocity": "length/time",
    "acceleration": "length/time^2",
}
RECORDED = {"time": "time", "position": "length", "effort": "force", "reference": "length"}
PER = {"velocity": "/s", "acceleration": "/s^2"}


class Move(NamedTuple):
    """A move to a position at a velocity, in SI units."""

    purpose: str
    dwell: float
    target: float
    velocity: float
    acceleration: float


def motion_columns(axis: Axis) -> dict[str, tuple[str, float]]:
    """Return the headers of the columns of a motion, and the divisor of values in SI units for each."""
    position = axis.columns.get("reference") or axis.columns.get("position")
    heads = {}
    for name, quantity in QUANTITIES.items():
        own = position if name == "position" else axis.columns.get(name)
        if own is None and name in PER and position is not None:
            heads[name] = (
                f"{name} [{position.unit or position.base}{PER[name]}]",
                _head(position, "", "")[1],
            )
        else:
            heads[name] = _head(own, name, unit_of(quantity, axis.kind))
    return heads


def _head(column: Column | None, name: str, unit: str) -> tuple[str, float]:
    """Return the header of a column and the divisor of values in SI units; without a column, a name in SI units."""
    if column is None:
        return f"{name} [{unit}]", 1.0
    unit = column.unit or column.base
    scale = column.scale * (factor(unit, column.base) if unit != column.base else 1.0)
    return f"{split_unit(column.name)[0]} [{unit}]", scale


def write_motion(
    path: str | os.PathLike[str], axis: Axis, signals: Mapping[str, np.ndarray]
) -> None:
    """Write a motion as CSV."""
    write_whole(path, _text(motion_columns(axis), signals))


def log_text(axis: Axis, signals: Mapping[str, np.ndarray]) -> str:
    """Return a log of the drive as CSV that can be read with the same axis."""
    heads = {
        name: _head(axis.columns.get(name), name, unit_of(quantity, axis.kind))
        for name, quantity in RECORDED.items()
    }
    return _text({name: head for name, head in heads.items() if name in signals}, signals)


def _text(columns: Mapping[str, tuple[str, float]], signals: Mapping[str, np.ndarray]) -> str:
    table, out = (
        np.column_stack([signals[name] / scale for name, (_, scale) in columns.items()]),
        io.StringIO(),
    )
    np.savetxt(
        out,
        table,
        fmt="%.12g",
        delimiter=",",
        header=",".join(head for head, _ in columns.values()),
        comments="",
    )
    return out.getvalue()


def axis_of_motion(source: Readable, axis: Axis | None) -> Axis | None:
    """Return the axis for reading a file whose position is the reference motion; None for a log."""
    if axis is None or "effort" not in axis.columns:
        return None
    if read_table(source, axis.table, choice=NONE).has(axis.columns["effort"].name):
        return None
    columns = {
        name: replace(axis.columns[own], optional=False)
        for name, own in (
            ("time", "time"),
            ("position", "reference" if "reference" in axis.columns else "position"),
        )
        if own in axis.columns
    }
    return Axis(
        name=axis.name,
        kind=axis.kind,
        columns=columns,
        table=axis.table,
        sample_time=axis.sample_time,
    )


NC = {"translational": ("X", "mm", "G21 (mm)"), "rotational": ("A", "deg", "(degrees)")}
"""For each kind of axis: its letter in an NC program, the unit of its positions, and the header."""


def moves_table(moves: Sequence[Move], axis: Axis) -> str:
    """Return the moves as CSV, in the units of the axis file."""
    heads, scales = zip(
        *(head for name, head in motion_columns(axis).items() if name != "time"), strict=True
    )
    lines, (position, velocity, acceleration) = [",".join(["purpose", "dwell [s]", *heads])], scales
    lines += [
        f"{move.purpose},{move.dwell:.6g},{move.target / position:.9g},{move.velocity / abs(velocity):.6g},"
        f"{move.acceleration / abs(acceleration):.6g}"
        for move in moves
    ]
    return "\n".join([*lines, ""])


def gcode_of(moves: Sequence[Move], axis: Axis, left_out: Sequence[str]) -> str:
    """Return the moves as an NC program in mm and mm/min, or in degrees and degrees per minute."""
    letter, unit, head = NC[axis.kind]
    si = factor(unit, "m" if unit == "mm" else "rad")
    lines = [
        "(motion for the identification of friction, written by bristle)",
        f"(rename the axis {letter} to yours; dwells G4 P are in seconds: some controls take milliseconds)",
        *(f"(omitted, because it is not a list of moves: {name})" for name in left_out),
        f"G90 G94 {head}",
    ]
    for move in moves:
        lines += [f"G4 P{move.dwell:.3f}"] if move.dwell else []
        lines.append(f"G1 {letter}{move.target / si:.6f} F{60.0 * move.velocity / si:.4f}")
    return "\n".join([*lines, "M30", ""])
