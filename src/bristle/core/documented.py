"""Descriptors of components: data, conditions, documentation and pickling."""

from __future__ import annotations

import importlib
import inspect
import math
import pickle
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from bristle.core.errors import InputError, did_you_mean
from bristle.core.lazy import cached_property
from bristle.core.read_only import ReadOnly
from bristle.core.typography import typed
from bristle.core.variable import KINDS, Variable, is_array, is_integer, variables_of

if TYPE_CHECKING:
    from bristle.core.formula import Paragraph


class Relation(NamedTuple):
    """A condition between parameters, such as F_S >= F_C.

    An `advisory` relation causes a warning instead of an error. A `structural` relation, such as equal lengths of arrays,
    keeps kernels within their arrays, so it is checked even without validation. `allowed` states the range that the
    other parameters leave.
    """

    condition: str
    holds: Callable[[Any], bool]
    mend: str
    advisory: bool = False
    structural: bool = False
    allowed: Callable[[Any], str] | None = None


class Redundancy(NamedTuple):
    """A parameter that acts only as a factor of other parameters, so that no measurement identifies it separately."""

    name: str
    factor_of: tuple[str, ...]


KIND = "{'translational', 'rotational'}"


class _Special:
    """A special attribute that instances compute; classes have a separate value or lack the attribute."""

    def __init__(self, compute: Callable[[Any], Any], own: str | None = None) -> None:
        self.compute, self.own = compute, own

    def __get__(self, instance: Any, owner: type) -> Any:
        if instance is not None:
            return self.compute(instance)
        if self.own is None:
            raise AttributeError("the class lacks this attribute")
        return self.own


@dataclass(frozen=True, kw_only=True)
class Documented:
    """Display and pickling of a descriptor; `bristle.core.contracts.Component` documents its data."""

    name: str
    description: str
    Parameters: type
    State: type
    reference: str = ""
    relations: tuple[Relation, ...] = ()
    redundancies: tuple[Redundancy, ...] = ()
    example: Mapping[str, Any] = field(default_factory=dict, compare=False)
    module: str = field(default="", compare=False)

    family: ClassVar[str] = "component"

    def __post_init__(self) -> None:
        object.__setattr__(self, "module", self.module or self.Parameters.__module__)
        object.__setattr__(self, "example", ReadOnly(self.example))

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """User parameters with their descriptions, in order."""
        return ReadOnly(variables_of(self.Parameters))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self._written(getattr(self.Parameters, "_field_defaults", {}))

    @property
    def channels_needed(self) -> list[Any]:
        """Channels of a log, other than its motion, on which a slot or the slots of a model depend."""
        needed = getattr(self, "surroundings", ()) or [getattr(self, "channel", None)]
        return [
            surrounding
            for surrounding in needed
            if surrounding is not None and surrounding.is_recorded
        ]

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return is_array(self.Parameters, name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return is_integer(self.Parameters, name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Convert user values to the `Parameters` of kernels."""
        return self.Parameters(**values)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Convert the `Parameters` of kernels to user values."""
        return self._written(parameters._asdict())

    def _written(self, values: Mapping[str, Any]) -> dict[str, Any]:
        described = variables_of(self.Parameters)
        return {name: described[name].written(value) for name, value in values.items()}

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass adds a __repr__ to each class without it.
        cls.__repr__ = Documented.__repr__  # type: ignore[method-assign]
        cls.__doc__ = _Special(_docstring_of, cls.__dict__.get("__doc__") or cls.__name__)  # type: ignore[assignment]
        cls.__signature__ = _Special(_signature_of)  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        # Components are singletons, compared by identity: unpickling finds the same object instead of a new object.
        return component_in, whereabouts(self)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def explanation(self) -> tuple[Paragraph, ...]:
        """Docstring of its file, then the docstrings of its slots."""
        from bristle.core.formula import paragraphs_of  # not needed for computing

        inner = getattr(self, "inner", None)
        if inner is None:
            return paragraphs_of(getattr(sys.modules.get(self.module), "__doc__", None) or "")
        own = paragraphs_of(getattr(sys.modules.get(type(self).__module__), "__doc__", None) or "")
        return (*inner.explanation, *own[1:])

    def laid_out(self, width: int) -> str:
        """Return its explanation as wrapped text, without references."""
        from bristle.core.formula import REFERENCE, laid_out

        return laid_out(
            (paragraph for paragraph in self.explanation if paragraph.kind != REFERENCE), width
        )

    @property
    def equations(self) -> tuple[str, ...]:
        """Lines of its equations as text."""
        from bristle.core.formula import EQUATION, lines_of

        return tuple(
            line
            for paragraph in self.explanation
            if paragraph.kind == EQUATION
            for line in lines_of(paragraph.text)
        )

    @property
    def latex(self) -> tuple[str, ...]:
        """Its equations in LaTeX."""
        from bristle.core.formula import EQUATION, equations_in

        displays = (paragraph.text for paragraph in self.explanation if paragraph.kind == EQUATION)
        return tuple(
            equation.strip().removesuffix(",")
            for display in displays
            for equation in equations_in(display)
        )

    def __repr__(self) -> str:
        defaults = self.defaults
        parameters = ", ".join(
            f"{name}={typed(defaults[name])}" if name in defaults else name
            for name in self.variables
        )
        return f"<{self.family} {self.name}({parameters})>"


def _unit_of(component: Documented, name: str, variable: Variable) -> str:
    """Return the type of a parameter in words, with its units on both kinds of axis."""
    if variable.choices:
        return " or ".join(map(repr, variable.choices))
    units = dict.fromkeys(variable.unit(kind) for kind in KINDS)
    unit = "a number" if "1" in units else " or ".join(units)
    if component.is_integer(name):
        return "a whole number"
    return f"a list, {unit}" if component.is_array(name) else unit


def _signature_of(component: Documented) -> inspect.Signature:
    def parameter(
        name: str, annotation: Any, default: Any = inspect.Parameter.empty
    ) -> inspect.Parameter:
        return inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=default
        )

    defaults: Mapping[str, Any] = component.defaults
    own = [
        parameter(
            name, _unit_of(component, name, variable), defaults.get(name, inspect.Parameter.empty)
        )
        for name, variable in component.variables.items()
    ]
    return inspect.Signature(
        [*own, parameter("kind", KIND, None), parameter("validate", "bool", True)]
    )


def _docstring_of(component: Documented) -> str:
    from bristle.core.formula import REFERENCE, TEXT, Paragraph, laid_out

    defaults = {name: f", default {_written(value)}" for name, value in component.defaults.items()}
    explained = component.explanation or (Paragraph(TEXT, component.description),)
    named = [
        f"{name} : {_unit_of(component, name, variable)}{defaults.get(name, '')}\n    {_said_of(component, variable)}"
        for name, variable in component.variables.items()
    ]
    named += [
        f"kind : {KIND}, optional\n    Kind of axis; by default from the units of the values, or else translational.",
        "validate : bool, default True\n    False accepts values that violate a range or a relation.",
    ]
    sections = {
        "Parameters": "\n".join(named),
        "Notes": "\n".join(
            f"{'Should have' if relation.advisory else 'Needs'} {relation.condition}."
            for relation in component.relations
        ),
    }
    if component.example and not hasattr(component, "inner"):
        values = ", ".join(f"{name}={_written(value)}" for name, value in component.example.items())
        sections["Examples"] = f">>> model = {component.name}({values})"
    sources = laid_out(paragraph for paragraph in explained if paragraph.kind == REFERENCE)
    sections["References"] = sources.replace("\n\n", "\n")
    text = laid_out(paragraph for paragraph in explained if paragraph.kind != REFERENCE)
    return "\n\n".join(
        [text, *(f"{head}\n{'-' * len(head)}\n{body}" for head, body in sections.items() if body)]
    )


def _written(value: Any) -> str:
    return repr(value) if isinstance(value, str) else typed(value)


def _said_of(component: Documented, variable: Variable) -> str:
    """Return meaning and range of a parameter; the unit of the range is in the line before."""
    bounded = not variable.choices and (variable.min > -math.inf or variable.max < math.inf)
    allowed = f"; {variable.allowed().removesuffix(f' {variable.unit()}')}" if bounded else ""
    by_direction = variable.directional and not getattr(component, "asymmetry", False)
    return f"{variable.description}{allowed}{'; by direction with +asymmetry' * by_direction}"


class WithParameters:
    """A model, whose parameters are additional attributes."""

    def __getattr__(self, name: str) -> Any:
        # Without a component yet, as during unpickling, or for special names of protocols.
        component = self.__dict__.get("component")
        if component is None or name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        if name in component.variables:
            return self.values[name]
        hint = did_you_mean(name, component.variables) or f"It has {', '.join(component.variables)}"
        raise AttributeError(f"{component.name} has no parameter {name!r}. {hint}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.component.variables]


def relations_of(component: Documented) -> tuple[Relation, ...]:
    """Return the relations of a component, for the parameters of the component that encloses it."""
    return tuple(
        relation._replace(holds=lambda p, holds=relation.holds: holds(p.inner))
        for relation in component.relations
    )


class Enclosing:
    """Base of a component that encloses another component; kernels find its parameters as ``p.inner``."""

    inner: Any

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Additional parameters besides those of the enclosed component; may be empty."""
        return {}

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """User parameters: first of the enclosed component, then the additional parameters."""
        return ReadOnly(self.inner.variables | dict(self.beside))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the enclosed component."""
        return self.inner.initial_state(parameters.inner)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name in self.inner.variables and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name in self.inner.variables and self.inner.is_integer(name)

    def inside(self, values: Mapping[str, Any]) -> Any:
        """Convert user values to the parameters of the kernels of the enclosed component."""
        return self.inner.assemble({name: values[name] for name in self.inner.variables})


MAIN = ("__main__", "__mp_main__")
MEND = "Define this model in a separate file under a module-level name such as MODEL, and import it from that file"


def whereabouts(component: Documented) -> tuple[Any, str]:
    """Return the module or source of a component, and its name there: the arguments of `component_in`."""
    # It is nearly always in its own module. The others are searched in the order of import, so that the defining module
    # comes before modules that import it, and the interactive module comes last.
    for home in (component.module, *sorted(sys.modules, key=MAIN.__contains__)):
        held = getattr(sys.modules.get(home), "__dict__", {})
        for name, value in list(held.items()):
            if value is component:
                return held.get("__travels_as__", home), name
    place = f"{component.family} {component.name}"
    raise pickle.PicklingError(
        str(
            InputError(
                "is not defined in a module, so another process cannot find it",
                path=place,
                mend=MEND,
            )
        )
    )


def component_in(source: Any, name: str) -> Documented:
    """Return the component with this name in a module."""
    module = importlib.import_module(source) if isinstance(source, str) else source.module()
    component = vars(module).get(name)
    if component is None:
        place = f"{module.__name__}.{name}"
        raise pickle.UnpicklingError(
            str(InputError("does not exist in this process", path=place, mend=MEND))
        )
    return component
