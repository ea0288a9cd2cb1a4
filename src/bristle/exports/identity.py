"""What tells an exported model from others, and whose its files are: a hash of the model, and a line on the licence.

The hash is over what the kernels do and the numbers they receive, not over how a target prints them: every export of
one model has the same, whatever its target, its name and its options, and comments of a kernel change nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from functools import cache
from importlib import resources
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.contracts import Model
from bristle.exports.described import Source
from bristle.exports.rendering import version
from bristle.exports.scope import NotExportableError
from bristle.exports.subject import subject_of
from bristle.exports.tree import Function, Node, Unit
from bristle.exports.types import Array, Scalar, Struct

if TYPE_CHECKING:
    from bristle.exports.law import Law

__all__ = [
    "LICENCE",
    "copyright_line",
    "hash_of_law",
    "hash_of_model",
    "hash_on_plant",
    "licence_text",
    "model_version",
    "rights_lines",
    "with_rights",
]

LICENCE = "BSD-3-Clause"
"""Of the text that bristle writes, as SPDX names it."""
COMMENTS = {
    ".c": ("/* ", " */"),
    ".h": ("/* ", " */"),
    ".cu": ("/* ", " */"),
    ".st": ("(* ", " *)"),
    ".mjs": ("// ", ""),
    ".xml": ("<!-- ", " -->"),
    ".txt": ("# ", ""),
    ".md": ("<!-- ", " -->"),
}
DIGITS = 12  # of a hash, where it tells versions apart


def hash_of_model(model: Model) -> str:
    """Return the SHA-256 of a friction model or an operator; empty where its kernels are not known as a tree."""
    try:
        subject = subject_of(model)
    except NotExportableError:
        return ""
    start = [subject.virgin, float(subject.memory_size)]
    return _digest(model.name, model.kind, subject.unit.functions, start, model.parameters)


def hash_on_plant(friction: str, plant: Model, unit: Unit) -> str:
    """Return the SHA-256 of a plant with its friction, from the hash of that and the functions of both."""
    return _digest(friction, plant.name, plant.kind, unit.functions, plant.parameters)


def hash_of_law(law: Law) -> str:
    """Return the SHA-256 of a control law whose parameters are fixed, in double precision."""
    start = [law.lasting, law.memory, law.dt, float(law.samples_ahead)]
    return _digest(law.controller.name, law.controller.kind, law.unit.functions, start, law.p)


def model_version(source: Source) -> str:
    """Return the version of an exported model: that of bristle, and what its hash begins with."""
    return f"{version()}+{source.model_hash[:DIGITS]}" if source.model_hash else version()


@cache
def licence_text() -> str:
    """Return the licence of the text that bristle writes."""
    return (resources.files("bristle.exports") / "templates" / "shared" / "LICENSE.txt").read_text(encoding="ascii")


def copyright_line() -> str:
    """Return whose the text is that bristle writes."""
    return next(line for line in licence_text().splitlines() if line.startswith("Copyright"))


def rights_lines(source: Source, ending: str) -> list[str]:
    """Return the licence of the text of a file and the hash of its model as comments of the language it ends in."""
    opening, closing = COMMENTS[ending]
    lines = [
        f"SPDX-License-Identifier: {LICENCE}",
        f"{copyright_line()}: the text that bristle {version()} wrote.",
        "The model and its numbers are yours.",
    ]
    lines += [f"Hash of the model: sha256 {source.model_hash}"] if source.model_hash else []
    return [f"{opening}{line}{closing}" for line in lines]


def with_rights(files: Mapping[str, str], source: Source) -> dict[str, str]:
    """Return texts, by the names of their files, that begin with their licence and the hash of their model."""
    return {name: _headed(text, rights_lines(source, PurePosixPath(name).suffix)) for name, text in files.items()}


def _headed(text: str, lines: list[str]) -> str:
    first, _, rest = text.partition("\n")
    return "\n".join([first, *lines, rest] if first.startswith("<?xml") else [*lines, text])


def _digest(*parts: Any) -> str:
    digest = hashlib.sha256()
    for word in _words(parts):
        digest.update(word.encode() + b"\0")
    return digest.hexdigest()


def _words(part: Any) -> Iterator[str]:
    """Give what a part of a model is made of, so that two differ where their models do."""
    if isinstance(part, Function):
        yield from _words([part.name, part.parameters, part.result, part.body])
    elif isinstance(part, Node):
        yield type(part).__name__
        for field in fields(part):
            value = getattr(part, field.name)
            yield from _words(value.name if isinstance(value, Function) else value)
    elif isinstance(part, Struct):
        yield from _words([part.cls.__name__, part.fields])
    elif isinstance(part, (Array, Scalar)):
        yield repr(part)
    elif isinstance(part, np.ndarray):
        yield from _words(part.tolist())
    elif isinstance(part, Iterable) and not isinstance(part, str):
        yield "("
        for inner in part:
            yield from _words(inner)
        yield ")"
    else:
        yield part.hex() if isinstance(part, float) else repr(part)
