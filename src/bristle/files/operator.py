"""Hysteresis operators in files: as ``[operator]`` with its values, or as the kernel of a friction model."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bristle.core import InputError, Model, Readable, amount, content_of, guarded, located, model
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.components import (
    check_keys,
    check_schema,
    key_of,
    kind_at,
    model_from,
    number_at,
    table_at,
)
from bristle.files.single import write_whole
from bristle.files.toml import TOML_LIMIT, Said, as_toml, read_toml
from bristle.models.friction import MODELS
from bristle.models.hysteresis import OPERATORS

OFFSET = Variable("force", "constant output added to the operator")


class OperatorFile(NamedTuple):
    """Content of a model file of an operator; `provenance` states the origin of the values."""

    operator: Model
    offset: float
    provenance: dict[str, Any]


@guarded(operator=model("hysteresis"), offset=amount(OFFSET))
def write_operator(
    path: str | os.PathLike[str],
    operator: Model,
    offset: float = 0.0,
    *,
    provenance: Mapping[str, str] | None = None,
) -> None:
    """Write a model file of an operator; numbers are read back exactly."""
    tables = {
        "provenance": provenance or {},
        "operator": described(operator),
        "output": {"offset": Said(float(offset), _said_of(OFFSET, operator))},
    }
    write_whole(path, as_toml({"schema": 1, "kind": operator.kind} | tables))


def described(model: Model) -> dict[str, Any]:
    """Return the table of a model: its name, and its values with unit and meaning."""
    variables = model.component.variables
    return {"model": model.name} | {
        key_of(name): Said(value, _said_of(variables[name], model))
        for name, value in model.values.items()
    }


def _said_of(variable: Variable, model: Model) -> str:
    return f"{variable.unit(model.kind)}: {' '.join(variable.description.split())}"


def holds_operator(path: Readable) -> bool:
    """Return whether a model file contains a hysteresis operator."""
    return "operator" in read_toml(path).data


def read_operator(path: Readable) -> OperatorFile:
    """Return the operator in a model file."""
    data, source, _ = read_toml(path, path="model", what="a model file")
    with located(source):
        check_keys(data, ("schema", "kind", "provenance", "operator", "output"), "")
        check_schema(data)
        kind = kind_at(data.get("kind", KINDS[0]), "kind", (*KINDS, "magnetic", "piezo"))
        operator = model_from(data.get("operator", {}), OPERATORS, kind=kind, path="operator")
        output = table_at(data.get("output", {}), "output")
        check_keys(output, ("offset",), "output")
        offset = number_at(output.get("offset", 0.0), OFFSET, kind, "output.offset")
        return OperatorFile(operator, offset, table_at(data.get("provenance", {}), "provenance"))


OperatorRead = Callable[[Any, str], OperatorFile]
"""Function that reads an operator, from the name of its file and the key that names the file."""


def operator_beside(folder: Path) -> OperatorRead:
    """Return a function that reads operators from files in the same folder."""

    def read(file: Any, path: str) -> OperatorFile:
        if not isinstance(file, str) or not file:
            raise InputError("must be the name of a file", path=path, value=file)
        with located(path):
            return read_operator(content_of(folder / file, limit=TOML_LIMIT))

    return read


def with_operator(
    entries: dict[str, Any], kind: Kind, path: str, read: OperatorRead
) -> dict[str, Any]:
    """Return the keys of a friction model, with the file of its kernel replaced by the operator."""
    kernel, at = entries.get("kernel"), f"{path}.kernel"
    if isinstance(kernel, dict) and "file" not in kernel:
        return entries | {"kernel": model_from(kernel, OPERATORS, kind=kind, path=at)}
    if isinstance(kernel, dict):
        check_keys(kernel, ("file",), at)
        described = read(kernel["file"], f"{at}.file")
    elif isinstance(kernel, str) and kernel.endswith(".toml"):
        described = read(kernel, at)
    else:
        return entries
    return (
        ({"offset": described.offset} if described.offset else {})
        | entries
        | {"kernel": described.operator}
    )


def contact_over(described: OperatorFile) -> dict[str, Any]:
    """Return the table of a friction model that is an operator on the position."""
    contact = {"model": MODELS["preisach_contact"].name, "kernel": described.operator}
    return contact | ({"offset": described.offset} if described.offset else {})
