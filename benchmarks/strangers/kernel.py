"""The loop as it runs: controller ticks, and fine steps of torque loop and axis between them.

Compiled code is kept in __pycache__, and numba looks only at the file of the function it calls: after a change of
`contact`, `steps` or `encoder` remove that folder.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from benchmarks.strangers.contact import STATIC, Contact
from benchmarks.strangers.encoder import Scale, counted
from benchmarks.strangers.steps import Body, bristle_step, play_step, static_step
from benchmarks.strangers.truth import Floats, Loop, Motor

__all__ = ["COLUMNS", "Controller", "Drive", "Inputs", "controller_of", "drive_of", "run"]

# What `run` returns, a row per instant of the trace. Forces are means since the row before; `motor` is what a current
# sensor could see, `force` what reaches the axis, with the ripple of the torque.
COLUMNS = (
    "q",
    "v",
    "command",
    "motor",
    "force",
    "friction",
    "position_force",
    "measured_velocity",
    "load",
)


class Controller(NamedTuple):
    """`benchmarks.strangers.truth.Loop` for compiled code; `keep` is the share that the velocity filter keeps."""

    pid: bool
    period: float
    delay: int
    kp: float
    kv: float
    ki: float
    keep: float
    feed_velocity: float
    feed_mass: float


class Drive(NamedTuple):
    """`benchmarks.strangers.truth.Motor` for compiled code."""

    lag: float
    ripple: float
    ripple_wave: float
    ripple_phase: float
    limit: float


class Inputs(NamedTuple):
    """What comes from outside: per tick reference, its derivatives, noise and heat; per reversal the scatter."""

    r: Floats
    r_v: Floats
    r_a: Floats
    noise: Floats
    heat: Floats
    scatter: Floats
    first_integral: float


def controller_of(loop: Loop) -> Controller:
    keep = float(np.exp(-loop.period / loop.velocity_filter)) if loop.velocity_filter > 0.0 else 0.0
    return Controller(
        loop.kind == "pid",
        loop.period,
        loop.delay,
        loop.kp,
        loop.kv,
        loop.ki,
        keep,
        loop.feed_velocity,
        loop.feed_mass,
    )


def drive_of(motor: Motor, turn: float) -> Drive:
    wave = 2.0 * np.pi * motor.ripple_per_turn / turn
    return Drive(motor.lag, motor.ripple, wave, motor.ripple_phase, motor.limit)


@njit(cache=True)
def _control(
    k: Controller, y: float, r: float, r_v: float, r_a: float, s: Floats, limit: float
) -> float:
    """Return the command. `s` is position last tick, filtered velocity, integral."""
    s[1] = k.keep * s[1] + (1.0 - k.keep) * (y - s[0]) / k.period
    s[0] = y
    if k.pid:
        e = r - y
        rest = k.kp * e + k.kv * (k.feed_velocity * r_v - s[1])
    else:
        e = k.kp * (r - y) + k.feed_velocity * r_v - s[1]
        rest = k.kv * e
    rest += k.feed_mass * r_a
    grown = s[2] + k.ki * k.period * e
    u = rest + grown
    if u > limit:
        if e < 0.0:
            s[2] = grown
        return limit
    if u < -limit:
        if e > 0.0:
            s[2] = grown
        return -limit
    s[2] = grown
    return u


@njit(cache=True)
def _turned(q: float, m: Floats, travel: float, last: int) -> None:
    """Count reversals: `m` is direction, farthest position in it, and which scatter now holds."""
    if m[0] * (q - m[1]) > 0.0:
        m[1] = q
    elif m[0] * (m[1] - q) > travel:
        m[0], m[1] = -m[0], q
        m[2] = min(m[2] + 1.0, last)


@njit(cache=True)
def run(
    c: Contact, b: Body, d: Drive, k: Controller, enc: Scale, x: Inputs, per_tick: int, fine: int
) -> Floats:
    """Return the rows named in `COLUMNS`, `per_tick` of them a tick, with `fine` steps between rows."""
    h = k.period / (per_tick * fine)
    fade = np.exp(-h / d.lag) if d.lag > 0.0 else 0.0
    share = (1.0 - fade) * d.lag / h if d.lag > 0.0 else 0.0
    q, v, guess = np.zeros(2), np.zeros(4), 0.0
    cells = max(2, c.cell_stiffness.size)
    z, after, w = np.zeros(cells), np.zeros(cells), 0.0
    if c.cell_stiffness.size > 0:
        z, after = z[: c.cell_stiffness.size], after[: c.cell_stiffness.size]
    state, queue = np.zeros(3), np.full(k.delay + 1, b.gravity)
    state[0], state[2] = counted(0.0, enc), x.first_integral
    turns, sums = np.array([1.0, 0.0, 0.0]), np.zeros(4)
    m = b.gravity
    q[1] = q[0] + (b.half_play if b.half_play > 0.0 else 0.0)
    if b.gravity > 0.0:
        q[1] = q[0] - b.half_play
    out = np.empty((x.r.size * per_tick, 9))
    for i in range(x.r.size):
        u = _control(k, counted(q[0], enc), x.r[i], x.r_v[i], x.r_a[i], state, d.limit)
        queue[i % (k.delay + 1)] = u
        goal = queue[(i + 1) % (k.delay + 1)] + x.noise[i]
        wet = x.heat[i]
        for j in range(per_tick):
            row = out[i * per_tick + j]
            row[0], row[1], row[2], row[7], row[8] = (
                q[0],
                v[0],
                u,
                state[1],
                q[1] if b.load_share > 0.0 else q[0],
            )
            row[3:7] = sums / fine
            sums[:] = 0.0
            for _ in range(fine):
                mid = q[0] + 0.5 * h * v[0]
                mean = goal + (m - goal) * share
                m = goal + (m - goal) * fade
                force = mean * (1.0 + d.ripple * np.sin(d.ripple_wave * mid + d.ripple_phase))
                place = b.cogging * np.sin(b.cogging_wave * mid + b.cogging_phase)
                dry = wet * (1.0 + x.scatter[int(turns[2])])
                if c.ripple != 0.0:
                    dry *= 1.0 + c.ripple * np.sin(c.ripple_wave * mid + c.ripple_phase)
                if b.load_share > 0.0:
                    f0, f1 = play_step(c, b, force - place, q, v, z, after, dry, wet, h)
                    z[:], f = after, f0 + f1
                elif c.law == STATIC:
                    v[0], f, travel = static_step(
                        c, b.mass, force - place - b.gravity, v[0], dry, wet, h
                    )
                    q[0] += travel
                else:
                    old, pull = v[0], force - place - b.gravity
                    v[0], f, w = bristle_step(
                        c, b.mass, pull, old, old + guess, z, after, w, dry, wet, h
                    )
                    guess, z[:] = v[0] - old, after
                    q[0] += 0.5 * h * (v[0] + old)
                _turned(q[0], turns, c.reversal_travel, x.scatter.size - 1)
                sums[0] += mean
                sums[1] += force
                sums[2] += f
                sums[3] += place + b.gravity
    return out
