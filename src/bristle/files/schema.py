"""Schema of axis files: strict tables, with errors that name the key, the value and the allowed values."""

import numbers
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from bristle.core.dimensions import AxisKind
from bristle.core.errors import InputError, did_you_mean
from bristle.core.former import FORMER
from bristle.core.motion import Side


class Strict(BaseModel):
    """A table of a file: unknown keys are refused, values are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


S = TypeVar("S", bound=Strict)


def _number_or_text(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, str)):
        raise ValueError('a number, or text with a unit such as "7 um"')
    return value


Quantity = Annotated[Any, AfterValidator(_number_or_text)]


def by_number(value: Any) -> Any:
    """Return the name of a column that is given by its number, from 1."""
    if isinstance(value, int) and not isinstance(value, bool) and value > 0:
        return f"column_{value}"
    return value


# The name of a column, or its number, counted from 1
ColumnName = Annotated[str, BeforeValidator(by_number)]


# By the type of the error of the library, whose messages name its classes.
EXPECTED = {
    "model_type": "a table",
    "model_attributes_type": "a table",
    "dict_type": "a table",
    "list_type": "a list",
    "tuple_type": "a list",
    "string_type": "text",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "float_type": "a number without quotes",
    "too_short": "at least {min_length} values",
    "too_long": "at most {max_length} values",
}


MISSING = {
    "kind": 'Write kind = "translational" or kind = "rotational" on the second line',
    "columns": 'Write [columns] and, below it, position = { column = "NAME", unit = "mm" }',
}
"""Remedies for required tables or keys that are missing."""


def validated(schema: type[S], data: Mapping[str, Any]) -> S:
    """Return `data` as the table that `schema` describes."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        raise _refusal(error.errors(), schema) from None


def _refusal(errors: list[Any], schema: type[Strict]) -> InputError:
    # A misspelt key gives two errors, unknown and missing: report the unknown key.
    first = next((error for error in errors if error["type"] == "extra_forbidden"), errors[0])
    loc, path = first["loc"], _dotted(first["loc"])
    more = f"Count of errors in this file: {len(errors)}" if len(errors) > 1 else ""
    key_of_any = ".".join(part for part in loc if isinstance(part, str))
    if key_of_any in FORMER:
        return InputError("was removed", path=path, mend=FORMER[key_of_any])
    if first["type"] == "extra_forbidden":
        keys, key = _keys(_table_at(schema, loc[:-1])), str(loc[-1])
        inner = {name: _table_in(field.annotation) for name, field in schema.model_fields.items()}
        tables = [
            name for name, table in inner.items() if table is not None and key in _keys(table)
        ]
        elsewhere = f"This key belongs under [{tables[0]}]" if len(tables) == 1 else ""
        mend = did_you_mean(key, keys) or elsewhere or more
        return InputError("unknown key", path=path, allowed=f"keys: {', '.join(keys)}", mend=mend)
    if first["type"] == "missing":
        return InputError("is missing", path=path, mend=MISSING.get(path, more))
    expected = EXPECTED.get(first["type"], "").format_map(first.get("ctx") or {})
    expected = expected or first["msg"].removeprefix("Input should be ").removeprefix(
        "Value error, "
    )
    return InputError("is not valid", path=path, value=first["input"], allowed=expected, mend=more)


def _dotted(loc: Iterable[str | int]) -> str:
    path = ""
    for part in loc:
        if isinstance(part, str) and "[" in part:  # the type that was tried
            continue
        path += f"[{part}]" if isinstance(part, int) else f".{part}" if path else part
    return path


def _keys(table: type[Strict]) -> list[str]:
    return [field.alias or name for name, field in table.model_fields.items()]


def _table_at(schema: type[Strict], loc: Iterable[str | int]) -> type[Strict]:
    """Return the table at a path of keys."""
    table = schema
    for part in loc:
        fields = {field.alias or name: field for name, field in table.model_fields.items()}
        if part in fields:
            table = _table_in(fields[str(part)].annotation) or table
    return table


def _table_in(annotation: Any) -> type[Strict] | None:
    if isinstance(annotation, type) and issubclass(annotation, Strict):
        return annotation
    return next((table for inner in get_args(annotation) if (table := _table_in(inner))), None)


def _no_truth_value(value: Any) -> Any:
    """Refuse truth values, which Python accepts as numbers."""
    if isinstance(value, bool):
        raise ValueError("1 or -1")
    return value


class SignalEntry(Strict):
    """Column, unit and sign of a signal."""

    column: ColumnName
    unit: str | None = None
    sign: Annotated[Literal[1, -1], BeforeValidator(_no_truth_value)] = 1


class ColumnEntry(SignalEntry):
    """A channel: a signal, the side of its measurement, and whether it is optional."""

    side: Side | None = None
    optional: bool = False


def long_form(value: Any) -> Any:
    """Accept the bare name of a column as a complete entry."""
    if isinstance(value, (str, int)) and not isinstance(value, bool):
        return {"column": value}
    return value


Signal = Annotated[SignalEntry, BeforeValidator(long_form)]
Entry = Annotated[ColumnEntry, BeforeValidator(long_form)]


class Columns(Strict):
    """Channels of the log; further keys are surroundings of the axis for slots."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Entry] = Field(init=False)  # type: ignore[assignment]

    time: Entry | None = None
    position: Entry | None = None
    velocity: Entry | None = None
    effort: Entry | None = None
    reference: Entry | None = None
    following_error: Entry | None = None


class InjectedEntry(Strict):
    """A known input of the loop: effort per unit of the column."""

    column: ColumnName
    gain: Quantity
    optional: bool = False


class KnownEntry(Strict):
    """A column of the log, or of the table `file`, whose product with a coefficient is an effort."""

    column: ColumnName
    name: Annotated[str, Field(pattern=r"^\w+$")] | None = None
    optional: bool = False
    unit: str = ""
    coefficient: Quantity = "identify"
    file: str = ""
    log: str = ""


class CoggingEntry(Strict):
    """Periodic part of the effort per turn of the motor or screw."""

    turn: Literal["motor", "screw"] = "motor"
    harmonics: (
        Annotated[list[Annotated[int, Field(ge=1, le=10_000)]], Field(max_length=200)]
        | Literal["identify"]
    ) = "identify"


class EffortEntry(Strict):
    """Conversion of values of the drive to a force or torque."""

    force_constant: str | None = None
    torque_constant: str | None = None
    constant: str | None = None
    rated: str | None = None
    limit: Quantity | None = None
    held: bool | None = None
    hold: Literal["zero", "linear", "band_limited"] | None = None
    lag: Quantity = 0.0
    periodic: bool | None = None


class TransmissionEntry(Strict):
    """Transmission between motor and load."""

    gear_ratio: Annotated[float, Field(gt=0)] | None = None
    lead: Quantity | None = None


class PlantEntry(Strict):
    """Known data of the moving mass."""

    model: Literal["inertia", "oscillator"] = "inertia"
    stiffness: Quantity | None = None
    damping: Quantity | None = None
    mass: Quantity | None = None
    inertia: Quantity | None = None
    offset: Quantity = "identify"
    presliding: Quantity | None = None
    nominal_load: Quantity | None = None
    gravity: Literal["link"] | None = None
    spring: Literal["linear", "cubic"] | None = None


class EncoderEntry(Strict):
    """The position sensor."""

    resolution: Quantity | None = None
    counts_per_rev: Annotated[float, Field(gt=0)] | None = None
    side: Side | None = None


class LogEntry(Strict):
    """Place of the log in the file."""

    table: Annotated[str, Field(min_length=1)] | None = None
    start: Literal["rest", "moving", "cycle"] = "moving"
    span: Annotated[list[Quantity], Field(min_length=2, max_length=2)] | None = None


class TimingEntry(Strict):
    """Sample time and delay of the channels."""

    sample_time: Quantity | None = None
    sample_rate: Quantity | None = None
    delay: Quantity | None = None


class LimitsEntry(Strict):
    """Limits of the motion of the axis."""

    velocity: Quantity | None = None
    acceleration: Quantity | None = None
    jerk: Quantity | None = None
    stroke: Annotated[list[Quantity], Field(min_length=2, max_length=2)] | None = None
    following_error: Quantity | None = None


class IdentificationEntry(Strict):
    """Filters of the log before the fit, and options of the fit."""

    cutoff: Quantity | None = None
    decimation: Annotated[int, Field(ge=1)] | None = None
    rests: Literal["drop", "keep"] = "drop"
    method: Literal["prediction_error", "inverse_dynamics", "output_error"] = "prediction_error"
    loop: Literal["open", "closed"] | None = None
    settings: dict[str, Quantity] = Field(default_factory=dict)


class AxisFile(Strict):
    """Complete axis file."""

    schema_version: Literal[1] = Field(alias="schema")
    name: str = "axis"
    kind: AxisKind
    log: LogEntry = LogEntry()
    columns: Columns
    effort: EffortEntry = EffortEntry()
    injected: list[InjectedEntry] = Field(default_factory=list)
    known: list[KnownEntry] = Field(default_factory=list)
    cogging: list[CoggingEntry] = Field(default_factory=list)
    transmission: TransmissionEntry = TransmissionEntry()
    plant: PlantEntry = PlantEntry()
    encoder: EncoderEntry = EncoderEntry()
    timing: TimingEntry = TimingEntry()
    limits: LimitsEntry = LimitsEntry()
    identification: IdentificationEntry = IdentificationEntry()
    controller: dict[str, Any] | None = None
