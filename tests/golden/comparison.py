"""Compare present numbers with frozen numbers."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

RELATIVE = 1e-9
"""Share by which numbers may differ where they were frozen."""
ELSEWHERE = 2e-3
"""The same on other processors and libraries. Another order of additions moves values by 1e-5 of themselves, standard
errors by 1e-4, the rest of a residual by 1e-3 (kernels of OpenBLAS for Haswell and Nehalem). Texts may differ in their
digits. A status, a verdict, an order and the number of anything may not differ."""
DRAWN_ELSEWHERE = 5e-2
"""The same of draws, what is computed from them, and loops in which a count of the encoder falls to another side."""
DRAWN = (
    "interval",
    "resampling",
    "draws",
    "scatter",
    "unexplained",
    "prediction",
    "force_error",
    "robust_std",
)
DIGITS = re.compile(r"[-\u2212]?\d[\d.,]*(e[-+]?\d+)?")
MISSING = "nothing"
LINE = 400  # characters
SURE = ("std", "robust_std", "interval")


class Difference(NamedTuple):
    """One place that is not what it was."""

    path: str
    was: Any
    now: Any

    def __str__(self) -> str:
        return f"{self.path}: was {_short(self.was)}, is {_short(self.now)}"


def _short(value: Any) -> str:
    text = value if value is MISSING else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 160 else f"{text[:120]} ... ({len(text)} characters)"


def differences(was: Any, now: Any, relative: float = RELATIVE) -> Iterator[Difference]:
    """Yield where plain data is not what it was; what was added to a table is no difference.

    Numbers may differ by a share of themselves, or of their scale: the largest number of their list, the width of the
    interval of an estimate, 1 of correlations.
    """
    yield from _compared("", was, now, relative, 0.0)


def _compared(path: str, was: Any, now: Any, relative: float, scale: float) -> Iterator[Difference]:
    if relative == ELSEWHERE and any(word in path for word in DRAWN):
        relative = DRAWN_ELSEWHERE
    if isinstance(was, dict) and isinstance(now, dict):
        yield from _tables(path, was, now, relative)
    elif isinstance(was, list) and isinstance(now, list):
        if len(was) != len(now):
            yield Difference(f"{path}.length", len(was), len(now))
        largest = max([scale, *(_magnitude(wa) for wa in was)])
        for place, (wa, other) in enumerate(zip(was, now, strict=False)):
            yield from _compared(f"{path}[{place}]", wa, other, relative, largest)
    elif _is_number(was) and _is_number(now):
        if not math.isclose(was, now, rel_tol=relative, abs_tol=relative * scale):
            yield Difference(path, was, now)
    elif type(was) is not type(now) or _text(was, relative) != _text(now, relative):
        yield Difference(path, was, now)


def _text(value: Any, relative: float) -> Any:
    """Return a value as it is compared: a text without its digits, where numbers may differ in those that are seen."""
    return DIGITS.sub("#", value) if isinstance(value, str) and relative > RELATIVE else value


def _tables(
    path: str, was: dict[str, Any], now: dict[str, Any], relative: float
) -> Iterator[Difference]:
    scale = _scale_of(was)
    for name, item in was.items():
        below = f"{path}.{name}" if path else name
        if name not in now:
            yield Difference(below, item, MISSING)
        else:
            yield from _compared(below, item, now[name], relative, scale.get(name, 0.0))


def _scale_of(table: dict[str, Any]) -> dict[str, float]:
    """Return the scale of those numbers of a table that may happen to be next to nothing."""
    if "value" in table:  # an estimate
        ends = [number for name in SURE for number in _numbers(table.get(name))]
        return dict.fromkeys(
            ("value", "interval"), max((abs(number) for number in ends), default=0.0)
        )
    if "rms" in table and "samples" in table:  # a signal
        return dict.fromkeys(("mean", "samples"), _magnitude(table["rms"]))
    if "aic" in table:  # above those of the best model: differences of numbers as large as the rows
        return dict.fromkeys(("aic", "bic"), 1e3)
    if "below_the_diagonal" in table:
        return {"below_the_diagonal": 1.0}
    if "deviation_of_levels" in table:
        # Levels for a drive; the viscous ones are what 1 m/s adds to what is there at rest.
        names = (
            "deviation",
            "deviation_of_levels",
            "constant",
            "viscous_forward",
            "viscous_backward",
        )
        return dict.fromkeys(names, max(map(_magnitude, table.values())))
    if "largest_deviation" in table:
        return {"largest_deviation": max(map(_magnitude, table["effort"]), default=0.0)}
    return {}


def _numbers(value: Any) -> list[float]:
    return [item for item in (value if isinstance(value, list) else [value]) if _is_number(item)]


def _magnitude(value: Any) -> float:
    return abs(value) if _is_number(value) else 0.0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def frozen_text(found: Any) -> str:
    """Return plain data as JSON for reading and for diffs: what is short, or numbers only, stands on one line."""
    return _written(found, "") + "\n"


def _written(value: Any, margin: str) -> str:
    line = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    below = (
        list(value.values())
        if isinstance(value, dict)
        else value
        if isinstance(value, list)
        else []
    )
    numbers = all(item is None or _is_number(item) for item in below)
    if numbers or (len(line) <= LINE and not any(isinstance(item, dict) for item in below)):
        return line
    deeper = margin + " "
    if isinstance(value, dict):
        entries = [
            f"{deeper}{json.dumps(name)}: {_written(item, deeper)}" for name, item in value.items()
        ]
        return "{\n" + ",\n".join(entries) + f"\n{margin}}}"
    return (
        "[\n" + ",\n".join(f"{deeper}{_written(item, deeper)}" for item in value) + f"\n{margin}]"
    )
