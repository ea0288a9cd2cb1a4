"""Experiments in a log: slides at constant velocity, loops before sliding, break-aways, chirps, moves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bristle.core import Axis, guarded, instance
from bristle.logs.log import Log
from bristle.logs.turns import Leg, graininess, legs_of, rests_of


@guarded(log=instance(Log, "a log", "Write read_log(...)"))
def passages(log: Log, axis: Axis | None = None) -> tuple[Passage, ...]:
    """Return the experiments in a log, in order.

    Parameters
    ----------
    log : Log
        Position over time, and the effort if recorded.
    axis : Axis, optional
        Its encoder and its pre-sliding distance, if known.
    """
    time, position, effort = (
        log.time.values,
        log.position.values,
        None if log.effort is None else log.effort.values,
    )
    axis = axis or Axis(kind=log.kind)
    grain = graininess(position, axis.resolution or log.position.step)
    ordered: list[Passage] = []
    for part in log.segments:
        pulled = None if effort is None else effort[part]
        ordered += passages_along(
            time[part],
            position[part],
            pulled,
            grain,
            presliding=axis.presliding,
            start=part.start or 0,
        )
    return tuple(ordered)


def passages_along(
    time: np.ndarray,
    position: np.ndarray,
    effort: np.ndarray | None,
    grain: float,
    *,
    presliding: float | None = None,
    start: int = 0,
) -> list[Passage]:
    """Return the experiments in one stretch without a gap, in order."""
    return (
        Stretch(time, position, effort, grain, presliding, start).passages()
        if time.size > 1
        else []
    )


# Largest ratio of the lengths and durations of equal strokes; share of the strokes that is a motion.
TWICE, MOST = (2.0, 0.8)


def holds(log: Log, motion: Log) -> bool:
    """Return whether a log already contains the strokes of another log, in number, length and duration."""
    own, strokes = _strokes(log), _strokes(motion)
    alike = np.all(np.abs(own[:, None] - strokes[None]) < np.log(TWICE), axis=-1)
    return min(np.sum(alike.any(axis=0)), np.sum(alike.any(axis=1))) >= MOST * len(strokes) > 0


def _strokes(log: Log) -> np.ndarray:
    """Return length [m or rad] and duration [s] of the strokes asked for in a log, shape (stroke, 2), in logarithms."""
    # An axis does not follow each stroke of its reference, and would not follow it the next time.
    way = log.position if log.reference is None else log.reference
    grain, parts = graininess(way.values, way.step), [way.values[part] for part in log.segments]
    legs = [
        leg
        for x in parts
        for leg in legs_of(x, rests_of(x, grain, log.sample_time), grain, log.sample_time)
    ]
    return np.log(
        [(abs(leg.distance), log.sample_time * (leg.last - leg.first)) for leg in legs]
    ).reshape(-1, 2)


@dataclass(frozen=True)
class Passage:
    """Part of a log with one kind of experiment."""

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
        """Return the passage as numbers, in SI units of the axis."""
        record = {name: value for name, value in vars(self).items() if name != "samples"}
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in record.items()
        }


def nesting(turning: Iterable[float]) -> int:
    """Return the largest count of nested turning points that a contact must remember."""
    points: list[float] = []
    most = 0
    for point in turning:
        # A turning point as far out as an earlier one erases all points between them.
        while len(points) > 1 and abs(point - points[-1]) >= abs(points[-1] - points[-2]):
            points = points[:-2] if len(points) > 2 else points[1:]
        points.append(point)
        most = max(most, len(points))
    return most


SLIDING = 0.4  # share of cruise above which a leg is a slide
SETTLED = 0.07  # of the swing of the effort: largest change in the second half of a slide
NINTHS, PARTS = 9, 40  # of a cruise, and of a leg, in which the effort is averaged
SAMPLES = 2  # in each, at least
CHIRP_LEGS, SWEPT, ALIKE = 8, 2.0, 0.25


class Stretch:
    """One stretch of a log without a gap, as it is divided into passages."""

    def __init__(
        self,
        time: np.ndarray,
        position: np.ndarray,
        effort: np.ndarray | None,
        grain: float,
        presliding: float | None,
        start: int,
    ) -> None:
        self.time, self.position, self.effort, self.start = time, position, effort, start
        self.grain, self.presliding = grain, presliding
        self.dt = float(time[-1] - time[0]) / (time.size - 1)
        self.rests = rests_of(self.position, grain, self.dt)
        self.legs = list(legs_of(self.position, self.rests, grain, self.dt))

    def passages(self) -> list[Passage]:
        """Return the passages in order, including rests."""
        kinds = [self._kind(leg) for leg in self.legs]
        _leave_none_alone(self.legs, kinds)
        _mark_oscillations(self.legs, kinds)
        runs: list[tuple[str, list[Leg]]] = []  # of one kind, without a long rest between
        for kind, leg in zip(kinds, self.legs, strict=True):
            # A rest below 0.5 [s] does not separate legs of the same kind.
            if runs and runs[-1][0] == kind and self.dt * (leg.first - runs[-1][1][-1].last) <= 0.5:
                runs[-1][1].append(leg)
            else:
                runs.append((kind, [leg]))
        passages = [
            self._passage(kind, legs[0].first, legs[-1].last, **self._facts(kind, legs))
            for kind, legs in runs
        ]
        for rest in self.rests:
            if not any(
                legs[0].first < rest.stop - 1 and rest.start < legs[-1].last for _, legs in runs
            ):
                passages.append(self._passage("rest", rest.start, rest.stop - 1))
        return sorted(passages, key=lambda passage: passage.samples.start)

    def of_kind(self, kind: str) -> list[Leg]:
        """Return the legs of one kind, each judged without its neighbours."""
        return [leg for leg in self.legs if self._kind(leg) == kind]

    def _kind(self, leg: Leg) -> str:
        if leg.cruise_share < SLIDING:
            return "moves"
        if not self._slides(leg):
            return "loops"
        # A cruise covers at least 20.0 grains of the position: over fewer, any speed looks constant.
        if leg.speed * self.dt * (leg.cruise.stop - leg.cruise.start) < 20.0 * self.grain:
            return "moves"
        return "break_away" if leg.from_rest and self._breaks_away(leg) else "constant_velocity"

    def _slides(self, leg: Leg) -> bool:
        """Return whether friction has saturated in a leg: its effort has settled, or the leg is long enough."""
        # Forces that depend on the position (gravity, cogging, a cable) repeat on the way back. Half the difference of both
        # directions is friction: constant along a sliding leg, and lens-shaped if it builds up from both ends.
        settled = None if self.effort is None else self._settled(leg)
        if settled is None:
            is_long = self.presliding is not None and abs(leg.distance) > 2.0 * self.presliding
            return is_long or (self.effort is None and self.presliding is None)
        at = self.legs.index(leg)
        beside = [self.legs[k] for k in (at - 1, at + 1) if 0 <= k < len(self.legs)]
        return settled or any(
            self._level_between(leg, back) for back in beside if back.distance * leg.distance < 0.0
        )

    def _settled(self, leg: Leg) -> bool | None:
        """Return whether the effort has settled in the second half of a cruise; None if undecided."""
        # Exclude the acceleration and deceleration at the ends of a cruise.
        edge = round(0.1 * (leg.cruise.stop - leg.cruise.start))
        begin, end = leg.cruise.start + edge, leg.cruise.stop - edge
        if end - begin < SAMPLES * NINTHS:
            return None
        course = self._course(begin, end, NINTHS)
        middle, late = float(course[3:6].mean()), float(course[6:].mean())
        # Each level has three means; the scatter of a mean is a share of the difference of two.
        scatter = float(np.std(np.diff(course))) / np.sqrt(3.0)
        return (
            abs(late - middle)
            <= SETTLED * float(np.ptp(self._course(leg.first, leg.last + 1, PARTS))) + scatter
        )

    def _level_between(self, leg: Leg, back: Leg) -> bool:
        assert self.effort is not None
        ends = [np.sort(self.position[[way.cruise.start, way.cruise.stop]]) for way in (leg, back)]
        low, high = max(ends[0][0], ends[1][0]), min(ends[0][1], ends[1][1])
        if high - low < SLIDING * abs(leg.distance):
            return False
        marks, efforts = np.linspace(low, high, 2 * NINTHS + 1), []
        for way in (leg, back):  # the mean effort between marks of the position
            inside = slice(way.cruise.start, way.cruise.stop + 1)
            place = np.digitize(self.position[inside], marks)
            counts = np.bincount(place, minlength=marks.size + 1)[1:-1]
            if np.any(counts < SAMPLES):
                return False
            efforts.append(
                np.bincount(place, self.effort[inside], minlength=marks.size + 1)[1:-1] / counts
            )
        friction = 0.5 * float(np.sign(leg.distance)) * (efforts[0] - efforts[1])
        first, middle, last = (
            float(np.mean(part)) for part in (friction[1:5], friction[7:-7], friction[-5:-1])
        )
        scatter = float(np.std(np.diff(friction))) / np.sqrt(8.0)
        # The friction from two legs must exceed 5.0 times its scatter.
        return (
            middle > 5.0 * scatter
            and max(abs(first - middle), abs(last - middle)) <= 2.0 * SETTLED * middle + scatter
        )

    def _course(self, begin: int, end: int, count: int) -> np.ndarray:
        """Return the mean effort of equal parts of a stretch [N or N*m]: single samples are mostly noise."""
        assert self.effort is not None
        marks = np.unique(np.linspace(begin, end, count + 1).astype(int))
        return np.add.reduceat(self.effort[: marks[-1]], marks[:-1]) / np.diff(marks)

    def _breaks_away(self, leg: Leg) -> bool:
        """Return whether the contact turns over during much of a leg from rest, slowly enough to be resolved."""
        # A force that depends on the position can rise along a leg, too.
        if self.effort is None or not self._settled(leg):
            return False
        side = float(np.sign(leg.distance))
        course = self._course(leg.first, leg.last + 1, PARTS) * side
        steady = side * float(
            self.effort[(leg.cruise.start + leg.cruise.stop) // 2 : leg.cruise.stop].mean()
        )
        before = side * float(np.median(self.effort[leg.first : leg.first + SAMPLES]))
        level = steady - before
        if level < 0.5 * max(float(np.ptp(course)), abs(steady)):
            return False
        # The contact has turned over at 0.9 of the swing of the effort.
        samples = round(
            float(np.argmax(course - before >= 0.9 * level)) / course.size * (leg.last - leg.first)
        )
        moved = abs(self.position[leg.first + samples] - self.position[leg.first])
        # This takes at least 0.15 of the leg.
        return samples >= 30 and moved >= 0.15 * abs(leg.distance)

    def _facts(self, kind: str, legs: Sequence[Leg]) -> dict[str, Any]:
        """Return the numbers of legs of one kind."""
        inner = [leg for leg in legs if not leg.from_rest] or list(legs)
        amplitudes = sorted(0.5 * abs(leg.distance) for leg in inner)
        levels: list[float] = []
        for amplitude in amplitudes:
            if not levels or amplitude - levels[-1] > max(0.05 * amplitude, self.grain):
                levels.append(amplitude)
        speeds, turning = (
            [leg.speed for leg in legs],
            [self.position[legs[0].first], *(self.position[leg.last] for leg in legs)],
        )
        facts: dict[str, Any] = {
            "legs": len(legs),
            "speeds": (min(speeds), max(speeds)),
            "amplitudes": (amplitudes[0], amplitudes[-1]),
            "levels": len(levels),
            "depth": nesting(turning) if kind == "loops" else 0,
        }
        if kind in ("chirp", "oscillation"):
            # The first and last leg are no complete half periods; a sample is a large part of the shortest leg.
            rates = [0.5 / leg.duration for leg in legs[1:-1]]
            facts["frequencies"] = (min(rates), float(np.quantile(rates, 0.98)))
        return facts

    def _passage(self, kind: str, first: int, last: int, **facts: Any) -> Passage:
        samples = slice(self.start + first, self.start + last + 1)
        return Passage(kind, samples, float(self.time[first]), float(self.time[last]), **facts)


def _leave_none_alone(legs: Sequence[Leg], kinds: list[str]) -> None:
    """Rename an isolated leg to the kind of its neighbours."""
    # This covers a single loop, a slide among moves, and a move among loops that is no longer than they are: near the grain
    # of the position and the tracking error of a loop, no speed is constant.
    joined = [False, *(first.last == second.first for first, second in pairwise(legs)), False]
    for k, kind in enumerate(kinds):
        beside = [kinds[j] for j, joins in ((k - 1, joined[k]), (k + 1, joined[k + 1])) if joins]
        if kind == "loops" and "loops" not in beside:
            kinds[k] = beside[0] if beside else "moves"
        elif kind == "constant_velocity" and beside == ["moves", "moves"]:
            kinds[k] = "moves"
    for order in (range(1, len(legs)), range(len(legs) - 2, -1, -1)):
        for k in order:
            j = k - order.step
            small = abs(legs[k].distance) <= 1.3 * abs(legs[j].distance)  # times the leg next to it
            if kinds[k] == "moves" and kinds[j] == "loops" and small and joined[max(j, k)]:
                kinds[k] = "loops"


def _mark_oscillations(legs: Sequence[Leg], kinds: list[str]) -> None:
    """Mark runs of legs that oscillate at changing or constant frequency."""
    parted = [k for k in range(len(legs)) if k == 0 or legs[k - 1].last != legs[k].first]
    for begin, end in pairwise([*parted, len(legs)]):
        turned = [k for k in range(begin + 1, end) if kinds[k] != kinds[k - 1]]
        for first, last in ((begin, end), *pairwise([begin, *turned, end])):
            # The first and last leg begin or end at rest.
            if kind := _oscillation(legs[first + 1 : last - 1], kinds[first + 1 : last - 1]):
                kinds[first:last] = [kind] * (last - first)
                if last == end and first == begin:
                    break


def _oscillation(legs: Sequence[Leg], kinds: Sequence[str]) -> str:
    """Return the kind of oscillation of a run of legs; empty if it is no oscillation."""
    if len(legs) < CHIRP_LEGS or sum(kind == "constant_velocity" for kind in kinds) > 0.5 * len(
        kinds
    ):
        return ""
    durations = np.log([leg.duration for leg in legs])
    distances = np.log([abs(leg.distance) for leg in legs])
    steps = np.arange(len(legs))
    slope, level = np.polyfit(steps, durations, 1)
    swept = abs(slope) * len(legs)
    if swept > np.log(SWEPT) and np.std(durations - level - slope * steps) < ALIKE * swept:
        follows = float(np.polyfit(durations, distances, 1)[0])
        # Slope of amplitude over duration, both logarithmic: triangles at one speed have 1
        return "chirp" if follows < 0.7 else ""
    curved = sum(kind == "moves" for kind in kinds) > 0.5 * len(kinds)
    return "oscillation" if curved and np.std(durations) < ALIKE * np.log(SWEPT) else ""
