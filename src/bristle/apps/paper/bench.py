r"""The bench of the measured figures: a motor, a torque sensor, a screw with its table.

The motor moves the screw slowly along a path, or drives it with a torque. The shaft carries the friction :math:`F_p`
of (18) and the torque of the inertia behind the sensor. The torque of the shaft and the reading of its sensor are

.. math:: T = F_p + (J - J_m)\,\dot\omega, \qquad \tau\,\dot{\tilde T} = T - \tilde T

The screw is rigid, as in (18): an angle of the motor is a travel of the table.

A contact can also be moved slowly without a bench, to measure friction itself. Both records are read in counts of the
encoder, with noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from bristle.apps.paper.reproduced import in_millinewtons, percent
from bristle.apps.paper.setting import Setting
from bristle.core import InputError, Model, with_unit
from bristle.engine import Contact, force_along, response
from bristle.models.plants import inertia
from bristle.models.references import legs_through
from bristle.models.sensors import torque_seen

STEP = 5e-9  # of the table [m]


class Walk(NamedTuple):
    """Positions of the table, and friction there."""

    x: np.ndarray
    torque: np.ndarray
    turns: np.ndarray

    @property
    def at_turns(self) -> np.ndarray:
        """Friction torque at the turning points [N*m]."""
        return self.torque[self.turns]

    def leg(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and torques between turning point `index` and the previous one."""
        start = 0
        if index:
            start = self.turns[index - 1]
        part = slice(int(start), int(self.turns[index]) + 1)
        return self.x[part], self.torque[part]


def walk(
    model: Model, turns: Iterable[float], speed: float, arm: float, *, step: float = STEP
) -> Walk:
    """Move a virgin contact from the origin through the turning points."""
    contact = Contact(model)
    path = list(turns)
    start = 0.0
    if path:
        start = arm * contact.force(math.copysign(0.0, path[0]))
    position = 0.0
    x = [np.zeros(1)]
    torque = [np.array([start])]
    ends = []
    for turn in path:
        distance = turn - position
        count = max(math.ceil(abs(distance) / step - 1e-9), 1)
        if distance != 0.0:
            torque.append(arm * contact.move(distance, speed, count))
            x.append(position + distance * (np.arange(count) + 0.5) / count)
        position = turn
        x.append(np.array([position]))
        torque.append(np.array([arm * contact.force(math.copysign(0.0, distance))]))
        ends.append(sum(part.size for part in x) - 1)
    return Walk(np.concatenate(x), np.concatenate(torque), np.array(ends))


def follow(operator: Model, turns: Iterable[float], arm: float) -> Walk:
    """Move a hysteresis operator, virgin at the origin, through the turning points."""
    path = [0.0, *turns]
    counts = [max(math.ceil(abs(b - a) / STEP - 1e-9), 1) for a, b in pairwise(path)]
    legs = [np.linspace(a, b, n + 1)[1:] for (a, b), n in zip(pairwise(path), counts, strict=True)]
    x = np.concatenate([np.zeros(1), *legs])
    return Walk(x, arm * response(operator, x), np.cumsum(counts))


SAMPLE_TIME = 5e-4  # [s]
MOST = 4_000_000  # samples: a slower motion is sampled more rarely


class Bench(NamedTuple):
    """Inertia on both sides of the torque sensor."""

    J: float
    J_m: float
    cutoff: float


class Sensed(NamedTuple):
    """Torques of one motion, each of shape (step,), as means over its steps [N*m]."""

    friction: np.ndarray
    shaft: np.ndarray
    read: np.ndarray


class Reading(NamedTuple):
    """A path of the table, with the reading of the torque sensor and the true friction."""

    sensor: Walk
    friction: Walk
    sensed: Sensed


def bench_of(setting: Setting) -> Bench:
    """Return the bench of an experiment."""
    J = float(setting["bench", "J"])
    J_m = float(setting["bench", "J_m"])
    if J_m > J:
        raise InputError(
            "is the inertia of the motor, and exceeds the total inertia",
            path=f"{setting.source}: bench.J_m",
            value=f"{J_m:g} kg*m^2",
            allowed=f"0 to bench.J = {J:g} kg*m^2",
        )
    return Bench(J, J_m, float(setting.numbers["bench"].get("torque_filter", math.inf)))


def plant_of(setting: Setting) -> Model:
    """Return the driven plant: the bench, with its inertia at the table, or the plant of the experiment."""
    if "bench" not in setting.numbers:
        return setting.mass
    return inertia(M=bench_of(setting).J / setting.arm**2)


def read_torque(
    bench: Bench, effort: np.ndarray, omega: np.ndarray, friction: np.ndarray, dt: float
) -> Sensed:
    """Return the readings of the torque sensor along a motion."""
    shaft = torque_seen(np.append(effort, 0.0), omega, dt, bench.J_m)
    # After a filter of first order, settled on its first value.
    gain = 1.0 - math.exp(-2.0 * math.pi * bench.cutoff * dt)
    read = np.fromiter(
        accumulate(shaft.tolist(), lambda was, now: was + gain * (now - was)), float, shaft.size
    )
    return Sensed(friction, shaft, read)


def led(setting: Setting, friction: Model, turns: Iterable[float], speed: float) -> Reading:
    """Move a virgin contact on the bench from the origin through the turning points."""
    bench = bench_of(setting)
    arm = setting.arm
    dt, x, v, ends = _motion(list(turns), speed, float(setting["bench", "acceleration"]))
    force = arm * force_along(friction, np.diff(x) / dt, dt, x[1:])
    omega = v / arm
    sensed = read_torque(bench, force + bench.J * np.diff(omega) / dt, omega, force, dt)
    middle = 0.5 * (x[:-1] + x[1:])
    return Reading(Walk(middle, sensed.read, ends), Walk(middle, sensed.friction, ends), sensed)


def _motion(
    turns: list[float], speed: float, acceleration: float
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Return sample time [s], positions [m], speeds [m/s], and the steps that end at the turning points."""
    # Each leg is stretched to whole samples, by less than one, so that the table turns exactly at its turning points.
    legs = [
        legs_through([b - a], speed, acceleration)
        for a, b in zip([0.0, *turns], turns, strict=False)
    ]
    fastest = max((float(np.max(np.abs(leg.velocity))) for leg in legs), default=0.0)
    dt = SAMPLE_TIME
    if fastest > 0.0:  # a change of speed takes several samples, however short it is
        dt = min(SAMPLE_TIME, STEP / fastest, 0.25 * fastest / acceleration)
    dt = max(dt, sum(leg.end for leg in legs) / MOST)
    x = [np.zeros(1)]
    v = [np.zeros(1)]
    ends = []
    position = 0.0
    for leg, turn in zip(legs, turns, strict=True):
        count = max(math.ceil(leg.end / dt - 1e-9), 1)
        moved, velocity, _ = leg.sample(leg.end * np.arange(1, count) / count)
        x += [position + moved, np.array([turn])]
        v += [velocity * (leg.end / (count * dt)), np.zeros(1)]
        ends.append(count)
        position = turn
    return dt, np.concatenate(x), np.concatenate(v), np.cumsum(ends) - 1


def sensor_numbers(runs: Sequence[Sensed]) -> dict[str, float]:
    """Return the largest differences between sensor and friction."""
    largest = max(float(np.max(np.abs(run.friction))) for run in runs)
    return {
        "apart": max(float(np.max(np.abs(run.read - run.friction))) for run in runs) / largest,
        "inertia": max(float(np.max(np.abs(run.shaft - run.friction))) for run in runs),
        "filter": max(float(np.max(np.abs(run.read - run.shaft))) for run in runs),
    }


def sensor_says(bench: Bench, apart: Mapping[str, float], condition: str) -> str:
    """Return the difference between sensor and friction, in words."""
    parts = [
        f"the inertia behind it, {with_unit(bench.J - bench.J_m, 'kg*m^2')}, adds up to {in_millinewtons(apart['inertia'], 2)}"
    ]
    if math.isfinite(bench.cutoff):
        parts.append(
            f"its filter of {with_unit(bench.cutoff, 'Hz')} removes up to {in_millinewtons(apart['filter'], 2)}"
        )
    return f"{condition} the error of the torque sensor is {percent(apart['apart'])} of the largest friction: {', '.join(parts)}."


SWEEP = 6  # rounds of falling amplitude
APART = 5e-8  # of the table between two readings [m]


class Record(NamedTuple):
    """Readings while the table moves through the turning points."""

    x: np.ndarray
    torque: np.ndarray
    turns: np.ndarray
    actual: Walk

    def since(self, turn: int) -> Record:
        """Return the readings from a turning point on."""
        return self.part(int(self.turns[turn]), self.x.size, turn)

    def part(self, start: int, end: int, turn: int) -> Record:
        """Return the readings between two samples, with the turning points from one on."""
        part = slice(start, end)
        turns = self.turns[turn:]
        turns = turns[turns < end] - start
        actual = Walk(self.actual.x[part], self.actual.torque[part], turns)
        return Record(self.x[part], self.torque[part], turns, actual)


def measured(
    setting: Setting, friction: Model, turns: Iterable[float], generator: np.random.Generator
) -> Record:
    """Return the readings of a motion of the table."""
    resolution = setting["measurement", "resolution"]
    noise = setting["measurement", "noise"]
    speed = setting["measurement", "speed"]
    if "bench" in setting.numbers:
        sensor, actual, _ = led(setting, friction, turns, speed)
        travelled = np.cumsum(np.abs(np.diff(sensor.x, prepend=0.0)))
        now_and_then = np.searchsorted(travelled, np.arange(0.0, travelled[-1], APART))
        part = np.union1d(now_and_then, sensor.turns)
        ends = np.searchsorted(part, sensor.turns)
        sensed, actual = (Walk(path.x[part], path.torque[part], ends) for path in (sensor, actual))
    else:  # the torque sensor reads friction itself
        sensed = actual = walk(friction, turns, speed, setting.arm, step=APART)
    read = sensed.x
    if resolution > 0.0:
        read = resolution * np.round(sensed.x / resolution)
    return Record(
        read,
        sensed.torque + noise * generator.standard_normal(sensed.torque.size),
        sensed.turns,
        actual,
    )


def measured_loop(
    setting: Setting, friction: Model, amplitude: float, rounds: int, generator: np.random.Generator
) -> list[Record]:
    """Return the last rounds of a symmetric loop, after a sweep from the largest loop that centres all loops around one point."""
    largest = float(np.max(setting["measurement", "amplitudes"]))
    falling = np.linspace(largest, amplitude, SWEEP).repeat(2)
    sweep = falling * np.tile([1.0, -1.0], SWEEP)
    record = measured(setting, friction, [*sweep, *([amplitude, -amplitude] * rounds)], generator)
    starts = record.turns[sweep.size - 1 :: 2]
    return [
        record.part(a, b + 1, sweep.size + 2 * k)
        for k, (a, b) in enumerate(pairwise(starts.tolist()))
    ]
