"""`excite`: a motion for an axis within its limits, and the parameters that its log will identify."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from typing import Any

import numpy as np

from bristle.core import (
    Axis,
    InputError,
    Model,
    Variable,
    cached_property,
    did_you_mean,
    located,
    quantity,
    unit_of,
    with_unit,
)
from bristle.core.edge import (
    NAMES,
    Amount,
    Progress,
    amount,
    guarded,
    model as of_family,
    optional,
    whole,
)
from bristle.files.arguments import AXIS
from bristle.files.motion import gcode_of, moves_table, write_motion
from bristle.identification import OPEN, Fit, Identification, half_width, identify
from bristle.logs import holds
from bristle.prediction.excitation.limits import MARGIN, MotionLimits, Prior, limits_of, prior_of
from bristle.prediction.excitation.motion import (
    ExcitationMotion,
    ExcitationPiece,
    length_of,
    moves_of,
)
from bristle.prediction.excitation.purposes import PURPOSES, closing
from bristle.prediction.excitation.rehearsal import Rehearsal, exceeded, lag_of, recorded, rehearse

SHORTEST = 2.0  # [s]
SAMPLES_LEAST = 100
SAMPLES_MOST = 1_500_000
SAMPLE_TIME = 1e-3  # default without an axis file entry
ABOVE = 1.02  # smallest ratio of a recorded value to a limit below it
HALVES = 4.0  # ratio of durations that halves intervals
DRAWS = 40  # simulated logs for the intervals of an earlier log
NARROWER = 0.7  # largest ratio of the half-width after a motion to the present half-width: a smaller gain is scatter of their draws
SLOWER = 0.9  # share of a limit that slower motion aims at
SLOWER_MOST = 5  # slower motions
# Dropped first if the time is short.
LEAVES_FIRST = ("resonance", "stiffness", "damping", "break-away", "presliding", "stribeck")
TIME = Variable("time", "duration", min=SHORTEST)
TRAVEL = Variable("length", "distance that the motion stays within", min=0.0)
START = Variable("length", "start of the motion")


@dataclass(frozen=True)
class Excitation:
    """A motion to run on an axis, with its assumptions and its simulation.

    Parameters
    ----------
    motion : ExcitationMotion
        The motion to run.
    axis : Axis
        The axis of the motion.
    limits : MotionLimits
        Limits of the motion.
    prior : Prior
        Assumed mechanism and friction of the axis.
    notes : tuple of str
        Omitted parts of the motion and assumptions, with reasons.
    rehearsal : Rehearsal or None
        The simulation of the motion on the prior, and the identification of the simulated log.
    exceeded : tuple of str
        Quantities beyond their limits in the simulated loop: ``"effort"``, ``"following error"``.
    earlier : Identification or None
        The identification of the earlier log.
    """

    motion: ExcitationMotion
    axis: Axis
    limits: MotionLimits
    prior: Prior
    notes: tuple[str, ...]
    rehearsal: Rehearsal | None = None
    exceeded: tuple[str, ...] = ()
    earlier: Identification | None = None

    @cached_property
    def is_repeat(self) -> bool:
        """Whether the earlier log already contains this motion: another log of it would be like that one, not like the rehearsal."""
        return (
            self.earlier is not None
            and self.rehearsal is not None
            and holds(self.earlier.log, self.rehearsal.log)
        )

    @property
    def half_widths(self) -> dict[str, tuple[float, float]]:
        """Half-widths of the 95 % intervals by the earlier log and after this motion [%]; empty without a rehearsal and an earlier log."""
        if self.earlier is None or self.rehearsal is None:
            return {}
        after = self.rehearsal.identification
        if self.is_repeat:
            after = self.earlier
        then = {estimate.name: half_width(estimate) for estimate in after.best.estimates}
        return {
            estimate.name: (half_width(estimate), then[estimate.name])
            for estimate in self.earlier.best.estimates
            if estimate.status != "held" and estimate.name in then
        }

    @property
    def is_worse(self) -> bool:
        """Whether the earlier log determines the axis as well as this motion: the mean of the half-widths is not clearly narrower."""
        # Parameters that are open in both tell nothing. The scatter of a mean falls with the root of their number.
        gains = [
            then / now for now, then in self.half_widths.values() if now and min(now, then) < OPEN
        ]
        return bool(self.half_widths) and math.prod(gains) >= NARROWER ** math.sqrt(len(gains))

    @property
    def purposes(self) -> list[tuple[str, str]]:
        """Purposes of the motion, each with the information that it adds to the log."""
        used = {piece.purpose for piece in self.motion.pieces}
        return [(name, purpose.tells) for name, purpose in PURPOSES.items() if name in used]

    @property
    def moves(self) -> tuple[str, str]:
        """Moves of the motion as a table in the units of the axis file, and as a program for an NC."""
        moves, left_out = moves_of(self.motion)
        return moves_table(moves, self.axis), gcode_of(moves, self.axis, left_out)

    @guarded()
    def write(self, path: str | PathLike[str]) -> None:
        """Write the set points of the motion as CSV, with the columns of the axis file."""
        write_motion(
            path,
            self.axis,
            {
                name: getattr(self.motion, name)
                for name in ("time", "position", "velocity", "acceleration")
            },
        )


PLANT_OR_NONE = optional(of_family("plant"))
FRICTION_MODEL = of_family("friction")


@guarded(
    axis=AXIS,
    duration=optional(amount(TIME)),
    purposes=optional(NAMES),
    draws=whole(20, 100_000, none=True),
)
def excite(
    axis: Any,
    *,
    duration: Amount | None = None,
    travel: float | str | None = None,
    start: float | str | None = None,
    purposes: Sequence[str] | str | None = None,
    model: Any = None,
    log: Any = None,
    rehearsed: bool = True,
    draws: int = 100,
    allow_code: bool = False,
    progress: Progress | None = None,
) -> Excitation:
    """Return a motion for an axis, so that bristle can identify the friction from a log of this motion.

    Parameters
    ----------
    axis : Axis, path-like, bytes, file object or dict
        Axis or axis file with limits, encoder, sample time and pre-sliding distance.
    duration : float or str, optional
        Duration of the motion [s], or text such as ``"60 s"``; 60 s by default.
    travel : float or str, optional
        Range of the motion, half of it on each side of its start [m or rad]; the stroke by default.
    start : float or str, optional
        Position of the axis at the start of the motion [m or rad]; the middle of the stroke by default.
    purposes : sequence of str, optional
        Names of `PURPOSES`, in a list or separated by commas; by default all that are possible on the axis,
        without ``resonance`` and ``stiffness``.
    model : Model, (Model, Model) or path-like, optional
        An earlier model: the friction, a pair of plant and friction, or a model file. By default, bristle derives a model
        from the limits.
    log : Log, path-like or table of columns, optional
        An earlier log of the axis, from which bristle identifies such a model (``dahl``, by inverse dynamics).
    rehearsed : bool
        Whether to simulate the motion on this model and to identify the simulated log.
    draws : int
        Number of simulated logs for the 95 % intervals of this identification; 0 for no intervals.
    allow_code : bool
        Whether your own models, named by the model file, may run without earlier permission.
    progress : callable, optional
        Called with the share done and the next step.

    Raises
    ------
    InputError
        If the axis lacks data for the requested motion, or an argument is out of range.

    Examples
    --------
    >>> from bristle.core import Axis
    >>> axis = Axis(presliding=7e-6, resolution=1e-7, sample_time=1e-3)
    >>> found = excite(axis, duration="30 s", purposes="presliding", rehearsed=False)
    >>> {piece.name for piece in found.motion.pieces} == {"conditioning slide", "decaying loops", "triangles"}
    True
    """
    seconds = 60.0
    if duration is not None:
        seconds = duration
    earlier = None
    if log is None:
        mechanism = _mechanism(model, axis, allow_code)
    else:
        # By one method for log and motion: half-widths of different methods cannot be compared.
        axis = replace(axis, method="inverse_dynamics")
        earlier = _identified(log, model, axis, draws=rehearsed * DRAWS)
        mechanism = _of_log(earlier.best)
    try:
        prior = prior_of(axis, *mechanism)
    except InputError as error:
        raise InputError(
            f"do not fit a real axis, because the typical friction is out of range ({error})",
            path="[limits]",
            mend="Correct velocity, acceleration, stroke and mass in the axis file",
        ) from None
    sample_time = axis.sample_time or SAMPLE_TIME
    count = seconds / sample_time
    if not SAMPLES_LEAST <= count <= SAMPLES_MOST:
        allowed = f"{SAMPLES_LEAST} to {SAMPLES_MOST} samples"
        longer = "Extend the duration"
        if count > SAMPLES_MOST:
            longer = "Record the motion in parts"
        raise InputError(
            f"contains {count:.3g} samples",
            path="duration",
            value=with_unit(seconds, "s"),
            allowed=allowed,
            mend=f"{longer}, or correct the sample time, {with_unit(sample_time, 's')}",
        )
    begin = None
    if start is not None:
        begin = quantity(start, START, axis.kind, path="start")
    distance = None
    if travel is not None:
        distance = amount(TRAVEL, exclusive=True)(travel, "travel", axis.kind)
    plan = partial(
        _planned, axis, prior, seconds=seconds, purposes=purposes, begin=begin, earlier=earlier
    )
    limits = limits_of(axis, prior, sample_time, distance, begin)
    excitation = plan(limits)
    if rehearsed:
        excitation = _rehearsed(excitation, plan, draws=draws, progress=progress)
    # Of unknown limits, the notes on purposes already say which to write.
    if (
        earlier is not None
        and excitation.is_worse
        and None not in (limits.velocity, limits.acceleration, limits.travel)
    ):
        notes = [
            f"to record more than the log at hand, raise {_below(excitation, limits, seconds, earlier)}"
        ]
        if excitation.is_repeat:
            notes.insert(
                0,
                "the log at hand already contains this motion: another log of it has the half-widths of that log",
            )
        excitation = replace(excitation, notes=(*excitation.notes, *notes))
    return excitation


def _below(
    excitation: Excitation, limits: MotionLimits, seconds: float, earlier: Identification
) -> str:
    """Return the limits that an earlier log exceeds, with sufficient values; a longer duration if it exceeds none, or is a repeat."""
    reached = (
        ("limits.velocity to", "length/time", earlier.best.traces.velocity, limits.velocity),
        (
            "limits.acceleration to",
            "length/time^2",
            earlier.best.traces.acceleration,
            limits.acceleration,
        ),
        (
            "limits.stroke to a range of",
            "length",
            np.ptp(earlier.log.position.values),
            limits.travel,
        ),
        ("--duration to", "time", earlier.log.duration, seconds),
    )
    below = [
        f"{name} {limits.in_unit(float(np.max(np.abs(value))) / MARGIN, of)}"
        for name, of, value, limit in reached
        if not excitation.is_repeat and limit is not None and np.max(np.abs(value)) > ABOVE * limit
    ]
    return (
        ", ".join(below)
        or f"--duration to {limits.in_unit(HALVES * seconds, 'time')}, which halves the intervals"
    )


def _planned(
    axis: Axis,
    prior: Prior,
    limits: MotionLimits,
    *,
    seconds: float,
    purposes: Sequence[str] | None,
    begin: float | None,
    earlier: Identification | None,
) -> Excitation:
    """Return a motion for these purposes within the limits."""
    chosen, notes = _chosen(purposes, limits)
    pieces, left_out = _in_time(
        chosen, limits, seconds - ExcitationMotion.rest, may_drop=purposes is None
    )
    if begin is not None:
        start = begin
    elif axis.stroke:
        start = 0.5 * sum(axis.stroke)
    else:
        start = 0.0
    motion = ExcitationMotion(tuple(pieces), limits.sample_time, axis.kind, start)
    notes += left_out
    if axis.sample_time is None:
        notes.append(
            f"bristle assumed a sample time of {with_unit(SAMPLE_TIME, 's')}: the axis file has no [timing] entry"
        )
    place = with_unit(motion.start, unit_of("length", axis.kind))
    if begin is not None:
        notes.append(f"the motion begins at {place}")
    elif axis.stroke:
        notes.append(f"the motion begins in the middle of the stroke, at {place}")
    else:
        notes.append(
            "the motion begins at position 0: add the present position of your axis, or state it with --start"
        )
    if prior.assumed:
        notes.append(f"the rehearsal assumes: {', '.join(prior.assumed)}")
    # Check the finished motion against the limits, to protect the axis.
    reach = float(np.max(np.abs(motion.position - motion.start)))
    for name, value, limit in (
        ("travel", 2.0 * reach, limits.travel),
        ("velocity", float(np.max(np.abs(motion.velocity))), limits.velocity),
        ("acceleration", float(np.max(np.abs(motion.acceleration))), limits.acceleration),
    ):
        if limit is not None and value > limit * (1.0 + 1e-9):
            raise RuntimeError(f"the motion exceeds the {name} of the axis: {value:g} > {limit:g}")
    return Excitation(motion, axis, limits, prior, tuple(notes), earlier=earlier)


def _rehearsed(
    excitation: Excitation,
    plan: Callable[[MotionLimits], Excitation],
    *,
    draws: int,
    progress: Progress | None,
) -> Excitation:
    """Return a motion with its rehearsal, planned again if the loop of the controller cannot run it."""
    axis = excitation.axis
    prior = excitation.prior
    limits = excitation.limits
    rehearsal = None
    failed = ()
    try:
        excitation = _within_the_loop(excitation, plan)
        log, _, loop = recorded(excitation.motion, axis, prior)
        followed = _for_the_loop(excitation, loop * lag_of(excitation.motion, log), plan)
        if followed is not None:
            excitation = _within_the_loop(followed, plan)
        rehearsal = rehearse(excitation.motion, axis, prior, draws=draws, progress=progress)
    except InputError as reason:
        failed = (f"the rehearsal failed: {reason}",)
    return replace(
        excitation,
        rehearsal=rehearsal,
        notes=(*excitation.notes, *_reductions(excitation, limits), *failed),
    )


def _within_the_loop(
    excitation: Excitation, plan: Callable[[MotionLimits], Excitation]
) -> Excitation:
    """Return a motion that keeps the limits of effort and following error in the simulated loop, slower if necessary."""
    axis = excitation.axis
    slower = excitation
    if axis.controller is None or (
        axis.effort_limit is None and axis.following_error_limit is None
    ):
        return excitation
    first = ratios = exceeded(excitation.motion, axis, excitation.prior)
    for _ in range(SLOWER_MOST):
        if not (ratios and (slower.limits.velocity or slower.limits.acceleration)):
            break
        limits = slower.limits
        share = SLOWER / max(ratios.values())
        velocity, acceleration = (
            share * float(np.max(np.abs(signal)))
            for signal in (slower.motion.velocity, slower.motion.acceleration)
        )
        if limits.velocity:
            limits = replace(limits, velocity=velocity)
        if limits.acceleration:
            limits = replace(limits, acceleration=acceleration)
        try:
            slower = plan(limits)
            ratios = exceeded(slower.motion, axis, slower.prior)
        except InputError:  # slower motion needs more time, or does not exist
            break
    if ratios == {} or not first:
        return slower
    return replace(excitation, exceeded=tuple(first))


def _reductions(excitation: Excitation, limits: MotionLimits) -> list[str]:
    """Return a note on the limits of effort and following error, if a motion is slower than other limits allow or exceeds them."""
    if excitation.exceeded:
        names = " and ".join(excitation.exceeded)
        reason = (
            "no slower motion of this duration respects the limits of the axis. "
            "Raise the limits or the duration, or tune the controller"
        )
        return [f"the rehearsal exceeds the limit of {names}, and {reason}"]
    pairs = (
        (excitation.limits.velocity, limits.velocity, "length/time"),
        (excitation.limits.acceleration, limits.acceleration, "length/time^2"),
    )
    reduced = [
        limits.in_unit(value, of)
        for value, before, of in pairs
        if value is not None and value != before
    ]
    reason = "because faster motion exceeds the limit of effort or following error in the rehearsal"
    if reduced:
        return [f"bristle limited the motion to {' and '.join(reduced)}, {reason}"]
    return []


def _for_the_loop(
    excitation: Excitation, lag: float, plan: Callable[[MotionLimits], Excitation]
) -> Excitation | None:
    """Return a motion without the loops that the controller cannot follow; None if it follows, or none would remain."""
    smallest = min(
        (piece.amplitude for piece in excitation.motion.pieces if piece.name == "triangles"),
        default=None,
    )
    if smallest is None or lag <= smallest:
        return None
    limits = replace(excitation.limits, followed=lag)
    try:
        again = plan(limits)
    except InputError:  # keep requested purposes; the report shows the tracking error
        return None
    length = limits.in_unit(lag, "length")
    note = f"the amplitude of pre-sliding loops is at least {length}, the tracking error of the controller in the rehearsal"
    if any(piece.purpose == "presliding" for piece in again.motion.pieces):
        return replace(again, notes=(*again.notes, note))
    return again


def _mechanism(model: Any, axis: Axis, allow_code: bool) -> tuple[Model | None, Model | None]:
    """Return plant and friction of an earlier model, as far as known."""
    plant = None
    if model is None:
        return None, None
    if isinstance(model, tuple):
        if len(model) != 2:
            raise InputError("must be a pair of plant and friction", path="model", value=model)
        plant = PLANT_OR_NONE(model[0], "model[0]", axis.kind)
        friction = FRICTION_MODEL(model[1], "model[1]", axis.kind)
    elif isinstance(model, Model):
        friction = model
    else:
        from bristle.files.model import read_model

        plant, friction, _ = read_model(model, allow_code=allow_code)
    if friction.kind != axis.kind:
        raise InputError(
            f"is for a {friction.kind} axis",
            path="model",
            value=friction.name,
            allowed=f"a model of a {axis.kind} axis",
        )
    return plant, friction


def _identified(log: Any, model: Any, axis: Axis, *, draws: int) -> Identification:
    """Return the identification of a log of the axis."""
    if model is not None:
        raise InputError(
            "cannot be combined with model",
            path="log",
            mend="Leave out log or model: each gives an earlier model of the axis",
        )
    return identify(log, "dahl", axis=axis, draws=draws)


def _of_log(best: Fit) -> tuple[Model | None, Model]:
    """Return plant and friction of a log of the axis; no plant if the log does not determine its mass."""
    is_known = best.inertia is not None and best.inertia.status in ("identified", "held")
    if is_known:
        return best.plant, best.friction
    return None, best.friction


def _chosen(purposes: Sequence[str] | None, limits: MotionLimits) -> tuple[list[str], list[str]]:
    """Return the possible purposes among the requested ones, and reasons against the others."""
    usual = [name for name, purpose in PURPOSES.items() if not purpose.on_request]
    names = usual
    if purposes is not None:
        names = list(purposes)
    if not names:
        raise InputError(
            "names no purpose of a motion",
            path="purposes",
            allowed=", ".join(PURPOSES),
            mend="Name a purpose, or omit the option for all possible purposes",
        )
    for name in names:
        if name not in PURPOSES:
            allowed = ", ".join(PURPOSES)
            raise InputError(
                "is not a purpose of a motion",
                path="purposes",
                value=name,
                allowed=allowed,
                mend=did_you_mean(name, PURPOSES),
            )
    reasons = {name: PURPOSES[name].missing(limits) for name in names}
    if purposes is None and all(reasons.values()):
        raise InputError(
            "contains too few data to plan a motion",
            path="axis",
            mend="; and ".join(dict.fromkeys(reasons.values())),
        )
    for name, reason in reasons.items():
        if reason and purposes is not None:
            raise InputError(f"cannot contain {name}, because {reason}", path="purposes")
    notes = [
        f"no {name} ({PURPOSES[name].tells}): {reason}"
        for name, reason in reasons.items()
        if reason
    ]
    return [name for name in PURPOSES if name in names and not reasons[name]], notes


def _in_time(
    chosen: list[str], limits: MotionLimits, seconds: float, *, may_drop: bool
) -> tuple[list[ExcitationPiece], list[str]]:
    """Return pieces within a time limit [s], and notes on purposes left out for it."""
    notes = list[str]()
    takes = 0.0
    while True:
        target = seconds
        pieces = _pieces(chosen, limits, seconds)
        for _ in range(4):  # iterate down to the time limit
            takes = length_of(pieces)
            if takes <= seconds * 1.001:
                return pieces, notes
            target *= seconds / takes
            pieces = min(pieces, _pieces(chosen, limits, target), key=length_of)
        asked, needed = (f"{time + ExcitationMotion.rest:.3g} s" for time in (seconds, takes))
        if len(chosen) == 1 or not may_drop:
            raise InputError(
                f"is too short, because a motion for {', '.join(chosen)} needs {needed} on this axis",
                path="duration",
                value=asked,
                mend="Extend the duration to this time, or name fewer purposes: a faster motion would not identify the parameters",
            )
        first = next(name for name in LEAVES_FIRST if name in chosen)
        notes.append(
            f"no {first} ({PURPOSES[first].tells}): with it, the motion would take {needed}"
        )
        chosen = [name for name in chosen if name != first]


def _pieces(chosen: Sequence[str], limits: MotionLimits, seconds: float) -> list[ExcitationPiece]:
    """Return the pieces of all purposes; later purposes get the unused time of earlier ones."""
    left = seconds
    share_left = sum(PURPOSES[name].share for name in chosen)
    pieces = []
    # Pieces of fixed number come first; triangles, whose duration is free, use the rest.
    for name in sorted(chosen, key=lambda name: name == "presliding"):
        purpose = PURPOSES[name]
        with located(f"the motion for {name} within the limits of the axis"):
            added = purpose.pieces(limits, left * purpose.share / share_left)
        left -= sum(piece.rest + piece.duration for piece in added)
        share_left -= purpose.share
        left = max(left, SHORTEST)
        pieces += added
    pieces.sort(key=lambda piece: chosen.index(piece.purpose))
    return [*pieces, *closing(limits, pieces)]
