r"""The interval of a change, from resampled cycles.

The samples of a log are not independent: errors keep their sign for long, and the motion repeats. Therefore whole
cycles are drawn with replacement [1]_, each a block that keeps its samples together. If each motion has several cycles
in each of the two logs, every log is drawn separately and each motion keeps its share. If a motion occurs once, its
two cycles, one of each log, are drawn together, and the interval is that of the ratio of both sides: the size of an
error differs between motions more than the factor of its change.

Cycles may be correlated with their neighbours, as while an axis warms up. With the correlations :math:`\rho_k` between
the effects of a cycle and of the `k`-th cycle after it, up to the first insignificant correlation,
:math:`\tau = 1 + 2 \sum_k \rho_k` cycles count as one [2]_. Few cycles underestimate the scatter: a variance from `n`
of them is raised by :math:`\tau\, n / (n - 1)`, and the interval is that of Student's t with :math:`n / \tau - 1`
degrees of freedom, for two logs by the rule of Welch and Satterthwaite [3]_.

The mean of a quantity differs between the recordings of a side more than its cycles show. The logs of a side with
several logs are therefore its replicates: its variance is that of the sums of the effects of the cycles of each log,
with a degree of freedom less than logs. A drift, for example from warming up, cancels in the change if both sides have
the same mean place in time, as in the order before, after, after, before. Each side with four logs or more then loses
the straight line through its logs, which has its own slope on each side, and another degree of freedom.

References
----------
.. [1] A. C. Davison, D. V. Hinkley, "Bootstrap Methods and their Application", Cambridge University Press, 1997.
   doi:10.1017/CBO9780511802843
.. [2] C. J. Geyer, "Practical Markov chain Monte Carlo", Statistical Science 7(4), 1992. doi:10.1214/ss/1177011137
.. [3] B. L. Welch, "The generalization of 'Student's' problem when several different population variances are
   involved", Biometrika 34(1-2), 1947. doi:10.1093/biomet/34.1-2.28
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bristle.core.least_squares import unbounded

DRAWS = 1000
SEED = 20_261_121
MANY = 4  # logs of a side: enough for a straight line through them
PAIRS = 6  # motions from which on they are drawn as pairs, if each is rare
OFTEN = 4  # repetitions in a log from which on a motion is not rare
LARGEST = 100.0  # logarithm of a reported ratio

Value = Callable[[np.ndarray], np.ndarray]


class Plan(NamedTuple):
    """The compared cycles of two sides with their motions and logs, and whether cycles are drawn as pairs, and logs follow in time."""

    before: np.ndarray
    after: np.ndarray
    kinds_before: np.ndarray
    kinds_after: np.ndarray
    paired: bool
    logs_before: np.ndarray
    logs_after: np.ndarray
    in_turn: bool = False

    @property
    def drift_cancels(self) -> bool:
        """Whether a drift has the same mean effect on both sides."""
        return self.in_turn and bool(
            np.mean(np.unique(self.logs_before)) == np.mean(np.unique(self.logs_after))
        )


class Changed(NamedTuple):
    """A quantity before and after, the 95 % interval of the change, and the number of correlated cycles."""

    before: float
    after: float
    interval: tuple[float, float] | None
    as_one: float


def plan_of(
    kinds_before: ArrayLike,
    kinds_after: ArrayLike,
    logs_before: ArrayLike = 0,
    logs_after: ArrayLike = 0,
) -> Plan:
    """Return the cycles to compare, by their motions: those of both sides; empty if they share no motion."""
    sides = np.asarray(kinds_before, dtype=int), np.asarray(kinds_after, dtype=int)
    logs = [
        np.broadcast_to(own, side.shape)
        for own, side in zip((logs_before, logs_after), sides, strict=True)
    ]
    shared = np.intersect1d(*sides)
    repeated = [kind for kind in shared if min(np.sum(side == kind) for side in sides) >= 2]
    often = sum(int(np.sum(side == kind)) for side in sides for kind in repeated)
    cycle_count = sum(int(np.sum(side == kind)) for side in sides for kind in shared)
    paired = 2 * often < cycle_count or (
        len(shared) >= PAIRS and cycle_count < 2 * OFTEN * len(shared)
    )
    low, high = (np.flatnonzero(np.isin(side, shared if paired else repeated)) for side in sides)
    return Plan(low, high, sides[0][low], sides[1][high], paired, logs[0][low], logs[1][high])


def changed(value: Value, before: np.ndarray, after: np.ndarray, plan: Plan) -> Changed | None:
    """Return a quantity of both sides and the interval of its change, without cycles whose sums are zero; None if undetermined."""
    low = before.any(axis=1)
    high = after.any(axis=1)
    own = plan_of(
        plan.kinds_before[low], plan.kinds_after[high], plan.logs_before[low], plan.logs_after[high]
    )
    if not own.before.size:
        return None
    before = before[low][own.before]
    after = after[high][own.after]
    plan = own._replace(in_turn=plan.in_turn)
    if plan.paired:
        return _pairs(value, before, after, plan)
    # Each motion has the weight of the side with fewer repetitions.
    counts = (np.bincount(kinds) for kinds in (plan.kinds_before, plan.kinds_after))
    shares = {
        kind: float(min(pair)) for kind, pair in enumerate(zip(*counts, strict=True)) if min(pair)
    }
    sides = (
        (before, plan.kinds_before, plan.logs_before),
        (after, plan.kinds_after, plan.logs_after),
    )
    first, second = (_drawn(value, *side, shares, drifts=plan.drift_cancels) for side in sides)
    variance = first.variance + second.variance
    spread = first.variance**2 / first.freedom + second.variance**2 / second.freedom
    freedom = first.freedom + second.freedom
    if spread > 0.0:
        freedom = variance**2 / spread
    return Changed(
        first.value,
        second.value,
        _interval(second.value - first.value, variance, freedom),
        max(first.as_one, second.as_one),
    )


class _Drawn(NamedTuple):
    """A quantity of a side, its variance with its degrees of freedom, and the number of correlated cycles."""

    value: float
    variance: float
    freedom: float
    as_one: float


def _drawn(
    value: Value,
    sums: np.ndarray,
    kinds: np.ndarray,
    logs: np.ndarray,
    shares: dict[int, float],
    *,
    drifts: bool,
) -> _Drawn:
    weights = np.array([shares[kind] / np.sum(kinds == kind) for kind in kinds])
    influence = _influence(value, sums, weights, kinds)
    if np.unique(logs).size > 1:
        return _Drawn(float(value(weights @ sums)), *_between(influence, logs, drifts=drifts), 1.0)
    as_one = _as_one(influence)
    rng = np.random.default_rng(SEED)
    drawn = np.zeros((DRAWS, kinds.size))
    for kind in shares:
        members = np.flatnonzero(kinds == kind)
        drawn[:, members] = _draws(members.size, rng)
    return _Drawn(
        float(value(weights @ sums)),
        *_spread(value(drawn * weights @ sums), kinds.size, len(shares), as_one),
        as_one,
    )


def _between(influence: np.ndarray, logs: np.ndarray, *, drifts: bool) -> tuple[float, float]:
    """Return the variance of a quantity from the scatter of its logs, about a straight line if it drifts, and its degrees of freedom."""
    places, own = np.unique(logs, return_inverse=True)
    count = places.size
    # Without a cycle, the mean of the others moves by more than its share.
    effects = np.bincount(own, influence) * (1.0 - 1.0 / influence.size)
    columns = np.vander(places - np.mean(places), 2 if drifts and count >= MANY else 1)
    rest = effects - columns @ unbounded(columns, effects)
    freedom = count - columns.shape[1]
    return count * float(rest @ rest) / freedom, float(freedom)


def _pairs(value: Value, before: np.ndarray, after: np.ndarray, plan: Plan) -> Changed:
    """Return the change of a quantity, with motions drawn on both sides together."""
    kinds = plan.kinds_before[np.sort(np.unique(plan.kinds_before, return_index=True)[1])]
    low, high = (
        np.stack([sums[own == kind].mean(axis=0) for kind in kinds])
        for sums, own in ((before, plan.kinds_before), (after, plan.kinds_after))
    )
    first = float(value(low.sum(axis=0)))
    second = float(value(high.sum(axis=0)))
    if kinds.size < 2:
        return Changed(first, second, None, 1.0)
    even = np.ones(kinds.size)
    alike = np.zeros(kinds.size, dtype=int)
    influences = _influence(value, low, even, alike), _influence(value, high, even, alike)
    as_one = _as_one(first * influences[1] - second * influences[0])  # that of the ratio
    drawn = _draws(kinds.size, np.random.default_rng(SEED))
    draws = np.stack([value(drawn @ low), value(drawn @ high)])
    draws = draws[:, np.isfinite(draws).all(axis=0)]  # a draw may lack the data of a quantity
    if not min(first, second, np.min(draws, initial=math.inf)) > 0.0:  # the ratio is undefined
        return Changed(
            first,
            second,
            _interval(second - first, *_spread(draws[1] - draws[0], kinds.size, 1, as_one)),
            as_one,
        )
    ratio = _interval(
        math.log(second / first), *_spread(np.log(draws[1] / draws[0]), kinds.size, 1, as_one)
    )
    ends = None if ratio is None else tuple(first * math.expm1(min(end, LARGEST)) for end in ratio)
    return Changed(first, second, ends, as_one)  # type: ignore[arg-type]


def _influence(
    value: Value, sums: np.ndarray, weights: np.ndarray, kinds: np.ndarray
) -> np.ndarray:
    """Return the influence of each cycle on the quantity, above the mean of its motion, shape (cycle,)."""
    weighted = weights[:, None] * sums
    without = value(weighted.sum(axis=0) - weighted)
    mean = np.bincount(kinds, weights=without) / np.maximum(np.bincount(kinds), 1)
    return np.nan_to_num(mean[kinds] - without)


def _as_one(influence: np.ndarray) -> float:
    """Return the number of neighbours that count as one cycle, from 1 to half of them."""
    count = influence.size
    square = float(influence @ influence)
    as_one = 1.0
    for lag in range(1, max(count // 3, 2)):
        # Around their mean, uncorrelated numbers have a correlation of -1 / count.
        correlation = 0.0
        if square > 0.0:
            correlation = float(influence[lag:] @ influence[:-lag]) / square + 1.0 / count
        if correlation * math.sqrt(count) <= 0.5:  # standard deviations
            break
        as_one += 2.0 * correlation
    return max(min(as_one, 0.5 * count), 1.0)


def _draws(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return the number of times that each of `count` cycles is drawn, shape (draw, cycle)."""
    return rng.multinomial(count, np.full(count, 1.0 / count), DRAWS).astype(float)


def _spread(draws: np.ndarray, count: int, motions: int, as_one: float) -> tuple[float, float]:
    """Return the variance of draws, raised for few correlated cycles, and its degrees of freedom."""
    finite = draws[np.isfinite(draws)]
    variance = math.nan
    if finite.size > 1:
        variance = float(np.var(finite))
    return as_one * variance * count / (count - motions), max(count / as_one - motions, 1.0)


def _interval(change: float, variance: float, freedom: float) -> tuple[float, float] | None:
    from scipy.special import stdtrit

    if not (math.isfinite(change) and math.isfinite(variance)):
        return None
    half = float(stdtrit(freedom, 0.975)) * math.sqrt(variance)
    return change - half, change + half
