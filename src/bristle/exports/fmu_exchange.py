"""A model in continuous time, as kernels of an FMU: rates between events, what an event commits, what holds after it.

An importer integrates the plant and what varies of the contact, where the equations of the model are smooth from event
to event (``piece``, ``flow`` and ``arrival``) or throughout (``rate``). They go on smoothly past an event, so that it
is found where their margin falls below zero; there the memory is committed, once, and the next piece begins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from bristle.core import dispatch
from bristle.core.contracts import Model, Motion
from bristle.core.variable import Variable, variables_of
from bristle.engine.motion import FARTHER, SLOW
from bristle.exports.build import Builder
from bristle.exports.cycle import Core, loaded, stored
from bristle.exports.scope import defined
from bristle.exports.subject import Subject, capacity_of, piece_of
from bristle.exports.tree import INTEGER, REAL, Array, Function, Struct, type_of

# An importer finds an event where an indicator changes its sign, on either side of it as rounding has it: this much
# beyond, the next piece is another one for certain.
BEYOND = 1e-9
# At rest an integrator moves to and fro by what its tolerance leaves. So a reversal is not looked at within this share
# of the pre-sliding distance from the last event, but for motions so fast [pre-sliding distances a second].
WINDOW, FAST = 1e-6, 1e3

FLOWING = """
def flowing({arguments}):
{body}    contact = Contact({contact})
    {flow}
{store}
    return force
"""
FLOW = """piece = Piece({piece})
    force, rates, margin = friction_flow(contact, piece, {motion}, p)
    forward = piece.side * {v}
    if forward < 0.0:
        force_at_rest, rates_at_rest, margin = friction_flow(contact, piece, {at_rest}, p)
    slope[{last}] = margin + BEYOND
    slope[{last} + 1] = forward + {fast!r} * max(0.0, 1.0 - {moved})"""
RATE = "force, rates = friction_rate(contact, {motion}, p)"
BODY = "    body = PlantState({load})\n"
BODY_RATES = "    body_rates = plant_rate(body, effort, force, q)\n"
BEGUN = """
def begun({arguments}):
{body}    state = State({state})
{begin}
{store}
"""
BEGIN = "    contact, piece = friction_piece(state, memory, {motion}, p)"
ARRIVED = """
def arrived({arguments}):
    contact = Contact({contact})
{arrive}
{store}
"""
ARRIVE = """    state = State({state})
    after = friction_commit(state, memory, friction_arrival(state, memory, contact, p), p)"""


@dataclass(frozen=True)
class Exchange:
    """A model in continuous time as functions of the tree."""

    flowing: Function
    begun: Function
    arrived: Function
    varying: dict[str, Variable]
    held: tuple[int, ...]

    @property
    def functions(self) -> tuple[Function, ...]:
        """Rates between events, what begins a piece, and what commits."""
        return self.flowing, self.begun, self.arrived


def why_not(friction: Model, plant: Model | None = None) -> str:
    """Return why a model, on a plant or alone, is for co-simulation alone; nothing where it is not."""
    component, p = friction.component, friction.parameters
    if component.rate is None and component.flow is None:
        state, memory = component.initial_state(p), component.new_memory(p)
        # A static map with two forces at rest.
        if not len(state) + len(memory) and len({component.trial(state, memory, Motion(v, 0.0), 0.0, p)[0] for v in (0.0, -0.0)}) > 1:
            return f"the force of {friction.name} jumps where the motion reverses, and sticking is no differential equation"
        return f"{friction.name} has kernels for steps, and none for continuous time"
    if plant is not None and plant.component.rate is None:
        return f"{plant.name} has kernels for steps, and none for continuous time"
    return ""


def exchange_of(core: Core, builder: Builder) -> Exchange:
    """Return a model in continuous time, built beside its step."""
    subject, plant = core.subject, core.plant
    # What varies of a contact, and what holds from event to event.
    contact, piece = (subject.state, None) if subject.model.component.flow is None else piece_of(subject, builder)
    texts = _Texts(subject, plant, contact, piece)
    lasting, remembered, varied = core.begin.size, subject.memory_size, len(texts.varied)
    sizes = {"lasting": lasting, "memory": remembered, "varying": varied, "held": len(texts.held), "slope": varied + 2}
    structures = {argument: kind for argument, (_, kind) in core.parameters.items()}

    def built(name: str, text: str, arguments: list[str], writes: tuple[str, ...]) -> Function:
        kernel = defined(name, text.replace("{arguments}", ", ".join(arguments)), texts.scope)
        arrays = {array: Array(size, writable=array in writes) for array, size in sizes.items()}
        kinds = arrays | structures
        return builder.function(kernel, [kinds.get(argument, REAL) for argument in arguments])

    inputs, parameters = (["effort"], ["q", "p"]) if plant is not None else (["v", "x", *subject.signals], ["p"])
    along = [] if plant is not None else inputs
    distance, variables = _variables(subject, plant, contact)
    sizes_of_contact = [variable.nominal for variable in variables[texts.first :]]
    return Exchange(
        built("flowing", texts.flowing(sizes_of_contact, distance), ["varying", "held", "slope", *inputs, *parameters], ("slope",)),
        built("begun", texts.begun(), ["lasting", "memory", "varying", "held", *along, "p"], ("varying", "held")),
        built("arrived", texts.arrived(), ["lasting", "memory", "varying", "p"], ("lasting", "memory")),
        dict(zip(texts.varied, variables, strict=True)),
        tuple(texts.held),
    )


class _Texts:
    """The kernels of a model as text: what they load and keep has the fields of the model."""

    def __init__(self, subject: Subject, plant: Model | None, contact: Struct, piece: Struct | None) -> None:
        self.subject, self.plant, self.contact, self.piece = subject, plant, contact, piece
        body = None if plant is None else type_of(plant.component.initial_state(plant.parameters))
        assert body is None or isinstance(body, Struct)
        self.body = body
        self.first = 0 if body is None else len(body.fields)
        around = (
            subject.usual
            if plant is not None
            else {name: name if name in subject.signals else usual for name, usual in subject.usual.items()}
        )
        self.v, x = ("body.v", "body.x") if plant is not None else ("v", "x")
        self.around = ", ".join([x, *map(str, around.values())])
        self.motion = f"Motion({self.v}, {self.around})"
        self.scope = vars(dispatch) | {
            "__name__": __name__,
            "State": subject.state.cls,
            "Contact": contact.cls,
            "Motion": subject.motion.cls,
            "BEYOND": BEYOND,
        }
        self.scope |= {} if piece is None else {"Piece": piece.cls}
        self.scope |= {} if body is None else {"PlantState": body.cls}
        of_body = [] if body is None else [name for name, _ in body.fields]
        of_contact = [name for name, _ in contact.fields]
        # What varies, by name: the state of the plant, then the contact.
        self.varied = [*of_body, *(f"contact_{name}" if name in of_body else name for name in of_contact)]
        # For each number that holds, how many values it can take where it is whole; 0 where it is real. Behind the piece
        # is the contact as it was at the event.
        self.held: list[int] = []
        if piece is not None:
            self.held = [capacity_of(name, subject.memory_size) + 1 if kind == INTEGER else 0 for name, kind in piece.fields]
            self.held += [0] * len(contact.fields)

    def flowing(self, sizes: list[float], distance: float) -> str:
        """Return the kernel of the rates, for a contact whose variables have some sizes."""
        flow = RATE.format(motion=self.motion)
        stores = [stored(self.contact, "rates", self.first, "slope")]
        if self.piece is not None:
            behind = len(self.piece.fields)
            moved = [f"abs(varying[{self.first + i}] - held[{behind + i}]) * {1.0 / (WINDOW * size)!r}" for i, size in enumerate(sizes)]
            farthest = moved[0] if len(moved) == 1 else f"max({', '.join(moved)})"
            flow = FLOW.format(
                motion=self.motion,
                at_rest=f"Motion(piece.side * 0.0, {self.around})",
                v=self.v,
                piece=loaded(self.piece, 0, "held"),
                last=len(self.varied),
                fast=FAST * distance,
                moved=farthest,
            )
        if self.body is not None:
            stores = [BODY_RATES + stored(self.body, "body_rates", 0, "slope"), *stores]
        contact = loaded(self.contact, self.first, "varying")
        return FLOWING.format(arguments="{arguments}", body=self._body("varying"), contact=contact, flow=flow, store="\n".join(stores))

    def begun(self) -> str:
        """Return the kernel that begins a piece."""
        begin, stores = "    contact = state", [stored(self.contact, "contact", self.first, "varying")]
        if self.piece is not None:
            begin = BEGIN.format(motion=self.motion)
            stores.append(stored(self.piece, "piece", 0, "held"))
            stores.append(stored(self.contact, "contact", len(self.piece.fields), "held"))
        if self.body is not None:
            stores.append(stored(self.body, "body", 0, "varying"))
        state = loaded(self.subject.state, self.first)
        return BEGUN.format(arguments="{arguments}", body=self._body("lasting"), state=state, begin=begin, store="\n".join(stores))

    def arrived(self) -> str:
        """Return the kernel that commits."""
        arrive, state = "    after = contact", self.subject.state
        if self.piece is not None:
            arrive = ARRIVE.format(state=loaded(state, self.first))
        stores = [stored(state, "after", self.first)]
        stores += [f"    lasting[{i}] = varying[{i}]" for i in range(self.first)]
        contact = loaded(self.contact, self.first, "varying")
        return ARRIVED.format(arguments="{arguments}", contact=contact, arrive=arrive, store="\n".join(stores))

    def _body(self, array: str) -> str:
        return "" if self.body is None else BODY.format(load=loaded(self.body, 0, array))


def _variables(subject: Subject, plant: Model | None, contact: Struct) -> tuple[float, list[Variable]]:
    """Return the pre-sliding distance, and what varies, each with the size at which it matters to the contact.

    A length matters where the contact reaches half of its largest force, a force at that; a velocity where the mass
    has the energy that this takes.
    """
    force = np.abs(subject.forces(np.concatenate(([0.0], FARTHER[1:])), SLOW))
    largest = float(np.max(force))
    sizes = {"force": largest, "length": float(FARTHER[np.argmax(force >= 0.5 * largest)])}
    listed: list[Variable] = []
    if plant is not None:
        body, q = plant.component.initial_state(plant.parameters), plant.parameters
        rise = plant.component.rate(body, largest, 0.0, q).v - plant.component.rate(body, 0.0, 0.0, q).v
        sizes["length/time"] = math.sqrt(rise * sizes["length"])
        listed += variables_of(type(body)).values()
    try:
        listed += variables_of(contact.cls).values()
    except TypeError:  # a contact of a user's own may have described none
        listed += [Variable("1", f"{name}, which varies") for name, _ in contact.fields]
    return sizes["length"], [replace(variable, nominal=sizes.get(variable.quantity) or variable.nominal) for variable in listed]
