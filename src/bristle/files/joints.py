"""Axis files with a table for each joint or axis of a common trace."""

import re
from collections.abc import Mapping
from typing import Any

from bristle.core import Axis, Content, InputError
from bristle.files.axis import read_axis
from bristle.files.components import table_at
from bristle.files.toml import as_toml, read_toml

# Table of a joint, and the texts that stand for its number from 1 and from 0
JOINT, NUMBER, INDEX = ("joint", "{joint}", "{joint0}")


def joints_in(content: Content) -> dict[str, dict[str, Any]]:
    """Return the axis files of the joints that a file describes, by name; empty for a file of one axis."""
    common = dict(read_toml(content, path="axis", what="an axis file").data)
    joints, described = common.pop(JOINT, []), dict[str, dict[str, Any]]()
    base: int | None = None
    if not isinstance(joints, list):
        raise InputError(
            "must be a list of tables", path=JOINT, value=joints, mend=f"Write [[{JOINT}]]"
        )
    for number, entry in enumerate(joints, start=1):
        own = dict(table_at(entry, f"{JOINT}[{number - 1}]"))
        name = own.setdefault("name", f"joint_{number}")
        if (
            not isinstance(name, str)
            or name in described
            or not name.replace("-", "_").isidentifier()
        ):
            raise InputError(
                "must be a word that no other joint has",
                path=f"{JOINT}[{number - 1}].name",
                value=name,
                mend="Write a word of letters, digits and _",
            )
        merged = _merged(common, own)
        base = _base_of_names(merged, name, number, base)
        described[name] = _numbered(merged, number)
        # The file of a joint may be written to another folder.
        for known in described[name].get("known", []):
            if isinstance(known, dict) and isinstance(known.get("file"), str):
                known["file"] = str(content.source.absolute().parent / known["file"])
    return described


def axes_in(content: Content) -> dict[str, Axis]:
    """Return the axes of the joints that a file describes, by name; empty for a file of one axis."""
    return {
        name: read_axis(Content(content.source, as_toml(table).encode()))
        for name, table in joints_in(content).items()
    }


def _merged(common: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Return the common tables, with the entries of one joint in place of those of the same key."""
    merged = dict(common)
    for key, entry in own.items():
        before = merged.get(key)
        merged[key] = (
            _merged(before, entry)
            if isinstance(before, dict) and isinstance(entry, dict)
            else entry
        )
    return merged


def _base_of_names(
    table: Mapping[str, Any], name: str, number: int, base: int | None
) -> int | None:
    """Return the number from which the names of joints count; refuse a table that could take the columns of another joint."""
    text, path = as_toml(table), f"{JOINT}[{number - 1}].name"
    if f"[{NUMBER}]" in text:
        raise InputError(
            f"uses [{NUMBER}], which counts from 1",
            path=path,
            value=name,
            mend=f"The columns of arrays in MAT, HDF5 and NPZ files count from 0: write [{INDEX}]. "
            "If yours count from 1, write [{joint1}]",
        )
    in_name = re.search(r"(\d+)$", name)
    if in_name is None or not any(place in text for place in (NUMBER, INDEX, "{joint1}")):
        return base
    own = int(in_name[1]) - number + 1
    if own not in ((0, 1) if base is None else (base,)):
        message = f"is the table of joint {number}, because {NUMBER} counts the tables"
        raise InputError(
            message,
            path=path,
            value=name,
            mend=f"List all joints in order, or write the columns of this joint into its table without {NUMBER}",
        )
    return own


def _numbered(entry: Any, number: int) -> Any:
    """Return an entry with the number of the joint in all its texts."""
    if isinstance(entry, dict):
        return {key: _numbered(value, number) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_numbered(value, number) for value in entry]
    if not isinstance(entry, str):
        return entry
    return (
        entry.replace(NUMBER, str(number))
        .replace(INDEX, str(number - 1))
        .replace("{joint1}", str(number))
    )
