"""The control law of a loop as one kernel: its start, its feedforward, and the command of its controller.

The kernel is generated as text, because the feedforward differs from loop to loop, and becomes a tree like any kernel.
At the first sample the law takes over the desired motion, and a compensator that leads by a delay advances to its
place. Therefore every target starts like a simulation, without a given state. The description of a law in its files and
the walk of its self-test are the same for all targets.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from bristle.core import InputError, Variable, kernel, unit_of, variables_of
from bristle.core.contracts import (
    NOMINAL_LOAD,
    NOMINAL_TEMPERATURE,
    NOT_KNOWN,
    Model,
    Motion,
    Reference,
)
from bristle.core.experiment import FEEDFORWARD, Variant
from bristle.engine.screwed import of_travel
from bristle.engine.translation.build import Builder
from bristle.engine.translation.scope import NotExportableError, defined, is_kernel
from bristle.engine.translation.tree import (
    REAL,
    TRUTH,
    Array,
    Function,
    Struct,
    Type,
    Unit,
    struct_type,
    type_of,
)
from bristle.exports.described import (
    Source,
    command_facts,
    digest_over,
    parameter_table,
    plain,
    version,
)
from bristle.exports.law_text import ALWAYS, law_text, loads_of, samples_of_wind_up
from bristle.exports.printing import loops_of
from bristle.exports.settled import fact_of, pruned, settled
from bristle.exports.subject import Walk, places_of, subject_of, walk_of, walk_over
from bristle.exports.tunable import CONSTANTS, TOLERANCE, Tunable, refuse_beyond_single, tunable_of
from bristle.models.controllers.feedforward import Shape, compensate
from bristle.models.controllers.law import law
from bristle.models.controllers.limits import within_drive
from bristle.models.controllers.wind_up import (
    AROUND,
    WindUp,
    Wound,
    bend_at,
    lead_at,
    rate_at,
    wind,
    winding_effort,
)
from bristle.models.friction.level import rises_with_effort
from bristle.models.friction.resting import with_rest
from bristle.models.plants.terms import effort_at, gravity_at
from bristle.prediction.drive_units import command_units
from bristle.simulation.compensation import shape_of
from bristle.simulation.run import planned_motion
from bristle.simulation.two_masses import screw_of, table_of, table_shape, whole_inertia, wind_up_of


class Fed(NamedTuple):
    """A compensator between two samples: the state of its friction model, its position, share and last effort."""

    state: Any
    place: Annotated[float, Variable("length", "position of the compensator")]
    share: Annotated[float, Variable("1", "share of the contact force that is fed forward")]
    effort: Annotated[float, Variable("force", "friction fed forward")]


class NoCompensator(NamedTuple):
    """Placeholder for a law without a compensator."""


class Lasting(NamedTuple):
    """State of a law between samples."""

    controller: Any
    fed: Any


class Parameters(NamedTuple):
    """Parameters of a law: controller, largest effort of the drive, and feedforward."""

    controller: Any
    limit: float
    mass: float
    friction: Any
    shape: Shape


class PlacedParameters(NamedTuple):
    """Parameters of a law with an effort that depends on position, or with a transmitted effort that is not fed forward."""

    controller: Any
    limit: float
    mass: float
    friction: Any
    shape: Shape
    place: Any
    carried_mass: float
    carried_place: Any


class LeadingLasting(NamedTuple):
    """State between samples of a law with the wind-up of a screw."""

    controller: Any
    fed: Any
    table: Any
    wound: Any


class LeadingParameters(NamedTuple):
    """Parameters of a law with the wind-up of a screw; `total_inertia` that of both masses [kg*m^2]."""

    controller: Any
    limit: float
    mass: float
    friction: Any
    shape: Shape
    screw: Any
    table: Any
    table_shape: Shape
    total_inertia: float


class NoPlace(NamedTuple):
    """Placeholder for a law without an effort that depends on position."""


@kernel
def led(fed, memory, place, transmitted, dt, shape, p):
    """Return the compensator after a step of `dt` [s] to a position [m or rad]."""
    motion = Motion((place - fed.place) / dt, place, NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted)
    effort, share, state = compensate(
        fed.state, memory, motion, fed.share, fed.effort, dt, shape, p
    )
    return Fed(state, place, share, effort)


@kernel
def inertial(acceleration, following, mass):
    """Return the effort [N or N*m] of inertia between two samples of the desired acceleration."""
    return mass * 0.5 * (acceleration + following)


@kernel
def pulled(table, wound, table_memory, leads, place, before, after, first, dt, p):
    """Return the compensator of the table and the wind-up after a step to a position [rad], between two accelerations [rad/s^2]."""
    passed = p.screw.M * p.screw.arm * (0.5 * (before + after))
    table = led(table, table_memory, p.screw.arm * place, passed, dt, p.table_shape, p.table)
    return table, wind(wound, leads, passed + table.effort, first, p.screw)


KERNELS = (
    led,
    inertial,
    pulled,
    law,
    effort_at,
    gravity_at,
    lead_at,
    rate_at,
    bend_at,
    winding_effort,
)


class Inputs(NamedTuple):
    """Inputs of a law at a sample, in SI units of the axis; `_ahead` arrays belong to the next samples."""

    position: float
    velocity: float
    acceleration: float
    measured: float
    place_ahead: np.ndarray
    acceleration_ahead: np.ndarray


@dataclass(frozen=True)
class Law:
    """The law of a variant as a function of the tree, with its initial state."""

    variant: Variant
    controller: Model
    unit: Unit
    entry: Function
    written: Callable[..., Any]
    arguments: tuple[str, ...]
    inputs: tuple[str, ...]
    samples_ahead: int
    lasting: Lasting | LeadingLasting
    p: Any
    memories: Mapping[str, np.ndarray]
    tunable: bool = False
    single: bool = False

    @property
    def types(self) -> tuple[Struct, Struct]:
        """Types of the state and of the parameters."""
        return struct_type(self.lasting), struct_type(self.p)

    @property
    def memory(self) -> np.ndarray:
        """All memories before the first sample, one after another."""
        return np.concatenate([*self.memories.values(), np.zeros(0)])

    @property
    def memory_size(self) -> int:
        """Numbers in all memories."""
        return self.memory.size

    @property
    def memory_at(self) -> dict[str, int]:
        """Place of the first number of each memory among all."""
        return places_of({name: memory.size for name, memory in self.memories.items()})

    @property
    def leaves(self) -> list[tuple[tuple[str, ...], Type]]:
        """Path and type of each number of the state."""

        def inside(kind: Struct, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Type]]:
            for name, part in kind.fields:
                if isinstance(part, Struct):
                    yield from inside(part, (*path, name))
                else:
                    yield (*path, name), part

        return list(inside(self.types[0], ()))

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.variant.run.sample_time

    def efforts(self, samples: Sequence[Inputs]) -> np.ndarray:
        """Return the command of the law at each sample [N or N*m], computed by the uncompiled kernels."""
        lasting = self.lasting
        efforts = np.zeros(len(samples))
        memories = {name: memory.copy() for name, memory in self.memories.items()}
        for k, sample in enumerate(samples):
            handed = {
                **sample._asdict(),
                **memories,
                "dt": self.dt,
                "p": self.p,
                "begun": k > 0,
                "lasting": lasting,
            }
            efforts[k], lasting = self.written(*[handed[name] for name in self.arguments])
        return efforts


def law_of(variant: Variant, *, tunable: bool = False, single: bool = False) -> Law:
    """Return the control law of a variant: its controller and its feedforward, along the desired or the measured motion."""
    for name, reason in (
        ("effort", "drives an open loop, which has no law"),
        ("learning", "needs repetitions of the whole motion"),
    ):
        if getattr(variant, name) is not None:
            raise InputError(
                f"{reason}, so bristle cannot export it", path=f"{variant.name}.{name}"
            )
    # A law starts at the position of the axis, without the initial motion of a simulated loop.
    variant = replace(variant, start=None)
    feedforward = variant.feedforward
    sides = {"friction": feedforward.friction, "table": feedforward.table}
    rested = {
        side: with_rest(friction, feedforward.rest)
        for side, friction in sides.items()
        if friction is not None
    }
    variant = replace(variant, feedforward=replace(feedforward, **rested))
    controller = within_drive(variant.controller, variant.run.effort_limit)
    feedforward = variant.feedforward
    ahead = variant.run.delay + 1
    friction = feedforward.friction
    table = table_of(feedforward)
    screw = screw_of(feedforward)
    component = controller.component
    for function in (component.start, component.step, component.resume):
        if function and not is_kernel(function):
            raise NotExportableError(
                function, None, "is not a kernel: decorate it with @kernel from bristle.core"
            )
    along_desired = friction is not None and feedforward.along == "desired"
    fed, carried = loads_of(feedforward, apart=tunable)
    needed = {
        "place_ahead": screw or along_desired or fed.place or carried.place,
        "acceleration_ahead": screw or fed.mass or carried.mass,
    }
    inputs = (*ALWAYS, *(name for name, reason in needed.items() if reason))
    # Initial states and memories of the compensators.
    memories = {}
    started = component.start(0.0, 0.0, 0.0, variant.run.sample_time, controller.parameters)
    lasting = Lasting(started, NoCompensator())
    shape = Shape(*map(float, shape_of(feedforward)))
    compensator = NoCompensator()
    if friction is not None:
        state, memories["memory"] = _initial(friction, feedforward.conditioning)
        lasting = Lasting(started, Fed(state, 0.0, 0.0, 0.0))
        compensator = friction.parameters
    of_all = (controller.parameters, float(variant.run.effort_limit), fed.mass, compensator, shape)
    p: Any = Parameters(*of_all)
    if fed.place or carried is not fed:
        p = PlacedParameters(
            *of_all, fed.place or NoPlace(), carried.mass, carried.place or NoPlace()
        )
    weights = 0
    if screw is not None and feedforward.plant is not None:
        # The numbers that depend on the motion are those of the experiment.
        position, _, acceleration = planned_motion(variant)
        wind_up = wind_up_of(feedforward, screw, position, acceleration, variant.run.sample_time)
        weights = wind_up.weights.size
        ahead = samples_of_wind_up(weights, variant.run.delay)
        state, memories["table_memory"] = _initial(table, feedforward.conditioning * screw.arm)
        memories["leads"] = np.zeros(weights + 2 * AROUND + 1 + variant.run.delay)
        lasting = LeadingLasting(*lasting, Fed(state, 0.0, 0.0, 0.0), Wound())
        inertia = whole_inertia(feedforward.plant, screw, variant.run.sample_time)
        p = LeadingParameters(*of_all, wind_up, table.parameters, table_shape(feedforward), inertia)
    constants = {}
    if single:
        constants = CONSTANTS
        refuse_beyond_single(p._asdict())
    arguments = ("lasting", *memories, *inputs, "begun", "dt", "p")
    text = law_text(arguments, variant, fed, carried, weights)
    called = (*KERNELS, Fed, Lasting, LeadingLasting, Reference)
    scope = {function.__name__: function for function in called}
    scope |= {"__name__": __name__, "NOT_KNOWN": NOT_KNOWN}
    scope |= {"start": component.start, "resume": component.resume}
    written = defined("command", text, scope)
    kinds = {
        "lasting": type_of(lasting),
        "begun": TRUTH,
        "p": type_of(p),
        "place_ahead": Array(ahead),
        "acceleration_ahead": Array(ahead),
    }
    kinds |= {name: Array(memory.size, writable=True) for name, memory in memories.items()}
    builder = Builder(constants)
    entry = builder.function(written, [kinds.get(name, REAL) for name in arguments])
    return Law(
        variant,
        controller,
        pruned(builder.unit, [entry]),
        entry,
        written,
        arguments,
        inputs,
        ahead,
        lasting,
        p,
        memories,
        tunable,
        single,
    )


def _initial(friction: Model, conditioning: float) -> tuple[Any, np.ndarray]:
    """Return the state and the memory of a compensator before the first sample."""
    if conditioning > 0.0:
        from bristle.engine import conditioned

        return conditioned(friction, conditioning)
    return friction.component.initial_state(friction.parameters), friction.component.new_memory(
        friction.parameters
    )


PER_VELOCITY = 100.0  # Acceleration of the self-test over its velocity [1/s]
INPUTS = {
    "position": ("desired position", "length"),
    "velocity": ("desired velocity", "length/time"),
    "acceleration": ("desired acceleration", "length/time^2"),
    "measured": ("position as the sensor reads it", "length"),
    "place_ahead": ("desired positions of the next samples, the nearest first", "length"),
    "acceleration_ahead": (
        "desired accelerations of the next samples, the nearest first",
        "length/time^2",
    ),
}


def law_facts(law: Law, name: str, source: Source) -> dict[str, Any]:
    """Return the facts of a law for the templates."""
    variant = law.variant
    kind = variant.controller.kind
    friction = variant.feedforward.friction
    table = variant.feedforward.table
    frictions = {}
    if friction:
        frictions = {
            f"{plain(friction.name)}, fed forward along the {variant.feedforward.along} motion": friction
        }
    if table:
        frictions |= {
            f"{plain(table.name)}, fed forward along the desired motion of the table": table
        }
    inputs = []
    for fed in law.inputs:
        several = fed.endswith("_ahead")
        declared = fed
        if several:
            declared = f"{fed}[{law.samples_ahead}]"
        unit = unit_of(INPUTS[fed][1], kind)
        inputs.append(
            {
                "name": fed,
                "declared": declared,
                "told": INPUTS[fed][0],
                "unit": unit,
                "several": several,
            }
        )
    limit = ""
    if np.isfinite(variant.run.effort_limit):
        limit = f"{variant.run.effort_limit:g}"
    return (
        {
            "name": name,
            "version": version(),
            "title": plain(f"Control law of an axis: {variant.controller.name}"),
        }
        | {
            "variant": plain(variant.name),
            "description": plain(variant.controller.component.description),
            "facts": source.lines,
        }
        | {"table": parameter_table(law.controller, source).rstrip(), "fed": _fed(law)}
        | {
            "leads": "table" in law.lasting._fields
            or bool(friction and variant.feedforward.along == "desired")
        }
        | {
            "frictions": {
                title: parameter_table(model, source).rstrip() for title, model in frictions.items()
            }
        }
        | {
            "unit_force": unit_of("force", kind),
            "unit_x": unit_of("length", kind),
            "dt": repr(law.dt),
            "rate": f"{1.0 / law.dt:g}",
        }
        | {"ahead": law.samples_ahead, "delay": variant.run.delay, "limit": limit, "inputs": inputs}
        | {
            "drive": command_facts(command_units(variant.axis, kind), kind),
            "loops": loops_of(law.unit, law.memory_size),
        }
        | {
            "single": law.single,
            "tunable": law.tunable,
            "result": "effort",
            "allowed": f"{TOLERANCE:g}",
            "several_places": True,
        }
    )


def law_walk(law: Law, steps: int) -> tuple[Walk, int, np.ndarray]:
    """Return the walk of the self-test of a law, the number of its positions, and the efforts along it."""
    friction = law.variant.feedforward.friction
    # Distance of the walk in the self-test of a law without a compensator [m or rad].
    if friction is None:
        walk = walk_over(1e-5, law.dt)
    else:
        walk = walk_of(subject_of(friction), law.dt)
    return walk, steps + law.samples_ahead + 1, law.efforts(samples_along(walk, law, steps))


def samples_along(walk: Walk, law: Law, steps: int) -> list[Inputs]:
    """Return the inputs of a law along a walk."""
    ahead = law.samples_ahead
    x = walk.positions(steps + ahead + 1)
    v = np.diff(x) / law.dt
    a = PER_VELOCITY * v
    at = x.tolist()
    speed = v.tolist()
    change = a.tolist()
    return [
        Inputs(
            at[k],
            speed[k],
            change[k],
            at[max(k - 1, 0)],
            x[k + 1 : k + 1 + ahead],
            a[k + 1 : k + 1 + ahead],
        )
        for k in range(steps)
    ]


def _fed(law: Law) -> list[str]:
    """Return the parts of the feedforward, one line each."""
    feedforward = law.variant.feedforward
    kind = law.variant.controller.kind
    fed, carried = loads_of(feedforward)
    lines = []
    if feedforward.mass:
        lines = [f"inertia along the desired motion: {feedforward.mass:g} {unit_of('mass', kind)}"]
    if isinstance(law.p, LeadingParameters):
        half = law.p.screw.weights.size // 2
        clear = law.p.screw.clear
        lines += [
            "both masses and the wind-up of the screw along the desired motion of the table, converted to the motor",
            f"the wind-up is a mean over {half} samples ({1e3 * half * law.dt:g} ms) before and after each sample",
            f"the motor changes the flank of the screw at a force beyond {clear:.4g} N",
            "both numbers are those of the motion of the experiment, and wind_up_time sets the mean",
        ]
        if feedforward.table is not None:
            lines.append(
                f"friction of the table along the desired motion by {feedforward.table.name}"
            )
    if fed.place and feedforward.plant is not None:
        lines.append(
            f"position-dependent effort of {feedforward.plant.name}, along the desired motion"
        )
    if feedforward.friction is not None:
        shape = [
            f", {name} {value:g}"
            for name, value in law.p.shape._asdict().items()
            if value != Shape._field_defaults[name]
        ]
        lines.append(
            f"friction along the {feedforward.along} motion by {feedforward.friction.name}"
            + "".join(shape)
        )
        if rises_with_effort(feedforward.friction):
            plant = feedforward.carries
            if carried is fed:
                plant = None
            passing = "the rest of the feedforward"
            if plant is not None:
                passing = plant.name
            lines.append(
                f"the friction level rises with the effort that {passing} transmits along the desired motion"
            )
    return [plain(line) for line in lines] or ["nothing"]


def hash_of_law(law: Law) -> str:
    """Return the SHA-256 of a control law whose parameters are fixed, in double precision."""
    start = [law.lasting, law.memory, law.dt, float(law.samples_ahead)]
    return digest_over(law.controller.name, law.controller.kind, law.unit.functions, start, law.p)


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
    fed = {}
    if law.p.mass:
        fed = {("mass",): law.p.mass}
    if friction is not None:
        fed |= {("shape", name): value for name, value in _tunable_shape(law.p.shape).items()}
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
        values[name] = value
        variables[name] = further[path[-1]]
        places[path] = name
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
    places = ()
    if law.tunable:
        places = tunable_law(law).places
    fact = fact_of(law.p, law.types[1], places)
    unit, (entry,) = settled(law.unit, [law.entry], {"p": fact}, single=law.single)
    return replace(law, unit=unit, entry=entry)
