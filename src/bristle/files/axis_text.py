"""An axis as the text of an axis file, so that results carry the axis that they were made with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from bristle.core.axis import Axis, Column, Injected, KnownColumn
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.variable import unit_of
from bristle.files.components import key_of

HEAD = "# The axis that these results were made with, in SI.\n"


def axis_text(axis: Axis) -> bytes | None:
    """Return an axis file that says what an axis says."""
    from bristle.files.axis import read_axis

    if axis.text and read_axis(axis.text) == axis:
        return axis.text
    try:
        text = _written(axis)
        return text if read_axis(text) == axis else None
    except InputError:
        return None


def _written(axis: Axis) -> bytes:
    import tomlkit

    tables = {
        "columns": {name: _column(column) for name, column in axis.columns.items()},
        "log": {"table": axis.table, "span": list(axis.span) if axis.span else None, "start": _start(axis)},
        "effort": {
            "limit": axis.effort_limit,
            "held": axis.held,
            "hold": axis.hold,
            "periodic": axis.periodic,
            "lag": "identify" if axis.seeks_lag else axis.lag or None,
        }
        | _constant(axis),
        "plant": {
            "model": axis.plant,
            "mass" if axis.kind == "translational" else "inertia": axis.mass,
            "stiffness": axis.stiffness,
            "damping": axis.damping,
            "offset": axis.offset,
            "presliding": axis.presliding,
            "gravity": "link" if axis.gravity else None,
        },
        "transmission": {"lead": axis.pitch},
        "encoder": {"resolution": axis.resolution},
        "timing": {"sample_time": axis.sample_time, "delay": None if axis.seeks_delay else axis.delay},
        "limits": {
            "velocity": axis.velocity_limit,
            "acceleration": axis.acceleration_limit,
            "jerk": axis.jerk_limit,
            "stroke": list(axis.stroke) if axis.stroke else None,
        },
        "identification": {
            "cutoff": axis.cutoff,
            "decimation": axis.decimation,
            "rests": "keep" if axis.keeps_rests else None,
            "method": axis.method,
            "loop": axis.loop,
            "global_search": axis.global_search or None,
            "settings": dict(axis.settings) or None,
        },
        "controller": _controller(axis.controller),
    }
    document = {
        "schema": 1,
        "name": axis.name,
        "kind": axis.kind,
        "injected": [_injected(known_input) for known_input in axis.injected],
        "known": [_known_column(column) for column in axis.regressors],
        "cogging": [
            {"turn": one.turner, "harmonics": "identify" if one.harmonics is None else list(one.harmonics)} for one in axis.cogging
        ],
    }
    document |= {name: {key: value for key, value in table.items() if value is not None} for name, table in tables.items()}
    filled = {name: value for name, value in document.items() if value not in ({}, [])}
    return (HEAD + tomlkit.dumps(filled)).encode("utf-8", "backslashreplace")


def _column(column: Column) -> dict[str, Any]:
    """Return the entry of a column; what its numbers are multiplied by beyond their unit stands elsewhere."""
    entry: dict[str, Any] = {"column": column.name} | ({"unit": column.unit} if column.unit else {})
    return entry | ({"sign": -1} if column.scale < 0.0 else {}) | ({"optional": True} if column.optional else {})


def _constant(axis: Axis) -> dict[str, Any]:
    """Return what turns the unit of the effort column into a force or a torque, where it is neither."""
    effort, unit = axis.columns.get("effort"), unit_of("force", axis.kind)
    if effort is None or effort.base == unit:
        return {}
    key = "force_constant" if axis.kind == "translational" else "torque_constant"
    return {key: f"{abs(effort.scale)!r} {unit}/{effort.base}"}


def _injected(known_input: Injected) -> dict[str, Any]:
    entry: dict[str, Any] = {"column": known_input.column, "gain": known_input.gain}
    return entry | ({"optional": True} if known_input.optional else {})


def _known_column(known_column: KnownColumn) -> dict[str, Any]:
    entry: dict[str, Any] = {"column": known_column.column, "name": known_column.name}
    return entry | ({"optional": True} if known_column.optional else {})


def _start(axis: Axis) -> str:
    return "rest" if axis.at_rest else "cycle" if axis.in_cycle else "moving"


def _controller(controller: Model | None) -> dict[str, Any]:
    """Return the table of a control law; what has no end is left to its default."""
    if controller is None:
        return {}
    values: dict[str, Any] = {
        key_of(name): np.asarray(value).tolist()
        for name, value in controller.values.items()
        if not (isinstance(value, float) and math.isinf(value))
    }
    return {"model": controller.name} | values
