"""Read TOML with located errors and strict limits, and write tables as TOML."""

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from bristle.core.content import Content, FixedLimit, Readable, content_of
from bristle.core.errors import InputError, located
from bristle.core.units import LARGEST
from bristle.core.values import shown

TOML_LIMIT = FixedLimit(4 * 2**20)
"""Largest file of settings [byte]; the tables of an operator with a hundred thousand numbers take two million."""

DEEPEST = 32  # tables in one another, and parts of a key
_CONTROLS = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
# Dots between the parts of a key, not dots in a text.
_JOINTS = re.compile(r"[\w\-\"'][ \t]*\.(?=[ \t]*[\w\-\"'])")


class Settings(NamedTuple):
    """Content and source of a file of settings; a dict has no source."""

    data: dict[str, Any]
    source: Path
    content: Content | None = None


def read_toml(
    source: Readable | dict[str, Any], *, path: str = "file", what: str = "a file"
) -> Settings:
    """Return the content of a TOML file."""
    if isinstance(source, dict):
        _refuse_absurdities(source)
        return Settings(source, Path("<dict>"))
    content = content_of(source, limit=TOML_LIMIT, path=path, what=what)
    with located(content.source):
        data = _parsed(content)
        _refuse_absurdities(data)
    return Settings(data, content.source, content)


def _parsed(content: Content) -> dict[str, Any]:
    try:
        text = content.data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise InputError(
            f"is not a text file in UTF-8 (byte {error.start})",
            mend="Check that this is the right file",
        ) from None
    before = ""
    # Keys with very many parts: the time of the parser grows with the square of their number.
    for match in re.finditer(r"[\w\-.\"' \t]+|[^\w\-.\"' \t]+", text):
        if (
            match[0][0] in "=]"
            and before.count(".") > DEEPEST
            and len(_JOINTS.findall(before)) > DEEPEST
        ):
            raise _too_deep(before.strip())
        before = match[0]
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        # Keys in the notation of the parser.
        message = re.sub(
            r"\(('(?:[^']|', ')*'),?\)", lambda match: match[1].replace("', '", "."), str(error)
        )
        raise InputError(
            f"the file is not valid TOML: {message}", mend=_mend(content, text, str(error))
        ) from None
    except RecursionError:
        raise _too_deep("") from None
    except Exception as error:  # noqa: BLE001  (unforeseen by the parser, such as a number of 5 000 digits)
        message = "a number with thousands of digits" if "digits" in str(error) else str(error)
        raise InputError(
            f"the file contains text that is not valid TOML ({message})",
            mend="Check that this is the right file",
        ) from None


def _mend(content: Content, text: str, message: str) -> str:
    """Return the remedy for the line that the parser names, for the two most frequent mistakes."""
    # Quote only from files of settings: another file may have named a confidential file.
    is_settings = content.source.suffix.lower() == ".toml" or content.source.name.startswith("<")
    number, lines = (
        message.partition("at line ")[2].partition(",")[0],
        text.splitlines() if is_settings else [],
    )
    line = (
        lines[int(number) - 1].strip()[:200]
        if number.isdigit() and int(number) <= len(lines)
        else ""
    )
    value = line.partition("=")[2].strip()
    if value and value[0].isdigit() and not value.endswith(('"', "'")):
        return f'Write a value with a unit in quotation marks: "{value}"'
    if line:
        return f"The line reads: {line}"
    return "Is a bracket or a quotation mark missing?"


def _refuse_absurdities(data: dict[str, Any]) -> None:
    """Refuse content that is absurd for a file of settings."""
    waiting: list[tuple[str, Any, int]] = [("", data, 0)]
    while waiting:
        path, value, depth = waiting.pop()
        if depth > DEEPEST:
            raise _too_deep(path)
        if isinstance(value, dict):
            for key, item in value.items():
                if not isinstance(key, str) or _CONTROLS.search(key):
                    raise InputError(
                        "a key contains control characters",
                        path=path,
                        value=key,
                        mend="Remove these characters",
                    )
                waiting.append((f"{path}.{key}" if path else key, item, depth + 1))
        elif not isinstance(value, list):
            _refuse_value(path, value)
        # Fast path for long tables of numbers.
        elif not all(type(number) is float and abs(number) <= LARGEST for number in value):
            waiting += [(f"{path}[{index}]", item, depth + 1) for index, item in enumerate(value)]


def _refuse_value(path: str, value: Any) -> None:
    if isinstance(value, str):
        if _CONTROLS.search(value):
            raise InputError(
                "holds control characters", path=path, value=value, mend="Remove these characters"
            )
    elif isinstance(value, int) and abs(value) > 2**63 - 1:  # the range that TOML guarantees
        raise InputError(
            "is too large for an integer",
            path=path,
            allowed="whole numbers up to 9223372036854775807",
        )
    elif isinstance(value, float) and math.isnan(value):
        raise InputError("must be a finite number", path=path, value=value)
    elif isinstance(value, float) and LARGEST < abs(value) < math.inf:
        raise InputError("is too large", path=path, value=value, allowed=f"up to {LARGEST:g}")


def _too_deep(path: str) -> InputError:
    return InputError(
        "is nested too deeply",
        path=path[:80],
        allowed=f"up to {DEEPEST} levels of tables",
        mend="Check that this is the right file",
    )


class Said(NamedTuple):
    """A value with a comment."""

    value: Any
    remark: str


def as_toml(tables: Mapping[str, Any]) -> str:
    """Write tables as TOML; a library would need seconds for fifty thousand numbers.

    Examples
    --------
    >>> print(as_toml({"schema": 1, "plant": {"M": Said(20.0, "kg: mass")}}), end="")
    schema = 1
    <BLANKLINE>
    [plant]
    M = 20.0 # kg: mass
    """
    return "\n".join(_lines_of(tables, "")).lstrip("\n") + "\n"


def _lines_of(table: Mapping[str, Any], head: str) -> Iterator[str]:
    """Yield the entries of a table, then its subtables, each after an empty line."""
    inner = {
        name: [entry] if isinstance(entry, Mapping) else entry
        for name, entry in table.items()
        if _is_table(entry)
    }
    if head and len(inner) < len(table):
        yield from ("", head)
    for name, entry in table.items():
        if name not in inner:
            value, remark = entry if isinstance(entry, Said) else (entry, "")
            with located(f"{head.strip('[]')}.{name}".lstrip(".")):
                line = f"{_key(name)} = {quoted(value)}"
            # After a long list it would be out of sight.
            yield from (
                [f"# {remark}", line]
                if remark and len(line) > 400
                else [f"{line} # {remark}" if remark else line]
            )
    for name, entries in inner.items():
        path = f"{head.strip('[]')}.{_key(name)}".lstrip(".")
        for entry in entries:
            yield from _lines_of(entry, f"[{path}]" if entry is table[name] else f"[[{path}]]")


def _is_table(entry: Any) -> bool:
    return isinstance(entry, Mapping) or (
        isinstance(entry, list) and bool(entry) and isinstance(entry[0], Mapping)
    )


def _key(name: str) -> str:
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else quoted(name)


def quoted(value: Any) -> str:
    """Write a value in TOML."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(quoted, value))}]"
    if isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if not isinstance(value, (int, float)):
        raise InputError(
            "cannot be written",
            value=shown(value),
            allowed="text, a number, True or False, or a list of these",
        )
    return repr(value)
