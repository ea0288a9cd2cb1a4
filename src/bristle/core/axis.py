"""`Axis`: known data of a motion axis before the identification."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bristle.core.edge import (
    FLAG,
    KIND,
    TEXT,
    among,
    amount,
    guarded,
    instance,
    many,
    mapping,
    model,
    optional,
    rising,
    taken,
    whole,
)
from bristle.core.errors import InputError, located
from bristle.core.motion import RECORDED
from bristle.core.tabular import SIGNALS
from bristle.core.values import shown
from bristle.core.variable import KINDS, Kind, Variable

CHANNELS = {
    name: SIGNALS[name].quantity
    for name in ("time", "position", "velocity", "effort", "reference", *RECORDED)
}
"""Channel of a log -> generalised quantity."""
COLUMNS = CHANNELS | {"following_error": "length"}
"""Allowed columns: a channel, or the following error, which gives the reference together with the position."""
LOAD_ENCODER, COUPLING_EFFORT = "load_position", "coupling_effort"
OF_COUPLING = {LOAD_ENCODER: "length", COUPLING_EFFORT: "force"}
"""Further channel of an elastic coupling -> quantity: second encoder at the load, sensor of torque or force behind the motor."""

_NUMBER = amount(Variable("1", "factor"))
_COEFFICIENT = optional(_NUMBER)


def _flag(*, default: bool = False) -> Any:
    return taken(FLAG, default)


DELAY = Variable("time", "delay of the effort", min=-10.0, max=10.0)


def _positive(quantity: str, meaning: str, **options: Any) -> Any:
    return taken(
        optional(amount(Variable(quantity, meaning, min=0.0), exclusive=True)), None, **options
    )


def _pair(quantity: str, meaning: str, *, endless: bool = False) -> Any:
    return taken(optional(rising(amount(Variable(quantity, meaning), endless=endless))), None)


def _offset(value: Any, path: str, kind: Kind | None) -> float | str:
    if isinstance(value, str) and value == "identify":
        return value
    variable = Variable("force", "constant part of the friction force")
    with located(allowed=f'"identify", or a value in {variable.unit(kind or KINDS[0])}'):
        return amount(variable)(value, path, kind)


@guarded()
@dataclass(frozen=True)
class Column:
    """A column of a log, and the conversion of its numbers to SI units of the axis.

    Parameters
    ----------
    name : str
        Name in the log.
    unit : str
        Unit of the numbers in the log; empty if the log states it.
    base : str
        Unit to which `scale` applies: ``"V"`` for a controller output, ``"rad"`` for the encoder of a motor.
    scale : float
        Value in SI units of the axis for one `base`, including sign, drive constants and transmission.
    optional : bool
        Whether a log may lack this column.
    shift : float
        Offset added after scaling, for temperatures.
    """

    name: str = taken(TEXT)
    unit: str = taken(TEXT)
    base: str = taken(TEXT)
    scale: float = taken(_NUMBER, 1.0)
    optional: bool = _flag()
    shift: float = taken(_NUMBER, 0.0)


def _columns(columns: Any, path: str, kind: Kind | None) -> dict[str, Column]:
    """Check the columns by channel; a further channel for a user slot must be a word with a unit."""
    columns = mapping(instance(Column, "an object of class Column"))(columns, path, kind)
    for name, column in columns.items():
        if name not in COLUMNS and not (
            isinstance(name, str) and name.isidentifier() and (column.base or column.shift)
        ):
            raise InputError(
                "has an unknown name",
                path=path,
                value=shown(name),
                allowed=f"{', '.join(COLUMNS)}, or a further channel with a unit",
            )
    return columns


@guarded()
@dataclass(frozen=True)
class Injected:
    """A known input added to the controller's output.

    Parameters
    ----------
    column : str
        Name in the log.
    gain : float
        `column` times `gain` is an effort in SI.
    optional : bool
        Whether a log may lack this column.
    """

    column: str = taken(TEXT)
    gain: float = taken(_NUMBER)
    optional: bool = _flag()


@guarded()
@dataclass(frozen=True)
class KnownColumn:
    """A column of a log, or of a second table, whose product with a coefficient is an effort.

    Parameters
    ----------
    column : str
        Name in the log or in the second table.
    name : str
        Suffix of the name of the coefficient: ``known_NAME``.
    optional : bool
        Whether a log may lack the column; bristle then uses zeros.
    unit : str
        Unit of the column to which the coefficient refers; empty for the unit in the log.
    coefficient : float or None
        Effort for 1 `unit` of the column [N or N*m]; None to identify it.
    file : str
        Path of the second table, which has a column of time; empty if the log itself holds the column.
    log : str
        SHA-256 of the only log to which the second table belongs; empty for any log.
    """

    column: str = taken(TEXT)
    name: str = taken(TEXT)
    optional: bool = _flag()
    unit: str = taken(TEXT, "")
    coefficient: float | None = taken(_COEFFICIENT, None)
    file: str = taken(TEXT, "")
    log: str = taken(TEXT, "")

    @property
    def place(self) -> str:
        """Name of the column among those of the log: a column of a second table has the name of its file before it."""
        return f"{Path(self.file).stem}.{self.column}" if self.file else self.column


@guarded()
@dataclass(frozen=True)
class Cogging:
    """Efforts that repeat an integral number of times per turn, equal in both directions.

    Parameters
    ----------
    turner : {"motor", "screw"}
        The rotating part.
    turn : float
        Movement of the axis per turn of the part that causes the effort [m or rad].
    harmonics : tuple of int or None
        Periods per turn; None to identify them from the log.
    """

    turner: str = taken(among("motor", "screw"))
    turn: float = taken(amount(Variable("length", "movement for one turn", min=1e-12)))
    harmonics: tuple[int, ...] | None = taken(optional(many(whole(1, 10_000), single=True)), None)


@guarded()
@dataclass(frozen=True)
class Axis:
    """A motion axis, in SI units (m, N, kg or rad, N*m, kg*m^2).

    Parameters
    ----------
    name : str
        Name of the axis.
    kind : {"translational", "rotational"}
        Decides the units: m, N, kg or rad, N*m, kg*m^2.
    columns : mapping of str to Column
        Channel (``time``, ``position``, ``velocity``, ``effort``, ``reference``, ``load``, ``temperature``, and
        further channels for user slots), mapped to the column of the log.
    injected : tuple of Injected
        Known inputs of the loop.
    table : str or None
        Table, group or array in a log file that has several of them.
    sample_time : float or None
        Sample time of a log without a time column [s].
    delay : float
        Delay of the effort column relative to the position column [s].
    seeks_delay : bool
        Whether the identification estimates an additional delay; otherwise only `delay` is compensated.
    mass : float or None
        Moving mass [kg] or inertia [kg*m^2], where known.
    plant : str
        The plant: ``inertia``, or ``oscillator`` with a spring and a damper to the ground.
    stiffness : float or None
        Stiffness of the oscillator, where known [N/m or N*m/rad].
    damping : float or None
        Damping of the oscillator, where known [N*s/m or N*m*s/rad].
    offset : float or "identify"
        Constant part of the friction force (gravity, bias).
    resolution : float or None
        Smallest step of the position encoder [m or rad].
    effort_limit : float or None
        Saturation of the effort [N or N*m].
    held : bool or None
        Whether each value of the effort acts until the next sample, as with a sampled controller; None (unknown) counts
        as no.
    hold : {"zero", "linear", "band_limited"} or None
        Interpolation of the effort between samples in a simulation; None is a zero-order hold.
    lag : float
        Time constant with which the drive follows its controller [s], in simulated loops.
    seeks_lag : bool
        Whether an identification of the closed loop estimates `lag`.
    periodic : bool or None
        Whether each log is an integral number of periods of a repeating motion; None to detect it from the log.
    in_cycle : bool
        Whether the log begins within a repeating motion, so that the memory of the contact has run in.
    span : tuple of float or None
        First and last time of the used part of the log, in the time of the log [s].
    at_rest : bool
        Whether each log begins at rest and relaxed. A periodic log may have run in from this state.
    velocity_limit : float or None
        Largest velocity [m/s or rad/s].
    acceleration_limit : float or None
        Largest acceleration [m/s^2 or rad/s^2].
    jerk_limit : float or None
        Largest jerk [m/s^3 or rad/s^3].
    stroke : tuple of float or None
        Smallest and largest position [m or rad].
    following_error_limit : float or None
        Largest following error [m or rad].
    controller : Model or None
        The control law of the loop in which the log was recorded.
    cycle : float or None
        Cycle of this controller [s]; by default the sample time of the log.
    pitch : float or None
        Movement of the axis per turn of the motor [m or rad], for an axis with a known transmission.
    rated : float or None
        Effort on the axis at 100 % of rated [N or N*m]; None if unknown.
    arm : float or None
        Movement of the axis per radian of the motor [m or rad], for an axis with a known transmission: gains may refer to
        the motor.
    gear : float or None
        Turns of the motor per turn behind the gear, if the axis file states them.
    presliding : float or None
        Distance over which friction changes its sign at a reversal [m or rad], if known, for the simulation of static
        friction models.
    cutoff : float or None
        Cut-off frequency of the zero-phase filter of the identification [Hz].
    decimation : int or None
        Decimation factor of the filtered samples in the identification.
    keeps_rests : bool
        Whether the identification keeps samples at rest. This is useful if a force sensor at the contact measures the
        friction, because a model with pre-sliding predicts the friction at rest, too.
    method : {"prediction_error", "inverse_dynamics", "output_error"}
        Objective of the identification. ``inverse_dynamics``: the error of the effort along the measured motion.
        ``prediction_error``: first as ``inverse_dynamics``; then, for the best model with pre-sliding, the error of an
        observer that predicts the next position from the measured effort. ``output_error``: the error of a simulation:
        of the position in open loop, of the controller effort in closed loop.
    loop : {"open", "closed"} or None
        Loop in a simulation of the axis; None selects the closed loop if controller and reference are known.
    settings : mapping of str to float
        Thresholds of an identification that differ from their defaults, by name.
    text : bytes
        Content of the axis file, or empty.
    gravity : bool
        Whether the axis rotates a link under gravity.
    spring : {"linear", "cubic"} or None
        Force of a spring (linear) or a cable (cubic) over the position.
    cogging : tuple of Cogging
        Periodic efforts per turn of motor or screw.
    regressors : tuple of KnownColumn
        Known columns, with identified or given coefficients.
    """

    name: str = taken(TEXT, "axis")
    kind: Kind = taken(KIND, "translational")
    columns: Mapping[str, Column] = taken(_columns, default_factory=dict)
    injected: tuple[Injected, ...] = taken(many(instance(Injected, "an Injected"), single=True), ())
    table: str | None = taken(optional(TEXT), None)
    sample_time: float | None = _positive("time", "sample time")
    delay: float = taken(amount(DELAY), 0.0)
    seeks_delay: bool = _flag(default=True)
    mass: float | None = _positive("mass", "moving mass or inertia")
    plant: str = taken(among("inertia", "oscillator"), "inertia")
    stiffness: float | None = taken(
        optional(amount(Variable("force/length", "stiffness to the ground", min=0.0))), None
    )
    damping: float | None = taken(
        optional(amount(Variable("force*time/length", "damping to the ground", min=0.0))), None
    )
    offset: float | str = taken(_offset, "identify")
    resolution: float | None = _positive("length", "step of the encoder")
    effort_limit: float | None = _positive("force", "largest effort")
    held: bool | None = taken(optional(FLAG), None)
    hold: str | None = taken(optional(among("zero", "linear", "band_limited")), None)
    lag: float = taken(amount(Variable("time", "lag of the drive", min=0.0)), 0.0)
    seeks_lag: bool = _flag()
    periodic: bool | None = taken(optional(FLAG), None)
    at_rest: bool = _flag()
    in_cycle: bool = _flag()
    span: tuple[float, float] | None = _pair("time", "first and last time", endless=True)
    velocity_limit: float | None = _positive("length/time", "largest velocity")
    acceleration_limit: float | None = _positive("length/time^2", "largest acceleration")
    jerk_limit: float | None = _positive("length/time^3", "largest jerk")
    stroke: tuple[float, float] | None = _pair("length", "end of the stroke")
    following_error_limit: float | None = _positive("length", "largest following error")
    controller: Any = taken(optional(model("controller")), None)
    cycle: float | None = _positive("time", "cycle of the controller")
    pitch: float | None = _positive("length", "movement for a turn")
    arm: float | None = _positive("length", "movement for a radian of the motor", compare=False)
    rated: float | None = _positive("force", "effort at 100 % of rated", compare=False)
    gear: float | None = _positive("1", "gear ratio", compare=False)
    presliding: float | None = _positive("length", "pre-sliding distance")
    cutoff: float | None = _positive("frequency", "cut-off")
    decimation: int | None = taken(optional(whole(1, 10_000)), None)
    keeps_rests: bool = _flag()
    method: str = taken(
        among("prediction_error", "inverse_dynamics", "output_error"), "prediction_error"
    )
    loop: str | None = taken(optional(among("open", "closed")), None)
    settings: Mapping[str, float] = taken(mapping(_NUMBER), default_factory=dict)
    text: bytes = field(default=b"", repr=False, compare=False)
    gravity: bool = _flag()
    spring: str | None = taken(optional(among("linear", "cubic")), None)
    cogging: tuple[Cogging, ...] = taken(
        many(instance(Cogging, "an object of class Cogging"), single=True), ()
    )
    regressors: tuple[KnownColumn, ...] = taken(
        many(instance(KnownColumn, "an object of class KnownColumn"), single=True), ()
    )
