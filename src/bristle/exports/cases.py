"""Moves of a loop without and with a feed, in cases that the identification cannot exclude.

Twelve cases for each of five distances, the reach F/K times 1, 3, 10, 30 and 100: rests of 0.05, 0.3 and 1 s between the moves,
quick moves and moves of 0.1 and 1 s, to and fro or with random signs. The friction of the axis is 13 % smaller or larger than
the model or equal; the half-width of the 95 % interval of its level adds to that as an independent error. Its lateness differs by
0.3 ms, and a force noise of 0.5 % of the friction acts, with the force of the log that the model does not explain.
The error of a case is the mean of the peak-to-peak errors of its moves. Without the feed the larger one of two noises counts.

A promise needs a margin, because few cases do not show all that can happen: the error falls by 40 %. During a rest of
1 s an integral takes the whole load over; there the feed halves the error. The promised factor counts a part that no friction
feedforward removes: the drive feeds an inertia forward that is 4 % wrong, with the largest acceleration.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core import Status, Variant
from bristle.exports.moves import TIMES, Limits, series_over
from bristle.models.friction.slots import scaled
from bristle.models.references import recorded
from bristle.prediction.claims import LEAST, LONGEST_REST, Claim, doubt_of
from bristle.simulation.run import simulate_with

Fed = Callable[[Variant, float], np.ndarray]
"""``fed(loop, late)``: the effort [N or N*m] at each sample of a loop that acts later than expected by a time [s]."""

# Durations of a move [s]; QUICK is as quick as the limits allow.
QUICK = 0.0
SHORT = 0.1
LONG = 1.0
RARE = 1.0  # the longest rest [s]
FARTHEST = 100.0  # distance of the longest moves, over the reach
LATER = 3e-4  # [s]
# Of the twelve cases of a distance: rest and duration of the moves [s], random signs, whether the friction of the axis is smaller
# (-1) or larger (1) than that of the model, and lateness [s].
PLAN = (
    (0.05, QUICK, False, -1, LATER),
    (0.05, QUICK, True, 1, -LATER),
    (0.3, QUICK, False, -1, LATER),
    (0.3, QUICK, True, 1, -LATER),
    (0.05, SHORT, True, 1, LATER),
    (0.3, SHORT, False, -1, -LATER),
    (0.3, SHORT, True, 0, LATER),
    (0.05, LONG, False, -1, LATER),
    (0.3, LONG, True, 1, -LATER),
    (RARE, QUICK, False, -1, LATER),
    (RARE, SHORT, True, 1, -LATER),
    (RARE, LONG, False, -1, LATER),
)
# Deviation of the friction level from an exact model, and the largest one, relative.
SPREAD = 0.13
MOST = 0.9
NOISE = 0.005  # of the friction
MOVES = {False: 16, True: 8}  # moves of a case, without and with long rests
# Largest ratio of the errors of a promised move.
OF_SHORT_RESTS = 0.7
OF_LONG_RESTS = 0.5
INERTIA = 0.04  # deviation of the inertia that a drive feeds forward, relative
CAREFUL = 0.75  # promised factor over that of the worst case, because few cases do not show all that can happen
# Ratio of the errors of moves that hardly improve; promised distance over that of such moves, at least.
POOR = 0.85
CLEAR = 5.0
HUNTING = 4  # cases that get worse of which more belong to an axis that hunts
SEEDS = (1, 2)


class Case(NamedTuple):
    """A sequence of moves, and the deviation of the axis from the model."""

    distance: float
    rest: float
    lasting: float
    is_random: bool
    friction: int
    late: float

    @property
    def is_brief(self) -> bool:
        """Whether neither rests nor moves last long."""
        return self.rest <= LONGEST_REST and self.lasting < LONG


class Unfed(NamedTuple):
    """A case without the feed: its loop, the first sample of each move, and its error [m or rad]."""

    case: Case
    loop: Variant
    starts: np.ndarray
    error: float


class Tried(NamedTuple):
    """A case with its errors without and with the feed, peak to peak [m or rad]; inf if the loop diverges."""

    case: Case
    without: float
    with_it: float

    @property
    def is_worse(self) -> bool:
        """Whether the feed makes the error larger."""
        return not self.with_it <= self.without

    @property
    def is_promised(self) -> bool:
        """Whether the feed lowers the error clearly."""
        most = OF_SHORT_RESTS
        if self.case.rest > LONGEST_REST:
            most = OF_LONG_RESTS
        return self.with_it <= most * self.without

    def ratio(self, common: float = 0.0) -> float:
        """Return the error with the feed divided by the error without it, beside an error of both [m or rad]."""
        return (self.with_it + common) / max(self.without + common, 1e-12)


def cases_over(reach: float) -> list[Case]:
    """Return the cases of a loop of this reach [m or rad]."""
    return [Case(times * reach, *deviation) for times in (*TIMES, FARTHEST) for deviation in PLAN]


def unfed_cases(loop: Variant, limits: Limits, reach: float, force: float) -> list[Unfed]:
    """Return each case in a loop at rest without a feed; the friction has a level [N or N*m]."""
    spread = min(math.hypot(SPREAD, doubt_of(loop.friction, loop.draws)), MOST)
    return [_unfed(case, loop, limits, force, spread) for case in cases_over(reach)]


def tried_cases(unfed: Sequence[Unfed], fed: Fed) -> list[Tried]:
    """Return the errors of each case without and with a feed."""
    return [
        Tried(run.case, run.error, _error(run.loop, fed(run.loop, run.case.late), run.starts))
        for run in unfed
    ]


def claims_of(
    tried: Sequence[Tried], reach: float, inertial: float = 0.0
) -> tuple[tuple[Claim, ...], bool]:
    """Return the moves that no case shows to get worse, and whether the axis hunts.

    An error [m or rad] that the drive leaves because of its own feedforward of inertia lowers the promised factor.
    """
    hunts = sum(trial.is_worse for trial in tried) > HUNTING
    # What an integral does during a long rest depends on small forces: then a promise for longer moves alone would not hold.
    rested = [
        trial
        for trial in tried
        if trial.case.rest > LONGEST_REST and trial.case.distance > 0.5 * LEAST * reach
    ]
    longest = LONGEST_REST
    if all(trial.is_promised for trial in rested):
        longest = RARE
    claims: list[Claim] = []
    for slowest, rest in [(LONG, longest), (None, LONGEST_REST)][hunts:]:
        inside = [
            trial
            for trial in tried
            if trial.case.rest <= rest and trial.case.lasting <= (slowest or 0.0)
        ]
        doubtful = max(
            (trial.case.distance for trial in inside if not trial.is_promised), default=0.0
        )
        # Moves that hardly improve where the rule promises an improvement cast doubt on the next longer ones, too.
        poor = max(
            (trial.case.distance for trial in inside if not trial.ratio() <= POOR), default=0.0
        )
        if poor >= LEAST * reach * (1.0 - 1e-9):
            doubtful = max(doubtful, CLEAR * poor)
        least = max(
            LEAST * reach,
            min(
                (trial.case.distance for trial in inside if trial.case.distance > doubtful),
                default=math.inf,
            ),
        )
        worst = max(
            (trial.ratio(inertial) for trial in inside if 2.0 * trial.case.distance > least),
            default=math.inf,
        )
        if math.isfinite(worst) and all(claim.least_distance > least for claim in claims):
            claims.append(Claim(least, slowest, rest, max(CAREFUL / worst, 1.0)))
    return tuple(claims), hunts


def least_of(claims: Sequence[Claim]) -> float:
    """Return the shortest promised distance [m or rad]; inf without a promise."""
    return min((claim.least_distance for claim in claims), default=math.inf)


def score_of(tried: Sequence[Tried], reach: float) -> float:
    """Return the mean ratio of the errors over moves with short rests that are long enough for a promise."""
    return float(
        np.mean(
            [
                trial.ratio()
                for trial in tried
                if trial.case.rest <= LONGEST_REST and trial.case.distance >= 0.99 * LEAST * reach
            ]
        )
    )


def _unfed(case: Case, loop: Variant, limits: Limits, force: float, spread: float) -> Unfed:
    dt = loop.run.sample_time
    positions, starts = _positions(case, limits, dt)
    assert loop.start is not None
    x = loop.start.position + positions
    run = replace(loop.run, duration=dt * x.size, settle=0.0, seeds=1)
    reference = recorded(kind=loop.plant.kind, position=x, sample_time=dt)
    friction = scaled(loop.friction, 1.0 + spread * case.friction)
    noise = [_noise(loop, x.size, force, seed) for seed in SEEDS]
    noisy = [
        replace(loop, friction=friction, reference=reference, run=run, disturbance=unseen)
        for unseen in noise
    ]
    return Unfed(case, noisy[0], starts, max(_error(variant, None, starts) for variant in noisy))


def _positions(case: Case, limits: Limits, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions of the moves from 0 [m or rad], and the first sample of each move."""
    signs = np.where(np.arange(MOVES[case.rest > LONGEST_REST]) % 2 == 0, 1.0, -1.0)
    if case.is_random:
        signs = np.random.default_rng(0).permutation(signs)
    return series_over(case.distance, limits, dt, signs, rest=case.rest, lasting=case.lasting)


def _noise(loop: Variant, count: int, force: float, seed: int) -> np.ndarray:
    """Return the force that the model does not explain, from a random place of its record on, with white noise."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, NOISE * force, count)
    if loop.disturbance is None:
        return noise
    return noise + np.resize(
        np.roll(loop.disturbance, -int(rng.integers(loop.disturbance.size))), count
    )


def _error(variant: Variant, effort: np.ndarray | None, starts: np.ndarray) -> float:
    """Return the mean of the peak-to-peak errors of the moves after the first; inf if the loop diverges."""
    outcome = simulate_with(variant, effort)
    if outcome.status is Status.NOT_FINITE:
        return math.inf
    error = outcome.reference - outcome.position
    return float(
        np.mean([np.ptp(error[first:last]) for first, last in pairwise(starts[1:].tolist())])
    )
