"""Hysteresis operators in files: ``[operator]`` with its values, and one in place of the kernel of a friction model."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bristle.core.content import Readable, content_of
from bristle.core.contracts import Model
from bristle.core.errors import InputError, located
from bristle.core.variable import KINDS, Kind, Variable
from bristle.files.components import check_keys, check_schema, key_of, kind_at, model_from, number_at, table_at
from bristle.files.single import write_whole
from bristle.files.toml import TOML_LIMIT, read_toml
from bristle.friction import MODELS
from bristle.hysteresis import OPERATORS

OFFSET = Variable("force", "constant output beside the operator")


class OperatorFile(NamedTuple):
    """What a model file of an operator holds; `provenance` says where the values come from."""

    operator: Model
    offset: float
    provenance: dict[str, Any]


def write_operator(
    path: str | os.PathLike[str], operator: Model, offset: float = 0.0, *, provenance: Mapping[str, str] | None = None
) -> None:
    """Write a model file of an operator; numbers come back to the bit."""
    import tomlkit

    def written(value: Any) -> str:  # a library would take seconds for a table of fifty thousand numbers
        if isinstance(value, str):
            return tomlkit.item(value).as_string()
        value = value.tolist() if hasattr(value, "tolist") else value
        return f"[{', '.join(map(repr, value))}]" if isinstance(value, list) else repr(value)

    lines = ["schema = 1", f"kind = {written(operator.kind)}", ""]
    if provenance:
        lines += ["[provenance]", *(f"{key_of(name)} = {written(text)}" for name, text in provenance.items()), ""]
    lines += ["[operator]", f"model = {written(operator.name)}"]
    for name, value in operator.values.items():
        variable = operator.component.variables[name]
        lines += [f"# {variable.unit(operator.kind)}: {variable.description}", f"{key_of(name)} = {written(value)}"]
    unit = OFFSET.unit(operator.kind)
    lines += ["", "[output]", f"# {unit}: {OFFSET.description}", f"offset = {written(float(offset))}", ""]
    write_whole(path, "\n".join(lines))


def holds_operator(path: Readable) -> bool:
    """Return whether a model file is one of a hysteresis operator."""
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
"""What reads the operator in a file, by its name as it is written and the key that it stands under."""


def operator_beside(folder: Path) -> OperatorRead:
    """Return what reads operators from files beside the one that names them."""

    def read(file: Any, path: str) -> OperatorFile:
        if not isinstance(file, str) or not file:
            raise InputError("must be the name of a file", path=path, value=file)
        with located(path):
            return read_operator(content_of(folder / file, limit=TOML_LIMIT))

    return read


def with_operator(entries: dict[str, Any], kind: Kind, path: str, read: OperatorRead) -> dict[str, Any]:
    """Return the keys of a friction model, an operator that they name for the kernel being there itself."""
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
    offset = {"offset": described.offset} if described.offset else {}
    return offset | entries | {"kernel": described.operator}


def contact_over(described: OperatorFile) -> dict[str, Any]:
    """Return the table of a contact that is an operator on the position: what a file of one is as friction."""
    contact = {"model": MODELS["preisach_contact"].name, "kernel": described.operator}
    return contact | ({"offset": described.offset} if described.offset else {})
