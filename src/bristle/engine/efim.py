r"""EFIM: the exponentially fitted implicit midpoint rule, with sticking. One scheme for every friction model.

A plant offers its friction port as :math:`v_m = a + b\,F(v_m)` with :math:`b < 0`: the mean velocity of the step is
affine in the mean force, and the model gives the exponentially fitted mean force at that velocity. A bracketed secant
solves the scalar equation to a residual in the force; then the memory is committed once.

Sticking: the two one-sided limits :math:`v_m = \pm 0` are tried as soon as the iterate would cross zero. If the
residual changes sign between them, the body rests, and the force is the reaction. The midpoint rule alone reverses the
velocity of a body that stops inside a step (:math:`v_1 = 2 v_m - v_0`) and would oscillate for ever. Therefore such a
step is split at the instant of the stop.
"""

from typing import Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion
from bristle.core.dispatch import (
    friction_commit,
    friction_trial,
    plant_port,
    plant_rest,
    plant_step,
)
from bristle.core.kernel import kernel
from bristle.core.mathematics import Bracket, bracket_guess, bracket_update

INFINITY = float("inf")
# Tolerances of the solve: of the force, and of the velocity.
FORCE_TOLERANCE, VELOCITY_TOLERANCE = 1e-9, 1e-11
ITERATIONS = 100


class Start(NamedTuple):
    """Start values of a solve, and its allowed error of the mean velocity."""

    guess: float
    slope: float
    slack: float


class Solution(NamedTuple):
    """Mean velocity and force of a step, the move to commit, and the status of the solve."""

    v: float
    force: float
    move: Any
    slope: float
    failures: float


class Advance(NamedTuple):
    """Result of a step."""

    plant_state: Any
    friction_state: Any
    force: float
    v_mean: float
    slope: float
    failures: float


@kernel
def evaluate(state, memory, v, x, transmitted, dt, p):
    """Return the mean force [N or N*m] and the move of a trial at mean velocity `v` [m/s or rad/s] from `x`."""
    motion = Motion(v, x + dt * v, NOMINAL_LOAD, NOMINAL_TEMPERATURE, transmitted)
    return friction_trial(state, memory, motion, dt, p)


@kernel(inline=False)
def evaluate_apart(state, memory, v, x, transmitted, dt, p):
    """Return the result of `evaluate`, in a separate copy of the model for rare cases."""
    return evaluate(state, memory, v, x, transmitted, dt, p)


@kernel
def next_guess(bracket, v, residual, slope):
    """Return the next velocity to evaluate: the secant if it is inside the bracket, otherwise the guess of the bracket."""
    guess = v - residual / slope
    if bracket.low < guess < bracket.high:
        return guess
    if bracket.low > -INFINITY and bracket.high < INFINITY:
        return bracket_guess(bracket)
    # The bracket has no bound on the side of the guess: the slope was negative (falling friction), continue.
    return v - 2.0 * residual


@kernel
def is_solved(residual, force, a, b, slack):
    """Return whether a residual of the velocity [m/s or rad/s] is small relative to the effect of the force."""
    return abs(residual) <= FORCE_TOLERANCE * abs(b * force) + VELOCITY_TOLERANCE * abs(a) + slack


@kernel
def is_narrow(low, high, v):
    """Return whether a bracket is as narrow as rounding allows."""
    return high - low <= 4e-16 * abs(v)


@kernel
def slope_from(slope, v, residual, v_last, residual_last):
    """Return the slope of the residual between the last two velocities; 1 if it does not rise."""
    if residual_last != 0.0 and v != v_last:
        secant = (residual - residual_last) / (v - v_last)
        return secant if secant > 1e-3 else 1.0
    return slope


@kernel
def solve(state, memory, x, effort, dt, p, a, b, start):
    """Return the `Solution` of ``v = a + b * F(v)``; `effort` minus friction is transmitted to the load.

    The guess [m/s or rad/s] and the slope (of the residual, at least 1 if friction rises with speed) come from the last
    step, so that one or two evaluations suffice. The model has one call site, shared by three phases: 0 is an ordinary
    iterate, 1 and 2 are the limits +0 and -0.
    """
    bracket = Bracket(-INFINITY, 0.0, INFINITY, 0.0, 0.0)
    guess, slope = start.guess, max(start.slope, 1.0)
    v = guess
    phase = 1 if guess == 0.0 else 0
    zero_is_known = False
    v_last, residual_last = 0.0, 0.0
    target = guess
    evaluations = 0
    while True:
        at = v if phase == 0 else (0.0 if phase == 1 else -0.0)
        force, move = evaluate(state, memory, at, x, effort - (at - a) / b, dt, p)
        residual = at - a - b * force
        evaluations += 1
        if phase == 0:
            if is_solved(residual, force, a, b, start.slack):
                return Solution(v, force, move, slope, 0.0)
            slope = slope_from(slope, v, residual, v_last, residual_last)
            v_last, residual_last = v, residual
            bracket = bracket_update(bracket, v, residual)
            if is_narrow(bracket.low, bracket.high, v) or evaluations >= ITERATIONS:
                return Solution(v, force, move, slope, 1.0 if evaluations >= ITERATIONS else 0.0)
            target = next_guess(bracket, v, residual, slope)
            crosses = (v > 0.0 and target <= 0.0) or (v < 0.0 and target >= 0.0)
            if crosses and not zero_is_known:
                phase = 1
            else:
                v = target
            continue
        zero_is_known = True
        if phase == 1 and residual >= 0.0:
            phase = 2
            continue
        if phase == 2 and residual <= 0.0:
            # The residual changes sign between the two limits: the body rests and the force is the reaction.
            return Solution(0.0, -a / b, move, slope, 0.0)
        bracket = bracket_update(bracket, 0.0, residual)
        v_last, residual_last = 0.0, residual
        inside = bracket.low < target < bracket.high
        v = target if inside and target != 0.0 else next_guess(bracket, 0.0, residual, slope)
        phase = 0


@kernel(inline=False)
def is_set_valued(state, memory, x, effort, dt, p):
    """Return whether the force at rest is an interval: the one-sided limits at zero velocity differ."""
    forward, _ = evaluate_apart(state, memory, 0.0, x, effort, dt, p)
    backward, _ = evaluate_apart(state, memory, -0.0, x, effort, dt, p)
    return forward > backward


@kernel(inline=False)
def stop_residual(time, plant_state, friction_state, memory, effort, q, p):
    """Return the residual of the mean velocity v/2 [m/s or rad/s] over a step after which the velocity is zero."""
    half = 0.5 * plant_state.v
    a, b = plant_port(plant_state, effort, time, q)
    force, _ = evaluate_apart(
        friction_state, memory, half, plant_state.x, effort - (half - a) / b, time, p
    )
    return half - a - b * force


@kernel(inline=False)
def stopping_time(plant_state, friction_state, memory, effort, dt, q, p):
    """Return the time within the step [s] at which the velocity at the port reaches zero; the mean velocity until then is v/2."""
    half = 0.5 * plant_state.v
    sign = 1.0 if half > 0.0 else -1.0
    bracket = Bracket(0.0, -abs(half), dt, 0.0, 0.0)
    time = dt
    for _ in range(ITERATIONS):
        residual = sign * stop_residual(time, plant_state, friction_state, memory, effort, q, p)
        if abs(residual) <= 1e-15 * abs(half):
            return time
        bracket = bracket_update(bracket, time, residual)
        if bracket.high - bracket.low <= 4e-16 * time:
            return time
        time = bracket_guess(bracket)
    return time


@kernel(inline=False)
def stop_and_go_on(plant_state, friction_state, memory, effort, dt, q, p, slope):
    """Return the `Advance` of a step in which the body stops, split at the instant of zero velocity."""
    first = stopping_time(plant_state, friction_state, memory, effort, dt, q, p)
    half = 0.5 * plant_state.v
    a, b = plant_port(plant_state, effort, first, q)
    transmitted = effort - (half - a) / b if first > 0.0 else effort
    force_1, move = evaluate_apart(
        friction_state, memory, half, plant_state.x, transmitted, first, p
    )
    friction_state = friction_commit(friction_state, memory, move, p)
    _, plant_state = plant_step(plant_state, effort, force_1, first, q)
    plant_state = plant_rest(plant_state, effort, 0.0, q)
    second = dt - first
    if second <= 0.0:
        return Advance(plant_state, friction_state, force_1, 0.0, slope, 0.0)
    a, b = plant_port(plant_state, effort, second, q)
    rest = solve(
        friction_state, memory, plant_state.x, effort, second, p, a, b, Start(0.0, slope, 0.0)
    )
    friction_state = friction_commit(friction_state, memory, rest.move, p)
    _, plant_next = plant_step(plant_state, effort, rest.force, second, q)
    if rest.v == 0.0:
        plant_next = plant_rest(plant_state, effort, second, q)
    force = (force_1 * first + rest.force * second) / dt
    return Advance(plant_next, friction_state, force, rest.v, rest.slope, rest.failures)


@kernel
def advance(plant_state, friction_state, memory, effort, dt, q, p, start):
    """Return the `Advance` over one step of `dt` [s] under a constant `effort` [N or N*m].

    `q` are the parameters of the plant, `p` those of the friction model; `start` has the start values of the solve.
    """
    a, b = plant_port(plant_state, effort, dt, q)
    solution = solve(friction_state, memory, plant_state.x, effort, dt, p, a, b, start)
    _, plant_next = plant_step(plant_state, effort, solution.force, dt, q)
    if plant_state.v == 0.0:
        if solution.v == 0.0:
            plant_next = plant_rest(plant_state, effort, dt, q)
    elif plant_state.v * plant_next.v < 0.0 and is_set_valued(
        friction_state, memory, plant_state.x, effort, dt, p
    ):
        return stop_and_go_on(plant_state, friction_state, memory, effort, dt, q, p, solution.slope)
    friction_state = friction_commit(friction_state, memory, solution.move, p)
    return Advance(
        plant_next, friction_state, solution.force, solution.v, solution.slope, solution.failures
    )
