"""What a file of a user's own defines under a name: a model, a reader of logs, a target of the export, a figure."""

from __future__ import annotations

from typing import TypeVar

from bristle.core.content import Readable
from bristle.core.errors import InputError
from bristle.files.permission import code_at
from bristle.files.user_model import SourceText

__all__ = ["declared_in"]

Declared = TypeVar("Declared")


def declared_in(path: Readable, name: str, family: type[Declared], *, title: str, mend: str) -> Declared:
    """Return what a Python file defines under a name."""
    content = code_at(path)
    declared = getattr(SourceText(content).module(), name, None)
    if not isinstance(declared, family):
        raise InputError(
            f"defines no {title}", path=str(content.source), mend=mend, value=None if declared is None else type(declared).__name__
        )
    return declared
