"""Distributions of one quantity: what a number between 0 and 1 stands for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.errors import InputError, did_you_mean
from bristle.files.components import number_at
from bristle.study.target import Target

__all__ = ["DISTRIBUTIONS", "Distribution", "distribution_from"]

DISTRIBUTIONS = ("normal", "uniform", "log_uniform", "choice")
EXAMPLES = {
    "normal": 'normal = ["34 mN*m", "2 mN*m"], mean and standard deviation',
    "uniform": 'uniform = ["0.8e-4 kg*m^2", "1.2e-4 kg*m^2"], lowest and highest',
    "log_uniform": 'log_uniform = ["1e4 N/m", "1e6 N/m"], lowest and highest',
    "choice": 'choice = ["1 mm", "5 mm"], values that are drawn equally often',
}


@dataclass(frozen=True)
class Distribution:
    """How a quantity is drawn."""

    name: str
    numbers: tuple[Any, ...]

    def values(self, unit_numbers: np.ndarray) -> np.ndarray:
        """Return what numbers between 0 and 1 stand for, by the inverse of the distribution function."""
        if self.name == "choice":
            places = np.minimum((unit_numbers * len(self.numbers)).astype(int), len(self.numbers) - 1)
            return np.array(self.numbers)[places]
        first, second = self.numbers
        if self.name == "normal":
            from scipy.special import ndtri

            return first + second * ndtri(unit_numbers)
        if self.name == "uniform":
            return first + (second - first) * unit_numbers
        return np.exp(math.log(first) + (math.log(second) - math.log(first)) * unit_numbers)


def distribution_from(table: Mapping[str, Any], target: Target, path: str) -> Distribution:
    """Return the distribution that a table of ``[vary]`` describes."""
    name = _name_in(table, path)
    values, place = table[name], f"{path}.{name}"
    count = "at least one value" if name == "choice" else "two values"
    if not isinstance(values, list) or not values or (name != "choice" and len(values) != 2):
        raise InputError("does not fit", path=place, value=values, allowed=count, mend=f"Write {EXAMPLES[name]}")
    if name == "choice":
        return Distribution(name, target.numbers(values, place))
    if target.is_discrete:
        raise InputError(
            f"is for quantities that vary without steps, and {target.path} is a whole number or a name",
            path=place,
            value=values,
            mend="Write choice = [...] instead",
        )
    first = target.number(values[0], f"{place}[0]")
    if name == "normal":
        width = number_at(values[1], target.spread, target.kind, f"{place}[1]")
        if not width > 0.0:
            raise InputError(
                "must be positive", path=f"{place}[1]", value=values[1], allowed="> 0", mend="The second value is the standard deviation"
            )
        return Distribution(name, (first, width))
    second = target.number(values[1], f"{place}[1]")
    if not first < second:
        raise InputError(
            "must be above the lowest value", path=f"{place}[1]", value=values[1], allowed=f"> {first:g}", mend=f"Write {EXAMPLES[name]}"
        )
    if name == "log_uniform" and not first > 0.0:
        raise InputError("must be positive: it has a logarithm", path=f"{place}[0]", value=values[0], allowed="> 0")
    return Distribution(name, (first, second))


def _name_in(table: Mapping[str, Any], path: str) -> str:
    allowed = f"{', '.join(DISTRIBUTIONS)}, or from and draws"
    for key in table:
        if key not in DISTRIBUTIONS:
            raise InputError(
                "is no distribution", path=f"{path}.{key}", value=table[key], allowed=allowed, mend=did_you_mean(key, DISTRIBUTIONS)
            )
    if len(table) != 1:
        fault = "has two distributions" if table else "has no distribution"
        raise InputError(fault, path=path, allowed=allowed, mend=f"Write {EXAMPLES['normal']}")
    return next(iter(table))
