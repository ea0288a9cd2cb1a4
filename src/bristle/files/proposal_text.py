"""The text of a proposed axis file: its tables as TOML for people, with what to write in place of each mark."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from bristle.core import units
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.files.components import FILL_IN, open_in
from bristle.logs.log import clear_step
from bristle.logs.roles import Roles
from bristle.logs.table import Table, some_of

_SCREW = 'with lead = "10 mm", travel for one turn of the motor, under [transmission] where a screw turns'
HINTS = {
    "columns.time.unit": "unit of the numbers: s, ms, us or ns",
    "columns.position.unit": "unit of the numbers: mm, um, m, deg, rad or rev",
    "columns.velocity.unit": "unit of the numbers: mm/s, m/min, rad/s, deg/s or rpm",
    "columns.effort.unit": "unit of the numbers: N, N*m, or A, %, ‰ or V with its constant under [effort]",
    "rated": '"%" or "‰" of rated, with rated = "2.4 N*m" under [effort]; or N, N*m, A or V',
    "effort.rated": f'what 100 % are, such as "120 N" (or "2.4 N*m", {_SCREW})',
    "effort.constant": 'force or torque for one {drive}, such as "61.2 N/{drive}" (or "0.12 N*m/{drive}", ' + f"{_SCREW})",
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
TOLD_BY = {
    "name": "unit from its name",
    "its name": "unit assumed from its name",
    "velocity": "unit from the velocity",
    "numbers": "unit from its numbers",
    "drive": 'whole numbers, as drives store ‰ of rated: see that it is not "%"',
    "position": "unit from the position",
    "reference": "unit from the reference",
}


def missing_of(tables: Mapping[str, Any]) -> list[str]:
    """Return the keys of the tables that are to be filled in."""
    keys = list(open_in(tables))
    following = ("columns.reference.unit", "columns.following_error.unit")
    return [key for key in keys if not (key in following and "columns.position.unit" in keys)]


def text_of(table: Table, roles: Roles, tables: Mapping[str, Any], kind: Kind) -> str:
    """Return the tables as an axis file for people."""
    lines, columns = [f"# Proposed by bristle from {table.origin.name or table.source.name} ({table.format})."], tables["columns"]
    missing = missing_of(tables)
    if missing:
        lines.append(f"# Fill in the question marks ({', '.join(missing)}), then look at the log with it.")
    lines += ["schema = 1", f"name = {_quoted(tables['name'])}"]
    if "kind" in tables:
        lines.append(f"kind = {_quoted(tables['kind'])}")
    else:
        motion = "position" if "position" in columns else "velocity"
        lines.append(f'# kind = "translational" or "rotational": the unit of the {motion} decides')
    lines += ["", "[columns]"]
    if roles.implied_time:
        lines.append(f"# each column of this {table.format} file brings its time: none is to be named")
    lines += [_column_line(channel, entry, roles) for channel, entry in columns.items()]
    for name in ("log", "effort", "transmission", "plant", "encoder", "timing"):
        if name in tables:
            lines += ["", f"[{name}]", *(_line(f"{name}.{key}", value, tables) for key, value in tables[name].items())]
    position = columns.get("position")
    is_told = position is None or "encoder" in tables or position["unit"] == FILL_IN
    if step := 0.0 if is_told else clear_step(table.columns[position["column"]]):
        remark = "the position moves in such steps: of the encoder, or of the digits of the file"
        lines += ["", "# [encoder]", f'# resolution = "{step:.6g} {position["unit"]}"  # {remark}']
    if {"reference", "following_error"} & set(columns):  # the log has what a loop follows
        gain, integral = (unit_of(quantity, kind) for quantity in ("force*time/length", "force/length"))
        lines += ["", CONTROLLER.format(gain=gain, integral=integral)]
    used = {entry["column"] for entry in columns.values()}
    left = [name for name in table.names if name not in used and name not in table.stamps.values()]
    if left:
        lines += ["", f"# columns that are not used: {some_of(left, 20)}"]
    return "\n".join(lines) + "\n"


CONTROLLER = """\
# How is the axis controlled? With the gains of the drive, bristle simulates the following error without and
# with compensation, and states the effect of what it exports.
# [controller]
# model = "cascade"
# k_p = "?"  # position loop, such as "60 1/s"
# k_v = "?"  # velocity loop, in {gain} or in the unit of the effort column
# k_i = "?"  # its integral, in {integral} likewise; or T_n = "10 ms"
# k_ff = "?"  # share of the reference velocity that the drive feeds forward, 0 to 1"""


def _column_line(channel: str, entry: Mapping[str, Any], roles: Roles) -> str:
    role, is_open = roles.channels[channel], entry["unit"] == FILL_IN
    follows = channel in ("reference", "following_error") and is_open
    visible = {key: value for key, value in entry.items() if not (follows and key == "unit")}
    body = ", ".join(f"{key} = {_quoted(value)}" for key, value in visible.items())
    remarks = [
        "" if role.reason == "its name" else role.reason,
        "in the unit of the position" if follows else TOLD_BY.get(role.told_by, ""),
        f"the file says {_quoted(role.unknown)}, which is no unit that is known here" if role.unknown else "",
        HINTS["rated" if role.told_by == "rated" else f"columns.{channel}.unit"] if is_open and not follows else "",
        "the effort as recorded takes work out of the axis" if entry.get("sign") == -1 else "",
    ]
    said = "; ".join(filter(None, remarks))
    return f"{channel} = {{ {body} }}  # {said}" if said else f"{channel} = {{ {body} }}"


def _line(key: str, value: Any, tables: Mapping[str, Any]) -> str:
    hint = "  # the effort goes with sine and cosine of the angle" if key == "plant.gravity" else ""
    if value == FILL_IN:
        unit = tables["columns"].get("effort", {}).get("unit", "A")
        drive = next((base for base in ("A", "V", "count") if unit != FILL_IN and units.compatible(unit, base)), "A")
        turning = HINTS_OF_TURNING if tables.get("kind") == KINDS[1] else {}
        hint = f"  # {turning.get(key, HINTS[key]).format(drive=drive)}"
    return f"{key.rpartition('.')[2]} = {_quoted(value)}{hint}"


def _quoted(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
