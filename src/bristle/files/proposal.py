"""`propose_axis`: the axis file that a log itself speaks of, with what it cannot know marked to be filled in."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bristle.core import units
from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Readable, size_of
from bristle.core.errors import InputError
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.files.axis import axis_from
from bristle.files.fill_in import FILL_IN
from bristle.files.kind import OF_UNIT
from bristle.logs import checked
from bristle.logs.assembly import record_of
from bristle.logs.channel import clear_step
from bristle.logs.likeness import pulls_as_a_link
from bristle.logs.readers import read_table
from bristle.logs.roles import Role, Roles, roles_of
from bristle.logs.stamped_text import amount_in
from bristle.logs.table import Table, some_of
from bristle.logs.tables import content_of_log

__all__ = ["Proposal", "propose_axis"]

ASSUMED_UNIT = {"position": {KINDS[0]: "m", KINDS[1]: "rad"}, "effort": {KINDS[0]: "N", KINDS[1]: "N*m"}}
ORDER = ("time", "position", "reference", "following_error", "velocity", "effort")
_SCREW = 'with lead = "10 mm", travel for one turn of the motor, under [transmission] where a screw turns'
HINTS = {
    "columns.position.unit": "unit of the numbers: mm, um, m, deg, rad or rev",
    "columns.effort.unit": "unit of the numbers: N, N*m, or A, %, ‰ or V with its constant under [effort]",
    "rated": '"%" or "‰" of rated, with rated = "2.4 N*m" under [effort]; or N, N*m, A or V',
    "effort.rated": f'what 100 % are, such as "120 N" (or "2.4 N*m", {_SCREW})',
    "effort.constant": 'force or torque for one {drive}, such as "61.2 N/{drive}" (or "0.12 N*m/{drive}", '
    + f"{_SCREW})",
    "transmission.lead": 'travel of the load for one turn of the motor, such as "10 mm"; or of the screw, with '
    "gear_ratio = 2 in the next line for a gear of 2:1 between both",
    "encoder.resolution": 'movement for one count, such as "0.1 um" or "0.01 deg"; '
    'or write counts_per_rev = 8192 and side = "motor" for it',
    "timing.sample_time": 'time between samples, such as "1 ms"',
}
# Of an axis that turns, a torque is what a data sheet gives.
HINTS_OF_TURNING = {
    "effort.rated": 'what 100 % are, such as "1.3 N*m"',
    "effort.constant": 'torque for one {drive}, such as "0.12 N*m/{drive}"',
}
OF_EFFORT = {"columns.effort.unit", "effort.rated", "effort.constant"}  # that leave its shape as it is
TOLD_BY = {
    "name": "unit from its name", "its name": "unit assumed from its name", "velocity": "unit from the velocity",
    "numbers": "unit from its numbers", "drive": 'whole numbers, as drives store ‰ of rated: see that it is not "%"',
    "position": "unit from the position", "reference": "unit from the reference",
}  # fmt: skip
# What stands above the columns of some exports -> where it belongs in an axis file.
FACTS = {
    "effort.rated": r"(rated|nominal|nenn|bemessungs)[\s_-]*(torque|moment|drehmoment|force|kraft)"
    r"|(torque|moment).*(rated|nenn)",
    "effort.constant": r"(torque|force|motor)[\s_-]*constant|(drehmoment|kraft|motor)konstante|\bk_?t\b",
    "transmission.lead": r"\b(lead|pitch)\b|spindelsteigung|steigung|vorschubkonstante|feed constant",
    "encoder.counts_per_rev": r"(counts|increments|inkremente|inc|pulses)[\s_-]*(per|pro|/)[\s_-]*"
    r"(rev|turn|umdrehung|u)\w*",
}


@dataclass(frozen=True)
class Proposal:
    """An axis file that a log speaks of.

    Parameters
    ----------
    text : str
        The file, TOML. What the log cannot know is ``"?"`` there, with a comment that says what to write.
    missing : tuple of str
        Keys that are to be filled in.
    axis : Axis
        The axis, with SI for each unit and 1 for each constant that is missing.
    table : Table
        The columns that it was made of.
    notes : tuple of str
        What was assumed, and which columns could have been taken instead.
    """

    text: str
    missing: tuple[str, ...]
    axis: Axis
    table: Table = field(repr=False, compare=False)
    notes: tuple[str, ...] = ()


def propose_axis(log: Readable, *, size_limit: int | str = SIZE_LIMIT) -> Proposal:
    """Return the axis file that a log speaks of: by names, units, and by what moves like what.

    Parameters
    ----------
    log : path-like, bytes or file object
        A log in any format that `read_log` reads.
    size_limit : int or str
        Largest file, and largest content that it announces [byte], or text such as ``"2 GB"``.

    Returns
    -------
    Proposal
        Its text, which keys are to be filled in, and the axis as far as it is known.

    Raises
    ------
    InputError
        If the log cannot be read, or no column can be the position.
    """
    limit = size_of(size_limit)
    content = content_of_log(log, limit=limit)
    table = read_table(content, size_limit=limit)
    if not table.tables:
        return _proposed_for(table)
    name = table.tables[0]
    return _proposed_for(read_table(content, name, size_limit=limit), name, len(table.tables))


def _proposed_for(table: Table, name: str | None = None, count: int = 1) -> Proposal:
    """Return the axis file that the columns of a table speak of; it is one of several where it has a name."""
    roles = roles_of(table)
    if "position" not in roles.channels:
        raise InputError(
            "does not say which column is the position", path=str(table.source), allowed=some_of(table.names, 40),
            mend="Write an axis file that names the columns, and give it (--axis AXIS.toml)",
        )  # fmt: skip
    tables: dict[str, Any] = _tables(table, roles)
    if name is not None:
        tables["log"] = {"table": name}
    axis = axis_from(_assumed(tables))
    if _reversed(table, axis):
        tables["columns"]["effort"]["sign"] = -1
        axis = axis_from(_assumed(tables))
    missing = tuple(_missing(tables))
    if set(missing) <= OF_EFFORT and _has_a_link(table, axis):
        tables["plant"] = {"gravity": "link"}
        axis = axis_from(_assumed(tables))
    notes = [f"column {role.column} is taken as the {channel.replace('_', ' ')}: {role.reason}"
             for channel, role in roles.channels.items()]  # fmt: skip
    notes += [f"{key} is not known: it is taken as 1 in SI" for key in missing]
    if name is not None:
        notes.append(f"the file holds {count} tables: {name!r} is looked at")
    if roles.rivals:
        notes.append(f"columns that could be the position as well: {some_of(roles.rivals)}")
    return Proposal(_text(table, roles, tables, axis.kind), missing, axis, table, tuple(notes))


def _kind(roles: Roles) -> Kind | None:
    """Return the kind of axis that the units speak of; None where they speak of none."""
    position, effort = roles.channels["position"], roles.channels.get("effort")
    for base, kind in OF_UNIT.items():
        if position.unit and units.compatible(position.unit, base):
            return kind
    if position.unit or effort is None or not effort.unit:
        return None
    return KINDS[0] if units.compatible(effort.unit, "N") else None


def _tables(table: Table, roles: Roles) -> dict[str, Any]:
    """Return the content of the proposed file; what is not known is marked."""
    kind = _kind(roles)
    columns: dict[str, dict[str, Any]] = {}
    for channel in ORDER:
        if (role := roles.channels.get(channel)) is not None:
            columns[channel] = {"column": role.column, "unit": role.unit or FILL_IN}
    position = roles.channels["position"]
    for channel in ("reference", "following_error"):
        if channel in columns and not roles.channels[channel].unit:
            columns[channel]["unit"] = FILL_IN
    tables: dict[str, Any] = {"schema": 1, "name": table.source.stem or "axis"}
    tables |= {"kind": kind} if kind else {}
    tables["columns"] = columns
    facts = _facts_of(table.facts)
    if "velocity" in columns and not _goes_with(columns["velocity"]["unit"], position.unit, facts):
        del columns["velocity"]  # of the motor, and the way from there to the position is not told
    if position.unit and units.compatible(position.unit, "count"):
        remark = facts.get("encoder.counts_per_rev")
        tables["encoder"] = {"counts_per_rev": remark} if remark else {"resolution": FILL_IN}
    if (effort := roles.channels.get("effort")) is not None:
        tables |= _constant(effort, facts)
    if "time" not in columns and not roles.implied_time and table.sample_time is None:
        tables["timing"] = {"sample_time": FILL_IN}
    if _needs_lead(tables, kind):
        tables["transmission"] = {"lead": facts.get("transmission.lead", FILL_IN)}
    return tables


def _constant(effort: Role, facts: Mapping[str, Any]) -> dict[str, Any]:
    if not effort.unit or any(units.compatible(effort.unit, base) for base in ("N", "N*m")):
        return {}
    if units.compatible(effort.unit, "rated"):
        return {"effort": {"rated": facts.get("effort.rated", FILL_IN)}}
    return {"effort": {"constant": facts.get("effort.constant", FILL_IN)}}


def _needs_lead(tables: Mapping[str, Any], kind: Kind | None) -> bool:
    """Return whether position and effort are measured on both sides of a screw."""
    turns = _turns(tables)
    return kind is not None and turns is not None and turns != (kind == KINDS[1])


def _turns(tables: Mapping[str, Any]) -> bool | None:
    """Return whether the drive turns: its effort is a torque, or its encoder counts turns; None where nothing tells."""
    if "counts_per_rev" in tables.get("encoder", {}):
        return True
    texts = [str(value) for value in tables.get("effort", {}).values()]
    texts.append(tables["columns"].get("effort", {}).get("unit", ""))
    turns = [units.compatible(unit, "N*m") for unit in map(_unit_in, texts) if unit and units.is_unit(unit)
             and any(units.compatible(unit, base) for base in ("N", "N*m"))]  # fmt: skip
    return any(turns) if turns else None


def _unit_in(text: str) -> str:
    """Return the force or torque that a unit, a rated effort or a constant speaks of."""
    unit = re.sub(r"^[\d.eE+-]+\s*", "", text)
    return unit.rpartition("/")[0] or unit


def _goes_with(velocity: str, position: str, facts: Mapping[str, Any]) -> bool:
    kinds = [next((base for base in ("m", "rad", "count") if unit and units.compatible(unit, base + per)), "")
             for unit, per in ((velocity, "/s"), (position, ""))]  # fmt: skip
    return kinds[0] == kinds[1] or ("count" not in kinds and "transmission.lead" in facts)


def _facts_of(facts: Mapping[str, str]) -> dict[str, Any]:
    """Return what the lines above the columns tell of the drive."""
    facts_found: dict[str, Any] = {}
    for name, text in facts.items():
        for key, pattern in FACTS.items():
            if key in facts_found or not re.search(pattern, name.lower()):
                continue
            amount = amount_in(name, text)
            if amount is None or amount[0] == 0.0:
                continue
            number, unit = amount
            if key == "encoder.counts_per_rev":
                facts_found[key] = number
            elif unit and _fits(unit, key):
                facts_found[key] = f"{number:.12g} {unit}"
    return facts_found


def _fits(unit: str, key: str) -> bool:
    bases = {
        "effort.rated": ("N", "N*m"),
        "effort.constant": ("N/A", "N*m/A", "N/V", "N*m/V"),
        "transmission.lead": ("m",),
    }
    return units.is_unit(unit) and any(units.compatible(unit, base) for base in bases[key])


def _assumed(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables with SI for what is missing, so that the log can be looked at."""
    kind: Kind = tables.get("kind") or (KINDS[1] if _turns(tables) else KINDS[0])
    columns = {name: dict(entry) for name, entry in tables["columns"].items()}
    for name, entry in columns.items():
        if entry.get("unit") == FILL_IN:
            channel = "effort" if name == "effort" else "position"
            entry["unit"] = ASSUMED_UNIT[channel][kind]
    assumed = {**tables, "kind": kind, "columns": columns}
    force = ASSUMED_UNIT["effort"][kind]
    for name, filled in (
        ("effort", force), ("encoder", ASSUMED_UNIT["position"][kind]), ("timing", "s"), ("transmission", "m"),
    ):  # fmt: skip
        if name in tables:
            assumed[name] = {
                key: f"1 {filled}{_per(key, columns)}" if value == FILL_IN else value
                for key, value in tables[name].items()
            }
    return assumed


def _per(key: str, columns: Mapping[str, Any]) -> str:
    if key != "constant":
        return ""
    unit = columns["effort"]["unit"]
    return f"/{next(drive for drive in ('A', 'V', 'count', 'rated') if units.compatible(unit, drive))}"


def _reversed(table: Table, axis: Axis) -> bool:
    """Return whether the effort takes work out of the axis that friction would put in."""
    if "effort" not in axis.columns:
        return False
    try:
        return any(facts_found.code == "sign_reversed" for facts_found in checked(_log(table, axis), axis))
    except InputError:
        return False


def _has_a_link(table: Table, axis: Axis) -> bool:
    """Return whether the effort of a rotational axis goes with its angle as the gravity of a link does."""
    if axis.kind != KINDS[1] or "effort" not in axis.columns:
        return False
    try:
        log = _log(table, axis)
    except InputError:
        return False
    return log.effort is not None and pulls_as_a_link(log.effort.values, log.position.values)


def _log(table: Table, axis: Axis) -> Any:
    from bristle.logs.log import log_of

    return log_of(record_of(table, axis))


def _missing(tables: Mapping[str, Any], path: str = "") -> list[str]:
    facts_found = []
    for key, value in tables.items():
        full = f"{path}.{key}" if path else key
        if isinstance(value, Mapping):
            facts_found += _missing(value, full)
        elif value == FILL_IN:
            facts_found.append(full)
    position = "columns.position.unit"
    following = ("columns.reference.unit", "columns.following_error.unit")
    return [key for key in facts_found if not (key in following and position in facts_found)]


def _text(table: Table, roles: Roles, tables: Mapping[str, Any], kind: Kind) -> str:
    """Return the tables as an axis file for people."""
    lines = [f"# Proposed by bristle from {table.origin.name or table.source.name} ({table.format})."]
    missing = _missing(tables)
    if missing:
        lines.append(f"# Fill in the question marks ({', '.join(missing)}), then look at the log with it.")
    lines += ["schema = 1", f"name = {_quoted(tables['name'])}"]
    if "kind" in tables:
        lines.append(f"kind = {_quoted(tables['kind'])}")
    else:
        lines.append('# kind = "translational" or "rotational": the unit of the position decides')
    lines += ["", "[columns]"]
    if roles.implied_time:
        lines.append(f"# each column of this {table.format} file brings its time: none is to be named")
    for channel, entry in tables["columns"].items():
        lines.append(_column_line(channel, entry, roles))
    for name in ("log", "effort", "transmission", "plant", "encoder", "timing"):
        if name in tables:
            lines += ["", f"[{name}]", *(_line(f"{name}.{key}", value, tables) for key, value in tables[name].items())]
    lines += _encoder_lines(table, tables) + _controller_lines(tables, kind)
    used = {entry["column"] for entry in tables["columns"].values()}
    left = [name for name in table.names if name not in used and name not in table.stamps.values()]
    if left:
        lines += ["", f"# columns that are not used: {some_of(left, 20)}"]
    return "\n".join(lines) + "\n"


def _encoder_lines(table: Table, tables: Mapping[str, Any]) -> list[str]:
    """Return what the steps of the position speak of, as a comment: digits of the file look like an encoder."""
    entry = tables["columns"]["position"]
    if "encoder" in tables or entry["unit"] == FILL_IN:
        return []
    step = clear_step(table.columns[entry["column"]])
    if not step:
        return []
    remark = "the position moves in such steps: of the encoder, or of the digits of the file"
    return ["", "# [encoder]", f'# resolution = "{step:.6g} {entry["unit"]}"  # {remark}']


def _controller_lines(tables: Mapping[str, Any], kind: Kind) -> list[str]:
    """Return the question for the controller of the drive, as a comment, where the log has what its loop follows."""
    if not {"reference", "following_error"} & set(tables["columns"]):
        return []
    gain, integral = (unit_of(quantity, kind) for quantity in ("force*time/length", "force/length"))
    return [
        "",
        "# How is the axis controlled? With the gains of the drive, bristle simulates the following error without and",
        "# with compensation, and states the effect of what it exports.",
        "# [controller]",
        '# model = "cascade"',
        f'# k_p = "{FILL_IN}"  # position loop, such as "60 1/s"',
        f'# k_v = "{FILL_IN}"  # velocity loop, in {gain} or in the unit of the effort column',
        f'# k_i = "{FILL_IN}"  # its integral, in {integral} likewise; or T_n = "10 ms"',
        f'# k_ff = "{FILL_IN}"  # share of the reference velocity that the drive feeds forward, 0 to 1',
    ]


def _column_line(channel: str, entry: Mapping[str, Any], roles: Roles) -> str:
    follows = channel in ("reference", "following_error") and entry["unit"] == FILL_IN
    visible = {key: value for key, value in entry.items() if not (follows and key == "unit")}
    body = ", ".join(f"{key} = {_quoted(value) if isinstance(value, str) else value}" for key, value in visible.items())
    line = f"{channel} = {{ {body} }}"
    role = roles.channels[channel]
    remark = TOLD_BY.get(role.told_by, "")
    remarks = [] if role.reason == "its name" else [role.reason]
    remarks += [remark] if remark and not follows else []
    remarks += ["in the unit of the position"] if follows else []
    hint = "rated" if role.told_by == "rated" else f"columns.{channel}.unit"
    remarks += [HINTS[hint]] if not follows and entry["unit"] == FILL_IN else []
    remarks += ["the effort as recorded takes work out of the axis"] if entry.get("sign") == -1 else []
    return f"{line}  # {'; '.join(remarks)}" if remarks else line


def _line(key: str, value: Any, tables: Mapping[str, Any]) -> str:
    hint = "  # the effort goes with sine and cosine of the angle" if key == "plant.gravity" else ""
    if value == FILL_IN:
        drive = tables["columns"].get("effort", {}).get("unit", "A")
        drive = next(
            (
                entry_name
                for entry_name in ("A", "V", "count")
                if drive != FILL_IN and units.compatible(drive, entry_name)
            ),
            "A",
        )
        turning = HINTS_OF_TURNING if tables.get("kind") == KINDS[1] else {}
        hint = f"  # {turning.get(key, HINTS[key]).format(drive=drive)}"
    return f"{key.rpartition('.')[2]} = {_quoted(value) if isinstance(value, str) else value}{hint}"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
