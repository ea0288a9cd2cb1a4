"""Derivatives of the elementary functions of kernels: each returns the slope to every argument, given the value.

Where a function is clamped its slope is that of the clamp, 0. At a corner it is that of one side: every slope is finite.
"""

import math
from collections.abc import Callable
from typing import Any

from bristle.core import mathematics
from bristle.core.exponent import mantissa
from bristle.core.kernel import kernel
from bristle.core.mathematics import ANGLE_WITHOUT_DIGITS, EXP_MAX, EXP_MIN, LARGEST, NORMAL_MIN, cos, exp, log, sin


@kernel
def exp_slope(x, y):
    r"""Return :math:`e^x`."""
    return y if EXP_MIN <= x <= EXP_MAX else 0.0


@kernel
def decay_slope(x, y):
    r"""Return :math:`-e^{-x}`."""
    return -y


@kernel
def expm1_slope(x, y):
    r"""Return :math:`e^x`."""
    return y + 1.0 if x <= EXP_MAX else 0.0


@kernel
def tanh_slope(x, y):
    r"""Return :math:`1 - \tanh^2 x`."""
    return 1.0 - y * y


@kernel
def log_slope(x, y):
    """Return 1/x."""
    return 1.0 / x if NORMAL_MIN <= x <= LARGEST else 0.0


@kernel
def log1p_slope(x, y):
    """Return 1/(1 + x)."""
    return 1.0 / (1.0 + x) if NORMAL_MIN <= 1.0 + x <= LARGEST else 0.0


@kernel
def sin_slope(x, y):
    """Return the cosine; 0 where the unit of the last place is a tenth of a turn."""
    return cos(x) if abs(x) <= ANGLE_WITHOUT_DIGITS else 0.0


@kernel
def cos_slope(x, y):
    """Return minus the sine."""
    return -sin(x)


@kernel
def sqrt_slope(x, y):
    """Return one over twice the root; 0 at 0, where there is none."""
    return 0.5 / y if y > 0.0 else 0.0


@kernel
def mantissa_slope(x, y):
    """Return the power of two that makes the mantissa of the number."""
    return y / x if x > 0.0 else 0.0


@kernel
def power_slopes(x, exponent, y):
    r"""Return :math:`n x^{n-1}` and :math:`x^n \ln x`; 0 and 0 where `x` is not positive."""
    if x <= 0.0:
        return (1.0 if exponent == 1.0 and x == 0.0 else 0.0), 0.0
    rise = exponent * (y / x)
    bend = y * log(x)
    return min(max(rise, -LARGEST), LARGEST), min(max(bend, -LARGEST), LARGEST)


@kernel
def relaxation_slope(rate, y):
    r"""Return :math:`(e^{-\Lambda} - y)/\Lambda` for :math:`y = (1 - e^{-\Lambda})/\Lambda`."""
    if rate < 0.03:
        low = 1.0 / 3.0 - rate * (0.125 - rate * (1.0 / 30.0))
        return -0.5 + rate * (low - rate * rate * rate * (1.0 / 144.0 - rate * (1.0 / 840.0 - rate * (1.0 / 5760.0))))
    return (exp(-rate) - y) / rate


SLOPES: dict[Callable[..., Any], Callable[..., Any]] = {
    mathematics.exp: exp_slope,
    mathematics.decay: decay_slope,
    mathematics.expm1: expm1_slope,
    mathematics.tanh: tanh_slope,
    mathematics.log: log_slope,
    mathematics.log1p: log1p_slope,
    mathematics.sin: sin_slope,
    mathematics.cos: cos_slope,
    mathematics.power: power_slopes,
    mathematics.relaxation: relaxation_slope,
    mantissa: mantissa_slope,
    math.sqrt: sqrt_slope,
}
