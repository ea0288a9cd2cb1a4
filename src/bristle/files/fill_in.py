"""What stands in a proposed file where a person has to say what a log cannot tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bristle.core.errors import InputError

__all__ = ["FILL_IN", "refuse_open"]

FILL_IN = "?"


def _open_in(tables: Any, path: str) -> Iterator[str]:
    if isinstance(tables, Mapping):
        for key, value in tables.items():
            yield from _open_in(value, f"{path}.{key}" if path else str(key))
    elif tables == FILL_IN:
        yield path


def refuse_open(tables: Mapping[str, Any]) -> None:
    """Refuse a file in which something is still to be filled in."""
    keys = list(_open_in(tables, ""))
    if not keys:
        return
    more = f" So are {', '.join(keys[1:])}" if len(keys) > 1 else ""
    raise InputError("is still to be filled in", path=keys[0], value=FILL_IN, mend=f"The comment behind it says what to write.{more}")
