"""`read_axis`: what a person wrote of an axis, as an `Axis` in SI."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from bristle.core import units
from bristle.core.axis import Axis, Column, Injected
from bristle.core.content import Readable
from bristle.core.errors import InputError
from bristle.core.motion import Transmission
from bristle.core.variable import Kind, Variable
from bristle.files.components import check_schema, refuse_open
from bristle.files.controller import controller_of
from bristle.files.drive import Constant, Drive, Scale, refuse_misspelt, surroundings_of, with_kind
from bristle.files.plant_terms import terms_of
from bristle.files.schema import AxisFile, ColumnEntry, EncoderEntry, InjectedEntry, validated
from bristle.files.toml import read_toml

TIME = Variable("time", "time")
SOUGHT = (None, "identify")  # a delay that an identification is to find
FREQUENCY = Variable("frequency", "frequency")
MASS = Variable("mass", "moving mass")
FORCE = Variable("force", "force")
VELOCITY = Variable("length/time", "velocity")
ACCELERATION = Variable("length/time^2", "acceleration")
JERK = Variable("length/time^3", "jerk")
LENGTH = Variable("length", "position")
STIFFNESS = Variable("force/length", "stiffness to the ground")
DAMPING = Variable("force*time/length", "damping to the ground")


def read_axis(path: Readable | dict[str, Any]) -> Axis:
    """Return the axis that a file describes.

    Parameters
    ----------
    path : path-like, bytes, file object or dict
        An axis file, TOML, or the tables that one would hold.

    Returns
    -------
    Axis
        In SI of its kind, its controller resolved.

    Raises
    ------
    InputError
        With file, key, value and what is allowed there.
    """
    data, source, content = read_toml(path, path="axis", what="an axis or its file")
    try:
        return replace(axis_from(data), text=content.data if content else b"")
    except InputError as error:
        raise error.at(str(source)) from None


def axis_from(data: dict[str, Any]) -> Axis:
    """Return the axis that the content of an axis file describes."""
    check_schema(data)
    refuse_open(data)
    refuse_misspelt(data.get("columns"))
    file = validated(AxisFile, with_kind(data))
    if file.columns.position is None and file.columns.velocity is None:
        raise InputError("is missing", path="columns.position", mend='Write position = { column = "NAME", unit = "mm" }, or velocity alone')
    drive = _drive_of(file)
    columns = {
        name: _column(name, entry, drive)
        for name in ("time", "position", "velocity", "effort", "reference", "following_error")
        if (entry := getattr(file.columns, name)) is not None
    } | surroundings_of(file)
    axis = Axis(
        name=file.name,
        kind=file.kind,
        columns=columns,
        injected=tuple(_injected(entry, file, drive, f"injected[{i}]") for i, entry in enumerate(file.injected)),
        table=file.log.table,
        sample_time=_sample_time(file),
        delay=0.0 if file.timing.delay in SOUGHT else units.quantity(file.timing.delay, TIME, path="timing.delay"),
        seeks_delay=file.timing.delay in SOUGHT,
        mass=_mass(file),
        plant=file.plant.model,
        stiffness=_of_oscillator(file, "stiffness", STIFFNESS),
        damping=_of_oscillator(file, "damping", DAMPING),
        offset=_offset(file),
        resolution=drive.count,
        effort_limit=_limit(file, drive),
        held=_held(file),
        hold=file.effort.hold,
        lag=_lag(file),
        seeks_lag=file.effort.lag == "identify",
        periodic=file.effort.periodic,
        at_rest=file.log.start == "rest",
        in_cycle=file.log.start == "cycle",
        span=_span(file),
        velocity_limit=_positive(file.limits.velocity, VELOCITY, file.kind, "limits.velocity"),
        acceleration_limit=_positive(file.limits.acceleration, ACCELERATION, file.kind, "limits.acceleration"),
        jerk_limit=_positive(file.limits.jerk, JERK, file.kind, "limits.jerk"),
        stroke=_stroke(file),
        pitch=drive.transmission.lead,
        arm=_arm(drive),
        rated=_rated(file, drive),
        presliding=_positive(file.plant.presliding, LENGTH, file.kind, "plant.presliding"),
        cutoff=_positive(file.identification.cutoff, FREQUENCY, file.kind, "identification.cutoff"),
        decimation=file.identification.decimation,
        keeps_rests=file.identification.rests == "keep",
        method=file.identification.method,
        loop=file.identification.loop,
        global_search=file.identification.global_search,
        settings=_thresholds(file),
        **terms_of(file, drive.transmission),
    )
    return replace(axis, controller=controller_of(file.controller, axis))


def _thresholds(file: AxisFile) -> dict[str, float]:
    thresholds, number = file.identification.settings, Variable("1", "threshold")
    return {name: units.quantity(threshold, number, path=f"identification.settings.{name}") for name, threshold in thresholds.items()}


def _drive_of(file: AxisFile) -> Drive:
    effort, transmission = file.effort, file.transmission
    given = [key for key in ("force_constant", "torque_constant", "constant") if getattr(effort, key)]
    if len(given) > 1:
        raise InputError(f"has both a {given[0]} and a {given[1]}", path="effort", mend="Keep one of them")
    constant = Constant.whichever(effort.constant, "effort.constant") if effort.constant else None
    if effort.force_constant:
        constant = Constant.of(effort.force_constant, "N", "effort.force_constant")
    if effort.torque_constant:
        constant = Constant.of(effort.torque_constant, "N*m", "effort.torque_constant")
    lead = _positive(_without(transmission.lead, "/rev"), LENGTH, "translational", "transmission.lead")
    drive = Drive(Transmission(file.kind, transmission.gear_ratio or 1.0, lead), constant, effort.rated)
    return replace(drive, count=_resolution(file.encoder, drive))


def _arm(drive: Drive) -> float | None:
    """Return the movement of the axis for one radian of the motor; None where nothing tells it."""
    train = drive.transmission
    return None if train.kind == "translational" and train.lead is None else train.travel("rotational", "motor")


def _rated(file: AxisFile, drive: Drive) -> float | None:
    """Return the effort on the axis at 100 % of rated [N or N*m]; None where nothing tells it."""
    if drive.rated is None and (drive.constant is None or drive.constant.drive != "rated"):
        return None
    return abs(_effort("100 %", file, drive, "effort.rated"))


def _resolution(encoder: EncoderEntry, drive: Drive) -> float | None:
    """Return the movement of the axis for one count [m or rad]."""
    path, raw = "encoder.resolution", _without(encoder.resolution, "/count")
    if raw is not None and encoder.counts_per_rev is not None:
        raise InputError("has both a resolution and counts_per_rev", path="encoder", mend="Keep one of them")
    if encoder.counts_per_rev is not None:
        turn = drive.movement("rad", encoder.side, "encoder.counts_per_rev")
        return 2 * math.pi * turn.factor / encoder.counts_per_rev
    if raw is None:
        return None
    unit = units.split(raw, path)[1] if isinstance(raw, str) else ""
    if not unit:
        return _above_zero(float(raw), path, raw)
    count = _in(raw, lambda: drive.movement(unit, encoder.side, path).of(str(raw), path))
    return _above_zero(count, path, raw)


def _without(raw: Any, suffix: str) -> Any:
    """Leave out what a quantity is told for, such as one turn."""
    short = "".join(raw.split()) if isinstance(raw, str) else ""
    return short.removesuffix(suffix) if short.endswith(suffix) else raw


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
    return Column(entry.column, entry.unit or "", scale.base, entry.sign * scale.factor, entry.optional)


def _injected(entry: InjectedEntry, file: AxisFile, drive: Drive, path: str) -> Injected:
    gain: Any = entry.gain
    if entry.unit is not None:
        if isinstance(gain, str):
            raise InputError("has a unit, and so has `gain`", path=f"{path}.unit", mend="Keep one of them")
        gain = f"{gain!r} {entry.unit}"
    value = _effort(gain, file, drive, f"{path}.gain")
    units.refuse_absurd(value, f"{path}.gain", gain)
    return Injected(entry.column, value, entry.optional)


def _limit(file: AxisFile, drive: Drive) -> float | None:
    raw = file.effort.limit
    if raw is None:
        return None
    return _above_zero(abs(_effort(raw, file, drive, "effort.limit")), "effort.limit", raw)


def _held(file: AxisFile) -> bool | None:
    held, hold = file.effort.held, file.effort.hold
    if held is not None and hold is not None and held != (hold == "zero"):
        raise InputError("contradicts `held`", path="effort.hold", value=hold, mend="Keep one of them")
    return held if hold is None else hold == "zero"


def _lag(file: AxisFile) -> float:
    raw = file.effort.lag
    if raw == "identify":
        return 0.0
    value = units.quantity(raw, TIME, path="effort.lag")
    if value < 0.0:
        raise InputError("must not be negative", path="effort.lag", value=raw, allowed='a time, or "identify"')
    return value


def _effort(raw: float | str, file: AxisFile, drive: Drive, path: str) -> float:
    """Return an effort in SI of the axis, from any unit that its column may have; a bare number is SI already."""
    unit = units.split(raw, path)[1] if isinstance(raw, str) else ""
    if not unit:
        return float(raw)
    measured_side = file.columns.effort.side if file.columns.effort else None
    side = None if units.compatible(unit, "N", path=path) else measured_side or ("motor" if drive.constant else None)
    return _in(raw, lambda: drive.effort(unit, side, path).of(str(raw), path))


def _in(raw: Any, converted: Callable[[], float]) -> float:
    """Return a converted value; what is refused is told as it was written, not as its unit."""
    try:
        return converted()
    except InputError as error:
        raise InputError(error.message, path=error.path, value=raw, allowed=error.allowed, mend=error.mend) from None


def _sample_time(file: AxisFile) -> float | None:
    rate = _positive(file.timing.sample_rate, FREQUENCY, file.kind, "timing.sample_rate")
    if rate is not None and file.timing.sample_time is not None:
        raise InputError("has both a sample_time and a sample_rate", path="timing", mend="Keep one of them")
    return 1.0 / rate if rate else _positive(file.timing.sample_time, TIME, file.kind, "timing.sample_time")


def _mass(file: AxisFile) -> float | None:
    right, wrong = ("mass", "inertia") if file.kind == "translational" else ("inertia", "mass")
    if getattr(file.plant, wrong) is not None:
        raise InputError(f"is not what a {file.kind} axis has", path=f"plant.{wrong}", mend=f"Write {right} in {MASS.unit(file.kind)}")
    return _positive(getattr(file.plant, right), MASS, file.kind, f"plant.{right}")


def _of_oscillator(file: AxisFile, key: str, variable: Variable) -> float | None:
    raw = getattr(file.plant, key)
    if raw is not None and file.plant.model != "oscillator":
        raise InputError("belongs to an oscillator", path=f"plant.{key}", value=raw, mend='Write model = "oscillator" under [plant]')
    return _positive(raw, variable, file.kind, f"plant.{key}")


def _offset(file: AxisFile) -> float | str:
    raw = file.plant.offset
    if raw == "identify":
        return raw
    try:
        return units.quantity(raw, FORCE, file.kind, path="plant.offset")
    except InputError as error:
        allowed = f'"identify", or a value in {FORCE.unit(file.kind)}'
        raise InputError(error.message, path=error.path, value=raw, allowed=allowed, mend=error.mend) from None


def _span(file: AxisFile) -> tuple[float, float] | None:
    """Return from when to when the log is used [s]."""
    raw = file.log.span
    if raw is None:
        return None
    first, last = (units.quantity(time, TIME, path=f"log.span[{i}]") for i, time in enumerate(raw))
    if first >= last:
        raise InputError("must rise", path="log.span", value=raw, allowed="[first, last time]")
    return first, last


def _stroke(file: AxisFile) -> tuple[float, float] | None:
    if file.limits.stroke is None:
        return None
    low, high = (units.quantity(end, LENGTH, file.kind, path=f"limits.stroke[{i}]") for i, end in enumerate(file.limits.stroke))
    if low >= high:
        raise InputError("must rise", path="limits.stroke", value=file.limits.stroke, allowed="[smallest, largest position]")
    return low, high


def _positive(raw: Any, variable: Variable, kind: Kind, path: str) -> float | None:
    if raw is None:
        return None
    return _above_zero(units.quantity(raw, variable, kind, path=path), path, raw)


def _above_zero(value: float, path: str, raw: Any) -> float:
    if not 0 < value < math.inf:
        raise InputError("must be positive and finite", path=path, value=raw, allowed="> 0")
    return value
