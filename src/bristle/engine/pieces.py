"""A plant with friction in continuous time, as entries: rates on a smooth piece, and the turn to the next one.

A model with a ``rate`` is one piece that never ends. One with a ``flow`` is smooth from event to event.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED, Motion
from bristle.core.dispatch import friction_arrival, friction_commit, friction_flow, friction_piece, friction_rate, plant_rate
from bristle.core.kernel import kernel
from bristle.core.packing import Structure, packer, unpacker
from bristle.engine.efim import INFINITY
from bristle.engine.signature import Vector

__all__ = ["Layout", "Mechanism", "PieceVectors", "Rates", "Turn", "make_rates", "make_turn", "never_turn", "rates_of"]


class PieceVectors(NamedTuple):
    """A plant with friction on a smooth piece.

    Parameters of both, what holds on the piece, and state and memory of the contact at its beginning.
    """

    plant: Vector
    friction: Vector
    piece: Vector
    state: Vector
    memory: Vector


# The time derivative of y, and the margin to the next event: (vectors, y, effort, slope).
Rates = Callable[[PieceVectors, Vector, float, Vector], float]
# The memory is committed at an event, and the next piece begins: (vectors, y).
Turn = Callable[[PieceVectors, Vector], float]


class Layout(NamedTuple):
    """How the vectors of plant and friction are laid out; `piece` is None for a model that is smooth throughout."""

    plant: Structure
    plant_state: Structure
    friction: Structure
    friction_state: Structure
    contact: Structure
    piece: Structure | None

    @property
    def size(self) -> int:
        """How many variables there are: [plant state | contact | friction impulse]."""
        return len(self.plant_state[1]) + len(self.contact[1]) + 1


class Mechanism(NamedTuple):
    """Parameters of plant and friction, and what holds on the present piece."""

    q: Any
    p: Any
    piece: Any


@cache
def rates_of(layout: Layout) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return two kernels: one that loads a `Mechanism`, and one that computes rates and margin for it."""
    load_plant, store_plant = unpacker(layout.plant_state), packer(layout.plant_state)
    count, last = len(layout.plant_state[1]), layout.size - 1
    load_contact, store_contact = unpacker(layout.contact, count), packer(layout.contact, count)
    load_mechanism = _loader(layout)
    flow = _smooth_flow if layout.piece is None else friction_flow

    @kernel
    def rates(mechanism, y, effort, slope):
        body = load_plant(y)
        motion = Motion(body.v, body.x, NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED)
        force, d_contact, margin = flow(load_contact(y), mechanism.piece, motion, mechanism.p)
        store_plant(plant_rate(body, effort, force, mechanism.q), slope)
        store_contact(d_contact, slope)
        slope[last] = force
        return margin

    return load_mechanism, rates


@kernel
def _smooth_flow(contact, piece, motion, p):
    force, d_state = friction_rate(contact, motion, p)
    return force, d_state, INFINITY


def _loader(layout: Layout) -> Callable[..., Any]:
    unpack_plant, unpack_friction = unpacker(layout.plant), unpacker(layout.friction)
    if layout.piece is None:

        @kernel
        def load_smooth(vectors):
            return Mechanism(unpack_plant(vectors.plant), unpack_friction(vectors.friction), 0.0)

        return load_smooth
    unpack_piece = unpacker(layout.piece)

    @kernel
    def load(vectors):
        return Mechanism(unpack_plant(vectors.plant), unpack_friction(vectors.friction), unpack_piece(vectors.piece))

    return load


def make_rates(layout: Layout) -> Callable[..., Any]:
    """Return the entry that writes the time derivative of `y` into `slope` and returns the margin to the next event."""
    load, rates = rates_of(layout)

    def rates_at(vectors, y, effort, slope):
        return rates(load(vectors), y, effort, slope)

    return rates_at


def make_turn(layout: Layout) -> Callable[..., Any]:
    """Return the entry that commits the memory at an event and begins the next piece."""
    load_plant, unpack_friction = unpacker(layout.plant_state), unpacker(layout.friction)
    load_contact = unpacker(layout.contact, len(layout.plant_state[1]))
    load_friction, store_friction = unpacker(layout.friction_state), packer(layout.friction_state)
    store_piece = packer(layout.piece or layout.contact)

    def turn(vectors, y):
        body, p, s = load_plant(y), unpack_friction(vectors.friction), load_friction(vectors.state)
        memory = vectors.memory
        s = friction_commit(s, memory, friction_arrival(s, memory, load_contact(y), p), p)
        store_friction(s, vectors.state)
        motion = Motion(body.v, body.x, NOMINAL_LOAD, NOMINAL_TEMPERATURE, NOTHING_TRANSMITTED)
        store_piece(friction_piece(s, memory, motion, p)[1], vectors.piece)
        return 0.0

    return turn


def never_turn(vectors, y):
    """Do nothing: a smooth model is one piece."""
    return 0.0
