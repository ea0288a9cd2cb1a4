"""What components and models tell of themselves at the prompt: docstring, signature, short names, completion.

``help(friction.lugre)`` shows the equations of the docstring of its file and every parameter with unit and range;
``friction.lugre(<tab>`` shows the parameters, ``model.F_C`` is the value of one.
"""

from __future__ import annotations

import inspect
import math
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from bristle.core.described import Described
from bristle.core.errors import did_you_mean
from bristle.core.typography import typed
from bristle.core.variable import KINDS, Variable

if TYPE_CHECKING:
    from bristle.core.docstring import Paragraph

__all__ = ["Documented", "WithParameters"]

KIND = "{'translational', 'rotational'}"


class _Special:
    """An attribute that Python looks for on any object: an instance computes it, its class has its own or none."""

    def __init__(self, compute: Callable[[Any], Any], own: str | None = None) -> None:
        self.compute, self.own = compute, own

    def __get__(self, instance: Any, owner: type) -> Any:
        if instance is not None:
            return self.compute(instance)
        if self.own is None:
            raise AttributeError("the class has none")
        return self.own


class Documented(Described):
    """A component, as it is shown: its `explanation` is what the docstring of its file says."""

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass brings a representation of its own for each class that has none.
        cls.__repr__ = Documented.__repr__  # type: ignore[method-assign]
        cls.__doc__ = _Special(_docstring_of, cls.__dict__.get("__doc__") or cls.__name__)  # type: ignore[assignment]
        cls.__signature__ = _Special(_signature_of)  # type: ignore[attr-defined]

    @property
    def explanation(self) -> tuple[Paragraph, ...]:
        """What the docstring of its file says; then that of each of its slots."""
        from bristle.core.docstring import paragraphs_of  # which nobody waits for who only computes

        inner = getattr(self, "inner", None)
        if inner is None:
            return paragraphs_of(getattr(sys.modules.get(self.module), "__doc__", None) or "")
        own = paragraphs_of(getattr(sys.modules.get(type(self).__module__), "__doc__", None) or "")
        return (*inner.explanation, *own[1:])

    @property
    def equations(self) -> tuple[str, ...]:
        """Its equations as text, line by line."""
        from bristle.core.docstring import EQUATION
        from bristle.core.formula import lines_of

        formulas = (paragraph.text for paragraph in self.explanation if paragraph.kind == EQUATION)
        return tuple(line for formula in formulas for line in lines_of(formula))

    def __repr__(self) -> str:
        parameters = ", ".join(_with_default(self, name) for name in self.variables)
        return f"<{self.family} {self.name}({parameters})>"


def _with_default(component: Described, name: str) -> str:
    defaults = component.defaults
    return f"{name}={typed(defaults[name])}" if name in defaults else name


def _unit_of(component: Described, name: str, variable: Variable) -> str:
    """Return what is to be given for a parameter, in words and units of both kinds of axis."""
    if variable.choices:
        return " or ".join(map(repr, variable.choices))
    units = dict.fromkeys(variable.unit(kind) for kind in KINDS)
    unit = "a number" if "1" in units else " or ".join(units)
    if component.is_integer(name):
        return "a whole number"
    return f"a list, {unit}" if component.is_array(name) else unit


def _signature_of(component: Documented) -> inspect.Signature:
    def parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
        return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=default)

    defaults: Mapping[str, Any] = component.defaults
    own = [
        parameter(name, _unit_of(component, name, variable), defaults.get(name, inspect.Parameter.empty))
        for name, variable in component.variables.items()
    ]
    return inspect.Signature([*own, parameter("kind", KIND, None), parameter("validate", "bool", True)])


def _docstring_of(component: Documented) -> str:
    from bristle.core.docstring import REFERENCE, TEXT, Paragraph, laid_out

    explained = component.explanation or (Paragraph(TEXT, component.description),)
    named = [
        f"{name} : {_unit_of(component, name, variable)}{_default_of(component, name)}\n    {_said_of(component, variable)}"
        for name, variable in component.variables.items()
    ]
    sections = {"Parameters": "\n".join([*named, *_FURTHER])}
    sections["Notes"] = "\n".join(
        f"{'Should have' if relation.advisory else 'Needs'} {relation.condition}." for relation in component.relations
    )
    if component.example and not hasattr(component, "inner"):
        values = ", ".join(f"{name}={_written(value)}" for name, value in component.example.items())
        sections["Examples"] = f">>> model = {component.name}({values})"
    sources = laid_out(paragraph for paragraph in explained if paragraph.kind == REFERENCE)
    sections["References"] = sources.replace("\n\n", "\n")
    text = laid_out(paragraph for paragraph in explained if paragraph.kind != REFERENCE)
    return "\n\n".join([text, *(f"{head}\n{'-' * len(head)}\n{body}" for head, body in sections.items() if body)])


_FURTHER = (
    f"kind : {KIND}, optional",
    "    Kind of axis; told from the units where they are given, else translational.",
    "validate : bool, default True",
    "    False lets values through that break a range or a relation.",
)


def _written(value: Any) -> str:
    return repr(value) if isinstance(value, str) else typed(value)


def _default_of(component: Described, name: str) -> str:
    defaults = component.defaults
    return f", default {_written(defaults[name])}" if name in defaults else ""


def _said_of(component: Described, variable: Variable) -> str:
    """Return meaning and range of a parameter, the range in the unit that stands before it."""
    bounded = not variable.choices and (variable.min > -math.inf or variable.max < math.inf)
    allowed = f"; {variable.allowed().removesuffix(f' {variable.unit()}')}" if bounded else ""
    by_direction = variable.directional and not getattr(component, "asymmetry", False)
    return f"{variable.description}{allowed}{'; by direction with +asymmetry' * by_direction}"


class WithParameters:
    """A model, whose parameters are attributes beside its own."""

    def __getattr__(self, name: str) -> Any:
        # Before there is a component, as while a pickle is read, and for what only protocols look for: nothing.
        component = self.__dict__.get("component")
        if component is None or name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if name in component.variables:
            return self.values[name]
        hint = did_you_mean(name, component.variables) or f"It has {', '.join(component.variables)}"
        raise AttributeError(f"{component.name} has no parameter {name!r}. {hint}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.component.variables]
