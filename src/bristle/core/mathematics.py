r"""Elementary functions for kernels: one source for plain Python, the compiler and, later, C and CUDA.

Plain Python raises where compiled code does not (overflow, division by zero, the logarithm of zero). The
functions here return the same finite number everywhere instead, so that a model gives the same bits however
it runs.
"""

import math
from typing import NamedTuple

from bristle.core.kernel import kernel

__all__ = [
    "Bracket",
    "bracket_guess",
    "bracket_update",
    "direction",
    "exp",
    "fitted_weight",
    "log",
    "power",
    "relaxation",
]

EXP_MAX = 709.0
EXP_MIN = -745.0


@kernel
def exp(x):
    r"""Return :math:`e^x`, with `x` clamped to [-745, 709] so that it neither overflows nor traps."""
    if x > EXP_MAX:
        return math.exp(EXP_MAX)
    if x < EXP_MIN:
        return 0.0
    return math.exp(x)


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
    if rate < 1e-12:
        return 1.0 - 0.5 * rate
    return -math.expm1(-rate) / rate


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
    return -1.0 / math.expm1(-rate) - 1.0 / rate


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
