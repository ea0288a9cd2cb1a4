"""The ground of all file schemas: strict tables, and errors that name key, value and what is allowed."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationError

from bristle.core.errors import InputError, did_you_mean

__all__ = ["ColumnName", "Quantity", "Strict", "by_number", "validated"]


class Strict(BaseModel):
    """A table of a file: unknown keys are refused, nothing is coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


S = TypeVar("S", bound=Strict)


def _number_or_text(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (numbers.Real, str)):
        raise ValueError('a number, or text with a unit such as "7 um"')
    return value


Quantity = Annotated[Any, AfterValidator(_number_or_text)]


def by_number(value: Any) -> Any:
    """Return the number of a column, counted from 1, as its name."""
    return f"column_{value}" if isinstance(value, int) and not isinstance(value, bool) and value > 0 else value


ColumnName = Annotated[str, BeforeValidator(by_number)]
"""The name of a column, or its number, counted from 1."""


# By the kind of error of the library, which speaks of its own classes.
EXPECTED = {
    "model_type": "a table",
    "model_attributes_type": "a table",
    "dict_type": "a table",
    "list_type": "a list",
    "tuple_type": "a list",
    "string_type": "text",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "too_short": "at least {min_length} values",
    "too_long": "at most {max_length} values",
}


MISSING = {
    "schema": "Write schema = 1 on the first line",
    "kind": 'Write kind = "translational" or kind = "rotational" on the second line',
    "columns": 'Write [columns] and, below it, position = { column = "NAME", unit = "mm" }',
}
"""What to write for a table or key that a file cannot do without."""


def validated(schema: type[S], data: Mapping[str, Any]) -> S:
    """Return `data` as the table that `schema` describes."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        raise _refusal(error.errors(), schema) from None


def _refusal(errors: list[Any], schema: type[Strict]) -> InputError:
    # A misspelt key is unknown and leaves the right one missing: the first tells a person more.
    first = next((error for error in errors if error["type"] == "extra_forbidden"), errors[0])
    loc, path = first["loc"], _dotted(first["loc"])
    more = f"{len(errors) - 1} more of this kind follow" if len(errors) > 1 else ""
    if first["type"] == "extra_forbidden":
        keys = _keys(_table_at(schema, loc[:-1]))
        mend = did_you_mean(loc[-1], keys) or _elsewhere(schema, str(loc[-1])) or more
        return InputError("unknown key", path=path, value=first["input"], allowed=", ".join(keys), mend=mend)
    if first["type"] == "missing":
        mend = MISSING.get(path, more)
        return InputError("is missing", path=path, mend=mend)
    if first["type"] in EXPECTED:
        expected = EXPECTED[first["type"]].format_map(first.get("ctx") or {})
    else:
        expected = first["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
    return InputError("does not fit", path=path, value=first["input"], allowed=expected, mend=more)


def _elsewhere(schema: type[Strict], key: str) -> str:
    """Return under which table of the file a key belongs; nothing where none or several have it."""
    tables = [
        name for name, field in schema.model_fields.items() if (table := _table_in(field.annotation)) is not None and key in _keys(table)
    ]
    return f"It belongs under [{tables[0]}]" if len(tables) == 1 else ""


def _dotted(loc: Iterable[str | int]) -> str:
    path = ""
    for part in loc:
        if isinstance(part, str) and "[" in part:  # which of several types was tried
            continue
        path += f"[{part}]" if isinstance(part, int) else f".{part}" if path else part
    return path


def _keys(table: type[Strict]) -> list[str]:
    return [field.alias or name for name, field in table.model_fields.items()]


def _table_at(schema: type[Strict], loc: Iterable[str | int]) -> type[Strict]:
    """Return the table that a path of keys leads to."""
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
