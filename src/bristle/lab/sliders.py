"""From where to where a slider goes, and whether by equal steps or by equal factors."""

from __future__ import annotations

import math
from typing import NamedTuple

from bristle.core.variable import Variable

__all__ = ["AROUND", "Slider", "slider_for"]

AROUND = 100.0
"""Factor from the middle of a slider without ends to either end."""
DECADES = 100.0  # from this ratio on equal factors are taken
SIGNED = 4.0  # ends of a number of either sign, over its value


class Slider(NamedTuple):
    """The ends of a slider, in SI; ``logarithmic`` where it goes by equal factors.

    Such a slider goes to 0 at its left end where ``to_zero``, and to infinity at its right end where ``endless``.
    """

    low: float
    high: float
    logarithmic: bool
    to_zero: bool = False
    endless: bool = False


def slider_for(
    variable: Variable, value: float, *, interval: tuple[float, float] | None = None, span: float = 0.0, around: float = AROUND
) -> Slider:
    """Return the slider of a parameter.

    Examples
    --------
    >>> slider_for(Variable("force", "Coulomb friction force", min=0.0), 20.0)
    Slider(low=0.2, high=2000.0, logarithmic=True, to_zero=True, endless=False)
    """
    low, high = variable.min, variable.max
    within = [number for number in (value, *(interval or ())) if math.isfinite(number)]
    if math.isfinite(low) and math.isfinite(high):
        if low > 0.0 and high / low >= DECADES:
            return Slider(low, high, logarithmic=True)
        return Slider(low, high, logarithmic=False)
    if low >= 0.0:
        middle = value if 0.0 < value < math.inf else max(variable.nominal, low)
        first = min([middle / around, *(number for number in within if number > 0.0)])
        last = max([middle * around, *within])
        return Slider(max(first, low), min(last, high), logarithmic=True, to_zero=low == 0.0, endless=math.isinf(value))
    farthest = max([SIGNED * abs(number) for number in within] + [span]) or abs(variable.nominal)
    return Slider(max(-farthest, low), min(farthest, high), logarithmic=False)
