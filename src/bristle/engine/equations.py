"""State equations of friction: its right-hand side as a differential equation, and the steps of the engine as a sampled system."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.core import InputError, Model, guarded, model, optional, unit_of, variables_of
from bristle.core.dispatch import friction_rate, friction_trial, plant_rate
from bristle.core.motion import Motion
from bristle.core.packing import pack, unpacker
from bristle.engine.checks import FRICTION, PERIOD, STEPS
from bristle.engine.entry_points import ACCELERATION, FORCE, OUT_SIZE, SLOPE, MechanismVectors
from bristle.engine.instance import Instance, warn_of_lost
from bristle.engine.loop import substeps_entry
from bristle.engine.motion import force_along_entry
from bristle.engine.screwed import refuse_screw
from bristle.models.friction import is_static

SAMPLED = 'Give dt, such as dt="0.5 ms": bristle then returns a sampled system'

# Names for the fields x and v of a plant.
PLANT_NAMES = {"x": "position", "v": "velocity"}
SOLVER = {"solver_slope": "1/s", "solver_acceleration": ""}
"""Start values of the next solve; without them the last bits would differ. The unit is that of the axis."""

# From a state and an input [N, N*m or m/s, rad/s] to the friction force [N or N*m] and the time derivative of the state;
# for a sampled system, the mean force of the step and the next state, which overwrites the first state.
Advance = Callable[[np.ndarray, float], tuple[float, np.ndarray]]


def axis_equations(plant: Model, friction: Model) -> Advance:
    """Return the equations of a plant with friction under an effort: the state is that of the plant, then of friction."""
    if plant.component.rate is None:
        raise InputError(
            "has no rate, so it is not a differential equation",
            path="plant",
            value=plant.name,
            mend=SAMPLED,
        )
    body, contact, rate = Instance(plant), Instance(friction), _rate_of(friction)
    q, p, count = plant.parameters, friction.parameters, body.state.size
    load_plant, load_contact = unpacker(body.structures[1]), unpacker(contact.structures[1])

    def at(state: np.ndarray, effort: float) -> tuple[float, np.ndarray]:
        moved = load_plant(state)
        force, d_contact = rate(load_contact(state[count:]), Motion(moved.v, moved.x), p)
        return force, np.concatenate((pack(plant_rate(moved, effort, force, q)), pack(d_contact)))

    return at


def contact_equations(friction: Model) -> Advance:
    """Return the equations of friction under a velocity: the state is the position, then that of the friction."""
    contact, rate, p = Instance(friction), _rate_of(friction), friction.parameters
    load = unpacker(contact.structures[1])

    def at(state: np.ndarray, velocity: float) -> tuple[float, np.ndarray]:
        force, d_contact = rate(load(state[1:]), Motion(velocity, float(state[0])), p)
        return force, np.concatenate(((velocity,), pack(d_contact)))

    return at


def _rate_of(friction: Model) -> Callable[..., Any]:
    """Return ``rate(state, motion, p) -> (force, d_state)`` of a friction model; refuse a model without it."""
    if friction.component.rate is not None:
        return friction_rate
    message, mend = "has no `rate`, so it is not a differential equation", SAMPLED
    if is_static(friction):
        forward, backward = (
            friction_trial((), (), Motion(v, 0.0), 0.0, friction.parameters)[0] for v in (0.0, -0.0)
        )
        if forward == backward:
            return lambda state, motion, p: (friction_trial(state, (), motion, 0.0, p)[0], state)
        message = "has a force that jumps at rest, where the contact sticks, so it is not a differential equation"
    elif friction.component.memory_size(friction.parameters):
        message = "changes its memory in jumps, at reversals or when an element slips, so it is not a differential equation"
    else:
        mend = f"{SAMPLED}. A smooth model of your own can define `rate(state, motion, p) -> (force, d_state)`"
    raise InputError(message, path="friction", value=friction.name, mend=mend)


def axis_step(plant: Model, friction: Model, dt: float, steps: int) -> Advance:
    """Return one sample of a plant with friction under a constant effort; state: plant, friction, memory, `SOLVER`."""
    body, contact = Instance(plant), Instance(friction)
    memory_size = friction.component.memory_size(friction.parameters)
    cuts = np.cumsum((body.state.size, contact.state.size, memory_size))
    entry = substeps_entry(body, contact)

    def step(state: np.ndarray, effort: float) -> tuple[float, np.ndarray]:
        plant_state, friction_state, memory, solver = np.split(state, cuts)
        out = np.zeros(OUT_SIZE)
        out[SLOPE], out[ACCELERATION] = solver
        vectors = MechanismVectors(
            body.parameters, plant_state, contact.parameters, friction_state, memory, out
        )
        entry(vectors, effort, effort, dt, steps)
        solver[:] = out[SLOPE], out[ACCELERATION]
        contact.state = friction_state
        warn_of_lost(contact)
        return float(out[FORCE]), state

    return step


def contact_step(friction: Model, dt: float) -> Advance:
    """Return a function for one sample of friction at a velocity; its state holds position, friction state and memory."""
    contact = Instance(friction)
    cuts = np.cumsum((1, contact.state.size))
    entry = force_along_entry(contact)
    around = np.array(list(contact.motion._field_defaults.values()), dtype=float)

    def step(state: np.ndarray, velocity: float) -> tuple[float, np.ndarray]:
        position, friction_state, memory = np.split(state, cuts)
        position += velocity * dt
        v, force = np.full(1, velocity), np.empty(1)
        entry(contact.parameters, friction_state, memory, v, position, around, dt, force)
        contact.state = friction_state
        warn_of_lost(contact)
        return float(force[0]), state

    return step


QUANTITIES = {
    "effort": "force",
    "friction": "force",
    "position": "length",
    "velocity": "length/time",
}


class System(NamedTuple):
    """An axis with its friction, or friction alone: next state or derivative, outputs, and the unit of each signal."""

    following: Callable[..., np.ndarray]
    output: Callable[..., np.ndarray]
    states: dict[str, str]
    inputs: dict[str, str]
    outputs: dict[str, str]
    name: str
    dt: float


@guarded(friction=FRICTION, plant=optional(model("plant")), dt=optional(PERIOD), steps=STEPS)
def system_of(
    friction: Model, plant: Model | None, dt: Any, steps: int, name: str | None, *, asked_by: str
) -> System:
    """Return an axis with its friction or friction alone as a differential equation, or as a sampled system if `dt` is given.

    The zero state is a virgin contact at rest. `asked_by` is the function that the user called.
    """
    if plant is not None:
        refuse_screw(plant, asked_by)
    if steps != 1 and (dt is None or plant is None):
        raise InputError(
            "needs a sampled axis",
            path="steps",
            value=steps,
            mend="Give dt and a plant, or omit steps",
        )
    if plant is None:
        advance = contact_equations(friction) if dt is None else contact_step(friction, dt)
    else:
        advance = (
            axis_equations(plant, friction) if dt is None else axis_step(plant, friction, dt, steps)
        )
    states = _states_of(friction, plant, is_sampled=dt is not None)
    motion = () if plant is None else ("position", "velocity")
    following, output = _functions_of(
        advance, _virgin(friction, plant, len(states)), len(motion), is_sampled=dt is not None
    )
    units = {signal: unit_of(quantity, friction.kind) for signal, quantity in QUANTITIES.items()}
    inputs = {signal: units[signal] for signal in (["velocity"] if plant is None else ["effort"])}
    outputs = {signal: units[signal] for signal in (*motion, "friction")}
    return System(
        following,
        output,
        states,
        inputs,
        outputs,
        friction.name.replace("+", "_") if name is None else name,
        dt or 0,
    )


def _virgin(friction: Model, plant: Model | None, size: int) -> np.ndarray:
    """Return the state of a virgin contact at rest."""
    # The contact follows the plant, or the position.
    before, p = len(plant.component.State._fields) if plant else 1, friction.parameters
    contact = np.concatenate(
        (pack(friction.component.initial_state(p)), friction.component.new_memory(p))
    )
    virgin = np.zeros(size)
    virgin[before : before + contact.size] = contact[: size - before]
    return virgin


def _functions_of(
    advance: Advance, virgin: np.ndarray, motion: int, *, is_sampled: bool
) -> tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]:
    """Return two functions ``f(t, x, u, params)``: next state or derivative, and outputs, beginning with `motion` numbers of the state."""
    # Adding zero would remove the sign of a zero, which marks the side of a contact.
    places = np.flatnonzero(virgin)

    def advanced(x: Any, u: Any) -> tuple[float, np.ndarray]:
        state = np.array(x, dtype=float)  # a copy, because a sample may be requested again
        state[places] += virgin[places]
        return advance(state, float(u[0]))

    def following(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
        _, state = advanced(x, u)
        if is_sampled:
            state[places] -= virgin[places]
        return state

    def output(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
        return np.array((*x[:motion], advanced(x, u)[0]))

    return following, output


def _states_of(friction: Model, plant: Model | None, *, is_sampled: bool) -> dict[str, str]:
    """Return the unit of each state, by its name, in the order of the vector."""
    kind, component = friction.kind, friction.component
    parts = {"position": unit_of("length", kind)}
    if plant is not None:
        variables = variables_of(plant.component.State)
        parts = {
            PLANT_NAMES.get(name, name): variable.unit(kind) for name, variable in variables.items()
        }
    for name, variable in variables_of(component.State).items():
        parts[f"contact_{name}" if name in parts else name] = variable.unit(kind)
    if is_sampled:
        parts |= {f"memory_{k}": "" for k in range(component.memory_size(friction.parameters))}
    if is_sampled and plant is not None:
        parts |= {name: unit or unit_of("length/time^2", kind) for name, unit in SOLVER.items()}
    return parts
