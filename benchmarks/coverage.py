"""Do 95 % intervals hold the truth in 95 % of the cases? Synthetic logs of an axis whose friction is known.

Each log begins with a conditioning slide and goes through 46 half-cycles, small triangles of pre-sliding in turn with
strokes at sliding speed. The truth runs five times as fine as the log, and its level scatters from reversal to
reversal; the position is read through an encoder, the effort with noise.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from benchmarks.legs import Leg, Motion, along
from bristle import friction
from bristle.core import Axis
from bristle.core.cores import core_count
from bristle.core.packing import pack
from bristle.engine.motion import in_turns
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.prediction import predict

__all__ = [
    "CASES",
    "STRANGERS",
    "Inside",
    "Share",
    "Trial",
    "coverage",
    "predicted_shares",
    "tried",
]

ENCODER = 0.125e-6  # m
NOISE = 0.005  # of the largest friction force
SCATTER = 0.05  # of the level of friction, from reversal to reversal
MASS = 20.0  # kg
SAMPLE_TIME, FINER = 1e-3, 5
ACCELERATION = 0.2  # m/s^2
AXIS = Axis(mass=MASS, resolution=ENCODER, offset=0.0, decimation=5, method="inverse_dynamics")
TRIALS, DRAWS = 100, 120
CURVE = 6  # points of the virgin curve, up to where all elements slip


@dataclass(frozen=True)
class Truth:
    """A friction model with values, and those of them that set its level."""

    model: str
    values: Mapping[str, Any]
    level: tuple[str, ...]

    def at(self, level: float) -> Any:
        return friction.find(self.model)(
            **{**self.values, **{name: level * self.values[name] for name in self.level}}
        )


def _elements(count: int, farthest: float) -> dict[str, list[float]]:
    """Stops that break away one after the other up to a distance [m], no two alike."""
    reach = farthest * np.linspace(0.12, 1.0, count) ** 1.6
    share = (reach / farthest) ** 0.3 * np.exp(
        0.35 * np.random.default_rng(7).standard_normal(count)
    )
    share /= share.sum()
    return {"k_i": (24.0 * share / reach).tolist(), "nu_i": share.tolist()}


LUGRE = {"F_C": 20.0, "F_S": 28.0, "v_S": 2e-3, "sigma_0": 1e7, "sigma_1": 1e3, "sigma_2": 200.0}
CASES = {
    "dahl": Truth("dahl", {"F_C": 24.0, "sigma_0": 1e7, "sigma_2": 200.0}, ("F_C",)),
    "lugre": Truth("lugre", LUGRE, ("F_C", "F_S")),
    "preisach_lugre": Truth(
        "preisach_lugre",
        {
            "s": 1e7,
            "f_p": 40.0,
            "F_C": 20.0,
            "F_S": 28.0,
            "v_S": 2e-3,
            "sigma_1": 1e3,
            "sigma_2": 200.0,
        },
        ("f_p", "F_C", "F_S"),
    ),
}
MAXWELL = Truth("maxwell_slip", {"F_C": 24.0, "sigma_2": 200.0, **_elements(12, 8e-6)}, ("F_C",))
CASES["maxwell_slip"] = MAXWELL
# What is fitted though the truth is made otherwise.
STRANGERS = ("dahl", "lugre")


def motion(amplitudes: tuple[float, ...], speeds: tuple[float, ...], pairs: int = 23) -> Motion:
    """A conditioning slide, then pairs of half-cycles: small triangles and, every other time, a stroke at speed."""
    centre = 6e-3
    legs = [Leg(centre, 2e-3)]
    for pair in range(pairs):
        which, small = pair // 2, pair % 2 == 0
        speed = 20e-6 if small else speeds[which % len(speeds)]
        reach = amplitudes[which % len(amplitudes)] if small else max(60e-6, 0.15 * speed)
        legs += [Leg(centre + reach, speed), Leg(centre - reach, speed)]
        if not small:
            legs.append(Leg(centre, max(speed, 1e-3)))
    return along(legs, ACCELERATION, SAMPLE_TIME / FINER)


FITTED = ((1.5e-6, 3e-6, 6e-6, 9e-6), (0.5e-3, 1e-3, 2e-3, 4e-3, 10e-3, 20e-3))
UNSEEN = ((2e-6, 7.5e-6, 4.5e-6), (1.5e-3, 15e-3, 0.7e-3, 6e-3))


def recorded(truth: Truth, path: Motion, seed: int) -> Log:
    """The log of an axis with this friction on this motion."""
    rng, dt = np.random.default_rng(seed), path.sample_time
    velocity = np.diff(path.position) / dt
    starts = (0, *(np.flatnonzero(np.diff(np.sign(velocity) >= 0.0)) + 1).tolist())
    levels = [truth.at(1.0 + SCATTER * rng.standard_normal()) for _ in starts]
    rows = np.array([pack(one.parameters) for one in levels])
    force = in_turns(levels[0], rows, velocity, dt, path.position[1:], starts)
    # The mean over the steps on both sides of a sample is the force at it.
    at_sample = 0.5 * (force[:-1] + force[1:])[FINER - 1 :: FINER]
    kept = slice(FINER, FINER * at_sample.size + 1, FINER)
    effort = MASS * path.acceleration[kept] + at_sample
    effort += NOISE * np.max(np.abs(at_sample)) * rng.standard_normal(effort.size)
    phase = rng.uniform(0.0, ENCODER)
    position = ENCODER * np.round((path.position[kept] + phase) / ENCODER)
    return Log(
        time=Channel(path.time[kept], "s", "t"),
        position=Channel(position, "m", "x"),
        effort=Channel(effort, "N", "u"),
        sample_time=SAMPLE_TIME,
        segments=(slice(0, effort.size),),
    )


class Trial(NamedTuple):
    """For each parameter that was identified, whether its interval holds the truth; and so for the scatter."""

    covered: dict[str, bool]
    scatter: bool
    seconds: float


def tried(name: str, seed: int, draws: int = DRAWS) -> Trial:
    """Record a log of a case, identify it, and see which intervals hold the truth."""
    from time import perf_counter

    truth = CASES[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        log, begin = recorded(truth, motion(*FITTED), seed), perf_counter()
        fit = identify(log, name, axis=AXIS, blocks=0, draws=draws).best
    known = dict(truth.values)
    if "k_i" in known:
        known["s"] = sum(known["k_i"])
    covered = {
        one.name: one.interval[0] <= known[one.name] <= one.interval[1]
        for one in fit.estimates
        if one.status == "identified" and one.interval is not None
    }
    for number, (x, _, low, high) in enumerate(fit.resampling.curve[:CURVE]):
        covered[f"f_v, point {number + 1}"] = low <= _virgin(truth, x) <= high
    scatter = fit.resampling.scatter
    return Trial(covered, scatter.low <= SCATTER <= scatter.high, perf_counter() - begin)


def _virgin(truth: Truth, x: float) -> float:
    """The force of elements that slip, at the first displacement [m] of all [N]."""
    k = np.array(truth.values["k_i"])
    return float(np.sum(np.minimum(k * x, truth.values["F_C"] * np.array(truth.values["nu_i"]))))


class Inside(NamedTuple):
    """Shares of an unseen motion in the bands [%]: of its effort, and of the position that this effort makes."""

    effort: float
    position: float


def predicted_shares(name: str, seed: int, draws: int = DRAWS) -> Inside:
    """Fit a model to a truth that is made otherwise; return how much of an unseen motion lies in its bands."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit = identify(
            recorded(MAXWELL, motion(*FITTED), seed), name, axis=AXIS, blocks=0, draws=draws
        ).best
        unseen, bands = recorded(MAXWELL, motion(*UNSEEN), 10_000 + seed), fit.resampling.bands
        along = predict(fit.plant, fit.friction, unseen, AXIS, bands=bands)
        driven = predict(fit.plant, fit.friction, unseen, AXIS, "open-loop", bands=bands)
        return Inside(along.inside_percent or 0.0, driven.position_inside_percent or 0.0)


@dataclass(frozen=True)
class Share:
    """A claim about a share [%]: between which bounds it must lie."""

    name: str
    percent: float
    low: float
    high: float
    of: int
    note: str = ""

    @property
    def missed(self) -> bool:
        """Whether the claim does not hold."""
        return not self.low <= self.percent <= self.high

    def row(self) -> str:
        """Return the claim as a line of the table."""
        verdict = "MISSED" if self.missed else "ok"
        bounds = f"{self.low:g} to {self.high:g} %"
        return f"{self.name:<44} {self.percent:>8.1f} % {bounds:>14} {verdict:<7} of {self.of}; {self.note}"


def coverage() -> Iterator[Share]:
    """Coverage of 95 % intervals where the model is right, and of bands where it is not."""
    with ProcessPoolExecutor(core_count()) as pool:
        for name in CASES:
            yield from _of_case(name, list(pool.map(tried, [name] * TRIALS, range(TRIALS))))
        for name in STRANGERS:
            shares = list(pool.map(predicted_shares, [name] * TRIALS, range(TRIALS)))
            yield _of_bands(f"bands of {name}", [one.effort for one in shares], 99.0)
            # All samples of an open loop err alike: whole logs are in or out.
            yield _of_bands(f"bands of {name}, open loop", [one.position for one in shares], 100.0)


def _of_bands(name: str, shares: list[float], high: float) -> Share:
    note = (
        f"unseen motion, truth maxwell_slip; single logs {min(shares):.0f} to {max(shares):.0f} %"
    )
    return Share(name, float(np.mean(shares)), 85.0, high, len(shares), note)


def _of_case(name: str, trials: list[Trial]) -> Iterator[Share]:
    every = [inside for one in trials for inside in one.covered.values()]
    seconds = f"{np.mean([one.seconds for one in trials]):.1f} s a trial"
    yield Share(f"{name}, pooled", 100.0 * float(np.mean(every)), 90.0, 98.0, len(every), seconds)
    for parameter in dict.fromkeys(key for one in trials for key in one.covered):
        inside = [one.covered[parameter] for one in trials if parameter in one.covered]
        if len(inside) >= len(trials) // 2:
            yield Share(
                f"{name}, {parameter}", 100.0 * float(np.mean(inside)), 85.0, 100.0, len(inside)
            )
    scatter = [one.scatter for one in trials]
    yield Share(
        f"{name}, scatter per reversal", 100.0 * float(np.mean(scatter)), 85.0, 100.0, len(scatter)
    )
