r"""Elementary functions for kernels: one source for plain Python, the compiler, C and all other targets.

Plain Python raises errors where compiled code does not (overflow, division by zero, the logarithm of zero). The functions
here return the same finite number everywhere, so that a model gives the same bits on every target. Libraries round `exp`,
`log` and `sin` differently. Here these functions are polynomials of operations that are exact by the floating-point
standard: the four operations, the square root, the sign and the floor.

References
----------
.. [1] W. J. Cody, W. Waite, "Software manual for the elementary functions", Prentice-Hall, 1980: arguments reduced by a
   constant in several parts.
.. [2] K. C. Ng, fdlibm, Sun Microsystems, 1993: the polynomials of `log`, `log1p`, `sin` and `cos`.
"""

import math
import sys
from typing import NamedTuple

from bristle.core.exponent import exponent, mantissa, power_of_two
from bristle.core.kernel import kernel

EXP_MAX, EXP_OF_MAX = 709.0, 8.218407461554972e307
EXP_MIN = -708.0
LOG2_E = 1.4426950408889634
# ln 2 in two parts: the first is short enough for k * LN2_HIGH to be exact.
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
NORMAL_MIN, LOG_OF_MIN, LARGEST = sys.float_info.min, -708.3964185322641, sys.float_info.max
ROOT_2 = math.sqrt(2.0)
TANH_MAX = 20.0  # above, tanh is 1 to the last place
# Half pi in parts of 33 bits, and the rest.
HALF_PI_1, HALF_PI_2 = 1.57079632673412561417e00, 6.07710050630396597660e-11
HALF_PI_3, HALF_PI_4 = 2.02226624871116645580e-21, 8.47842766036889956997e-32
TWO_OVER_PI, TURN = 2.0 / math.pi, math.tau
SINE_1 = 1.66666666666666324348e-01
NEWTON_ROUNDS = 16
NEWTON_LAST = NEWTON_ROUNDS + 64  # 64 halvings reduce any interval to its last place
ANGLE_MAX, ANGLE_WITHOUT_DIGITS = 1e6, 1e15
# Adding and subtracting it rounds to the nearest integer.
ROUNDER = 6755399441055744.0


@kernel
def exp(x):
    r"""Return :math:`e^x`; 0 below -708, and :math:`e^{709}` above 709.

    Within two units of the last place, by a polynomial: the same bits on every target, and no call that prevents
    vectorization over trajectories.
    """
    scale, fraction = _scale_and_fraction(x)
    value = scale * fraction + scale
    return 0.0 if x < EXP_MIN else (EXP_OF_MAX if x > EXP_MAX else value)


@kernel
def decay(x):
    r"""Return :math:`e^{-x}` for :math:`x \ge 0`, with the bits of `exp`."""
    scale, fraction = _scale_and_fraction(-x)
    return 0.0 if x > -EXP_MIN else scale * fraction + scale


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
    range of `exp` the results are undefined.
    """
    k = (x * LOG2_E + ROUNDER) - ROUNDER
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    low = (0.5000000000000001 + 0.16666666666666669 * r) + (
        0.041666666666624164 + 0.008333333333330065 * r
    ) * r2
    middle = (0.001388888891719689 + 0.00019841269863040675 * r) + (
        2.480152132210459e-05 + 2.7557268480106926e-06 * r
    ) * r2
    high = 2.762007600563138e-07 + 2.5100375929185925e-08 * r
    return power_of_two(k), (r + r2 * low) + (r2 * r4) * (middle + r4 * high)


@kernel
def tanh(x):
    r"""Return the hyperbolic tangent, within three units of the last place."""
    twice = expm1(2.0 * min(abs(x), TANH_MAX))
    return math.copysign(twice / (twice + 2.0), x) if x == x else x


@kernel
def log(x):
    r"""Return :math:`\ln x` within one unit of the last place, `x` clamped to the smallest normal number from below."""
    normal = max(x, NORMAL_MIN)
    m, k = mantissa(normal), exponent(normal)
    high = m > ROOT_2
    value = _logarithm((0.5 * m if high else m) - 1.0, 0.0, k + 1.0 if high else k)
    return LOG_OF_MIN if x < NORMAL_MIN else (value if x <= LARGEST else x)


@kernel
def log1p(x):
    r"""Return :math:`\ln(1 + x)` within one unit of the last place, near 0 too; clamped below x = -1, like `log`."""
    near = -0.29289321881345254 < x < 0.41421356237309503
    shifted = max(1.0 + x, NORMAL_MIN)
    # Correct the rounding error of the sum.
    lost = 1.0 - (shifted - x) if x >= 1.0 else x - (shifted - 1.0)
    m, k = mantissa(shifted), exponent(shifted)
    high = m > ROOT_2
    f = x if near else (0.5 * m if high else m) - 1.0
    correction = lost / shifted if -1.0 < x <= LARGEST and not near else 0.0
    value = _logarithm(f, correction, 0.0 if near else (k + 1.0 if high else k))
    return x if abs(x) < 1e-16 or not x <= LARGEST else value


@kernel
def _logarithm(f, correction, k):
    r"""Return :math:`\ln[2^k (1 + f)]` plus a correction, 1 + f between the roots of one half and of two.

    With :math:`s = f/(2 + f)`, :math:`\ln(1 + f) = 2s + \tfrac23 s^3 + \dots`, which is
    :math:`f - \tfrac12 f^2 + s\,(\tfrac12 f^2 + R)`.
    """
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = w * (0.3999999999940942 + w * (0.22222198432149784 + w * 0.15313837699209373))
    odd = z * (
        0.6666666666666735
        + w * (0.2857142874366239 + w * (0.1818357216161805 + w * 0.14798198605116586))
    )
    half = 0.5 * f * f
    return k * LN2_HIGH - ((half - (s * (half + (odd + even)) + (k * LN2_LOW + correction))) - f)


@kernel
def sin(x):
    r"""Return :math:`\sin x`, `x` in radians, within one unit of the last place up to a million.

    Beyond a million, the error of the angle is up to one unit of the last place of `x`; the result is 0 if this unit is
    a tenth of a turn.
    """
    near = _near_turn(x)
    n = (near * TWO_OVER_PI + ROUNDER) - ROUNDER
    y, tail = _within_quarter(near, n)
    quarters = n - 4.0 * ((0.25 * n + ROUNDER) - ROUNDER)  # from -2 to 2
    value = _cosine(y, tail) if abs(quarters) == 1.0 else _sine(y, tail)
    return -value if quarters == -1.0 or abs(quarters) == 2.0 else value


@kernel
def cos(x):
    r"""Return :math:`\cos x`, `x` in radians, as exactly as `sin`; 1 where `sin` is 0."""
    near = _near_turn(x)
    n = (near * TWO_OVER_PI + ROUNDER) - ROUNDER
    y, tail = _within_quarter(near, n)
    quarters = n - 4.0 * ((0.25 * n + ROUNDER) - ROUNDER)
    value = _sine(y, tail) if abs(quarters) == 1.0 else _cosine(y, tail)
    return -value if quarters == 1.0 or abs(quarters) == 2.0 else value


@kernel
def smooth_step(y):
    r"""Return :math:`\tfrac12[1 + \sin \pi(y - \tfrac12)]`, from 0 at y = 0 to 1 at y = 1; only for 0 <= y <= 1."""
    return smooth_step_point(y)[0]


@kernel
def smooth_step_point(y):
    """Return `smooth_step` and its derivative, at little more cost than `smooth_step`."""
    s, c = _of_half_quarter(y)
    total = s + c
    return 0.5 * total * total, 0.25 * TURN * (c - s) * total


@kernel
def _of_half_quarter(y):
    r"""Return sine and cosine of :math:`\tfrac\pi2(y - \tfrac12)`, with the bits of `_sine` and `_cosine`."""
    x = HALF_PI_1 * (y - 0.5) + HALF_PI_2 * (y - 0.5)
    z = x * x
    v = z * x
    w = z * z
    half = 0.5 * z
    rest = 1.0 - half
    sine = x - (v * SINE_1 - z * (v * _sine_tail(z, w)))
    return sine, rest + (((1.0 - rest) - half) + z * _cosine_tail(z, w))


@kernel
def _near_turn(x):
    """Return an angle within the range of the reduction, less whole turns; NaN if `x` is not finite."""
    if abs(x) <= ANGLE_MAX:
        return x
    return (
        x - TURN * ((x / TURN + ROUNDER) - ROUNDER) if abs(x) <= ANGLE_WITHOUT_DIGITS else 0.0 * x
    )


@kernel
def _within_quarter(x, n):
    r"""Return :math:`x - n \pi/2` as a number and its rounding error, for an integral `n` of up to 20 bits.

    :math:`\pi/2` is split into four parts; the products of the first three parts with `n` are exact.
    """
    first = x - n * HALF_PI_1
    second = n * HALF_PI_2
    near = first - second
    lost = (first - near) - second
    third = n * HALF_PI_3
    nearer = near - third
    lost += ((near - nearer) - third) - n * HALF_PI_4
    y = nearer + lost
    return y, (nearer - y) + lost


@kernel
def _sine(y, tail):
    r"""Return the sine of `y` plus `tail`, :math:`|y| \le \pi/4`."""
    z = y * y
    v = z * y
    r = _sine_tail(z, z * z)
    return y - ((z * (0.5 * tail - v * r) - tail) + v * SINE_1)


@kernel
def _sine_tail(z, w):
    r"""Return the terms of the sine from :math:`y^5` on, divided by :math:`y^5`, with :math:`z = y^2, w = z^2`."""
    return (
        0.00833333333332248946124
        + z * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)
    ) + z * w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)


@kernel
def _cosine(y, tail):
    r"""Return the cosine of `y` plus `tail`, :math:`|y| \le \pi/4`."""
    z = y * y
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + (z * _cosine_tail(z, z * z) - y * tail))


@kernel
def _cosine_tail(z, w):
    r"""Return the terms of the cosine from :math:`y^4` on, divided by :math:`y^2`, with :math:`z = y^2, w = z^2`."""
    low = z * (
        0.0416666666666666019037 + z * (-0.00138888888888741095749 + z * 2.48015872894767294178e-05)
    )
    high = (
        w
        * w
        * (
            -2.75573143513906633035e-07
            + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
        )
    )
    return low + high


@kernel
def power(x, y):
    r"""Return :math:`x^y` for :math:`x \ge 0`; negative `x` counts as 0, and :math:`0^y = 0` for y > 0."""
    if x <= 0.0:
        return 1.0 if y == 0.0 else 0.0
    if y == 2.0:
        return x * x
    if y == 1.0:
        return x
    if y == 3.0:
        return x * x * x
    if y == 0.5:
        return math.sqrt(x)
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
    # With the smallest rate, the quotient is defined and exactly 1.
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
        return 0.5 + rate * (1.0 / 12.0 - square * (1.0 / 720.0 - square * (1.0 / 30240.0)))
    if rate < 0.25:
        # More terms of the same series cost less than an exponential.
        square = rate * rate
        fourth = square * square
        low = 1.0 / 12.0 - square * (1.0 / 720.0)
        middle = 1.0 / 30240.0 - square * (1.0 / 1209600.0)
        high = 1.0 / 47900160.0 - square * (691.0 / 1307674368000.0)
        return 0.5 + rate * (low + fourth * (middle + fourth * high))
    return -1.0 / expm1(-rate) - 1.0 / rate


@kernel
def hyperbolic_mean(u):
    r"""Return :math:`\ln(1 + u)/u`, the mean of :math:`1/(1 + u t)` over :math:`0 \le t \le 1`, for :math:`u > -1`."""
    if abs(u) < 0.01:
        # The series, to the last place.
        square = u * u
        odd = 0.5 + square * (0.25 + square * (1.0 / 6.0 + 0.125 * square))
        return 1.0 + square * (1.0 / 3.0 + square * (0.2 + square / 7.0)) - u * odd
    return log1p(u) / u


class Newton(NamedTuple):
    """Search for the root of an increasing function: interval, next point, and history."""

    low: float
    high: float
    x: float
    step: float  # length of the last step, or of the halved interval
    rounds: int


@kernel
def newton_from(high, x):
    """Return the search for a root between 0 and `high` that begins at `x`."""
    return Newton(0.0, high, x, 2.0 * high, 0)


@kernel
def newton_next(search, residual, slope):
    """Return the search after the evaluation of `residual` and `slope` at its point.

    The next point is a step of Newton's method if it stays inside the interval and is at most half as long as the last
    step; otherwise it is the middle of the interval. After `NEWTON_ROUNDS` it is always the middle, so k rounds later
    the interval has shrunk by 2^-k for every function.
    """
    above = residual > 0.0
    low, high = search.low if above else search.x, search.x if above else search.high
    step = residual / slope if slope > 0.0 else high - low
    x = search.x - step
    if low <= x <= high and abs(step) <= 0.5 * search.step and search.rounds < NEWTON_ROUNDS:
        return Newton(low, high, x, abs(step), search.rounds + 1)
    return Newton(low, high, 0.5 * (low + high), high - low, search.rounds + 1)


class Bracket(NamedTuple):
    """An interval around the root of an increasing function, with the values at its ends."""

    low: float
    f_low: float
    high: float
    f_high: float
    stalled: float  # consecutive updates of the same end, signed: negative for `low`


@kernel
def bracket_guess(bracket):
    """Return the next point: on the secant through both ends, or the middle if the search stalls."""
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
    """Return the bracket after the evaluation of `f` at `x` inside it (Illinois rule for the fixed end)."""
    if f < 0.0:
        stalled = min(bracket.stalled, 0.0) - 1.0
        f_high = 0.5 * bracket.f_high if stalled <= -2.0 else bracket.f_high
        return Bracket(x, f, bracket.high, f_high, 0.0 if stalled < -3.0 else stalled)
    stalled = max(bracket.stalled, 0.0) + 1.0
    f_low = 0.5 * bracket.f_low if stalled >= 2.0 else bracket.f_low
    return Bracket(bracket.low, f_low, x, f, 0.0 if stalled > 3.0 else stalled)
