"""The kind of an axis whose file does not name it: that of its units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.core import units
from bristle.core.dimensions import KINDS, Kind

__all__ = ["OF_UNIT", "with_kind"]

OF_UNIT: dict[str, Kind] = {"m": KINDS[0], "rad": KINDS[1]}
"""Unit of a movement -> the kind of axis that it speaks of."""


def with_kind(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of an axis file with the kind of axis that its units speak of, where it names none."""
    if "kind" in data:
        return dict(data)
    kind = (
        _of_movement(_entry_at(data, "columns", "position", "unit"))
        or _of_movement(_unit_of(_entry_at(data, "encoder", "resolution")))
        or _of_movement(_entry_at(data, "columns", "velocity", "unit"), per="/s")
    )
    if kind is None and _entry_at(data, "encoder", "counts_per_rev") is not None:
        kind = KINDS[0] if _entry_at(data, "transmission", "lead") is not None else KINDS[1]
    return dict(data) if kind is None else {**data, "kind": kind}


def _entry_at(data: Any, *path: str) -> Any:
    for key in path:
        data = data.get(key) if isinstance(data, Mapping) else None
    return data


def _unit_of(quantity: Any) -> str | None:
    try:
        return units.split(quantity.removesuffix("/count"))[1] if isinstance(quantity, str) else None
    except ValueError:
        return None


def _of_movement(unit: Any, per: str = "") -> Kind | None:
    if not isinstance(unit, str) or not units.is_unit(unit):
        return None
    for base, kind in OF_UNIT.items():
        if units.compatible(unit, base + per):
            return kind
    return None
