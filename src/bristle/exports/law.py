"""The control law of a loop as one kernel: its start, its feedforward, and the command of its controller.

The kernel is generated as text, because the feedforward differs from loop to loop, and becomes a tree like any kernel.
At the first sample the law takes over the desired motion, and a compensator that leads by a delay advances to its
place. Therefore every target starts like a simulation, without a given state. The description of a law in its files and
the walk of its self-test are the same for all targets.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from bristle.controllers.feedforward import Shape, compensate
from bristle.controllers.law import law
from bristle.controllers.limits import within_drive
from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOT_KNOWN, Model, Motion, Reference
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward, Variant
from bristle.core.kernel import kernel
from bristle.core.variable import Variable, unit_of
from bristle.exports.described import Source, command_facts, parameter_table, plain, version
from bristle.exports.printing import loops_of
from bristle.exports.settled import pruned
from bristle.exports.subject import Walk, subject_of, walk_of, walk_over
from bristle.exports.tunable import CONSTANTS, TOLERANCE, refuse_beyond_single
from bristle.friction.level import rises_with_effort
from bristle.friction.resting import with_rest
from bristle.plants import inertia
from bristle.plants.terms import Place, Termed, effort_at, gravity_at, place_of
from bristle.prediction.drive_units import command_units
from bristle.simulation.two_masses import plant_of_one_mass
from bristle.translation.build import Builder
from bristle.translation.scope import NotExportableError, defined, is_kernel
from bristle.translation.tree import REAL, TRUTH, Array, Function, Struct, Type, Unit, struct_type, type_of


class Gravity(NamedTuple):
    """Gravity of a link [N or N*m], of a plant without cogging."""

    g_sin: float
    g_cos: float


class Load(NamedTuple):
    """An effort along the desired motion, of inertia and of position, and the prefix of its parameters."""

    prefix: str
    mass: float
    place: Any

    @property
    def numbers(self) -> tuple[float, ...]:
        """All numbers of the effort."""
        return (self.mass, *(float(number) for part in self.place or () for number in np.atleast_1d(part)))

    def text(self, before: str, after: str) -> str:
        """Return the effort between two samples as text, by their indices among the samples ahead; empty for the present one."""
        parts = []
        if self.mass:
            parts.append(f"inertial({_ahead('acceleration', before)}, acceleration_ahead[{after}], p.{self.prefix}mass)")
        if self.place:
            kernel_name = "effort_at" if isinstance(self.place, Place) else "gravity_at"
            middle = f"0.5 * ({_ahead('position', before)} + place_ahead[{after}])"
            parts.append(f"{kernel_name}({middle}, p.{self.prefix}place)")
        return " + ".join(parts) or "0.0"


def _ahead(name: str, place: str) -> str:
    ahead = f"{'place' if name == 'position' else name}_ahead[{place}]"
    return name if not place else f"({ahead} if i > 0 else {name})" if "i" in place else ahead


def loads_of(feedforward: Feedforward, *, apart: bool = False) -> tuple[Load, Load]:
    """Return the load that is fed forward in addition to friction, and the load that friction transmits, as one if equal."""
    fed = Load("", float(feedforward.mass), _place(plant_of_one_mass(feedforward)))
    carries = feedforward.carries
    if feedforward.friction is None or carries is None or not rises_with_effort(feedforward.friction):
        return fed, fed
    if (carries.component.inner if isinstance(carries.parameters, Termed) else carries.component) is not inertia:
        raise InputError(
            "has forces besides inertia, gravity, cogging and a spring, so bristle cannot export the law",
            path="feedforward.carries",
            value=carries.name,
            mend="Omit carries: the feedforward then defines the transmitted effort",
        )
    carried = Load("carried_", float(carries.values["M"]), _place(carries))
    return fed, fed if carried.numbers == fed.numbers and not apart else carried


def _place(plant: Model | None) -> Any:
    """Return the data of the position-dependent effort of a plant; None if it has no such effort."""
    place = place_of(plant)
    if not place.is_link:
        return place
    return Gravity(place.g_sin, place.g_cos) if place.g_sin or place.g_cos else None


class Fed(NamedTuple):
    """A compensator between two samples: the state of its friction model, its position, and its last effort."""

    state: Any
    place: Annotated[float, Variable("length", "position of the compensator")]
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


class NoPlace(NamedTuple):
    """Placeholder for a law without an effort that depends on position."""


@kernel
def led(fed, memory, place, transmitted, dt, shape, p):
    """Return the compensator after a step of `dt` [s] to a position [m or rad]."""
    motion = Motion((place - fed.place) / dt, place, NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted)
    effort, state = compensate(fed.state, memory, motion, fed.effort, dt, shape, p)
    return Fed(state, place, effort)


@kernel
def inertial(acceleration, following, mass):
    """Return the effort [N or N*m] of inertia between two samples of the desired acceleration."""
    return mass * 0.5 * (acceleration + following)


# Position, velocity, acceleration are desired; `begun` is false at the first sample. Indices of samples ahead count
# from the next sample.
HEAD = "def command({arguments}):\n    fed = lasting.fed"
AT_FIRST = """
    if not begun:
        fed = Fed(fed.state, {begins}, fed.effort)"""
BEFORE_THE_FIRST = """
        for i in range({delay}):
            fed = led(fed, memory, place_ahead[i], {to_come}, dt, p.shape, p.friction)"""
ALONG_DESIRED = """
    planned = {planned}
    fed = led(fed, memory, place_ahead[{delay}], {carried}, dt, p.shape, p.friction)
    planned = planned + fed.effort
    told = planned"""
ALONG_MEASURED = """
    planned = {planned}
    fed = led(fed, memory, measured, {carried}, dt, p.shape, p.friction)
    told = planned + fed.effort"""
NO_FRICTION = """
    planned = {planned}
    told = planned"""
CONTROLLED = """
    controller = lasting.controller
    if not begun:
        controller = start(measured, velocity, acceleration, dt, p.controller){resumed}
    reference = Reference(position, velocity, acceleration, told)
    effort, controller = law(controller, reference, measured, 0.0, p.limit, dt, p.controller)
    return effort, Lasting(controller, fed)
"""
RESUMED = """
        followed = Reference(position, velocity, acceleration, planned)
        controller = resume(controller, followed, measured, NOT_KNOWN, dt, p.controller)"""
ALWAYS = ("position", "velocity", "acceleration", "measured")


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
    lasting: Lasting
    p: Parameters | PlacedParameters
    memory: np.ndarray
    tunable: bool = False
    single: bool = False

    @property
    def types(self) -> tuple[Struct, Struct]:
        """Types of the state and of the parameters."""
        return struct_type(self.lasting), struct_type(self.p)

    @property
    def memory_size(self) -> int:
        """Numbers in the memory."""
        return self.memory.size

    @property
    def leaves(self) -> list[tuple[tuple[str, ...], Type]]:
        """Path and type of each number of the state."""

        def inside(kind: Struct, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Type]]:
            for name, part in kind.fields:
                yield from inside(part, (*path, name)) if isinstance(part, Struct) else [((*path, name), part)]

        return list(inside(self.types[0], ()))

    @property
    def dt(self) -> float:
        """Sample time [s]."""
        return self.variant.run.sample_time

    def efforts(self, samples: Sequence[Inputs]) -> np.ndarray:
        """Return the command of the law at each sample [N or N*m], computed by the uncompiled kernels."""
        lasting, memory, efforts = self.lasting, self.memory.copy(), np.zeros(len(samples))
        for k, sample in enumerate(samples):
            handed = {**sample._asdict(), "memory": memory, "dt": self.dt, "p": self.p, "begun": k > 0}
            handed["lasting"] = lasting
            efforts[k], lasting = self.written(*[handed[name] for name in self.arguments])
        return efforts


def law_of(variant: Variant, *, tunable: bool = False, single: bool = False) -> Law:
    """Return the control law of a variant: its controller and its feedforward, along the desired or the measured motion."""
    for name, reason in (("effort", "drives an open loop, which has no law"), ("learning", "needs repetitions of the whole motion")):
        if getattr(variant, name) is not None:
            raise InputError(f"{reason}, so bristle cannot export it", path=f"{variant.name}.{name}")
    # A law starts at the position of the axis, without the initial motion of a simulated loop.
    variant = replace(variant, start=None)
    feedforward = variant.feedforward
    if feedforward.friction is not None:
        rested = with_rest(feedforward.friction, feedforward.rest)
        variant = replace(variant, feedforward=replace(feedforward, friction=rested))
    controller = within_drive(variant.controller, variant.run.effort_limit)
    feedforward, ahead = variant.feedforward, variant.run.delay + 1
    friction = feedforward.friction
    component = controller.component
    for function in (component.start, component.step, *([component.resume] if component.resume else [])):
        if not is_kernel(function):
            raise NotExportableError(function, None, "is not a kernel: decorate it with @kernel from bristle.core")
    along_desired = friction is not None and feedforward.along == "desired"
    inputs = [*ALWAYS]
    fed, carried = loads_of(feedforward, apart=tunable)
    inputs += ["place_ahead"] if along_desired or fed.place or carried.place else []
    inputs += ["acceleration_ahead"] if fed.mass or carried.mass else []
    arguments = ("lasting", *(["memory"] if friction else []), *inputs, "begun", "dt", "p")
    text = _text(arguments, variant, fed, carried)
    # Initial state and memory of the compensator.
    state, memory = NoCompensator(), np.zeros(0)
    if friction is not None and feedforward.conditioning > 0.0:
        from bristle.engine import conditioned

        state, memory = conditioned(friction, feedforward.conditioning)
    elif friction is not None:
        state, memory = friction.component.initial_state(friction.parameters), friction.component.new_memory(friction.parameters)
    lasting = Lasting(
        component.start(0.0, 0.0, 0.0, variant.run.sample_time, controller.parameters),
        NoCompensator() if friction is None else Fed(state, 0.0, 0.0),
    )
    shape = Shape(*(float(getattr(feedforward, name)) for name in Shape._fields))
    compensator = NoCompensator() if friction is None else friction.parameters
    of_all = (controller.parameters, float(variant.run.effort_limit), fed.mass, compensator, shape)
    p: Parameters | PlacedParameters = Parameters(*of_all)
    if fed.place or carried is not fed:
        p = PlacedParameters(*of_all, fed.place or NoPlace(), carried.mass, carried.place or NoPlace())
    if single:
        refuse_beyond_single(p._asdict())
    called = {kernel.__name__: kernel for kernel in (led, inertial, law, effort_at, gravity_at)}
    scope = called | {"__name__": __name__, "Fed": Fed, "Lasting": Lasting, "Reference": Reference, "NOT_KNOWN": NOT_KNOWN}
    written = defined("command", text, scope | {"start": component.start, "resume": component.resume})
    kinds = {"lasting": type_of(lasting), "memory": Array(memory.size, writable=True), "begun": TRUTH, "p": type_of(p)}
    kinds |= {"place_ahead": Array(ahead), "acceleration_ahead": Array(ahead)}
    builder = Builder(CONSTANTS if single else {})
    entry = builder.function(written, [kinds.get(name, REAL) for name in arguments])
    unit, signals = pruned(builder.unit, [entry]), tuple(inputs)
    return Law(variant, controller, unit, entry, written, arguments, signals, ahead, lasting, p, memory, tunable, single)


def _text(arguments: Sequence[str], variant: Variant, fed: Load, carried: Load) -> str:
    """Return the text of the law."""
    feedforward, delay = variant.feedforward, variant.run.delay
    along_desired = feedforward.along == "desired"
    before = str(delay - 1) if delay else ""
    planned = fed.text(before, str(delay))
    passed = "planned" if carried is fed else carried.text(before, str(delay))
    text = HEAD.format(arguments=", ".join(arguments))
    if feedforward.friction is None:
        text += NO_FRICTION.format(planned=planned)
    else:
        text += AT_FIRST.format(begins="position" if along_desired else "measured")
        to_come = carried.text("i - 1", "i")
        text += BEFORE_THE_FIRST.format(delay=delay, to_come=to_come) if along_desired and delay else ""
        along = ALONG_DESIRED if along_desired else ALONG_MEASURED
        text += along.format(planned=planned, carried=passed, delay=delay)
    return text + CONTROLLED.format(resumed=RESUMED if variant.controller.component.resume else "")


PER_VELOCITY = 100.0  # Acceleration of the self-test over its velocity [1/s]
INPUTS = {
    "position": ("desired position", "length"),
    "velocity": ("desired velocity", "length/time"),
    "acceleration": ("desired acceleration", "length/time^2"),
    "measured": ("position as the sensor reads it", "length"),
    "place_ahead": ("desired positions of the next samples, the nearest first", "length"),
    "acceleration_ahead": ("desired accelerations of the next samples, the nearest first", "length/time^2"),
}


def law_facts(law: Law, name: str, source: Source) -> dict[str, Any]:
    """Return the facts of a law for the templates."""
    variant = law.variant
    kind, friction = variant.controller.kind, variant.feedforward.friction
    inputs = []
    for fed in law.inputs:
        several = fed.endswith("_ahead")
        declared, unit = f"{fed}[{law.samples_ahead}]" if several else fed, unit_of(INPUTS[fed][1], kind)
        inputs.append({"name": fed, "declared": declared, "told": INPUTS[fed][0], "unit": unit, "several": several})
    limit = variant.run.effort_limit
    return (
        {"name": name, "version": version(), "title": plain(f"Control law of an axis: {variant.controller.name}")}
        | {"variant": plain(variant.name), "description": plain(variant.controller.component.description), "facts": source.lines}
        | {"along": variant.feedforward.along if friction else "", "friction": plain(friction.name) if friction else ""}
        | {"table": parameter_table(law.controller, source).rstrip(), "fed": _fed(law)}
        | {"fed_table": parameter_table(friction, source).rstrip() if friction else ""}
        | {"unit_force": unit_of("force", kind), "unit_x": unit_of("length", kind), "dt": repr(law.dt), "rate": f"{1.0 / law.dt:g}"}
        | {"ahead": law.samples_ahead, "delay": variant.run.delay, "limit": f"{limit:g}" if np.isfinite(limit) else "", "inputs": inputs}
        | {"drive": command_facts(command_units(variant.axis, kind), kind), "loops": loops_of(law.unit, law.memory_size)}
        | {"single": law.single, "tunable": law.tunable, "result": "effort", "allowed": f"{TOLERANCE:g}", "several_places": True}
    )


def law_walk(law: Law, steps: int) -> tuple[Walk, int, np.ndarray]:
    """Return the walk of the self-test of a law, the number of its positions, and the efforts along it."""
    friction = law.variant.feedforward.friction
    # Distance of the walk in the self-test of a law without a compensator [m or rad].
    walk = walk_over(1e-5, law.dt) if friction is None else walk_of(subject_of(friction), law.dt)
    return walk, steps + law.samples_ahead + 1, law.efforts(samples_along(walk, law, steps))


def samples_along(walk: Walk, law: Law, steps: int) -> list[Inputs]:
    """Return the inputs of a law along a walk."""
    ahead = law.samples_ahead
    x = walk.positions(steps + ahead + 1)
    v = np.diff(x) / law.dt
    a = PER_VELOCITY * v
    at, speed, change = x.tolist(), v.tolist(), a.tolist()
    return [Inputs(at[k], speed[k], change[k], at[max(k - 1, 0)], x[k + 1 : k + 1 + ahead], a[k + 1 : k + 1 + ahead]) for k in range(steps)]


def _fed(law: Law) -> list[str]:
    """Return the parts of the feedforward, one line each."""
    feedforward, kind = law.variant.feedforward, law.variant.controller.kind
    fed, carried = loads_of(feedforward)
    lines = [f"inertia along the desired motion: {feedforward.mass:g} {unit_of('mass', kind)}"] if feedforward.mass else []
    if fed.place and feedforward.plant is not None:
        lines.append(f"position-dependent effort of {feedforward.plant.name}, along the desired motion")
    if feedforward.friction is not None:
        shape = [f", {name} {value:g}" for name, value in law.p.shape._asdict().items() if value != Shape._field_defaults[name]]
        lines.append(f"friction along the {feedforward.along} motion by {feedforward.friction.name}" + "".join(shape))
        if rises_with_effort(feedforward.friction):
            plant = None if carried is fed else feedforward.carries
            passing = "the rest of the feedforward" if plant is None else plant.name
            lines.append(f"the friction level rises with the effort that {passing} transmits along the desired motion")
    return [plain(line) for line in lines] or ["nothing"]
