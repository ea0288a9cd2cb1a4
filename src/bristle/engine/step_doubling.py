r"""Adaptive steps by step doubling: one step of EFIM against two of half its length, memory kept until both are done.

The scheme is the same for every friction model, and so is the estimate of its error, the difference between the two
results. A rejected step leaves no trace: the mechanism, memory included, is put back as it was.

Where the contact is loaded there is no extrapolation: at a kink (a reversal, the wiping-out of a loop, an arrest) it
would be worth nothing, and it would part the position from the deflection. Far into sliding, carried along for several
times its pre-sliding distance, the contact only follows the motion. There the two results are extrapolated, to order 4,
and the error left is told from the one removed: with :math:`e` the difference and :math:`\ell` the way, both of one
time scale :math:`\tau`, :math:`e/\ell \sim (h/\tau)^2`, so that :math:`e^2/\ell` is left.

A body at rest hides its break-away from any such estimate, since both results stay where they were. So after each
step that ends at rest it is asked how long the body can rest, and the step is made to end there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core.dispatch import plant_port, plant_rest
from bristle.core.kernel import kernel
from bristle.core.mathematics import Bracket, bracket_guess, bracket_update
from bristle.core.packing import Structure, unpacker
from bristle.engine.efim import INFINITY, evaluate
from bristle.engine.entries import ACCELERATION, BOUND, FAILED, FORCE, SLACK, SLOPE
from bristle.engine.step_length import GIVE_UP, ROUNDING, length_factor

__all__ = ["doubling", "make_rest_time"]

# A step so short, as a share of another one, that the mean force over it is the force at an instant.
INSTANT = 1e-9
BISECTIONS = 60
# What the solves may contribute to the error that is allowed.
SHARE_OF_SOLVES = 0.01
# What is left after an extrapolation may be so many times what the orders of magnitude say.
CAUTION = 10.0


@kernel(inline=False)
def reserve(body, s, memory, effort, dt, q, p):
    """Return how much force is left [N or N*m] until a body at rest breaks away; negative where it cannot rest.

    It is infinite for a model that is not set-valued: nothing rests on it.
    """
    a, b = plant_port(body, effort, dt, q)
    forward, _ = evaluate(s, memory, 0.0, body.x, dt, p)
    backward, _ = evaluate(s, memory, -0.0, body.x, dt, p)
    if not forward > backward:
        return INFINITY
    return min(forward + a / b, -a / b - backward)


def make_rest_time(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Callable[..., Any]:
    """Return the entry that tells after what part of a step [s] a body at rest breaks away; `dt` if it does not."""
    unpack_plant, load_plant = unpacker(plant), unpacker(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)

    def rest_time(q_vector, plant_vector, p_vector, state_vector, memory, effort, effort_end, dt, steps, out):
        q, body = unpack_plant(q_vector), load_plant(plant_vector)
        p, s = unpack_friction(p_vector), load_friction(state_vector)
        rise, time, guess, bracket = (effort_end - effort) / dt, dt, dt, Bracket(0.0, -1.0, dt, 1.0, 0.0)
        for count in range(BISECTIONS):
            if count > 1 and bracket.high - bracket.low <= 1e-12 * dt:
                break
            there = plant_rest(body, effort + 0.5 * guess * rise, guess, q)
            left = reserve(there, s, memory, effort + guess * rise, INSTANT * dt, q, p)
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
def copy_twice(source, target, other):
    """Copy the numbers of one vector into two others of the same length."""
    copy(source, target)
    copy(source, other)


@kernel
def sampled(k, t, h, part_0, x_0, v_0, x_1, v_1, force_1, force_2, total, times, x, v, impulse):
    """Write the samples from number `k` on that lie in one half of a step; return the number of the next.

    The half begins at `t` [s], after `part_0` of the step of `h` [s]. Position and velocity are those of the cubic
    through both its ends. Friction runs straight over the whole step, through the means of its halves; its impulse
    [N*s or N*m*s] is `total` at the beginning of the step.
    """
    half = 0.5 * h
    slope = (x_1 - x_0) / half
    bend_0, bend_1 = v_0 - slope, v_1 - slope
    while k < times.size and times[k] <= t + half:
        part = (times[k] - t) / half
        rest = 1.0 - part
        x[k] = rest * x_0 + part * x_1 + half * part * rest * (rest * bend_0 - part * bend_1)
        v[k] = slope + (rest * rest - 2.0 * part * rest) * bend_0 + (part * part - 2.0 * part * rest) * bend_1
        whole = part_0 + 0.5 * part
        impulse[k] = total + h * whole * (force_1 + (force_2 - force_1) * (whole - 0.5))
        k += 1
    return k


@kernel
def slides(body_0, x_middle, v_middle, body, far):
    """Return whether a step carried the contact along, `far` [m or rad] in each half, without turning around."""
    forward = body_0[1] > 0.0 and v_middle > 0.0 and body[1] > 0.0
    backward = body_0[1] < 0.0 and v_middle < 0.0 and body[1] < 0.0
    return (forward or backward) and min(abs(x_middle - body_0[0]), abs(body[0] - x_middle)) > far


@kernel
def extrapolate(fine, coarse):
    """Cancel the leading error of a result of order 2 by one with steps twice as long."""
    for i in range(fine.size):
        fine[i] += (fine[i] - coarse[i]) / 3.0


def doubling(
    burst, rest_time, q, body, p, state, memory, body_0, state_0, memory_0, body_1, state_1, out, out_1, knots,
    starts, ends, settings, times, x, v, impulse, report,
):  # fmt: skip
    """Drive a plant with friction by an effort that is straight between knots.

    Vectors with 0 keep the mechanism as it was before a step, those with 1 are for the step as a whole. ``settings``
    are the error allowed per time [m/s or rad/s] and per step [m or rad], the longest, shortest and first step [s],
    and the way after which a contact only follows [m or rad]; ``report`` receives the numbers of steps accepted, of
    steps rejected, of steps that missed the tolerance, and of solves that did. Returns the number of samples reached:
    all, unless the motion left the finite numbers or too many steps missed the tolerance.
    """
    per_time, per_step, h_max, h_min, wish = settings[0], settings[1], settings[2], settings[3], settings[4]
    far = settings[5]
    error_last, total, k, h_last, acceleration, bend = 1.0, 0.0, 0, 0.0, 0.0, 0.0
    for segment in range(starts.size):
        t, t_end, u, rests_until = knots[segment], knots[segment + 1], starts[segment], INFINITY
        rise = (ends[segment] - u) / (t_end - t)
        while t < t_end:
            left = min(t_end, rests_until) - t
            h = min(wish, h_max)
            is_last = h >= left * (1.0 - 1e-9)
            h = left if is_last else min(h, 0.5 * left)
            is_cut, u_middle, u_end = h < wish, u + 0.5 * h * rise, u + h * rise
            copy_twice(body, body_0, body_1)
            copy_twice(state, state_0, state_1)
            copy(memory, memory_0)
            # Each solve begins where the last ones point to: the mean acceleration, straight on in time.
            allowed = max(min(per_time * h, per_step), ROUNDING * abs(body[0]))
            slack = SHARE_OF_SOLVES * allowed / h
            expected = acceleration + bend * (0.25 * h_last + 0.5 * h)
            out_1[SLOPE], out_1[ACCELERATION], out_1[SLACK] = out[SLOPE], expected, slack
            burst(q, body_1, p, state_1, memory, u, u_end, h, 1, out_1)
            copy(memory_0, memory)
            out[SLOPE], out[ACCELERATION], out[SLACK] = out_1[SLOPE], out_1[ACCELERATION] - 0.25 * h * bend, slack
            burst(q, body, p, state, memory, u, u_middle, 0.5 * h, 1, out)
            x_middle, v_middle, force_1, failures, early = body[0], body[1], out[FORCE], out[FAILED], out[ACCELERATION]
            out[ACCELERATION] = 2.0 * out_1[ACCELERATION] - early
            burst(q, body, p, state, memory, u_middle, u_end, 0.5 * h, 1, out)
            error = abs(body[0] - body_1[0]) + 2.0 * h * abs(body[1] - body_1[1])
            if slides(body_0, x_middle, v_middle, body, far):
                x_middle += (body[0] - body_1[0]) / 6.0
                v_middle += (body[1] - body_1[1]) / 6.0
                extrapolate(body, body_1)
                error *= CAUTION * error / (h * min(abs(body_0[1]), abs(body[1])))
            error /= allowed
            rest = h
            if body[1] == 0.0 and rests_until == INFINITY:
                if body_0[1] == 0.0:
                    rest = rest_time(q, body_0, p, state_0, memory_0, u, u_end, h, 1, out_1)
                elif rest_time(q, body, p, state, memory, u_end, u_end, INSTANT * h, 1, out_1) == 0.0:
                    rest = 0.5 * h
            if h > h_min and (rest < h or not error <= 1.0):
                copy(body_0, body)
                copy(state_0, state)
                copy(memory_0, memory)
                report[1] += 1.0
                if rest < h and body_0[1] == 0.0 and rest > h_min:
                    rests_until = t + rest
                else:
                    wish = max(h_min, min(rest, h * length_factor(error, 1.0, 2.0)))
                continue
            k = sampled(
                k, t, h, 0.0, body_0[0], body_0[1], x_middle, v_middle, force_1, out[FORCE], total, times, x, v, impulse
            )  # fmt: skip
            k = sampled(
                k, t + 0.5 * h, h, 0.5, x_middle, v_middle, body[0], body[1], force_1, out[FORCE], total, times, x, v,
                impulse,
            )  # fmt: skip
            t = min(t_end, rests_until) if is_last else t + h
            total += 0.5 * h * (force_1 + out[FORCE])
            if not abs(body[0]) + abs(body[1]) < BOUND or report[2] > GIVE_UP:
                return k
            wish = max(wish if is_cut else h_min, h * length_factor(error, error_last, 2.0))
            u, error_last, rests_until = u_end, error, INFINITY
            h_last, acceleration, bend = h, out[ACCELERATION], 2.0 * (out[ACCELERATION] - early) / h
            report[0] += 1.0
            report[2] += 1.0 if not error <= 1.0 else 0.0
            report[3] += failures + out[FAILED]
    return k
