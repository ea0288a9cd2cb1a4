"""Thresholds that a person may set: each with its default, unit, meaning and range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, Self

from bristle.core.errors import InputError


class Threshold(NamedTuple):
    """What a setting is: its default, unit, meaning, what it may be, and where it comes from."""

    name: str
    default: float
    unit: str
    meaning: str
    least: float
    most: float
    source: str


def threshold(default: float, meaning: str, unit: str = "1", least: float = 0.0, most: float = math.inf, source: str = "") -> Any:
    """Return the field of a threshold."""
    about = {"default": default, "meaning": meaning, "unit": unit, "least": least, "most": most, "source": source}
    return field(default=default, metadata=about)


@dataclass(frozen=True)
class Thresholds:
    """Thresholds, each a field that `threshold` made."""

    @classmethod
    def of(cls, values: Mapping[str, Any], path: str = "settings") -> Self:
        """Return the thresholds that are given, all others at their defaults."""
        by_name = {entry.name: entry for entry in thresholds_of(cls)}
        numbers: dict[str, float] = {}
        for name, value in values.items():
            if name not in by_name:
                if isinstance(getattr(cls, name, None), float):
                    raise InputError("is fixed, and no longer set", path=f"{path}.{name}", value=value, mend="Leave it out")
                raise InputError("is no threshold of an identification", path=f"{path}.{name}", value=value, allowed=", ".join(by_name))
            numbers[name] = _checked(by_name[name], value, f"{path}.{name}")
        return cls(**numbers)

    @classmethod
    def among(cls, values: Mapping[str, Any], path: str = "settings") -> Self:
        """Return those of the thresholds that are given which are of this class, all others at their defaults."""
        names = {entry.name for entry in thresholds_of(cls)}
        return cls.of({name: value for name, value in values.items() if name in names}, path)

    @property
    def changed(self) -> dict[str, float]:
        """Those that differ from the default, by name."""
        return {entry.name: value for entry in thresholds_of(type(self)) if (value := getattr(self, entry.name)) != entry.default}

    def as_data(self) -> dict[str, float]:
        """Return all of them, by name."""
        return {entry.name: getattr(self, entry.name) for entry in thresholds_of(type(self))}


def _checked(entry: Threshold, value: Any, path: str) -> float:
    number = value if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
    if not (entry.least <= number <= entry.most and math.isfinite(number)):
        allowed = f"{entry.least:g} to {entry.most:g}" if math.isfinite(entry.most) else f">= {entry.least:g}"
        raise InputError("is out of range", path=path, value=value, allowed=allowed)
    return float(number)


def thresholds_of(settings: type[Thresholds]) -> tuple[Threshold, ...]:
    """Return what each of the thresholds of a class is, in order."""
    return tuple(Threshold(entry.name, **entry.metadata) for entry in fields(settings))
