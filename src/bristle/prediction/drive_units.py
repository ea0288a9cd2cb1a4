"""The units that a drive and its log count in: what is typed in is wanted in these, and not in SI of the axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from bristle.core import units
from bristle.core.axis import Axis, Column
from bristle.core.variable import Kind, unit_of

__all__ = ["DriveUnit", "DriveUnits", "LogUnits", "drive_units", "log_units"]

RPM = 2.0 * math.pi / 60.0  # rad/s
NEARLY = 1e-9


class DriveUnit(NamedTuple):
    """A unit: what it is called, and what one of it is in SI of the axis."""

    name: str
    si: float

    def of(self, value: float) -> float:
        """Return a value in SI of the axis in this unit."""
        return value / self.si


class LogUnits(NamedTuple):
    """The units of the columns of a log: of velocity, and of effort."""

    velocity: DriveUnit
    effort: DriveUnit


class DriveUnits(NamedTuple):
    """The units in which a drive may want speed, effort and inertia, besides SI of the axis."""

    velocities: tuple[DriveUnit, ...]
    efforts: tuple[DriveUnit, ...]
    inertias: tuple[DriveUnit, ...]


def log_units(axis: Axis | None, kind: Kind) -> LogUnits:
    """Return the units of the columns of the logs of an axis; SI where there is no axis file.

    Parameters
    ----------
    axis : Axis or None
        Its columns.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    columns = {} if axis is None else axis.columns
    length = _own(columns["position"]) if "position" in columns else DriveUnit(unit_of("length", kind), 1.0)
    effort = _own(columns["effort"]) if "effort" in columns else DriveUnit(unit_of("force", kind), 1.0)
    return LogUnits(DriveUnit(f"{length.name}/s", length.si), effort)


def drive_units(axis: Axis | None, kind: Kind) -> DriveUnits:
    """Return the units that a drive of this axis may want: those of its log, of its motor, percent of rated.

    Parameters
    ----------
    axis : Axis or None
        Its columns, its transmission (`arm`), its rated effort.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    if axis is None:
        return DriveUnits((), (), ())
    own, arm = log_units(axis, kind), axis.arm
    geared = arm is not None and (kind == "translational" or abs(arm - 1.0) > NEARLY)
    motor = [DriveUnit("rpm of the motor", RPM * arm)] if arm is not None else []
    torque = [DriveUnit("N*m at the motor", 1.0 / arm)] if arm is not None and geared else []
    rated = [DriveUnit("% of rated", 0.01 * axis.rated)] if axis.rated else []
    inertia = [DriveUnit("kg*m^2 at the motor", 1.0 / arm**2)] if arm is not None and geared else []
    percent = bool(rated) and own.effort.name == "%"
    return DriveUnits(
        (*_besides_si([own.velocity], unit_of("length/time", kind)), *motor),
        (*([] if percent else _besides_si([own.effort], unit_of("force", kind))), *torque, *rated), tuple(inertia),
    )  # fmt: skip


def _own(column: Column) -> DriveUnit:
    name = column.unit or column.base
    return DriveUnit(name, abs(column.scale) * units.factor(name, column.base))


def _besides_si(own: Sequence[DriveUnit], si: str) -> list[DriveUnit]:
    return [unit for unit in own if unit.name != si]
