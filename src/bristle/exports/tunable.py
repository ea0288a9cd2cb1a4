"""Options of an export: parameters that change at run time, and single precision."""

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core import InputError, Model, mathematics
from bristle.core.variable import Kind, Variable
from bristle.models.friction import deflection, slip_law
from bristle.models.friction.maxwell_stribeck import BEYOND
from bristle.models.hysteresis import everett

TOLERANCE = (
    1e-3  # Allowed deviation from double precision in the self-test, divided by the largest output
)
CHECKPOINT = 25  # Steps between two comparisons with double precision

_OF_MATHEMATICS = (
    {
        "EXP_MAX": 88.0,
        "EXP_OF_MAX": 1.6516362549940018e38,
        "EXP_MIN": -87.0,
        "ROUNDER": 12582912.0,
        "TANH_MAX": 10.0,
    }
    # ln 2 and half pi in parts of a few bits, and the remainder.
    | {"LN2_HIGH": 0.693359375, "LN2_LOW": -2.1219444005469057e-04}
    | {
        "HALF_PI_1": 1.5703125,
        "HALF_PI_2": 4.837512969970703e-04,
        "HALF_PI_3": 7.54978941586159635e-08,
        "HALF_PI_4": 5.390302529957764e-15,
    }
    | {
        "NORMAL_MIN": 1.1754943508222875e-38,
        "LOG_OF_MIN": -87.33654475055310,
        "LARGEST": 3.4028234663852886e38,
    }
    | {"ANGLE_MAX": 5e3, "ANGLE_WITHOUT_DIGITS": 1e6}
)
CONSTANTS: dict[tuple[str, float], float] = (
    {(name, getattr(mathematics, name)): value for name, value in _OF_MATHEMATICS.items()}
    | {
        ("RELATIVE", deflection.RELATIVE): 1e-5,
        ("OF_SLIDING", deflection.OF_SLIDING): 1e-5,
        ("TOLERANCE", deflection.TOLERANCE): 1e-7,
    }
    | {("SHORTEST", deflection.SHORTEST): 1e-30, ("TOLERANCE", slip_law.TOLERANCE): 1e-4}
    | {("BEYOND", BEYOND): 1e18, ("FAR", everett.FAR): 1e18}
)
"""By the name of a constant and its value in double precision."""


def single_note(output: str) -> str:
    """Return the note for an export in single precision."""
    return f"single precision changes the results by rounding; the self-test allows {TOLERANCE:g} of the largest {output}"


def refuse_beyond_single(values: Mapping[str, Any], path: str = "") -> None:
    """Refuse parameters, also in nested tuples, that are finite but too large for single precision."""
    largest = float(np.finfo(np.float32).max)
    for name, value in values.items():
        if hasattr(value, "_fields"):
            refuse_beyond_single(value._asdict(), f"{path}{name}.")
            continue
        if not isinstance(value, str):
            numbers = np.abs(np.atleast_1d(value)).astype(float)
        else:
            numbers = np.zeros(1)
        if np.any(np.isfinite(numbers) & (numbers > largest)):
            raise InputError(
                "is too large for single precision",
                path=f"{path}{name}",
                value=float(np.max(numbers)),
                allowed=f"<= {largest:.3g}",
                mend="Omit float32",
            )


def checkpoints(outputs: np.ndarray, *, single: bool) -> dict[str, Any]:
    """Return the reference outputs of a self-test in single precision; empty for double precision."""
    near = {
        "checkpoints": [repr(output) for output in outputs[::CHECKPOINT].tolist()],
        "largest": repr(float(np.max(np.abs(outputs)))),
    }
    tolerance = ""
    if single:
        tolerance = repr(TOLERANCE)
    return near | {"every": CHECKPOINT, "tolerance": tolerance}


MARK = 1024.0  # first of the numbers that mark parameters, to find them in the parameters of the kernels


@dataclass(frozen=True)
class Tunable:
    """The variable parameters with their values, and the place of each."""

    kind: Kind
    variables: Mapping[str, Variable]
    values: dict[str, Any]
    places: dict[tuple[str, ...], str]

    def numbers(self) -> Iterator[tuple[str, int | None, float]]:
        """Yield the name, the index within an array, and the value of each number."""
        for name, value in self.values.items():
            if isinstance(value, np.ndarray):
                yield from ((name, place, number) for place, number in enumerate(value.tolist()))
            else:
                yield name, None, value


def bounds_of(tuned: Tunable) -> Iterator[tuple[str, int | None, list[tuple[str, float]]]]:
    """Yield the name, the index and the bounds of each variable number; an unbounded number has the largest of its type."""
    for name, place, _ in tuned.numbers():
        variable = tuned.variables[name]
        low = float(variable.min)
        high = float(variable.max)
        compared = [(">=", low)] * math.isfinite(low) + [("<=", high)] * math.isfinite(high)
        yield name, place, compared or [(">=", -math.inf), ("<=", math.inf)]


def tunable_of(
    model: Model, fixed_names: Container[str] = (), *, mend: str = "Omit --tunable"
) -> Tunable:
    """Return the variable parameters of a model: its real numbers, except those named in `fixed_names`; `mend` ends a refusal."""
    component = model.component
    values = {
        name: value if isinstance(value, np.ndarray) else float(value)
        for name, value in model.values.items()
        if not component.is_integer(name)
        and not component.variables[name].choices
        and name not in fixed_names
    }
    # Numbers mark the parameters, to find them in the parameters of the kernels.
    marked: dict[str, Any] = {}
    count = MARK
    for name, value in values.items():
        marked[name] = count
        if isinstance(value, np.ndarray):
            marked[name] = count + np.arange(value.size, dtype=float)
        count += np.size(value)
    names = {np.asarray(mark).tobytes(): name for name, mark in marked.items()}
    leaves = dict(_leaves(component.assemble(dict(model.values) | marked), ()))
    keys = {path: np.asarray(value).tobytes() for path, value in leaves.items()}
    places = {path: names[key] for path, key in keys.items() if key in names}
    lost = sorted(set(values) - set(places.values()))
    usual = _leaves(component.assemble(dict(model.values)), ())
    lost += [
        ".".join(path)
        for path, value in usual
        if path not in places and keys[path] != np.asarray(value).tobytes()
    ]
    if lost:
        raise InputError(
            "converts these parameters at the start, so they cannot change at run time",
            path=model.name,
            value=", ".join(lost),
            mend=mend,
        )
    return Tunable(model.kind, component.variables, values, places)


def _leaves(value: Any, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    leaves: list[tuple[tuple[str, ...], Any]] = []
    for name, part in zip(value._fields, value, strict=True):
        if hasattr(part, "_fields"):
            leaves += _leaves(part, (*path, name))
        else:
            leaves.append(((*path, name), part))
    return leaves
