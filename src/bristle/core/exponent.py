"""Mantissa and exponent of floating-point numbers, read and written as bits by the compiler.

The compiler vectorizes a loop over trajectories only without calls of libraries, such as ``ldexp`` and ``frexp`` of the C
library. Moving an integer into or out of the exponent gives the same bits without a call.
"""

import math
from collections.abc import Callable
from typing import Any

from bristle.core.kernel import kernel

# Added to an integral k, the sum holds k + 1023 in its lowest bits: 1.5 * 2^52 keeps the last bit worth one.
INTEGER_IN_LAST_BITS = 6755399441055744.0 + 1023.0
MANTISSA_BITS, BIAS = 52, 1023
OF_MANTISSA = 2**MANTISSA_BITS - 1
BITS_OF_ONE = BIAS << MANTISSA_BITS


def _in_bits(change: Callable[[Any, Any, Any], Any]) -> Any:
    """Return an intrinsic of the compiler that changes the bits of a number."""
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def changed(context: Any, x: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            integer, number = (
                context.get_value_type(types.int64),
                context.get_value_type(types.float64),
            )
            return change(builder, builder.bitcast(arguments[0], integer), number)

        return types.float64(types.float64), generate

    return changed


def power_in_bits() -> Any:
    """Return `power_of_two` for the compiler."""

    def moved(builder: Any, bits: Any, number: Any) -> Any:
        return builder.bitcast(builder.shl(bits, bits.type(MANTISSA_BITS)), number)

    shifted = _in_bits(moved)

    def implementation(k: Any) -> Any:
        return lambda k: shifted(k + INTEGER_IN_LAST_BITS)

    return implementation


def mantissa_in_bits() -> Any:
    """Return `mantissa` for the compiler."""

    def masked(builder: Any, bits: Any, number: Any) -> Any:
        mantissa = builder.and_(bits, bits.type(OF_MANTISSA))
        return builder.bitcast(builder.or_(mantissa, bits.type(BITS_OF_ONE)), number)

    part = _in_bits(masked)

    def implementation(x: Any) -> Any:
        return lambda x: part(x)  # noqa: PLW0108  (the compiler takes a function)

    return implementation


def exponent_in_bits() -> Any:
    """Return `exponent` for the compiler."""

    def read(builder: Any, bits: Any, number: Any) -> Any:
        # In the last bits of 1.5 * 2^52, the biased exponent becomes a number without a conversion.
        placed = builder.or_(
            builder.lshr(bits, bits.type(MANTISSA_BITS)), bits.type(BITS_OF_ROUNDER)
        )
        return builder.bitcast(placed, number)

    part = _in_bits(read)

    def implementation(x: Any) -> Any:
        return lambda x: part(x) - INTEGER_IN_LAST_BITS

    return implementation


BITS_OF_ROUNDER = (BIAS + MANTISSA_BITS << MANTISSA_BITS) | 1 << (MANTISSA_BITS - 1)


@kernel(compiled_as=power_in_bits)
def power_of_two(k):
    """Return 2^k for an integral `k` between -1022 and 1023; outside, the result is undefined."""
    return math.ldexp(1.0, int(k)) if -1022.0 <= k <= 1023.0 else 0.0


@kernel(compiled_as=mantissa_in_bits)
def mantissa(x):
    """Return m of x = m 2^k, 1 <= m < 2, for a positive normal number; otherwise, the result is undefined."""
    return 2.0 * math.frexp(x)[0]


@kernel(compiled_as=exponent_in_bits)
def exponent(x):
    """Return k of x = m 2^k, 1 <= m < 2, for a positive normal number; otherwise, the result is undefined."""
    return math.frexp(x)[1] - 1.0
