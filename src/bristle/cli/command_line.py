"""The command line as results tell it."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable

__all__ = ["command_told"]

SEPARATORS = f"{os.sep}{os.altsep or ''}"


def command_told(arguments: Iterable[str], separators: str = SEPARATORS) -> str:
    """Return a command line as it is told: files without their folders, nothing that cannot be printed.

    Examples
    --------
    >>> command_told(["identify", "/home/anna/axis 1.csv", "--axis=../x/axis.toml", "--cutoff", "100 Hz"])
    "bristle identify 'axis 1.csv' --axis=axis.toml --cutoff '100 Hz'"
    """
    return shlex.join(["bristle", *(_plain(_without_folders(argument, separators)) for argument in arguments)])


def _plain(text: str) -> str:
    # The names of files are bytes, and whoever passes one on may be of another opinion on its letters.
    if text.isprintable():
        return text
    from bristle.core.typography import escaped

    return "".join(letter if letter.isprintable() else "?" for letter in escaped(text))


def _without_folders(argument: str, separators: str) -> str:
    option, equals, value = argument.partition("=")
    if equals and option.startswith("--"):
        return f"{option}={_without_folders(value, separators)}"
    return ",".join(re.split(f"[{re.escape(separators)}]", part.rstrip(separators))[-1] for part in argument.split(","))
