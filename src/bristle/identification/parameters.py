"""The parameters of a plant with a friction model: which are free, which are fixed, and why."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Plant
from bristle.core.diagnostic import Number
from bristle.core.dimensions import exponents_of
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.least_squares import unbounded
from bristle.core.variable import Variable, unit_of
from bristle.friction.slots import OFFSET, directional
from bristle.friction.variation import HALF_RANGE, MIDDLE, PITCH
from bristle.identification.dataset import Dataset
from bristle.identification.recorded_surroundings import refuse_unrecorded
from bristle.identification.roles import Role, name_of, names_of
from bristle.identification.scales import stroke_of
from bristle.plants.inertia import MODEL as inertia

__all__ = ["Fixed", "ParameterSet", "PriorKnowledge", "parameters_of"]

ONE_WAY = 0.01  # share of the samples below which a direction counts as not seen
SLIDES = 0.1  # of the largest speed: what is slower is not asked for a level of friction
SINGULAR = 1e-9


class Fixed(NamedTuple):
    """A parameter that is not identified: its value, why (the code of a diagnostic with what its sentence needs).

    It is `redundant` where no log could tell it. Of what was found in this log before any model, half of its 95 %
    interval is known, and there is no reason.
    """

    value: float
    reason: str
    redundant: bool = False
    numbers: Mapping[str, Number] = {}
    half_width: float | None = None


@dataclass(frozen=True)
class ParameterSet:
    """The parameters of a plant with a friction model: the `free` ones, plant first, and all others `fixed`.

    `loop` is what is unknown of the loop that both are simulated in.
    """

    component: FrictionModel
    free: tuple[str, ...]
    fixed: Mapping[str, Fixed]
    plant: Plant = inertia
    loop: Mapping[str, Variable] = field(default_factory=dict)

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The `Variable` of each parameter, plant first."""
        return self.plant.variables | self.component.variables | dict(self.loop)

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return every parameter, from the free ones."""
        return {name: fixed.value for name, fixed in self.fixed.items()} | dict(values)

    @property
    def is_linear(self) -> bool:
        """Whether the effort is linear in the free parameters, and no relation binds them."""
        return self.component.linear and not self.component.relations


@dataclass(frozen=True)
class PriorKnowledge:
    """What is known of the axis beforehand: the plant, those of its parameters that are known, and the offset.

    An offset of None is to be identified; so is the pitch of the screw. Shapes in `free` are identified too. What was
    `measured` in the log before any model has half of its 95 % interval beside it.
    """

    offset: float | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    plant: Plant = inertia
    pitch: float | None = None
    free: tuple[str, ...] = ()
    measured: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def parameters_of(component: FrictionModel, prior: PriorKnowledge, dataset: Dataset) -> ParameterSet:
    """Return which parameters of a model are free and which are held, with the reason.

    Raises
    ------
    InputError
        If parameters by direction are asked of a log that moves in one direction only, or the log lacks a channel
        that a slot asks for.
    """
    held = {name: Fixed(value, reason="", half_width=width) for name, (value, width) in prior.measured.items()}
    held |= {name: Fixed(value, "held_known") for name, value in prior.values.items()}
    held |= _redundant(component, stroke_of(dataset))
    held |= _slot_parameters(component, dataset, prior.pitch)
    damped = name_of(Role.VISCOUS, prior.plant.variables) is not None
    for name, variable in component.variables.items():
        if variable == OFFSET:
            continue
        if damped and Role.VISCOUS.fits(variable):
            held[name] = Fixed(0.0, "held_plant_damping")
        elif name in component.defaults and not variable.excitation and name not in (*held, *prior.free):
            default = component.defaults[name]
            code = variable.code(default, name) if variable.choices else default
            held[name] = Fixed(code, "held_default")
    unidentifiable = _held_offset(component, dataset)
    fixed = unidentifiable if prior.offset is None else Fixed(prior.offset, "held_known")
    if fixed is not None:
        held |= dict.fromkeys(names_of(OFFSET, component.variables), fixed)
    free = tuple(name for name in (*prior.plant.variables, *component.variables) if name not in held)
    return ParameterSet(component, free, held, prior.plant)


def _redundant(component: FrictionModel, stroke: float) -> dict[str, Fixed]:
    """Return the parameters that no log can tell, each held at a round number of the right magnitude."""
    length, fixed = 10.0 ** math.floor(math.log10(stroke)), {}
    for name, factors in component.redundancies:
        value = length ** exponents_of(component.variables[name].quantity).get("length", 0.0)
        products = tuple(f"{name}*{factor}" for factor in factors)
        fixed[name] = Fixed(value, "redundant", redundant=True, numbers={"products": products})
    return fixed


def _held_offset(component: FrictionModel, dataset: Dataset) -> Fixed | None:
    """Return the offset as held where it cannot be told from the rest."""
    side = _only_direction(dataset)
    split = directional(component)
    if side and split:
        raise InputError(
            f"the log moves {side} only, which does not show the friction of the other direction",
            path="model", value=component.name, mend="Record both directions, or drop +asymmetry",
        )  # fmt: skip
    force = unit_of("force", dataset.kind)
    levels = [name for name in split if component.variables[name].unit(dataset.kind) == force]
    if levels:
        constant = _constant_beyond(dataset)
        return Fixed(constant, "held_constant" if constant else "held_levels", numbers={"levels": tuple(levels[:2])})
    variables = component.variables.items()
    forces = [name for name, variable in variables if variable != OFFSET and variable.unit(dataset.kind) == force]
    if side and forces:
        return Fixed(0.0, "held_one_direction", numbers={"level": forces[0], "direction": side})
    return None


def _constant_beyond(dataset: Dataset) -> float:
    """Return the constant force without which friction of one direction would be negative [N or N*m]; 0 where none is.

    It is half of what the levels of both directions differ by, as of a weight that is larger than friction.
    """
    velocity = dataset.velocity
    fast = np.abs(velocity) > SLIDES * float(np.max(np.abs(velocity)))
    v, forward, effort = velocity[fast], velocity[fast] > 0.0, dataset.effort[fast]
    # Before sliding the effort takes all levels: it is the constant alone that keeps its sign on both sides.
    if np.median(effort[forward]) * np.median(effort[~forward]) <= 0.0:
        return 0.0
    columns = np.stack([forward, ~forward, v * forward, v * ~forward, dataset.acceleration[fast]], axis=1)
    level_forward, level_backward = unbounded(columns, effort, rcond=SINGULAR)[:2]
    return 0.5 * float(level_forward + level_backward)


def _only_direction(dataset: Dataset) -> str:
    velocity = dataset.all_velocities
    forward = float(np.mean(~np.signbit(velocity)))
    return "backward" if forward < ONE_WAY else "forward" if forward > 1.0 - ONE_WAY else ""


def _slot_parameters(component: FrictionModel, dataset: Dataset, pitch: float | None) -> dict[str, Fixed]:
    """Return the parameters of slots that are read off the log or the axis: range, and travel for one turn."""
    refuse_unrecorded(component, dataset)
    low = min(float(np.min(segment.position)) for segment in dataset.segments)
    high = max(float(np.max(segment.position)) for segment in dataset.segments)
    fixed = {
        MIDDLE: Fixed(0.5 * (low + high), "held_middle"),
        HALF_RANGE: Fixed(0.5 * (high - low), "held_half_range"),
    }
    if pitch is not None:
        fixed[PITCH] = Fixed(pitch, "held_pitch")
    return {name: fixed[variable] for name, variable in component.variables.items() if variable in fixed}
