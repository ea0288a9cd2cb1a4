"""The power of two that scales a floating-point number: written into its bits where the compiler can do that.

A loop over many trajectories runs several of them in one instruction only if nothing in it calls a library. The C
library's ``ldexp`` is such a call; moving an integer into the exponent is not, and gives the same bits.
"""

from __future__ import annotations

import math
from typing import Any

from bristle.core.kernel import kernel

__all__ = ["power_of_two"]

# Added to an integral k, the sum holds k + 1023 in its lowest bits: 1.5 * 2^52 keeps the last bit worth one.
INTEGER_IN_LAST_BITS = 6755399441055744.0 + 1023.0
MANTISSA_BITS = 52


def in_bits() -> Any:
    """Return `power_of_two` for the compiler."""
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def shifted(context: Any, k: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            integer = context.get_value_type(types.int64)
            bits = builder.bitcast(arguments[0], integer)
            moved = builder.shl(bits, integer(MANTISSA_BITS))
            return builder.bitcast(moved, context.get_value_type(types.float64))

        return types.float64(types.float64), generate

    def implementation(k: Any) -> Any:
        return lambda k: shifted(k + INTEGER_IN_LAST_BITS)  # pyright: ignore[reportCallIssue]

    return implementation


@kernel(compiled_as=in_bits)
def power_of_two(k):
    """Return 2^k for an integral `k` between -1022 and 1023; outside, the result means nothing."""
    return math.ldexp(1.0, int(k)) if -1022.0 <= k <= 1023.0 else 0.0
