"""Names, literals, parts and helpers of a PLC program: case-insensitive names that avoid the keywords of all vendors.

The language has no standard access to bits. Therefore helpers find a sign by comparison with zero, and a power of two by
multiplication. The code never divides by zero and no number leaves its range, because either stops the program on many
controllers.
"""

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.engine.translation.scope import ascii_name, free_name
from bristle.exports.printing import INDENT

# Keywords and operators of IEC 61131-3, its standard functions and blocks, those of its annex F in libraries of
# compilers, and reserved words of TwinCAT, CODESYS, TIA Portal or MATIEC.
WORDS = """
abs abstract access acos action add adr and and_then any any_bit any_date any_int any_num any_real array asin at atan
atan2 average begin bitadr bool by byte bytes cal calc calcn cdt char class concat configuration constant continue cos
ct ctd ctu ctud cu data data_block date date_and_time db db_specific delay delete derivative diffeq dint div do dt
dword else elsif end end_case end_if enum eq exit exp expt extends f_edge f_trig false fb fc final finally find for
from function function_block ge get global goto gravel gt hysteresis if implements in index ini initial_step insert
int integral interface internal interval iref is jmp jmpc jmpcn label lag1 ld ldate ldn ldt ldword le left len library
limit ln log lreal lt ltime ltod lword max method mid min mod mode move mul mux namespace ne nil non_retain not null
ob object of on or or_else organization out output override package parameter persistent pi pid pointer pou private
program property protected pt public pv r_edge r_trig ramp read_only read_write real ref ref_to reference region
repeat replace res resource ret retain retc retcn return right rol ror round rs rtc s1 sel sema set shl shr sign sin
single sint sizeof sqrt sr st start step stn stop string struct sub sum super sys tan task test then this time timer
title to tod tof ton tp transfer transition true trunc tstring type type_of udint uint ulint union until using usint
value var var_access var_config var_external var_global var_in_out var_input var_output var_stat var_temp variant
version void wchar weigh while with word wstring xor
"""
RESERVED = frozenset(WORDS.split())
LREAL = "LREAL"
REAL = "REAL"
TRUTHS = {True: "TRUE", False: "FALSE"}
SHORT = 2  # letters: length of names of tags, qualifiers of actions and old instructions
# MATIEC folds constants in single precision, which has no more digits.
LARGEST_PRODUCT = 16777215.0 * 2.0**1000
LARGEST_WRITTEN = (
    1e37  # some compilers refuse larger literals, because they read them as REAL first
)
NO_NUMBER_WRITTEN = 3e37  # marks "not a number"
BELOW_ZERO = {LREAL: 2.0**-1000, REAL: 2.0**-120}  # the language cannot distinguish -0.0 from 0.0
STEP = 100  # power of two that builds longer ones


def checked(name: str) -> None:
    """Refuse an invalid name of a block.

    Raises
    ------
    InputError
        If the name is a word of the language, ends with an underscore, or has two underscores in a row.
    """
    if name in RESERVED or len(name) <= SHORT or name.endswith("_") or "__" in name:
        raise InputError(
            "cannot name a function block",
            path="name",
            value=name,
            allowed="three letters or more, not a word of Structured Text, no double underscore, no underscore at the end",
        )


class Names:
    """The names of one scope, unique regardless of case; all begin with `prefix`."""

    def __init__(self, used: Iterable[str] = (), prefix: str = "") -> None:
        self._prefix = prefix
        self._used = {name.lower() for name in used}
        self._names: dict[object, str] = {}

    def of(self, key: object, proposal: str) -> str:
        """Return the name for a key: the proposed name or a similar one."""
        if key not in self._names:
            self._names[key] = self.new(proposal)
        return self._names[key]

    def new(self, proposal: str) -> str:
        """Return an unused name."""
        first = self._prefix + re.sub("_+", "_", ascii_name(proposal)).strip("_")
        if first[0].isdigit():
            first = f"part_{first}"
        if len(first) <= SHORT or first.lower() in RESERVED:
            first = f"v_{first}"
        lowered = free_name(first.lower(), self._used)
        self._used.add(lowered)
        return first + lowered[len(first) :]


def real_literal(value: float, scalar: str = LREAL) -> str:
    """Return an exact real number; a very large or small number becomes an exact product of powers of two."""
    # The language has no literals for infinity and NaN: numbers far outside the range of the model represent them. The
    # largest double, which only bounds finite numbers, loses its last digits. A number of single precision has its type in
    # the literal, because compilers read others as double.
    if value != value:
        return _plain(NO_NUMBER_WRITTEN, scalar)
    if abs(value) == float("inf"):
        return real_literal(math.copysign(LARGEST_WRITTEN, value), scalar)
    if value == 0.0 or 1.0 / LARGEST_WRITTEN <= abs(value) <= LARGEST_WRITTEN:
        return _plain(value, scalar)
    factors = []
    left = math.copysign(min(abs(value), LARGEST_PRODUCT), value)
    power = 2.0**-STEP
    if abs(value) > 1.0:
        power = 2.0**STEP
    while not 2.0**-STEP <= abs(left) <= 2.0**STEP:
        left /= power
        factors.append(_plain(power, scalar))
    return f"({' * '.join([_plain(left, scalar), *factors])})"


def _plain(value: float, scalar: str) -> str:
    if scalar == LREAL:
        text = repr(value)
    else:
        text = str(np.float32(abs(value)))
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa = f"{mantissa}.0"
    number = mantissa
    if exponent:
        number = f"{mantissa}E{int(exponent)}"
    if scalar == LREAL:
        return number
    if value < 0.0:
        return f"-{scalar}#{number}"
    return f"{scalar}#{number}"


def whole_literal(value: int) -> str:
    """Return a whole number, with its type if it exceeds 32 bits."""
    if abs(value) < 2**31:
        return str(value)
    return f"LINT#{value}"


SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR")


@dataclass(frozen=True)
class Variable:
    """A variable or a field: name, type, meaning, section of its POU, initial value."""

    name: str
    type: str
    meaning: str = ""
    section: str = "VAR"
    initial: str = ""


@dataclass(frozen=True)
class Array:
    """A data type: an array of numbers, from index 0."""

    name: str
    size: int
    of: str


@dataclass(frozen=True)
class Record:
    """A data type: a structure of named values."""

    name: str
    fields: tuple[Variable, ...]


@dataclass(frozen=True)
class Pou:
    """A function, a function block or a program; `returns` is the type of a function."""

    kind: str
    name: str
    returns: str
    variables: tuple[Variable, ...]
    body: tuple[str, ...]
    meaning: str = ""

    def declared(self, section: str) -> list[Variable]:
        """Return the variables of one section."""
        return [variable for variable in self.variables if variable.section == section]


def commented(text: str) -> str:
    """Return text that neither begins nor ends a comment."""
    return text.replace("(*", "( *").replace("*)", "* )")


def used_of(types: Sequence[Array | Record], pous: Iterable[Pou]) -> list[Array | Record]:
    """Return the data types in use, each after its inner types."""
    names = {variable.type for pou in pous for variable in pou.variables}
    for part in reversed(types):
        if part.name in names and isinstance(part, Record):
            names |= {field.type for field in part.fields}
    return [part for part in types if part.name in names]


def part_text(part: Array | Record | Pou) -> str:
    """Return a part as Structured Text."""
    if isinstance(part, Array):
        return f"TYPE\n{INDENT}{part.name} : ARRAY[0..{part.size - 1}] OF {part.of};\nEND_TYPE\n"
    if isinstance(part, Record):
        fields = [f"{INDENT * 2}{line}" for line in _declarations(part.fields)]
        return "\n".join(
            [
                "TYPE",
                f"{INDENT}{part.name} :",
                f"{INDENT}STRUCT",
                *fields,
                f"{INDENT}END_STRUCT;",
                "END_TYPE",
                "",
            ]
        )
    lines = []
    if part.meaning:
        lines = [f"(* {commented(part.meaning)} *)"]
    head = f"{part.kind} {part.name}"
    if part.returns:
        head += f" : {part.returns}"
    lines.append(head)
    for section in SECTIONS:
        if declared := part.declared(section):
            lines += [section, *(f"{INDENT}{line}" for line in _declarations(declared)), "END_VAR"]
    return "\n".join([*lines, "", *part.body, f"END_{part.kind}", ""])


def _declarations(variables: Iterable[Variable]) -> Iterator[str]:
    for variable in variables:
        initial = ""
        if variable.initial:
            initial = f" := {variable.initial}"
        meaning = ""
        if variable.meaning:
            meaning = f" (* {commented(variable.meaning)} *)"
        yield f"{variable.name} : {variable.type}{initial};{meaning}"


LARGEST_POWER = {LREAL: 512, REAL: 64}
USUAL_POWER = 32
WHOLE_POWERS = {LREAL: (-1022, 1023), REAL: (-126, 127)}
NUMBER = re.compile(r"(?<![\w.#])\d+\.\d+(?:E-?\d+)?")
WITHIN = "within"  # The helper that checks that a value is a number within a limit

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
    """Return the lines that scale a positive number to 1 to 2 by powers of two, and count them."""
    lines = ["mantissa := number;", "exponent := 0.0;"]
    far = f"(mantissa >= {real_literal(4.0**USUAL_POWER)}) OR (mantissa < {real_literal(2.0 * 4.0**-USUAL_POWER)})"
    lines.append(f"IF {far} THEN")
    power = LARGEST_POWER[scalar]
    while power:
        if power == USUAL_POWER:
            lines.append("END_IF;")
        indent = "    "
        if power <= USUAL_POWER:
            indent = ""
        up = real_literal(2.0**power)
        down = real_literal(2.0**-power)
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


# For each helper: name, result, arguments, further variables, description; then its body. `{own}` is its result,
# `{whole}` the type of whole numbers, `{real}` that of real numbers; other helpers appear by name.
HELPERS = """
within | BOOL | number most | near:BOOL | Whether a value is a number within a limit.
near := number = number;
IF near THEN
    near := (number >= -most) AND (number <= most);
END_IF;
{own} := near;

copysign | real | number sign_of | size | Magnitude of the first number with the sign of the second; the sign of zero is positive.
{sized}
IF sign_of < 0.0 THEN
    {own} := -size;
ELSE
    {own} := size;
END_IF;

abs | real | number | | Magnitude of a number.
{magnitude}

floor | whole | number | cut:whole | The next whole number below, independent of the rounding of a controller.
cut := {real}_TO_{whole}(number);
IF {whole}_TO_{real}(cut) > number THEN
    cut := cut - 1;
END_IF;
{own} := cut;

truncated | whole | number | | The integer part.
IF number < 0.0 THEN
    {own} := -{floor}(number := -number);
ELSE
    {own} := {floor}(number := number);
END_IF;

isinf | BOOL | number | | Whether a number represents infinity.
{own} := ((number >= {far}) AND (number < {none})) OR (number <= -{far});

isnan | BOOL | number | | Whether a number represents "not a number".
{own} := number = {none};

min | real | first second | | The smaller number.
{smaller}

max | real | first second | | The larger number.
{larger}

whole_min | whole | first:whole second:whole | | The smaller number.
{smaller}

whole_max | whole | first:whole second:whole | | The larger number.
{larger}

whole_abs | whole | number:whole | | Magnitude of a whole number.
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

floor_rest | whole | first:whole second:whole | | The remainder of a quotient that is rounded down.
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


def helpers_of(
    names: Collection[str], named: Callable[[str], str], integer: str, scalar: str = LREAL
) -> list[Pou]:
    """Return the requested helpers; `named` maps each to its name in the program."""
    needed = {*names, *(NEEDED[name] for name in names if name in NEEDED)}
    called = {name: named(name) for name in TEXTS if name in needed}
    types = {"whole": integer, "real": scalar}
    least, most = WHOLE_POWERS[scalar]
    facts: dict[str, Any] = {
        **types,
        **called,
        "least": least,
        "most": most,
        "far": real_literal(LARGEST_WRITTEN, scalar),
        "none": real_literal(math.nan, scalar),
    }
    pous = []
    for name, own in called.items():
        gives, arguments, variables, meaning, body = TEXTS[name]
        declared = [
            Variable(variable, types.get(kind or "real", kind), section=section)
            for section, text in (("VAR_INPUT", arguments), ("VAR", variables))
            for variable, _, kind in (word.partition(":") for word in text.split())
        ]
        parts = {f"of_{part}": _scaled(part, scalar, own) for part in ("mantissa", "exponent")}
        parts |= {
            "smaller": CHOICE.format(own=own, than="<"),
            "larger": CHOICE.format(own=own, than=">"),
            "magnitude": SIZE.format(to=own),
            "sized": SIZE.format(to="size"),
        }
        text = body.format(**facts, **parts, own=own)
        # Some compilers read a number without a type as double.
        if scalar != LREAL:
            text = NUMBER.sub(lambda match: real_literal(float(match[0]), scalar), text)
        lines = [f"    {line}" for line in text.strip().split("\n")]
        pous.append(
            Pou("FUNCTION", own, types.get(gives, gives), tuple(declared), tuple(lines), meaning)
        )
    return pous
