"""Derivatives of a friction model in C: a step of the axis, and of its changes in several directions.

The derived function is printed like every other function of the model (`bristle.engine.translation.derivative`), for one direction.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.core.errors import InputError, InputWarning
from bristle.core.packing import pack
from bristle.engine.compilation import interpreted
from bristle.engine.derivatives import force_with_derivatives
from bristle.engine.translation.build import Builder
from bristle.engine.translation.derivative import (
    Activity,
    activity_of,
    is_active,
    tangent_of,
    type_of_tangent,
)
from bristle.engine.translation.directional import derived_in
from bristle.engine.translation.scope import defined
from bristle.engine.translation.tree import REAL, Array, Struct, Type
from bristle.exports.c_code import Printer, initializer
from bristle.exports.c_parts import CONSTANT, around_text, place_of
from bristle.exports.described import meaning_of
from bristle.exports.printing import wrapped
from bristle.exports.subject import Subject, capacity_of, hash_of, settled_subject
from bristle.exports.tunable import Tunable, tunable_of

STEP = """def step(state, memory, motion, dt, p):
    force, move = trial(state, memory, motion, dt, p)
    if force - force == 0.0:
        state = commit(state, memory, move, p)
    return force, state
"""
ARGUMENTS = ("state", "memory", "motion", "dt", "p")


@dataclass(frozen=True)
class DerivedStep:
    """The step of a friction model with its tangent in one direction, and which numbers have tangents."""

    subject: Subject
    tuned: Tunable
    entering: dict[str, Activity]
    leaving: Activity

    @property
    def places(self) -> dict[str, int]:
        """The place of each parameter among the numbers of all parameters."""
        return {
            name: k
            for k, (name, within, _) in reversed(list(enumerate(self.tuned.numbers())))
            if not within
        }

    def facts(self, printer: Printer, *, tunable: bool) -> dict[str, Any]:
        """Return the facts of the templates."""
        state = self.subject.state
        tuned = self.tuned
        numbers = list(self.tuned.numbers())
        names = [place_of(name, within, printer) for name, within, _ in numbers]
        meanings = [meaning_of(tuned.variables[name], tuned.kind) for name, *_ in numbers]
        d_force = "0.0"
        if is_active(self.leaving[0]):  # type: ignore[index]
            d_force = "step.part_1.part_0"
        return {
            "derived": True,
            "directions": len(numbers),
            "d_velocity": "(d_x_k - at->position - velocity * d_dt_k) / dt",
            "d_parameters": [
                f"{k}: {name}, {meaning}"
                for k, (name, meaning) in enumerate(zip(names, meanings, strict=True))
            ],
            "d_state": [
                printer.names.variable(name) for name, part in state.fields if part == REAL
            ],
            "usual_signals": [repr(self.subject.usual[name]) for name in self.subject.signals],
            "step_d": self._call(printer, tunable=tunable),
            "copies": self.derived.writes and self.subject.memory_size > 0,
            "d_force": d_force,
            "d_after": self._after(printer),
        }

    def fields(self, printer: Printer) -> list[dict[str, Any]]:
        """Return name, type and, of an integer, the number of values of each field of the state."""
        subject = self.subject
        return [
            {
                "name": printer.names.variable(name),
                "type": printer.type_name(kind),
                "capacity": kind != REAL and capacity_of(name, subject.memory_size),
            }
            for name, kind in subject.state.fields
        ]

    @property
    def derived(self) -> Any:
        """The derived function."""
        return self.subject.derived

    def _call(self, printer: Printer, *, tunable: bool) -> list[str]:
        """Return the lines that call the derived function, as it is left after pruning."""
        subject = self.subject
        state = initializer(
            f"axis->state.{printer.names.variable(name)}" for name, _ in subject.state.fields
        )
        usual = dict(zip(subject.usual, around_text(subject, printer), strict=True))
        moved = {name: f"d_{text}_k" for name, text in usual.items()}
        moved |= {"v": "d_velocity", "x": "d_x_k"}

        def parameter(path: tuple[str, ...], part: Type) -> str:
            place = f"at->parameters[{self.places[self.tuned.places[path]]}]"
            if isinstance(part, Array):
                return f"&{place}"
            return place

        handed = {
            "state": printer.structure_text(subject.state, state),
            "memory": "axis->memory",
            "motion": printer.structure_text(
                subject.motion, ", ".join(["velocity", "x", *usual.values()])
            ),
            "dt": "dt",
            "p": CONSTANT,
            tangent_of("memory"): "at->memory",
            tangent_of("dt"): "d_dt_k",
        }
        if self.derived.writes:
            handed["memory"] = "memory"
        if tunable:
            handed["p"] = "assembled(&axis->parameters)"
        leaves: dict[str, tuple[Type, Callable[[tuple[str, ...], Type], str]]] = {
            "state": (
                subject.state,
                lambda path, _: f"at->state.{printer.names.variable(path[0])}",
            ),
            "motion": (subject.motion, lambda path, _: moved[path[0]]),
            "p": (subject.parameters, parameter),
        }
        left = {argument.name for argument in self.derived.parameters}
        for name, (kind, leaf) in leaves.items():
            if tangent_of(name) not in left:
                continue
            handed[tangent_of(name)] = _tangent_text(printer, kind, self.entering[name], leaf)
        called = f"{self.derived.name}({', '.join(handed[argument.name] for argument in self.derived.parameters)})"
        return wrapped(
            f"        const {printer.named(self.derived.result, 'step')} = {called};", "        "
        )

    def _after(self, printer: Printer) -> list[str]:
        """Return the lines that store the tangent of the state."""
        assert isinstance(self.leaving, tuple)
        force, state = self.leaving
        assert isinstance(state, tuple)
        lines = []
        place = 0
        for (name, kind), active in zip(self.subject.state.fields, state, strict=True):
            value = "0.0"
            if active:
                value = f"step.part_1.part_{int(is_active(force))}.part_{place}"
            place += is_active(active)
            if kind == REAL:
                lines.append(f"at->state.{printer.names.variable(name)} = {value};")
        return lines

    def selftest_facts(self, x: np.ndarray, dt: float) -> dict[str, Any]:
        """Return the parameters of the first direction, and the hash of the derivatives along the walk.

        The first direction changes all parameters, the second one scales the walk.
        """
        values = [
            (k + 1.0) * (value or 1.0) if math.isfinite(value) else 0.0
            for k, (*_, value) in enumerate(self.tuned.numbers())
        ]
        model = self.subject.model
        v = np.diff(x) / dt
        packed = pack(
            _replaced(model.parameters, self.tuned, self.places, values, self.entering["p"])
        )
        tangents = np.column_stack((packed, 0.0 * packed))
        still = np.zeros(v.size)
        moved = np.column_stack((still, v)), np.column_stack((still, x[1:]))
        with interpreted(), np.errstate(invalid="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)  # the walk fills any memory
            _, slopes = force_with_derivatives(model, tangents, v, dt, x[1:], motion_tangents=moved)
        return {
            "directions_of_test": [repr(value) for value in values],
            "hash_d": f"0x{hash_of([0.0, 0.0, *(slopes + 0.0).ravel()]):016X}",
        }


def _tangent_text(
    printer: Printer,
    kind: Type,
    activity: Activity,
    leaf: Callable[[tuple[str, ...], Type], str],
    path: tuple[str, ...] = (),
) -> str:
    """Return the expression of a tangent from those of its numbers and arrays."""
    if not isinstance(kind, Struct) or not isinstance(activity, tuple):
        return leaf(path, kind)
    pairs = zip(kind.fields, activity, strict=True)
    parts = [
        _tangent_text(printer, part, inner, leaf, (*path, name))
        for (name, part), inner in pairs
        if is_active(inner)
    ]
    if parts:
        return printer.structure_text(type_of_tangent(kind, activity), ", ".join(parts))
    return ""


def _replaced(
    p: Any,
    tuned: Tunable,
    places: dict[str, int],
    values: list[float],
    activity: Any,
    path: tuple[str, ...] = (),
) -> Any:
    """Return parameters of the kernels with other values where they have tangents, and zeros elsewhere."""
    parts: list[Any] = []
    for name, part, active in zip(p._fields, p, activity, strict=True):
        inner = (*path, name)
        if hasattr(part, "_fields"):
            parts.append(_replaced(part, tuned, places, values, active, inner))
        elif isinstance(part, np.ndarray):
            numbers = 0.0 * part
            if active:
                first = places[tuned.places[inner]]
                numbers = np.array(values[first : first + part.size])
            parts.append(numbers)
        elif active:
            parts.append(values[places[tuned.places[inner]]])
        else:
            parts.append(0.0)
    return type(p)(*parts)


def derived_step(subject: Subject, *, tunable: bool) -> DerivedStep:
    """Return the settled step of a friction model with tangents; an infinite parameter that cannot change has none."""
    if subject.is_operator:
        raise InputError(
            "is a hysteresis operator, and bristle exports derivatives of friction only",
            path=subject.model.name,
            mend="Omit derivatives",
        )
    component = subject.model.component
    tuned = tunable_of(subject.model, mend="Omit --derivatives")
    moving = {
        path
        for path, name in tuned.places.items()
        if tunable or np.all(np.isfinite(tuned.values[name]))
    }

    def of_parameters(kind: Type, path: tuple[str, ...] = ()) -> Activity:
        if isinstance(kind, Struct):
            return tuple(of_parameters(part, (*path, name)) for name, part in kind.fields)
        return path in moving

    builder = Builder()
    memory = Array(subject.memory_size, writable=True)
    types = [subject.state, memory, subject.motion, REAL, subject.parameters]
    trial = builder.function(component.trial, types)
    commit = builder.function(
        component.commit, [subject.state, memory, subject.move, subject.parameters]
    )
    step = builder.function(
        defined(
            "step", STEP, {"trial": component.trial, "commit": component.commit, "__name__": "step"}
        ),
        types,
    )
    of_motion = tuple(name in ("v", "x", *subject.signals) for name, _ in subject.motion.fields)
    entering = [
        activity_of(subject.state),
        True,
        of_motion,
        True,
        of_parameters(subject.parameters),
    ]
    derived, function = derived_in(builder, step, entering)
    places = ()
    if tunable:
        places = tuned.places
    settled = settled_subject(
        replace(subject, unit=builder.unit, trial=trial, commit=commit, derived=function), places
    )
    return DerivedStep(settled, tuned, dict(zip(ARGUMENTS, entering, strict=True)), derived.result)
