"""Read axis files as an `Axis` in SI units, and write an `Axis` as an axis file for the results."""

import math
import re
from contextlib import suppress
from dataclasses import replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from bristle.core import InputError, Readable, located, units
from bristle.core.axis import CHANNELS, Axis, Cogging, Column, Injected, KnownColumn
from bristle.core.motion import Transmission
from bristle.core.variable import Kind, Variable, unit_of
from bristle.files.components import check_schema, controller_from, key_of, number_at, refuse_open
from bristle.files.drive import Constant, Drive, Scale, refuse_misspelt, surroundings_of, with_kind
from bristle.files.schema import AxisFile, ColumnEntry, InjectedEntry, validated
from bristle.files.toml import as_toml, read_toml
from bristle.logs.log import Log

# Key under [controller], beside its gains.
CYCLE, OF_CYCLE = ("cycle", Variable("time", "cycle of the controller"))
PLACES = {
    "table": "log.table",
    "span": "log.span",
    "hold": "effort.hold",
    "periodic": "effort.periodic",
    "lag": "effort.lag",
    "plant": "plant.model",
    "stiffness": "plant.stiffness",
    "damping": "plant.damping",
    "offset": "plant.offset",
    "presliding": "plant.presliding",
    "spring": "plant.spring",
    "delay": "timing.delay",
    "sample_time": "timing.sample_time",
    "velocity_limit": "limits.velocity",
    "acceleration_limit": "limits.acceleration",
    "jerk_limit": "limits.jerk",
    "stroke": "limits.stroke",
    "following_error_limit": "limits.following_error",
    "cutoff": "identification.cutoff",
    "decimation": "identification.decimation",
    "method": "identification.method",
    "loop": "identification.loop",
    "settings": "identification.settings",
}
"""Field of `Axis` that accepts text with a unit -> key in the file."""


def read_axis(path: Readable | dict[str, Any]) -> Axis:
    """Return the axis described by a file.

    Parameters
    ----------
    path : path-like, bytes, file object or dict
        An axis file (TOML), or its tables.

    Returns
    -------
    Axis
        The axis in SI units of its kind, with its controller.

    Raises
    ------
    InputError
        With the file, the key, the value and the allowed values.
    """
    data, source, content = read_toml(path, path="axis", what="an axis or an axis file")
    with located(source):
        return replace(
            axis_from(data, source.absolute().parent), text=content.data if content else b""
        )


def describes_curves(path: Readable | dict[str, Any]) -> bool:
    """Return whether an axis file names the input and output of a hysteresis instead of the channels of an axis."""
    data = read_toml(path).data
    columns = data.get("columns")
    named = (
        isinstance(columns, dict)
        and bool({"input", "output"} & set(columns))
        and "position" not in columns
    )
    return named or data.get("kind") in ("magnetic", "piezo")


def axis_from(data: dict[str, Any], folder: Path = Path()) -> Axis:
    """Return the axis described by the content of an axis file; paths in it refer to its `folder`."""
    check_schema(data)
    refuse_open(data)
    if "joint" in data:
        raise InputError(
            "this axis file describes several joints",
            path="joint",
            mend="Name the axis file of one joint. To predict all, give the results of bristle identify --robot: bristle predict DIR LOG",
        )
    refuse_misspelt(data.get("columns"))
    file = validated(AxisFile, with_kind(data))
    if file.columns.position is None and file.columns.velocity is None:
        raise InputError(
            "is missing",
            path="columns.position",
            mend='Write position = { column = "NAME", unit = "mm" }, or name a velocity column',
        )
    drive = _drive_of(file)
    places = PLACES | {"mass": f"plant.{_mass_of(file)}"}
    raw = {
        name: getattr(getattr(file, place.split(".")[0]), place.split(".")[1])
        for name, place in places.items()
    }
    # Delays that the identification estimates.
    seeks_delay, seeks_lag = (raw["delay"] in (None, "identify"), raw["lag"] == "identify")
    columns = {
        name: _column(name, entry, drive)
        for name in ("time", "position", "velocity", "effort", "reference", "following_error")
        if (entry := getattr(file.columns, name)) is not None
    }
    is_of_rated = drive.rated is not None or (
        drive.constant is not None and drive.constant.drive == "rated"
    )
    # The movement for one radian of the motor is known if the axis is rotational or has a lead.
    is_turned = file.kind == "rotational" or drive.transmission.lead is not None
    rate = _positive(
        file.timing.sample_rate,
        Variable("frequency", "sample rate"),
        file.kind,
        "timing.sample_rate",
    )
    limit, held, hold = file.effort.limit, file.effort.held, file.effort.hold
    _refuse_contradictions(file)
    fields = raw | {
        "name": file.name,
        "kind": file.kind,
        "columns": columns | surroundings_of(file, drive),
        "injected": tuple(
            _injected(entry, file, drive, f"injected[{i}]") for i, entry in enumerate(file.injected)
        ),
        "sample_time": 1.0 / rate if rate else file.timing.sample_time,
        "delay": 0.0 if seeks_delay else raw["delay"],
        "seeks_delay": seeks_delay,
        "resolution": drive.count,
        "effort_limit": None
        if limit is None
        else _above_zero(abs(_effort(limit, file, drive, "effort.limit")), "effort.limit", limit),
        "held": held if hold is None else hold == "zero",
        "lag": 0.0 if seeks_lag else raw["lag"],
        "seeks_lag": seeks_lag,
        "at_rest": file.log.start == "rest",
        "in_cycle": file.log.start == "cycle",
        "pitch": drive.transmission.lead,
        "gear": file.transmission.gear_ratio,
        "arm": drive.transmission.travel("rotational", "motor") if is_turned else None,
        "rated": abs(_effort("100 %", file, drive, "effort.rated")) if is_of_rated else None,
        "keeps_rests": file.identification.rests == "keep",
        "gravity": file.plant.gravity is not None,
        "cogging": _cogging(file, drive.transmission),
        "regressors": _known_columns(file, drive, folder),
    }
    try:
        axis = Axis(**fields)
    except InputError as error:
        name, rest = re.fullmatch(r"(\w+)(.*)", error.path).groups()  # type: ignore[union-attr]
        raise error.at(path=places.get(name, name) + rest) from None
    return _with_controller(axis, file)


def _refuse_contradictions(file: AxisFile) -> None:
    """Refuse two keys that contradict each other, and a gravity that the axis cannot have."""
    if file.timing.sample_rate is not None and file.timing.sample_time is not None:
        raise InputError(
            "has both a sample_time and a sample_rate", path="timing", mend="Keep only one"
        )
    held, hold = file.effort.held, file.effort.hold
    if held is not None and hold is not None and held != (hold == "zero"):
        raise InputError(
            "contradicts the key `held`",
            path="effort.hold",
            value=hold,
            mend="Keep only one of `hold` and `held`",
        )
    if file.plant.gravity is not None and file.kind != "rotational":
        raise InputError(
            "is the gravity of a rotating link, but this axis is translational",
            path="plant.gravity",
            value=file.plant.gravity,
            mend="Remove gravity: bristle identifies the weight on a vertical axis as the constant offset",
        )


def _with_controller(axis: Axis, file: AxisFile) -> Axis:
    """Return the axis with the controller of the file and its cycle."""
    if file.controller is None:
        return axis
    law = {key: value for key, value in file.controller.items() if key != CYCLE}
    axis = replace(
        axis, controller=controller_from(law, kind=axis.kind, axis=axis, path="controller")
    )
    if CYCLE not in file.controller:
        return axis
    place = f"controller.{CYCLE}"
    cycle = _above_zero(
        number_at(file.controller[CYCLE], OF_CYCLE, axis.kind, place), place, file.controller[CYCLE]
    )
    return replace(axis, cycle=cycle)


def _drive_of(file: AxisFile) -> Drive:
    effort, transmission, encoder = file.effort, file.transmission, file.encoder
    keys = [
        key for key in ("force_constant", "torque_constant", "constant") if getattr(effort, key)
    ]
    if len(keys) > 1:
        raise InputError(
            f"has both a {keys[0]} and a {keys[1]}", path="effort", mend="Keep only one"
        )
    constant = None
    if keys:
        spoken_of = {"force_constant": "N", "torque_constant": "N*m"}.get(keys[0])
        constant = Constant.of(
            getattr(effort, keys[0]),
            spoken_of,
            f"effort.{keys[0]}",
            file.columns.effort and file.columns.effort.unit,
        )
    # A suffix may state the base of the quantity, such as one turn.
    lead, raw = (
        text.removesuffix(suffix)
        if (text := "".join(raw.split()) if isinstance(raw, str) else "").endswith(suffix)
        else raw
        for raw, suffix in ((transmission.lead, "/rev"), (encoder.resolution, "/count"))
    )
    lead = _positive(lead, Variable("length", "lead"), "translational", "transmission.lead")
    drive = Drive(
        Transmission(file.kind, transmission.gear_ratio or 1.0, lead), constant, effort.rated
    )
    if raw is not None and encoder.counts_per_rev is not None:
        raise InputError(
            "has both a resolution and counts_per_rev", path="encoder", mend="Keep only one"
        )
    if encoder.counts_per_rev is not None:
        turn = drive.movement("rad", encoder.side, "encoder.counts_per_rev")
        return replace(drive, count=2 * math.pi * turn.factor / encoder.counts_per_rev)
    if raw is None:
        return drive
    path = "encoder.resolution"
    unit = units.split(raw, path)[1] if isinstance(raw, str) else ""
    with located(value=raw):
        count = drive.movement(unit, encoder.side, path).of(str(raw), path) if unit else float(raw)
        return replace(drive, count=_above_zero(count, path, raw))


def _above_zero(value: float, path: str, raw: Any) -> float:
    if not 0 < value < math.inf:
        raise InputError("must be positive and finite", path=path, value=raw, allowed="> 0")
    return value


def _column(name: str, entry: ColumnEntry, drive: Drive) -> Column:
    path = f"columns.{name}.unit"
    if name == "time":
        scale = Scale("s", 1.0)
    elif name == "effort":
        scale = drive.effort(entry.unit, entry.side, path)
    else:
        scale = drive.movement(entry.unit, entry.side, path, per="/s" if name == "velocity" else "")
    if entry.unit is not None:
        units.factor(entry.unit, scale.base, path=path)
    return Column(
        entry.column, entry.unit or "", scale.base, entry.sign * scale.factor, entry.optional
    )


def _injected(entry: InjectedEntry, file: AxisFile, drive: Drive, path: str) -> Injected:
    value = _effort(entry.gain, file, drive, f"{path}.gain")
    units.refuse_absurd(value, f"{path}.gain", entry.gain)
    return Injected(entry.column, value, entry.optional)


def _effort(raw: float | str, file: AxisFile, drive: Drive, path: str) -> float:
    """Return an effort in SI units of the axis; a bare number is in SI units already."""
    unit = units.split(raw, path)[1] if isinstance(raw, str) else ""
    if not unit:
        return float(raw)
    measured_side = file.columns.effort.side if file.columns.effort else None
    side = (
        None
        if units.compatible(unit, "N", path=path)
        else measured_side or ("motor" if drive.constant else None)
    )
    with located(value=raw):
        return drive.effort(unit, side, path).of(str(raw), path)


def _mass_of(file: AxisFile) -> str:
    """Return the key of the mass or inertia; refuse keys that do not fit this kind of axis or plant."""
    right, wrong = ("mass", "inertia") if file.kind == "translational" else ("inertia", "mass")
    if getattr(file.plant, wrong) is not None:
        raise InputError(
            f"does not apply to a {file.kind} axis",
            path=f"plant.{wrong}",
            mend=f"Write {right} instead, in {Variable('mass', 'moving mass').unit(file.kind)}",
        )
    for key in ("stiffness", "damping"):
        raw = getattr(file.plant, key)
        if raw is not None and file.plant.model != "oscillator":
            raise InputError(
                "needs an oscillator as the plant",
                path=f"plant.{key}",
                value=raw,
                mend='Write model = "oscillator" under [plant]',
            )
    return right


def _positive(raw: Any, variable: Variable, kind: Kind, path: str) -> float | None:
    if raw is None:
        return None
    return _above_zero(units.quantity(raw, variable, kind, path=path), path, raw)


def _cogging(file: AxisFile, transmission: Transmission) -> tuple[Cogging, ...]:
    coggings: list[Cogging] = []
    for place, entry in enumerate(file.cogging):
        path = f"cogging[{place}].turn"
        if entry.turn in [term.turner for term in coggings]:
            raise InputError(
                "is defined twice",
                path=path,
                value=entry.turn,
                mend="Write all its harmonics into one [[cogging]] table",
            )
        try:
            turn = (
                2.0
                * math.pi
                * transmission.travel("rotational", "motor" if entry.turn == "motor" else "load")
            )
        except InputError:
            mend = 'Write lead = "10 mm" (and gear_ratio if there is a gear)'
            raise InputError(
                "needs the travel of the axis per turn",
                path=path,
                value=entry.turn,
                mend=f"{mend} under [transmission]",
            ) from None
        harmonics = None if entry.harmonics == "identify" else tuple(sorted(set(entry.harmonics)))
        coggings.append(Cogging(entry.turn, turn, harmonics))
    return tuple(coggings)


def _known_columns(file: AxisFile, drive: Drive, folder: Path) -> tuple[KnownColumn, ...]:
    columns: list[KnownColumn] = []
    for place, entry in enumerate(file.known):
        name = entry.name or re.sub(r"\W+", "_", entry.column).strip("_") or f"column_{place + 1}"
        if name in [column.name for column in columns]:
            raise InputError(
                "is defined twice",
                path=f"known[{place}].name",
                value=name,
                mend="Give each known column a unique name",
            )
        path, given = f"known[{place}]", entry.coefficient
        coefficient = (
            None if given == "identify" else _effort(given, file, drive, f"{path}.coefficient")
        )
        if entry.unit and not units.is_unit(entry.unit):
            raise InputError("is not a unit", path=f"{path}.unit", value=entry.unit)
        table = str(folder / entry.file) if entry.file else ""
        columns.append(
            KnownColumn(
                entry.column, name, entry.optional, entry.unit, coefficient, table, entry.log
            )
        )
    return tuple(columns)


def axis_text(axis: Axis | None, log: Log | None = None) -> bytes | None:
    """Return the text of an axis file for an axis; if the axis names no columns, use the columns of the log and their units."""
    if log is not None and (axis is None or not axis.columns):
        columns = {
            name: Column(channel.column, "", channel.unit)
            for name, channel in log.channels()
            if name in CHANNELS
        }
        injected = tuple(
            Injected(name, 1.0) for name, _ in log.channels() if name.startswith("injected.")
        )
        axis = replace(axis or Axis(kind=log.kind), columns=columns, injected=injected)
    assert axis is not None
    for write in (attrgetter("text"), _text_of):
        with suppress(InputError):
            text = write(axis)
            if text and read_axis(text) == axis:
                return text
    return None


def _text_of(axis: Axis) -> bytes:
    linear, effort, unit = (
        axis.kind == "translational",
        axis.columns.get("effort"),
        unit_of("force", axis.kind),
    )
    # Infinite values keep their default.
    law = {} if axis.controller is None else axis.controller.values
    endless = [
        name for name, value in law.items() if isinstance(value, float) and math.isinf(value)
    ]
    gains = {key_of(name): value for name, value in law.items() if name not in endless}
    values = {place: getattr(axis, name) for name, place in PLACES.items()} | {
        "log.start": "rest" if axis.at_rest else "cycle" if axis.in_cycle else "moving",
        "effort.limit": axis.effort_limit,
        "effort.held": axis.held,
        "effort.lag": "identify" if axis.seeks_lag else axis.lag or None,
        "plant.mass" if linear else "plant.inertia": axis.mass,
        "plant.gravity": "link" if axis.gravity else None,
        "transmission.lead": axis.pitch,
        "encoder.resolution": axis.resolution,
        "timing.delay": None if axis.seeks_delay else axis.delay,
        "identification.rests": "keep" if axis.keeps_rests else None,
    }
    # Converts the unit of its column to a force or a torque.
    if effort is not None and effort.base != unit:
        values["effort.force_constant" if linear else "effort.torque_constant"] = (
            f"{abs(effort.scale)!r} {unit}/{effort.base}"
        )
    document: dict[str, Any] = {
        "schema": 1,
        "name": axis.name,
        "kind": axis.kind,
        "injected": [
            _entry(column, column=column.column, gain=column.gain) for column in axis.injected
        ],
        "known": [_known_entry(column) for column in axis.regressors],
        "cogging": [
            {
                "turn": term.turner,
                "harmonics": "identify" if term.harmonics is None else term.harmonics,
            }
            for term in axis.cogging
        ],
        "columns": {
            name: _entry(
                column,
                column=column.name,
                unit=column.unit or None,
                sign=-1 if column.scale < 0.0 else None,
            )
            for name, column in axis.columns.items()
        },
    }
    for place, value in values.items():
        table, key = place.split(".")
        if value is not None:
            document.setdefault(table, {})[key] = value
    cycle = {} if axis.cycle is None else {CYCLE: axis.cycle}
    document["controller"] = (
        {} if axis.controller is None else {"model": axis.controller.name} | gains | cycle
    )
    filled = {name: value for name, value in document.items() if value not in ({}, [])}
    return ("# The axis of these results, in SI units.\n" + as_toml(filled)).encode(
        "utf-8", "backslashreplace"
    )


def _known_entry(known: KnownColumn) -> dict[str, Any]:
    optional = {
        "unit": known.unit or None,
        "coefficient": known.coefficient,
        "file": known.file or None,
        "log": known.log or None,
    }
    return _entry(known, column=known.column, name=known.name, **optional)


def _entry(column: Column | Injected | KnownColumn, /, **keys: Any) -> dict[str, Any]:
    """Return the entry of a column; factors other than its unit are in other tables."""
    return {key: value for key, value in keys.items() if value is not None} | (
        {"optional": True} if column.optional else {}
    )
