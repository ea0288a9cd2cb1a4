"""Do intervals hold the truth where the filter of the treatment rounds what friction does? LuGre in a loop, by RK4.

No code of the package makes these logs: a mass with LuGre friction is integrated by a Runge-Kutta method of fourth
order within each tick of a cascade that holds its effort. Pre-sliding is crossed within a few samples at each reversal,
and a contact rings as fast as the filter lets it; most encoders are nearly free of noise, as those of simulations are.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np
from numba import njit

import bristle as br
from benchmarks.coverage import Share
from bristle.core.cores import core_count

__all__ = ["Case", "Found", "corners", "log_of", "tried"]

FIRST, LOGS, DRAWS = 200, 30, 50
DURATION, FINE = 16.0, 2e-5  # s
SINES = ((0.31, 0.33), (0.97, 0.083), (2.3, 0.025), (0.13, 0.33))  # Hz, share of the top speed [m]


class Case(NamedTuple):
    """Motion and treatment of logs: `counts` of the encoder to the pre-sliding zone, noise of the effort over F_C."""

    slides: bool
    rate: float
    counts: float
    noise: float


CASES = {
    "sines, 1 kHz": Case(True, 1e3, 1e4, 1e-3),
    "sines, 2 kHz": Case(True, 2e3, 1e4, 1e-3),
    "sines, 1 kHz, 50 counts": Case(True, 1e3, 50.0, 1e-2),
    "loops and strokes, 1 kHz": Case(False, 1e3, 1e4, 1e-3),
    "loops and strokes, 1 kHz, 50 counts": Case(False, 1e3, 50.0, 1e-2),
}


class Found(NamedTuple):
    """Which intervals hold the truth, which miss it by more than their width, and the codes that were told."""

    inside: dict[str, bool]
    far: tuple[str, ...]
    codes: frozenset[str]


@njit(cache=True)
def _rates(v: float, z: float, u: float, p: np.ndarray) -> tuple[float, float]:
    mass, F_C, F_S, v_S, sigma_0, sigma_1, sigma_2, offset = p
    dz = v - sigma_0 * abs(v) / (F_C + (F_S - F_C) * math.exp(-((v / v_S) ** 2))) * z
    return (u - sigma_0 * z - sigma_1 * dz - sigma_2 * v - offset) / mass, dz


@njit(cache=True)
def _loop(
    r: np.ndarray,
    r_v: np.ndarray,
    period: float,
    fine: int,
    p: np.ndarray,
    gains: np.ndarray,
    step: float,
):
    """Return the counted position and the command at each tick."""
    out, h = np.empty((2, r.size)), period / fine
    x = v = z = integral = last = 0.0
    for tick in range(r.size):
        y = step * math.floor(x / step + 0.5)
        error = gains[0] * (r[tick] - y) + r_v[tick] - (y - last) / period
        integral, last = integral + gains[2] * period * error, y
        u = gains[1] * error + integral
        out[0, tick], out[1, tick] = y, u
        for _ in range(fine):
            a1, b1 = _rates(v, z, u, p)
            a2, b2 = _rates(v + 0.5 * h * a1, z + 0.5 * h * b1, u, p)
            a3, b3 = _rates(v + 0.5 * h * a2, z + 0.5 * h * b2, u, p)
            a4, b4 = _rates(v + h * a3, z + h * b3, u, p)
            x += h * v + h * h * (a1 + a2 + a3) / 6.0
            v += h * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0
            z += h * (b1 + 2.0 * b2 + 2.0 * b3 + b4) / 6.0
    return out


def _reference(
    rng: np.random.Generator, t: np.ndarray, zone: float, speed: float, *, slides: bool
) -> np.ndarray:
    """Sines that start softly, or small loops in turn with strokes from the same place [m]."""
    if slides:
        waves = [
            share * speed * np.sin(2.0 * np.pi * f * t + rng.uniform(0.0, 6.0))
            for f, share in SINES
        ]
        r = np.sum(waves, axis=0)
        return (r - r[0]) * np.minimum(t / 0.5, 1.0) ** 2
    r, start, small = np.zeros_like(t), 0.2, True
    while start < t[-1]:
        if small:
            amplitude, f = zone * rng.uniform(0.6, 4.0), rng.uniform(0.8, 2.0)
            s, start = t - start, start + 2.0 / f
            shape = np.sin(2.0 * np.pi * f * s) * np.minimum(2.0 * f * s, 1.0)
        else:
            amplitude, f = speed * rng.uniform(0.1, 1.0) / (1.6 * np.pi), 0.8
            s, start = t - start, start + 1.0 / f
            shape = 1.0 - np.cos(2.0 * np.pi * f * s)
        r += np.where((s >= 0.0) & (s < start - (t[0] - s[0])), amplitude * shape, 0.0)
        small = not small
    return r


def log_of(case: Case, seed: int) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Return the columns of a log, and the truth."""
    rng = np.random.default_rng(seed)
    mass = float(10.0 ** rng.uniform(0.0, 1.3))
    F_C = mass * rng.uniform(1.0, 4.0)
    F_S, zone = F_C * rng.uniform(1.15, 1.6), float(10.0 ** rng.uniform(-5.3, -4.3))
    sigma_0, speed = F_S / zone, rng.uniform(0.03, 0.15)
    truth = {
        "M": mass,
        "F_C": F_C,
        "F_S": F_S,
        "v_S": speed * rng.uniform(0.02, 0.08),
        "sigma_0": sigma_0,
        "sigma_1": min(2.0 * rng.uniform(0.2, 0.6) * math.sqrt(sigma_0 * mass), 4e-3 * sigma_0),
        "sigma_2": F_C * rng.uniform(0.2, 1.0) / speed,
        "offset": rng.uniform(-0.2, 0.2) * F_C,
    }
    period, bandwidth = 1.0 / case.rate, 2.0 * np.pi * rng.uniform(12.0, 25.0)
    t = period * np.arange(round(DURATION * case.rate))
    r = _reference(rng, t, zone, speed, slides=case.slides)
    gains = np.array([bandwidth / 4.0, mass * bandwidth, mass * bandwidth**2 / 5.0])
    fine, parameters = round(period / FINE), np.array(list(truth.values()))
    y, u = _loop(r, np.gradient(r, period), period, fine, parameters, gains, zone / case.counts)
    return {
        "time": t,
        "position": y,
        "effort": u + case.noise * F_C * rng.standard_normal(t.size),
    }, truth


def tried(name: str, seed: int) -> Found:
    """Identify a log with nothing told, and see which intervals hold the truth."""
    columns, truth = log_of(CASES[name], seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = br.identify(columns, "lugre", blocks=0, draws=DRAWS)
    inside, far = dict[str, bool](), []
    for parameter, known in truth.items():
        estimate = found.parameters[parameter]
        if estimate.status == "identified" and estimate.interval is not None:
            low, high = estimate.interval
            inside[parameter] = bool(low <= known <= high)
            far += [parameter] if max(low - known, known - high) > high - low else []
    return Found(
        inside,
        tuple(far),
        frozenset(one.code for one in found.diagnostics if one.severity != "note"),
    )


def corners(first: int = FIRST) -> Iterator[Share]:
    """Yield the coverage of each case, pooled and of each parameter, and how often a right model is told to differ."""
    seeds = range(first, first + LOGS)
    with ProcessPoolExecutor(core_count()) as pool:
        for name in CASES:
            found = list(pool.map(tried, [name] * LOGS, seeds))
            every = [inside for one in found for inside in one.inside.values()]
            silent = sum(len(one.far) for one in found if not one.codes)
            note = f"{silent} miss by more than their width without a word"
            yield Share(
                f"{name}, pooled", 100.0 * float(np.mean(every)), 88.0, 100.0, len(every), note
            )
            for parameter in dict.fromkeys(key for one in found for key in one.inside):
                inside = [one.inside[parameter] for one in found if parameter in one.inside]
                yield Share(
                    f"{name}, {parameter}", 100.0 * float(np.mean(inside)), 0.0, 100.0, len(inside)
                )
