r"""Rodas5P: a stiffly stable Rosenbrock method of order 5, for friction that is smooth, or smooth from event to event.

Eight stages, each one linear solve with the same matrix :math:`I/(\gamma h) - J`, the Jacobian from differences; an
embedded result of order 4 for the error, an interpolant of order 4 for the samples. The friction impulse is carried
along as one more variable, so that mean forces between samples come out of the same integration.

Friction that is smooth from event to event goes on smoothly past the next one. So a step across an event is as exact
as any other; the event is searched for in its interpolant, the step ends there, memory is committed, and the next piece
begins. Nothing is ever taken back.

References
----------
.. [1] G. Steinebach, "Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
   Differential Equations package", BIT Numerical Mathematics 63, 2023. doi:10.1007/s10543-023-00967-x
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import Bracket, bracket_guess, bracket_update
from bristle.engine.drivers import BOUND
from bristle.engine.efim import INFINITY
from bristle.engine.pieces import Layout, PieceVectors, Rates, Turn, rates_of
from bristle.engine.signature import Vector
from bristle.engine.step_doubling import copy
from bristle.engine.step_length import GIVE_UP, ROUNDING, Course, Limits, Samples, next_length, own_factor

__all__ = ["STAGES", "RosenbrockEntries", "Search", "Step", "Tableau", "Work", "make_search", "make_step", "rosenbrock"]

STAGES = 8
DIFFERENCE = 1.5e-8
# Of the search for an event: in how many parts of the step to look for two that hide each other, how often to halve
# or better, and how narrow an interval is enough, as a share of the step.
LOOKS, LOCATIONS, NARROW = 4, 60, 1e-12


class Tableau(NamedTuple):
    """Coefficients: [gamma | nodes | weights of the drift], and the weights of stages, row by row."""

    nodes: Vector
    advances: Vector
    couplings: Vector
    dense: Vector


class Work(NamedTuple):
    """What a step reads and writes: `y` is [plant state | contact | friction impulse], `y_next` that at its end.

    `stages` are the increments; `slope_0` are the rates at the beginning, and `drift` is how fast these change with
    time. `slope` has one more number: the lowest margin that a stage has seen. `bends` are coefficients of
    interpolants, and `at_event` is the state just past one.
    """

    y: Vector
    y_next: Vector
    slope_0: Vector
    drift: Vector
    jacobian: Vector
    matrix: Vector
    stages: Vector
    slope: Vector
    bends: Vector
    at_event: Vector


class Reach(NamedTuple):
    """A step of `h` [s] from `t` [s] on, up to `t_next`."""

    t: float
    h: float
    t_next: float


# One step: (vectors, work, effort at its beginning, its rise a second, dt, whether the Jacobian is new, tableau).
Step = Callable[[PieceVectors, Work, float, float, float, int, Tableau], float]
# An event in a step: (vectors, work, effort, effort at the end, margin, margin at the end, dense weights).
Search = Callable[[PieceVectors, Work, float, float, float, float, Vector], float]


class RosenbrockEntries(NamedTuple):
    """What integrates from event to event."""

    step: Step
    rates: Rates
    search: Search
    turn: Turn


@kernel
def weighted(weights, row, count, stages, j):
    """Return the sum of the first `count` stages of variable `j` with the weights of this row of a tableau."""
    total = 0.0
    for m in range(count):
        total += weights[row * STAGES + m] * stages[j * STAGES + m]
    return total


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
def multiply(matrix, n, b, target, stage):
    """Write the product of an n by n matrix with `b` into this stage of each variable."""
    for row in range(n):
        total = 0.0
        for k in range(n):
            total += matrix[row * n + k] * b[k]
        target[row * STAGES + stage] = total


def make_step(layout: Layout) -> Callable[..., Any]:
    """Return the entry that tries one step of `h` [s] under the effort `u` that rises by `rise` a second.

    It returns the error of the position [m or rad]. The Jacobian is computed where `is_new`.
    """
    n = layout.size
    load, rates = rates_of(layout)

    def step(vectors, work, u, rise, h, is_new, tableau):
        y, y_next, slope, slope_0, stages = work.y, work.y_next, work.slope, work.slope_0, work.stages
        nodes, jacobian, drift = tableau.nodes, work.jacobian, work.drift
        mechanism = load(vectors)
        if is_new:
            copy(y, y_next)
            # Nothing depends on the impulse, the last variable: its column stays zero.
            for j in range(n - 1):
                delta = DIFFERENCE * max(abs(y[j]), h * abs(slope_0[j])) + 1e-100
                y_next[j] = y[j] + delta
                inverse = 1.0 / (y_next[j] - y[j])
                rates(mechanism, y_next, u, slope)
                y_next[j] = y[j]
                for i in range(n):
                    jacobian[i * n + j] = (slope[i] - slope_0[i]) * inverse
        invert(jacobian, n, 1.0 / (nodes[0] * h), work.matrix)
        inverse_step, margin = 1.0 / h, INFINITY
        for stage in range(STAGES):
            for j in range(n):
                y_next[j] = y[j] + weighted(tableau.advances, stage, stage, stages, j)
            margin = min(margin, rates(mechanism, y_next, u + nodes[1 + stage] * h * rise, slope))
            for j in range(n):
                slope[j] += h * nodes[1 + STAGES + stage] * drift[j]
                slope[j] += inverse_step * weighted(tableau.couplings, stage, stage, stages, j)
            multiply(work.matrix, n, slope, stages, stage)
        slope[n] = margin
        # The last stage is the error of the embedded result, of order 4.
        for j in range(n):
            y_next[j] += stages[j * STAGES + STAGES - 1]
        return abs(stages[STAGES - 1]) + 2.0 * h * abs(stages[2 * STAGES - 1])

    return step


@kernel
def bend(dense, stages, j, bends, at):
    """Write the three coefficients of the interpolant of variable `j` into `bends` from number `at` on."""
    for i in range(3):
        bends[at + i] = weighted(dense, i, STAGES, stages, j)


@kernel
def interpolated(bends, at, part, before, after):
    """Return a variable at this part of a step between its values before and after: of order 4."""
    curve = bends[at] + part * (bends[at + 1] + part * bends[at + 2])
    return (1.0 - part) * before + part * (after + (1.0 - part) * curve)


@kernel
def sampled(k, reach, work, dense, samples):
    """Write the samples from number `k` on up to the end of a step; return the number of the next."""
    y, y_next, bends, times, last = work.y, work.y_next, work.bends, samples.times, work.y.size - 1
    bend(dense, work.stages, 0, bends, 0)
    bend(dense, work.stages, 1, bends, 3)
    bend(dense, work.stages, last, bends, 6)
    while k < times.size and times[k] <= reach.t_next:
        part = (times[k] - reach.t) / reach.h
        samples.x[k] = interpolated(bends, 0, part, y[0], y_next[0])
        samples.v[k] = interpolated(bends, 3, part, y[1], y_next[1])
        samples.impulse[k] = interpolated(bends, 6, part, y[last], y_next[last])
        k += 1
    return k


@kernel
def state_at(part, work, dense):
    """Write all variables at this part of a step into `at_event`."""
    for j in range(work.y.size):
        bend(dense, work.stages, j, work.bends, 0)
        work.at_event[j] = interpolated(work.bends, 0, part, work.y[j], work.y_next[j])


def make_search(layout: Layout) -> Callable[..., Any]:
    """Return the entry that tells after what part of a step the margin first falls below zero, 1 where it does not.

    `margin` is that at the beginning, `margin_end` that at the end.
    """
    load, rates = rates_of(layout)

    def search(vectors, work, u, u_end, margin, margin_end, dense):
        mechanism = load(vectors)
        low, high, above, below = 0.0, 0.0, margin, margin
        # Two crossings may hide each other: the first is in the first part at whose end one is seen.
        for look in range(1, LOOKS + 1):
            low, above, high, below = high, below, look / LOOKS, margin_end
            if look < LOOKS:
                state_at(high, work, dense)
                below = rates(mechanism, work.at_event, u + high * (u_end - u), work.slope)
            if below < 0.0:
                break
        if not below < 0.0:
            return 1.0
        bracket = Bracket(low, -above, high, -below, 0.0)
        for _ in range(LOCATIONS):
            if bracket.high - bracket.low <= NARROW:
                break
            part = bracket_guess(bracket)
            state_at(part, work, dense)
            bracket = bracket_update(bracket, part, -rates(mechanism, work.at_event, u + part * (u_end - u), work.slope))
        state_at(bracket.high, work, dense)
        return bracket.high

    return search


def rosenbrock(
    run: RosenbrockEntries,
    vectors: PieceVectors,
    work: Work,
    course: Course,
    limits: Limits,
    tableau: Tableau,
    samples: Samples,
    report: Vector,
) -> int:
    """Integrate a plant with friction under an effort that is straight between knots.

    `report` receives the numbers of steps accepted, rejected, and accepted in spite of their error. Returns the number
    of samples reached: all, unless the motion left the finite numbers or too many steps missed the tolerance.
    """
    y, y_next, slope_0, drift, n = work.y, work.y_next, work.slope_0, work.drift, work.y.size
    wish, h_min, error_last, h_last, tries, k = limits.first, limits.shortest, 1.0, 0.0, 1, 0
    for segment in range(course.starts.size):
        t, t_end, u = course.knots[segment], course.knots[segment + 1], course.starts[segment]
        rise, is_new = (course.ends[segment] - u) / (t_end - t), True
        margin = run.rates(vectors, y, u, slope_0)
        while t < t_end:
            left, h = t_end - t, min(wish, limits.longest)
            is_last = h >= left * (1.0 - 1e-9)
            h = left if is_last else min(h, 0.5 * left)
            is_cut, part, u_end = h < wish, 1.0, u + h * rise
            if is_new:
                if rise != 0.0:
                    run.rates(vectors, y, u_end, drift)
                for j in range(n):
                    drift[j] = (drift[j] - slope_0[j]) / h if rise != 0.0 else 0.0
            error = run.step(vectors, work, u, rise, h, is_new, tableau)
            error /= max(min(limits.per_time * h, limits.per_step), ROUNDING * abs(y[0]))
            is_new = error <= 1.0 or h <= h_min
            if not is_new:
                report[1] += 1.0
                tries += 1
                wish = max(h_min, h * own_factor(error, 4.0))
                continue
            margin_end = run.rates(vectors, y_next, u_end, slope_0)
            if min(margin_end, work.slope[n]) < 0.0 <= margin and h > h_min:
                part = run.search(vectors, work, u, u_end, margin, margin_end, tableau.dense)
            t_next = t_end if is_last and part == 1.0 else t + part * h
            if k < samples.times.size and samples.times[k] <= t_next:
                k = sampled(k, Reach(t, h, t_next), work, tableau.dense, samples)
            copy(y_next, y)
            if part < 1.0:
                copy(work.at_event, y)
            t, u = t_next, u + part * h * rise
            margin = margin_end
            if margin < 0.0 or part < 1.0:
                run.turn(vectors, y)
                margin = run.rates(vectors, y, u, slope_0)
            if not abs(y[0]) + abs(y[1]) < BOUND or report[2] > GIVE_UP:
                return k
            wish = max(wish if is_cut else h_min, next_length(h, error, h_last, error_last, tries, 4.0))
            error_last, h_last, tries = error, h, 1
            report[0] += 1.0
            report[2] += 1.0 if not error <= 1.0 else 0.0
    return k
