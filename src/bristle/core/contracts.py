r"""The contracts: all step functions have the arguments *state, memory, inputs, dt, parameters*, in this order.

========== ==================================================================================================
hysteresis ``trial(state, memory, u, p) -> (w, move)``, ``commit(state, memory, move, p) -> state``
friction   ``trial(state, memory, motion, dt, p) -> (force, move)``, ``commit(state, memory, move, p) -> state``
plant      ``port(state, effort, dt, p) -> (a, b)``, ``step(state, effort, force, dt, p) -> (output, state)``,
           ``rest(state, effort, dt, p) -> state``
controller ``step(state, reference, measured, dt, p) -> (effort, state)``
sensor     ``step(state, x, dt, p) -> (measured, state)``
========== ==================================================================================================

A `Component` is a frozen descriptor: data plus pure functions. Its `Parameters` and `State` are NamedTuples whose
fields carry a `Variable`. Called with values, a component returns a `Model`: the component with validated
parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

import numpy as np

from bristle.core import dispatch
from bristle.core.documented import Documented, Redundancy, Relation, WithParameters  # noqa: F401
from bristle.core.errors import InputError
from bristle.core.motion import (
    NOMINAL_LOAD as NOMINAL_LOAD,
    NOMINAL_TEMPERATURE as NOMINAL_TEMPERATURE,
    NOT_KNOWN as NOT_KNOWN,
    NOTHING_TRANSMITTED as NOTHING_TRANSMITTED,
    STILL as STILL,
    Motion as Motion,
    Reference as Reference,
    Screw as Screw,
)
from bristle.core.packing import pack
from bristle.core.read_only import ReadOnly
from bristle.core.tabular import of_upper_layer
from bristle.core.typography import typed
from bristle.core.values import check_relations, check_value, coerced, looked_at
from bristle.core.variable import KINDS, Kind


@dataclass(frozen=True, kw_only=True)
class Component(Documented):
    """Base class of models, plants, control laws, sensors and references: their names, types of data and source.

    Parameters
    ----------
    name : str
        Name in files and on the command line.
    description : str
        Description in one line.
    Parameters, State : type
        NamedTuples; every field is annotated with a `Variable`.
    reference : str
        Source with DOI.
    relations : tuple of Relation
        Conditions between parameters.
    redundancies : tuple of Redundancy
        Parameters that act only as a factor of other parameters.
    example : mapping
        Typical values of the parameters, in SI units of a translational axis, for docs and the contract suite.
    """

    functions: ClassVar[tuple[str, ...]] = ()
    optional: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        functions = {name: getattr(self, name) for name in (*self.functions, *self.optional)}
        dispatch.register(
            self.family,
            self.Parameters,
            {name: function for name, function in functions.items() if function is not None},
        )

    def __reduce__(self) -> tuple[Any, ...]:
        made_by = self._made_by()
        if made_by is not None and made_by[0](*made_by[1]) is self:
            return made_by
        return super().__reduce__()

    def _made_by(self) -> tuple[Callable[..., Component], tuple[Any, ...]] | None:
        """Return the cached factory of this component and its arguments; None without a factory."""
        return None

    def initial_state(self, parameters: Any) -> Any:
        """Return the virgin state."""
        return self.State()

    def __call__(self, *, kind: Kind | None = None, validate: bool = True, **values: Any) -> Model:
        """Return this component with its parameters.

        Parameters
        ----------
        kind : {"translational", "rotational"}, optional
            Kind of axis; by default from the units of the values, or else translational.
        validate : bool
            False accepts values that violate a range or a relation, for studies of failures. The lengths of arrays
            must fit the model in any case.
        **values
            Parameters by name: numbers in SI, or text with a unit such as ``"40 mN*m"``.

        Returns
        -------
        Model
            The component with parameters.

        Raises
        ------
        InputError
            If a name is unknown or missing, a unit does not fit, or a value or a relation is out of range.
        """
        return make_model(self, values, kind=kind, validate=validate)


@dataclass(frozen=True, kw_only=True)
class HysteresisOperator(Component):
    """A rate-independent hysteresis operator: its output depends on the path of the input, not on its speed.

    ``trial(state, memory, u, p) -> (w, move)`` is pure: it returns the output at the input `u`, reached in one monotone
    move, and the data for `commit`. ``commit(state, memory, move, p) -> state`` is called once for each accepted move. Only
    `commit` writes ``memory``, a 1-D array of ``memory_size(p)`` numbers. A virgin operator is at the input 0.
    Operators with an Everett function also provide ``measure(p)``, on whose type `everett` and similar functions dispatch.
    ``input`` and ``output`` are generalised quantities. A ``State`` that can lose memory counts the losses in ``lost``.
    """

    trial: Callable[..., Any]
    commit: Callable[..., Any]
    memory_size: Callable[[Any], int] = field(default=lambda p: 0)
    measure: Callable[[Any], Any] | None = None
    input: str = "length"
    output: str = "force"

    family: ClassVar[str] = "hysteresis"
    functions: ClassVar[tuple[str, ...]] = ("trial", "commit")
    optional: ClassVar[tuple[str, ...]] = ("measure",)

    def new_memory(self, parameters: Any) -> np.ndarray:
        """Return the memory of a virgin operator, shape (memory_size,)."""
        return np.zeros(self.memory_size(parameters))


@dataclass(frozen=True, kw_only=True)
class FrictionModel(Component):
    """A friction model.

    ``trial(state, memory, motion, dt, p) -> (force, move)`` is pure: it returns the mean force over a step at constant
    velocity ``motion.v``, positive when it opposes ``v > 0``, and the data for `commit`. ``v = +0.0`` and ``-0.0`` give the
    two one-sided limits, so that a set-valued model needs no flag. ``commit(state, memory, move, p) -> state`` is called
    once for each accepted step. Only `commit` writes ``memory``, a 1-D array (or ``()``) of ``memory_size(p)`` numbers.

    The same equations in continuous time are optional: ``rate(state, motion, p) -> (force, d_state)`` for a smooth model.
    A model that is smooth between events has three functions. ``piece(state, memory, motion, p) -> (contact, piece)``
    separates variables from constants, including the ``side`` of the motion. ``flow(contact, piece, motion, p) -> (force,
    d_contact, margin)`` is smooth beyond the event, too; at the event the margin falls below zero. ``arrival(state, memory,
    contact, p) -> move`` is the move to commit at the event.

    Optional too is ``trial_sided(state, memory, motion, dt, backward, forward)``, for models whose parameters depend on the
    direction of the deflection of the contact instead of the direction of motion. Models whose unknown state before a log
    matters have ``start(place, backward, forward) -> state``: the possible states, for a place from -1 to 1.
    """

    trial: Callable[..., Any]
    commit: Callable[..., Any]
    memory_size: Callable[[Any], int] = field(default=lambda p: 0)
    rate: Callable[..., Any] | None = None
    piece: Callable[..., Any] | None = None
    flow: Callable[..., Any] | None = None
    arrival: Callable[..., Any] | None = None
    trial_sided: Callable[..., Any] | None = None
    start: Callable[..., Any] | None = None
    linear: bool = False

    family: ClassVar[str] = "friction"
    functions: ClassVar[tuple[str, ...]] = ("trial", "commit")
    optional: ClassVar[tuple[str, ...]] = ("rate", "piece", "flow", "arrival", "trial_sided")

    def over(self, operator: Model, path: str = "kernel") -> tuple[FrictionModel, dict[str, Any]]:
        """Return this model with a hysteresis operator in place of its kernel, and the values to set then.

        Raises
        ------
        InputError
            If the model has no kernel, or the operator cannot be one.
        """
        made_by = self._made_by()
        if made_by is None:
            raise InputError(
                "the friction model has no kernel that an operator can replace",
                path=path,
                value=operator.name,
            )
        factory, (inner, *further) = made_by
        component, values = inner.over(operator, path)
        outer: Any = factory(component, *further)
        return outer, values

    @property
    def surroundings(self) -> tuple[Any, ...]:
        """Surroundings that its slots depend on."""
        return getattr(getattr(self, "inner", None), "surroundings", ())

    def new_memory(self, parameters: Any) -> np.ndarray:
        """Return the memory of a virgin model, shape (memory_size,)."""
        return np.zeros(self.memory_size(parameters))


@dataclass(frozen=True, kw_only=True)
class Plant(Component):
    """A mechanism on which friction acts through a port that is affine in the friction force.

    ``port(state, effort, dt, p) -> (a, b)``: the mean velocity over the step is ``a + b * force``, with ``b < 0``.
    ``step(state, effort, force, dt, p) -> (output, state)`` uses the mean force of the step.
    ``rest(state, effort, dt, p) -> state`` keeps the port at a velocity of exactly zero.
    ``rate(state, effort, force, p) -> d_state`` is optional: the same equations in continuous time.
    ``inverse(x, v, a, p) -> effort`` is the effort of a motion without friction, for arrays; linear in the parameters.
    Fields ``x`` and ``v`` of its `State` are the position and velocity at the port.
    A plant with a second port has ``screw(p)``: the screw between the first port and the friction of its table.
    """

    port: Callable[..., Any]
    step: Callable[..., Any]
    rest: Callable[..., Any]
    rate: Callable[..., Any] | None = None
    screw: Callable[[Any], Screw] | None = None
    inverse: Callable[..., Any] | None = None

    family: ClassVar[str] = "plant"
    functions: ClassVar[tuple[str, ...]] = ("port", "step", "rest")
    optional: ClassVar[tuple[str, ...]] = ("rate",)


@dataclass(frozen=True, kw_only=True)
class Controller(Component):
    """A sampled control law: ``step(state, reference, measured, dt, p) -> (effort, state)``.

    ``start(measured, velocity, acceleration, dt, p) -> state`` is the state of a controller that takes over a motion.
    ``resume(state, reference, measured, effort, dt, p) -> state`` is optional, for a controller with an integral or a
    memory of its reference: the state after it has followed the reference and applied an effort (`NOT_KNOWN`, a NaN, if
    unknown). All three are kernels, so exported control laws start in the same way. ``learned(state, p) -> p`` is optional,
    for a law that learns: the parameters with which the next run begins.
    """

    step: Callable[..., Any]
    start: Callable[..., Any]
    resume: Callable[..., Any] | None = None
    learned: Callable[[Any, Any], Any] | None = None

    family: ClassVar[str] = "controller"
    functions: ClassVar[tuple[str, ...]] = ("step",)


@dataclass(frozen=True, kw_only=True)
class Sensor(Component):
    """A sensor: ``step(state, x, dt, p) -> (measured, state)``."""

    step: Callable[..., Any]

    family: ClassVar[str] = "sensor"
    functions: ClassVar[tuple[str, ...]] = ("step",)


@dataclass(frozen=True, kw_only=True)
class Trajectory(Component):
    """A desired motion: ``sample(t, p) -> (position, velocity, acceleration)``, arrays of the shape of `t` [s]."""

    sample: Callable[..., Any]

    family: ClassVar[str] = "reference"
    functions: ClassVar[tuple[str, ...]] = ("sample",)


@dataclass(frozen=True, eq=False)
class Model(WithParameters):
    """A component and its parameters, which are also attributes. Two models are equal if their component, kind and numbers are equal.

    Parameters
    ----------
    component : Component
        The descriptor.
    parameters : NamedTuple
        Parameters of the kernels, in SI units.
    kind : {"translational", "rotational"}
        The kind of axis.
    """

    component: Any
    parameters: Any
    kind: Kind = "translational"

    def __reduce__(self) -> tuple[Any, ...]:
        # The component comes first, because unpickling it defines the classes of its parameters.
        return type(self), (self.component, self.parameters, self.kind)

    @property
    def name(self) -> str:
        """Name of the component, with its slots."""
        return self.component.name

    @property
    def values(self) -> ReadOnly[str, Any]:
        """User parameters in SI units; read-only, use `with_values` for changes."""
        return ReadOnly(self.component.values(self.parameters))

    def with_values(self, **changes: Any) -> Model:
        """Return the model with changed parameters, validated again."""
        return make_model(self.component, self.values | changes, kind=self.kind, validate=True)

    def __eq__(self, operand: object) -> bool:
        return isinstance(operand, Model) and self._identity == operand._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[str, str, type, Kind, bytes]:
        component = self.component
        return (
            component.family,
            component.name,
            component.Parameters,
            self.kind,
            pack(self.parameters).tobytes(),
        )

    def __repr__(self) -> str:
        variables = self.component.variables
        parts = [
            f"{k}={typed(v)} {variables[k].unit(self.kind)}".removesuffix(" 1")
            for k, v in self.values.items()
        ]
        return f"{self.name}({', '.join(parts)})"

    _repr_html_ = of_upper_layer("bristle.report.notebook", "as_html")
    _repr_mimebundle_ = of_upper_layer("bristle.report.notebook", "bundle")


def make_model(
    component: Component,
    values: Mapping[str, Any],
    *,
    kind: Kind | None,
    validate: bool,
    related: bool = True,
    path: str = "",
) -> Model:
    """Return `component` with validated parameters; `path` is the prefix of names in error messages."""
    from bristle.core import units

    prefix = f"{path}." if path else ""
    if isinstance(component, FrictionModel) and isinstance(values.get("kernel"), Model):
        component, values, kind = _over_operator(component, values, kind, prefix)
    variables = component.variables
    for name in values:
        if name not in variables:
            raise InputError(
                f"{component.name} has no such parameter",
                path=prefix + name,
                allowed=", ".join(variables),
            )
    kinds = (*KINDS, "magnetic", "piezo") if component.family == "hysteresis" else KINDS
    if not isinstance(validate, bool):
        raise InputError("must be True or False", path=f"{prefix}validate", value=validate)
    if kind is not None and not (isinstance(kind, str) and kind in kinds):
        raise InputError(
            "unknown kind of axis", path=f"{prefix}kind", value=kind, allowed=" or ".join(kinds)
        )
    missing = [name for name in variables if name not in values and name not in component.defaults]
    if missing:
        mend = f"Give {missing[0]} ({variables[missing[0]].description} [{variables[missing[0]].unit(kind or 'translational')}])"
        raise InputError(
            f"{component.name} needs {', '.join(missing)}", path=path or component.name, mend=mend
        )
    chosen: Kind = kind or units.kind_of(values, variables)
    numbers: dict[str, Any] = {}
    for name, variable in variables.items():
        raw = values.get(name, component.defaults.get(name))
        numbers[name] = looked_at(
            partial(coerced, component, name, variable), raw, f"{prefix}{name}", chosen
        )
        if validate:
            check_value(component, name, variable, numbers[name], chosen, f"{prefix}{name}")
    parameters = component.assemble(numbers)
    check_relations(
        component, parameters, path or component.name, structural_only=not (validate and related)
    )
    return Model(component, parameters, chosen)


def _over_operator(
    component: FrictionModel, values: Mapping[str, Any], kind: Kind | None, prefix: str
) -> tuple[FrictionModel, dict[str, Any], Kind]:
    """Return a friction model with an operator as its kernel, and the values of both."""
    path, operator = f"{prefix}kernel", values["kernel"]
    if kind is not None and kind != operator.kind:
        raise InputError(
            f"is a {operator.kind} operator, but this friction is {kind}",
            path=path,
            value=operator.name,
            mend="Use an operator for the same kind of axis",
        )
    composed, fixed = component.over(operator, path)
    for name in fixed:
        if name in values and name != "kernel":
            raise InputError(
                "is already set by the operator",
                path=f"{prefix}{name}",
                value=values[name],
                mend=f"Remove {name}",
            )
    return (
        composed,
        {name: value for name, value in values.items() if name != "kernel"} | fixed,
        operator.kind,
    )


def example_of(component: Component) -> Model:
    """Return a model with the example parameters of its descriptor, or the nominal value of each."""
    values: dict[str, Any] = dict(component.example)
    for name, variable in component.variables.items():
        if name not in values and name not in component.defaults:
            number = min(max(variable.nominal, variable.min), variable.max)
            values[name] = [number] if component.is_array(name) else number
    return make_model(component, values, kind="translational", validate=True, path="example")
