"""One fine step of the moved body: rigid with a jump of friction, rigid with bristles, or two masses with play.

Each keeps the momentum of the step exactly: mass times change of velocity is the step times the mean of the forces that
it reports. Bristles and the contact are stepped at the mean velocity of the step, found by iteration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from benchmarks.strangers.contact import Contact, memory, push, viscous
from benchmarks.strangers.truth import Axis, Floats

__all__ = ["Body", "body_of", "bristle_step", "play_step", "static_step"]


class Body(NamedTuple):
    """The masses for compiled code."""

    mass: float
    gravity: float
    cogging: float
    cogging_wave: float
    cogging_phase: float
    half_play: float
    load_share: float
    stiffness: float
    damping: float


def body_of(a: Axis) -> Body:
    wave = 2.0 * np.pi * a.cogging_per_turn / a.turn
    return Body(
        a.mass,
        a.gravity,
        a.cogging,
        wave,
        a.cogging_phase,
        a.half_play,
        a.load_share,
        a.contact_stiffness,
        a.contact_damping,
    )


@njit(cache=True)
def _from_rest(c: Contact, mass: float, pull: float, dry: float, h: float) -> tuple[float, float]:
    """Return the velocity after h from rest, and the mean friction force."""
    if pull > dry * c.F_S_p:
        return h * (pull - dry * c.F_S_p) / mass, dry * c.F_S_p
    if pull < -dry * c.F_S_n:
        return h * (pull + dry * c.F_S_n) / mass, -dry * c.F_S_n
    return 0.0, pull


@njit(cache=True)
def static_step(
    c: Contact, mass: float, pull: float, v: float, dry: float, wet: float, h: float
) -> tuple[float, float, float]:
    """Return velocity after a step, mean friction force and travel, where friction jumps at zero; linear viscous part.

    A step in which the velocity passes through zero is split there.
    """
    if v == 0.0:
        after, force = _from_rest(c, mass, pull, dry, h)
        return after, force, 0.5 * h * after
    level = dry * (c.F_C_p if v > 0.0 else -c.F_C_n)
    drag = wet * (c.F_v_p if v > 0.0 else c.F_v_n)
    rate = 0.5 * h * drag / mass
    after = (v * (1.0 - rate) + h * (pull - level) / mass) / (1.0 + rate)
    if after * v > 0.0:
        mean = 0.5 * (v + after)
        return after, level + wet * viscous(c, mean), h * mean
    first = h * v / (v - after)
    rest, _ = _from_rest(c, mass, pull, dry, h - first)
    # What the momentum of the whole step leaves for friction.
    force = pull - mass * (rest - v) / h
    return rest, force, 0.5 * first * v + 0.5 * (h - first) * rest


@njit(cache=True)
def bristle_step(
    c: Contact,
    mass: float,
    pull: float,
    v: float,
    guess: float,
    z: Floats,
    after: Floats,
    w: float,
    dry: float,
    wet: float,
    h: float,
) -> tuple[float, float, float]:
    """Return velocity after a step, mean friction force and lagged speed. `guess` is a first velocity after it."""
    tiny = 1e-13 * (abs(v) + abs(guess)) + 1e-300
    x0, r0 = v, 0.0
    x1 = guess
    force, lagged = 0.0, w
    for turn in range(25):
        mean = 0.5 * (v + x1)
        seen, lagged = memory(c, mean, w, h)
        force = push(c, z, after, mean, seen, lagged if c.lag > 0.0 else abs(x1), dry, wet, h)
        r1 = v + h * (pull - force) / mass - x1
        if abs(r1) <= tiny:
            break
        # A secant step: the force over the velocity is nearly straight over so short a time.
        slope = -1.0
        if turn > 0 and x1 != x0:
            slope = min((r1 - r0) / (x1 - x0), -0.2)
        x0, r0 = x1, r1
        x1 -= r1 / slope
    return v + h * (pull - force) / mass, force, lagged


@njit(cache=True)
def play_step(
    c: Contact,
    b: Body,
    pull: float,
    q: Floats,
    v: Floats,
    z: Floats,
    after: Floats,
    dry: float,
    wet: float,
    h: float,
) -> tuple[float, float]:
    """Step motor and load, and return both friction forces. Positions q and bristles are those of motor, load.

    v holds both velocities and their last changes, which the next step starts from; q and v are changed in place.
    """
    motor, load = (1.0 - b.load_share) * b.mass, b.load_share * b.mass
    a, e = v[0] + v[2], v[1] + v[3]
    f0, f1 = 0.0, 0.0
    for _ in range(25):
        m0, m1 = 0.5 * (v[0] + a), 0.5 * (v[1] + e)
        gap = q[0] - q[1] + 0.5 * h * (m0 - m1)
        deep = abs(gap) - b.half_play
        touch = 0.0
        if deep > 0.0:
            # Damping sets in with depth: a force that jumped at the touch would cost accuracy, and no contact has it.
            damping = b.damping * min(1.0, deep / (0.1 * b.half_play))
            touch = max(0.0, b.stiffness * deep + np.sign(gap) * damping * (m0 - m1)) * np.sign(gap)
        f0 = (1.0 - b.load_share) * push(c, z[:1], after[:1], m0, abs(m0), abs(a), dry, wet, h)
        f1 = b.load_share * push(c, z[1:], after[1:], m1, abs(m1), abs(e), dry, wet, h)
        a1 = v[0] + h * (pull - touch - f0) / motor
        e1 = v[1] + h * (touch - b.gravity - f1) / load
        done = abs(a1 - a) + abs(e1 - e) <= 1e-9 * (abs(a1) + abs(e1))
        a, e = a1, e1
        if done:
            break
    q[0] += 0.5 * h * (v[0] + a)
    q[1] += 0.5 * h * (v[1] + e)
    v[2], v[3] = a - v[0], e - v[1]
    v[0], v[1] = a, e
    return f0, f1
