"""What a structure in C keeps over a restart: where each number stands in the bytes, and what none of them ever is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from bristle.exports.c_code import Printer
from bristle.exports.subject import Subject
from bristle.exports.types import REAL, Type
from bristle.exports.walk import digest_of

__all__ = ["capacity_of", "layout_of", "saved_facts"]

MARKS = 8  # bytes of `begun` and `flags`


def layout_of(subject: Subject, scalar: str) -> str:
    """Return what tells the saved bytes of a friction model or an operator from those of another one."""
    return f"{subject.model.name} {scalar} {subject.state.fields} {subject.memory_size}"


def capacity_of(name: str, memory_size: int) -> int:
    """Return how many values a whole number of the state takes, from 0 on: as many turning points as there is room."""
    return memory_size // 2 if name.endswith("depth") and memory_size else 2**31


def saved_facts(
    printer: Printer, heads: Sequence[str], fields: Iterable[tuple[str, Type]], memory_size: int, layout: str
) -> dict[str, Any]:
    """Return what the template of ``save`` and ``load`` is told."""
    wide = printer.scalar == "double"
    marks_at = 8 * (1 + len(heads))
    first = marks_at + MARKS
    lines = []
    for place, (name, kind) in enumerate(fields):
        at, field = f"bytes + {first + 8 * place}", f"axis->state.{name}"
        if kind == REAL:
            save, restore = f"put_real(at, {'' if wide else '(double)'}{field})", f"got_real({at})"
            refused, restore = f"!is_finite(got_real({at}))", restore if wide else f"(float){restore}"
        else:
            save = f"put(at, (uint64_t){field})"
            restore = f"({printer.type_name(kind)})got({at})"
            refused = f"got({at}) >= {capacity_of(name, memory_size)}U"
        lines.append({"put": save, "got": f"{field} = {restore}", "refused": refused})
    memory_at = first + 8 * len(lines)
    return {
        "heads": [{"name": name, "at": 8 * (1 + place)} for place, name in enumerate(heads)],
        "marks_at": marks_at,
        "saved": memory_at + 8 * memory_size + 8,
        "saved_state": lines,
        "memory_at": memory_at,
        "layout": f"0x{digest_of(layout.encode()):016X}",
        "widened": "" if wide else "(double)",
        "narrowed": "" if wide else "(float)",
    }
