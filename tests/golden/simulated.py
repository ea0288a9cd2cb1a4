"""Simulated logs and curves of the golden cases.

They are not in a test module, because the inputs of a test may change with the test. The inputs of frozen results may not.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from benchmarks.loops import recorded_in_loop
from tests.excitation.axes import STAGE
from tests.identification.known_logs import Motion, log_of, sines, sliding_effort

from bristle import friction, hysteresis, plants, response
from bristle.core import Axis, Model
from bristle.engine import force_along, run_open_loop
from bristle.excitation import excite
from bristle.friction import find
from bristle.logs.curves import Curve, Curves
from bristle.logs.log import Channel, Log

STRIBECK = friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0)
LUGRE = friction.lugre(F_C=35.0, F_S=44.0, v_S=5e-3, sigma_0=1e6, sigma_1=2e3, sigma_2=200.0)

# --- loops ----------------------------------------------------------------------------------------------------------


@cache
def in_loop(*, pairs: int = 5, scatter: float = 0.0) -> Log:
    """Return a closed loop whose drive lags, with pulses beside its controller."""
    return recorded_in_loop(STRIBECK, 3, pairs=pairs, scatter=scatter, lag=0.8e-3, pulses=6.0)


RATE, SIZE, FINE = 750.0, 1500, 40
OPEN = Axis(plant="oscillator", offset=0.0, hold="band_limited", at_rest=True, method="output_error", cutoff=150.0, decimation=1)


@cache
def ringing() -> Log:
    """Return the steady motion of an oscillator with a hysteretic spring, two periods of a smooth force."""
    lines, rng = np.arange(10, 300), np.random.default_rng(0)
    time = np.arange(SIZE * FINE) / (RATE * FINE)
    phases = rng.uniform(0.0, 2.0 * np.pi, lines.size)
    item = 4.0 * np.cos(np.pi * np.outer(time, lines) + phases).sum(axis=1)
    plant = plants.oscillator(M=2.0, c=40.0, k=5e4)
    spring = friction.bouc_wen_classic(alpha=4e4, beta=1e3, gamma=0.9, delta=0.3)
    trace = run_open_loop(plant, spring, np.tile(item, 6), 1.0 / (RATE * FINE), hold="linear")
    position = np.tile(trace.position[-item.size :: FINE], 2)
    position = position + np.random.default_rng(2).normal(0.0, 5e-6, position.size)
    return Log(
        time=Channel(np.arange(position.size) / RATE, "s", "t"),
        position=Channel(position, "m", "y"),
        effort=Channel(np.tile(item[::FINE], 2), "N", "u"),
        sample_time=1.0 / RATE,
        segments=(slice(0, position.size),),
    )


# --- motion that is known -------------------------------------------------------------------------------------------


@cache
def late() -> Log:
    """Return a log whose effort was recorded three samples later than it acted."""
    phases = (0.3, 1.1, 2.5)
    motion, fine = sines(phases=phases), sines(dt=1e-5, phases=phases)
    effort = np.interp(motion.time - 3e-3, fine.time, sliding_effort(fine, noise=0.0))
    return log_of(motion, effort + np.random.default_rng(5).normal(0.0, 0.1, effort.size))


SLOW = ((30e-6, 14e-6, 6e-6), (0.31, 0.83, 1.97))  # amplitudes and frequencies in and out of pre-sliding


def elements(load: np.ndarray | None = None) -> Log:
    """Return slow motion on three elements that slip, under a load that may change."""
    fine, dt = 10, 1e-3
    motion = sines(12.0, dt / fine, *SLOW)
    truth = find("maxwell_slip")(F_C=20.0, nu_i=[0.3, 0.4, 0.3], k_i=[3e6, 8e6 / 6.0, 0.4e6], sigma_2=300.0, offset=1.5)
    values = {} if load is None else {"load": np.repeat(load, fine)}
    force = force_along(truth, motion.velocity, dt / fine, motion.position, **values)
    coarse = Motion(*(item[::fine] for item in motion))
    scatter = np.random.default_rng(0).normal(0.0, 0.05, coarse.time.size)
    log = log_of(coarse, 12.0 * coarse.acceleration + force[::fine] + scatter)
    return log if load is None else replace(log, load=Channel(load, "1", "load"))


def elements_with_stribeck() -> Log:
    """Return loops before sliding, then slow slides, on elements whose level scatters from reversal to reversal."""
    dt, share = 1e-4, np.array([0.3, 0.4, 0.3])
    loops = sines(8.0, dt, *SLOW)
    slides = sines(8.0, dt, (6e-3, 6e-4, 2e-4), (0.25, 1.7, 3.1))
    x = np.concatenate([loops.position, slides.position + loops.position[-1] - slides.position[0]])
    v, a = (np.concatenate([getattr(item, name) for item in (loops, slides)]) for name in ("velocity", "acceleration"))
    truth = find("gms")(
        F_C=20.0, F_S=28.0, v_S=1e-3, C=2e3, sigma_2=300.0, offset=1.5, nu_i=share, k_i=28.0 * share / np.array([2e-6, 6e-6, 15e-6])
    )
    sides = np.sign(v)
    leg = np.cumsum(np.diff(sides, prepend=sides[0]) != 0.0)
    levels = 1.0 + 0.03 * np.random.default_rng(10).standard_normal(leg[-1] + 1)
    force = (force_along(truth, v, dt, x) - 1.5) * levels[leg] + 1.5
    coarse = Motion(*(item[::10] for item in (dt * np.arange(x.size), x, v, a)))
    noise = np.random.default_rng(0).normal(0.0, 0.05, coarse.time.size)
    return log_of(coarse, 12.0 * coarse.acceleration + force[::10] + noise, step=1e-8)


PULLED = replace(STAGE, resolution=2e-8, sample_time=5e-4, jerk_limit=None)


@cache
def pulls() -> tuple[Log, Any]:
    """Return pulls from rest at three rates, on elements whose level scatters from leg to leg, and the elements."""
    limits, reach = np.array([18.0, 24.0, 18.0]), np.array([2e-6, 4e-6, 7e-6])
    truth = find("maxwell_slip")(F_C=60.0, nu_i=limits / 60.0, k_i=limits / reach, offset=5.0)
    motion = excite(PULLED, duration="24 s", purposes="break-away", model=truth, rehearsed=False).motion
    v, dt, rng = motion.velocity, motion.sample_time, np.random.default_rng(0)
    sides = np.sign(v)
    moving = np.flatnonzero(sides)
    turns = moving[1:][sides[moving[1:]] != sides[moving[:-1]]]
    leg = np.searchsorted(turns, np.arange(v.size), side="right")
    levels = 1.0 + 0.05 * rng.standard_normal(turns.size + 1)
    force = (force_along(truth, v, dt, motion.position + 0.5 * dt * v) - 5.0) * levels[leg] + 5.0
    effort = 28.0 * motion.acceleration + force + 0.3 * rng.standard_normal(v.size)
    return log_of(motion, effort, step=PULLED.resolution), truth


# --- hysteresis -----------------------------------------------------------------------------------------------------

MASING = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)


def wandering(rng: np.random.Generator, turns: int, samples: int) -> np.ndarray:
    """Return a path through random turning points, once through its whole range first."""
    at = np.concatenate([[0.0, 3.0, -3.0], rng.uniform(-3.0, 3.0, turns - 2)])
    return np.interp(np.linspace(0.0, turns, samples), np.arange(turns + 1), at)


def curve_along(u: np.ndarray, rng: np.random.Generator | None = None, offset: float = 0.0) -> Curves:
    """Return the output along a path from the virgin state, with noise where there is a generator."""
    noise = 0.0 if rng is None else 0.005 * rng.standard_normal(u.size)
    return Curves((Curve(u, response(MASING, u) + offset + noise),))


def reversal_curves(count: int, operator: Model = MASING) -> tuple[Curve, ...]:
    """Return first-order reversal curves, each from saturation."""
    paths = [np.linspace(turn, 3.0, 60) for turn in np.linspace(-3.0, 2.7, count).tolist()]
    return tuple(Curve(u, response(operator, u, history=[3.0])) for u in paths)
