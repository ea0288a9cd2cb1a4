"""Options of an export: parameters that change at run time, and single precision."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import mathematics
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import FEEDFORWARD
from bristle.core.variable import Kind, Variable, variables_of
from bristle.engine.screwed import of_travel
from bristle.exports.settled import fact_of, settled
from bristle.models.controllers.feedforward import Shape
from bristle.models.controllers.wind_up import WindUp
from bristle.models.friction import deflection, slip_law
from bristle.models.friction.maxwell_stribeck import BEYOND
from bristle.models.hysteresis import everett

if TYPE_CHECKING:
    from bristle.exports.law import Law

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
        numbers = (
            np.abs(np.atleast_1d(value)).astype(float)
            if not isinstance(value, str)
            else np.zeros(1)
        )
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
    return near | {"every": CHECKPOINT, "tolerance": repr(TOLERANCE) if single else ""}


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
        low, high = float(variable.min), float(variable.max)
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
        marked[name] = (
            count + np.arange(value.size, dtype=float) if isinstance(value, np.ndarray) else count
        )
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


def tunable_law(law: Law) -> Tunable:
    """Return the variable parameters of the controller and the feedforward of a law, named such as ``controller_k_p``."""
    feedforward = law.variant.feedforward
    friction = feedforward.friction
    values: dict[str, Any] = {}
    variables: dict[str, Variable] = {}
    places: dict[tuple[str, ...], str] = {}
    for part, model in (
        ("controller", law.controller),
        ("friction", friction),
        ("table", feedforward.table),
    ):
        if model is not None:
            tuned = tunable_of(model)
            values |= {f"{part}_{name}": value for name, value in tuned.values.items()}
            named = {
                name: of_travel(variable) if part == "table" else variable
                for name, variable in tuned.variables.items()
            }
            variables |= {f"{part}_{name}": named[name] for name in tuned.values}
            places |= {(part, *path): f"{part}_{name}" for path, name in tuned.places.items()}
    fed = {("mass",): law.p.mass} if law.p.mass else {}
    fed |= (
        {}
        if friction is None
        else {("shape", name): value for name, value in _tunable_shape(law.p.shape).items()}
    )
    further = {**FEEDFORWARD, **variables_of(Shape)}
    if hasattr(law.p, "screw"):
        further |= variables_of(WindUp)
        fed |= {
            ("screw", name): value
            for name, value in law.p.screw._asdict().items()
            if isinstance(value, float)
        }
    for path, value in fed.items():
        name = f"feedforward_{path[-1]}"
        values[name], variables[name], places[path] = value, further[path[-1]], name
    return Tunable(law.controller.kind, variables, values, places)


def _tunable_shape(shape: Shape) -> dict[str, float]:
    """Return the fields of a shape that can change; the fields of a rule only if the shape has it."""
    usual = Shape._field_defaults
    fixed = {"return_distance", "fade_time", "constant", "viscous"}
    return {
        name: value
        for name, value in shape._asdict().items()
        if name not in fixed or value != usual[name]
    }


def settled_law(law: Law) -> Law:
    """Return a law without the branches that its fixed parameters rule out."""
    places = tunable_law(law).places if law.tunable else ()
    fact = fact_of(law.p, law.types[1], places)
    unit, (entry,) = settled(law.unit, [law.entry], {"p": fact}, single=law.single)
    return replace(law, unit=unit, entry=entry)


def _leaves(value: Any, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    leaves: list[tuple[tuple[str, ...], Any]] = []
    for name, part in zip(value._fields, value, strict=True):
        leaves += (
            _leaves(part, (*path, name)) if hasattr(part, "_fields") else [((*path, name), part)]
        )
    return leaves
