r"""Elementary functions for kernels: one source for plain Python, the compiler and, later, C and CUDA.

Plain Python raises where compiled code does not (overflow, division by zero, the logarithm of zero). The
functions here return the same finite number everywhere instead, so that a model gives the same bits however
it runs.
"""

import math
from typing import NamedTuple

from bristle.core.exponent import power_of_two
from bristle.core.kernel import kernel

__all__ = [
    "Bracket",
    "bracket_guess",
    "bracket_update",
    "direction",
    "exp",
    "expm1",
    "fitted_weight",
    "hyperbolic_mean",
    "log",
    "power",
    "relaxation",
]

EXP_MAX, EXP_OF_MAX = 709.0, 8.218407461554972e307
EXP_MIN = -708.0
LOG2_E = 1.4426950408889634
# ln 2 in two parts: the first is short enough for k * LN2_HIGH to be exact.
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
# Adding and subtracting it rounds to the nearest integer.
ROUNDER = 6755399441055744.0


@kernel
def exp(x):
    r"""Return :math:`e^x`; 0 below -708, and :math:`e^{709}` above 709.

    Within two units of the last place, by a polynomial: the same bits on every target, and no call that keeps a loop
    over trajectories from running several of them in one instruction.
    """
    scale, fraction = _scale_and_fraction(x)
    value = scale * fraction + scale
    return 0.0 if x < EXP_MIN else (EXP_OF_MAX if x > EXP_MAX else value)


@kernel
def expm1(x):
    r"""Return :math:`e^x - 1` without cancellation, within the range of `exp`."""
    scale, fraction = _scale_and_fraction(x)
    value = scale * fraction + (scale - 1.0)
    return -1.0 if x < EXP_MIN else (EXP_OF_MAX if x > EXP_MAX else value)


@kernel
def _scale_and_fraction(x):
    r"""Return :math:`2^k` and :math:`e^r - 1` with :math:`x = k \ln 2 + r`, :math:`|r| \le \tfrac12 \ln 2`.

    The polynomial is the Chebyshev interpolant of :math:`(e^r - 1 - r)/r^2`; its error is below 2e-17. Outside the
    range of `exp` the results mean nothing.
    """
    k = (x * LOG2_E + ROUNDER) - ROUNDER
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    low = (0.5000000000000001 + 0.16666666666666669 * r) + (0.041666666666624164 + 0.008333333333330065 * r) * r2
    middle = (0.001388888891719689 + 0.00019841269863040675 * r) + (
        2.480152132210459e-05 + 2.7557268480106926e-06 * r
    ) * r2
    high = 2.762007600563138e-07 + 2.5100375929185925e-08 * r
    return power_of_two(k), (r + r2 * low) + (r2 * r4) * (middle + r4 * high)


@kernel
def log(x):
    r"""Return :math:`\ln x`, with `x` clamped to the smallest positive normal number from below."""
    if x < 2.2250738585072014e-308:
        return -708.3964185322641
    return math.log(x)


@kernel
def power(x, y):
    r"""Return :math:`x^y` for :math:`x \ge 0`; negative `x` counts as 0, and :math:`0^y = 0` for y > 0."""
    if x <= 0.0:
        return 1.0 if y == 0.0 else 0.0
    if y == 2.0:
        return x * x
    if y == 1.0:
        return x
    return exp(y * log(x))


@kernel
def direction(v):
    r"""Return +1.0 or -1.0: the sign of a velocity, in which :math:`\pm 0` are the two one-sided limits."""
    return math.copysign(1.0, v)


@kernel
def relaxation(rate):
    r"""Return :math:`(1 - e^{-\Lambda})/\Lambda`, the mean of an exponential decay over its step.

    Exact to rounding for every :math:`\Lambda \ge 0`; 1 at :math:`\Lambda = 0`.
    """
    # The smallest rate keeps the quotient defined, and exact: 1.
    positive = max(rate, 1e-30)
    return -expm1(-positive) / positive


@kernel
def fitted_weight(rate):
    r"""Return the exponentially fitted weight :math:`\vartheta = 1/(1-e^{-\Lambda}) - 1/\Lambda`.

    The mean of a decaying quantity over a step is :math:`(1-\vartheta) y_0 + \vartheta y_1`, exactly. It runs
    from 1/2 (midpoint rule) at :math:`\Lambda = 0` to 1 (implicit Euler) for large :math:`\Lambda`.
    """
    if rate < 0.03:
        # The two terms cancel for small arguments: series with error below 1e-17 here.
        square = rate * rate
        return 0.5 + rate * (1.0 / 12.0 - square * (1.0 / 720.0 - square / 30240.0))
    return -1.0 / expm1(-rate) - 1.0 / rate


@kernel
def hyperbolic_mean(u):
    r"""Return :math:`\ln(1 + u)/u`, the mean of :math:`1/(1 + u t)` over :math:`0 \le t \le 1`, for :math:`u \ge 0`."""
    if u < 1e-8:
        return 1.0 - 0.5 * u
    return math.log1p(u) / u


class Bracket(NamedTuple):
    """An interval that holds a root of an increasing function, with what is known at its ends."""

    low: float
    f_low: float
    high: float
    f_high: float
    stalled: float  # consecutive updates of the same end, signed: negative for `low`


@kernel
def bracket_guess(bracket):
    """Return where to evaluate next: the secant through both ends, or the middle where it stalls."""
    width = bracket.high - bracket.low
    span = bracket.f_high - bracket.f_low
    if abs(bracket.stalled) >= 3.0 or span <= 0.0:
        return bracket.low + 0.5 * width
    guess = bracket.low - bracket.f_low * (width / span)
    if guess <= bracket.low or guess >= bracket.high:
        return bracket.low + 0.5 * width
    return guess


@kernel
def bracket_update(bracket, x, f):
    """Return the bracket after `f` was found at `x` inside it (Illinois rule for the end that stays)."""
    if f < 0.0:
        stalled = min(bracket.stalled, 0.0) - 1.0
        f_high = 0.5 * bracket.f_high if stalled <= -2.0 else bracket.f_high
        return Bracket(x, f, bracket.high, f_high, 0.0 if stalled < -3.0 else stalled)
    stalled = max(bracket.stalled, 0.0) + 1.0
    f_low = 0.5 * bracket.f_low if stalled >= 2.0 else bracket.f_low
    return Bracket(bracket.low, f_low, x, f, 0.0 if stalled > 3.0 else stalled)
