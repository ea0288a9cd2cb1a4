"""`Axis`: what is known of a motion axis before anything is identified from its logs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bristle.core.edge import FLAG, KIND, TEXT, among, amount, guarded, instance, many, mapping, model, optional, taken, whole
from bristle.core.errors import InputError, located
from bristle.core.motion import RECORDED
from bristle.core.tabular import SIGNALS
from bristle.core.values import shown
from bristle.core.variable import KINDS, Kind, Variable

CHANNELS = {name: SIGNALS[name].quantity for name in ("time", "position", "velocity", "effort", "reference", *RECORDED)}
"""Channel of a log -> generalised quantity."""
COLUMNS = CHANNELS | {"following_error": "length"}
"""What a column may be: a channel, or the following error, which makes the reference with the position."""

_NUMBER = amount(Variable("1", "factor"))


def _flag(*, default: bool = False) -> Any:
    return taken(FLAG, default)


def _positive(quantity: str, meaning: str, **options: Any) -> Any:
    return taken(optional(amount(Variable(quantity, meaning, min=0.0), exclusive=True)), None, **options)


def _pair(quantity: str, meaning: str, *, endless: bool = False) -> Any:
    return taken(optional(many(amount(Variable(quantity, meaning), endless=endless), least=2, most=2)), None)


def _offset(value: Any, path: str, kind: Kind | None) -> float | str:
    if isinstance(value, str) and value == "identify":
        return value
    variable = Variable("force", "constant part of the friction force")
    with located(allowed=f'"identify", or a value in {variable.unit(kind or KINDS[0])}'):
        return amount(variable)(value, path, kind)


@guarded()
@dataclass(frozen=True)
class Column:
    """One column of a log and how its numbers become SI of the axis.

    Parameters
    ----------
    name : str
        Name in the log.
    unit : str
        Unit of the numbers in the log; empty where the log says it itself.
    base : str
        Unit that `scale` applies to: ``"V"`` for a controller output, ``"rad"`` for a motor's encoder.
    scale : float
        SI of the axis for one `base`, sign, drive constants and transmission included.
    optional : bool
        Whether a log may lack it.
    shift : float
        What is added after scaling, for temperatures.
    """

    name: str = taken(TEXT)
    unit: str = taken(TEXT)
    base: str = taken(TEXT)
    scale: float = taken(_NUMBER, 1.0)
    optional: bool = _flag()
    shift: float = taken(_NUMBER, 0.0)


def _columns(columns: Any, path: str, kind: Kind | None) -> dict[str, Column]:
    """Take columns by channel; a further channel, for a slot of a person's own, is a word and has a unit."""
    columns = mapping(instance(Column, "a Column"))(columns, path, kind)
    for name, column in columns.items():
        if name not in COLUMNS and not (isinstance(name, str) and name.isidentifier() and (column.base or column.shift)):
            allowed = f"{', '.join(COLUMNS)}, or a further channel, with its unit"
            raise InputError("has an unknown name", path=path, value=shown(name), allowed=allowed)
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
        Whether a log may lack it.
    """

    column: str = taken(TEXT)
    gain: float = taken(_NUMBER)
    optional: bool = _flag()


@guarded()
@dataclass(frozen=True)
class KnownColumn:
    """A column of a log that an identified coefficient makes an effort of.

    Parameters
    ----------
    column : str
        Name in the log.
    name : str
        What the coefficient is called after: ``known_NAME``.
    optional : bool
        Whether a log may lack it; it is zero there.
    """

    column: str = taken(TEXT)
    name: str = taken(TEXT)
    optional: bool = _flag()


@guarded()
@dataclass(frozen=True)
class Cogging:
    """Efforts that come back a whole number of times in a turn, the same in both directions.

    Parameters
    ----------
    turner : {"motor", "screw"}
        What turns.
    turn : float
        Movement of the axis for one turn of it [m or rad].
    harmonics : tuple of int or None
        How often in a turn; None where the log is to tell.
    """

    turner: str = taken(among("motor", "screw"))
    turn: float = taken(amount(Variable("length", "movement for one turn", min=1e-12)))
    harmonics: tuple[int, ...] | None = taken(optional(many(whole(1, 10_000), single=True)), None)


@guarded()
@dataclass(frozen=True)
class Axis:
    """A motion axis, in SI of its kind.

    Parameters
    ----------
    name : str
        What people call it.
    kind : {"translational", "rotational"}
        Decides the units: m, N, kg or rad, N*m, kg*m^2.
    columns : mapping of str to Column
        Channel (``time``, ``position``, ``velocity``, ``effort``, ``reference``, ``load``, ``temperature``, and
        further ones for slots of your own) to the column of the log.
    injected : tuple of Injected
        Known inputs of the loop.
    table : str or None
        Table, group or array of the log file, where it holds several.
    sample_time : float or None
        Sample time of the log where it has no column of time [s].
    delay : float
        By how much the effort column lags the position column [s].
    seeks_delay : bool
        Whether an identification is to find how much more it lags; else nothing is moved besides `delay`.
    mass : float or None
        Moving mass [kg] or inertia [kg*m^2], where known.
    plant : str
        What the friction acts on: ``inertia``, or ``oscillator``, which has a spring and a damper to the ground.
    stiffness, damping : float or None
        Of the oscillator, where known [N/m, N*s/m or N*m/rad, N*m*s/rad].
    offset : float or "identify"
        Constant part of the friction force (gravity, bias).
    resolution : float or None
        Smallest step of the position encoder [m or rad].
    effort_limit : float or None
        Saturation of the effort [N or N*m].
    held : bool or None
        Whether each value of the effort acts until the next sample, as of a sampled controller; None where nobody
        said so, which counts as no.
    hold : {"zero", "linear", "band_limited"} or None
        What the effort does between its samples where its motion is simulated; None counts as held.
    lag : float
        Time constant with which the drive follows its controller [s], in simulated loops.
    seeks_lag : bool
        Whether an identification of the closed loop is to find it.
    periodic : bool or None
        Whether each log is a whole number of periods of a motion that repeats; None where the log is to tell.
    in_cycle : bool
        Whether the log begins within a motion that repeats: a contact with a memory has been through it before.
    span : tuple of float or None
        From when to when the log is used, in its own time [s].
    at_rest : bool
        Whether each log begins at rest and relaxed, or, where it is periodic, has run in from there.
    velocity_limit : float or None
        Largest velocity [m/s or rad/s].
    acceleration_limit : float or None
        Largest acceleration [m/s^2 or rad/s^2].
    jerk_limit : float or None
        Largest jerk [m/s^3 or rad/s^3].
    stroke : tuple of float or None
        Smallest and largest position [m or rad].
    controller : Model or None
        The control law that was running.
    pitch : float or None
        Movement of the axis for one turn of the motor [m or rad], where a transmission is told.
    rated : float or None
        Effort on the axis at 100 % of rated [N or N*m]; None where nothing tells it.
    arm : float or None
        Movement of the axis for one radian of the motor [m or rad], where a transmission is told: gains may be those
        of the motor.
    presliding : float or None
        Distance over which friction turns at a reversal, where known: static friction models are simulated with
        it [m or rad].
    cutoff : float or None
        Cut-off of the zero-phase filter of the identification [Hz].
    decimation : int or None
        Of how many filtered samples the identification keeps one.
    keeps_rests : bool
        Whether the identification keeps samples at rest: where the effort is the friction itself, as a sensor beside
        the contact sees it, a model with pre-sliding tells it there too.
    method : {"prediction_error", "inverse_dynamics", "output_error"}
        What an identification makes small: the error of the effort along the measured motion, and from there on, for the
        best model where it has pre-sliding, the error with which an observer predicts the next position from the measured
        effort; the error of the effort alone; or the error of a simulation: in open loop that of the position that the
        measured effort makes of the model, in closed loop that of the effort that the controller asks for.
    loop : {"open", "closed"} or None
        Which loop is simulated there; None where controller and reference decide: with both it is the closed one.
    settings : mapping of str to float
        Thresholds of an identification that differ from their defaults, by name.
    text : bytes
        The axis file, where it was read from one.
    gravity : bool
        Whether the axis turns a link on which gravity pulls.
    cogging : tuple of Cogging
        What of the effort comes back with every turn of motor or screw.
    regressors : tuple of KnownColumn
        Columns of the log that an identified coefficient makes efforts of.
    """

    name: str = taken(TEXT, "axis")
    kind: Kind = taken(KIND, "translational")
    columns: Mapping[str, Column] = taken(_columns, default_factory=dict)
    injected: tuple[Injected, ...] = taken(many(instance(Injected, "an Injected"), single=True), ())
    table: str | None = taken(optional(TEXT), None)
    sample_time: float | None = _positive("time", "sample time")
    delay: float = taken(amount(Variable("time", "delay of the effort")), 0.0)
    seeks_delay: bool = _flag(default=True)
    mass: float | None = _positive("mass", "moving mass or inertia")
    plant: str = taken(among("inertia", "oscillator"), "inertia")
    stiffness: float | None = taken(optional(amount(Variable("force/length", "stiffness to the ground", min=0.0))), None)
    damping: float | None = taken(optional(amount(Variable("force*time/length", "damping to the ground", min=0.0))), None)
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
    span: tuple[float, float] | None = _pair("time", "from when to when", endless=True)
    velocity_limit: float | None = _positive("length/time", "largest velocity")
    acceleration_limit: float | None = _positive("length/time^2", "largest acceleration")
    jerk_limit: float | None = _positive("length/time^3", "largest jerk")
    stroke: tuple[float, float] | None = _pair("length", "where the stroke ends")
    controller: Any = taken(optional(model("controller")), None)
    pitch: float | None = _positive("length", "movement for a turn")
    arm: float | None = _positive("length", "movement for a radian of the motor", compare=False)
    rated: float | None = _positive("force", "effort at 100 % of rated", compare=False)
    presliding: float | None = _positive("length", "pre-sliding distance")
    cutoff: float | None = _positive("frequency", "cut-off")
    decimation: int | None = taken(optional(whole(1, 10_000)), None)
    keeps_rests: bool = _flag()
    method: str = taken(among("prediction_error", "inverse_dynamics", "output_error"), "prediction_error")
    loop: str | None = taken(optional(among("open", "closed")), None)
    settings: Mapping[str, float] = taken(mapping(_NUMBER), default_factory=dict)
    text: bytes = field(default=b"", repr=False, compare=False)
    gravity: bool = _flag()
    cogging: tuple[Cogging, ...] = taken(many(instance(Cogging, "a Cogging"), single=True), ())
    regressors: tuple[KnownColumn, ...] = taken(many(instance(KnownColumn, "a KnownColumn"), single=True), ())
