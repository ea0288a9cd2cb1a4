"""The inertia of small rotors that are driven by steps of torque, behind an encoder whose error is not white.

The simulator shares nothing with bristle: friction of Coulomb, Stribeck and viscous kind that holds the rotor at rest, an
integrator of its own, an encoder with an error in a band of 20 to 40 Hz, such as that of a coupling or of a disc that is not
centred. Nothing is stated but the step of the encoder. ``python -m benchmarks.rotors 1000 40`` asks about seeds of one's own.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import NamedTuple

import numba
import numpy as np

import bristle as br
from benchmarks.coverage import Share
from bristle.core.cores import core_count

__all__ = ["Judged", "Rotor", "made", "rotors", "tried"]

FINE = 20  # steps of the integrator in a sample
BAND = 20.0, 40.0  # Hz: of the error of the encoder
# Of the error over what rounding has in that band, or in every other log over all of it.
TIMES = (30.0, 100.0)
FIRST, LOGS = 1000, 40
MODEL, NORMAL = "stribeck", 1.96
BANDS, STEADY, SHARP = (100.0, 25.0), 8.0, 35.0  # Hz: of the rows; of the inertia [%]
DOUBTS = {"stages_differ", "noisy_acceleration"}


class Rotor(NamedTuple):
    """What is true of a rotor, in SI, and its log: time, position and effort."""

    inertia: float
    coulomb: float
    static: float
    stribeck: float
    viscous: float
    counts: int
    delay: float  # samples by which the torque acts later than it is recorded
    rate: float
    table: dict[str, np.ndarray]

    @property
    def step(self) -> float:
        """The step of the encoder [rad]."""
        return 2.0 * np.pi / self.counts


class Judged(NamedTuple):
    """The inertia of one log: relative error and half-width [%], whether its interval holds, and the warnings about it."""

    error: float
    half_width: float
    holds: bool
    identified: bool
    warned: bool


@numba.njit(cache=True)
def turned(
    torque: np.ndarray,
    dt: float,
    inertia: float,
    coulomb: float,
    static: float,
    stribeck: float,
    viscous: float,
) -> np.ndarray:
    """Return the position of a rotor at each torque [rad], by steps of the midpoint; what holds it at rest holds all of a step."""
    position, q, v = np.empty(torque.size), 0.0, 0.0
    for i in range(torque.size):
        position[i] = q
        if v == 0.0 and abs(torque[i]) <= static:
            continue
        side = np.sign(v) if v != 0.0 else np.sign(torque[i])
        half = v
        for share in (0.5, 1.0):
            friction = (
                side * (coulomb + (static - coulomb) * np.exp(-((half / stribeck) ** 2)))
                + viscous * half
            )
            half = v + share * dt * (torque[i] - friction) / inertia
        if half * side <= 0.0:
            half = 0.0
        q += 0.5 * dt * (v + half)
        v = half
    return position


def _in_band(count: int, rate: float, rng: np.random.Generator) -> np.ndarray:
    """Return noise of a standard deviation of one in the band."""
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    spectrum = np.where(
        inside, rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size), 0.0
    )
    noise = np.fft.irfft(spectrum, count)
    return noise / np.std(noise)


def made(seed: int) -> Rotor:
    """Return a rotor with its log."""
    rng = np.random.default_rng((seed, 77001))
    rate = float(rng.choice([500.0, 1000.0]))
    duration = rng.uniform(10.0, 20.0)
    inertia = float(np.exp(rng.uniform(*np.log([0.5e-4, 5e-4]))))
    viscous = inertia / float(np.exp(rng.uniform(*np.log([0.03, 0.5]))))
    top = rng.uniform(8.0, 40.0)  # rad/s
    coulomb = viscous * top * rng.uniform(0.1, 0.6)
    static, stribeck = coulomb * rng.uniform(1.05, 1.6), rng.uniform(0.03, 0.1) * top
    counts = int(np.exp(rng.uniform(*np.log([4000, 20000]))))
    delay = rng.uniform(0.0, 2.0)
    count, longest = int(duration * rate), float(np.exp(rng.uniform(*np.log([0.6, 4.0]))))
    torque, at = np.empty(count), 0
    while at < count:
        length = int(rng.uniform(0.2, 1.0) * longest * rate)
        side = -1.0 if rng.random() < 0.5 else 1.0
        torque[at : at + length] = side * (coulomb + viscous * top * rng.uniform(0.1, 1.0))
        at += length
    # What is recorded acts so many samples later, and until the next sample.
    fine = np.repeat(torque, FINE)
    late = round(delay * FINE)
    acting = np.concatenate([np.zeros(late), fine])[: fine.size]
    position = turned(acting, 1.0 / (rate * FINE), inertia, coulomb, static, stribeck, viscous)[
        ::FINE
    ]
    step = 2.0 * np.pi / counts
    rounding = step / 12.0**0.5 * (1.0 if seed % 2 else ((BAND[1] - BAND[0]) / (0.5 * rate)) ** 0.5)
    error = rounding * np.exp(rng.uniform(*np.log(TIMES))) * _in_band(count, rate, rng)
    read = step * np.round((position + error) / step)
    effort = torque + 0.01 * np.std(torque) * rng.standard_normal(count)
    table = {"time": np.arange(count) / rate, "position": read, "effort": effort}
    return Rotor(inertia, coulomb, static, stribeck, viscous, counts, delay, rate, table)


def tried(seed: int, cutoff: float | None = None) -> Judged:
    """Identify one log, its rows behind a `cutoff` [Hz] where one is given, and judge the inertia."""
    rotor = made(seed)
    axis = br.Axis(kind="rotational", resolution=rotor.step)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit = br.identify(rotor.table, MODEL, axis=axis, cutoff=cutoff, blocks=0, draws=0).best  # type: ignore[arg-type]
    estimate = fit.parameters["M"]
    width = NORMAL * (estimate.larger_std or np.nan)
    low, high = estimate.interval or (estimate.value - width, estimate.value + width)
    warned = any(entry.code in DOUBTS and entry.severity == "warning" for entry in fit.diagnostics)
    holds, error = low <= rotor.inertia <= high, 100.0 * (estimate.value / rotor.inertia - 1.0)
    return Judged(
        error, 50.0 * (high - low) / rotor.inertia, holds, estimate.status == "identified", warned
    )


def rotors(first: int = FIRST, count: int = LOGS) -> Iterator[Share]:
    """Coverage of the interval of the inertia, its half-width, and by how much the cut-off of the rows moves it."""
    with ProcessPoolExecutor(core_count()) as pool:
        seeds = range(first, first + count)
        plain, wide, narrow = (
            list(pool.map(partial(tried, cutoff=cutoff), seeds)) for cutoff in (None, *BANDS)
        )
    sure = [entry for entry in plain if entry.identified]
    width, errors = (
        float(np.median([entry.half_width for entry in sure])),
        [abs(entry.error) for entry in sure],
    )
    note = f"error {np.median(errors):.1f} %, 90 % within {np.quantile(errors, 0.9):.1f}, half-width {width:.1f}"
    yield Share(
        "inertia of rotors, intervals that hold",
        100.0 * float(np.mean([entry.holds for entry in sure])),
        92.0,
        100.0,
        len(sure),
        note,
    )
    yield Share("inertia of rotors, identified", 100.0 * len(sure) / count, 90.0, 100.0, count)
    yield Share(
        "inertia of rotors, half-width up to 35 %",
        100.0 * float(np.mean([entry.half_width <= 35.0 for entry in sure])),
        50.0,
        100.0,
        len(sure),
    )
    pairs = [
        (one, other)
        for one, other in zip(wide, narrow, strict=True)
        if one.identified and other.identified
    ]
    steady = [abs(one.error - other.error) <= STEADY for one, other in pairs]
    yield Share(
        "inertia of rotors, equal at 100 and 25 Hz",
        100.0 * float(np.mean(steady)),
        90.0,
        100.0,
        len(pairs),
    )


if __name__ == "__main__":
    for share in rotors(*map(int, sys.argv[1:])):
        print(share.row(), flush=True)
