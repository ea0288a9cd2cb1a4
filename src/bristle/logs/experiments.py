"""Experiments found in a log: triangles, decaying loops, break-away ramps, constant speeds, chirps, by their shape.

A motion is cut where it turns. Half-cycles in a row make an experiment:

* ``chirp``: ever faster ones of about one travel, which are not straight,
* ``decaying loop``: each a little shorter than the last one,
* ``break-away ramps``: straight ones with a rest at an end,
* ``triangles``: straight ones at one and the same speed,
* ``constant speeds``: straight ones at several speeds,
* ``sines``: rounded ones of one travel and duration,
* ``conditioning slide``: a straight start that goes several times further than what comes after it.

All else is ``other motion``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from bristle.logs.log import Log

__all__ = ["Found", "experiments_in"]

COUNTS, DEVIATIONS = 4.0, 10.0  # steps of the encoder, of the noise: below, nothing turned
STRAIGHT = 0.008  # root mean square deviation from a line, as a share of the travel
INNER = (0.1, 0.9)  # share of the travel that is looked at
RESTS = 0.15  # longest start without motion that is none [s]
SAME = 0.15  # relative difference of speeds or travels that are alike
KEPT = 0.6  # of the travel: a chirp has the same one throughout
LONG = 4.0  # times the next half-cycles: a slide
SLIDE = "conditioning slide"
FEWEST = {"chirp": 8, "decaying loop": 5, "break-away ramps": 2, "triangles": 5, "sines": 4, "constant speeds": 2}


@dataclass(frozen=True)
class Found:
    """An experiment in a log.

    Parameters
    ----------
    kind : str
        What it is.
    start, end : float
        Time at which it begins and ends [s].
    half_cycles : int
        Number of moves in one direction.
    reach : tuple of float
        Smallest and largest half of a travel [m or rad].
    speed : tuple of float
        Smallest and largest speed between a tenth and nine tenths of a travel [m/s or rad/s].
    """

    kind: str
    start: float
    end: float
    half_cycles: int
    reach: tuple[float, float]
    speed: tuple[float, float]


@dataclass(frozen=True)
class _Half:
    """A move in one direction: samples, travel, speed, whether it is straight, and the rest at an end [s]."""

    first: int
    last: int
    travel: float
    speed: float
    straight: bool
    rest: float

    @property
    def samples(self) -> int:
        return self.last - self.first


def experiments_in(log: Log) -> tuple[Found, ...]:
    """Return the experiments in a log, in the order of time."""
    found: list[Found] = []
    for part in log.segments or (slice(0, len(log)),):
        position, time = np.asarray(log.position.values[part]), np.asarray(log.time.values[part])
        if position.size < 3:
            continue
        halves = _halves(position, log.sample_time)
        for kind, group in _grouped(_kinds(halves), halves):
            found.append(Found(
                kind, float(time[group[0].first]), float(time[group[-1].last]), len(group),
                (0.5 * min(one.travel for one in group), 0.5 * max(one.travel for one in group)),
                (min(one.speed for one in group), max(one.speed for one in group)),
            ))  # fmt: skip
    return tuple(found)


def _halves(position: np.ndarray, dt: float) -> list[_Half]:
    steps = np.abs(np.diff(position))
    step = float(steps[steps > 0.0].min()) if np.any(steps > 0.0) else 0.0
    # A smooth motion has next to no third difference: what there is, is noise.
    noise = 1.4826 * float(np.median(np.abs(np.diff(position, 3)))) / 20.0**0.5 if position.size > 3 else 0.0
    coarse = step if np.mean(steps == 0.0) > 0.01 else 0.0
    edges = [0, *_turns(position, max(COUNTS * coarse, DEVIATIONS * noise)), position.size - 1]
    return [_half(position, first, last, dt, coarse) for first, last in pairwise(edges)]


def _turns(position: np.ndarray, least: float) -> list[int]:
    """Return where a motion turns by at least so much."""
    change = np.diff(position)
    moving = np.flatnonzero(change != 0.0)
    places = moving[1:][np.sign(change[moving[1:]]) != np.sign(change[moving[:-1]])]
    kept: list[int] = []
    before, candidate = 0, None
    for point in [*places.tolist(), position.size - 1]:
        if candidate is None:
            candidate = point if abs(position[point] - position[before]) >= max(least, 1e-300) else None
            continue
        way, back = position[candidate] - position[before], position[point] - position[candidate]
        if way * back > 0.0:
            candidate = point
        elif abs(back) >= max(least, 1e-300):
            kept.append(candidate)
            before, candidate = candidate, point
    return kept


def _half(position: np.ndarray, first: int, last: int, dt: float, step: float) -> _Half:
    way = position[first : last + 1] - position[first]
    travel = float(abs(way[-1]))
    share = np.abs(way) / travel if travel > 0.0 else np.zeros(way.size)
    begin, end = int(np.argmax(share > INNER[0])), int(np.argmax(share >= INNER[1]))
    still = max(1.5 * step, 0.01 * travel)
    rest = dt * max(int(np.argmax(np.abs(way) > still)), int(np.argmax(np.abs(way - way[-1])[::-1] > still)))
    if end - begin < 3:
        return _Half(first, last, travel, travel / max((last - first) * dt, dt), False, rest)
    time, inner = dt * np.arange(end - begin + 1), way[begin : end + 1]
    slope, level = np.polyfit(time, inner, 1)
    off = float(np.sqrt(np.mean((inner - slope * time - level) ** 2)))
    return _Half(first, last, travel, float(abs(slope)), off <= STRAIGHT * travel + 0.5 * step, rest)


def _kinds(halves: list[_Half]) -> list[str]:
    """Return the kind of experiment that each half-cycle belongs to."""
    kinds = [""] * len(halves)
    later = float(np.median([one.travel for one in halves])) if halves else 0.0
    for place in range(min(3, len(halves))):
        if halves[place].travel <= LONG * later:
            break
        kinds[place] = SLIDE
    for kind, follows in RULES.items():
        for first, last in _runs(halves, kinds, follows):
            if last - first >= FEWEST[kind] and (kind != "chirp" or _faster(halves[first:last])):
                kinds[first:last] = [kind] * (last - first)
    for place in range(1, len(kinds) - 1):
        # A move from one experiment of a series to the next one belongs to both.
        if not kinds[place] and kinds[place - 1] and kinds[place - 1] in kinds[place + 1 : place + 3]:
            kinds[place] = kinds[place - 1]
    return [kind or "other motion" for kind in kinds]


def _faster(halves: list[_Half]) -> bool:
    """Return whether half-cycles get faster, and not only because they get smaller."""
    travels = [one.travel for one in halves]
    return halves[-1].samples < 0.5 * halves[0].samples and float(np.median(travels)) > KEPT * max(travels[1:])


def _follows_in_chirp(a: _Half, b: _Half) -> bool:
    return b.samples <= 1.05 * a.samples + 1.0 and (_alike(a, b, "travel") or b.travel < a.travel)


def _alike(a: _Half, b: _Half, name: str) -> bool:
    one, other = getattr(a, name), getattr(b, name)
    return abs(one - other) <= SAME * max(one, other)


RULES: dict[str, Callable[[_Half, _Half], bool]] = {
    "chirp": _follows_in_chirp,
    "decaying loop": lambda a, b: 0.5 * a.travel < b.travel < 0.97 * a.travel and _alike(a, b, "speed"),
    "break-away ramps": lambda a, b: a.straight and b.straight and min(a.rest, b.rest) > RESTS,
    "triangles": lambda a, b: a.straight and b.straight and _alike(a, b, "speed"),
    "sines": lambda a, b: not (a.straight or b.straight) and _alike(a, b, "travel") and _alike(a, b, "samples"),
    "constant speeds": lambda a, b: a.straight or b.straight,
}


def _runs(
    halves: list[_Half], kinds: list[str], follows: Callable[[_Half, _Half], bool]
) -> Iterator[tuple[int, int]]:  # fmt: skip
    """Yield the ends of each run of half-cycles without a kind, of which each follows from the last one."""
    first = 0
    while first < len(halves):
        if kinds[first]:
            first += 1
            continue
        last = first + 1
        while last < len(halves) and not kinds[last] and follows(halves[last - 1], halves[last]):
            last += 1
        yield first, last
        first = last


def _grouped(kinds: list[str], halves: list[_Half]) -> Iterator[tuple[str, list[_Half]]]:
    for kind, group in groupby(zip(kinds, halves, strict=True), key=lambda pair: pair[0]):
        yield kind, [half for _, half in group]
