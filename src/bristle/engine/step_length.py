"""How long the next step is.

Where the error of steps jumps, as at kinks, proportional and integral control damps what it does to their length. Where
it changes smoothly, the length follows its trend.

References
----------
.. [1] K. Gustafsson, "Control-theoretic techniques for stepsize selection in implicit Runge-Kutta methods", ACM
   Transactions on Mathematical Software 20(4), 1994. doi:10.1145/198429.198437
"""

from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import power
from bristle.engine.signature import Vector

__all__ = ["GIVE_UP", "ROUNDING", "Course", "Limits", "Samples", "length_factor", "next_length", "own_factor"]

SAFETY = 0.9
SMALLEST_FACTOR, LARGEST_FACTOR = 0.2, 4.0
PROPORTIONAL, INTEGRAL = 0.7, 0.4
SMALLEST_ERROR = 1e-4
ROUNDING = 1e-15  # share of the position below which its error means nothing
GIVE_UP = 1000.0  # steps of the shortest length, and still not exact enough


class Course(NamedTuple):
    """An effort that is straight between `knots` [s]: at the beginning and at the end of each stretch."""

    knots: Vector
    starts: Vector
    ends: Vector


class Limits(NamedTuple):
    """The error allowed per time [m/s or rad/s] and per step [m or rad]; longest, shortest and first step [s].

    After the way `far` [m or rad] in one step a contact only follows. `between` is the error of the position allowed
    at a sample inside a step [m or rad]: it does not add up.
    """

    per_time: float
    per_step: float
    longest: float
    shortest: float
    first: float
    far: float
    between: float


class Samples(NamedTuple):
    """When [s] something is recorded, and what: position, velocity, and impulse of the friction until then."""

    times: Vector
    x: Vector
    v: Vector
    impulse: Vector


@kernel
def length_factor(error, error_last, order):
    """Return by how much the step length changes after an error.

    Both errors are shares of what is allowed, that of this step and that of the last one; the error goes with the
    power `order` of the step length.
    """
    if not error <= 1e300:
        return SMALLEST_FACTOR
    now, last = max(error, SMALLEST_ERROR), max(error_last, SMALLEST_ERROR)
    factor = SAFETY * power(now, -PROPORTIONAL / order) * power(last, INTEGRAL / order)
    return max(SMALLEST_FACTOR, min(LARGEST_FACTOR, factor))


@kernel
def own_factor(error, order):
    """Return by how much the step length changes by its own error alone."""
    if not error <= 1e300:
        return SMALLEST_FACTOR
    factor = SAFETY * power(max(error, SMALLEST_ERROR), -1.0 / order)
    return max(SMALLEST_FACTOR, min(LARGEST_FACTOR, factor))


@kernel
def next_length(h, error, h_last, error_last, tries, order):
    """Return the length [s] of the step after an accepted one, `h_last` and `error_last` being those of the one before.

    Where the error for a given length grows from step to step, it is expected to go on growing as fast. After a step
    that took several `tries` the next one is no longer.
    """
    now, last = max(error, SMALLEST_ERROR), max(error_last, SMALLEST_ERROR)
    trend = h / h_last * power(last / now, 1.0 / order) if h_last > 0.0 else 1.0
    factor = own_factor(now, order) * min(1.0, trend)
    return h * max(SMALLEST_FACTOR, factor if tries == 1 else min(1.0, factor))
