"""A friction model over a hysteresis operator: a table of branches, a plane of cells, or stops.

`preisach_lugre` and `preisach_contact` have kernels in closed form. Given an operator for ``kernel``, they use it and
its memory instead. The parameters of the operator, ``kernel_E`` and so on, replace ``s`` and ``f_p``. An operator in
closed form is a built-in kernel, and changes no other parameter.

The parameters of the kernels are the operator, the rest of the friction model, and two lengths that follow from the
operator: the length over which it turns, for the parts of a long step, and the smallest reversal that it stores.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from bristle.core import (
    KINDS,
    FrictionModel,
    HysteresisOperator,
    InputError,
    Model,
    Relation,
    Variable,
    kernel,
    variables_of,
)
from bristle.core.dispatch import operator_commit, operator_trial
from bristle.core.lazy import cached_property, once
from bristle.core.read_only import ReadOnly
from bristle.models.hysteresis import (
    everett_table,
    prandtl_ishlinskii,
    preisach,
    preisach_grid,
    reversal_table,
)
from bristle.models.hysteresis.prandtl_ishlinskii import Move
from bristle.models.hysteresis.sliders import Sliders
from bristle.models.hysteresis.turning_points import Stack

PREFIX = "kernel_"
HALVINGS = 60
CLOSED_FORM = ("s", "f_p", "kernel", "exponent", "capacity")
OWN_TOLERANCE = preisach.defaults["tolerance"]
SHORTEST = 1e-6  # of the reach: a length over which an operator turns


class Lean(NamedTuple):
    """State of a contact of stops: its deflection and the force there. The sliders are the memory. Also a move."""

    z: Annotated[float, Variable("length", "input of the operator")] = 0.0
    f: Annotated[float, Variable("force", "output of the operator")] = 0.0


class Lengths(NamedTuple):
    """Lengths of an operator: that over which it turns, and the smallest reversal that it stores."""

    turn: float
    smallest: float


@kernel
def leaning(state, memory, p):
    """Return the place of stops in parallel, as turning points without memory, and their measure."""
    return Stack(state.z, state.f, 0.0, 0, 0), Sliders(p.thresholds, p.weights, p.spring, memory)


@kernel
def slide(state, memory, move, p):
    """Let every slider follow a move, and return the state after it."""
    operator_commit(state, memory, Move(move.z), p)
    return Lean(move.z, move.f)


class Reach(NamedTuple):
    """Range of inputs in which an operator has a measure, and the reference of its tolerance."""

    low: float
    high: float
    unit: float


def _reach_of_curves(p: Any) -> Reach:
    ends = sorted((p.side * float(p.reversals[0]), p.side * float(p.reversals[-1])))
    return Reach(ends[0], ends[1], ends[1] - ends[0])


def _reach_of_stops(p: Any) -> Reach:
    farthest = float(max(p.thresholds))
    return Reach(-farthest, farthest, farthest)


REACHES: dict[str, Callable[[Any], Reach]] = {
    everett_table.name: lambda p: Reach(-p.extent, p.extent, p.extent),
    reversal_table.name: _reach_of_curves,
    preisach_grid.name: lambda p: Reach(p.low, p.high, p.high - p.low),
    prandtl_ishlinskii.name: _reach_of_stops,
}
"""The operators that can replace a kernel, and the reach of each."""


class Form(NamedTuple):
    """A friction model over one sort of operators: the class of its parameters, its memory, and its functions."""

    Parameters: type
    State: type
    trial: Callable[..., Any]
    commit: Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class TakesOperator(FrictionModel):
    """A friction model that takes a hysteresis operator as its kernel.

    Parameters
    ----------
    own : type
        Named tuple of its parameters besides those of the kernel.
    turning, stops : Form
        The model over an operator with turning points, and over stops in parallel.
    own_relations : tuple of Relation
        Conditions between its parameters besides those of the kernel.
    exceeded : str
        Parameter that the saturation of the operator must exceed, if any.
    example_over : mapping
        Values of its example over an operator, if they differ.
    """

    own: type
    turning: Form
    stops: Form
    own_relations: tuple[Relation, ...] = ()
    exceeded: str = ""
    example_over: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def over(self, operator: Model, path: str = "kernel") -> tuple[FrictionModel, dict[str, Any]]:
        """Return this model with an operator as its kernel, and the values of the operator.

        Raises
        ------
        InputError
            If the operator cannot be a kernel.
        """
        allowed = ", ".join((preisach.name, *REACHES))
        if operator.component.family != "hysteresis":
            raise InputError(
                "is not a hysteresis operator", path=path, value=operator.name, allowed=allowed
            )
        if operator.kind not in KINDS:
            raise InputError(
                f"is {operator.kind}, so its output is not a force over a displacement",
                path=path,
                value=operator.name,
                allowed=" or ".join(KINDS),
            )
        if operator.component is preisach:
            return self, _closed_form(operator, path)
        if operator.name not in REACHES:
            raise InputError(
                _REFUSED.get(operator.name, "gives no force from a displacement"),
                path=path,
                value=operator.name,
                allowed=allowed,
            )
        return over_operator(self, operator.component), _prefixed(operator.values)


_REFUSED = {
    "relay_grid": "has a staircase output without stiffness, unlike preisach_grid, which has the same measure"
}


def _closed_form(operator: Model, path: str) -> dict[str, Any]:
    if operator.values["tolerance"] != OWN_TOLERANCE:
        raise InputError(
            "has a tolerance, but a kernel in closed form has a fixed tolerance",
            path=path,
            value=operator.values["tolerance"],
            allowed=repr(OWN_TOLERANCE),
        )
    return {name: operator.values[name] for name in CLOSED_FORM}


def _prefixed(values: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{PREFIX}{name}": value for name, value in values.items()}


@dataclass(frozen=True, kw_only=True)
class OverOperator(FrictionModel):
    """A friction model over an operator; the parameters of the operator replace those of its kernel."""

    inner: TakesOperator
    operator: HysteresisOperator

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return over_operator, (self.inner, self.operator)

    def over(self, operator: Model, path: str = "kernel") -> tuple[FrictionModel, dict[str, Any]]:
        """Return the model over another operator, and the values of that operator."""
        return self.inner.over(operator, path)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Description of each parameter: those of the operator, then those of the model."""
        return ReadOnly(_prefixed(self.operator.variables) | variables_of(self.inner.own))

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters."""
        own = {
            name: value
            for name, value in self.inner.defaults.items()
            if name in self.inner.own._fields
        }
        return _prefixed(self.operator.defaults) | own

    def is_array(self, name: str) -> bool:
        """Return whether this parameter is a 1-D array."""
        return name.startswith(PREFIX) and self.operator.is_array(name.removeprefix(PREFIX))

    def is_integer(self, name: str) -> bool:
        """Return whether this parameter is a whole number."""
        if name.startswith(PREFIX):
            return self.operator.is_integer(name.removeprefix(PREFIX))
        return self.inner.is_integer(name)

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of the kernels from the values of the user."""
        operator = self.operator.assemble(
            {name: values[f"{PREFIX}{name}"] for name in self.operator.variables}
        )
        own = self.inner.own(**{name: values[name] for name in self.inner.own._fields})
        return self.Parameters(operator, own, _lengths(self.operator, operator))

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the user from the parameters of the kernels."""
        own = parameters.own._asdict()
        return _prefixed(self.operator.values(parameters.operator)) | {
            name: self.variables[name].written(value) for name, value in own.items()
        }

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state: the operator may have a force at rest."""
        return self.State(f=_at_rest(self.operator, parameters.operator))


@once
def over_operator(model: TakesOperator, operator: HysteresisOperator) -> OverOperator:
    """Return a friction model over an operator."""
    form = model.stops if operator is prandtl_ishlinskii else model.turning
    example = {name: value for name, value in model.example.items() if name in model.own._fields}
    return OverOperator(
        name=f"{model.name}+{operator.name}",
        description=f"{model.description}; its kernel is an operator: {operator.description}",
        Parameters=form.Parameters,
        State=form.State,
        trial=form.trial,
        commit=form.commit,
        memory_size=lambda p: operator.memory_size(p.operator),
        relations=_relations(model, operator),
        reference=model.reference,
        module=model.module,
        example=_prefixed(operator.example) | example | dict(model.example_over),
        inner=model,
        operator=operator,
    )


def _relations(model: TakesOperator, operator: HysteresisOperator) -> tuple[Relation, ...]:
    relations = [
        *(_of_part(relation, "operator") for relation in operator.relations),
        *(_of_part(relation, "own") for relation in model.own_relations),
    ]
    if model.exceeded:
        relations.append(
            Relation(
                f"saturation of the operator > {model.exceeded}",
                lambda p: saturation(operator, p.operator) > getattr(p.own, model.exceeded),
                f"Lower {model.exceeded}, or record curves up to a larger force: otherwise the deflection grows without "
                "bound while the body slides",
            )
        )
    return tuple(relations)


def _of_part(relation: Relation, part: str) -> Relation:
    return relation._replace(holds=lambda p: relation.holds(getattr(p, part)))


def saturation(operator: HysteresisOperator, p: Any) -> float:
    """Return the saturation of an operator, the smaller of both directions [N or N*m]."""
    if operator is prandtl_ishlinskii and p.spring > 0.0:
        return math.inf
    reach, state, memory = (
        REACHES[operator.name](p),
        operator.initial_state(p),
        operator.new_memory(p),
    )
    low, high = (operator_trial(state, memory, end, p)[0] for end in (reach.low, reach.high))
    return min(high, -low)


def _at_rest(operator: HysteresisOperator, p: Any) -> float:
    """Return the force of a virgin operator at the input 0 [N or N*m]."""
    return float(operator_trial(operator.initial_state(p), operator.new_memory(p), 0.0, p)[0])


def _lengths(operator: HysteresisOperator, p: Any) -> Lengths:
    """Return the lengths of an operator: it turns over a quarter of the way to half of a full stroke.

    For a Masing kernel of Dahl's exponent 2 and a long stroke, that is f_p/s.
    """
    if not all(relation.holds(p) for relation in operator.relations):
        return Lengths(1.0, 0.0)  # unused: such parameters are refused
    reach, state, memory = (
        REACHES[operator.name](p),
        operator.initial_state(p),
        operator.new_memory(p),
    )
    state = operator_commit(state, memory, operator_trial(state, memory, reach.low, p)[1], p)
    start, end = (operator_trial(state, memory, u, p)[0] for u in (reach.low, reach.high))
    near, far = reach.low, reach.high
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        done = (
            (operator_trial(state, memory, middle, p)[0] - start) / (end - start)
            if end != start
            else 1.0
        )
        near, far = (middle, far) if done < 0.5 else (near, middle)
    turn = max(0.5 * (far - reach.low), SHORTEST * (reach.high - reach.low))
    return Lengths(turn, getattr(p, "tolerance", 0.0) * reach.unit)
