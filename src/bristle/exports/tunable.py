"""Parameters that may be changed at run time: what a person sets, and where kernels look for it."""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.experiment import FEEDFORWARD
from bristle.core.variable import Kind, Variable
from bristle.exports.settled import fact_of, settled

if TYPE_CHECKING:
    from bristle.exports.law import Law

__all__ = ["Tunable", "bounds_of", "settled_law", "tunable_law", "tunable_of"]

MARK = 1024.0  # numbers that stand for parameters, to be leaves again in what kernels receive
FED = "feedforward"


@dataclass(frozen=True)
class Tunable:
    """Which parameters may be changed, with their values, and where each of them goes."""

    kind: Kind
    variables: Mapping[str, Variable]
    values: dict[str, Any]
    places: dict[tuple[str, ...], str]
    fixed: dict[tuple[str, ...], Any]

    def numbers(self) -> Iterator[tuple[str, int | None, float]]:
        """Give the name, the place in it where it is an array, and the value of each number."""
        for name, value in self.values.items():
            if isinstance(value, np.ndarray):
                yield from ((name, place, number) for place, number in enumerate(value.tolist()))
            else:
                yield name, None, value


def bounds_of(tuned: Tunable) -> Iterator[tuple[str, int | None, list[tuple[str, float]]]]:
    """Give the name and the place of each number that may be changed, and what it is compared with.

    A number that is unbounded is compared with the largest of its type, so that it is finite.
    """
    for name, place, _ in tuned.numbers():
        variable = tuned.variables[name]
        low, high = float(variable.min), float(variable.max)
        compared = [(">=", low)] * math.isfinite(low) + [("<=", high)] * math.isfinite(high)
        yield name, place, compared or [(">=", -math.inf), ("<=", math.inf)]


def tunable_of(model: Model, fixed_names: Container[str] = ()) -> Tunable:
    """Return the parameters of a model that may be changed: its real numbers; whole numbers and choices are fixed.

    So are those of these names.
    """
    component = model.component
    values = {
        name: value
        for name, value in model.values.items()
        if not component.is_integer(name) and not component.variables[name].choices and name not in fixed_names
    }
    marked: dict[str, Any] = {}
    names: dict[Any, str] = {}
    count = MARK
    for name, value in values.items():
        size = value.size if isinstance(value, np.ndarray) else 1
        numbers = count + np.arange(size, dtype=float)
        count += size
        marked[name] = numbers if isinstance(value, np.ndarray) else float(numbers[0])
        names[_key(marked[name])] = name
    leaves = dict(_leaves(component.assemble(dict(model.values) | marked), ()))
    places = {path: names[_key(value)] for path, value in leaves.items() if _key(value) in names}
    fixed = {path: value for path, value in _leaves(model.parameters, ()) if path not in places}
    lost = sorted(set(values) - set(places.values()))
    usual = dict(_leaves(component.assemble(dict(model.values)), ()))
    lost += [".".join(path) for path in fixed if _bits(leaves[path]) != _bits(usual[path])]
    if lost:
        raise InputError(
            "makes something else of a parameter, so that it cannot be changed at run time",
            path=model.name,
            value=", ".join(lost),
            mend="Leave --tunable out",
        )
    values = {name: v if isinstance(v, np.ndarray) else float(v) for name, v in values.items()}
    return Tunable(model.kind, component.variables, values, places, fixed)


def tunable_law(law: Law) -> Tunable:
    """Return the parameters of a law that may be changed: those of its controller, and of what it feeds forward.

    Each is called by what it belongs to and its own name, ``controller_k_p``. The limit of the drive, and the gravity
    and the cogging of a plant, are fixed.
    """
    friction = law.variant.feedforward.friction
    parts = {"controller": law.controller} | ({} if friction is None else {"friction": friction})
    values: dict[str, Any] = {}
    variables: dict[str, Variable] = {}
    places: dict[tuple[str, ...], str] = {}
    for part, model in parts.items():
        tuned = tunable_of(model)
        values |= {f"{part}_{name}": value for name, value in tuned.values.items()}
        variables |= {f"{part}_{name}": tuned.variables[name] for name in tuned.values}
        places |= {(part, *path): f"{part}_{name}" for path, name in tuned.places.items()}
    fed = {("mass",): law.p.mass} if law.p.mass else {}
    fed |= {} if friction is None else {("shape", name): value for name, value in law.p.shape._asdict().items()}
    for path, value in fed.items():
        name = f"{FED}_{path[-1]}"
        values[name], variables[name], places[path] = value, FEEDFORWARD[path[-1]], name
    fixed = {path: value for path, value in _leaves(law.p, ()) if path not in places}
    return Tunable(law.controller.kind, variables, values, places, fixed)


def settled_law(law: Law) -> Law:
    """Return a law with all left out that its parameters decide, but for those that may be changed."""
    places = tunable_law(law).places if law.tunable else ()
    fact = fact_of(law.p, law.types[1], places)
    unit, (entry,) = settled(law.unit, [law.entry], {"p": fact}, single=law.single)
    return replace(law, unit=unit, entry=entry)


def _bits(value: Any) -> bytes:
    return np.asarray(value).tobytes()


def _key(value: Any) -> Any:
    return value.tobytes() if isinstance(value, np.ndarray) else value


def _leaves(value: Any, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    leaves: list[tuple[tuple[str, ...], Any]] = []
    for name, part in zip(value._fields, value, strict=True):
        leaves += _leaves(part, (*path, name)) if hasattr(part, "_fields") else [((*path, name), part)]
    return leaves
