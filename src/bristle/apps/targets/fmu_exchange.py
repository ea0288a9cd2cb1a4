"""A model in continuous time, as kernels of an FMU: rates between events, and the commit at an event.

An importer integrates the plant and the continuous state of the contact, if the equations of the model are smooth from
event to event (``piece``, ``flow`` and ``arrival``) or throughout (``rate``). The equations continue smoothly past an
event, so that the importer finds it at a negative margin. There the memory is committed once, and the next piece begins.
"""

import math
import textwrap
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Model, Motion, Variable, dispatch, variables_of
from bristle.engine.motion import FARTHER, SLOW
from bristle.engine.translation.build import Builder
from bristle.engine.translation.derivative import nowhere
from bristle.engine.translation.directional import derived_in
from bristle.engine.translation.scope import defined
from bristle.engine.translation.tree import (
    INTEGER,
    REAL,
    Array,
    Function,
    Struct,
    Type,
    struct_type,
)
from bristle.exports.cycle import Core, loaded, stored
from bristle.exports.subject import Subject, capacity_of, piece_of

# An importer finds an event at the sign change of an indicator, on either side due to rounding: with this offset, the
# next piece is certain to be a different one.
BEYOND = 1e-9
# At rest an integrator oscillates within its tolerance. Therefore a reversal is ignored within this share of the
# pre-sliding distance after the last event, unless the motion is faster than this [pre-sliding distances per second].
WINDOW = 1e-6
FAST = 1e3


class Exchange(NamedTuple):
    """A model in continuous time as functions of the tree: rates between events, start of a piece, commit, rates with tangents."""

    flowing: Function
    begun: Function
    arrived: Function
    changing: Function
    varying: dict[str, Variable]  # states for an importer
    # Constant between events: the number of values of an integer, or 0 for a real number.
    held: tuple[int, ...]


def why_not(friction: Model, plant: Model | None = None) -> str:
    """Return the reason why a model, on a plant or alone, supports co-simulation only; empty if it supports both."""
    component = friction.component
    p = friction.parameters
    if component.rate is None and component.flow is None:
        state = component.initial_state(p)
        memory = component.new_memory(p)
        # A static map with two forces at rest.
        if (
            not len(state) + len(memory)
            and len(
                {component.trial(state, memory, Motion(v, 0.0), 0.0, p)[0] for v in (0.0, -0.0)}
            )
            > 1
        ):
            return f"the force of {friction.name} jumps at reversals, and sticking is not a differential equation"
        return f"{friction.name} has kernels for time steps only, not for continuous time"
    if plant is not None and plant.component.rate is None:
        return f"{plant.name} has kernels for time steps only, not for continuous time"
    return ""


def exchange_of(core: Core, builder: Builder) -> Exchange:
    """Return a model in continuous time, built together with its step: kernels that load and store the fields of the model."""
    subject = core.subject
    plant = core.plant
    state = core.subject.state
    contact, piece, body, varied, held = _states_of(core, builder)
    first = len(varied) - len(contact.fields)
    distance, variables = _variables(subject, plant, contact)

    inputs = ["effort"]
    along = []
    parameters = ["q", "p"]
    v = "body.v"
    x = "body.x"
    usual = {name: str(value) for name, value in subject.usual.items()}
    if plant is None:
        inputs = ["v", "x", *subject.signals]
        along = inputs
        parameters = ["p"]
        v = "v"
        x = "x"
        usual |= {name: name for name in subject.signals}
    around = ", ".join([x, *usual.values()])
    flowing = [f"contact = Contact({loaded(contact, first, 'varying')})"]
    begun = [f"state = State({loaded(state, first)})"]
    arrived = list(flowing)
    stores = [stored(contact, "contact", first, "varying")]
    if piece is None:
        flowing.append(f"force, rates = friction_rate(contact, Motion({v}, {around}), p)")
        begun.append("contact = state")
        arrived.append("after = contact")
    else:
        behind = len(piece.fields)
        sizes = [variable.nominal for variable in variables[first:]]
        moved = [
            f"abs(varying[{first + i}] - held[{behind + i}]) * {1.0 / (WINDOW * size)!r}"
            for i, size in enumerate(sizes)
        ]
        farthest = ", ".join(moved)
        if len(moved) > 1:
            farthest = f"max({farthest})"
        flowing += [
            f"piece = Piece({loaded(piece, 0, 'held')})",
            f"force, rates, margin = friction_flow(contact, piece, Motion({v}, {around}), p)",
            f"forward = piece.side * {v}",
            "if forward < 0.0:\n"
            f"    force_at_rest, rates_at_rest, margin = friction_flow(contact, piece, Motion(piece.side * 0.0, {around}), p)",
            f"slope[{len(varied)}] = margin + BEYOND",
            f"slope[{len(varied) + 1}] = forward + {FAST * distance!r} * max(0.0, 1.0 - {farthest})",
        ]
        begun.append(f"contact, piece = friction_piece(state, memory, Motion({v}, {around}), p)")
        stores += [stored(piece, "piece", 0, "held"), stored(contact, "contact", behind, "held")]
        arrived += [
            begun[0],
            "after = friction_commit(state, memory, friction_arrival(state, memory, contact, p), p)",
        ]
    if body is not None:
        flowing.insert(0, f"body = PlantState({loaded(body, 0, 'varying')})")
        flowing += [
            "body_rates = plant_rate(body, effort, force, q)",
            stored(body, "body_rates", 0, "slope"),
        ]
        begun.insert(0, f"body = PlantState({loaded(body, 0)})")
        stores.append(stored(body, "body", 0, "varying"))
    flowing += [stored(contact, "rates", first, "slope"), "return force"]
    arrived += [
        stored(state, "after", first),
        *(f"lasting[{i}] = varying[{i}]" for i in range(first)),
    ]

    classes = {"State": state, "Contact": contact, "Motion": subject.motion}
    classes |= {"Piece": piece, "PlantState": body}
    scope = vars(dispatch) | {name: kind.cls for name, kind in classes.items() if kind}
    scope |= {"__name__": __name__, "BEYOND": BEYOND}
    lasts = {
        "lasting": core.begin.size,
        "memory": subject.memory_size,
        "varying": len(varied),
        "held": len(held),
        "slope": len(varied) + 2,
    }

    built = partial(_built, builder, core, lasts, scope)
    rates = built(
        "flowing", flowing, ["varying", "held", "slope", *inputs, *parameters], ("slope",)
    )
    entering = [
        part.name in ("varying", "slope", *inputs) or nowhere(part.type)
        for part in rates.parameters
    ]
    return Exchange(
        rates,
        built(
            "begun",
            [*begun, *stores],
            ["lasting", "memory", "varying", "held", *along, "p"],
            ("varying", "held"),
        ),
        built("arrived", arrived, ["lasting", "memory", "varying", "p"], ("lasting", "memory")),
        derived_in(builder, rates, entering)[1],
        dict(zip(varied, variables, strict=True)),
        tuple(held),
    )


def _built(
    builder: Builder,
    core: Core,
    lasts: Mapping[str, int],
    scope: dict[str, Any],
    name: str,
    lines: list[str],
    arguments: list[str],
    writes: tuple[str, ...],
) -> Function:
    """Return a function of these lines; it writes some of the arrays of the exchange."""
    text = textwrap.indent("\n".join(map(textwrap.dedent, lines)), "    ")
    kinds: dict[str, Type] = {}
    for array, size in lasts.items():
        kinds[array] = Array(size, writable=array in writes)
    for argument, (_, kind) in core.parameters.items():
        kinds[argument] = kind
    kernel = defined(name, f"def {name}({', '.join(arguments)}):\n{text}\n", scope)
    return builder.function(kernel, [kinds.get(argument, REAL) for argument in arguments])


class _States(NamedTuple):
    """Structures of contact, piece and body; names of the continuous states; largest integers of what is held between events."""

    contact: Struct
    piece: Struct | None
    body: Struct | None
    varied: list[str]
    held: list[int]


def _states_of(core: Core, builder: Builder) -> _States:
    """Return the continuous states, body before contact, and the data that an event sets: the piece, then the contact at the event."""
    subject = core.subject
    plant = core.plant
    contact = subject.state
    piece = None
    if subject.model.component.flow is not None:
        contact, piece = piece_of(subject, builder)
    body = None
    varied = []
    if plant is not None:
        body = struct_type(plant.component.initial_state(plant.parameters))
        varied = [name for name, _ in body.fields]
    of_contact = {name: name for name, _ in contact.fields}
    of_contact |= {name: f"contact_{name}" for name in varied if name in of_contact}
    varied += of_contact.values()
    held = []
    if piece is not None:
        held = [
            capacity_of(name, subject.memory_size) + 1 if kind == INTEGER else 0
            for name, kind in piece.fields
        ]
        held += [0] * len(contact.fields)
    return _States(contact, piece, body, varied, held)


def _variables(
    subject: Subject, plant: Model | None, contact: Struct
) -> tuple[float, list[Variable]]:
    """Return the pre-sliding distance and the states, each with the nominal value for the contact."""
    # Nominal length: half of the largest force of the contact is reached; nominal force: the largest; nominal velocity:
    # the mass has the energy of this work.
    force = np.abs(subject.forces(np.concatenate(([0.0], FARTHER[1:])), SLOW))
    largest = float(np.max(force))
    sizes = {"force": largest, "length": float(FARTHER[np.argmax(force >= 0.5 * largest)])}
    listed: list[Variable] = []
    if plant is not None:
        body = plant.component.initial_state(plant.parameters)
        q = plant.parameters
        rise = (
            plant.component.rate(body, largest, 0.0, q).v
            - plant.component.rate(body, 0.0, 0.0, q).v
        )
        sizes["length/time"] = math.sqrt(rise * sizes["length"])
        listed += variables_of(type(body)).values()
    try:
        listed += variables_of(contact.cls).values()
    except TypeError:  # a user's contact may lack descriptions
        listed += [Variable("1", f"{name}, which varies") for name, _ in contact.fields]
    return sizes["length"], [
        replace(variable, nominal=sizes.get(variable.quantity) or variable.nominal)
        for variable in listed
    ]
