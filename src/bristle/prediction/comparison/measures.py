r"""Quantities of each cycle, and their values from sums over cycles.

Every quantity is a function of sums over cycles, so that it exists for any selection of cycles: the sum of
squares for root mean squares, sum and number for peaks, the normal equations for friction.

The friction level is fitted to :math:`u = M a + c + \sum_b F_b\, \mathrm{sign}(v)\, [|v| \in b]` by least squares. The
speed ranges `b` are those that the compared parts of both logs have in both directions, so each :math:`F_b` is half the
difference between the directions at one speed. Inertia hardly matters, because a stroke passes each speed once speeding
up and once slowing down; `M` takes the remainder. The level is the mean of :math:`F_b` with the same weights in
both logs.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bristle.core.lazy import cached_property
from bristle.prediction.comparison.cycles import Cycle, Side
from bristle.prediction.comparison.resampling import plan_of
from bristle.prediction.comparison.result import Course, Turn

RANGES = 4  # of speed
SLOWEST = 0.1  # of the 95 % quantile of speed: slower rows are close to a reversal
FEWEST_ROWS = 20  # of a range, in each direction of each log
SMALL = 1e-10  # share of the diagonal of normal equations, added to it: makes a mass without acceleration 0

Sums = np.ndarray
SumsOf = Callable[[Side], np.ndarray]
TURNS = {"forward_to_backward": False, "backward_to_forward": True}


class Measure(NamedTuple):
    """A quantity: its name, its dimension (``length``, ``force``), its sums by cycle, and its value from sums."""

    name: str
    quantity: str
    sums: SumsOf
    value: Callable[[Sums], np.ndarray]


def _mean(sums: Sums) -> np.ndarray:
    with np.errstate(invalid="ignore", divide="ignore"):
        return sums[..., 0] / sums[..., 1]


def level_measures(signal: str, name: str, quantity: str) -> list[Measure]:
    """Return the root mean square of a signal, and its largest value in a cycle, averaged over cycles."""

    def squares(side: Side) -> np.ndarray:
        parts = [cycle.part(signal) for cycle in side.cycles]
        return np.array([(float(part @ part), part.size) for part in parts])

    def peaks(side: Side) -> np.ndarray:
        return np.array([(float(np.max(np.abs(cycle.part(signal)))), 1.0) for cycle in side.cycles])

    return [
        Measure(f"{name}.rms", quantity, squares, lambda sums: np.sqrt(_mean(sums))),
        Measure(f"{name}.peak", quantity, peaks, _mean),
    ]


def _turns_in(cycle: Cycle, window: int, *, forward: bool) -> list[int]:
    """Return the samples of a cycle at which the motion turns into one direction, if the log contains their window."""
    motion = cycle.recording.motion
    places = cycle.recording.turns
    inside = places[(places >= cycle.samples.start) & (places < cycle.samples.stop)]
    inside = inside[inside + window < motion.size]
    rises = motion[inside + window] > motion[inside]
    return inside[rises == forward].tolist()


def turn_measures(window: int) -> list[Measure]:
    """Return the largest following error in so many samples after a reversal, averaged over reversals, for each direction."""

    def peaks(forward: bool) -> SumsOf:
        def sums(side: Side) -> np.ndarray:
            collected = []
            for cycle in side.cycles:
                size = np.abs(cycle.recording.error)  # type: ignore[arg-type]
                places = _turns_in(cycle, window, forward=forward)
                collected.append(
                    (
                        sum(float(np.max(size[k : k + window + 1])) for k in places),
                        float(len(places)),
                    )
                )
            return np.array(collected)

        return sums

    return [
        Measure(f"reversals.{name}", "length", peaks(forward), _mean)
        for name, forward in TURNS.items()
    ]


def course_of(before: Side, after: Side, *, follows: bool) -> Course:
    """Return the mean of each motion, one after the other: following error, or effort without a reference."""
    signal = "effort"
    if follows:
        signal = "error"
    parts = []
    for kind in dict.fromkeys(before.kinds):
        low, high = (
            [cycle for cycle in side.cycles if cycle.kind == kind] for side in (before, after)
        )
        count = min(cycle.count for cycle in (*low, *high))
        courses = ((low, "motion"), (low, signal), (high, signal))
        parts.append(
            [
                np.mean([cycle.part(name)[:count] for cycle in cycles], axis=0)
                for cycles, name in courses
            ]
        )
    motion, first, second = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return Course(
        before.cycles[0].recording.sample_time * np.arange(motion.size), motion, first, second
    )


def turn_courses(before: Side, after: Side, window: int) -> tuple[Turn, ...]:
    """Return the mean following error around the reversals of each direction that both sides have."""
    collected = []
    steps = np.arange(-window, 3 * window + 1)  # one window before a reversal, three after it
    for name, forward in TURNS.items():
        rows = [
            [
                cycle.recording.error[place + steps]  # type: ignore[index]
                for cycle in side.cycles
                for place in _turns_in(cycle, window, forward=forward)
                if place + steps[0] >= 0 and place + steps[-1] < cycle.recording.motion.size
            ]
            for side in (before, after)
        ]
        if all(rows):
            collected.append(
                Turn(
                    name,
                    before.cycles[0].recording.sample_time * steps,
                    *(np.mean(own, axis=0) for own in rows),
                )
            )
    return tuple(collected)


class SlidingRows:
    """Rows of sliding of two sides, in ranges of speed that both have in both directions."""

    # A cycle without a row in any range does not determine friction: only motions whose rows enter the sums determine the
    # ranges.
    def __init__(self, before: Side, after: Side) -> None:
        self.kinds = np.intersect1d(before.kinds, after.kinds)
        sides = before, after
        while True:
            kinds = [
                np.array([cycle.kind for cycle in self._cycles(side)], dtype=int) for side in sides
            ]
            counts = self._counts(
                [[_rows(cycle)[0] for cycle in self._cycles(side)] for side in sides]
            )
            self.ranges = _serving(counts, kinds)
            counts = [count[..., self.ranges] for count in counts]
            serving = [
                own[count.any(axis=(1, 2))] for own, count in zip(kinds, counts, strict=True)
            ]
            compared = np.unique(plan_of(*serving).kinds_before)
            if compared.size == self.kinds.size:
                break
            self.kinds = compared
        self.weights = np.sum([count.sum(axis=(0, 1)) for count in counts], axis=0)

    def _cycles(self, side: Side) -> list[Cycle]:
        return [cycle for cycle in side.cycles if cycle.kind in self.kinds]

    def _counts(self, sides: Sequence[Sequence[np.ndarray]]) -> list[np.ndarray]:
        """Sort speeds into ranges; return the number of rows in each, for each side, shape (cycle, direction, range)."""
        pooled = np.abs(np.concatenate([np.empty(0), *sides[0], *sides[1]]))
        top = 0.0
        if pooled.size:
            top = float(np.quantile(pooled, 0.95))
        self._speeds = pooled[pooled > SLOWEST * top]
        fastest = float(np.max(self._speeds, initial=0.0)) * (1.0 + 1e-9)
        self.edges = np.linspace(SLOWEST * top, fastest, RANGES + 1)
        counts = (
            [[np.histogram(sign * v, self.edges)[0] for sign in (1, -1)] for v in side]
            for side in sides
        )
        return [np.reshape(count, (-1, 2, RANGES)).astype(int) for count in counts]

    @cached_property
    def speeds(self) -> list[float]:
        """Mean speed of each range [m/s or rad/s]."""
        place = np.searchsorted(self.edges, self._speeds, side="right") - 1
        return [float(np.mean(self._speeds[place == number])) for number in self.ranges]

    def measures(self) -> list[Measure]:
        """Return the friction level, and friction in each range of speed; empty without a usable range."""
        if not self.ranges.size:
            return []
        shares = self.weights / self.weights.sum()
        level = Measure(
            "friction.level", "force", self._sums, lambda sums: self._friction(sums) @ shares
        )
        names = (f"friction.at_speeds.{number}" for number in range(self.ranges.size))
        return [
            level,
            *(
                Measure(name, "force", self._sums, lambda sums, k=k: self._friction(sums)[..., k])
                for k, name in enumerate(names)
            ),
        ]

    def _sums(self, side: Side) -> np.ndarray:
        """Return the normal equations of each cycle, the matrix after the right side."""
        equations = []
        for cycle in side.cycles:
            v, a, u = _rows(cycle) if cycle.kind in self.kinds else np.empty((3, 0))
            place = np.searchsorted(self.edges, np.abs(v), side="right") - 1
            member = place == self.ranges[:, None]
            used = member.any(axis=0)
            columns = np.vstack([np.ones(v.size), np.sign(v) * member, a])[:, used]
            effort = u[used]
            equations.append(np.concatenate([columns @ effort, (columns @ columns.T).ravel()]))
        return np.array(equations)

    def _friction(self, sums: Sums) -> np.ndarray:
        """Return friction in each range, shape (..., range); NaN if a range lacks a direction."""
        size = self.ranges.size + 2
        right = sums[..., :size]
        matrix = sums[..., size:].reshape(*sums.shape[:-1], size, size)
        scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), np.finfo(float).tiny))
        scaled = matrix / (scale[..., :, None] * scale[..., None, :])
        solved = np.linalg.solve(scaled + SMALL * np.eye(size), (right / scale)[..., None])
        friction = (solved[..., 0] / scale)[..., 1:-1]
        rows = np.diagonal(matrix, axis1=-2, axis2=-1)[..., 1:-1]
        # Forward minus backward is the whole of a range in one direction: offset and friction are confounded there.
        return np.where(np.abs(matrix[..., 0, 1:-1]) < rows * (1.0 - SMALL), friction, np.nan)


def _serving(counts: Sequence[np.ndarray], kinds: Sequence[np.ndarray]) -> np.ndarray:
    """Return the ranges with enough rows of each side in each direction, from more than one drawn block."""
    paired = plan_of(*kinds).paired
    is_served = []
    for count, own in zip(counts, kinds, strict=True):
        blocks = count
        if paired:
            blocks = [count[own == kind].sum(axis=0) for kind in np.unique(own)]
        blocks = np.reshape(blocks, (-1, *count.shape[1:]))
        # A result from a single block shows no scatter when blocks are drawn anew.
        is_served.append((blocks.sum(axis=0) >= FEWEST_ROWS) & (np.sum(blocks > 0, axis=0) >= 2))
    return np.flatnonzero(np.all(is_served, axis=(0, 1)))


def _rows(cycle: Cycle) -> np.ndarray:
    """Return velocity, acceleration and effort of a cycle, shape (3, row)."""
    if cycle.recording.sliding is None:
        return np.empty((3, 0))
    part = cycle.recording.sliding[:, cycle.samples]
    return part[:, np.all(np.isfinite(part), axis=0)]
