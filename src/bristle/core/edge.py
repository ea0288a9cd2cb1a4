"""Validation of the arguments of public functions: converters accept or refuse each argument.

Files and command lines are validated when they are read, but a call from Python may pass any object. `guarded` adds a
converter for each argument to a public function, or to the fields of a public dataclass:

>>> @guarded(speed=amount(Variable("length/time", "speed", min=0.0)), hold=among("zero", "linear"))
... def drive(speed, hold="zero"):
...     return speed, hold
>>> drive("3 mm/s")
(0.003, 'zero')
>>> drive(-1.0)
Traceback (most recent call last):
...
bristle.core.errors.InputError: speed: out of range; found -1.0, allowed >= 0 m/s

The arguments of a converter are the value, the name of the argument, and the kind of axis if another argument states it.
`looked_at` converts errors that foreign objects raise during conversion.

An argument without a converter is compared with its annotation, if this is a path, a text, a truth value, a function, a
dictionary, one of some names, or a class of bristle:

>>> @guarded()
... def kept(path: str | PathLike[str], *, force: bool = False):
...     return path
>>> kept(5)
Traceback (most recent call last):
...
bristle.core.errors.InputError: path: must be a path; found 5
"""

import builtins
import functools
import inspect
import math
import numbers
import types
import typing
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, field
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from bristle.core.contracts import Component, Model
from bristle.core.errors import InputError, did_you_mean
from bristle.core.units import quantity
from bristle.core.values import LARGEST_COUNT, Converter, looked_at, shown
from bristle.core.variable import KINDS, Kind, Variable

Amount = Any  # A number in SI, or text with a unit

T = TypeVar("T", bound=Callable[..., Any])


def guarded(**arguments: Converter) -> Callable[[T], T]:
    """Return a decorator that adds converters to the arguments of a function or to fields of a dataclass, also those from `taken`."""

    def guard(target: Any) -> Any:
        if isinstance(target, type):
            of_fields = {
                name: entry.metadata["taken"]
                for name, entry in fields_of(target).items()
                if "taken" in entry.metadata
            }
            target.__init__ = _in_front(target.__init__, of_fields | arguments)
            return target
        return _in_front(target, arguments)

    return guard


def fields_of(cls: type) -> dict[str, Field[Any]]:
    """Return the fields of a dataclass, by name."""
    return getattr(cls, "__dataclass_fields__", {})


def taken(converter: Converter, default: Any = MISSING, **options: Any) -> Any:
    """Return a field of a `guarded` dataclass with a converter."""
    return field(
        default=default, metadata={"taken": converter} | options.pop("metadata", {}), **options
    )


def _in_front(function: Any, arguments: Mapping[str, Converter]) -> Any:
    parameters = inspect.signature(function).parameters
    names = tuple(
        name
        for name, parameter in parameters.items()
        if parameter.kind is parameter.POSITIONAL_OR_KEYWORD
    )
    usual = parameters["kind"].default if "kind" in parameters else None
    unknown = arguments.keys() - parameters.keys()
    if unknown:
        raise TypeError(f"{function.__qualname__} has no arguments {', '.join(sorted(unknown))}")

    def checked(**keywords: Any) -> dict[str, Any]:
        """Return arguments as the function takes them; refuse unknown ones."""
        for name in keywords.keys() - parameters.keys():
            raise InputError(
                f"is no argument of {function.__name__}",
                path=name,
                mend=did_you_mean(name, parameters),
            )
        converters = {name: arguments[name] for name in keywords if name in arguments}
        return keywords | {
            name: looked_at(converter, keywords[name], name, None)
            for name, converter in converters.items()
        }

    @functools.wraps(function)
    def convert_first(*args: Any, **keywords: Any) -> Any:
        if len(args) > len(names) or not keywords.keys().isdisjoint(names[: len(args)]):
            return function(*args, **keywords)  # which raises the usual TypeError
        handed = dict(zip(names, args, strict=False)) | keywords
        # The kind of axis of a call is the kind of its first model, or the argument `kind`.
        kind = handed.get("kind", usual)
        kind = kind if isinstance(kind, str) and kind in KINDS else None
        models = {
            name: argument for name, argument in handed.items() if isinstance(argument, Model)
        }
        for argument in models.values():
            kind = argument.kind
            break
        for name, converter in {**annotated_arguments(function), **arguments}.items():
            if name in handed:
                handed[name] = looked_at(converter, handed[name], name, kind)
        _refuse_two_kinds(models)
        return function(**handed)

    vars(convert_first)["checked"] = checked
    return convert_first


class _Unresolved:
    """A name in an annotation that only a type checker imports, also with arguments in brackets."""

    def __class_getitem__(cls, arguments: Any) -> Any:
        return cls


class _Unknown(dict[str, Any]):
    def __missing__(self, name: str) -> Any:
        return _Unresolved


@functools.cache
def annotated_arguments(function: Callable[..., Any]) -> dict[str, Converter]:
    """Return a converter for each argument of a function whose annotation can be checked."""
    namespace = ChainMap(function.__globals__, dict(vars(builtins)), _Unknown())
    hints = typing.get_type_hints(function, localns=namespace)
    converters = {name: _of_annotation(hint) for name, hint in hints.items() if name != "return"}
    return {name: converter for name, converter in converters.items() if converter is not None}


def _of_annotation(hint: Any) -> Converter | None:
    """Return the converter for an annotation; None for numbers, arrays, sequences, and what cannot be checked."""
    if typing.get_origin(hint) is typing.Literal:
        return among(*typing.get_args(hint))
    options = (
        typing.get_args(hint)
        if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union
        else (hint,)
    )
    classes = [typing.get_origin(option) or option for option in options]
    if Sequence in classes and set(classes) <= {Sequence, types.NoneType}:
        return optional(_listed) if types.NoneType in classes else _listed
    if not all(cls in _CALLED or _is_own(cls) for cls in classes):
        return None
    of_paths = not {PathLike, Path}.isdisjoint(classes)
    words = [
        _CALLED.get(cls) or f"an object of class {cls.__name__}"
        for cls in classes
        if not (of_paths and cls is str)
    ]
    converter = instance(
        tuple(_WIDER.get(cls, cls) for cls in classes if cls is not types.NoneType),
        " or ".join(filter(None, words)),
    )
    return optional(converter) if types.NoneType in classes else converter


def _listed(value: Any, path: str, kind: Kind | None) -> Any:
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise InputError(
            "must be a list", path=path, value=shown(value), mend="Write it in brackets: [...]"
        )
    return value


def _is_own(cls: Any) -> bool:
    """Return whether it is a class of bristle whose objects can be told from others."""
    is_class = (
        isinstance(cls, type) and cls is not _Unresolved and not getattr(cls, "_is_protocol", False)
    )
    return is_class and cls.__module__.startswith("bristle.")


_CALLED = {
    str: "text",
    bool: "True or False",
    PathLike: "a path",
    Path: "a path",
    Mapping: "a dictionary",
    Callable: "a function",
    types.NoneType: "",
}
_WIDER: dict[Any, Any] = {bool: (bool, np.bool_), Path: PathLike}
OF_A_SCREW = ("table",)  # arguments that act on the other side of a screw


def _refuse_two_kinds(models: Mapping[str, Model]) -> None:
    """Refuse models of both kinds of axis in one call."""
    of_axis = [(name, argument) for name, argument in models.items() if name not in OF_A_SCREW]
    for name, argument in of_axis[1:]:
        first, before = of_axis[0]
        if argument.kind != before.kind:
            raise InputError(
                f"is not of the kind of {first}",
                path=name,
                value=f"{argument.name}, {argument.kind}",
                allowed=f"{before.kind} models",
                mend=f"Write kind={before.kind!r}, or give {first} of the other kind",
            )


SMALLEST = 1e-300  # a quotient by smaller numbers may overflow


def amount(variable: Variable, *, exclusive: bool = False, endless: bool = False) -> Converter:
    """Return a converter for a number in SI units, or text with a unit."""

    def convert(value: Any, path: str, kind: Kind | None) -> float:
        value = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
        try:
            number = quantity(value, variable, kind or KINDS[0], path=path, infinite=endless)
        except InputError:
            # Without a known kind of axis, the units of both kinds are accepted.
            if (
                kind is not None
                or not isinstance(value, str)
                or variable.unit(KINDS[0]) == variable.unit(KINDS[1])
            ):
                raise
            number = quantity(value, variable, KINDS[1], path=path, infinite=endless)
        if 0.0 < abs(number) < SMALLEST:
            raise InputError(
                "is too close to 0",
                path=path,
                value=value,
                allowed=f"0, or {SMALLEST:g} and more in SI",
                mend="Check the unit",
            )
        if not variable.min <= number <= variable.max or (exclusive and number == variable.min):
            allowed = variable.allowed(kind or KINDS[0])
            if exclusive and variable.min == 0.0 and number <= 0.0:
                raise InputError(
                    "must be positive", path=path, value=value, allowed=allowed.replace(">=", ">")
                )
            raise InputError("out of range", path=path, value=value, allowed=allowed)
        return number

    return convert


def quantity_of(
    variable: Variable, default: Any = MISSING, *, count: bool = False, endless: bool = False
) -> Any:
    """Return a field of a guarded dataclass for a quantity; the default of a `count` may be below its range."""
    converter = amount(variable, endless=endless)
    if count:
        converter = whole(
            int(variable.min),
            int(variable.max),
            none=default is not MISSING and default < variable.min,
        )
    return taken(converter, default, metadata={"variable": variable})


def variables_in(cls: type) -> dict[str, Variable]:
    """Return the variables of the quantities in the fields of a dataclass."""
    return {
        name: entry.metadata["variable"]
        for name, entry in fields_of(cls).items()
        if "variable" in entry.metadata
    }


def whole(least: int, most: int = LARGEST_COUNT, *, none: bool = False) -> Converter:
    """Return a converter for a whole number from `least` to `most`; `none` also allows 0."""
    allowed = (
        f"{'0, or ' if none else ''}{least} to {most}"
        if most < LARGEST_COUNT
        else f"{'0, or ' if none else '>= '}{least}"
    )
    allowed += " and more" if none and most >= LARGEST_COUNT else ""

    def convert(value: Any, path: str, kind: Kind | None) -> int:
        number: Any = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
        is_real = isinstance(number, numbers.Real) and not isinstance(number, bool)
        if not is_real or not (
            isinstance(number, numbers.Integral)
            or (math.isfinite(number) and number == number // 1)
        ):
            raise InputError(
                "must be a whole number", path=path, value=shown(value), allowed=allowed
            )
        number = cast("Any", number)
        if not (least <= number <= most or (none and number == 0)):
            raise InputError("out of range", path=path, value=value, allowed=allowed)
        return int(number)

    return convert


def among(*names: str) -> Converter:
    """Return a converter for a choice of names."""

    def convert(value: Any, path: str, kind: Kind | None) -> str:
        if not isinstance(value, str) or value not in names:
            mend = did_you_mean(value, names) if isinstance(value, str) else ""
            raise InputError(
                "is not a valid choice",
                path=path,
                value=shown(value),
                allowed=", ".join(names),
                mend=mend,
            )
        return value

    return convert


def rising(converter: Converter) -> Converter:
    """Return a converter for a range: a pair whose second number is larger."""
    pair = many(converter, least=2, most=2)

    def convert(value: Any, path: str, kind: Kind | None) -> tuple[Any, ...]:
        low, high = pair(value, path, kind)
        if not low < high:
            raise InputError(
                "must be in ascending order",
                path=path,
                value=shown(value),
                allowed="a smaller number, then a larger one",
            )
        return low, high

    return convert


def instance(
    cls: type | tuple[type, ...],
    expected: str,
    mend: str = "",
    read: Callable[[Any], Any] | None = None,
) -> Converter:
    """Return a converter for an instance of a class, or for a value that `read` converts, usually a path."""

    def convert(value: Any, path: str, kind: Kind | None) -> Any:
        candidate = read(value) if read is not None and not isinstance(value, cls) else value
        if not isinstance(candidate, cls):
            raise InputError(f"must be {expected}", path=path, value=shown(value), mend=mend)
        return candidate

    return convert


def model(*families: str) -> Converter:
    """Return a converter for a model with parameters, of these families."""
    expected = " or ".join(map(_called, families))

    def convert(value: Any, path: str, kind: Kind | None) -> Model:
        if not isinstance(value, Model):
            named, mend = value, _EXAMPLES[families[0]]
            if isinstance(value, Component):
                named = value.name
                mend = f"Call {named} with its parameters: {named}({', '.join(f'{name}=...' for name in value.variables)})"
            raise InputError(
                f"must be a {expected} with parameters", path=path, value=shown(named), mend=mend
            )
        family = getattr(value.component, "family", None)
        if family not in families:
            raise InputError(
                f"must be a {expected}, but is a {_called(family)}",
                path=path,
                value=value.name,
                mend="Check the order of the arguments",
            )
        return value

    return convert


_EXAMPLES = {
    "friction": "Give a model such as friction.coulomb(F_C=2.0)",
    "hysteresis": "Give an operator such as hysteresis.play(r=1e-6)",
    "plant": "Give a model such as plants.inertia(M=10.0)",
    "controller": "Give a model such as controllers.cascade(k_p=50.0, k_v=1e4)",
    "sensor": "Give a model such as sensors.encoder()",
    "reference": "Give a model such as references.sine(amplitude=1e-3, frequency=1.0)",
}


def _called(family: Any) -> str:
    return f"{family} {'operator' if family == 'hysteresis' else 'model'}"


def component(family: str) -> Converter:
    """Return a converter for a component without parameters, of this family."""

    def convert(value: Any, path: str, kind: Kind | None) -> Component:
        if not isinstance(value, Component) or value.family != family:
            mend = "Give the attribute component of this model" if isinstance(value, Model) else ""
            raise InputError(
                f"must be a {family} model without parameter values",
                path=path,
                value=shown(value),
                mend=mend,
            )
        return value

    return convert


def optional(converter: Converter) -> Converter:
    """Return a converter that also accepts None."""
    return lambda value, path, kind: None if value is None else converter(value, path, kind)


def many(
    converter: Converter, *, least: int = 0, most: float = math.inf, single: bool = False
) -> Converter:
    """Return a converter for a tuple or list; with `single`, also for a single value."""
    expected = (
        "a list or a tuple of two values"
        if least == most == 2
        else "a list or a tuple" + (f" of at least {least} items" if least else "")
    )

    def convert(value: Any, path: str, kind: Kind | None) -> tuple[Any, ...]:
        value = value.tolist() if isinstance(value, np.ndarray) and value.ndim == 1 else value
        if single and not isinstance(value, (tuple, list)):
            return (converter(value, path, kind),)
        if not isinstance(value, (tuple, list)) or not least <= len(value) <= most:
            raise InputError(f"must be {expected}", path=path, value=shown(value))
        return tuple(
            looked_at(converter, item, f"{path}[{index}]", kind) for index, item in enumerate(value)
        )

    return convert


def mapping(converter: Converter) -> Converter:
    """Return a converter for a mapping with any keys."""

    def convert(value: Any, path: str, kind: Kind | None) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise InputError("must be a dictionary", path=path, value=shown(value))
        return {
            name: looked_at(converter, item, f"{path}.{name}", kind) for name, item in value.items()
        }

    return convert


_TRUTH: Converter = instance((bool, np.bool_), "True or False")


def _flag(value: Any, path: str, kind: Kind | None) -> bool:
    return bool(_TRUTH(value, path, kind))


def _names(value: Any, path: str, kind: Kind | None) -> tuple[str, ...]:
    if isinstance(value, str):
        names = tuple(name.strip() for name in value.split(",") if name.strip())
        if not names and value:
            raise InputError("is an empty list of names", path=path, value=value)
        return names
    return many(TEXT)(value, path, kind)


FLAG: Converter = _flag
TEXT: Converter = instance(str, "text")  # A text
NAMES: Converter = _names  # Names, in a list or separated by commas
# Function that receives the completed share of the work and the stage in words.
Progress = Callable[[float, str], None]


def between(report: Callable[..., None], low: float, high: float) -> Callable[..., None]:
    """Return the progress report of a stage, from the share `low` of the whole work to the share `high`."""
    return lambda share, *words: report(low + (high - low) * share, *words)


KIND: Converter = among(*KINDS)


def array(*, ndim: int = 1, least: int = 0, single: bool = False, finite: bool = True) -> Converter:
    """Return a converter for an array of numbers with `ndim` dimensions."""

    def convert(value: Any, path: str, kind: Kind | None) -> np.ndarray:
        numbers = vector(value, path)
        if not (numbers.ndim == ndim or (single and numbers.ndim < ndim)):
            raise InputError(
                f"must be a {ndim}-D array of numbers", path=path, value=shown(numbers)
            )
        if numbers.ndim and numbers.shape[-1] < least:
            raise InputError(
                "is too short", path=path, value=shown(numbers), allowed=f"at least {least} numbers"
            )
        if finite and not is_finite(numbers):
            place = int(np.flatnonzero(~np.isfinite(numbers))[0])
            raise InputError(
                "contains values that are not finite",
                path=path,
                value=f"{numbers.flat[place]} at index {place}",
                mend="Remove NaN and infinity",
            )
        return numbers

    return convert


def is_finite(numbers: np.ndarray) -> bool:
    """Return whether all numbers are finite."""
    # A finite sum has only finite terms, and is much faster than a test of each term; an overflow is inconclusive.
    with np.errstate(over="ignore", invalid="ignore"):
        total = np.sum(numbers)
    return bool(np.isfinite(total)) or bool(np.all(np.isfinite(numbers)))


def vector(values: Any, name: str = "signal") -> np.ndarray:
    """Convert values to a contiguous, writable floating-point array for compiled entries."""
    if np.ma.is_masked(values):
        raise InputError("has masked values", path=name, mend="Fill or remove these samples")
    try:
        numeric = np.asarray(values).dtype.kind in "fiub"
    except ValueError:  # rows of different lengths
        numeric = False
    if not numeric:
        raise InputError("must hold real numbers in SI", path=name, value=shown(values))
    return np.require(values, dtype=float, requirements=("C", "W"))


def _curve(value: Any, path: str, kind: Kind | None) -> tuple[np.ndarray, np.ndarray]:
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise InputError(
            "must be a curve, a pair of inputs and outputs", path=path, value=shown(value)
        )
    u, f = (array(least=1)(sequence, path, kind) for sequence in value)
    if u.shape != f.shape:
        raise InputError(
            f"needs an output for each input, but has {u.size} inputs and {f.size} outputs",
            path=path,
        )
    return u, f


CURVE: Converter = _curve
