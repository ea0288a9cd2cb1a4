"""Propose an axis file for a log; missing information is marked for the user to fill in."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from bristle.core import SIZE_LIMIT, InputError, Readable, size_of, units
from bristle.core.axis import COLUMNS, Axis
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.files.axis import axis_from
from bristle.files.components import FILL_IN, open_in
from bristle.files.drive import EFFORTS, MOVEMENTS
from bristle.files.joints import JOINT
from bristle.files.toml import quoted
from bristle.logs import checked
from bristle.logs.assembly import record_of
from bristle.logs.channel import clear_step
from bristle.logs.nameless import (
    REVERSED,
    Proposed,
    is_nameless,
    joint_count,
    numbered_roles,
    proposed_roles,
    roles_of_joint,
)
from bristle.logs.readers import read_table
from bristle.logs.roles import Roles, facts_of_speeds, pulls_as_a_link, roles_of
from bristle.logs.stamped_text import amount_in, stated_periods
from bristle.logs.table import Table, some_of
from bristle.logs.tables import content_of_log
from bristle.logs.words import is_time

_SCREW = 'with lead = "10 mm", travel per turn of the motor, under [transmission] for a screw, or gear_ratio = 60 for a gear'
HINTS = {
    "columns.time.unit": "unit of the numbers: s, ms, us or ns",
    "columns.position.unit": "unit of the numbers: mm, um, m, deg, rad or rev",
    "columns.velocity.unit": "unit of the numbers: mm/s, m/min, rad/s, deg/s or rpm",
    "columns.effort.unit": "unit of the numbers: N, N*m, or A, %, ‰ or V with its constant under [effort]",
    "rated": '"%" or "‰" of rated, with rated = "2.4 N*m" under [effort]; or N, N*m, A or V',
    "effort.rated": f'effort at 100 %, such as "120 N" (or "2.4 N*m", {_SCREW})',
    "effort.constant": 'force or torque per {drive}, such as "61.2 N/{drive}" (or "0.12 N*m/{drive}", '
    + f"{_SCREW})",
    "transmission.gear_ratio": "turns of the motor per turn of the axis, without quotes: 1 for a direct drive, 60 for a worm of 60:1. "
    'With a gear, add side = "load" or side = "motor" to each column of an angle',
    "transmission.lead": 'travel of the load per turn of the motor, such as "10 mm"; or per turn of the screw, with '
    "gear_ratio = 2 in the next line for a 2:1 gear between them",
    "encoder.resolution": 'movement per count, such as "0.1 um" or "0.01 deg"; or write counts_per_rev = 8192 and side = "motor" instead',
    "timing.sample_time": 'time between samples, such as "1 ms"',
}
# The data sheet of a rotational axis gives torques.
HINTS_OF_TURNING = {
    "effort.rated": 'effort at 100 %, such as "1.3 N*m"',
    "effort.constant": 'torque per {drive}, such as "0.12 N*m/{drive}"',
}
UNIT_SOURCES = {
    "name": "unit from its name",
    "its name": "unit assumed from its name",
    "velocity": "unit from the velocity",
    "numbers": "unit from its numbers",
    "drive": 'the numbers are whole, as in drives that store ‰ of rated: check that the unit is not "%"',
    "position": "unit from the position",
    "reference": "unit from the reference",
    "Hz": "the file states Hz: check that these are turns of the axis, not periods of a current",
}


def missing_of(tables: Mapping[str, Any]) -> list[str]:
    """Return the keys of the tables to fill in."""
    keys = list(open_in(tables))
    following = [f"columns.{channel}.unit" for channel in LIKE_POSITION]
    return [key for key in keys if not (key in following and "columns.position.unit" in keys)]


def text_of(table: Table, roles: Roles, tables: Mapping[str, Any], kind: Kind) -> str:
    """Return the tables as the text of an axis file with comments."""
    lines, columns = (
        [f"# Proposed by bristle from {table.origin.name or table.source.name} ({table.format})."],
        tables["columns"],
    )
    missing = missing_of(tables)
    if missing:
        lines.append(
            f"# Fill in the question marks ({', '.join(missing)}), then inspect the log with this file."
        )
    lines += ["schema = 1", f"name = {quoted(tables['name'])}"]
    if "kind" in tables:
        lines.append(f"kind = {quoted(tables['kind'])}")
    else:
        motion = "position" if "position" in columns else "velocity"
        lines.append(f'# kind = "translational" or "rotational": the unit of the {motion} decides')
    lines += ["", "[columns]"]
    if table.stamps:
        lines.append(
            f"# each column of this {table.format} file has its own time: do not name a time column"
        )
    lines += [_column_line(channel, entry, roles) for channel, entry in columns.items()]
    for name in ("log", "effort", "transmission", "plant", "encoder", "timing"):
        if name in tables:
            lines += [
                "",
                f"[{name}]",
                *(
                    _line(f"{name}.{key}", value, tables, table.facts)
                    for key, value in tables[name].items()
                ),
            ]
    position = columns.get("position")
    is_open = position is not None and "encoder" not in tables and position["unit"] != FILL_IN
    if position is not None and is_open and (step := clear_step(table.columns[position["column"]])):
        remark = "smallest step of the position, by the encoder or by the digits in the file"
        lines += ["", "# [encoder]", f'# resolution = "{step:.6g} {position["unit"]}"  # {remark}']
    if {"reference", "following_error"} & set(columns):  # the log has a reference
        gain, integral = (
            unit_of(quantity, kind) for quantity in ("force*time/length", "force/length")
        )
        lines += ["", CONTROLLER.format(gain=gain, integral=integral)]
    used = {entry["column"] for entry in columns.values()}
    left = [name for name in table.names if name not in used and name not in table.stamps.values()]
    if left:
        lines += ["", f"# unused columns: {some_of(left, 20)}"]
    return "\n".join(lines) + "\n"


CONTROLLER = """\
# With the gains of the controller, bristle simulates the following error without and with compensation.
# [controller]
# model = "cascade"
# k_p = "?"  # position loop, such as "60 1/s"
# k_v = "?"  # velocity loop, in {gain}, or with the unit of the effort column
# k_i = "?"  # its integral, in {integral}, or with the unit of the effort column; or T_n = "10 ms"
# k_ff = "?"  # share of the reference velocity that the drive feeds forward, 0 to 1
# cycle = "?"  # cycle of the controller, such as "0.25 ms"; by default the sample time of the log"""


def _column_line(channel: str, entry: Mapping[str, Any], roles: Roles) -> str:
    role, is_open = roles.channels[channel], entry["unit"] == FILL_IN
    follows = channel in LIKE_POSITION and is_open
    visible = {key: value for key, value in entry.items() if not (follows and key == "unit")}
    body = ", ".join(f"{key} = {quoted(value)}" for key, value in visible.items())
    remarks = [
        "" if role.reason == "its name" else role.reason,
        "second encoder, at the load" if channel == "load_position" else "",
        "in the unit of the position" if follows else UNIT_SOURCES.get(role.unit_source, ""),
        f"the file states the unknown unit {quoted(role.unknown)}" if role.unknown else "",
        HINTS["rated" if role.unit_source == "rated" else f"columns.{channel}.unit"]
        if is_open and not follows
        else "",
        "the recorded effort takes work out of the axis, so its sign is reversed"
        if entry.get("sign") == -1
        else "",
    ]
    comment = "; ".join(filter(None, remarks))
    return f"{channel} = {{ {body} }}  # {comment}" if comment else f"{channel} = {{ {body} }}"


REMARKS = {
    "plant.gravity": "  # the effort depends on sine and cosine of the angle",
    "transmission.gear_ratio": "  # ratio of two speeds in the log",
}


def _line(key: str, value: Any, tables: Mapping[str, Any], facts: Mapping[str, str]) -> str:
    hint = REMARKS.get(key, "")
    if value == FILL_IN:
        unit = tables["columns"].get("effort", {}).get("unit", "A")
        drive = next(
            (
                base
                for base in ("A", "V", "count")
                if unit != FILL_IN and units.compatible(unit, base)
            ),
            "A",
        )
        turning = HINTS_OF_TURNING if tables.get("kind") == KINDS[1] else {}
        stated = [
            f"; the log states {line!r}"
            for line in stated_periods(facts, named=False)
            if key == "timing.sample_time"
        ]
        hint = "".join([f"  # {turning.get(key, HINTS[key]).format(drive=drive)}", *stated])
    return f"{key.rpartition('.')[2]} = {quoted(value)}{hint}"


# Channels in the unit of the position.
LIKE_POSITION = ("load_position", "reference", "following_error")
ORDER = ("time", "position", "load_position", "reference", "following_error", "velocity", "effort")
# Header lines of some exports -> key in an axis file.
FACTS = {
    "effort.rated": r"(rated|nominal|nenn|bemessungs)[\s_-]*(torque|moment|drehmoment|force|kraft)"
    r"|(torque|moment).*(rated|nenn)",
    "effort.constant": r"(torque|force|motor)[\s_-]*constant|(drehmoment|kraft|motor)konstante|\bk_?t\b",
    "transmission.lead": r"\b(lead|pitch)\b|spindelsteigung|steigung|vorschubkonstante|feed constant",
    "encoder.counts_per_rev": r"(counts|increments|inkremente|inc|pulses)[\s_-]*(per|pro|/)[\s_-]*"
    r"(rev|turn|umdrehung|u)\w*",
}


SPOKEN_OF = {
    "effort.rated": ("N", "N*m"),
    "effort.constant": ("N/A", "N*m/A", "N/V", "N*m/V"),
    "transmission.lead": ("m",),
}


@dataclass(frozen=True)
class Proposal:
    """A proposed axis file for a log.

    Parameters
    ----------
    text : str
        The file (TOML). Missing values are ``"?"``, with a comment that explains them.
    missing : tuple of str
        Keys to fill in.
    axis : Axis
        The axis, with SI units for missing units and 1 for missing constants.
    table : Table
        The source columns.
    notes : tuple of str
        Assumptions, and alternative columns.
    unknown : dict of str to str
        Channels whose unit bristle does not know, each with the unit as the file states it.
    roles : tuple of Proposed
        Role of each column of a log without names, for one joint or several, with its evidence.
    """

    text: str
    missing: tuple[str, ...]
    axis: Axis
    table: Table = field(repr=False, compare=False)
    notes: tuple[str, ...] = ()
    unknown: Mapping[str, str] = field(default_factory=dict)
    roles: tuple[Proposed, ...] = ()

    @property
    def joints(self) -> int:
        """Number of joints among columns without names."""
        return joint_count(self.roles)


def propose_axis(log: Readable, *, size_limit: int | str = SIZE_LIMIT) -> Proposal:
    """Propose an axis file for a log, from the names, units and similarity of its columns.

    Parameters
    ----------
    log : path-like, bytes or file object
        A log in any format that `read_log` reads.
    size_limit : int or str
        Limit for the file and for the content that it announces [byte], or text such as ``"2 GB"``.

    Returns
    -------
    Proposal
        Its text, the keys to fill in, and the axis as far as it is known.

    Raises
    ------
    InputError
        If the log cannot be read or lacks a column for the position.
    """
    limit = size_of(size_limit)
    content = content_of_log(log, limit=limit)
    table, name, count = read_table(content, size_limit=limit), None, 0
    if table.tables:
        name, count = table.tables[0], len(table.tables)
        table = read_table(content, name, size_limit=limit)
    roles = roles_of(table)
    has_names = not is_nameless(table) and {"position", "velocity"} & set(roles.channels)
    proposed = numbered_roles(table, roles) if has_names else proposed_roles(table)
    joints = joint_count(proposed)
    if joints:
        first, named = roles_of_joint(proposed, 1).channels, roles.channels if has_names else {}
        channels = {
            channel: replace(named.get(channel, role), column=role.column)
            for channel, role in first.items()
        }
        roles = replace(
            roles,
            channels=channels
            | {key: roles.channels[key] for key in {"time"} & set(roles.channels)},
        )
    if not {"position", "velocity"} & set(roles.channels):
        message = "has no column that bristle recognises as the position"
        raise InputError(
            f"{message}, only {some_of(table.names, 40)}",
            path=str(table.source),
            mend="Write an axis file that names the columns, and add --axis AXIS.toml",
        )
    transmission = facts_of_speeds(table, roles)
    if joints > 1:  # each joint has its own gear
        transmission = {}
    tables: dict[str, Any] = _tables(table, roles, **transmission)
    if name is not None:
        tables["log"] = {"table": name}
    missing = tuple(missing_of(tables))
    axis = _looked_at(table, tables, missing)
    notes = [
        f"bristle uses column {role.column} as the {channel.replace('_', ' ')} (reason: {role.reason})"
        for channel, role in roles.channels.items()
    ]
    unknown = {
        channel: role.unknown
        for channel, role in roles.channels.items()
        if role.unknown and not role.unit
    }
    notes += [
        f"the file states the unknown unit {text!r} for the {channel}: bristle cannot convert it to SI units"
        for channel, text in unknown.items()
    ]
    without_unit = {f"columns.{channel}.unit" for channel in unknown}
    notes += [
        f"{key} is unknown: bristle assumes 1 in SI units"
        for key in missing
        if key not in without_unit
    ]
    notes += [
        f"column {transmission['second']} shows {key} = {value}"
        for key, value in transmission.items()
        if "." in key
    ]
    if name is not None:
        notes.append(f"the file contains {count} tables: bristle uses {name!r}")
    if roles.rivals:
        notes.append(f"other possible columns for the position: {some_of(roles.rivals)}")
    text = text_of(table, roles, tables, axis.kind)
    if joints > 1:
        text = _text_of_joints(text, tables, proposed, joints)
        notes = [
            f"the log has the columns of {joints} joints, one table [[joint]] for each: bristle uses no column before you accept its role"
        ]
    return Proposal(text, missing, axis, table, tuple(notes), unknown, proposed)


def _text_of_joints(
    text: str, tables: Mapping[str, Any], proposed: Sequence[Proposed], joints: int
) -> str:
    """Return the text of an axis file with common units, and the columns of each joint."""
    first = roles_of_joint(proposed, 1).channels
    for channel in tables["columns"]:
        if channel != "time":
            stated = tables["columns"][channel].get("unit", FILL_IN)
            hint = (
                f"  # {HINTS.get(f'columns.{channel}.unit', HINTS['columns.position.unit'])}"
                if stated == FILL_IN
                else ""
            )
            text = re.sub(
                rf"(?m)^{channel} = .*$", f"{channel} = {{ unit = {quoted(stated)} }}{hint}", text
            )
    text = "".join(
        line for line in text.splitlines(keepends=True) if not line.startswith("# unused columns")
    )
    lines = [text.rstrip("\n")]
    for joint in range(1, joints + 1):
        lines += ["", f"[[{JOINT}]]"]
        for channel, role in roles_of_joint(proposed, joint).channels.items():
            sign = ", sign = -1" if role.reason.endswith(REVERSED) else ""
            if channel in first and channel != "time":
                lines.append(
                    f"columns.{channel} = {{ column = {quoted(role.column)}{sign} }}  # {role.reason}"
                )
    return "\n".join(lines) + "\n"


def _looked_at(table: Table, tables: dict[str, Any], missing: tuple[str, ...]) -> Axis:
    """Return the axis of the tables; add a reversed sign of the effort, or a link, if the log shows it."""
    axis = axis_from(_assumed(tables))
    try:
        log = record_of(table, axis) if "effort" in axis.columns else None
        if log is not None and any(
            finding.code == "sign_reversed" for finding in checked(log, axis)
        ):
            tables["columns"]["effort"]["sign"] = -1
            axis = axis_from(_assumed(tables))
    except InputError:
        return axis
    # The effort of a rotational axis may depend on the angle like the gravity of a link; scaling does not change this shape.
    is_known = set(missing) <= {"columns.effort.unit", "effort.rated", "effort.constant"}
    effort = log.effort if log is not None and axis.kind == KINDS[1] and is_known else None
    if (
        log is not None
        and effort is not None
        and pulls_as_a_link(effort.values, log.position.values)
    ):
        tables["plant"] = {"gravity": "link"}
        axis = axis_from(_assumed(tables))
    return axis


def _tables(table: Table, roles: Roles, **transmission: str | float) -> dict[str, Any]:
    """Return the content of the proposed file, with markers for missing values; `transmission` is what a second speed shows."""
    position, effort = roles.channels.get("position"), roles.channels.get("effort")
    motion, per = (position, "") if position else (roles.channels["velocity"], "/s")
    kind: Kind | None = None  # stated by the units
    if motion.unit:
        kind = MOVEMENTS.get(units.like(motion.unit, MOVEMENTS, per=per) or "")
    if kind is None and effort is not None and units.like(effort.unit, ("N",)):
        kind = KINDS[0]
    named = {
        channel: role for channel in ORDER if (role := roles.channels.get(channel)) is not None
    }
    columns: dict[str, dict[str, Any]] = {
        channel: {"column": role.column, "unit": role.unit or FILL_IN}
        for channel, role in named.items()
    }
    tables: dict[str, Any] = {"schema": 1, "name": table.source.stem or "axis"}
    tables |= {"kind": kind} if kind else {}
    tables["columns"] = columns
    # Data of the drive, from a second speed and from the lines above the columns.
    facts: dict[str, Any] = dict(transmission)
    for name, text in table.facts.items():
        for key, pattern in FACTS.items():
            amount = (
                amount_in(name, text)
                if key not in facts and re.search(pattern, name.lower())
                else None
            )
            if amount is not None and amount[0] != 0.0 and key == "encoder.counts_per_rev":
                facts[key] = amount[0]
            elif (
                amount is not None
                and amount[0] != 0.0
                and amount[1]
                and units.is_unit(amount[1])
                and units.like(amount[1], SPOKEN_OF[key])
            ):
                facts[key] = f"{amount[0]:.12g} {amount[1]}"
    is_of_drive = effort is not None and effort.unit != "" and not units.like(effort.unit, EFFORTS)
    if columns.get("velocity", {}).get("column") == facts.get("second", "") and (
        is_of_drive or kind == KINDS[0]
    ):
        del columns["velocity"]
    if position and "velocity" in columns:
        bases = ("m", "rad", "count")
        moved = [
            units.like(columns["velocity"]["unit"].strip(FILL_IN), bases, per="/s"),
            units.like(position.unit, bases),
        ]
        if moved[0] != moved[1] and ("count" in moved or "transmission.lead" not in facts):
            del columns["velocity"]  # of the motor, but its relation to the position is unknown
    if units.like(motion.unit, ("count", "count/s")):
        remark = facts.get("encoder.counts_per_rev")
        tables["encoder"] = {"counts_per_rev": remark} if remark else {"resolution": FILL_IN}
    if effort is not None and is_of_drive:
        key = "rated" if units.compatible(effort.unit, "rated") else "constant"
        tables["effort"] = {key: facts.get(f"effort.{key}", FILL_IN)}
        if kind == KINDS[1]:
            tables["transmission"] = {"gear_ratio": facts.get("transmission.gear_ratio", FILL_IN)}
            for channel in {"position", "velocity", "reference", "following_error"} & set(columns):
                columns[channel] |= {key: facts[key] for key in {"side"} & set(facts)}
        elif "second" in facts:
            tables["transmission"] = {"lead": facts["transmission.lead"]}
    if (
        "time" not in columns
        and not table.stamps
        and (table.sample_time is None or any(map(is_time, table.names)))
    ):
        tables["timing"] = {
            "sample_time": f"{table.sample_time:g} s" if table.sample_time else FILL_IN
        }
    # Position and effort are measured on both sides of a screw.
    if kind is not None and (turns := _turns(tables)) is not None and turns != (kind == KINDS[1]):
        tables["transmission"] = {"lead": facts.get("transmission.lead", FILL_IN)}
    return tables


def _turns(tables: Mapping[str, Any]) -> bool | None:
    """Return whether the drive is rotational: its effort is a torque, or its encoder counts turns; None if unknown."""
    if "counts_per_rev" in tables.get("encoder", {}):
        return True
    texts = [str(value) for value in tables.get("effort", {}).values()]
    texts.append(tables["columns"].get("effort", {}).get("unit", ""))
    # Force or torque, from a unit, a rated effort or a constant.
    bare = [re.sub(r"^[\d.eE+-]+\s*", "", text) for text in texts]
    spoken_of = [unit.rpartition("/")[0] or unit for unit in bare]
    bases = [units.like(unit, EFFORTS) for unit in spoken_of if unit and units.is_unit(unit)]
    return "N*m" in bases if any(bases) else None


def _assumed(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables with SI units in place of missing values, so that the log can be read."""
    kind: Kind = tables.get("kind") or (KINDS[1] if _turns(tables) else KINDS[0])
    columns = {name: dict(entry) for name, entry in tables["columns"].items()}
    for name, entry in columns.items():
        if entry.get("unit") == FILL_IN:
            entry["unit"] = unit_of(COLUMNS[name], kind)
    assumed = {**tables, "kind": kind, "columns": columns}
    force, drive = (
        unit_of("force", kind),
        units.like(columns.get("effort", {}).get("unit"), ("A", "V", "count", "rated")),
    )
    unity = {
        "rated": f"1 {force}",
        "constant": f"1 {force}/{drive}",
        "resolution": f"1 {unit_of('length', kind)}",
        "gear_ratio": 1.0,
        "sample_time": "1 s",
        "lead": "1 m",
    }
    for name in {"effort", "encoder", "timing", "transmission"} & set(tables):
        assumed[name] = {
            key: unity[key] if value == FILL_IN else value for key, value in tables[name].items()
        }
    return assumed
