"""Axis files with a table for each joint or axis of a common trace."""

from collections.abc import Mapping
from typing import Any

from bristle.core.axis import Axis
from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.files.axis import read_axis
from bristle.files.components import table_at
from bristle.files.toml import as_toml, read_toml

JOINT, NUMBER = "joint", "{joint}"  # table of a joint, and the text that stands for its number, from 1


def joints_in(content: Content) -> dict[str, dict[str, Any]]:
    """Return the axis files of the joints that a file describes, by name; empty for a file of one axis."""
    common = dict(read_toml(content, path="axis", what="an axis file").data)
    joints, described = common.pop(JOINT, []), dict[str, dict[str, Any]]()
    if not isinstance(joints, list):
        raise InputError("must be a list of tables", path=JOINT, value=joints, mend=f"Write [[{JOINT}]]")
    for number, entry in enumerate(joints, start=1):
        own = dict(table_at(entry, f"{JOINT}[{number - 1}]"))
        name = own.setdefault("name", f"joint_{number}")
        if not isinstance(name, str) or name in described or not name.replace("-", "_").isidentifier():
            message = "must be a word that no other joint has"
            raise InputError(message, path=f"{JOINT}[{number - 1}].name", value=name, mend="Write a word of letters, digits and _")
        described[name] = _numbered(_merged(common, own), str(number))
        for known in described[name].get("known", []):  # the file of a joint may be written to another folder
            if isinstance(known, dict) and isinstance(known.get("file"), str):
                known["file"] = str(content.source.absolute().parent / known["file"])
    return described


def axes_in(content: Content) -> dict[str, Axis]:
    """Return the axes of the joints that a file describes, by name; empty for a file of one axis."""
    return {name: read_axis(Content(content.source, as_toml(table).encode())) for name, table in joints_in(content).items()}


def _merged(common: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the common tables, with the entries of one joint in place of those of the same key."""
    merged = dict(common)
    for key, entry in own.items():
        before = merged.get(key)
        merged[key] = _merged(before, entry) if isinstance(before, dict) and isinstance(entry, dict) else entry
    return merged


def _numbered(entry: Any, number: str) -> Any:
    """Return an entry with the number of the joint in all its texts."""
    if isinstance(entry, dict):
        return {key: _numbered(value, number) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_numbered(value, number) for value in entry]
    return entry.replace(NUMBER, number) if isinstance(entry, str) else entry
