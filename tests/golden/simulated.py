"""Simulated logs and curves of the golden cases.

They are not in a test module, because the inputs of a test may change with the test. The inputs of frozen results may not.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from benchmarks.loops import recorded_in_loop
from tests.identification.known_logs import Motion, log_of, sines, sliding_effort
from tests.prediction.excitation.axes import STAGE

from bristle import friction, hysteresis, plants, response
from bristle.core import Axis
from bristle.engine import force_along, run_open_loop
from bristle.logs.curves import Curve, Curves
from bristle.logs.log import Channel, Log
from bristle.models.friction import find
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.motion import ExcitationMotion

STRIBECK = friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0)
LUGRE = friction.lugre(F_C=35.0, F_S=44.0, v_S=5e-3, sigma_0=1e6, sigma_1=2e3, sigma_2=200.0)

# --- loops ----------------------------------------------------------------------------------------------------------


@cache
def in_loop(*, pairs: int = 5, scatter: float = 0.0) -> Log:
    """Return a closed loop whose drive lags, with pulses beside its controller."""
    return recorded_in_loop(STRIBECK, 3, pairs=pairs, scatter=scatter, lag=0.8e-3, pulses=6.0)


RATE, SIZE, FINE = 750.0, 1500, 40
OPEN = Axis(
    plant="oscillator",
    offset=0.0,
    hold="band_limited",
    at_rest=True,
    method="output_error",
    cutoff=150.0,
    decimation=1,
)


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


# Level by level: 20 N, of which each element takes its share where it slips: 2, 6, 15 um.
ELEMENTS = {"F_C": 20.0, "nu_i": [0.3, 0.4, 0.3], "k_i": [3e6, 8e6 / 6.0, 0.4e6]}
# Amplitudes and frequencies in and out of pre-sliding.
SLOW = ((30e-6, 14e-6, 6e-6), (0.31, 0.83, 1.97))


def elements_log(
    name="maxwell_slip",
    *,
    noise=0.05,
    seed=0,
    duration=12.0,
    dt=1e-3,
    fine=10,
    strokes=SLOW[0],
    load=None,
    temperature=None,
    **more,
) -> Log:
    """Return slow motion in and out of pre-sliding on three elements, with the truth run some times as fine as the log."""
    motion = sines(duration, dt / fine, strokes, SLOW[1])
    truth = find(name)(**(ELEMENTS | {"sigma_2": 300.0, "offset": 1.5} | more))
    around = {"load": load, "temperature": temperature}
    values = {key: np.repeat(item, fine) for key, item in around.items() if item is not None}
    force = force_along(truth, motion.velocity, dt / fine, motion.position, **values)
    coarse = Motion(*(item[::fine] for item in motion))
    scatter = np.random.default_rng(seed).normal(0.0, noise, coarse.time.size)
    log = log_of(coarse, 12.0 * coarse.acceleration + force[::fine] + scatter)
    units = {"load": "1", "temperature": "K"}
    return replace(
        log,
        **{key: Channel(item, units[key], key) for key, item in around.items() if item is not None},
    )


# Of elements, and where each breaks away.
SHARES, REACH = (np.array([0.3, 0.4, 0.3]), np.array([2e-6, 6e-6, 15e-6]))
SHAPE = {"v_S": 1e-3, "C": 2e3, "k_i": 28.0 * SHARES / REACH, "nu_i": SHARES}
SLIDING = {"F_C": 20.0, "F_S": 28.0, "sigma_2": 300.0, "offset": 1.5}


def gms_log(name="gms", *, seed=0, scatter=0.0, **truth) -> Log:
    """Return loops before sliding, then slow slides, with the truth run ten times as fine as the log.

    The level of friction is drawn anew at each reversal.
    """
    dt = 1e-4
    loops = sines(8.0, dt, *SLOW)
    slides = sines(8.0, dt, (6e-3, 6e-4, 2e-4), (0.25, 1.7, 3.1))
    x = np.concatenate([loops.position, slides.position + loops.position[-1] - slides.position[0]])
    v, a = (
        np.concatenate([getattr(item, name) for item in (loops, slides)])
        for name in ("velocity", "acceleration")
    )
    force = force_along(find(name)(**(SHAPE | (truth or SLIDING))), v, dt, x)
    sides = np.sign(v)
    leg = np.cumsum(np.diff(sides, prepend=sides[0]) != 0.0)
    levels = 1.0 + scatter * np.random.default_rng(seed + 10).standard_normal(leg[-1] + 1)
    force = (force - SLIDING["offset"]) * levels[leg] + SLIDING["offset"]
    coarse = Motion(*(item[::10] for item in (dt * np.arange(x.size), x, v, a)))
    noise = np.random.default_rng(seed).normal(0.0, 0.05, coarse.time.size)
    return log_of(coarse, 12.0 * coarse.acceleration + force[::10] + noise, step=1e-8)


PULLED = replace(STAGE, resolution=2e-8, sample_time=5e-4, jerk_limit=None)
LIMITS, DISTANCES = np.array([18.0, 24.0, 18.0]), np.array([2e-6, 4e-6, 7e-6])
SLIPPING = find("maxwell_slip")(F_C=60.0, nu_i=LIMITS / 60.0, k_i=LIMITS / DISTANCES, offset=5.0)


@cache
def pulling() -> ExcitationMotion:
    """Return the motion of pulls from rest at three rates."""
    return excite(
        PULLED, duration="24 s", purposes="break-away", model=SLIPPING, rehearsed=False
    ).motion


def pulled(motion, seed=0, scatter=0.05) -> Log:
    """Return the log of a motion on elements whose level is drawn anew for each leg."""
    v, dt, rng = motion.velocity, motion.sample_time, np.random.default_rng(seed)
    sides = np.sign(v)
    moving = np.flatnonzero(sides)
    turns = moving[1:][sides[moving[1:]] != sides[moving[:-1]]]
    leg = np.searchsorted(turns, np.arange(v.size), side="right")
    levels = 1.0 + scatter * rng.standard_normal(turns.size + 1)
    force = (force_along(SLIPPING, v, dt, motion.position + 0.5 * dt * v) - 5.0) * levels[leg] + 5.0
    effort = 28.0 * motion.acceleration + force + 0.3 * rng.standard_normal(v.size)
    return log_of(motion, effort, step=PULLED.resolution)


# --- hysteresis -----------------------------------------------------------------------------------------------------

# In units of the saturation and of f_p/s.
MASING = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)
NOISE = 0.005


def to_and_fro(rng, turns=80, amplitude=3.0, samples=1601):
    """Return a path through random turning points, once through its whole range first."""
    at = np.concatenate(
        [[0.0, amplitude, -amplitude], rng.uniform(-amplitude, amplitude, turns - 2)]
    )
    return np.interp(np.linspace(0.0, turns, samples), np.arange(turns + 1), at)


def recorded(operator, u, rng=None, offset=0.0):
    """Return the output of an operator along a path, with noise, as one curve from the virgin state."""
    noise = 0.0 if rng is None else NOISE * rng.standard_normal(u.size)
    return Curves((Curve(u, response(operator, u) + offset + noise),))


def reversal_curves(operator, count=41, extent=3.0, samples=60, rising=True):
    """Return first-order reversal curves of an operator, each from saturation."""
    side = 1.0 if rising else -1.0
    paths = [
        side * np.linspace(turn, extent, samples)
        for turn in np.linspace(-extent, 0.9 * extent, count).tolist()
    ]
    return tuple(Curve(u, response(operator, u, history=[side * extent])) for u in paths)
