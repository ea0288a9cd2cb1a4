"""What functions in Structured Text call beside each other: arithmetic that needs no bits of a number.

The language reads no bits, and what makers have for that differs. Here a sign is what a comparison with zero says, and
a power of two is a product. Nothing divides by zero, and no number leaves its range: on many controllers either stops
the program.
"""

import math
import re
from collections.abc import Callable, Collection
from typing import Any

from bristle.exports.st_parts import LARGEST_WRITTEN, LREAL, REAL, Pou, Variable, real_literal

LARGEST_POWER, USUAL_POWER = {LREAL: 512, REAL: 64}, 32
WHOLE_POWERS = {LREAL: (-1022, 1023), REAL: (-126, 127)}
NUMBER = re.compile(r"(?<![\w.#])\d+\.\d+(?:E-?\d+)?")
WITHIN = "within"
"""The helper that tells whether a number is one, and no larger than another."""

SIZE = """IF number < 0.0 THEN
    {to} := -number;
ELSE
    {to} := 0.0 + number;
END_IF;"""
CHOICE = """IF second {than} first THEN
    {own} := second;
ELSE
    {own} := first;
END_IF;"""


def _scaled(gives: str, scalar: str, own: str) -> str:
    """Return the lines that bring a positive number between 1 and 2 by powers of two, and count them."""
    lines = ["mantissa := number;", "exponent := 0.0;"]
    far = f"(mantissa >= {real_literal(4.0**USUAL_POWER)}) OR (mantissa < {real_literal(2.0 * 4.0**-USUAL_POWER)})"
    lines.append(f"IF {far} THEN")
    power = LARGEST_POWER[scalar]
    while power:
        if power == USUAL_POWER:
            lines.append("END_IF;")
        indent = "" if power <= USUAL_POWER else "    "
        up, down = real_literal(2.0**power), real_literal(2.0**-power)
        lines += [
            indent + line
            for line in (
                f"IF mantissa >= {up} THEN",
                f"    mantissa := mantissa * {down};",
                f"    exponent := exponent + {power}.0;",
                f"ELSIF mantissa < {real_literal(2.0 ** (1 - power))} THEN",
                f"    mantissa := mantissa * {up};",
                f"    exponent := exponent - {power}.0;",
                "END_IF;",
            )
        ]
        power //= 2
    return "\n".join([*lines, f"{own} := {gives};"])


# For each its name, its result, its arguments, further variables, and what it is; below that its body. `{own}` is what it
# gives, `{whole}` the type of whole numbers, `{real}` that of real ones; another helper is named by its name.
HELPERS = """
within | BOOL | number most | near:BOOL | Whether this is a number, and no farther from 0 than another.
near := number = number;
IF near THEN
    near := (number >= -most) AND (number <= most);
END_IF;
{own} := near;

copysign | real | number sign_of | size | Size of one number, sign of another; that of zero is positive.
{sized}
IF sign_of < 0.0 THEN
    {own} := -size;
ELSE
    {own} := size;
END_IF;

abs | real | number | | Size of a number.
{magnitude}

floor | whole | number | cut:whole | The next whole number below, however a controller rounds.
cut := {real}_TO_{whole}(number);
IF {whole}_TO_{real}(cut) > number THEN
    cut := cut - 1;
END_IF;
{own} := cut;

truncated | whole | number | | What stands before the point.
IF number < 0.0 THEN
    {own} := -{floor}(number := -number);
ELSE
    {own} := {floor}(number := number);
END_IF;

isinf | BOOL | number | | Whether a number stands for an infinite one.
{own} := ((number >= {far}) AND (number < {none})) OR (number <= -{far});

isnan | BOOL | number | | Whether a number stands for what is none.
{own} := number = {none};

min | real | first second | | The smaller one.
{smaller}

max | real | first second | | The larger one.
{larger}

whole_min | whole | first:whole second:whole | | The smaller one.
{smaller}

whole_max | whole | first:whole second:whole | | The larger one.
{larger}

whole_abs | whole | number:whole | | Size of a whole number.
IF number < 0 THEN
    {own} := -number;
ELSE
    {own} := number;
END_IF;

floor_divided | whole | first:whole second:whole | cut:whole | The quotient, rounded down.
cut := first / second;
IF (cut * second <> first) AND ((first < 0) <> (second < 0)) THEN
    cut := cut - 1;
END_IF;
{own} := cut;

floor_rest | whole | first:whole second:whole | | What a quotient that is rounded down leaves.
{own} := first - {floor_divided}(first := first, second := second) * second;

power_of_two | real | power | remaining:whole factor grown | 2 to a whole power, by squaring: exact.
grown := 0.0;
IF (power >= {least}.0) AND (power <= {most}.0) THEN
    remaining := {real}_TO_{whole}(power);
    factor := 2.0;
    IF remaining < 0 THEN
        remaining := -remaining;
        factor := 0.5;
    END_IF;
    grown := 1.0;
    WHILE remaining > 0 DO
        IF (remaining MOD 2) = 1 THEN
            grown := grown * factor;
        END_IF;
        remaining := remaining / 2;
        IF remaining > 0 THEN
            factor := factor * factor;
        END_IF;
    END_WHILE;
END_IF;
{own} := grown;

mantissa | real | number | mantissa exponent | m of m 2^k, m from 1 to 2, of a positive number.
{of_mantissa}

exponent | real | number | mantissa exponent | k of m 2^k, m from 1 to 2, of a positive number.
{of_exponent}
"""
TEXTS: dict[str, list[str]] = {}
for _block in HELPERS.strip().split("\n\n"):
    _head, _, _body = _block.partition("\n")
    _name, *_facts = (part.strip() for part in _head.split("|"))
    TEXTS[_name] = [*_facts, _body]
NEEDED = {"truncated": "floor", "floor_rest": "floor_divided"}


def helpers_of(names: Collection[str], named: Callable[[str], str], integer: str, scalar: str = LREAL) -> list[Pou]:
    """Return the helpers that are asked for; `named` tells what each is called."""
    needed = {*names, *(NEEDED[name] for name in names if name in NEEDED)}
    called = {name: named(name) for name in TEXTS if name in needed}
    types, (least, most) = {"whole": integer, "real": scalar}, WHOLE_POWERS[scalar]
    facts: dict[str, Any] = {**types, **called, "least": least, "most": most}
    facts |= {"far": real_literal(LARGEST_WRITTEN, scalar), "none": real_literal(math.nan, scalar)}
    pous = []
    for name, own in called.items():
        gives, arguments, variables, meaning, body = TEXTS[name]
        declared = [
            Variable(variable, types.get(kind or "real", kind), section=section)
            for section, text in (("VAR_INPUT", arguments), ("VAR", variables))
            for variable, _, kind in (word.partition(":") for word in text.split())
        ]
        parts = {f"of_{part}": _scaled(part, scalar, own) for part in ("mantissa", "exponent")}
        parts |= {"smaller": CHOICE.format(own=own, than="<"), "larger": CHOICE.format(own=own, than=">")}
        parts |= {"magnitude": SIZE.format(to=own), "sized": SIZE.format(to="size")}
        text = body.format(**facts, **parts, own=own)
        # A number without a type is read as double by some compilers.
        text = text if scalar == LREAL else NUMBER.sub(lambda match: real_literal(float(match[0]), scalar), text)
        lines = [f"    {line}" for line in text.strip().split("\n")]
        pous.append(Pou("FUNCTION", own, types.get(gives, gives), tuple(declared), tuple(lines), meaning))
    return pous
