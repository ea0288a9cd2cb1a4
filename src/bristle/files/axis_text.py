"""An axis as the text of an axis file, so that results carry the axis that they were made with."""

from __future__ import annotations

import math
from typing import Any

from bristle.core import units
from bristle.core.axis import CHANNELS, Axis, Column, Injected
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.variable import Kind, unit_of
from bristle.files.components import key_of

__all__ = ["axis_text"]

HEAD = "# The axis that these results were made with, in SI.\n"


def axis_text(axis: Axis) -> bytes | None:
    """Return an axis file that says what an axis says.

    Parameters
    ----------
    axis : Axis
        The axis. One that was read from a file is told by that file, as long as nothing of it was changed since.

    Returns
    -------
    bytes or None
        TOML in UTF-8; None where an axis file cannot say it, as of columns with a scale that is no unit.
    """
    from bristle.files.axis import read_axis

    if axis.text and read_axis(axis.text) == axis:
        return axis.text
    try:
        text = _written(axis)
        return text if _alike(read_axis(text), axis) else None
    except InputError:
        return None


def _alike(read: Axis, axis: Axis) -> bool:
    """Return whether a file says what an axis says; of a column its scale, in whatever unit."""

    def scales(one: Axis) -> dict[str, tuple[Any, ...]]:
        return {name: (its.name, its.scale, its.shift, its.optional) for name, its in one.columns.items()}

    plain = {name: getattr(axis, name) for name in vars(axis) if name not in ("columns", "text", "pitch")}
    return scales(read) == scales(axis) and all(getattr(read, name) == one for name, one in plain.items())


def _written(axis: Axis) -> bytes:
    import tomlkit

    tables = {
        "columns": {name: _column(name, one, axis.kind) for name, one in axis.columns.items()},
        "log": {"table": axis.table, "span": list(axis.span) if axis.span else None, "start": _start(axis)},
        "effort": {"limit": axis.effort_limit, "held": axis.held, "hold": axis.hold, "periodic": axis.periodic,
                   "lag": "identify" if axis.seeks_lag else axis.lag or None},
        "plant": {"model": axis.plant, "mass" if axis.kind == "translational" else "inertia": axis.mass,
                  "stiffness": axis.stiffness, "damping": axis.damping, "offset": axis.offset,
                  "presliding": axis.presliding},
        "encoder": {"resolution": axis.resolution},
        "timing": {"sample_time": axis.sample_time, "delay": "identify" if axis.seeks_delay else axis.delay or None},
        "limits": {"velocity": axis.velocity_limit, "acceleration": axis.acceleration_limit, "jerk": axis.jerk_limit,
                   "stroke": list(axis.stroke) if axis.stroke else None},
        "identification": {"cutoff": axis.cutoff, "decimation": axis.decimation,
                           "rests": "keep" if axis.keeps_rests else None, "method": axis.method, "loop": axis.loop,
                           "global_search": axis.global_search or None, "settings": dict(axis.settings) or None},
        "controller": _controller(axis.controller),
    }  # fmt: skip
    document = {"schema": 1, "name": axis.name, "kind": axis.kind, "injected": [_known(one) for one in axis.injected]}
    document |= {name: {key: one for key, one in its.items() if one is not None} for name, its in tables.items()}
    said = {name: one for name, one in document.items() if one != {} and one != []}
    return (HEAD + tomlkit.dumps(said)).encode("utf-8", "backslashreplace")


def _column(name: str, one: Column, kind: Kind) -> dict[str, Any]:
    """Return the entry of a column: its unit, where that is all there is to its scale; none where the log says it."""
    base = unit_of(CHANNELS[name], kind)
    fits = one.unit and math.isclose(units.factor(one.unit, base), abs(one.scale), rel_tol=1e-15)
    entry: dict[str, Any] = {"column": one.name} | ({"unit": one.unit if fits else base} if one.unit else {})
    return entry | ({"sign": -1} if one.scale < 0.0 else {}) | ({"optional": True} if one.optional else {})


def _known(one: Injected) -> dict[str, Any]:
    return {"column": one.column, "gain": one.gain} | ({"optional": True} if one.optional else {})


def _start(axis: Axis) -> str:
    return "rest" if axis.at_rest else "cycle" if axis.in_cycle else "moving"


def _controller(controller: Model | None) -> dict[str, Any]:
    """Return the table of a control law; what has no end is left to its default."""
    if controller is None:
        return {}
    values = {
        key_of(name): value.tolist() if hasattr(value, "tolist") else value
        for name, value in controller.values.items()
        if not (isinstance(value, float) and math.isinf(value))
    }
    return {"model": controller.name} | values
