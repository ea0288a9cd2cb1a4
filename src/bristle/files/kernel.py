"""The kernel of a friction model in a file: one of its own by name, or a hysteresis operator, in a file or a table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bristle.core.content import content_of
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.files.components import check_keys, model_from
from bristle.files.operator import OperatorFile, read_operator
from bristle.files.toml import TOML_LIMIT
from bristle.friction import MODELS
from bristle.hysteresis import OPERATORS

__all__ = ["OperatorRead", "contact_over", "operator_beside", "with_operator"]

OperatorRead = Callable[[Any, str], OperatorFile]
"""What reads the operator in a file, by its name as it is written and the key that it stands under."""


def operator_beside(folder: Path) -> OperatorRead:
    """Return what reads operators from files beside the one that names them."""

    def read(file: Any, path: str) -> OperatorFile:
        if not isinstance(file, str) or not file:
            raise InputError("must be the name of a file", path=path, value=file)
        try:
            return read_operator(content_of(folder / file, limit=TOML_LIMIT))
        except InputError as error:
            raise error.at(path) from None

    return read


def with_operator(entries: dict[str, Any], kind: Kind, path: str, read: OperatorRead) -> dict[str, Any]:
    """Return the keys of a friction model, an operator that they name for the kernel being there itself.

    The constant output beside an operator in a file is the offset of the friction, unless that is given.
    """
    kernel = entries.get("kernel")
    if isinstance(kernel, dict) and "file" not in kernel:
        return entries | {"kernel": model_from(kernel, OPERATORS, kind=kind, path=f"{path}.kernel")}
    if isinstance(kernel, dict):
        check_keys(kernel, ("file",), f"{path}.kernel")
        file, at = kernel["file"], f"{path}.kernel.file"
    elif isinstance(kernel, str) and kernel.endswith(".toml"):
        file, at = kernel, f"{path}.kernel"
    else:
        return entries
    described = read(file, at)
    offset = {"offset": described.offset} if described.offset else {}
    return offset | entries | {"kernel": described.operator}


def contact_over(described: OperatorFile) -> dict[str, Any]:
    """Return the table of a contact that is an operator on the position: what a file of one is as friction."""
    contact = {"model": MODELS["preisach_contact"].name, "kernel": described.operator}
    return contact | ({"offset": described.offset} if described.offset else {})
