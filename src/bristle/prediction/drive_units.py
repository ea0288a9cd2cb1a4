"""The units of a drive and its log, for values to enter there instead of SI."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from bristle.core import Axis, Column, factor
from bristle.core.dimensions import exponents_of
from bristle.core.variable import Kind, unit_of

RPM = 2.0 * math.pi / 60.0  # rad/s
FEED = 1e-3 / 60.0  # m/s for a mm/min, the unit of numerical controls
NEARLY = 1e-9


class DriveUnit(NamedTuple):
    """A unit: its name, and its size in SI units of the axis."""

    name: str
    si: float

    def of(self, value: float) -> float:
        """Return a value in SI units of the axis in this unit."""
        return value / self.si


class LogUnits(NamedTuple):
    """The units of the columns of a log: of velocity, and of effort."""

    velocity: DriveUnit
    effort: DriveUnit


class TableUnits(NamedTuple):
    """The units of a file for a drive: those of the log, those of the drive if they differ, and all units of effort."""

    log: LogUnits
    drive: LogUnits | None
    efforts: tuple[DriveUnit, ...]
    inertias: tuple[DriveUnit, ...]


class DriveUnits(NamedTuple):
    """The units of speed, effort, inertia and distance of the drive of an axis, besides SI of the axis."""

    axis: Axis | None
    kind: Kind
    velocities: tuple[DriveUnit, ...]
    efforts: tuple[DriveUnit, ...]
    inertias: tuple[DriveUnit, ...]
    lengths: tuple[DriveUnit, ...]

    def of(self, quantity: str) -> tuple[DriveUnit, ...]:
        """Return the units of a parameter in the log and at the motor, besides SI."""
        powers = dict(exponents_of(quantity))
        force, length, time = (powers.pop(name, 0.0) for name in ("force", "length", "time"))
        if self.axis is None or powers or (force, length) == (0.0, 0.0):
            return ()
        simple = {
            (1.0, 0.0, 0.0): _of_other_sizes(self.efforts),
            (1.0, -1.0, 2.0): self.inertias,
            (0.0, 1.0, -1.0): _of_other_sizes(self.velocities),
            (0.0, 1.0, 0.0): self.lengths,
        }
        units = simple.get((force, length, time))
        if units is None:
            return _of_other_sizes(_products(self, self.axis, force, length, time))
        return units


def log_units(axis: Axis | None, kind: Kind) -> LogUnits:
    """Return the units of the columns of the logs of an axis; SI without an axis file."""
    length = _column_unit(axis, "position", "length", kind)
    effort = _column_unit(axis, "effort", "force", kind)
    if axis is not None and "velocity" in axis.columns:
        velocity = _column_unit(axis, "velocity", "length/time", kind)
    else:
        velocity = DriveUnit(f"{length.name}/s", length.si)
    return LogUnits(velocity, effort)


def column_signs(axis: Axis | None) -> tuple[float, float]:
    """Return the signs of the columns of velocity and of effort relative to the axis; 1 without an axis file."""
    if axis is None:
        return 1.0, 1.0
    moving = axis.columns.get("velocity") or axis.columns.get("position")
    return _sign_of(moving), _sign_of(axis.columns.get("effort"))


def _sign_of(column: Column | None) -> float:
    if column is None:
        return 1.0
    return math.copysign(1.0, column.scale)


class CommandUnits(NamedTuple):
    """The units of the command of a drive: of position and effort, with the signs of the columns, and others."""

    position: DriveUnit
    effort: DriveUnit
    others: tuple[DriveUnit, ...]


def command_units(axis: Axis | None, kind: Kind) -> CommandUnits | None:
    """Return the units of the command of a drive: those of its log, if they differ from SI of the axis."""
    efforts = drive_units(axis, kind).efforts
    if axis is None or not efforts:
        return None
    moving, pushing = column_signs(axis)
    own = _column_unit(axis, "position", "length", kind)
    logged = "effort" in axis.columns and efforts[0].name == log_units(axis, kind).effort.name
    # A drive counts effort in the direction of positions; a column of the log may be against both.
    signed = [unit._replace(si=moving * unit.si) for unit in efforts]
    if logged:
        signed[0] = efforts[0]._replace(si=pushing * efforts[0].si)
    return CommandUnits(own._replace(si=moving * own.si), signed[0], tuple(signed[1:]))


def signed_units(axis: Axis | None, kind: Kind) -> tuple[DriveUnit, DriveUnit]:
    """Return the units of position and effort in the logs of an axis, with the signs of their columns."""
    moving, pushing = column_signs(axis)
    position = _column_unit(axis, "position", "length", kind)
    effort = _column_unit(axis, "effort", "force", kind)
    return position._replace(si=moving * position.si), effort._replace(si=pushing * effort.si)


def drive_units(axis: Axis | None, kind: Kind) -> DriveUnits:
    """Return the possible units of the drive of this axis: those of its log, of its motor, percent of rated."""
    if axis is None:
        return DriveUnits(None, kind, (), (), (), ())
    own = log_units(axis, kind)
    arm = axis.arm
    geared = arm is not None and (kind == "translational" or abs(arm - 1.0) > NEARLY)
    velocities = _besides_si([own.velocity], unit_of("length/time", kind))
    efforts = []
    inertias = []
    if not axis.rated or own.effort.name != "%":
        efforts += _besides_si([own.effort], unit_of("force", kind))
    if arm is not None:
        velocities.append(DriveUnit("rpm of the motor", RPM * arm))
    if arm is not None and geared:
        efforts.append(DriveUnit("N*m at the motor", 1.0 / arm))
        inertias.append(DriveUnit("kg*m^2 at the motor", 1.0 / arm**2))
    if axis.rated:
        efforts.append(DriveUnit("% of rated", 0.01 * axis.rated))
    return DriveUnits(
        axis, kind, tuple(velocities), tuple(efforts), tuple(inertias), length_units(axis, kind)
    )


def table_units(axis: Axis | None, kind: Kind) -> TableUnits:
    """Return the units of a file for the drive of an axis: those of its log, and other possible units."""
    own = log_units(axis, kind)
    more = drive_units(axis, kind)
    velocities = [own.velocity]
    if axis is not None and kind == "translational":
        velocities.append(DriveUnit("mm/min", FEED))
    velocities = _of_other_sizes((*velocities, *more.velocities))
    efforts = _of_other_sizes((own.effort, *more.efforts))
    drive = LogUnits(
        velocities[-1], next((unit for unit in efforts if "%" in unit.name), efforts[-1])
    )
    if drive == own:
        drive = None
    return TableUnits(own, drive, efforts, (DriveUnit(unit_of("mass", kind), 1.0), *more.inertias))


def length_units(axis: Axis | None, kind: Kind) -> tuple[DriveUnit, ...]:
    """Return the units of a distance, besides SI: that of the position in the log, degrees of the motor."""
    if axis is None:
        return ()
    units = _besides_si([_column_unit(axis, "position", "length", kind)], unit_of("length", kind))
    if axis.arm is not None:
        units.append(DriveUnit("deg of the motor", math.radians(1.0) * axis.arm))
    return _of_other_sizes(units)


def _products(
    drive: DriveUnits, axis: Axis, force: float, length: float, time: float
) -> tuple[DriveUnit, ...]:
    """Return the units of a product: effort and position of the log; percent of rated, or torque, and turns of the motor."""
    kind = drive.kind
    own = log_units(axis, kind)
    if length == -time and length != 0.0:
        # A product with length and time contains a speed, as viscous friction does: in rpm of the motor.
        motions = drive.velocities
        logged = own.velocity
        rest = 0.0
        in_si = unit_of("force", kind), unit_of("length/time", kind)
    else:
        motions = drive.lengths
        logged = DriveUnit(unit_of("length", kind), 1.0)
        if motions:
            logged = motions[0]
        rest = time
        in_si = unit_of("force", kind), unit_of("length", kind)
    pairs = [(own.effort, logged)]
    if axis.arm is not None:
        effort = own.effort
        if drive.efforts:
            effort = drive.efforts[-1]
        pairs.append((effort, motions[-1]))
    products = [_product(pair, (force, length, rest)) for pair in pairs]
    return tuple(
        unit
        for unit, pair in zip(products, pairs, strict=True)
        if (pair[0].name, pair[1].name) != in_si
    )


def _product(pair: tuple[DriveUnit, DriveUnit], powers: tuple[float, float, float]) -> DriveUnit:
    """Return a product of units, shortened: ``%/rpm`` is percent of rated per turn a minute of the motor."""
    short = [
        unit.name.removesuffix(" of rated")
        .removesuffix(" of the motor")
        .removesuffix(" at the motor")
        for unit in pair
    ]
    names = [f"({name})" if set(name) & set("/*") else name for name in short] + ["s"]
    over = []
    under = []
    for name, power in zip(names, powers, strict=True):
        raised = name
        if abs(power) != 1.0:
            raised = f"{name}^{abs(power):g}"
        if power > 0.0:
            over.append(raised)
        elif power < 0.0:
            under.append(raised)
    alone = "*".join(over) or "1"
    if over == names[:1]:
        alone = over[0].strip("()")
    return DriveUnit("/".join([alone, *under]), pair[0].si ** powers[0] * pair[1].si ** powers[1])


def _of_other_sizes(listed: Sequence[DriveUnit]) -> tuple[DriveUnit, ...]:
    """Return units without those of the same size as an earlier unit: the same under another name."""
    sizes: list[DriveUnit] = []
    for unit in listed:
        if not any(math.isclose(unit.si, earlier.si, rel_tol=NEARLY) for earlier in sizes):
            sizes.append(unit)
    return tuple(sizes)


def _column_unit(axis: Axis | None, column: str, quantity: str, kind: Kind) -> DriveUnit:
    """Return the unit of a column of the logs of an axis; SI without such a unit."""
    if axis is None or column not in axis.columns:
        return DriveUnit(unit_of(quantity, kind), 1.0)
    own = axis.columns[column]
    name = own.unit or own.base
    return DriveUnit(name, abs(own.scale) * factor(name, own.base))


def _besides_si(own: Sequence[DriveUnit], si: str) -> list[DriveUnit]:
    return [unit for unit in own if unit.name != si]
