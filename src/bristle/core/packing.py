"""Pack parameters and states into flat vectors and back, so that a driver is compiled once for all models.

The layout of a NamedTuple follows its fields: a number for a scalar, the length and the numbers for a 1-D array, and
the layout of a nested NamedTuple. In lanes, number `i` of `LANES` trajectories is contiguous, then number ``i + 1``, so
that the compiler can vectorize over trajectories.
"""

import hashlib
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bristle.core.kernel import kernel


def without_holder() -> Any:
    """Return `unowned` for the compiler."""
    from numba.core import cgutils
    from numba.extending import intrinsic

    @intrinsic
    def disowned(context: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            lent = context.make_array(signature.args[0])(context, builder, arguments[0])
            lent.meminfo = cgutils.get_null_value(lent.meminfo.type)
            return lent._getvalue()

        return array(array), generate

    def implementation(array: Any) -> Any:
        return lambda array: disowned(array)  # noqa: PLW0108  # pyright: ignore[reportCallIssue]

    return implementation


@kernel(compiled_as=without_holder)
def unowned(array):
    """Return the array; compiled, without reference counting."""
    return array


LANES = 32

Structure = tuple[type, tuple[Any, ...]]


def structure_of(value: Any) -> Structure:
    """Return the type of a NamedTuple and the structures of its fields, which determine its layout."""
    parts: list[Any] = []
    for field in value:
        if hasattr(field, "_fields"):
            parts.append(structure_of(field))
        elif isinstance(field, np.ndarray):
            parts.append("array")
        else:
            parts.append(
                "integer"
                if isinstance(field, (int, np.integer)) and not isinstance(field, bool)
                else "number"
            )
    return type(value), tuple(parts)


def is_scalar(structure: Structure) -> bool:
    """Return whether a NamedTuple contains only numbers at all levels, so that its layout is fixed."""
    return all(
        is_scalar(part) if isinstance(part, tuple) else part != "array" for part in structure[1]
    )


def pack(value: Any) -> np.ndarray:
    """Return a NamedTuple of scalars, 1-D arrays and nested NamedTuples as one flat vector.

    Examples
    --------
    >>> from typing import NamedTuple
    >>> class Two(NamedTuple):
    ...     a: float
    ...     k: np.ndarray
    >>> pack(Two(1.0, np.array([5.0, 6.0])))
    array([1., 2., 5., 6.])
    """
    numbers: list[float | np.ndarray] = []
    arrays = _extend(value, numbers)
    if arrays:
        return np.hstack(numbers).astype(float, copy=False)
    return np.array(numbers, dtype=float)


def _extend(value: Any, numbers: list[float | np.ndarray]) -> bool:
    """Append the content of a NamedTuple, and return whether it contains arrays."""
    arrays = False
    for field in value:
        if hasattr(field, "_fields"):
            arrays |= _extend(field, numbers)
        elif isinstance(field, np.ndarray):
            numbers += [float(field.size), field]
            arrays = True
        else:
            numbers.append(float(field))
    return arrays


@cache
def flattener(structure: Structure) -> Callable[[Any], tuple[float, ...]]:
    """Return a function that flattens a nested NamedTuple of scalars to a tuple."""
    numbers = "".join(f"value{place}, " for place in _places(structure))
    return eval(f"lambda value: ({numbers})")


@cache
def unpacker(structure: Structure) -> Callable[[Any], Any]:
    """Return the kernel ``unpack(vector) -> NamedTuple`` for this structure."""
    return _unpacker(
        structure, "unpack(vector)", "0", "vector[at]", "vector[at + 1 : at + 1 + {size}]"
    )


class LaneConstants(NamedTuple):
    """Properties of numbers that are common to all lanes, by their place in a structure of scalars."""

    infinite: frozenset[int] = frozenset()
    twins: frozenset[tuple[int, int]] = frozenset()

    @property
    def word(self) -> str:
        """Short identifier of these properties."""
        return hashlib.sha256(repr([sorted(part) for part in self]).encode()).hexdigest()[:8]


NO_CONSTANTS = LaneConstants()


def lane_constants(structure: Structure, rows: np.ndarray) -> LaneConstants:
    """Return the common properties of some vectors of a structure, shape (lane, number)."""
    if not is_scalar(structure):
        return NO_CONSTANTS
    infinite = np.flatnonzero(np.all(np.isposinf(rows), axis=0))
    return LaneConstants(frozenset(infinite.tolist()), frozenset(_twins(structure, rows, 0)))


def _twins(structure: Structure, rows: np.ndarray, first: int) -> Iterator[tuple[int, int]]:
    """Yield the places of each part that equals a neighbouring part, and the places in that part."""
    before: list[tuple[Structure, int]] = []
    for part in structure[1]:
        size = number_count(part)
        if isinstance(part, tuple):
            numbers = rows[:, first : first + size].tobytes()
            before_it = [
                at
                for kind, at in before
                if kind == part and rows[:, at : at + size].tobytes() == numbers
            ]
            if before_it:
                yield from ((first + place, before_it[0] + place) for place in range(size))
            else:
                before.append((part, first))
                yield from _twins(part, rows, first)
        first += size


def number_count(part: Any) -> int:
    """Return the number of scalars in a part of a structure."""
    return sum(map(number_count, part[1])) if isinstance(part, tuple) else 1


@cache
def lane_unpacker(
    structure: Structure, constants: LaneConstants = NO_CONSTANTS
) -> Callable[[Any, int, int], Any]:
    """Return the kernel ``unpack(block, row, lane) -> NamedTuple`` of a lane whose numbers begin in this row."""
    array = f"block[(at + 1) * {LANES} + lane : (at + 1 + {{size}}) * {LANES} : {LANES}]"
    return _unpacker(
        structure,
        "unpack(block, row, lane)",
        "row",
        f"block[at * {LANES} + lane]",
        array,
        constants,
    )


def _unpacker(
    structure: Structure,
    head: str,
    first: str,
    number: str,
    array: str,
    constants: LaneConstants = NO_CONSTANTS,
) -> Callable[..., Any]:
    names: dict[str, Any] = {"INFINITY": float("inf"), "unowned": unowned}
    lines = [f"at = {first}"]
    expression = _unpack_expression(structure, names, lines, number, array, constants)
    return kernel_of(head, [*lines, f"return {expression}"], names)


def _unpack_expression(
    structure: Structure,
    names: dict[str, Any],
    lines: list[str],
    number: str,
    array: str,
    constants: LaneConstants,
) -> str:
    cls, parts = structure
    twins = dict(constants.twins)
    key = f"Class{len(names)}"
    names[key] = cls
    arguments = []
    for part in parts:
        if isinstance(part, tuple):
            arguments.append(_unpack_expression(part, names, lines, number, array, constants))
            continue
        name, place = f"field_{len(lines)}", lines.count("at += 1")
        if part == "array":
            size = f"size_{name}"
            lines += [
                f"{size} = int({number})",
                f"{name} = unowned({array.format(size=size)})",
                f"at += 1 + {size}",
            ]
        elif place in constants.infinite:
            lines += [f"{name} = INFINITY", "at += 1"]
        elif place in twins:
            lines += [f"{name} = field_{1 + 2 * twins[place]}", "at += 1"]
        else:
            cast = "int" if part == "integer" else "float"
            lines += [f"{name} = {cast}({number})", "at += 1"]
        arguments.append(name)
    return f"{key}({', '.join(arguments)})"


@cache
def packer(structure: Structure) -> Callable[[Any, Any], None]:
    """Return the kernel ``store(value, vector)`` that writes a NamedTuple of scalars into a vector."""
    lines = [f"vector[{i}] = value{place}" for i, place in enumerate(_places(structure))]
    return kernel_of("store(value, vector)", lines or ["return"], {})


def _places(structure: Structure) -> list[str]:
    """Return the index expression of each number of a NamedTuple, such as ``[1][0]``, in the order of the layout."""
    paths: list[str] = []
    for i, part in enumerate(structure[1]):
        paths += (
            [f"[{i}]{inner}" for inner in _places(part)] if isinstance(part, tuple) else [f"[{i}]"]
        )
    return paths


@cache
def lane_packer(structure: Structure) -> Callable[[Any, Any, int, int], None]:
    """Return the kernel ``store(value, block, row, lane)`` that writes a NamedTuple of scalars into one lane."""
    lines = [
        f"block[(row + {i}) * {LANES} + lane] = value{place}"
        for i, place in enumerate(_places(structure))
    ]
    return kernel_of("store(value, block, row, lane)", lines or ["return"], {})


@cache
def motion_reader(motion: Any) -> Callable[[Any, Any, Any, int], Any]:
    """Return the kernel ``moved(v, x, around, k) -> motion`` of a step, for a class of motions."""
    more = [f"around[k + {place} * v.size]" for place in range(len(motion._fields) - 2)]
    return kernel_of(
        "moved(v, x, around, k)",
        [f"return Motion({', '.join(['v[k]', 'x[k]', *more])})"],
        {"Motion": motion},
    )


def kernel_of(
    head: str, lines: list[str], names: dict[str, Any], *, portable: bool = True
) -> Callable[..., Any]:
    """Return the kernel with this head and these lines, which can use these names."""
    text = f"def {head}:\n" + "".join(f"    {line}\n" for line in lines)
    scope: dict[str, Any] = {"__name__": __name__} | names
    exec(compile(text, f"<{head}>", "exec"), scope)
    function = scope[head.partition("(")[0]]
    function.source = text
    return kernel(portable=portable)(function)
