r"""Rodas5P: a stiffly stable Rosenbrock method of order 5, for friction models that are smooth enough to have a rate.

Eight stages, each one linear solve with the same matrix :math:`I/(\gamma h) - J`, the Jacobian from differences; an
embedded result of order 4 for the error, an interpolant of order 4 for the samples. The friction impulse is carried
along as one more variable, so that mean forces between samples come out of the same integration.

References
----------
.. [1] G. Steinebach, "Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
   Differential Equations package", BIT Numerical Mathematics 63, 2023. doi:10.1007/s10543-023-00967-x
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion
from bristle.core.dispatch import friction_rate, plant_rate
from bristle.core.kernel import kernel
from bristle.core.packing import Structure, packer, unpacker
from bristle.engine.entries import BOUND
from bristle.engine.step_doubling import copy
from bristle.engine.step_length import GIVE_UP, ROUNDING, length_factor

__all__ = ["make_rate", "rosenbrock"]

STAGES = 8
# Vectors are padded with zeros to a multiple of this, so that sums over them have no loose ends.
PADDING = 8
DIFFERENCE = 1.5e-8


def make_rate(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Callable[..., Any]:
    """Return the entry that computes the time derivative of [plant state | friction state | friction impulse]."""
    unpack_plant, load_plant, store_plant = unpacker(plant), unpacker(plant_state), packer(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)
    store_friction = packer(friction_state)
    count, last = len(plant_state[1]), len(plant_state[1]) + len(friction_state[1])

    def rate(q_vector, p_vector, y, effort, slope):
        q, body = unpack_plant(q_vector), load_plant(y)
        p, s = unpack_friction(p_vector), load_friction(y[count:])
        force, d_s = friction_rate(s, Motion(body.v, body.x, NOMINAL_LOAD, NOMINAL_TEMPERATURE), p)
        store_plant(plant_rate(body, effort, force, q), slope)
        store_friction(d_s, slope[count:])
        slope[last] = force
        return 0.0

    return rate


@kernel
def invert(jacobian, n, inverse_step, matrix):
    """Write the inverse of the matrix of the linear systems, row by row: `inverse_step` [1/s] times I, minus J.

    Eight systems share it, and a product takes less time than two triangular solves. Elimination without exchange of
    rows: the diagonal leads wherever a step is short enough for its error, and where it does not, the error tells.
    """
    for k in range(n * n):
        matrix[k] = -jacobian[k]
    for row in range(n):
        matrix[row * n + row] += inverse_step
    for pivot in range(n):
        diagonal = matrix[pivot * n + pivot]
        inverse = 1.0 / diagonal if diagonal != 0.0 else 1e300
        matrix[pivot * n + pivot] = 1.0
        for k in range(n):
            matrix[pivot * n + k] *= inverse
        for row in range(n):
            if row != pivot:
                factor = matrix[row * n + pivot]
                matrix[row * n + pivot] = 0.0
                for k in range(n):
                    matrix[row * n + k] -= factor * matrix[pivot * n + k]


@kernel
def multiply(matrix, n, b, target, first):
    """Write the product of an n by n matrix with `b` into `target` from number `first` on."""
    for row in range(n):
        total = 0.0
        for k in range(n):
            total += matrix[row * n + k] * b[k]
        target[first + row] = total


@kernel
def add_stages(target, weights, row, count, scale, stages):
    """Add the first `count` stages, with the weights of this row of a tableau times `scale`, to a vector."""
    width = target.size
    for m in range(count):
        weight = weights[row * STAGES + m] * scale
        for block in range(0, width, PADDING):
            for j in range(PADDING):
                target[block + j] += weight * stages[m * width + block + j]


@kernel
def bend(dense, stages, width, j, bends, at):
    """Write the three coefficients of the interpolant of variable `j` into `bends` from number `at` on."""
    for i in range(3):
        total = 0.0
        for m in range(STAGES):
            total += dense[i * STAGES + m] * stages[m * width + j]
        bends[at + i] = total


@kernel
def interpolated(bends, at, part, before, after):
    """Return a variable at this part of a step between its values before and after: of order 4."""
    curve = bends[at] + part * (bends[at + 1] + part * bends[at + 2])
    return (1.0 - part) * before + part * (after + (1.0 - part) * curve)


def rosenbrock(
    rate, q, p, y, n, knots, starts, ends, settings, tableau, advances, couplings, dense, times, x, v, impulse,
    jacobian, matrix, stages, y_next, slope, slope_0, drift, bends, report,
):  # fmt: skip
    """Integrate a plant with friction under an effort that is straight between knots.

    `y` is [plant state | friction state | friction impulse], `n` numbers and padding. ``settings`` are the error
    allowed per time [m/s or rad/s] and per step [m or rad], and the longest, shortest and first step [s]; `tableau` is
    [gamma | nodes | weights of the drift]; `report` receives the numbers of steps accepted, rejected, and accepted in
    spite of their error. Returns the number of samples reached: all, unless the motion left the finite numbers or too
    many steps missed the tolerance.
    """
    per_time, per_step, h_max, h_min, wish = settings[0], settings[1], settings[2], settings[3], settings[4]
    width, gamma, error_last, k, is_new = y.size, tableau[0], 1.0, 0, True
    for segment in range(starts.size):
        t, t_end, u, is_new = knots[segment], knots[segment + 1], starts[segment], True
        rise = (ends[segment] - u) / (t_end - t)
        while t < t_end:
            left = t_end - t
            h = min(wish, h_max)
            is_last = h >= left * (1.0 - 1e-9)
            h = left if is_last else min(h, 0.5 * left)
            is_cut = h < wish
            if is_new:
                rate(q, p, y, u, slope_0)
                if rise != 0.0:
                    rate(q, p, y, u + rise * h, drift)
                for j in range(n):
                    drift[j] = (drift[j] - slope_0[j]) / h if rise != 0.0 else 0.0
                    y_next[j] = y[j]
                # Nothing depends on the impulse: its column stays zero.
                for j in range(n - 1):
                    delta = DIFFERENCE * max(abs(y[j]), h * abs(slope_0[j])) + 1e-100
                    y_next[j] = y[j] + delta
                    inverse = 1.0 / (y_next[j] - y[j])
                    rate(q, p, y_next, u, slope)
                    y_next[j] = y[j]
                    for i in range(n):
                        jacobian[i * n + j] = (slope[i] - slope_0[i]) * inverse
            invert(jacobian, n, 1.0 / (gamma * h), matrix)
            for stage in range(STAGES):
                copy(y, y_next)
                add_stages(y_next, advances, stage, stage, 1.0, stages)
                rate(q, p, y_next, u + tableau[1 + stage] * h * rise, slope)
                for j in range(n):
                    slope[j] += h * tableau[1 + STAGES + stage] * drift[j]
                add_stages(slope, couplings, stage, stage, 1.0 / h, stages)
                multiply(matrix, n, slope, stages, stage * width)
            for j in range(n):
                y_next[j] += stages[7 * width + j]
            # The last stage is the error of the embedded result, of order 4.
            error = abs(stages[7 * width]) + 2.0 * h * abs(stages[7 * width + 1])
            error /= max(min(per_time * h, per_step), ROUNDING * abs(y[0]))
            is_new = error <= 1.0 or h <= h_min
            if not is_new:
                report[1] += 1.0
                wish = max(h_min, h * length_factor(error, 1.0, 4.0))
                continue
            if k < times.size and times[k] <= t + h:
                bend(dense, stages, width, 0, bends, 0)
                bend(dense, stages, width, 1, bends, 3)
                bend(dense, stages, width, n - 1, bends, 6)
            while k < times.size and times[k] <= t + h:
                part = (times[k] - t) / h
                x[k] = interpolated(bends, 0, part, y[0], y_next[0])
                v[k] = interpolated(bends, 3, part, y[1], y_next[1])
                impulse[k] = interpolated(bends, 6, part, y[n - 1], y_next[n - 1])
                k += 1
            copy(y_next, y)
            if not abs(y[0]) + abs(y[1]) < BOUND or report[2] > GIVE_UP:
                return float(k)
            t, u = t_end if is_last else t + h, u + h * rise
            wish = max(wish if is_cut else h_min, h * length_factor(error, error_last, 4.0))
            error_last = error
            report[0] += 1.0
            report[2] += 1.0 if not error <= 1.0 else 0.0
    return float(k)
