"""The parameters of a plant with a friction model: their roles, magnitudes, and the free and fixed parameters with reasons.

The role of a parameter follows from its quantity and excitation, not from its name. Typical magnitudes of a log scale and
bound parameters of unknown magnitude. The inputs of a slot must be recorded.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from bristle.core import units
from bristle.core.contracts import FrictionModel, Plant
from bristle.core.diagnostic import Number
from bristle.core.dimensions import exponents_of
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.core.surroundings import Surrounding
from bristle.core.variable import Variable, unit_of
from bristle.identification.dataset import Dataset
from bristle.models.friction.slots import OFFSET, directional, slot_needing
from bristle.models.friction.variation import HALF_RANGE, LIKE_A_SPRING, MIDDLE, PITCH
from bristle.models.plants.inertia import MODEL as inertia

SLIDES = ("sliding", "stribeck", "presliding")
# Of the largest speed: above, the log would not show the level after the fall.
STRIBECK_SHARE = 1.0 / 3.0
ALIKE = 1e-9  # relative difference below which two unit factors are equal
ONE_WAY = 0.01  # share of the samples below which a direction counts as missing
SLIDES_FROM = 0.1  # of the largest speed: slower rows do not show a friction level
SINGULAR = 1e-9
# Reason of a fixed value: the user gave it.
STATED = "held_known"


class Role(Enum):
    """Quantity and excitation of parameters with special treatment."""

    INERTIA = ("mass", "acceleration")
    VISCOUS = ("force*time/length", "speed")
    LEVEL = ("force", "sliding")
    BREAK_AWAY = ("force", "stribeck")
    FALL = ("length/time", "stribeck")
    STIFFNESS = ("force/length", "presliding")
    SPRING = ("force/length", "place")
    MICRO_DAMPING = ("force*time/length", "presliding")

    def fits(self, variable: Variable) -> bool:
        """Return whether a parameter has this role; the constant part of friction is not a level."""
        return (variable.quantity, variable.excitation) == self.value and variable != OFFSET


def names_of(role: Role | Variable, variables: Mapping[str, Variable]) -> list[str]:
    """Return the parameters of a role, or those equal to a `Variable`."""
    return [
        name
        for name, variable in variables.items()
        if (role.fits(variable) if isinstance(role, Role) else variable == role)
    ]


def acts_in_sliding(variable: Variable) -> bool:
    """Return whether a parameter is a force that friction reaches only in sliding."""
    return variable.quantity == "force" and variable.excitation in SLIDES and variable != OFFSET


def name_of(role: Role | Variable, variables: Mapping[str, Variable]) -> str | None:
    """Return the first parameter of a role, or None."""
    return next(iter(names_of(role, variables)), None)


def offset_of(variables: Mapping[str, Variable], values: Mapping[str, float]) -> float:
    """Return the constant part of friction [N or N*m]; 0 if a model does not have it."""
    name = name_of(OFFSET, variables)
    return 0.0 if name is None else values.get(name, 0.0)


def constant_of(variables: Mapping[str, Variable], values: Mapping[str, float]) -> float:
    """Return the constant force in a friction model [N or N*m]: its constant part, or half the difference of two levels."""
    levels = [values[name] for name in names_of(Role.LEVEL, variables)]
    halves = 0.5 * (levels[0] - levels[1]) if len(levels) > 1 else 0.0
    return offset_of(variables, values) + halves


class Scales(NamedTuple):
    """Typical magnitudes of a log, in SI."""

    force: float
    peak: float
    speed: float
    slowest: float
    acceleration: float
    stroke: float
    shortest: float
    duration: float
    sample_time: float

    def magnitude(self, variable: Variable) -> float:
        """Return a typical value of a parameter [SI], by default from the exponents of its quantity."""
        if variable.excitation == "drive":
            return variable.nominal
        typical = {
            "length": math.sqrt(self.stroke * self.shortest),
            "length/time": math.sqrt(self.slowest * self.speed),
            "force/length": self.force / math.sqrt(self.stroke * self.shortest),
            "1/length": 1.0 / self.stroke,
            "time": math.sqrt(self.sample_time * self.duration),
            "1/time": 1.0 / math.sqrt(self.sample_time * self.duration),
            "force/time": self.force / math.sqrt(self.sample_time * self.duration),
        }
        powers = exponents_of(variable.quantity)
        if variable.quantity in typical or not powers or set(powers) - {"force", "length", "time"}:
            return typical.get(variable.quantity, variable.nominal)
        length, time = powers.get("length", 0.0), powers.get("time", 0.0)
        # Speed and acceleration together give every power of length and time.
        parts = (
            (self.force, powers.get("force", 0.0)),
            (self.speed, 2.0 * length + time),
            (self.acceleration, -length - time),
        )
        above, below = (
            math.prod(part ** max(sign * power, 0.0) for part, power in parts)
            for sign in (1.0, -1.0)
        )
        return above / below

    def range(self, variable: Variable) -> tuple[float, float]:
        """Return the search range of a positive parameter of unknown magnitude [SI]."""
        return {
            "length": (self.shortest, self.stroke),
            "length/time": (self.slowest, max(STRIBECK_SHARE * self.speed, 2.0 * self.slowest)),
            "force/length": (self.force / self.stroke, self.force / self.shortest),
            "time": (self.sample_time, self.duration),
            "1/time": (1.0 / self.duration, 1.0 / self.sample_time),
            "force/time": (self.force / self.duration, self.force / self.sample_time),
        }.get(variable.quantity, (1e-3 * self.magnitude(variable), 1e2 * self.magnitude(variable)))


def stroke_of(dataset: Dataset) -> float:
    """Return the largest stroke within a segment of the log [m or rad]."""
    return max(float(np.ptp(segment.position)) for segment in dataset.segments)


def scales_of(dataset: Dataset, force: float) -> Scales:
    """Return the typical magnitudes of a log, for a friction force of this magnitude [N or N*m]."""
    speeds = np.abs(dataset.all_velocities)
    speeds = speeds[speeds > 0.0]
    speed = float(np.quantile(speeds, 0.995))
    # A share of the samples is slower than the smallest Stribeck velocity sought.
    slowest = max(float(np.quantile(speeds, 0.01)), 1e-4 * speed)
    stroke = stroke_of(dataset)
    return Scales(
        force=force,
        peak=float(np.max(np.abs(dataset.effort))),
        speed=speed,
        slowest=slowest,
        acceleration=max(
            float(np.sqrt(np.mean(dataset.acceleration**2))), 1e-9 * speed / dataset.sample_time
        ),
        stroke=stroke,
        shortest=min(max(dataset.resolution, slowest * dataset.sample_time), 0.1 * stroke),
        duration=float(np.ptp(dataset.time)),
        sample_time=dataset.sample_time,
    )


def refuse_unrecorded(component: FrictionModel, dataset: Dataset) -> None:
    """Reject a log without a channel that a slot needs, or with another quantity under its name."""
    for surrounding in component.surroundings:
        name = surrounding.name
        if all(surrounding.name in segment.surroundings for segment in dataset.segments):
            _refuse_another(surrounding, dataset)
        elif surrounding.is_recorded:
            slot, unit = slot_needing(component, name), surrounding.variable.unit(dataset.kind)
            written = (
                f'{{ column = "...", unit = "{"%" if unit == "1" else unit}" }}'
                if surrounding.is_own
                else "..."
            )
            raise InputError(
                f"has no {name}, needed by +{slot}",
                path="log",
                mend=f"Name its column under [columns] of the axis file: {name} = {written}, or drop +{slot}",
            )


def _is_of_its_quantity(dataset: Dataset, surrounding: Surrounding) -> bool:
    unit, in_si = dataset.units.get(surrounding.name, ""), surrounding.variable.unit(dataset.kind)
    return not surrounding.is_own or (
        units.compatible(unit, in_si) and abs(units.factor(unit, in_si) - 1.0) < ALIKE
    )


def _refuse_another(surrounding: Surrounding, dataset: Dataset) -> None:
    """Reject a channel of another quantity, or with most values out of range."""
    name, variable = surrounding.name, surrounding.variable
    wanted, unit = variable.unit(dataset.kind), dataset.units.get(name, "")
    if not surrounding.is_own:
        return
    if not _is_of_its_quantity(dataset, surrounding):
        raise InputError(
            "has another quantity than the slot expects",
            path=f"columns.{name}.unit",
            value=unit,
            allowed=f"{variable.description}, in {wanted} or a multiple of it",
            mend="Correct the unit in the axis file, or the channel in the file of the slot",
        )
    usual = float(
        np.median(np.concatenate([segment.surroundings[name] for segment in dataset.segments]))
    )
    if not variable.min <= usual <= variable.max:
        raise InputError(
            "has a median out of range",
            path=f"columns.{name}",
            value=usual,
            allowed=variable.allowed(dataset.kind),
            mend=f"Check the unit of this column: the slot expects the {variable.description}",
        )


class Fixed(NamedTuple):
    """A fixed parameter: its value, and the reason as the code of a diagnostic with its `numbers`; measured, with a `half_width`."""

    value: float
    reason: str
    redundant: bool = False  # no log could identify it
    numbers: Mapping[str, Number] = {}
    half_width: float | None = (
        None  # of the 95 % interval of a parameter measured in this log before the fit, which has no reason
    )


@dataclass(frozen=True)
class ParameterSet:
    """The parameters of a plant with friction: `free`, plant first, `fixed`, and unknown parameters of the simulated `loop`."""

    component: FrictionModel
    free: tuple[str, ...]
    fixed: Mapping[str, Fixed]
    plant: Plant = inertia
    loop: Mapping[str, Variable] = field(default_factory=dict)

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The `Variable` of each parameter, plant first."""
        return self.plant.variables | self.component.variables | dict(self.loop)

    @cached_property
    def held(self) -> dict[str, float]:
        """The values of the fixed parameters."""
        return {name: fixed.value for name, fixed in self.fixed.items()}

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return every parameter, from the free ones."""
        return {**self.held, **values}

    def is_redundant(self, name: str) -> bool:
        """Return whether a parameter is fixed because the log cannot identify it."""
        return name in self.fixed and self.fixed[name].redundant

    @property
    def is_linear(self) -> bool:
        """Whether the effort is linear in the free parameters, and no relation binds them."""
        return self.component.linear and not self.component.relations


@dataclass(frozen=True)
class PriorKnowledge:
    """Prior knowledge of the axis; an offset or a pitch of None and the shapes in `free` are identified."""

    offset: float | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    plant: Plant = inertia
    pitch: float | None = None
    free: tuple[str, ...] = ()  # shapes
    # Before the fit: value and half-width of its 95 % interval.
    measured: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def parameters_of(
    component: FrictionModel, prior: PriorKnowledge, dataset: Dataset
) -> ParameterSet:
    """Return the free and the fixed parameters of a model, with the reasons."""
    held = {
        name: Fixed(value, reason="", half_width=width)
        for name, (value, width) in prior.measured.items()
    }
    held |= {name: Fixed(value, STATED) for name, value in prior.values.items()}
    # Redundant parameters are fixed at a round number of the right magnitude.
    length = 10.0 ** math.floor(math.log10(stroke_of(dataset)))
    for name, factors in component.redundancies:
        value = length ** exponents_of(component.variables[name].quantity).get("length", 0.0)
        products = tuple(f"{name}*{factor}" for factor in factors)
        held[name] = Fixed(value, "redundant", redundant=True, numbers={"products": products})
    refuse_unrecorded(component, dataset)
    places = np.concatenate([segment.position for segment in dataset.segments])
    low, high = float(np.min(places)), float(np.max(places))
    of_slots = {
        MIDDLE: Fixed(0.5 * (low + high), "held_middle"),
        HALF_RANGE: Fixed(0.5 * (high - low), "held_half_range"),
    }
    if prior.pitch is not None:
        of_slots[PITCH] = Fixed(prior.pitch, "held_pitch")
    held |= {
        name: of_slots[variable]
        for name, variable in component.variables.items()
        if variable in of_slots
    }
    damped = name_of(Role.VISCOUS, prior.plant.variables) is not None
    for name, variable in component.variables.items():
        if variable == OFFSET:
            continue
        is_in_plant = damped and Role.VISCOUS.fits(variable)
        is_in_plant |= LIKE_A_SPRING.get(name) in prior.plant.variables
        if is_in_plant:
            held[name] = Fixed(0.0, "held_plant_damping")
        elif (
            name in component.defaults
            and not variable.excitation
            and name not in (*held, *prior.free)
        ):
            default = component.defaults[name]
            held[name] = Fixed(
                variable.code(default, name) if variable.choices else default, "held_default"
            )
    ahead = float(np.mean(~np.signbit(dataset.all_velocities)))
    side = "backward" if ahead < ONE_WAY else "forward" if ahead > 1.0 - ONE_WAY else ""
    split = directional(component)
    if side and split:
        raise InputError(
            f"the log contains only {side} motion",
            path="model",
            value=component.name,
            mend="Record both directions or drop +asymmetry",
        )
    force = unit_of("force", dataset.kind)
    levels = [name for name in split if component.variables[name].unit(dataset.kind) == force]
    if levels:
        velocity = dataset.velocity
        fast = np.abs(velocity) > SLIDES_FROM * float(np.max(np.abs(velocity)))
        v, forward, effort = velocity[fast], velocity[fast] > 0.0, dataset.effort[fast]
        # In pre-sliding the effort covers all levels: only the constant keeps its sign in both directions.
        constant = 0.0
        if np.median(effort[forward]) * np.median(effort[~forward]) > 0.0:
            columns = np.stack(
                [forward, ~forward, v * forward, v * ~forward, dataset.acceleration[fast]], axis=1
            )
            constant = 0.5 * float(np.sum(unbounded(columns, effort, rcond=SINGULAR)[:2]))
        offset = Fixed(
            constant,
            "held_constant" if constant else "held_levels",
            numbers={"levels": tuple(levels)},
        )
    else:
        variables = component.variables.items()
        forces = [
            name
            for name, variable in variables
            if variable != OFFSET and variable.unit(dataset.kind) == force
        ]
        offset = (
            None
            if not side or not forces
            else Fixed(0.0, "held_one_direction", numbers={"level": forces[0], "direction": side})
        )
    if prior.offset is not None:
        offset = Fixed(prior.offset, STATED)
    if offset is not None:
        held |= dict.fromkeys(names_of(OFFSET, component.variables), offset)
    free = tuple(
        name for name in (*prior.plant.variables, *component.variables) if name not in held
    )
    return ParameterSet(component, free, held, prior.plant)
