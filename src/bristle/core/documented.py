"""What a component is besides its functions: its data and conditions, what it tells of itself, how it travels."""

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

    One that is `advisory` is warned of, not refused. One that is `structural`, such as arrays of one length, keeps
    kernels within their arrays: it holds even where values are not validated.
    """

    condition: str
    holds: Callable[[Any], bool]
    mend: str
    advisory: bool = False
    structural: bool = False


class Redundancy(NamedTuple):
    """A parameter that only shows as a factor of others: no measurement tells it alone."""

    name: str
    factor_of: tuple[str, ...]


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


@dataclass(frozen=True, kw_only=True)
class Documented:
    """The data of a descriptor (`bristle.core.contracts.Component` says what each is), as it is shown and travels."""

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
        """Each parameter that a person sets, with its description, in order."""
        return ReadOnly(variables_of(self.Parameters))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self._written(getattr(self.Parameters, "_field_defaults", {}))

    @property
    def channels_needed(self) -> list[Any]:
        """The channels of a log, beside its motion, that a slot, or those of a model, depend on."""
        needed = getattr(self, "surroundings", ()) or [getattr(self, "channel", None)]
        return [surrounding for surrounding in needed if surrounding is not None and surrounding.is_recorded]

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return is_array(self.Parameters, name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return is_integer(self.Parameters, name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the `Parameters` that kernels receive, from the values that a person sets."""
        return self.Parameters(**values)

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values that a person sets, from the `Parameters` that kernels receive."""
        return self._written(parameters._asdict())

    def _written(self, values: Mapping[str, Any]) -> dict[str, Any]:
        described = variables_of(self.Parameters)
        return {name: described[name].written(value) for name, value in values.items()}

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        # A dataclass brings a representation of its own for each class that has none.
        cls.__repr__ = Documented.__repr__  # type: ignore[method-assign]
        cls.__doc__ = _Special(_docstring_of, cls.__dict__.get("__doc__") or cls.__name__)  # type: ignore[assignment]
        cls.__signature__ = _Special(_signature_of)  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        # There is one of each, told by identity: it is found again in another process, never made anew.
        return component_in, whereabouts(self)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def explanation(self) -> tuple[Paragraph, ...]:
        """What the docstring of its file says; then that of each of its slots."""
        from bristle.core.formula import paragraphs_of  # which nobody waits for who only computes

        inner = getattr(self, "inner", None)
        if inner is None:
            return paragraphs_of(getattr(sys.modules.get(self.module), "__doc__", None) or "")
        own = paragraphs_of(getattr(sys.modules.get(type(self).__module__), "__doc__", None) or "")
        return (*inner.explanation, *own[1:])

    def laid_out(self, width: int) -> str:
        """Return its explanation as text in lines of this width, without references."""
        from bristle.core.formula import REFERENCE, laid_out

        return laid_out((paragraph for paragraph in self.explanation if paragraph.kind != REFERENCE), width)

    @property
    def equations(self) -> tuple[str, ...]:
        """Its equations as text, line by line."""
        from bristle.core.formula import EQUATION, lines_of

        formulas = (paragraph.text for paragraph in self.explanation if paragraph.kind == EQUATION)
        return tuple(line for formula in formulas for line in lines_of(formula))

    def __repr__(self) -> str:
        defaults = self.defaults
        parameters = ", ".join(f"{name}={typed(defaults[name])}" if name in defaults else name for name in self.variables)
        return f"<{self.family} {self.name}({parameters})>"


def _unit_of(component: Documented, name: str, variable: Variable) -> str:
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
    from bristle.core.formula import REFERENCE, TEXT, Paragraph, laid_out

    defaults = {name: f", default {_written(value)}" for name, value in component.defaults.items()}
    explained = component.explanation or (Paragraph(TEXT, component.description),)
    named = [
        f"{name} : {_unit_of(component, name, variable)}{defaults.get(name, '')}\n    {_said_of(component, variable)}"
        for name, variable in component.variables.items()
    ]
    named += [f"kind : {KIND}, optional\n    Kind of axis; told from the units where they are given, else translational."]
    named += ["validate : bool, default True\n    False lets values through that break a range or a relation."]
    sections = {"Parameters": "\n".join(named)}
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


def _written(value: Any) -> str:
    return repr(value) if isinstance(value, str) else typed(value)


def _said_of(component: Documented, variable: Variable) -> str:
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


def relations_of(component: Documented) -> tuple[Relation, ...]:
    """Return the relations of a component for the one around it, whose parameters hold those of the component."""
    return tuple(relation._replace(holds=lambda p, holds=relation.holds: holds(p.inner)) for relation in component.relations)


class Enclosing:
    """What a component around another one, `inner`, has of it; kernels find the parameters of that as ``p.inner``."""

    inner: Any

    @property
    def beside(self) -> Mapping[str, Variable]:
        """Its parameters beside those of the component inside, of which there need be none."""
        return {}

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Each parameter that a person sets: those of the component inside, then those beside."""
        return ReadOnly(self.inner.variables | dict(self.beside))

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state of the component inside."""
        return self.inner.initial_state(parameters.inner)

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name in self.inner.variables and self.inner.is_array(name)

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        return name in self.inner.variables and self.inner.is_integer(name)

    def inside(self, values: Mapping[str, Any]) -> Any:
        """Return what kernels of the component inside receive, from the values that a person sets."""
        return self.inner.assemble({name: values[name] for name in self.inner.variables})


MAIN = ("__main__", "__mp_main__")
MEND = "Put it into a file of its own, by a name at the left margin such as MODEL, and import it from there"


def whereabouts(component: Documented) -> tuple[Any, str]:
    """Return the module of a component, or what it is made from, and its name there: the arguments of `component_in`."""
    # Hardly ever is it in another module than its own. All others are asked in the order in which they were imported, so
    # that what defines it comes before what has it from there, and the one that a person types last.
    for home in (component.module, *sorted(sys.modules, key=MAIN.__contains__)):
        held = getattr(sys.modules.get(home), "__dict__", {})
        for name, value in list(held.items()):
            if value is component:
                return held.get("__travels_as__", home), name
    place = f"{component.family} {component.name}"
    raise pickle.PicklingError(str(InputError("stands in no module, where another process would look for it", path=place, mend=MEND)))


def component_in(source: Any, name: str) -> Documented:
    """Return the component of this name in a module."""
    module = importlib.import_module(source) if isinstance(source, str) else source.module()
    component = vars(module).get(name)
    if component is None:
        place = f"{module.__name__}.{name}"
        raise pickle.UnpicklingError(str(InputError("is not to be found in this process", path=place, mend=MEND)))
    return component
