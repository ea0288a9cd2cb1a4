r"""The effect of an export on the axis: which moves it improves, and the loop without and with it.

bristle reads the numbers of the files back and simulates a drive that feeds forward :math:`u_{ff}` from them, in the loop of
the axis with the identified lateness. Moves go from rest to rest over 1, 3, 10 and 30 times the reach F/K, the sliding
friction over the stiffness of the position loop (`bristle.prediction.claims`). Cases that the identification cannot exclude
decide what the files promise (`bristle.exports.cases`). Without a controller there is no loop to simulate: then the promise is
that of the rule, if the log shows the stiffness, and otherwise there is none.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Axis, Model, Status, cached_property, number
from bristle.core.experiment import Experiment, Feedforward, Start, Variant
from bristle.core.variable import Kind, unit_of
from bristle.engine import conditioned
from bristle.engine.contact import level_of, sliding_level
from bristle.engine.motion import compensation_along
from bristle.exports.cases import (
    INERTIA,
    Tried,
    Unfed,
    claims_of,
    least_of,
    score_of,
    tried_cases,
    unfed_cases,
)
from bristle.exports.described import Request
from bristle.exports.loops import late_of, lead_of, loop_for, reach_for
from bristle.exports.moves import (
    FASTEST,
    TIMES,
    Limits,
    fastest_of,
    limits_within,
    moved_by,
    moves_over,
    turning_distance,
)
from bristle.models.controllers.feedforward import Rule, Shape
from bristle.models.friction import with_presliding
from bristle.models.friction.level import rises_with_effort
from bristle.models.friction.resting import with_rest
from bristle.models.friction.slots import whole_parts
from bristle.models.references import recorded
from bristle.prediction.claims import (
    CONSTANT_GAINS,
    LEAST,
    LONGEST_REST,
    SLOW_FADE,
    Claim,
    Compensation,
    claims_for,
    reach_of,
    rule_for,
    samples_ahead,
)
from bristle.simulation.compensation import settling, shape_of
from bristle.simulation.result import VariantResult
from bristle.simulation.run import simulate_with
from bristle.simulation.two_masses import screw_of, table_of

Drive = Callable[[np.ndarray, float], np.ndarray]
"""``drive(x, dt)``: the force [N or N*m] fed forward for the step that ends at each desired position."""
Compensated = Callable[[Variant, int], VariantResult]
"""``compensated(loop, ahead)``: the run of a loop with a feedforward, `ahead` samples early."""

WORSE = 1.05  # ratio of two errors that count as different
TINY = 1e-12  # an error or a ratio below it counts as zero
PREFIXES = ("", 1.0), ("m", 1e3)
FAR = 10.0  # moves over so many times the reach must not get worse
MOVES = "moves"
LOG = "log"
EXPERIMENT = "experiment"


class Along(NamedTuple):
    """One motion: its kind, its distance (0 for a log), and the error without and with the export.

    `not_ahead` is the error if the desired motion is not fed ahead. Errors are peak to peak [m or rad].
    """

    motion: str
    distance: float
    without: float
    with_it: float
    not_ahead: float = math.nan

    @property
    def is_worse(self) -> bool:
        """Whether the export makes the error larger, or the loop diverge."""
        return not self.with_it <= WORSE * self.without

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
        The errors along each motion: first the moves, last the motion of the log; empty without a loop.
    kind : {"translational", "rotational"}
        The kind of axis.
    reach : float
        Sliding friction over the stiffness of the position loop [m or rad].
    claims : tuple of Claim or None
        The moves that do not get worse; None for a model that is not from a log, whose error is unknown.
    ahead : int
        Cycles of the controller by which the desired motion is fed ahead.
    late : float
        Time by which an effort acts after its command [s].
    hunts : bool
        Whether moves with long rests, or slow ones, get worse in many cases.
    assumed : float
        Pre-sliding distance that bristle assumes [m or rad]; 0 if model or axis file has one.
    mass : float
        Mass or inertia that the drive must also feed forward [kg or kg*m^2]; 0 if the files do, or without a loop.
    """

    along: tuple[Along, ...]
    kind: Kind
    reach: float
    claims: tuple[Claim, ...] | None
    ahead: int
    late: float
    hunts: bool = False
    assumed: float = 0.0
    mass: float = 0.0

    @property
    def moves(self) -> list[Along]:
        """The moves, the shortest first."""
        return [path for path in self.along if path.motion == MOVES]

    @property
    def is_harmful(self) -> bool:
        """Whether the export increases the error along the motion of the log, or along far moves without a promise for farther ones."""
        far = FAR * (1.0 - 1e-9) * self.reach
        return any(
            path.is_worse and (path.motion != MOVES or (path.distance >= far and not self.claims))
            for path in self.along
        )

    @property
    def ratio(self) -> float:
        """Ratio of the errors with and without the export, geometric mean over all motions; inf if one diverges."""
        ratios = [path.ratio for path in self.along]
        return float(np.exp(np.mean(np.log(np.maximum(ratios, TINY)))))

    @property
    def least_distance(self) -> float:
        """Distance from which the export improves quick moves [m or rad]; inf if it promises none."""
        return least_of(self.claims or ())

    def lines(self) -> tuple[str, ...]:
        """Return the effect in sentences, the most important first."""
        lines = self._verdict()
        if self.moves:
            sizes = [
                f"{self._change(path)} in moves of {self._length(path.distance)}"
                for path in self._ends()
            ]
            case = "worst case"
            if self.claims is None:
                case = "exact model"
            lines.append(
                f"simulated following error, peak to peak, without -> with compensation, {case}: {'; '.join(sizes)}"
            )
        lines += [
            f"also {claim.text(self._length(claim.least_distance))}"
            for claim in (self.claims or ())[1:]
        ]
        for own in (path for path in self.along if path.motion != MOVES):
            late = ""
            if not math.isnan(own.not_ahead):
                late = f", {self._length(own.not_ahead)} if the motion is not fed ahead"
            lines.append(f"along the motion of the {own.motion}: {self._change(own)}{late}")
        if self.hunts:
            lines.append(
                "the axis hunts with rests of 1 s: there the compensation can make the error larger"
            )
        if self.assumed:
            lines.append(
                f"the pre-sliding distance is unknown, and bristle assumes {self._length(self.assumed)}: "
                "write presliding under [plant] of the axis file"
            )
        return tuple(lines)

    def as_data(self) -> dict[str, Any]:
        """Return the effect as data for JSON, in SI units of the axis."""
        along = [
            {
                "motion": path.motion,
                "distance": path.distance or None,
                "without": path.without,
                "with": path.with_it,
            }
            | {"worse": path.is_worse, "not_fed_ahead": path.not_ahead}
            for path in self.along
        ]
        claims = None
        if self.claims is not None:
            claims = [claim._asdict() for claim in self.claims]
        return (
            {
                "quantity": "following_error",
                "unit": unit_of("length", self.kind),
                "reach": self.reach,
            }
            | {"claims": claims, "hunts": self.hunts}
            | {
                "samples_ahead": self.ahead,
                "late": self.late,
                "mass": self.mass,
                "harmful": self.is_harmful,
            }
            | {"least_distance": self.least_distance, "along": along}
        )

    def _verdict(self) -> list[str]:
        if self.claims:
            helped = self.claims[0].text(self._length(self.claims[0].least_distance))
            if self.mass:
                helped += f", in a drive that also feeds the acceleration of {self.mass:.3g} {unit_of('mass', self.kind)} forward"
            return [f"the compensation helps {helped}; shorter moves can get worse"]
        farthest = self._length(TIMES[-1] * self.reach)
        if any(path.is_worse for path in self.moves):
            return [
                f"the compensation can harm moves up to {farthest}: do not use it for moves from rest to rest"
            ]
        if self.claims is None:
            return []
        return [
            f"bristle promises nothing for moves from rest to rest up to {farthest}: some do not clearly improve in simulated cases"
        ]

    def _ends(self) -> list[Along]:
        """Return the shortest promised move and the longest one, or the worst."""
        promised = [
            path for path in self.moves if path.distance >= self.least_distance * (1.0 - 1e-9)
        ]
        if promised:
            return [promised[0], promised[-1]]
        return [max(self.moves, key=lambda path: path.ratio)]

    def _change(self, path: Along) -> str:
        return f"{self._length(path.without)} -> {self._length(path.with_it)}"

    def _length(self, value: float) -> str:
        return length_text(value, self.kind)


def length_text(value: float, kind: Kind) -> str:
    """Return a distance as text in ASCII; an infinite one is the error of a loop that diverges."""
    if not math.isfinite(value):
        return "diverges"
    prefix, factor = next((prefix for prefix in PREFIXES if value * prefix[1] >= 1.0), ("u", 1e6))
    return f"{number(factor * value, digits=3)} {prefix}{unit_of('length', kind)}"


def fed_along(drive: Drive, loop: Variant, ahead: int, late: float = 0.0) -> np.ndarray:
    """Return the feed of a drive at each sample of a loop, `ahead` samples early; it acts later by a time [s]."""
    dt = loop.run.sample_time
    count = round(loop.run.duration / dt)
    x = loop.reference.component.sample(dt * np.arange(count + ahead), loop.reference.parameters)[0]
    effort = drive(x, dt)[ahead:]
    if late:
        effort = np.interp(np.arange(effort.size) - late / dt, np.arange(effort.size), effort)
    return effort


def driven_by(drive: Drive) -> Compensated:
    """Return a function that runs a loop with the feed of a drive."""
    return lambda loop, ahead: simulate_with(loop, fed_along(drive, loop, ahead))


def drive_of_law(feedforward: Feedforward) -> Drive | None:
    """Return the friction that a law feeds forward along a desired motion.

    None where it also needs other signals, and for a share of the whole force: that is a choice of the experiment, not of an
    identification.
    """
    friction = feedforward.friction
    if (
        friction is None
        or feedforward.scaled == "force"
        or feedforward.along == "measured"
        or rises_with_effort(friction)
        or screw_of(feedforward) is not None
    ):
        return None
    return drive_of(
        with_rest(friction, feedforward.rest), shape_of(feedforward), feedforward.conditioning
    )


def drive_of(friction: Model, shape: Shape, conditioning: float = 0.0) -> Drive:
    """Return the feed of a friction model with a shape, whose memory is conditioned with an amplitude [m or rad]."""

    def drive(x: np.ndarray, dt: float) -> np.ndarray:
        state, memory = conditioned(friction, conditioning)
        return compensation_along(
            friction, shape, np.diff(x, prepend=x[:1]) / dt, dt, x, state=state, memory=memory
        )

    return drive


@dataclass(frozen=True)
class InLoop:
    """A loop of an axis without friction fed forward: the limits of its moves, reach [m or rad], lateness [s], pre-sliding [m or rad]."""

    loop: Variant
    limits: Limits
    reach: float
    late: float
    presliding: float
    assumed: float = 0.0

    @property
    def ahead(self) -> int:
        """Samples of the loop by which the desired motion is fed ahead."""
        return samples_ahead(self.late, self.loop.run.sample_time)

    def effect(self, compensated: Compensated) -> Effect:
        """Return the effect along moves and along the motion of the loop, without a promise."""
        along = [self._move(times, compensated) for times in TIMES]
        loop = self._with_presliding
        dt = self.loop.run.sample_time
        own = loop.first(min(round(loop.run.duration / dt), 60_000))
        count = round(own.run.duration / dt)
        if (
            np.ptp(
                own.reference.component.sample(dt * np.arange(count), own.reference.parameters)[0]
            )
            > 0.0
        ):
            results = [simulate_with(own, None), compensated(own, self.ahead), compensated(own, 0)]
            motion = EXPERIMENT
            if own.reference.component is recorded:
                motion = LOG
            along.append(Along(motion, 0.0, *map(_error, results)))
        return Effect(
            tuple(along),
            loop.plant.kind,
            self.reach,
            None,
            self.ahead,
            self.late,
            assumed=self.assumed,
            mass=loop.feedforward.mass,
        )

    @property
    def _with_presliding(self) -> Variant:
        """The loop with a pre-sliding distance."""
        return replace(self.loop, friction=with_presliding(self.loop.friction, self.presliding))

    @cached_property
    def _unfed(self) -> list[Unfed]:
        begun = replace(_at_rest(self._with_presliding), disturbance=self.loop.disturbance)
        return unfed_cases(
            begun, self.limits, self.reach, level_of(self.loop.friction, self.limits.velocity)
        )

    def tried(self, drive: Drive, *, brief: bool = False) -> list[Tried]:
        """Return the cases of this loop with the feed of a drive, or only the brief ones that a promise may contain."""
        unfed = [
            run
            for run in self._unfed
            if not brief or (run.case.is_brief and run.case.distance > 2.0 * self.reach)
        ]
        return tried_cases(unfed, lambda loop, late: fed_along(drive, loop, self.ahead, late))

    def best_rule(
        self, usual: Rule, drive_with: Callable[[Rule], Drive | None]
    ) -> tuple[Rule, Drive]:
        """Return the rule that promises the shortest brief moves, among equals that with the smallest error, and its feed.

        A share that fades suits long rests. A constant share suits random moves with short rests. A small one suits an
        integral that winds quickly.
        """
        choices: dict[tuple[Rule, Drive], tuple[float, float]] = {}
        for rule in (
            usual,
            usual._replace(fade_time=SLOW_FADE),
            *(usual._replace(gain=gain, return_distance=0.0) for gain in CONSTANT_GAINS),
        ):
            drive = drive_with(rule)
            assert drive is not None
            tried = self.tried(drive, brief=True)
            choices[rule, drive] = (
                max(least_of(self.claims(tried)[0]), LEAST * self.reach),
                score_of(tried, self.reach),
            )
        return min(choices, key=choices.__getitem__)

    def claims(self, tried: list[Tried]) -> tuple[tuple[Claim, ...], bool]:
        """Return the promise of cases, and whether the axis hunts."""
        # Of the effort that the drive feeds forward too much.
        share = (
            INERTIA
            * moved_by(self.loop.plant)
            * self.limits.acceleration
            / level_of(self.loop.friction, self.limits.velocity)
        )
        return claims_of(tried, self.reach, 2.0 * share * self.reach)

    def promised(self, effect: Effect, tried: list[Tried]) -> Effect:
        """Return an effect with the promise of its cases, and with the worst case of each promised move."""
        claims, hunts = self.claims(tried)
        along = []
        for path in effect.along:
            if path.motion == MOVES:
                path = _worst_of(path, tried)
            along.append(path)
        return replace(effect, along=tuple(along), claims=claims, hunts=hunts)

    def _move(self, times: float, compensated: Compensated) -> Along:
        begun = _at_rest(self._with_presliding)
        dt = self.loop.run.sample_time
        assert begun.start is not None
        x = begun.start.position + moves_over(times * self.reach, self.limits, dt)
        run = replace(self.loop.run, duration=dt * x.size, settle=settling(dt * x.size), seeds=1)
        variant = replace(
            begun,
            reference=recorded(kind=self.loop.plant.kind, position=x, sample_time=dt),
            run=run,
        )
        return Along(
            MOVES,
            times * self.reach,
            _error(simulate_with(variant, None)),
            _error(compensated(variant, self.ahead)),
        )


def _worst_of(path: Along, tried: list[Tried]) -> Along:
    """Return a move with the errors of its worst case among quick moves with short rests."""
    near = [
        trial
        for trial in tried
        if math.isclose(trial.case.distance, path.distance) and not trial.case.lasting
    ]
    worst = max((trial for trial in near if trial.case.rest <= LONGEST_REST), key=Tried.ratio)
    return path._replace(without=worst.without, with_it=worst.with_it)


def _at_rest(loop: Variant) -> Variant:
    """Return a loop that begins at rest under the constant force, without an unexplained force."""
    origin = float(loop.reference.component.sample(np.zeros(1), loop.reference.parameters)[0][0])
    return replace(
        loop,
        disturbance=None,
        injected=None,
        learning=None,
        start=Start(origin, effort=whole_parts(loop.friction)["constant"]),
    )


def _error(outcome: VariantResult) -> float:
    """Return the following error of a run, that of the load if the motor leads, peak to peak; inf if it diverged."""
    if outcome.status is Status.NOT_FINITE:
        return math.inf
    if outcome.load_reference is None:
        return outcome.following_error.peak_to_peak
    return outcome.true_error.peak_to_peak


def with_best_rule(request: Request) -> tuple[Request, Effect | None]:
    """Return the request of a compensator with the best rule, and its effect; without a loop to simulate, a constant share."""
    within = _within(request)
    if not request.share.return_distance:
        return request, effect_of_files(request, None)
    if within is None:
        return replace(request, rule=rule_for(request.friction, None)), effect_of_files(
            request, None
        )
    rule, drive = within.best_rule(
        request.share, lambda rule: drive_of(request.sampled, Shape(**rule._asdict()))
    )
    effect = replace(within.effect(driven_by(drive)), ahead=lead_of(request))
    return replace(request, rule=rule), within.promised(effect, within.tried(drive))


def _within(request: Request) -> InLoop | None:
    """Return the loop of a request; None without a loop whose stiffness is known."""
    loop = loop_for(request)
    reach = reach_for(request)
    if loop is None or reach is None:
        return None
    limits = limits_within(request.friction, request.plant, fastest_of(request), request.axis)
    distance, assumed = turning_distance(request.friction, request.axis, limits.velocity)
    return InLoop(loop, limits, reach, late_of(request), distance, assumed)


def effect_of_files(
    request: Request, drive: Drive | None, *, of_cogging: bool = False, promises: bool = True
) -> Effect | None:
    """Return the effect of the files of a target with the force `drive`, or of the feed of the model without it.

    None without a loop whose stiffness is known.
    """
    within = _within(request)
    reach = reach_for(request)
    if reach is None:
        return None
    if within is None:
        if of_cogging or not request.is_from_log:
            return None
        return Effect(
            *(
                (),
                request.friction.kind,
                reach,
                claims_for(reach),
                lead_of(request),
                late_of(request),
            ),
            mass=moved_by(request.plant),
        )
    drive = drive or drive_of(request.sampled, Shape(**request.share._asdict()))
    if of_cogging:
        loop = within.loop
        within = replace(
            within, loop=replace(loop, feedforward=replace(loop.feedforward, plant=None))
        )
    effect = replace(within.effect(driven_by(drive)), ahead=lead_of(request))
    if not promises or of_cogging or not request.is_from_log:
        return effect
    return within.promised(effect, within.tried(drive))


def effect_of_law(variant: Variant) -> Effect | None:
    """Return the effect of the friction that a law feeds forward; None for a law without it, or without a stiffness."""
    within = loop_of_law(variant)
    if within is None:
        return None
    effect = within.effect(
        lambda loop, ahead: simulate_with(replace(loop, feedforward=variant.feedforward), None)
    )
    effect = replace(
        effect,
        along=tuple(path._replace(not_ahead=math.nan) for path in effect.along),
        ahead=variant.run.delay + 1,
        mass=0.0,
    )
    drive = drive_of_law(variant.feedforward)
    if drive is None:
        return effect
    return within.promised(effect, within.tried(drive))


def promise_of_law(variant: Variant) -> tuple[Claim, ...]:
    """Return the moves that the friction feedforward of a law helps; none without the share of an identification."""
    within = loop_of_law(variant)
    drive = drive_of_law(variant.feedforward)
    if within is None or drive is None:
        return ()
    return within.claims(within.tried(drive))[0]


def loop_of_law(variant: Variant) -> InLoop | None:
    """Return the loop of a law without its friction feedforward; None for a law without it, or without a stiffness."""
    feedforward = variant.feedforward
    if feedforward.friction is None and feedforward.table is None:
        return None
    friction: Model = feedforward.friction or variant.friction
    loop = replace(variant, feedforward=replace(feedforward, friction=None, table=None, offset=0.0))
    t = variant.run.sample_time * np.arange(round(variant.run.duration / variant.run.sample_time))
    fastest = float(
        np.max(
            np.abs(variant.reference.component.sample(t, variant.reference.parameters)[1]),
            initial=0.0,
        )
    )
    limits = limits_within(friction, variant.plant, fastest or FASTEST, variant.axis)
    reach = reach_of(variant.friction, variant.controller, {}, limits.velocity)
    if reach is None:
        return None
    distance, _ = turning_distance(friction, variant.axis, limits.velocity)
    screw = screw_of(feedforward)
    # The screw turns over with the friction of the table.
    if screw is not None:
        force = sliding_level(table_of(feedforward), screw.arm * limits.velocity)
        lost = 2.0 * (force / screw.k + screw.gap) / screw.arm
        reach = max(reach, lost)
        distance = max(distance, lost)
    late = variant.run.delay * variant.run.sample_time + variant.run.current_lag
    return InLoop(loop, limits, reach, late, distance)


def compensated_loop(
    experiment: Experiment, axis: Axis | None, draws: Mapping[str, np.ndarray], usual: Compensation
) -> tuple[Experiment, Compensation]:
    """Return the experiment of a log whose last variant has the best rule, and its promise; without a known loop, the usual ones.

    The cases of the promise use the limits of the axis and the draws of the parameters.
    """
    *plain, compensated = experiment.variants
    within = loop_of_law(replace(compensated, axis=axis, draws=draws))
    feedforward = compensated.feedforward
    if within is None or drive_of_law(feedforward) is None:
        return experiment, usual

    def with_rule(rule: Rule) -> Feedforward:
        return replace(
            feedforward,
            gain=rule.gain,
            return_distance=rule.return_distance,
            fade_time=rule.fade_time,
        )

    rule, drive = within.best_rule(usual.rule, lambda rule: drive_of_law(with_rule(rule)))
    claims = within.claims(within.tried(drive))[0]
    variants = (*plain, replace(compensated, feedforward=with_rule(rule)))
    return replace(experiment, variants=variants), Compensation(rule, within.reach, claims)
