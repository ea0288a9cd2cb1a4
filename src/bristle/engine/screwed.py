r"""Two ports for friction: the load of a motor by a table with friction and an elastic screw, as one friction model.

Over a step of length `h` the motor turns at the mean velocity :math:`v_m`. The table follows at :math:`v_t`, converted to
the motor, so that with the half gap :math:`g` and the twist :math:`\delta` between them

.. math::
    \frac{2M}{h}(v_t - v_{t,0}) + F_t(v_t) = f_s, \qquad
    f_s = \left(k\,\frac{D_1 + D_0}{2} + \frac{d}{h}(D_1 - D_0)\,\right)
          \frac{D_1 - D_0}{\delta_1 - \delta_0}, \qquad
    D = \delta - \max(-g, \min(g, \delta))

with :math:`\delta_1 = \delta_0 + h\,(v_m - v_t)`. The elastic part is the discrete gradient of the energy
:math:`\tfrac12 k D^2`, so that a screw without damping, even with backlash, conserves energy to rounding. The left side
rises with :math:`v_t` and the right side falls: the root is unique, and the bracketed solve of the motor also finds it.
It is nested in the solve for the motor, because alternating between the two would converge slowly if :math:`k h^2` is
large relative to the masses.

The table sticks by the rule of the motor: between the one-sided limits at rest the force is the reaction. A step in
which the table would reverse ends with the table at rest; its friction is the force that this requires.
"""

import re
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from bristle.core import FrictionModel, InputError, Model, Variable, dispatch, kernel
from bristle.core.dispatch import friction_commit, friction_trial
from bristle.core.lazy import cached_property, once
from bristle.core.motion import Motion
from bristle.core.read_only import ReadOnly
from bristle.engine.efim import Start, evaluate, is_set_valued, solve
from bristle.models.friction import viscous

# Indices of position and velocity of the table in the state.
TABLE = slice(0, 2)


class Screwed(NamedTuple):
    """Both friction models and the screw between them, converted to the motor."""

    motor: Any
    table: Any
    M: float
    k: float
    d: float
    gap: float
    arm: float
    motor_memory: int


class Apart(NamedTuple):
    """The same for an export, with `Memories`."""

    motor: Any
    table: Any
    M: float
    k: float
    d: float
    gap: float
    arm: float


class Memories(NamedTuple):
    """Memories of both friction models, as separate arrays."""

    motor: Any
    table: Any


class State(NamedTuple):
    """The table, converted to the motor, the twist of the screw, and the states of both friction models."""

    x: float
    v: float
    twist: float
    motor: Any
    table: Any


class Move(NamedTuple):
    """Result of a trial for commit."""

    x: float
    v: float
    twist: float
    motor: Any
    table: Any


class Pulled(NamedTuple):
    """Loads of the table in a step in which the motor turns at `v_m`: its friction, and the screw against it."""

    table: Any
    k: float
    d: float
    gap: float
    arm: float
    v_m: float
    twist: float


@kernel
def screw_force(twist, turned, dt, q):
    """Return the torque [N*m] that the screw transmits while its twist grows by `turned` [rad] in `dt` [s]."""
    after = twist + turned
    before_touch = twist - max(-q.gap, min(q.gap, twist))
    after_touch = after - max(-q.gap, min(q.gap, after))
    stretched = after_touch - before_touch
    if turned == 0.0:
        share = 0.0 if before_touch == 0.0 and q.gap > 0.0 else 1.0
    else:
        share = stretched / turned
    rate = stretched / dt if dt > 0.0 else 0.0
    return (0.5 * q.k * (before_touch + after_touch) + q.d * rate) * share


@kernel
def pulled_trial(state, memory, motion, dt, p):
    """Return the force against the table, converted to the motor: its friction minus the force of the screw."""
    force, move = friction_trial(
        state,
        memory,
        Motion(
            p.arm * motion.v,
            p.arm * motion.x,
            motion.load,
            motion.temperature,
            motion.transmitted / p.arm,
        ),
        dt,
        p.table,
    )
    return p.arm * force - screw_force(p.twist, dt * (p.v_m - motion.v), dt, p), move


@kernel
def pulled_commit(state, memory, move, p):
    """Return the state of the friction of the table after the step."""
    return friction_commit(state, memory, move, p.table)


dispatch.register("friction", Pulled, {"trial": pulled_trial, "commit": pulled_commit})


@kernel
def trial_of(state, own, behind, motion, dt, p):
    """Return the mean torque [N*m] against the motor at a mean velocity, and the moves of both sides, with their memories."""
    pulled = Pulled(p.table, p.k, p.d, p.gap, p.arm, motion.v, state.twist)
    half = 0.5 * dt / p.M
    start = Start(state.v, 1.0 + half * (0.5 * p.k * dt + p.d), 0.0)
    solution = solve(state.table, behind, state.x, 0.0, dt, pulled, state.v, -half, start)
    v, v_next, table = solution.v, 2.0 * solution.v - state.v, solution.move
    if state.v == 0.0:
        if v == 0.0:
            v_next = 0.0
    elif state.v * v_next < 0.0 and is_set_valued(state.table, behind, state.x, 0.0, dt, pulled):
        v, v_next = 0.5 * state.v, 0.0
        _, table = evaluate(state.table, behind, v, state.x, (v - state.v) / half, dt, pulled)
    turned = dt * (motion.v - v)
    pull = screw_force(state.twist, turned, dt, p)
    # The effort minus the friction of the motor accelerates the motor and loads the screw.
    passed = Motion(motion.v, motion.x, motion.load, motion.temperature, motion.transmitted + pull)
    force, motor = friction_trial(state.motor, own, passed, dt, p.motor)
    move = Move(state.x + dt * v, v_next, state.twist + turned, motor, table)
    return force + pull, move


@kernel
def commit_of(state, own, behind, move, p):
    """Return the state of both sides after the step, with their memories."""
    motor = friction_commit(state.motor, own, move.motor, p.motor)
    table = friction_commit(state.table, behind, move.table, p.table)
    return State(move.x, move.v, move.twist, motor, table)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean torque [N*m] against the motor at a mean velocity, and the moves of both sides."""
    return trial_of(state, memory[: p.motor_memory], memory[p.motor_memory :], motion, dt, p)


@kernel
def commit(state, memory, move, p):
    """Return the state of both sides after the step."""
    return commit_of(state, memory[: p.motor_memory], memory[p.motor_memory :], move, p)


@kernel
def trial_apart(state, memory, motion, dt, p):
    """Return the mean torque and the moves, with separate memories."""
    return trial_of(state, memory.motor, memory.table, motion, dt, p)


@kernel
def commit_apart(state, memory, move, p):
    """Return the state of both sides after the step, with separate memories."""
    return commit_of(state, memory.motor, memory.table, move, p)


@dataclass(frozen=True, kw_only=True)
class ScrewedModel(FrictionModel):
    """Load of a motor by its friction, a screw, and a table with friction."""

    motor: FrictionModel
    table: FrictionModel

    def _made_by(self) -> tuple[Any, tuple[Any, ...]]:
        return _screwed, (self.motor, self.table, self.Parameters)

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Parameters of the friction of the motor, and of the table in units of travel."""
        motor = {f"motor_{name}": variable for name, variable in self.motor.variables.items()}
        return ReadOnly(
            motor
            | {
                f"table_{name}": of_travel(variable)
                for name, variable in self.table.variables.items()
            }
        )

    def values(self, parameters: Any) -> dict[str, Any]:
        """Convert the parameters of kernels to user values of both sides."""
        motor = {
            f"motor_{name}": value for name, value in self.motor.values(parameters.motor).items()
        }
        return motor | {
            f"table_{name}": value for name, value in self.table.values(parameters.table).items()
        }

    def memory_sizes(self, parameters: Any) -> Memories:
        """Return the number of values in each memory."""
        return Memories(
            self.motor.memory_size(parameters.motor), self.table.memory_size(parameters.table)
        )

    def initial_state(self, parameters: Any) -> State:
        """Return the virgin state, the table at rest at 0."""
        motor, table = (
            self.motor.initial_state(parameters.motor),
            self.table.initial_state(parameters.table),
        )
        return State(0.0, 0.0, 0.0, motor, table)


def of_travel(variable: Variable) -> Variable:
    """Return a variable of the table, whose force and length are not those of the motor."""
    quantity = re.sub(r"\b(force|mass)\b", r"\1 of travel", variable.quantity)
    return replace(variable, quantity=re.sub(r"\blength\b", "travel", quantity))


@once
def _screwed(motor: FrictionModel, table: FrictionModel, parameters: type) -> ScrewedModel:
    apart = parameters is Apart
    return ScrewedModel(
        name=f"{motor.name} | {table.name}",
        description="friction on either side of a screw",
        Parameters=parameters,
        State=State,
        trial=trial_apart if apart else trial,
        commit=commit_apart if apart else commit,
        memory_size=lambda p: motor.memory_size(p.motor) + table.memory_size(p.table),
        motor=motor,
        table=table,
    )


def through_screw(
    plant: Model, friction: Model, table: Model | None, *, exported: bool = False
) -> Model:
    """Return the load of the motor of a plant with a screw as one friction model; for an export, with `Memories`."""
    if plant.component.screw is None:
        raise InputError(
            "the plant has no table behind a screw",
            path="table",
            value=plant.name,
            allowed="ball_screw",
            mend="Omit table",
        )
    table = table if table is not None else viscous(F_v=0.0)
    for path, model, kind in (
        ("friction", friction, plant.kind),
        ("table", table, "translational"),
    ):
        if model.kind != kind:
            raise InputError(
                f"must be {kind}",
                path=path,
                value=f"{model.name}, {model.kind}",
                mend=f"The motor is {plant.kind}, and the table travels (N and m)",
            )
    M, k, d, gap, arm = plant.component.screw(plant.parameters)
    at_motor = (
        friction.parameters,
        table.parameters,
        M * arm * arm,
        k * arm * arm,
        d * arm * arm,
        gap / arm,
        arm,
    )
    own = friction.component.memory_size(friction.parameters)
    joined = Apart(*at_motor) if exported else Screwed(*at_motor, own)
    return Model(_screwed(friction.component, table.component, type(joined)), joined, plant.kind)


def refuse_screw(plant: Model, caller: str) -> None:
    """Refuse a plant with a screw in a simulation of one mass."""
    if plant.component.screw is not None:
        raise InputError(
            f"has a screw, but {caller} simulates one mass only",
            path="plant",
            value=plant.name,
            mend="Use run_open_loop, run_closed_loop, or plants.inertia with the sum of both masses",
        )
