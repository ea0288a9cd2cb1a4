"""What the files of an export say of the model: its parameters with units, ranges and intervals, and its source."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.typography import typed
from bristle.core.variable import Kind, Variable
from bristle.exports.names import ascii_name

__all__ = ["Source", "parameter_rows", "parameter_table", "plain", "told"]


@dataclass(frozen=True)
class Source:
    """Where the values of a model come from."""

    provenance: Mapping[str, str] = field(default_factory=dict)
    uncertainty: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    model_hash: str = ""

    @property
    def lines(self) -> list[str]:
        """Remarks and facts of the making, a line each."""
        facts = [f"{key}: {plain(str(value))}" for key, value in self.provenance.items()]
        return [*(plain(remark) for remark in self.remarks), *facts]


def told(variable: Variable, kind: Kind) -> str:
    """Return what a variable means, with its unit, for a comment."""
    unit = variable.unit(kind)
    return plain(variable.description) + (f" [{plain(unit)}]" if unit != "1" else "")


def parameter_rows(model: Model, source: Source) -> Iterator[tuple[str, str, str, str, str, str]]:
    """Give name, value, unit, allowed range, 95 % interval and meaning of each parameter."""
    component = model.component
    for name, variable in component.variables.items():
        value = model.values[name]
        unit = variable.unit(model.kind)
        facts = source.uncertainty.get(name, {})
        interval = facts.get("interval")
        sure = f"{interval[0]:.6g} to {interval[1]:.6g}" if interval else facts.get("status", "")
        yield (ascii_name(name), _value(value), "" if unit == "1" else unit, _range(variable), plain(sure), plain(variable.description))


def parameter_table(model: Model, source: Source) -> str:
    """Return the parameters as a table of plain text, for a comment."""
    rows = [("", "value", "unit", "allowed", "95 % interval", ""), *parameter_rows(model, source)]
    if not any(row[4] for row in rows[1:]):
        rows = [(*row[:4], *row[5:]) for row in rows]  # type: ignore[misc]
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]) - 1)]
    lines = ["   " + "  ".join(f"{cell:<{width}}" for cell, width in zip(row, [*widths, 0], strict=True)).rstrip() for row in rows]
    return "\n".join(lines)


def plain(text: str) -> str:
    """Return text in ASCII that ends no comment."""
    for mark, instead in (("µ", "u"), ("·", "*"), ("–", "-"), ("−", "-"), ("²", "^2"), ("*/", "* /"), ("/*", "/ *")):
        text = text.replace(mark, instead)
    return " ".join(text.encode("ascii", "replace").decode().split())


def _value(value: Any) -> str:
    if isinstance(value, np.ndarray):
        numbers = ", ".join(f"{number:.9g}" for number in value[:8])
        return f"{numbers}, ... ({value.size} in all)" if value.size > 8 else numbers
    return value if isinstance(value, str) else typed(value) if not isinstance(value, float) else f"{value:.9g}"


def _range(variable: Any) -> str:
    low, high = variable.min, variable.max
    if variable.choices:
        return "fixed"
    if math.isinf(low) and math.isinf(high):
        return ""
    if math.isinf(high):
        return f">= {low:g}"
    return f"<= {high:g}" if math.isinf(low) else f"{low:g} to {high:g}"
