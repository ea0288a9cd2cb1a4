r"""The effect of an export on the axis: the loop without and with it, along moves and along the motion of the log.

bristle reads the numbers of the files back and simulates a drive that feeds forward :math:`u_{ff}` from them. The moves
go from rest to rest with dwells in between, forward and backward, over 1, 3, 10 and 30 times the pre-sliding distance.
Inside that distance a compensator without memory may push in the wrong direction. The effort of acceleration equals
that of sliding friction. A second simulation feeds forward a tenth more friction: friction falls as an axis warms up,
and with too much compensation an integrating controller may hunt.

If the controller is unknown, two loops with an integral replace it. In a loop as slow as its quick moves of 0.1 s, a
compensation that pushes too much displaces the axis. In a loop as stiff as the sample time allows, the integral alone
follows the friction of a slow move of 1 s, and the step of a table without memory disturbs it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from bristle.core.experiment import Feedforward, Start, Variant
from bristle.core.status import Status
from bristle.core.typography import number
from bristle.core.variable import Kind, unit_of
from bristle.engine import response
from bristle.exports.loops import Assumed, assumed_loops, loop_for, samples_ahead
from bristle.exports.moves import (
    FASTEST,
    MOVES,
    SHORTEST,
    SLOW,
    SLOW_MOVES,
    TIMES,
    Limits,
    limits_within,
    moves_over,
    sliding_level,
    turning_distance,
)
from bristle.exports.targets import Request
from bristle.friction import with_presliding
from bristle.identification.parameters import offset_of
from bristle.references import recorded
from bristle.simulation.compensation import settling
from bristle.simulation.result import VariantResult
from bristle.simulation.run import simulate_with
from bristle.simulation.two_masses import screw_of, table_of

Compensated = Callable[[Variant, int, float], VariantResult]
Drive = Callable[[np.ndarray, float], np.ndarray]
"""``drive(x, dt)``: the force [N or N*m] fed forward for the step that ends at each desired position."""

SERIOUS = 10.0  # An export that is worse from this distance on, or along the motion of the log, is refused
WORSE = 1.05  # ratio of two errors that count as different
TINY = 1e-12  # an error or a ratio below it counts as zero
FARTHER = (*TIMES, 100.0)  # distances of the moves over the pre-sliding distance, if the controller is unknown
LOG, EXPERIMENT = "log", "experiment"


class Along(NamedTuple):
    """One motion: its kind, its distance (0 for a log), and the error without and with the export.

    `not_ahead` is the error if the desired motion is not fed ahead, `too_much` the error with a tenth too much friction
    fed forward. Errors are peak to peak [m or rad].
    """

    motion: str
    distance: float
    without: float
    with_it: float
    not_ahead: float = math.nan
    too_much: float = math.nan

    @property
    def is_worse(self) -> bool:
        """Whether the export makes the error larger, or the loop diverge."""
        return not self.with_it <= WORSE * self.without

    @property
    def is_no_better(self) -> bool:
        """Whether the error with the export is not clearly smaller, and on the real axis may be larger than without it.

        This includes a reduction by less than half that disappears with a tenth too much friction fed forward.
        """
        clearly = self.without / WORSE
        is_worse = self.too_much > clearly and self.with_it > 0.5 * self.without
        return is_worse or not self.with_it <= clearly

    @property
    def ratio(self) -> float:
        """The error with the export divided by the error without it."""
        return self.with_it / max(self.without, TINY)


@dataclass(frozen=True)
class Effect:
    """Effect of an export on the axis.

    Parameters
    ----------
    along : tuple of Along
        The errors along each motion: first the moves, last the motion of the log.
    kind : {"translational", "rotational"}
        The kind of axis.
    distance : float
        Pre-sliding distance: displacement after a reversal over which friction changes its sign [m or rad].
    assumed : bool
        Whether `distance` is an assumption, because neither model nor axis file has one.
    loops : tuple of float
        Bandwidths of the assumed loops [Hz], of moves and of slow moves; empty for the loop of the axis.
    ahead : int
        Samples by which the desired motion is fed ahead.
    """

    along: tuple[Along, ...]
    kind: Kind
    distance: float
    assumed: bool
    loops: tuple[float, ...]
    ahead: int

    @property
    def moves(self) -> list[Along]:
        """The moves, the shortest first."""
        return [path for path in self.along if path.motion == MOVES]

    @property
    def is_harmful(self) -> bool:
        """Whether the export increases the error along the motion of the log, or along moves far longer than `distance`."""
        far = SERIOUS * (1.0 - 1e-9) * self.distance
        return not self.loops and any(path.is_worse and (path.motion != MOVES or path.distance >= far) for path in self.along)

    @property
    def ratio(self) -> float:
        """Ratio of the errors with and without the export, geometric mean over all motions; inf if one diverges."""
        ratios = [path.ratio for path in self.along]
        return float(np.exp(np.mean(np.log(np.maximum(ratios, TINY))))) if np.all(np.isfinite(ratios)) else math.inf

    @property
    def least_distance(self) -> float:
        """Distance from which the export improves every move [m or rad]; 0 for all moves, inf if it does not improve the longest move."""
        below = max((path.distance for path in self.moves if path.is_no_better), default=0.0)
        return min((path.distance for path in self.moves if path.distance > below), default=math.inf) if below else 0.0

    @property
    def _slow_distance(self) -> float:
        """Distance up to which slow moves can get worse in a stiff loop [m or rad]; 0 if none does."""
        return max((path.distance for path in self.along if path.motion == SLOW_MOVES and path.is_no_better), default=0.0)

    @property
    def _is_worse_slowly(self) -> bool:
        """Whether slow moves can get worse over distances over which quick moves improve."""
        return self._slow_distance >= self.least_distance and self._slow_distance > 0.0

    def lines(self) -> tuple[str, ...]:
        """Return the effect in sentences, the most important first."""
        head = "simulated following error, peak to peak, without -> with compensation"
        loop = f" (loop of {number(self.loops[0], digits=2)} Hz, moves of {SHORTEST:g} s)" if self.loops else ""
        lines = [self._verdict(), f"{head}: {self._sizes(self.moves)}{loop}"]
        for own in (path for path in self.along if path.motion in (LOG, EXPERIMENT)):
            late = "" if math.isnan(own.not_ahead) else f", {self._size(own.not_ahead)} if the motion is not fed ahead"
            lines.append(f"along the motion of the {own.motion}: {self._change(own)}{late}")
        if slow := [path for path in self.along if path.motion == SLOW_MOVES]:
            lines.append(f"slow moves: {self._sizes(slow)} (loop of {number(self.loops[-1], digits=2)} Hz, moves of {SLOW:g} s)")
        # The move that suffers most from a tenth too much friction.
        worst = max(self.moves, key=lambda path: -1.0 if path.is_worse else path.too_much / max(path.without, TINY))
        if not (worst.is_worse or math.isnan(worst.too_much)):
            change = f"{self._size(worst.without)} -> {self._size(worst.too_much)} in moves of {self._length(worst.distance)}"
            harm = (
                "" if worst.too_much <= WORSE * worst.without else ": worse than no compensation, so feed forward only 90 % of the friction"
            )
            lines.append(f"with a tenth too much friction fed forward: {change}{harm}")
        if self.assumed:
            lines.append(
                f"the pre-sliding distance is unknown, and bristle assumes {self._length(self.distance)}: "
                "write presliding under [plant] of the axis file"
            )
        if self.loops:
            lines.append(
                "the controller is unknown: for the effect in its loop, write [controller] with model, k_p and k_v into the axis file"
            )
        return tuple(lines)

    def as_data(self) -> dict[str, Any]:
        """Return the effect as data for JSON, in SI units of the axis; null for infinite or missing values."""

        def finite(value: float) -> float | None:
            return value if math.isfinite(value) else None

        along = [
            {"motion": path.motion, "distance": path.distance or None, "without": path.without, "with": finite(path.with_it)}
            | {"worse": path.is_worse, "not_fed_ahead": finite(path.not_ahead), "with_a_tenth_more": finite(path.too_much)}
            for path in self.along
        ]
        return (
            {"quantity": "following_error", "unit": unit_of("length", self.kind), "assumed_loops": list(self.loops)}
            | {"presliding_distance": self.distance, "assumed_distance": self.assumed, "samples_ahead": self.ahead}
            | {"harmful": self.is_harmful, "least_distance": finite(self.least_distance), "along": along}
        )

    def _verdict(self) -> str:
        least, moves = self.least_distance, "quick moves" if self._is_worse_slowly else "moves"
        verdict = f"the compensation helps {moves} of {self._length(least or self.moves[0].distance)} or more"
        if math.isinf(least):
            harm = "does not help" if not any(path.is_worse for path in self.moves) else "can harm" if self.loops else "harms"
            verdict = f"the compensation {harm} {moves} up to {self._length(self.moves[-1].distance)}"
        elif least and self.assumed:
            times = number(least / self.distance, digits=2)
            verdict += f", and of {times} times the true pre-sliding distance if this exceeds the assumed {self._length(self.distance)}"
        harmed = [f"shorter moves {'can ' if self.loops else ''}get worse"] if 0.0 < least < math.inf else []
        if self._is_worse_slowly:
            harmed.append(f"slow moves up to {self._length(self._slow_distance)} can get worse in a stiff loop")
        mend = "switch it off there" + (", or export a model with pre-sliding (--to c)" if self.loops else "")
        return f"{'; '.join([verdict, *harmed])}{f': {mend}' if least or harmed else ''}"

    def _sizes(self, moves: list[Along]) -> str:
        better, worse = ([path for path in moves if path.is_no_better == no_better] for no_better in (False, True))
        worst = max(worse, key=lambda path: path.ratio, default=None)
        chosen = [*better[-1:], worst or (better[0] if len(better) > 1 else None)]
        return "; ".join(f"{self._change(path)} in moves of {self._length(path.distance)}" for path in chosen if path)

    def _change(self, path: Along) -> str:
        return f"{self._size(path.without)} -> {self._size(path.with_it)}"

    def _size(self, value: float) -> str:
        if not math.isfinite(value):
            return "diverges"
        return self._length(value)

    def _length(self, value: float) -> str:
        if self.kind == "rotational":
            return f"{number(1e6 * value, digits=3)} urad"
        return f"{number(1e3 * value, digits=3)} mm" if value >= 1e-3 else f"{number(1e6 * value, digits=3)} um"


def driven_by(drive: Drive) -> Compensated:
    """Return a function that runs a loop with the feedforward of a drive, `ahead` samples early."""

    def compensated(loop: Variant, ahead: int, share: float = 1.0) -> VariantResult:
        dt = loop.run.sample_time
        count = round(loop.run.duration / dt)
        x = loop.reference.component.sample(dt * np.arange(count + ahead), loop.reference.parameters)[0]
        fed = drive(x, dt)[ahead:]
        return simulate_with(loop, fed if share == 1.0 else share * fed + (1.0 - share) * _held(loop))

    return compensated


def fed_by(feedforward: Feedforward) -> Compensated:
    """Return a function that runs a loop with the feedforward of a law, which has an input for the next samples."""

    def compensated(loop: Variant, ahead: int, share: float = 1.0) -> VariantResult:
        gain = share * feedforward.gain
        offset = feedforward.offset + (1.0 - share) * feedforward.gain * _held(loop)
        return simulate_with(replace(loop, feedforward=replace(feedforward, gain=gain, offset=offset)), None)

    return compensated


def _held(loop: Variant) -> float:
    """Return the constant force of a loop's friction (gravity or bias), which is never fed in excess."""
    return offset_of(loop.friction.component.variables, loop.friction.values)


def effect_in_loop(loop: Variant, compensated: Compensated, limits: Limits, distance: tuple[float, bool], ahead: int) -> Effect:
    """Return the effect of an export on a loop; friction without pre-sliding turns over the given distance."""
    along = _moves(loop, compensated, limits, distance[0], ahead, TIMES)
    loop, dt = replace(loop, friction=with_presliding(loop.friction, distance[0])), loop.run.sample_time
    count = min(round(loop.run.duration / dt), 60_000)
    own = loop.first(count)
    if np.ptp(own.reference.component.sample(dt * np.arange(count), own.reference.parameters)[0]) > 0.0:
        results = [simulate_with(own, None), compensated(own, ahead, 1.0)]
        results += [compensated(own, 0, 1.0)] if ahead else []
        motion = LOG if own.reference.component is recorded else EXPERIMENT
        along.append(Along(motion, 0.0, *map(_error, results)))
    return Effect(tuple(along), loop.plant.kind, *distance, (), ahead)


def effect_in_assumed_loops(loops: Sequence[Assumed], compensated: Compensated, limits: Limits, distance: tuple[float, bool]) -> Effect:
    """Return the effect of an export on an axis of unknown controller."""
    ahead, along = samples_ahead(loops[0].variant), []
    for loop in loops:
        moves = _moves(loop.variant, compensated, limits, distance[0], ahead, FARTHER, loop.lasting)
        along += [path._replace(motion=loop.motion) for path in moves]
    return Effect(tuple(along), loops[0].variant.plant.kind, *distance, tuple(loop.bandwidth for loop in loops), ahead)


def _moves(
    loop: Variant,
    compensated: Compensated,
    limits: Limits,
    distance: float,
    ahead: int,
    times: tuple[float, ...],
    lasting: float = SHORTEST,
) -> list[Along]:
    """Return the errors along moves over multiples of the pre-sliding distance."""
    begun, dt = _at_rest(replace(loop, friction=with_presliding(loop.friction, distance))), loop.run.sample_time
    assert begun.start is not None
    along = []
    for far in times:
        x = begun.start.position + moves_over(far * distance, limits, dt, lasting)
        run = replace(loop.run, duration=dt * x.size, settle=settling(dt * x.size), seeds=1)
        variant = replace(begun, reference=recorded(kind=loop.plant.kind, position=x, sample_time=dt), run=run)
        results = simulate_with(variant, None), compensated(variant, ahead, 1.0), compensated(variant, ahead, 1.1)
        without, with_it, too_much = map(_error, results)
        along.append(Along(MOVES, far * distance, without, with_it, too_much=too_much))
    return along


def _at_rest(loop: Variant) -> Variant:
    """Return a loop that begins at rest under the constant force, without an unexplained force."""
    origin = float(loop.reference.component.sample(np.zeros(1), loop.reference.parameters)[0][0])
    return replace(loop, disturbance=None, injected=None, learning=None, start=Start(origin, effort=_held(loop)))


def _error(outcome: VariantResult) -> float:
    """Return the following error of a run, that of the load if the motor leads, peak to peak; inf if it diverged."""
    error = outcome.following_error if outcome.load_reference is None else outcome.true_error
    return math.inf if outcome.status is Status.NOT_FINITE else error.peak_to_peak


def effect_of_files(request: Request, drive: Drive | None, *, of_cogging: bool = False) -> Effect | None:
    """Return the effect of the files of a target with the force `drive`, or of the model without it; None without `drive` and loop."""
    friction, loop, axis = request.model, loop_for(request), request.axis
    if friction.component.family != "friction" or (loop is None and (drive is None or of_cogging)):
        return None
    fastest = request.speed or (axis and axis.velocity_limit) or FASTEST
    limits = limits_within(friction, request.plant, fastest)
    if axis is not None:
        limits = Limits(
            min(limits.velocity, axis.velocity_limit or math.inf),
            min(limits.acceleration, axis.acceleration_limit or math.inf),
            axis.jerk_limit or math.inf,
        )
    drive = drive or partial(response, friction, rest=request.rest)
    distance = turning_distance(friction, axis, limits.velocity)
    if loop is None:
        mass = sliding_level(friction, fastest) / limits_within(friction, request.plant, fastest).acceleration
        loops = assumed_loops(request, mass)
        return effect_in_assumed_loops(loops, driven_by(drive), limits, distance) if loops else None
    loop = replace(loop, feedforward=replace(loop.feedforward, plant=None)) if of_cogging else loop
    return effect_in_loop(loop, driven_by(drive), limits, distance, samples_ahead(loop))


def effect_of_law(variant: Variant) -> Effect | None:
    """Return the effect of the friction that a law feeds forward; None for a law without it."""
    fed = variant.feedforward
    if fed.friction is None and fed.table is None:
        return None
    friction = fed.friction or variant.friction
    loop = replace(variant, feedforward=replace(fed, friction=None, table=None, offset=0.0))
    t = variant.run.sample_time * np.arange(round(variant.run.duration / variant.run.sample_time))
    fastest = float(np.max(np.abs(variant.reference.component.sample(t, variant.reference.parameters)[1]), initial=0.0))
    limits = limits_within(friction, variant.plant, fastest or FASTEST)
    distance = turning_distance(friction, variant.axis, limits.velocity)
    if (screw := screw_of(fed)) is not None:  # the screw turns over with the friction of the table
        force = sliding_level(table_of(fed), screw.arm * limits.velocity)
        distance = max(distance[0], 2.0 * (force / screw.k + screw.gap) / screw.arm), False
    return replace(effect_in_loop(loop, fed_by(fed), limits, distance, 0), ahead=variant.run.delay + 1)
