"""Parts of a source in C: operations on bits, parameters, and saving over a restart."""

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from bristle.core.exponent import BITS_OF_ONE, BITS_OF_ROUNDER, INTEGER_IN_LAST_BITS, OF_MANTISSA
from bristle.engine.translation.tree import REAL, Array, Struct, Type
from bristle.exports.c_code import Printer, initializer, number
from bristle.exports.described import meaning_within
from bristle.exports.printing import wrapped
from bristle.exports.subject import Subject, capacity_of, digest_of
from bristle.exports.tunable import Tunable, bounds_of

# Fields of the state: name, type, meaning, and initial value.
Fields = Sequence[tuple[str, Type, str, Any]]
# Of the format: bits of the fraction, the number that shifts an integer into the last bits, masks, and library functions.
BITS: dict[str, dict[str, Any]] = {
    "double": {
        "width": 64,
        "fraction": 52,
        "place": repr(INTEGER_IN_LAST_BITS),
        "top": "0x8000000000000000",
        "root": "sqrt",
    }
    | {
        "of_mantissa": f"0x{OF_MANTISSA:X}",
        "of_one": f"0x{BITS_OF_ONE:X}",
        "of_rounder": f"0x{BITS_OF_ROUNDER:X}",
    }
    # One instruction without a call, if the compiler has it.
    | {"size": "__builtin_fabs", "largest": "DBL_MAX"},
    "float": {
        "width": 32,
        "fraction": 23,
        "place": "12583039.0f",
        "top": "0x80000000",
        "root": "sqrtf",
    }
    | {"of_mantissa": "0x7FFFFF", "of_one": "0x3F800000", "of_rounder": "0x4B400000"}
    | {"size": "__builtin_fabsf", "largest": "FLT_MAX"},
}

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


def helpers_text(
    names: Collection[str], scalar: str, integer: str, inline: str = "static inline"
) -> str:
    """Return the text of the named helpers."""
    facts = BITS[scalar] | {
        "inline": inline,
        "scalar": scalar,
        "integer": integer,
        "unsigned": f"UINT{BITS[scalar]['width']}_C",
    }
    in_bits = {"copysign", "abs", "power_of_two", "mantissa", "exponent"}
    if in_bits.intersection(names):
        chosen = {"bits", *names}
    else:
        chosen = set(names)
    return "\n".join(text.format(**facts) for name, text in TEXTS.items() if name in chosen)


CONSTANT = "parameters"  # Name of the constant for kernels if no parameter can change


def parameters_text(
    p: Any, kind: Struct, printer: Printer, name: str, tuned: Tunable | None
) -> str:
    """Return the parameters of the kernels: a constant or, if parameters can change, a function that assembles them.

    A second function checks that each parameter is in its range.
    """
    if tuned is None:
        return constant_text(CONSTANT, p, kind, printer)
    tests = []
    for parameter, place, compared in bounds_of(tuned):
        field = f"given->{place_of(parameter, place, printer)}"
        for operator, bound in compared:
            largest = BITS[printer.scalar]["largest"]
            infinite = {math.inf: f"{largest}", -math.inf: f"-{largest}"}
            text = infinite.get(bound, number(bound, printer.scalar))
            tests.append(f"{field} {operator} {text}")
    head = f"{printer.inline} bool within_ranges(const {name}_parameters *given)"
    within = "\n".join(
        [head, "{", *wrapped(f"    return {' && '.join(tests) or 'true'};", "    "), "}", ""]
    )
    return f"{assembled(p, tuned, printer, kind, f'{name}_parameters')}\n{within}"


def constant_text(name: str, p: Any, kind: Struct, printer: Printer, *path: str) -> str:
    """Return parameters as a constant; its arrays become separate constants, named by their path."""
    arrays: list[str] = []
    structure = _structure(p, kind, printer, arrays, None, path)
    return "\n".join(
        [
            *arrays,
            *wrapped(f"{printer.constant} {printer.named(kind, name)} = {structure};", ""),
            "",
        ]
    )


def assembled(
    p: Any, tuned: Tunable, printer: Printer, kind: Struct, given: str, called: str = "assembled"
) -> str:
    """Return the function that assembles the parameters of the kernels from the structure `given`."""
    arrays: list[str] = []
    returned = f"    return {_structure(p, kind, printer, arrays, tuned)};"
    head = f"{printer.inline} {printer.named(kind, called)}(const {given} *given)"
    return "\n".join([*arrays, head, "{", *wrapped(returned, "    "), "}", ""])


def _structure(
    value: Any,
    kind: Struct,
    printer: Printer,
    arrays: list[str],
    tuned: Tunable | None,
    path: tuple[str, ...] = (),
) -> str:
    """Return the text of a structure, with the variable parameters of `tuned`; its arrays become separate constants."""
    parts: list[str] = []
    for (name, part), field in zip(kind.fields, value, strict=True):
        inner = (*path, name)
        if isinstance(part, Struct):
            parts.append(_structure(field, part, printer, arrays, tuned, inner))
        elif tuned is not None and inner in tuned.places:
            parts.append(f"given->{printer.names.variable(tuned.places[inner])}")
        elif isinstance(part, Array):
            parts.append(f"fixed_{'_'.join(inner)}")
            arrays.append(array_text(parts[-1], field, printer))
        else:
            parts.append(literal(field, part, printer.scalar))
    text = initializer(parts)
    if tuned is None:
        return f"{{{text}}}"
    return printer.structure_text(kind, text)


def array_text(name: str, values: np.ndarray, printer: Printer) -> str:
    """Return an array as a constant."""
    numbers = [number(float(value), printer.scalar) for value in values]
    lines = [", ".join(numbers[at : at + 6]) for at in range(0, len(numbers), 6)]
    size = max(len(numbers), 1)
    return (
        f"{printer.constant} {printer.scalar} {name}[{size}] = {{\n    "
        + ",\n    ".join(lines or ["0"])
        + "\n};"
    )


def literal(value: Any, kind: Type, scalar: str) -> str:
    """Return a number of this type as text of C."""
    if kind == REAL:
        return number(float(value), scalar)
    return str(int(value))


def declared(tuned: Tunable, printer: Printer) -> list[str]:
    """Return the fields of the structure of the parameters."""
    lines = []
    for name, value in tuned.values.items():
        size = ""
        if isinstance(value, np.ndarray):
            size = f"[{value.size}]"
        field = f"{printer.scalar} {printer.names.variable(name)}{size}"
        lines.append(f"{field}; /* {meaning_within(tuned.variables[name], tuned.kind)} */")
    return lines


def started(tuned: Tunable, printer: Printer) -> list[str]:
    """Return the lines that set the exported values."""
    return [
        f"axis->parameters.{place_of(name, place, printer)} = {number(value, printer.scalar)};"
        for name, place, value in tuned.numbers()
    ]


def place_of(name: str, place: int | None, printer: Printer) -> str:
    """Return a number among the parameters as text of C."""
    if place is None:
        return printer.names.variable(name)
    return f"{printer.names.variable(name)}[{place}]"


def around_text(subject: Subject, printer: Printer) -> list[str]:
    """Return the inputs of friction besides the motion as text of C: signals by name, others as their usual values."""
    usual = {name: repr(value) for name, value in subject.usual.items()}
    usual |= {name: printer.names.variable(name) for name in subject.signals}
    return list(usual.values())


def saved_facts(
    printer: Printer, heads: Sequence[str], fields: Fields, memory_size: int, layout: str
) -> dict[str, Any]:
    """Return the facts for the template of ``save`` and ``load``."""
    widened = ""
    narrowed = ""
    if printer.scalar != "double":
        widened = "(double)"
        narrowed = "(float)"
    first = 8 * (2 + len(heads))  # after the layout, the heads, and 8 bytes of `begun` and `flags`
    lines = []
    for place, (name, kind, *_) in enumerate(fields):
        at = f"bytes + {first + 8 * place}"
        field = f"axis->state.{name}"
        if kind == REAL:
            save = f"put_real(at, {widened}{field})"
            load = f"{narrowed}got_real({at})"
            refused = f"!is_finite(got_real({at}))"
        else:
            save = f"put(at, (uint64_t){field})"
            load = f"({printer.type_name(kind)})got({at})"
            refused = f"got({at}) >= {capacity_of(name, memory_size)}U"
        lines.append({"put": save, "got": f"{field} = {load}", "refused": refused})
    memory_at = first + 8 * len(lines)
    return (
        {
            "heads": [{"name": name, "at": 8 * (1 + place)} for place, name in enumerate(heads)],
            "marks_at": first - 8,
        }
        | {"saved": memory_at + 8 * memory_size + 8, "saved_state": lines, "memory_at": memory_at}
        | {
            "layout": f"0x{digest_of(layout.encode()):016X}",
            "widened": widened,
            "narrowed": narrowed,
        }
    )
