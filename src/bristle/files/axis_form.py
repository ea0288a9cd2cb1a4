"""An axis file as a form: the fields that a page shows, and edits that keep the rest of the file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bristle.core import Content, InputError
from bristle.core.axis import COLUMNS
from bristle.core.dimensions import KINDS, unit_of
from bristle.core.motion import RECORDED
from bristle.files.components import open_in
from bristle.files.schema import by_number, long_form
from bristle.files.toml import read_toml

# The channels that a form for an axis file offers for a column.
CHANNELS = tuple(name for name in COLUMNS if name not in RECORDED)
EMPTY = 'schema = 1\nname = "axis"\n'  # the smallest axis file
# Default channels of a log of the motion.
OF_MOTION = {"time": "time", "position": "length", "reference": "length", "effort": "force"}


def edited(text: str, edits: Mapping[str, Any], label: str = "axis.toml") -> str:
    """Return an axis file with some keys changed; everything else is unchanged, comments included."""
    import tomlkit

    read_toml(Content(Path(label), text.encode()))  # applies the limits for every user file
    document = tomlkit.parse(text)
    for key, value in edits.items():
        _set(document, key, value)
    return tomlkit.dumps(document)


def _set(document: Any, key: str, value: Any) -> None:
    import tomlkit

    *parents, last = key.split(".")
    if len(parents) >= 3 or not all((*parents, last)):
        raise InputError("is not a key of an axis file", path=key)
    if not (value is None or isinstance(value, (str, int, float))):
        raise InputError("must be text or a number", path=key, value=value)
    table: Any = document
    path: list[str] = []
    for name in parents:
        path.append(name)
        if name not in table:
            if value is None:
                return
            table[name] = tomlkit.inline_table() if len(path) > 1 else tomlkit.table()
        elif path[:-1] == ["columns"] and (entry := long_form(table[name])) is not table[name]:
            table[name] = tomlkit.inline_table()
            table[name].update(entry)
        table = table[name]
        if not hasattr(table, "keys"):
            raise InputError("is not a table", path=".".join(path))
        if len(path) > 1 and hasattr(table, "trivia"):
            table.trivia.comment, table.trivia.comment_ws = "", ""  # it described the old value
    if value is None:
        table.pop(last, None)
    else:
        table[last] = value
    if not table and len(parents) > 1:
        document[parents[0]].pop(parents[1], None)


def form_of(axis_file: Content) -> dict[str, Any]:
    """Return the content of a form for an axis file: its tables, missing keys and comments."""
    import tomlkit

    tables, text = read_toml(axis_file).data, axis_file.data.decode("utf-8-sig")
    entries, columns = tables.get("columns"), {}
    for name, value in entries.items() if isinstance(entries, Mapping) else ():
        entry = long_form(value)  # the reader of the file refuses an invalid column
        if isinstance(entry, Mapping) and isinstance(
            column := by_number(entry.get("column", "")), str
        ):
            columns[name] = {**entry, "column": column}
    remarks = {}
    for name, table in tomlkit.parse(text).items():
        for key, item in table.items() if isinstance(table, Mapping) else ():
            if comment := getattr(getattr(item, "trivia", None), "comment", ""):
                remarks[f"{name}.{key}"] = comment.lstrip("# ")
    plain = {
        key: value for key, value in tables.items() if isinstance(value, (str, int, float, Mapping))
    }
    return {
        "tables": plain | {"columns": columns},
        "missing": list(open_in(tables)),
        "remarks": remarks,
    }


def with_columns_of_motion(text: str) -> str:
    """Return an axis file that names the columns of the motion; missing columns get common names and SI units."""
    tables = read_toml(text.encode()).data
    if "columns" in tables:
        return text
    # The reader of the file refuses an invalid kind.
    kind = tables["kind"] if tables.get("kind") in KINDS else KINDS[0]
    entries = {f"columns.{name}.column": name for name in OF_MOTION}
    return edited(
        text,
        entries | {f"columns.{name}.unit": unit_of(of, kind) for name, of in OF_MOTION.items()},
    )
