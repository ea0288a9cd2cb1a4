"""Elastic drives: are antiresonance, resonance and the sum of the masses reported, and rigid axes left alone?

The drives are those of `benchmarks.two_mass`, a simulator that shares no code with bristle. Each drive is simulated twice:
with its spring, and as a rigid axis with the same loop, motion and friction. A third of the drives have play, at which
the apparent antiresonance depends on the amplitude. ``python -m benchmarks.elastic [FIRST COUNT]`` prints the figures.

The log of the motor alone shows both masses, too, and friction of both sides together.

``python -m benchmarks.elastic two [FIRST COUNT]`` identifies both masses from logs with a second encoder at the load.

``python -m benchmarks.elastic sensor [FIRST COUNT]`` has a torque sensor between motor and screw, too, a nut with friction
in half of the drives, and a screw with mass in half. ``python -m benchmarks.elastic no_scale`` omits the second encoder.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.two_mass import Drive, columns_of, drive_of, log_of, of_the_motor
from bristle.core.cores import core_count
from bristle.identification.two_masses import two_masses

__all__ = ["Found", "Tried", "elastic", "found", "tried", "two"]

FIRST, COUNT = 500, 60
NARROWEST, WIDEST = 92.0, 98.0  # % of the intervals that hold the true value
RECORDS = {
    "two": "two encoders",
    "sensor": "two encoders and a sensor",
    "no_scale": "one encoder and a sensor",
}
# % of the frequencies, of the sum of the masses, of the stiffness
CLOSE, CLOSE_MASS, CLOSE_STIFFNESS = (3.0, 1.0, 5.0)


class Tried(NamedTuple):
    """The report on one drive: its errors [%], the models that bristle suggests, and whether elasticity is named first."""

    reported: bool
    antiresonance: float
    resonance: float
    ratio: float
    mass: float
    suggested: tuple[str, ...]
    first: bool
    play: bool
    inside: tuple[bool, ...]
    # Whether the true values of both masses are in their intervals; empty if the report refuses them.
    of_masses: dict[str, bool]

    @property
    def close(self) -> bool:
        return self.reported and abs(self.antiresonance) < CLOSE and abs(self.resonance) < CLOSE


def tried(seed: int, elastic: bool) -> Tried:
    """Identify one drive from the log of its motor."""
    drive = drive_of(seed, elastic=elastic)
    columns: Any = columns_of(drive)
    axis = br.Axis(resolution=drive.step)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = br.identify(columns, "coulomb_viscous,stribeck", axis=axis, blocks=0, draws=0)
    facts, codes = found.treatment, [item.code for item in found.best.diagnostics]
    pairs = {
        "antiresonance": drive.antiresonance,
        "resonance": drive.resonance,
        "inertia_ratio": drive.load / drive.motor,
    }
    antiresonance, resonance, ratio = (
        100.0 * (facts[name] / truth - 1.0) if "antiresonance" in facts else np.nan
        for name, truth in pairs.items()
    )
    inside = [
        abs(facts[name] - truth) < facts[f"{name}_half_width"]
        for name, truth in pairs.items()
        if "antiresonance" in facts
    ]
    ends = found.best.parameters["M"].ends
    inside += [ends[0] < drive.total < ends[1]] if inside and ends else []
    suggested = {str(item.numbers.get("model", "")) for item in found.best.diagnostics} - {""}
    mass = 100.0 * (found.best.parameters["M"].value / drive.total - 1.0)
    first = codes[:1] == ["elastic_load"]
    reported, models = "antiresonance" in facts, tuple(sorted(suggested))
    both = {} if found.two_masses is None else found.two_masses.by_name
    of_masses = {
        name: abs(both[name].value - truth) < both[name].half_width
        for name, truth in _truths(drive).items()
        if both
    }
    return Tried(
        reported,
        antiresonance,
        resonance,
        ratio,
        mass,
        models,
        first,
        drive.gap > 0.0,
        tuple(inside),
        of_masses,
    )


def _truths(drive: Drive) -> dict[str, float]:
    """Return both masses, stiffness and damping of a drive."""
    damping = 2.0 * drive.damping * drive.load * 2.0 * np.pi * drive.antiresonance
    return {
        "motor": drive.motor,
        "load": drive.load,
        "stiffness": drive.stiffness,
        "damping": damping,
    }


def elastic(first: int = FIRST, count: int = COUNT) -> Iterator[Share]:
    """Yield the rates of detection and the shares of close values."""
    seeds = list(range(first, first + count))
    with ProcessPoolExecutor(core_count()) as pool:
        drives, rigid = (list(pool.map(tried, seeds, [kind] * count)) for kind in (True, False))
    for kind, results in (("elastic", drives), ("rigid", rigid)):
        for seed, one in zip(seeds, results, strict=True):
            print(kind, seed, one, file=sys.stderr)
    play, tight = ([one for one in drives if one.play == has] for has in (True, False))
    reported = [one for one in drives if one.reported]
    yield _share("elastic drive, reported", [one.reported for one in drives], least=95.0)
    yield _share("elastic drive, both frequencies within 3 %", [one.close for one in drives])
    yield _share("the same without play", [one.close for one in tight], least=95.0)
    yield _share("the same with play", [one.close for one in play])
    yield _share("rigid axis, reported as elastic", [one.reported for one in rigid], most=2.0)
    yield _share(
        "reported drive, elasticity first, no pre-sliding model",
        [one.first and not _cures(one) for one in reported],
        least=100.0,
    )
    yield _share(
        "true value in the 95 % interval",
        [part for one in reported for part in one.inside],
        NARROWEST,
        WIDEST,
    )
    yield _share("sum of the masses within 1 %", [abs(one.mass) < CLOSE_MASS for one in reported])
    yield _share(
        "the same without play", [abs(one.mass) < CLOSE_MASS for one in reported if not one.play]
    )
    shown = [one.of_masses for one in reported if one.of_masses]
    yield _share(
        "reported drive, both masses from one encoder", [bool(one.of_masses) for one in reported]
    )
    yield _share(
        "true value in the 95 % interval",
        [held for one in shown for held in one.values()],
        NARROWEST,
        WIDEST,
    )
    for name in ("motor", "load", "stiffness", "damping"):
        yield _share(f"the same, {name}", [one[name] for one in shown])


class Found(NamedTuple):
    """Two masses of one drive: whether the true values are in the intervals, and errors [%] of stiffness and sum of the masses."""

    inside: dict[str, bool]
    stiffness: float
    mass: float
    widths: dict[str, float]


def with_sensor(seed: int, *, has_nut: bool) -> Drive:
    """Draw a drive with a torque sensor between motor and screw; friction of a nut needs a scale to differ from a heavier load."""
    draw, drive = np.random.default_rng([55, seed]), drive_of(seed)
    level = sum(side[1] for side in drive.friction)
    screw, nut = (
        float(draw.choice([0.0, draw.uniform(*ends)])) for ends in ((0.05, 0.4), (0.05, 0.3))
    )
    return replace(
        drive,
        sensor=level * draw.uniform(0.002, 0.02),
        screw=drive.motor * screw,
        nut=nut if has_nut else 0.0,
    )


def found(seed: int, record: str = "two") -> Found | str:
    """Identify both masses of one drive from the log of both encoders, of a sensor, too, or of a sensor and one encoder."""
    drive = drive_of(seed) if record == "two" else with_sensor(seed, has_nut=record == "sensor")
    axis = br.Axis(resolution=drive.step)
    columns: Any = of_the_motor(log_of(drive)) if record == "no_scale" else log_of(drive)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        log = br.Log.from_columns(columns)
        if record == "no_scale":
            result = br.identify(log, "lugre", axis=axis, blocks=0, draws=0)
            both = result.two_masses or result.left_out["the plant with two masses"]
        else:
            both = two_masses([(log, axis)], partial(br.identify, model="lugre", blocks=0, draws=0))
    if isinstance(both, str):
        return both
    truths = _truths(drive) | ({"play": drive.gap} if both.play_is_clear else {})
    if record != "two":
        truths |= {"motor": drive.motor - drive.screw, "screw": drive.screw, "nut": drive.nut}
    if record == "no_scale":  # one rigid mass behind the sensor
        truths["load"] += drive.screw
    values = {name: both.by_name[name] for name in truths if name in both.by_name}
    inside = {
        name: abs(item.value - truths[name]) < item.half_width
        for name, item in values.items()
        if np.isfinite(item.half_width)
    }
    widths = {
        name: 100.0 * item.half_width / (item.value or np.inf)
        for name, item in values.items()
        if np.isfinite(item.half_width)
    }
    for (side, of_side), friction in zip(both.sides.items(), drive.friction, strict=True):
        name, level = f"{side} friction", of_side.best.parameters["F_C"]
        if level.status == "identified" and level.ends is not None:
            inside[name] = level.ends[0] < friction[1] < level.ends[1]
            widths[name] = 50.0 * (level.ends[1] - level.ends[0]) / level.value
    mass = values["motor"].value + values["load"].value
    mass += values["screw"].value if "screw" in values else 0.0
    stiffness = values["stiffness"].value if "stiffness" in values else np.nan
    return Found(
        inside,
        100.0 * (stiffness / drive.stiffness - 1.0),
        100.0 * (mass / drive.total - 1.0),
        widths,
    )


def two(first: int = 0, count: int = COUNT, record: str = "two") -> Iterator[Share]:
    """Yield the shares of intervals that hold the truth, and of close values, for logs with two encoders or a sensor."""
    seeds = list(range(first, first + count))
    with ProcessPoolExecutor(core_count()) as pool:
        results = list(pool.map(found, seeds, [record] * count))
    for seed, one in zip(seeds, results, strict=True):
        print("two", seed, one, file=sys.stderr)
    shown = [one for one in results if isinstance(one, Found)]
    yield _share(
        f"log with {RECORDS[record]}, two masses reported",
        [isinstance(one, Found) for one in results],
    )
    yield _share(
        "true value in the 95 % interval",
        [held for one in shown for held in one.inside.values()],
        least=92.0,
        most=98.0,
    )
    for name in (
        "motor",
        "load",
        "stiffness",
        "damping",
        "play",
        "screw",
        "nut",
        "motor friction",
        "load friction",
    ):
        if having := [one for one in shown if name in one.inside]:
            median = float(np.median([one.widths[name] for one in having]))
            yield _share(
                f"the same, {name}, median ± {median:.1f} %", [one.inside[name] for one in having]
            )
    stiff = [one for one in shown if not np.isnan(one.stiffness)]
    yield _share(
        "stiffness within 5 %", [abs(one.stiffness) < CLOSE_STIFFNESS for one in stiff], least=95.0
    )
    yield _share(
        "sum of the masses within 1 %", [abs(one.mass) < CLOSE_MASS for one in shown], least=95.0
    )


def _cures(one: Tried) -> bool:
    return any(name.startswith(("lugre", "dahl", "maxwell", "gms")) for name in one.suggested)


def _share(name: str, holds: list[bool], least: float = 0.0, most: float = 100.0) -> Share:
    return Share(name, 100.0 * float(np.mean(holds)), least, most, len(holds))


if __name__ == "__main__":
    record = next((name for name in RECORDS if sys.argv[1:2] == [name]), "")
    numbers = map(int, sys.argv[1 + bool(record) :])
    for share in two(*numbers, record=record) if record else elastic(*numbers):
        print(share.row())
