"""What functions in C call beside each other: operations that every target computes exactly, written in its bits."""

from __future__ import annotations

from collections.abc import Collection

from bristle.core.exponent import BITS_OF_ONE, BITS_OF_ROUNDER, INTEGER_IN_LAST_BITS, OF_MANTISSA

__all__ = ["helpers_text"]

WIDTH = {"double": 64, "float": 32}
LARGEST = {"double": "DBL_MAX", "float": "FLT_MAX"}
# Of the format: bits of the fraction, what puts an integer into the last bits, masks.
BITS = {
    "double": {
        "fraction": 52,
        "place": repr(INTEGER_IN_LAST_BITS),
        "of_mantissa": f"0x{OF_MANTISSA:X}",
        "of_one": f"0x{BITS_OF_ONE:X}",
        "of_rounder": f"0x{BITS_OF_ROUNDER:X}",
    },
    "float": {"fraction": 23, "place": "12583039.0f", "of_mantissa": "0x7FFFFF", "of_one": "0x3F800000", "of_rounder": "0x4B400000"},
}
ROOT = {"double": "sqrt", "float": "sqrtf"}
SIZE = {"double": "__builtin_fabs", "float": "__builtin_fabsf"}  # one instruction, and no call, where it is known

TEXTS = {
    "bits": "typedef union {{\n    {scalar} number;\n    uint{width}_t bits;\n}} Bits;\n",
    "copysign": """{inline} {scalar} with_sign({scalar} x, {scalar} sign)
{{
    Bits size = {{x}};
    const Bits side = {{sign}};
    size.bits = (size.bits & ({unsigned}({top}) - 1U)) | (side.bits & {unsigned}({top}));
    return size.number;
}}
""",
    "abs": """{inline} {scalar} magnitude({scalar} x)
{{
#if defined(__GNUC__) && !defined(__CUDACC__)
    return {size}(x);
#else
    Bits size = {{x}};
    size.bits &= {unsigned}({top}) - 1U;
    return size.number;
#endif
}}
""",
    "sqrt": "{inline} {scalar} root({scalar} x)\n{{\n    return {root}(x);\n}}\n",
    "floor": """{inline} {integer} next_below({scalar} x)
{{
    const {integer} cut = ({integer})x;
    return ({scalar})cut > x ? cut - 1 : cut;
}}
""",
    "isinf": "{inline} bool is_infinite({scalar} x)\n{{\n    return x > {largest} || x < -{largest};\n}}\n",
    "isnan": "{inline} bool is_nan({scalar} x)\n{{\n    return x != x;\n}}\n",
    "min": "{inline} {scalar} least({scalar} a, {scalar} b)\n{{\n    return b < a ? b : a;\n}}\n",
    "max": "{inline} {scalar} greatest({scalar} a, {scalar} b)\n{{\n    return b > a ? b : a;\n}}\n",
    "whole_min": "{inline} {integer} whole_least({integer} a, {integer} b)\n{{\n    return b < a ? b : a;\n}}\n",
    "whole_max": """{inline} {integer} whole_greatest({integer} a, {integer} b)
{{
    return b > a ? b : a;
}}
""",
    "whole_abs": "{inline} {integer} whole_magnitude({integer} a)\n{{\n    return a < 0 ? -a : a;\n}}\n",
    "floor_divided": """{inline} {integer} floor_divided({integer} a, {integer} b)
{{
    const {integer} cut = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? cut - 1 : cut;
}}
""",
    "floor_rest": """{inline} {integer} floor_rest({integer} a, {integer} b)
{{
    return a - floor_divided(a, b) * b;
}}
""",
    "power_of_two": """/* 2 to the k, for an integral k in range: the sum has k and the bias in its last bits. */
{inline} {scalar} power_of_two({scalar} k)
{{
    Bits part = {{k + {place}}};
    part.bits <<= {fraction}U;
    return part.number;
}}
""",
    "mantissa": """/* m of x = m 2^k, 1 <= m < 2, for a positive normal number. */
{inline} {scalar} mantissa_of({scalar} x)
{{
    Bits part = {{x}};
    part.bits = (part.bits & {unsigned}({of_mantissa})) | {unsigned}({of_one});
    return part.number;
}}
""",
    "exponent": """/* k of x = m 2^k, 1 <= m < 2, for a positive normal number. */
{inline} {scalar} exponent_of({scalar} x)
{{
    Bits part = {{x}};
    part.bits = (part.bits >> {fraction}U) | {unsigned}({of_rounder});
    return part.number - {place};
}}
""",
}
IN_BITS = ("copysign", "abs", "power_of_two", "mantissa", "exponent")


def helpers_text(names: Collection[str], scalar: str, integer: str, inline: str = "static inline") -> str:
    """Return the helpers that are names for."""
    width = WIDTH[scalar]
    facts = {
        "inline": inline,
        "scalar": scalar,
        "integer": integer,
        "width": width,
        "largest": LARGEST[scalar],
        "root": ROOT[scalar],
        "size": SIZE[scalar],
        "unsigned": f"UINT{width}_C",
        "top": f"0x{1 << (width - 1):X}",
        **BITS[scalar],
    }
    chosen = {"bits", *names} if any(name in names for name in IN_BITS) else set(names)
    return "\n".join(text.format(**facts) for name, text in TEXTS.items() if name in chosen)
