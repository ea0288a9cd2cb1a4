"""Derivatives of elementary functions, given the value: finite, 0 in a clamped range, one-sided at a corner."""

import math
from collections.abc import Callable
from typing import Any

from bristle.core import kernel, mathematics
from bristle.core.exponent import mantissa
from bristle.core.mathematics import LARGEST, exp, log
from bristle.core.packing import kernel_of


@kernel
def power_slopes(x, exponent, y):
    r"""Return :math:`n x^{n-1}` and :math:`x^n \ln x`; 0 and 0 if `x` is not positive."""
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
        return -0.5 + rate * (
            low - rate * rate * rate * (1.0 / 144.0 - rate * (1.0 / 840.0 - rate * (1.0 / 5760.0)))
        )
    return (exp(-rate) - y) / rate


RULES = {
    mathematics.exp: "y if EXP_MIN <= x <= EXP_MAX else 0.0",
    mathematics.decay: "-y",
    mathematics.expm1: "y + 1.0 if x <= EXP_MAX else 0.0",
    mathematics.tanh: "1.0 - y * y",
    mathematics.log: "1.0 / x if NORMAL_MIN <= x <= LARGEST else 0.0",
    mathematics.log1p: "1.0 / (1.0 + x) if 1.0 + x >= NORMAL_MIN and 1.0 + x <= LARGEST else 0.0",
    mathematics.sin: "cos(x) if abs(x) <= ANGLE_WITHOUT_DIGITS else 0.0",
    mathematics.cos: "-sin(x)",
    mantissa: "y / x if x > 0.0 else 0.0",
    math.sqrt: "0.5 / y if y > 0.0 else 0.0",
}
SLOPES: dict[Callable[..., Any], Callable[..., Any]] = {
    **{
        function: kernel_of("slope(x, y)", [f"return {rule}"], dict(vars(mathematics)))
        for function, rule in RULES.items()
    },
    mathematics.power: power_slopes,
    mathematics.relaxation: relaxation_slope,
}
