"""How long the next step is: proportional and integral control of its error."""

from bristle.core.kernel import kernel
from bristle.core.mathematics import power

SAFETY = 0.9
SMALLEST_FACTOR, LARGEST_FACTOR = 0.2, 4.0
PROPORTIONAL, INTEGRAL = 0.7, 0.4
SMALLEST_ERROR = 1e-4
ROUNDING = 1e-15  # share of the position below which its error means nothing
GIVE_UP = 1000.0  # steps of the shortest length, and still not exact enough


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
