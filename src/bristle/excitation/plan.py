"""Which motion to run on an axis so that its log identifies friction, within the limits of the axis.

A conditioning slide comes first: it wipes out what the contact remembers. Triangles of several amplitudes around the
break-away distance, and a loop that decays, show pre-sliding; break-away at several rates shows whether it
depends on time; strokes at constant speeds show the Stribeck curve; a chirp below break-away shows the damping of the
bristles at the resonance of the mass on their stiffness. Each experiment begins and ends at rest in the middle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.typography import with_unit
from bristle.core.variable import unit_of
from bristle.excitation.motion import Leg, Motion, along, joined

__all__ = ["Experiment", "Frame", "Plan", "frame_of", "planned"]

MARGIN = 0.9  # of each limit is used
COUNTS = 40.0  # steps of the encoder, taken for the break-away distance where nobody knows it
FEWEST_COUNTS = 6.0  # steps of the encoder in the smallest amplitude
CROSSING = 0.15  # time in which a triangle crosses the break-away distance [s]
AMPLITUDES = (0.4, 3.0, 0.8, 1.6)  # of the triangles, in break-away distances
DECAY = 0.8  # from one half-cycle of a decaying loop to the next
RATES = (0.05, 0.15, 0.5, 1.5)  # times in which a ramp crosses the break-away distance [s]
REST = 0.4  # before a ramp [s]
PLATEAU = 0.25  # shortest time at constant speed [s]
SPEEDS, SLOWEST = 9, 2e-3  # number of speeds, and the smallest over the largest
CHIRP_FROM, CHIRP_TO = 2.0, 0.1  # first frequency [Hz], and last one in samples
FADE = 0.2  # of the amplitude of the chirp at both ends [s]
SHORTEST = 20.0  # duration of a plan [s]
SLIDE = "conditioning slide"
# Share of the time for each experiment after the slide, in their order; triangles take what is left.
SHARES = {"triangles": 0.4, "decaying loop": 0.08, "break-away ramps": 0.12, "constant speeds": 0.32, "chirp": 0.08}


@dataclass(frozen=True)
class Frame:
    """What a motion must keep to, in SI of the axis.

    Parameters
    ----------
    low, high : float
        Smallest and largest position [m or rad].
    speed, acceleration : float
        Largest of each [m/s, m/s^2 or rad/s, rad/s^2].
    sample_time : float
        Time between samples [s].
    resolution : float
        Step of the position encoder [m or rad].
    breakaway : float
        Displacement over which friction builds up, as far as it is known [m or rad].
    """

    low: float
    high: float
    speed: float
    acceleration: float
    sample_time: float
    resolution: float
    breakaway: float

    @property
    def centre(self) -> float:
        """Where each experiment begins and ends [m or rad]."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> float:
        """How far a motion may go to either side [m or rad]."""
        return 0.5 * MARGIN * (self.high - self.low)

    @property
    def top(self) -> float:
        """Largest speed that is used [m/s or rad/s]: one that is held for a while within the reach."""
        held, ramp = PLATEAU, 1.0 / (MARGIN * self.acceleration)
        room = 2.0 * self.reach
        within = (math.sqrt(held * held + 4.0 * ramp * room) - held) / (2.0 * ramp)
        return min(MARGIN * self.speed, within)


class Experiment(NamedTuple):
    """A part of a motion: what it is, and its samples."""

    kind: str
    first: int
    last: int


@dataclass(frozen=True)
class Plan:
    """A motion to run, and the experiments in it."""

    motion: Motion
    experiments: tuple[Experiment, ...]


def frame_of(axis: Axis, breakaway: float | None = None) -> Frame:
    """Return what a motion of an axis must keep to.

    Parameters
    ----------
    axis : Axis
        Its limits, encoder and sample time.
    breakaway : float, optional
        Displacement over which friction builds up [m or rad], where a model says it; else the axis file, or 40 steps of
        the encoder.

    Raises
    ------
    InputError
        If the axis file does not say how far, how fast or how finely, or the axis has no room for the motion.
    """
    needed: dict[str, tuple[Any, str]] = {
        "limits.stroke": (axis.stroke, 'stroke = ["0 mm", "200 mm"] under [limits]'),
        "limits.velocity": (axis.velocity_limit, 'velocity = "100 mm/s" under [limits]'),
        "limits.acceleration": (axis.acceleration_limit, 'acceleration = "1 m/s^2" under [limits]'),
        "timing.sample_time": (axis.sample_time, 'sample_time = "1 ms" under [timing]'),
        "encoder.resolution": (axis.resolution, 'resolution = "0.1 um" under [encoder]'),
    }
    for path, (value, mend) in needed.items():
        if not value:
            raise InputError("is needed to plan a motion", path=f"axis.{path}", mend=f"Write {mend}")
    low, high, speed, acceleration, period, step = (
        *(axis.stroke or ()), *(float(value) for value, _ in list(needed.values())[1:]),
    )  # fmt: skip
    distance = breakaway or axis.presliding or COUNTS * step
    found = Frame(low, high, speed, acceleration, period, step, distance)
    unit = unit_of("length", axis.kind)
    if max(8.0 * distance, 2.0 * FEWEST_COUNTS * step) > found.reach:
        raise InputError(
            "leaves no room for the motion", path="axis.limits.stroke", value=with_unit(2.0 * found.reach, unit),
            allowed=f"at least 16 times the break-away distance of {with_unit(distance, unit)}",
        )  # fmt: skip
    return found


def planned(frame: Frame, duration: float = 60.0) -> Plan:
    """Return a motion of about this duration [s] that keeps the limits.

    Raises
    ------
    InputError
        If the duration is too short for all experiments.
    """
    if not SHORTEST <= duration < math.inf:
        raise InputError("out of range", path="duration", value=duration, allowed=f">= {SHORTEST:g} s")
    makers: dict[str, Callable[[Frame], Iterator[list[Leg]]]] = {
        "triangles": _triangles, "decaying loop": _decaying, "break-away ramps": _ramps, "constant speeds": _speeds,
    }  # fmt: skip
    acceleration = MARGIN * frame.acceleration
    parts = {SLIDE: along(_slide(frame), acceleration, frame.sample_time, frame.centre)}
    parts["chirp"] = _chirp(frame, SHARES["chirp"] * duration)
    # Triangles come last in the making: they take the time that the others leave.
    for kind in reversed(makers):
        left = duration - sum(part.time[-1] for part in parts.values())
        budget = left if kind == "triangles" else min(SHARES[kind] * duration, left)
        legs = _filled(makers[kind](frame), budget, acceleration, frame)
        parts[kind] = along(legs, acceleration, frame.sample_time, frame.centre)
    spent = sum(part.time[-1] for part in parts.values())
    if spent > duration:
        raise InputError(
            "is too short for all experiments", path="duration", value=with_unit(duration, "s"),
            allowed=f">= {with_unit(math.ceil(spent), 's')}",
        )  # fmt: skip
    experiments, first = [], 0
    order = (SLIDE, *SHARES)
    for kind in order:
        part = parts[kind]
        last = first + part.time.size - (1 if first else 0)
        experiments.append(Experiment(kind, first, last))
        first = last
    return Plan(joined([parts[kind] for kind in order]), tuple(experiments))


def _filled(rounds: Iterator[list[Leg]], budget: float, acceleration: float, frame: Frame) -> list[Leg]:
    """Return legs, round after round, as long as the time lasts; at least one round."""
    legs: list[Leg] = []
    spent = 0.0
    for one in rounds:
        taken = along(one, acceleration, frame.sample_time, frame.centre).time[-1]
        if legs and spent + taken > budget:
            break
        legs += one
        spent += taken
    return legs


def _slide(frame: Frame) -> list[Leg]:
    speed = 0.2 * frame.top
    way = min(max(20.0 * frame.breakaway, speed), frame.reach)
    return [Leg(frame.centre + way, speed), Leg(frame.centre - way, speed), Leg(frame.centre, speed)]


def _to_and_fro(frame: Frame, amplitudes: Sequence[float], speed: float) -> list[Leg]:
    """Return legs to either side by these amplitudes in turn, and back to the middle."""
    sides = (1.0, -1.0)
    legs = [Leg(frame.centre + sides[number % 2] * one, speed) for number, one in enumerate(amplitudes)]
    return [*legs, Leg(frame.centre, speed)]


def _triangles(frame: Frame) -> Iterator[list[Leg]]:
    speed = min(frame.breakaway / CROSSING, frame.top)
    while True:
        for share in AMPLITUDES:
            amplitude = max(share * frame.breakaway, FEWEST_COUNTS * frame.resolution)
            yield _to_and_fro(frame, (amplitude,) * 4, speed)


def _decaying(frame: Frame) -> Iterator[list[Leg]]:
    speed, amplitudes = min(frame.breakaway / CROSSING, frame.top), [4.0 * frame.breakaway]
    while DECAY * amplitudes[-1] > max(0.3 * frame.breakaway, FEWEST_COUNTS * frame.resolution):
        amplitudes.append(DECAY * amplitudes[-1])
    while True:
        yield _to_and_fro(frame, amplitudes, speed)


def _ramps(frame: Frame) -> Iterator[list[Leg]]:
    while True:
        for time in RATES:
            speed = min(frame.breakaway / time, frame.top)
            way = frame.centre + 4.0 * frame.breakaway
            yield [Leg(frame.centre, 0.0, REST), Leg(way, speed), Leg(way, 0.0, REST), Leg(frame.centre, speed)]


def _speeds(frame: Frame) -> Iterator[list[Leg]]:
    speeds = np.geomspace(SLOWEST * frame.top, frame.top, SPEEDS).tolist()
    # Fast ones first, and slow ones between, so that every part of the log has both.
    order = [speeds[(SPEEDS - 1 - 4 * place) % SPEEDS] for place in range(SPEEDS)]
    while True:
        for speed in order:
            ramp = speed * speed / (MARGIN * frame.acceleration)
            half = 0.5 * min(max(speed * PLATEAU, 4.0 * frame.breakaway) + ramp, 2.0 * frame.reach)
            yield _to_and_fro(frame, (half, half), speed)


def _chirp(frame: Frame, duration: float) -> Motion:
    """Return a sine of rising frequency below break-away, as fast as acceleration and sampling allow."""
    amplitude = max(0.25 * frame.breakaway, 0.5 * FEWEST_COUNTS * frame.resolution)
    highest = math.sqrt(0.8 * MARGIN * frame.acceleration / amplitude) / (2.0 * math.pi)
    last = min(highest, CHIRP_TO / frame.sample_time, 0.8 * MARGIN * frame.speed / (2.0 * math.pi * amplitude))
    first = min(CHIRP_FROM, 0.5 * last)
    duration = max(duration, 4.0 * FADE, 2.0 / first)
    time = frame.sample_time * np.arange(math.floor(duration / frame.sample_time) + 1)
    growth = math.log(last / first)
    phase = 2.0 * math.pi * first * duration / growth * np.expm1(growth * time / duration)
    fade = np.clip(np.minimum(time, time[-1] - time) / FADE, 0.0, 1.0)
    position = frame.centre + amplitude * fade * fade * (3.0 - 2.0 * fade) * np.sin(phase)
    velocity = np.gradient(position, frame.sample_time)
    return Motion(time, position, velocity, np.gradient(velocity, frame.sample_time))
