"""Do the intervals of stiffness and damping from sweeps hold the truth?

The simulator shares no code with bristle. Its frictions are LuGre, Dahl, Maxwell slip, generalised Maxwell slip, and branches
of exponential shape with a memory of turning points, whose hysteresis depends on the mean position, as that of a Preisach
operator does. Mass, resonance, damping, encoder, noise, delay, constant force, loop and amplitudes are drawn. A position
loop follows chirps, or a weak loop holds the axis while chirps of effort move it.
``python -m benchmarks.frequency_stiffness [FIRST COUNT]`` prints the shares.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

import bristle as br
from benchmarks.coverage import Share
from bristle.core.cores import core_count
from bristle.identification.dahl_resonance import DahlResonance, dahl_resonance

__all__ = ["Sweep", "columns_of", "frequency_stiffness", "sweep_of", "tried"]

LUGRE, DAHL, MAXWELL, GMS, BRANCHES = range(5)
KINDS = ("lugre", "dahl", "maxwell slip", "gms", "branches")
SUBSTEPS = 8
FIRST, COUNT = 2000, 320


@dataclass(frozen=True)
class Sweep:
    """An axis, its loop and its sweeps; SI units of a linear axis."""

    kind: int
    mass: float
    stiffness: float
    damping: float  # at small amplitudes
    level: float
    numbers: tuple[float, ...]  # of the friction
    elements: tuple[tuple[float, ...], tuple[float, ...]]  # stiffnesses and thresholds
    sample_time: float
    gains: tuple[float, float, float]
    by_effort: bool
    amplitudes: tuple[float, ...]  # m, or N for sweeps of effort
    frequencies: tuple[float, float]
    duration: float  # of a sweep
    constant: float
    step: float
    jitter: float
    noise: float  # of the recorded effort
    torque_noise: float
    late: int  # samples by which the recorded effort lags
    seed: int


def sweep_of(seed: int) -> Sweep:
    """Draw an axis."""
    draw = np.random.default_rng([77, seed])
    kind = int(draw.integers(len(KINDS)))
    mass, hertz, zeta = (
        10.0 ** draw.uniform(-0.5, 1.8),
        10.0 ** draw.uniform(1.0, 2.0),
        draw.uniform(0.02, 0.4),
    )
    omega = 2.0 * math.pi * hertz
    stiffness, damping = mass * omega**2, 2.0 * zeta * mass * omega
    reach = 10.0 ** draw.uniform(-6.3, -4.5)
    level = stiffness * reach
    viscous = damping * draw.uniform(0.05, 0.6) if kind in (LUGRE, GMS) else damping
    numbers = (
        level * draw.uniform(1.0, 1.6),
        reach * omega * draw.uniform(0.3, 10.0),
        damping - viscous,
        viscous,
        draw.uniform(-0.3, 0.3),
    )
    count = int(draw.integers(4, 16))
    parts = draw.dirichlet(np.full(count, 2.0))
    reaches = 10.0 ** draw.uniform(-1.3, 0.5, count)
    reaches *= reach / float(parts @ reaches)
    if kind == GMS:  # the element that breaks away last keeps the damping
        numbers = (numbers[0], numbers[1], 0.0, damping, level * omega * draw.uniform(0.5, 5.0))
    sample_time = 1.0 / (hertz * 10.0 ** draw.uniform(1.5, 2.1))
    by_effort = bool(draw.random() < 0.5)
    bandwidth = omega * (draw.uniform(0.15, 0.5) if by_effort else draw.uniform(1.0, 2.0))
    bandwidth = min(bandwidth, 0.15 / sample_time)
    gains = (mass * bandwidth**2, 1.4 * mass * bandwidth, mass * bandwidth**3 * 0.2)
    sizes = np.geomspace(draw.uniform(0.02, 0.06), draw.uniform(0.2, 0.4), int(draw.integers(3, 7)))
    amplitudes = (
        sizes * reach * (stiffness * max(2.0 * zeta, 0.15) ** 0.5 * 0.7 if by_effort else 1.0)
    )
    frequencies = (
        hertz * draw.uniform(0.1, 0.3),
        min(hertz * draw.uniform(1.5, 2.5), 0.1 / sample_time),
    )
    return Sweep(
        kind,
        mass,
        stiffness,
        damping,
        level,
        numbers,
        (tuple(stiffness * parts), tuple(reaches)),
        sample_time,
        gains,
        by_effort,
        tuple(draw.permutation(amplitudes).tolist()),
        frequencies,
        float(draw.uniform(60.0, 200.0) / hertz),
        float(level * draw.choice([0.0, draw.uniform(-0.5, 0.5)])),
        float(sizes[0] * reach / 10.0 ** draw.uniform(0.4, 1.8)),
        float(draw.choice([0.0, draw.uniform(0.0, 0.5)])),
        float(level * 10.0 ** draw.uniform(-3.5, -2.0)),
        float(level * 10.0 ** draw.uniform(-4.0, -2.5)),
        int(draw.integers(0, 3)),
        seed,
    )


def columns_of(sweep: Sweep) -> dict[str, np.ndarray]:
    """Simulate the log of an axis."""
    dt, draw = sweep.sample_time, np.random.default_rng([78, sweep.seed])
    parts = []
    low, high = sweep.frequencies
    for amplitude in sweep.amplitudes:
        t = np.arange(0.0, sweep.duration, dt)
        rate = math.log(high / low) / sweep.duration
        fade = np.clip(np.minimum(t, sweep.duration - t) * low / 1.0, 0.0, 1.0)
        parts += [
            amplitude * fade * np.sin(2.0 * math.pi * low * np.expm1(rate * t) / rate),
            np.zeros(round(2.0 / low / dt)),
        ]
    signal = np.concatenate([np.zeros(round(2.0 / low / dt)), *parts])
    pushes = sweep.torque_noise * draw.standard_normal(signal.size)
    dither = sweep.step * (draw.uniform() + sweep.jitter * draw.standard_normal(signal.size))
    position, effort = _simulated(
        sweep.kind,
        sweep.mass,
        sweep.stiffness,
        sweep.level,
        np.array(sweep.numbers),
        np.array(sweep.elements[0]),
        np.array(sweep.elements[1]),
        dt,
        np.array(sweep.gains),
        sweep.by_effort,
        signal,
        pushes + sweep.constant,
        sweep.step,
        dither,
    )
    recorded = effort + sweep.noise * draw.standard_normal(signal.size)
    if sweep.late:
        position, recorded = position[sweep.late :], recorded[: -sweep.late]
    return {"time": np.arange(recorded.size) * dt, "position": position, "effort": recorded}


@numba.njit(cache=True)  # type: ignore[misc]
def _force(kind, x, v, dx, h, stiffness, level, numbers, springs, reaches, memory, stack):
    """Return the friction force after a step `dx`; `memory` and `stack` change."""
    high, v_s, micro, viscous, further = numbers
    if kind == LUGRE:
        steady = level + (high - level) * math.exp(-((v / v_s) ** 2))
        decay = abs(dx) * stiffness / steady
        target = steady / stiffness * (1.0 if dx >= 0.0 else -1.0)
        memory[0] = target + (memory[0] - target) * math.exp(-decay)
        rate = v * (1.0 - (1.0 if v >= 0.0 else -1.0) * stiffness * memory[0] / steady)
        return stiffness * memory[0] + micro * rate + viscous * v
    if kind == DAHL:
        target = level * (1.0 if dx >= 0.0 else -1.0)
        memory[0] = target + (memory[0] - target) * math.exp(-abs(dx) * stiffness / level)
        return memory[0] + viscous * v
    if kind == MAXWELL:
        total = viscous * v
        for i in range(springs.size):
            bound = springs[i] * reaches[i]
            memory[i] = min(max(memory[i] + springs[i] * dx, -bound), bound)
            total += memory[i]
        return total
    if kind == GMS:
        total, ratio = viscous * v, 1.0 + (high / level - 1.0) * math.exp(-((v / v_s) ** 2))
        share = 0.0
        for i in range(springs.size):
            share += springs[i] * reaches[i]
        for i in range(springs.size):
            part = springs[i] * reaches[i]
            bound = part * ratio
            side = 1.0 if v >= 0.0 else -1.0
            sticks = memory[i] + springs[i] * dx
            if abs(sticks) > bound and sticks * v > 0.0:
                memory[i] += part / share * side * further * h * (1.0 - side * memory[i] / bound)
                memory[i] = side * min(side * memory[i], max(bound, side * (memory[i])))
            else:
                memory[i] = sticks
            total += memory[i]
        return total
    # Branches from turning points: stack holds position and hysteresis at each, memory[0] their number, memory[1] the position.
    before, n = memory[1], int(memory[0])
    if dx != 0.0:
        rising = dx > 0.0
        if n == 0:
            stack[0, 0], stack[0, 1], n = -1e3, 0.0, 0
        if memory[2] != 0.0 and (memory[2] > 0.0) != rising and n < stack.shape[0] - 1:
            n += 1
            stack[n, 0], stack[n, 1] = before, memory[3]
        memory[2] = 1.0 if rising else -1.0
        while n >= 2 and (
            (rising and x >= stack[n - 1, 0]) or (not rising and x <= stack[n - 1, 0])
        ):
            n -= 2
        length = level / stiffness
        if n == 0:  # the virgin branch
            size = abs(x)
            memory[3] = math.copysign(level * _lost(size / length), x) * (
                1.0 + further * math.tanh(0.5 * x / length)
            )
        else:
            origin = stack[n, 0]
            mean = 1.0 + further * math.tanh(0.5 * (x + origin) / length)
            memory[3] = (
                stack[n, 1]
                + math.copysign(2.0 * level * _lost(0.5 * abs(x - origin) / length), x - origin)
                * mean
            )
        memory[0], memory[1] = n, x
    return stiffness * x - memory[3] + viscous * v


@numba.njit(cache=True)  # type: ignore[misc]
def _lost(x):
    return x - 0.7 * (1.0 - math.exp(-x / 0.7))


@numba.njit(cache=True)  # type: ignore[misc]
def _simulated(
    kind,
    mass,
    stiffness,
    level,
    numbers,
    springs,
    reaches,
    dt,
    gains,
    by_effort,
    signal,
    pushes,
    step,
    dither,
):
    """Return recorded position and effort of a loop."""
    count = signal.size
    position, effort = np.empty(count), np.empty(count)
    memory, stack = np.zeros(max(springs.size, 4)), np.zeros((400, 2))
    x = v = force = integral = 0.0
    smooth = earlier = 0.0
    h = dt / SUBSTEPS
    for k in range(count):
        read = math.floor((x + dither[k]) / step) * step
        position[k] = read
        speed = (read - earlier) / dt if k else 0.0
        earlier = read
        smooth += 0.5 * (speed - smooth)
        error = -read if by_effort else signal[k] - read
        integral += gains[2] * dt * error
        u = gains[0] * error - gains[1] * smooth + integral + (signal[k] if by_effort else 0.0)
        if not by_effort and k:
            u += gains[1] * (signal[k] - signal[k - 1]) / dt
        effort[k] = u
        drive = u + pushes[k]
        for _ in range(SUBSTEPS):
            middle, late = v + 0.5 * h * (drive - force) / mass, v + h * (drive - force) / mass
            dx = h * middle
            x += dx
            force = _force(
                kind, x, late, dx, h, stiffness, level, numbers, springs, reaches, memory, stack
            )
            v = middle + 0.5 * h * (drive - force) / mass
    return position, effort


def tried(seed: int) -> tuple[str, DahlResonance | str | None, float, float]:
    """Return the kind of friction, the result, and the true stiffness and damping."""
    sweep = sweep_of(seed)
    columns: Any = columns_of(sweep)
    log = br.Log.from_columns(columns)
    return KINDS[sweep.kind], dahl_resonance([log], sweep.step), sweep.stiffness, sweep.damping


def frequency_stiffness(first: int = FIRST, count: int = COUNT) -> Iterator[Share]:
    """Yield the shares of intervals that hold the truth."""
    with ProcessPoolExecutor(core_count()) as pool:
        results = list(pool.map(tried, range(first, first + count), chunksize=4))
    for seed, one in enumerate(results, first):
        print(seed, one, file=sys.stderr)
    shown = [
        (kind, found, *truth) for kind, found, *truth in results if isinstance(found, DahlResonance)
    ]
    yield Share("sweep, stiffness reported", 100.0 * len(shown) / count, 0.0, 100.0, count)
    for name in ("stiffness", "damping"):
        for kind in ("", *KINDS):
            rows = [
                (found, truth if name == "stiffness" else damping)
                for of, found, truth, damping in shown
                if kind in (of, "")
            ]
            widths = [getattr(found, f"{name}_half_width") / truth for found, truth in rows]
            inside = [
                abs(getattr(found, name) - truth) <= getattr(found, f"{name}_half_width")
                for found, truth in rows
            ]
            errors = [abs(getattr(found, name) / truth - 1.0) for found, truth in rows]
            note = f"median half-width {100.0 * np.median(widths):.1f} %, median error {100.0 * np.median(errors):.1f} %"
            bounds = (0.0, 100.0) if kind else (92.0, 98.0)
            yield Share(
                f"{name} in its interval" + (f", {kind}" if kind else ""),
                100.0 * float(np.mean(inside)),
                *bounds,
                len(rows),
                note,
            )


if __name__ == "__main__":
    for share in frequency_stiffness(*map(int, sys.argv[1:])):
        print(share.row())
