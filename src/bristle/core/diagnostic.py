"""`Diagnostic`: what a computation found out about its data, as numbers; the words for it are those of the report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from bristle.core.variable import Kind

__all__ = ["Diagnostic", "Number", "Severity"]

Severity = Literal["error", "warning", "note"]
Number = float | int | str | tuple[str, ...] | tuple[float, ...]


@dataclass(frozen=True)
class Diagnostic:
    """One thing to know of a result.

    Parameters
    ----------
    code : str
        What it is: in kebab case of a fit or a prediction, in snake case of a check of a log. A code keeps its meaning
        from version to version; `bristle.report.messages` has the sentence of each.
    parameter : str
        The parameter it concerns; empty where it concerns none.
    severity : {"warning", "note", "error"}
        ``error``: there is no result, or none to rely on. ``warning``: the result may mislead. ``note``: what it rests
        on.
    numbers : mapping of str to number, str or tuple of either
        What the sentence needs, in SI.
    kind : {"translational", "rotational"}
        Of the axis; decides the units of the numbers.
    """

    code: str
    parameter: str = ""
    severity: Severity = "warning"
    numbers: Mapping[str, Number] = field(default_factory=dict)
    kind: Kind = "translational"

    def as_data(self) -> dict[str, Any]:
        """Return what goes into JSON: ``code``, ``parameter``, ``severity``, ``numbers``."""
        return {"code": self.code, "parameter": self.parameter, "severity": self.severity, "numbers": dict(self.numbers)}
