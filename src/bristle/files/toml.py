"""Reading TOML, with errors that say where."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from bristle.core.errors import InputError

__all__ = ["read_toml"]


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises
    ------
    InputError
        If there is no such file, or it is no TOML; the message has the line.
    """
    source = Path(path)
    try:
        text = source.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError("there is no such file", path=str(source), mend="Check the path") from None
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not a text file in UTF-8 (byte {error.start})", path=str(source), mend="Is it the right file?"
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path=str(source)) from None
    try:
        return tomllib.loads(text.replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not valid TOML: {error}", path=str(source), mend=_mend(text, str(error))) from None
    except RecursionError:
        raise InputError("is nested too deeply", path=str(source), mend="Is it the right file?") from None


def _mend(text: str, message: str) -> str:
    """Return what to do about the line that the parser names, for the two mistakes that people make most."""
    number = message.partition("at line ")[2].partition(",")[0]
    lines = text.splitlines()
    line = lines[int(number) - 1].strip() if number.isdigit() and int(number) <= len(lines) else ""
    value = line.partition("=")[2].strip()
    if value and value[0].isdigit() and not value.endswith(('"', "'")):
        return f'A value with a unit stands in quotation marks: "{value}"'
    return f"The line reads: {line}" if line else "Is a bracket or a quotation mark missing at its end?"
