r"""Adaptive steps by step doubling: one step of EFIM against two of half its length, memory kept until both are done.

The scheme is the same for every friction model, and so is the estimate of its error, the difference between the two
results. A rejected step has no effect: the mechanism, including its memory, is restored.

While the contact is loading there is no extrapolation: at a kink (a reversal, the wiping-out of a loop, an arrest) it
would be useless, and it would separate the position from the deflection. Far into sliding, after several pre-sliding
distances, the contact only follows the motion. There the two results are extrapolated to order 4, and the remaining
error is estimated from the removed one: with the difference :math:`e` and the distance :math:`\ell`, both of one time
scale :math:`\tau`, :math:`e/\ell \sim (h/\tau)^2`, so that :math:`e^2/\ell` remains.

If a body stops inside a step, exact ends are not enough: the cubic that interpolates the samples does not include the
stop, where the force jumps. Its deviation there is also an error of the step, if the step contains a sample.

A body at rest hides its break-away from any such estimate, because both results are equal. Therefore, after each step
that ends at rest, the integrator computes how long the body can rest, and ends the next step at this time.

Where the error of steps jumps, as at kinks, proportional-integral control smooths the step length.

References
----------
.. [1] K. Gustafsson, "Control-theoretic techniques for stepsize selection in implicit Runge-Kutta methods", ACM
   Transactions on Mathematical Software 20(4), 1994. doi:10.1145/198429.198437
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.core.dispatch import plant_port, plant_rest
from bristle.core.kernel import kernel
from bristle.core.mathematics import Bracket, bracket_guess, bracket_update, power
from bristle.core.packing import Structure, unpacker
from bristle.engine.drivers import BOUND
from bristle.engine.efim import INFINITY, evaluate
from bristle.engine.entry_points import (
    ACCELERATION,
    FAILED,
    FORCE,
    SLACK,
    SLOPE,
    MechanismVectors,
    Substeps,
)
from bristle.engine.signature import Vector

# Length of a step, as a share of another step, whose mean force is the force at an instant.
INSTANT = 1e-9
BISECTIONS = 60
# Share of the allowed error for the solves.
SHARE_OF_SOLVES = 0.01
# Safety factor on the estimated error after an extrapolation: with a tenth of it, a mass on a spring that slides for metres
# exceeded the tolerance by a factor of two.
CAUTION = 100.0
SAFETY = 0.9
SMALLEST_FACTOR, LARGEST_FACTOR = 0.2, 4.0
PROPORTIONAL, INTEGRAL = 0.7, 0.4
SMALLEST_ERROR = 1e-4
ROUNDING = 1e-15  # share of the position below which its error is rounding
GIVE_UP = 1000.0  # inexact steps of the shortest length before the run ends


class Course(NamedTuple):
    """A piecewise linear effort with `knots` [s]: values at the beginning and at the end of each stretch."""

    knots: Vector
    starts: Vector
    ends: Vector


class Limits(NamedTuple):
    """Allowed error per time [m/s or rad/s] and per step [m or rad]; longest, shortest and first step [s].

    A contact that slides over the distance `far` [m or rad] in one step only follows the motion. `between` is the allowed
    error of the position at a sample inside a step [m or rad], which does not accumulate.
    """

    per_time: float
    per_step: float
    longest: float
    shortest: float
    first: float
    far: float
    between: float


class Samples(NamedTuple):
    """Times of the samples [s], with position, velocity, and impulse of the friction until then."""

    times: Vector
    x: Vector
    v: Vector
    impulse: Vector


class DoublingEntries(NamedTuple):
    """Entries of the integration, with equal arguments: equal steps, and the remaining time of a body at rest."""

    substeps: Substeps
    rest_time: Substeps


class Half(NamedTuple):
    """One half of a step of `h` [s] that begins at `t` [s]; `part` of the step precedes it.

    Position and velocity at its beginning and its end, the mean friction forces [N or N*m] of both halves, and the
    impulse of the friction [N*s or N*m*s] at the beginning of the step.
    """

    t: float
    h: float
    part: float
    x_0: float
    v_0: float
    x_1: float
    v_1: float
    force_1: float
    force_2: float
    impulse: float


@kernel
def length_factor(error, error_last, order):
    """Return the factor of the step length after an error.

    Both errors, of this step and of the last step, are divided by the allowed error; the error is proportional to the
    power `order` of the step length.
    """
    if not error <= 1e300:
        return SMALLEST_FACTOR
    now, last = max(error, SMALLEST_ERROR), max(error_last, SMALLEST_ERROR)
    factor = SAFETY * power(now, -PROPORTIONAL / order) * power(last, INTEGRAL / order)
    return max(SMALLEST_FACTOR, min(LARGEST_FACTOR, factor))


@kernel(inline=False)
def reserve(body, s, memory, effort, dt, q, p):
    """Return the force reserve [N or N*m] until a body at rest breaks away; negative if it cannot rest.

    It is infinite for a model that is not set-valued, because it has no rest.
    """
    a, b = plant_port(body, effort, dt, q)
    forward, _ = evaluate(s, memory, 0.0, body.x, effort + a / b, dt, p)
    backward, _ = evaluate(s, memory, -0.0, body.x, effort + a / b, dt, p)
    if not forward > backward:
        return INFINITY
    return min(forward + a / b, -a / b - backward)


def make_rest_time(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Callable[..., Any]:
    """Return the entry for the time within a step [s] at which a body at rest breaks away; `dt` if it does not.

    Its arguments are those of `Substeps`.
    """
    unpack_plant, load_plant = unpacker(plant), unpacker(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)

    def rest_time(vectors, effort, effort_end, dt, steps):
        q, body = unpack_plant(vectors.plant), load_plant(vectors.plant_state)
        p, s, memory = (
            unpack_friction(vectors.friction),
            load_friction(vectors.friction_state),
            vectors.memory,
        )
        rise, time, guess, bracket = (
            (effort_end - effort) / dt,
            dt,
            dt,
            Bracket(0.0, -1.0, dt, 1.0, 0.0),
        )
        for count in range(BISECTIONS):
            if count > 1 and bracket.high - bracket.low <= 1e-12 * dt:
                break
            body_then = plant_rest(body, effort + 0.5 * guess * rise, guess, q)
            left = reserve(body_then, s, memory, effort + guess * rise, INSTANT * dt, q, p)
            if count == 0:
                if left >= 0.0:
                    return dt
                bracket, guess = Bracket(0.0, -1.0, dt, -left, 0.0), 0.0
            elif count == 1:
                if left <= 0.0:
                    return 0.0
                bracket = Bracket(0.0, -left, dt, bracket.f_high, 0.0)
                guess = bracket_guess(bracket)
            else:
                bracket = bracket_update(bracket, guess, -left)
                guess = bracket_guess(bracket)
            time = bracket.high
        return time

    return rest_time


@kernel
def copy(source, target):
    """Copy the numbers of one vector into another of the same length."""
    for i in range(source.size):
        target[i] = source[i]


@kernel
def on_cubic(part, half, x_0, v_0, x_1, v_1):
    """Return the position after this part of a half, on the cubic through both ends."""
    slope, rest = (x_1 - x_0) / half, 1.0 - part
    return (
        rest * x_0 + part * x_1 + half * part * rest * (rest * (v_0 - slope) - part * (v_1 - slope))
    )


@kernel
def astray(half, x_0, v_0, x_1, v_1):
    """Return the deviation of the cubic from the path of a body that stops inside, where the force jumps."""
    if v_0 == 0.0 or v_0 * v_1 > 0.0:
        return 0.0
    stop = max(0.0, min(half, (2.0 * (x_1 - x_0) - v_1 * half) / (v_0 - v_1)))
    at_stop = abs(on_cubic(stop / half, half, x_0, v_0, x_1, v_1) - (x_0 + 0.5 * v_0 * stop))
    # The cubic may cross the path at the stop, but not also half-way to it.
    return max(
        at_stop,
        abs(on_cubic(0.5 * stop / half, half, x_0, v_0, x_1, v_1) - (x_0 + 0.375 * v_0 * stop)),
    )


@kernel
def sampled(k, half_step, samples):
    """Write the samples from number `k` on in one half of a step; return the number of the next sample.

    Position and velocity follow the cubic through both ends. Friction is linear over the whole step, through the means
    of its halves.
    """
    t, h, part_0, x_0, v_0, x_1, v_1, force_1, force_2, total = half_step
    half = 0.5 * h
    slope = (x_1 - x_0) / half
    bend_0, bend_1 = v_0 - slope, v_1 - slope
    times = samples.times
    while k < times.size and times[k] <= t + half:
        part = (times[k] - t) / half
        rest = 1.0 - part
        samples.x[k] = on_cubic(part, half, x_0, v_0, x_1, v_1)
        samples.v[k] = (
            slope
            + (rest * rest - 2.0 * part * rest) * bend_0
            + (part * part - 2.0 * part * rest) * bend_1
        )
        share = part_0 + 0.5 * part
        samples.impulse[k] = total + h * share * (force_1 + (force_2 - force_1) * (share - 0.5))
        k += 1
    return k


@kernel
def slides(body_0, x_middle, v_middle, body, far):
    """Return whether the contact slid over `far` [m or rad] in each half of a step, without a reversal."""
    forward = body_0[1] > 0.0 and v_middle > 0.0 and body[1] > 0.0
    backward = body_0[1] < 0.0 and v_middle < 0.0 and body[1] < 0.0
    return (forward or backward) and min(abs(x_middle - body_0[0]), abs(body[0] - x_middle)) > far


@kernel
def extrapolate(fine, coarse):
    """Cancel the leading error of a result of order 2 with a result of doubled step length."""
    for i in range(fine.size):
        fine[i] += (fine[i] - coarse[i]) / 3.0


@kernel
def remember(vectors, before):
    """Copy the present mechanism into the vectors of the mechanism before a step."""
    copy(vectors.plant_state, before.plant_state)
    copy(vectors.friction_state, before.friction_state)
    copy(vectors.memory, before.memory)


def doubling(
    run: DoublingEntries,
    vectors: MechanismVectors,
    before: MechanismVectors,
    full_step: MechanismVectors,
    course: Course,
    limits: Limits,
    samples: Samples,
    report: Vector,
) -> int:
    """Drive a plant with friction by a piecewise linear effort.

    `before` stores the mechanism before a step, `full_step` is for the whole step and shares the memory. `report`
    receives the numbers of accepted steps, rejected steps, steps that missed the tolerance, and solves that missed it.
    Returns the number of samples reached: all, unless the motion diverged or too many steps missed the tolerance.
    """
    substeps, rest_time = run
    body, body_0, body_1 = vectors.plant_state, before.plant_state, full_step.plant_state
    out, out_1, wish = vectors.out, full_step.out, limits.first
    error_last, total, k, h_last, acceleration, bend = 1.0, 0.0, 0, 0.0, 0.0, 0.0
    for segment in range(course.starts.size):
        t, t_end, u = course.knots[segment], course.knots[segment + 1], course.starts[segment]
        rise, rests_until = (course.ends[segment] - u) / (t_end - t), INFINITY
        while t < t_end:
            left = min(t_end, rests_until) - t
            h = min(wish, limits.longest)
            is_last = h >= left * (1.0 - 1e-9)
            h = left if is_last else min(h, 0.5 * left)
            is_cut, u_middle, u_end = h < wish, u + 0.5 * h * rise, u + h * rise
            remember(vectors, before)
            copy(body, body_1)
            copy(vectors.friction_state, full_step.friction_state)
            # Each solve begins at the linear extrapolation of the mean acceleration.
            allowed = max(min(limits.per_time * h, limits.per_step), ROUNDING * abs(body[0]))
            slack = SHARE_OF_SOLVES * allowed / h
            expected = acceleration + bend * (0.25 * h_last + 0.5 * h)
            out_1[SLOPE], out_1[ACCELERATION], out_1[SLACK] = out[SLOPE], expected, slack
            substeps(full_step, u, u_end, h, 1)
            copy(before.memory, vectors.memory)
            out[SLOPE], out[ACCELERATION], out[SLACK] = (
                out_1[SLOPE],
                out_1[ACCELERATION] - 0.25 * h * bend,
                slack,
            )
            substeps(vectors, u, u_middle, 0.5 * h, 1)
            x_middle, v_middle, force_1, failures, early = (
                body[0],
                body[1],
                out[FORCE],
                out[FAILED],
                out[ACCELERATION],
            )
            out[ACCELERATION] = 2.0 * out_1[ACCELERATION] - early
            substeps(vectors, u_middle, u_end, 0.5 * h, 1)
            error = abs(body[0] - body_1[0]) + 2.0 * h * abs(body[1] - body_1[1])
            if slides(body_0, x_middle, v_middle, body, limits.far):
                x_middle += (body[0] - body_1[0]) / 6.0
                v_middle += (body[1] - body_1[1]) / 6.0
                extrapolate(body, body_1)
                error *= CAUTION * error / (h * min(abs(body_0[1]), abs(body[1])))
            error /= allowed
            if k < samples.times.size and samples.times[k] < t + h:
                first_half = astray(0.5 * h, body_0[0], body_0[1], x_middle, v_middle)
                strayed = max(first_half, astray(0.5 * h, x_middle, v_middle, body[0], body[1]))
                error = max(error, strayed / limits.between)
            rest = h
            if body[1] == 0.0 and rests_until == INFINITY:
                if body_0[1] == 0.0:
                    rest = rest_time(before, u, u_end, h, 1)
                elif rest_time(vectors, u_end, u_end, INSTANT * h, 1) == 0.0:
                    rest = 0.5 * h
            if h > limits.shortest and (rest < h or not error <= 1.0):
                remember(before, vectors)
                report[1] += 1.0
                if rest < h and body_0[1] == 0.0 and rest > limits.shortest:
                    rests_until = t + rest
                else:
                    wish = max(limits.shortest, min(rest, h * length_factor(error, 1.0, 2.0)))
                continue
            force_2 = out[FORCE]
            first = Half(
                t, h, 0.0, body_0[0], body_0[1], x_middle, v_middle, force_1, force_2, total
            )
            second = Half(
                t + 0.5 * h, h, 0.5, x_middle, v_middle, body[0], body[1], force_1, force_2, total
            )
            k = sampled(sampled(k, first, samples), second, samples)
            t = min(t_end, rests_until) if is_last else t + h
            total += 0.5 * h * (force_1 + force_2)
            if not abs(body[0]) + abs(body[1]) < BOUND or report[2] > GIVE_UP:
                return k
            wish = max(
                wish if is_cut else limits.shortest, h * length_factor(error, error_last, 2.0)
            )
            u, error_last, rests_until = u_end, error, INFINITY
            h_last, acceleration, bend = h, out[ACCELERATION], 2.0 * (out[ACCELERATION] - early) / h
            report[0] += 1.0
            report[2] += 1.0 if not error <= 1.0 else 0.0
            report[3] += failures + out[FAILED]
    return k
