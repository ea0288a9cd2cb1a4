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

from bristle.core.contracts import Motion
from bristle.core.dispatch import friction_rate, plant_rate
from bristle.core.kernel import kernel
from bristle.core.packing import Structure, packer, unpacker
from bristle.engine.step_length import GIVE_UP, length_factor

__all__ = ["make_rate", "rosenbrock"]

STAGES = 8
DIFFERENCE = 1.5e-8


def make_rate(
    plant: Structure, plant_state: Structure, friction: Structure, friction_state: Structure
) -> Callable[..., Any]:
    """Return the entry that computes the time derivative of [plant state | friction state | friction impulse]."""
    unpack_plant, load_plant, store_plant = unpacker(plant), unpacker(plant_state), packer(plant_state)
    unpack_friction, load_friction = unpacker(friction), unpacker(friction_state)
    store_friction = packer(friction_state)
    count = len(plant_state[1])

    def rate(q_vector, p_vector, y, effort, slope):
        q, body = unpack_plant(q_vector), load_plant(y)
        p, s = unpack_friction(p_vector), load_friction(y[count:])
        force, d_s = friction_rate(s, Motion(body.v, body.x, 1.0, 293.15), p)
        store_plant(plant_rate(body, effort, force, q), slope)
        store_friction(d_s, slope[count:])
        slope[slope.size - 1] = force
        return 0.0

    return rate


@kernel
def factorise(matrix, n, pivots):
    """Replace an n by n matrix, row by row in a vector, by its triangular factors; `pivots` tells the rows swapped."""
    for column in range(n):
        best = column
        for row in range(column + 1, n):
            if abs(matrix[row * n + column]) > abs(matrix[best * n + column]):
                best = row
        pivots[column] = best
        if best != column:
            for k in range(n):
                swapped = matrix[column * n + k]
                matrix[column * n + k] = matrix[best * n + k]
                matrix[best * n + k] = swapped
        inverse = 1.0 / matrix[column * n + column]
        for row in range(column + 1, n):
            factor = matrix[row * n + column] * inverse
            matrix[row * n + column] = factor
            for k in range(column + 1, n):
                matrix[row * n + k] -= factor * matrix[column * n + k]


@kernel
def solve_factorised(matrix, n, pivots, b, first):
    """Replace the `n` numbers of `b` from `first` on by the solution of the linear system with them on the right."""
    for row in range(n):
        other = int(pivots[row])
        value = b[first + other]
        b[first + other] = b[first + row]
        for k in range(row):
            value -= matrix[row * n + k] * b[first + k]
        b[first + row] = value
    for row in range(n - 1, -1, -1):
        value = b[first + row]
        for k in range(row + 1, n):
            value -= matrix[row * n + k] * b[first + k]
        b[first + row] = value / matrix[row * n + row]


@kernel
def combined(weights, row, count, stages, n, j):
    """Return the sum over the first `count` stages of variable `j`, with the weights of this row of a tableau."""
    total = 0.0
    for m in range(count):
        total += weights[row * STAGES + m] * stages[m * n + j]
    return total


@kernel
def interpolated(dense, stages, n, j, part, before, after):
    """Return variable `j` at this part of a step between its values before and after: of order 4."""
    bend = combined(dense, 1, STAGES, stages, n, j) + part * combined(dense, 2, STAGES, stages, n, j)
    bend = combined(dense, 0, STAGES, stages, n, j) + part * bend
    return (1.0 - part) * before + part * (after + (1.0 - part) * bend)


def rosenbrock(
    rate, q, p, y, knots, starts, ends, settings, tableau, advances, couplings, dense, times, x, v, impulse,
    jacobian, matrix, pivots, stages, y_next, slope, slope_0, drift, report,
):  # fmt: skip
    """Integrate a plant with friction under an effort that is straight between knots.

    `y` is [plant state | friction state | friction impulse]. ``settings`` are the error allowed per time [m/s or
    rad/s] and per step [m or rad], and the longest, shortest and first step [s]; `tableau` is [gamma | nodes | weights
    of the drift]; `report` receives the numbers of steps accepted, rejected, and accepted in spite of their error.
    Returns the number of samples reached: all, unless the motion left the finite numbers or too many steps missed
    the tolerance.
    """
    per_time, per_step, h_max, h_min, wish = settings[0], settings[1], settings[2], settings[3], settings[4]
    n, gamma, error_last, k, is_new = y.size, tableau[0], 1.0, 0, True
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
                rate(q, p, y, u + rise * h, drift)
                for j in range(n):
                    drift[j] = (drift[j] - slope_0[j]) / h
                    y_next[j] = y[j]
                for j in range(n):
                    delta = DIFFERENCE * max(abs(y[j]), h * abs(slope_0[j])) + 1e-100
                    y_next[j] = y[j] + delta
                    delta = y_next[j] - y[j]
                    rate(q, p, y_next, u, slope)
                    y_next[j] = y[j]
                    for i in range(n):
                        jacobian[i * n + j] = (slope[i] - slope_0[i]) / delta
            for j in range(n * n):
                matrix[j] = -jacobian[j]
            for j in range(n):
                matrix[j * n + j] += 1.0 / (gamma * h)
            factorise(matrix, n, pivots)
            for stage in range(STAGES):
                for j in range(n):
                    y_next[j] = y[j] + combined(advances, stage, stage, stages, n, j)
                rate(q, p, y_next, u + tableau[1 + stage] * h * rise, slope)
                for j in range(n):
                    coupling = combined(couplings, stage, stage, stages, n, j) / h
                    stages[stage * n + j] = slope[j] + h * tableau[1 + STAGES + stage] * drift[j] + coupling
                solve_factorised(matrix, n, pivots, stages, stage * n)
            for j in range(n):
                y_next[j] += stages[7 * n + j]
            # The last stage is the error of the embedded result, of order 4.
            error = abs(stages[7 * n]) + 2.0 * h * abs(stages[7 * n + 1])
            error /= min(per_time * h, per_step)
            is_new = error <= 1.0 or h <= h_min
            if not is_new:
                report[1] += 1.0
                wish = max(h_min, h * length_factor(error, 1.0, 4.0))
                continue
            while k < times.size and times[k] <= t + h:
                part = (times[k] - t) / h
                x[k] = interpolated(dense, stages, n, 0, part, y[0], y_next[0])
                v[k] = interpolated(dense, stages, n, 1, part, y[1], y_next[1])
                impulse[k] = interpolated(dense, stages, n, n - 1, part, y[n - 1], y_next[n - 1])
                k += 1
            for j in range(n):
                y[j] = y_next[j]
            if not abs(y[0]) + abs(y[1]) < 1e100 or report[2] > GIVE_UP:
                return float(k)
            t, u = t_end if is_last else t + h, u + h * rise
            wish = max(wish if is_cut else h_min, h * length_factor(error, error_last, 4.0))
            error_last = error
            report[0] += 1.0
            report[2] += 1.0 if not error <= 1.0 else 0.0
    return float(k)
