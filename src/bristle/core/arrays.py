"""Arrays that a person hands in: lists, columns of other libraries, what is no number among them."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.core.values import Converter, shown
from bristle.core.variable import Kind

__all__ = ["CURVE", "array", "is_finite", "vector"]


def array(*, ndim: int = 1, least: int = 0, single: bool = False, finite: bool = True) -> Converter:
    """Return what takes an array of numbers, of so many dimensions."""

    def convert(value: Any, path: str, kind: Kind | None) -> np.ndarray:
        numbers = vector(value, path)
        if not (numbers.ndim == ndim or (single and numbers.ndim < ndim)):
            raise InputError(f"must be a {ndim}-D array of numbers", path=path, value=shown(numbers))
        if numbers.ndim and numbers.shape[-1] < least:
            raise InputError("is too short", path=path, value=shown(numbers), allowed=f"at least {least} numbers")
        if finite and not is_finite(numbers):
            place = int(np.flatnonzero(~np.isfinite(numbers))[0])
            raise InputError(
                "is not finite throughout", path=path, value=f"{numbers.flat[place]} at {place}", mend="Remove NaN and infinity first"
            )
        return numbers

    return convert


def is_finite(numbers: np.ndarray) -> bool:
    """Return whether all numbers are finite."""
    # A sum is finite only if every term is, and costs a fraction of a test of each; one that overflows decides nothing.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.sum(numbers)
    return bool(np.isfinite(total)) or bool(np.all(np.isfinite(numbers)))


def vector(values: Any, name: str = "signal") -> np.ndarray:
    """Return values as compiled entries take them: contiguous, writable, of floating point."""
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=name, mend="Fill them, or leave those samples out")
    try:
        numeric = np.asarray(values).dtype.kind in "fiub"
    except ValueError:  # rows of different lengths
        numeric = False
    if not numeric:
        raise InputError("must hold real numbers in SI", path=name, value=shown(values))
    return np.require(values, dtype=float, requirements=("C", "W"))


def _curve(value: Any, path: str, kind: Kind | None) -> tuple[np.ndarray, np.ndarray]:
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise InputError("must be the input and the output of a curve", path=path, value=shown(value))
    u, f = (array(least=1)(sequence, path, kind) for sequence in value)
    if u.shape != f.shape:
        raise InputError(f"has {u.size} inputs and {f.size} outputs", path=path)
    return u, f


CURVE: Converter = _curve
