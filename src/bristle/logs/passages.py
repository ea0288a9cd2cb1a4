"""Experiments that a log contains: slides at constant velocity, loops before sliding, break-aways, chirps, moves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any

import numpy as np

from bristle.core.axis import Axis
from bristle.core.edge import guarded, instance, optional
from bristle.logs.legs import Leg, graininess, legs_of, rests_of
from bristle.logs.log import Log

__all__ = ["KINDS", "Passage", "Stretch", "nesting", "passages", "passages_along"]


@guarded(log=instance(Log, "a log", "Write read_log(...)"), axis=optional(instance(Axis, "an axis")))
def passages(log: Log, axis: Axis | None = None) -> tuple[Passage, ...]:
    """Return the experiments that a log contains, in order.

    Parameters
    ----------
    log : Log
        Position over time, and the effort where there is one.
    axis : Axis, optional
        Its encoder and its pre-sliding distance, where known.
    """
    position, effort = log.position.values, None if log.effort is None else log.effort.values
    resolution = axis.resolution if axis is not None else None
    grain = graininess(position, resolution or log.position.step)
    ordered: list[Passage] = []
    for part in log.segments or (slice(0, position.size),):
        ordered += passages_along(
            log.time.values[part],
            position[part],
            None if effort is None else effort[part],
            grain,
            presliding=axis.presliding if axis is not None else None,
            start=part.start or 0,
        )
    return tuple(ordered)


def passages_along(
    time: np.ndarray, position: np.ndarray, effort: np.ndarray | None, grain: float, *, presliding: float | None = None, start: int = 0
) -> list[Passage]:
    """Return the experiments that one stretch without a gap contains, in order."""
    return Stretch(time, position, effort, grain, presliding, start).passages() if time.size > 1 else []


KINDS = {
    "constant_velocity": "slides at constant velocity",
    "loops": "loops before sliding",
    "break_away": "break-away from rest",
    "chirp": "oscillation of changing frequency",
    "oscillation": "oscillation of one frequency",
    "moves": "ordinary moves",
    "rest": "rest",
}


@dataclass(frozen=True)
class Passage:
    """A part of a log in which one kind of experiment was made."""

    kind: str
    samples: slice
    begin: float
    end: float
    legs: int = 0
    speeds: tuple[float, float] = (0.0, 0.0)
    amplitudes: tuple[float, float] = (0.0, 0.0)
    levels: int = 0
    depth: int = 0
    frequencies: tuple[float, float] = (0.0, 0.0)

    def as_data(self) -> dict[str, Any]:
        """Return it in numbers, in SI of the axis."""
        record = {name: value for name, value in vars(self).items() if name != "samples"}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in record.items()}


def nesting(turning: Iterable[float]) -> int:
    """Return how many turning points a contact must remember at most: those that lie inside one another."""
    points: list[float] = []
    most = 0
    for point in turning:
        # A turning point as far out as an earlier one wipes out what lies between them.
        while len(points) > 1 and abs(point - points[-1]) >= abs(points[-1] - points[-2]):
            points = points[:-2] if len(points) > 2 else points[1:]
        points.append(point)
        most = max(most, len(points))
    return most


SLIDING = 0.4  # share of a leg that is a cruise, from which on it is a slide
GRAINS = 20.0  # of the position, in a cruise: in fewer any speed looks constant
SETTLED = 0.07  # of the swing of the effort, by which it may still change in the second half of a slide
CLEAR = 5.0  # times its scatter, that a friction told by two legs must be
TURNED = 0.9  # of the swing of the effort: the contact has turned over
LONG_BREAK_AWAY = 0.15  # of a leg from rest, that the turning over of the contact takes
BREAK_AWAY_SAMPLES = 30
EDGE = 0.1  # of a cruise
NINTHS, PARTS = 9, 40  # of a cruise, and of a leg, in which the effort is averaged
SAMPLES = 2  # in each, at least
CHIRP_LEGS, SWEPT, ALIKE = 8, 2.0, 0.25
FALL = 0.7  # slope of amplitude over duration, both logarithmic: triangles at one speed have 1
SHORT_REST = 0.5  # [s] a shorter rest does not part what is alike
SAME_AMPLITUDE = 0.05
AS_SMALL = 1.3  # times the leg beside it


class Stretch:
    """One stretch of a log without a gap, on its way to passages."""

    def __init__(
        self, time: np.ndarray, position: np.ndarray, effort: np.ndarray | None, grain: float, presliding: float | None, start: int
    ) -> None:
        self.time, self.position, self.effort, self.start = time, position, effort, start
        self.grain, self.presliding = grain, presliding
        self.dt = float(time[-1] - time[0]) / (time.size - 1)
        self.rests = rests_of(self.position, grain, self.dt)
        self.legs = list(legs_of(self.position, self.rests, grain, self.dt))

    def passages(self) -> list[Passage]:
        """Return the passages in order, rests among them."""
        kinds = list(map(self._kind, self.legs))
        _leave_none_alone(self.legs, kinds)
        _mark_oscillations(self.legs, kinds)
        runs = self._joined(kinds)
        passages = [self._of_legs(kind, legs) for kind, legs in runs]
        for rest in self.rests:
            if not any(legs[0].first < rest.stop - 1 and rest.start < legs[-1].last for _, legs in runs):
                passages.append(self._passage("rest", rest.start, rest.stop - 1))
        return sorted(passages, key=attrgetter("samples.start"))

    def of_kind(self, kind: str) -> list[Leg]:
        """Return the legs that are of one kind by themselves, whatever lies beside them."""
        return [leg for leg in self.legs if self._kind(leg) == kind]

    def _kind(self, leg: Leg) -> str:
        if leg.cruise_share < SLIDING:
            return "moves"
        if not self._slides(leg):
            return "loops"
        if leg.speed * self.dt * (leg.cruise.stop - leg.cruise.start) < GRAINS * self.grain:
            return "moves"
        return "break_away" if leg.from_rest and self._breaks_away(leg) else "constant_velocity"

    def _slides(self, leg: Leg) -> bool:
        """Return whether friction has saturated in a leg: its effort has settled, or it is long enough."""
        if self.effort is None:
            return self.presliding is None or abs(leg.distance) > 2.0 * self.presliding
        settled = self._settled(leg)
        if settled is None:
            return self.presliding is not None and abs(leg.distance) > 2.0 * self.presliding
        return settled or self._settled_apart(leg)

    def _settled(self, leg: Leg) -> bool | None:
        """Return whether the effort has settled in the second half of a cruise; None where nobody can tell."""
        # What is left of speeding up and slowing down at either end of a cruise is not for friction to answer.
        edge = round(EDGE * (leg.cruise.stop - leg.cruise.start))
        begin, end = leg.cruise.start + edge, leg.cruise.stop - edge
        if end - begin < SAMPLES * NINTHS:
            return None
        course = self._course(begin, end, NINTHS)
        middle, late = float(course[3:6].mean()), float(course[6:].mean())
        # Of each level three means are taken, and a mean scatters by a share of what two of them differ by.
        scatter = float(np.std(np.diff(course))) / np.sqrt(3.0)
        return abs(late - middle) <= SETTLED * self._swing(leg) + scatter

    def _settled_apart(self, leg: Leg) -> bool:
        """Return whether the effort settles apart from what depends on the place: gravity, cogging, a cable.

        That is the same on the way back. Half of what both ways differ by is friction: constant along a leg that
        slides, and a lens where each way builds up from its own end.
        """
        at = self.legs.index(leg)
        beside = [self.legs[k] for k in (at - 1, at + 1) if 0 <= k < len(self.legs)]
        return any(self._level_between(leg, back) for back in beside if back.distance * leg.distance < 0.0)

    def _level_between(self, leg: Leg, back: Leg) -> bool:
        assert self.effort is not None
        ends = [np.sort(self.position[[way.cruise.start, way.cruise.stop]]) for way in (leg, back)]
        low, high = max(ends[0][0], ends[1][0]), min(ends[0][1], ends[1][1])
        if high - low < SLIDING * abs(leg.distance):
            return False
        marks = np.linspace(low, high, 2 * NINTHS + 1)
        ways = [self._over(way, marks) for way in (leg, back)]
        if any(np.any(counts < SAMPLES) for _, counts in ways):
            return False
        friction = 0.5 * float(np.sign(leg.distance)) * (ways[0][0] - ways[1][0])
        first, middle, last = (float(np.mean(part)) for part in (friction[1:5], friction[7:-7], friction[-5:-1]))
        scatter = float(np.std(np.diff(friction))) / np.sqrt(8.0)
        apart = max(abs(first - middle), abs(last - middle))
        return middle > CLEAR * scatter and apart <= 2.0 * SETTLED * middle + scatter

    def _over(self, leg: Leg, marks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean effort between marks of the position [N or N*m], and of how many samples each is."""
        assert self.effort is not None
        inside = slice(leg.cruise.start, leg.cruise.stop + 1)
        place = np.digitize(self.position[inside], marks)
        counts = np.bincount(place, minlength=marks.size + 1)[1:-1]
        sums = np.bincount(place, self.effort[inside], minlength=marks.size + 1)[1:-1]
        return sums / np.maximum(counts, 1), counts

    def _course(self, begin: int, end: int, count: int) -> np.ndarray:
        """Return the mean effort of so many parts of a stretch [N or N*m]: single samples are mostly noise."""
        assert self.effort is not None
        marks = np.unique(np.linspace(begin, end, count + 1).astype(int))
        return np.add.reduceat(self.effort[: marks[-1]], marks[:-1]) / np.diff(marks)

    def _swing(self, leg: Leg) -> float:
        """Return by how much the effort changes in a leg [N or N*m]."""
        return float(np.ptp(self._course(leg.first, leg.last + 1, PARTS)))

    def _breaks_away(self, leg: Leg) -> bool:
        """Return whether a good part of a leg from rest is the contact turning over, slowly enough to see it."""
        # A force of the place may rise along a leg as well.
        if self.effort is None or not self._settled(leg):
            return False
        course = self._course(leg.first, leg.last + 1, PARTS) * np.sign(leg.distance)
        steady = float(self.effort[(leg.cruise.start + leg.cruise.stop) // 2 : leg.cruise.stop].mean())
        steady *= float(np.sign(leg.distance))
        before = float(np.median(self.effort[leg.first : leg.first + SAMPLES])) * float(np.sign(leg.distance))
        level = steady - before
        if level < 0.5 * max(self._swing(leg), abs(steady)):
            return False
        samples = round(float(np.argmax(course - before >= TURNED * level)) / course.size * (leg.last - leg.first))
        moved = abs(self.position[leg.first + samples] - self.position[leg.first])
        return samples >= BREAK_AWAY_SAMPLES and moved >= LONG_BREAK_AWAY * abs(leg.distance)

    def _joined(self, kinds: Sequence[str]) -> list[tuple[str, list[Leg]]]:
        """Return runs of legs of one kind, not parted by a long rest."""
        runs: list[tuple[str, list[Leg]]] = []
        for kind, leg in zip(kinds, self.legs, strict=True):
            if runs and runs[-1][0] == kind:
                gap = self.dt * (leg.first - runs[-1][1][-1].last)
                if gap <= SHORT_REST:
                    runs[-1][1].append(leg)
                    continue
            runs.append((kind, [leg]))
        return runs

    def _of_legs(self, kind: str, legs: Sequence[Leg]) -> Passage:
        only_from_rest = all(map(attrgetter("from_rest"), legs))
        amplitudes = np.array([0.5 * abs(leg.distance) for leg in legs if only_from_rest or not leg.from_rest])
        speeds = list(map(attrgetter("speed"), legs))
        frequencies = (0.0, 0.0)
        if kind in ("chirp", "oscillation"):
            # The first and the last leg are no whole half periods; of the shortest a sample is a good part.
            rates = [0.5 / leg.duration for leg in legs[1:-1]]
            frequencies = (min(rates), float(np.quantile(rates, 0.98)))
        turning = self.position[[legs[0].first, *map(attrgetter("last"), legs)]].tolist()
        return self._passage(
            kind,
            legs[0].first,
            legs[-1].last,
            legs=len(legs),
            speeds=(min(speeds), max(speeds)),
            amplitudes=(float(amplitudes.min()), float(amplitudes.max())),
            levels=_levels(amplitudes, self.grain),
            depth=nesting(turning) if kind == "loops" else 0,
            frequencies=frequencies,
        )

    def _passage(self, kind: str, first: int, last: int, **facts: Any) -> Passage:
        samples = slice(self.start + first, self.start + last + 1)
        return Passage(kind, samples, float(self.time[first]), float(self.time[last]), **facts)


def _levels(amplitudes: np.ndarray, grain: float) -> int:
    """Return how many different amplitudes there are."""
    levels: list[float] = []
    for amplitude in np.sort(amplitudes):
        if not levels or amplitude - levels[-1] > max(SAME_AMPLITUDE * amplitude, grain):
            levels.append(float(amplitude))
    return len(levels)


def _leave_none_alone(legs: Sequence[Leg], kinds: list[str]) -> None:
    """Name a leg as those that it turns to or comes from, where by itself it is something else.

    That is a single loop, a slide amid moves, and a move among loops that is no longer than they are: close to the
    grain of the position, and of how well a loop follows its reference, no speed is constant.
    """
    for k, kind in enumerate(kinds):
        beside = [kinds[j] for j in (k - 1, k + 1) if 0 <= j < len(legs) and legs[min(j, k)].last == legs[max(j, k)].first]
        if kind == "loops" and "loops" not in beside:
            kinds[k] = beside[0] if beside else "moves"
        elif kind == "constant_velocity" and beside == ["moves", "moves"]:
            kinds[k] = "moves"
    for order in (range(1, len(legs)), range(len(legs) - 2, -1, -1)):
        for k in order:
            j = k - order.step
            small = abs(legs[k].distance) <= AS_SMALL * abs(legs[j].distance)
            if kinds[k] == "moves" and kinds[j] == "loops" and small and legs[min(j, k)].last == legs[max(j, k)].first:
                kinds[k] = "loops"


def _mark_oscillations(legs: Sequence[Leg], kinds: list[str]) -> None:
    """Name the runs of legs that are an oscillation of changing or of one frequency."""
    parted = [k for k in range(len(legs)) if k == 0 or legs[k - 1].last != legs[k].first]
    for begin, end in pairwise([*parted, len(legs)]):
        if not _marked(legs, kinds, begin, end):
            turned = [k for k in range(begin + 1, end) if kinds[k] != kinds[k - 1]]
            for first, last in pairwise([begin, *turned, end]):
                _marked(legs, kinds, first, last)


def _marked(legs: Sequence[Leg], kinds: list[str], begin: int, end: int) -> bool:
    """Name a run of legs if it is an oscillation."""
    # The first and the last leg go from rest or to rest.
    inner, of_inner = legs[begin + 1 : end - 1], kinds[begin + 1 : end - 1]
    if of_inner.count("constant_velocity") > 0.5 * len(inner) or len(inner) < CHIRP_LEGS:
        return False
    kind = _oscillation(inner, of_inner)
    if kind:
        kinds[begin:end] = [kind] * (end - begin)
    return bool(kind)


def _oscillation(legs: Sequence[Leg], kinds: list[str]) -> str:
    durations = np.log(list(map(attrgetter("duration"), legs)))
    distances = np.log(np.abs(list(map(attrgetter("distance"), legs))))
    steps = np.arange(len(legs))
    slope, level = np.polyfit(steps, durations, 1)
    swept = abs(slope) * len(legs)
    if swept > np.log(SWEPT) and np.std(durations - level - slope * steps) < ALIKE * swept:
        follows = float(np.polyfit(durations, distances, 1)[0])
        return "chirp" if follows < FALL else ""
    curved = kinds.count("moves") > 0.5 * len(kinds)
    return "oscillation" if curved and np.std(durations) < ALIKE * np.log(SWEPT) else ""
