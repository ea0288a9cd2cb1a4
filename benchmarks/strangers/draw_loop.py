"""Draws motor, encoder, controller and trace for an axis and a motion, tuned as at commissioning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.strangers.motion import reference
from benchmarks.strangers.truth import (
    Axis,
    Encoder,
    Friction,
    Loop,
    Motion,
    Motor,
    Recording,
    Truth,
)

__all__ = ["drive"]


def drive(
    rng: np.random.Generator,
    seed: int,
    family: str,
    axis: Axis,
    friction: Friction,
    motion: Motion,
    speed: float,
) -> Truth:
    """Return the truth of an axis in its drive."""
    level = max(friction.F_C)
    rates, often = [500.0, 1000.0, 2000.0, 4000.0], [0.1, 0.3, 0.35, 0.25]
    if motion.kind == "presliding":
        rates, often = rates[2:], [0.4, 0.6]
    period = 1.0 / float(rng.choice(rates, p=often))
    motor = _motor(rng, axis, friction, motion, speed, level)
    encoder = _encoder(rng, axis, motion)
    loop = _loop(rng, axis, motor, encoder, period, level, motion.kind == "presliding")
    if motion.kind == "presliding" and friction.break_away > 0.0:
        loop, motion = _paced(rng, loop, motion, max(friction.F_S) / friction.break_away)
    elif motion.dwell > 0.0 and loop.feed_velocity == 0.0:
        # Without velocity feedforward the axis trails: whoever runs such a cycle waits until it is in position.
        motion = replace(motion, dwell=max(motion.dwell, 4.0 / loop.kp))
    return Truth(
        seed,
        family,
        axis,
        friction,
        motor,
        loop,
        encoder,
        motion,
        _trace(rng, axis, motor, loop, motion),
    )


def _motor(
    rng: np.random.Generator,
    axis: Axis,
    friction: Friction,
    motion: Motion,
    speed: float,
    level: float,
) -> Motor:
    """A motor whose peak force carries the motion with some reserve; three times what it is rated for."""
    acceleration = float(np.abs(reference(motion, 2e-3)[2]).max())
    drag = max(friction.F_v) * speed + friction.F_root * np.sqrt(speed)
    need = axis.mass * acceleration + 2.0 * level + drag + abs(axis.gravity)
    limit = float(rng.uniform(1.3, 2.5)) * need
    ripple = float(np.exp(rng.uniform(np.log(0.002), np.log(0.02))))
    noise = level * float(np.exp(rng.uniform(np.log(0.002), np.log(0.02))))
    if motion.kind == "presliding":
        # LuGre creeps under forces that shake it faster than it moves: noise can take a fifth off its friction there.
        noise *= 0.1
    return Motor(
        float(rng.uniform(0.2e-3, 1e-3)),
        noise,
        ripple,
        int(rng.choice([6, 12, 24])),
        float(rng.uniform(0.0, 2.0 * np.pi)),
        limit / 3.0,
        limit,
    )


def _encoder(rng: np.random.Generator, axis: Axis, motion: Motion) -> Encoder:
    period = 0.01 if axis.linear else 2.0 * np.pi
    counts = float(np.exp(rng.uniform(np.log(1e3), np.log(1e6))))
    if motion.kind == "presliding":
        # Nobody measures pre-sliding with an encoder that does not see it.
        counts = float(np.clip(counts, min(40.0 * period / motion.amplitudes[0], 1e6), None))
    counts = round(counts)
    several = rng.random() < 0.4
    sizes = rng.uniform(0.0, 0.3, 3) * (
        float(np.exp(rng.uniform(0.0, np.log(10.0)))) if several else 1.0
    )
    sizes *= np.array([1.0, 0.7, 0.4])
    phases = rng.uniform(0.0, 2.0 * np.pi, 3)
    return Encoder(period / counts, period, tuple(sizes.tolist()), tuple(phases.tolist()))


def _loop(
    rng: np.random.Generator,
    axis: Axis,
    motor: Motor,
    encoder: Encoder,
    period: float,
    level: float,
    small: bool,
) -> Loop:
    """A crossover that leaves the delays their phase, and does not shake the motor with single counts.

    Who is after `small` motions has a fast drive, and tunes it as stiff as it goes.
    """
    delay = int(rng.choice([0, 1, 2, 3], p=[0.35, 0.35, 0.2, 0.1]))
    smooth = float(rng.choice([0.0, 0.5e-3, 1e-3, 2e-3]))
    slack = float(rng.uniform(0.3, 0.5))
    if small:
        delay, smooth, slack = min(delay, 1), min(smooth, 0.5e-3), 0.45
    dead = (delay + 1.0) * period + motor.lag + smooth
    cross = min(slack / dead, 2.0 * np.pi * (200.0 if small else 120.0))
    # With play only the mass before it feels the loop for a while: the gain is set for that.
    mass = axis.mass * (1.0 - 0.7 * axis.load_share)
    jump = mass * cross * encoder.resolution / (period + smooth)
    cross *= max(min(1.0, 0.4 * level / jump), 0.3)
    jump = mass * cross * encoder.resolution / (period + smooth)
    if jump > 0.4 * level:
        smooth += mass * cross * encoder.resolution / (0.4 * level)
        cross = min(cross, 0.4 / ((delay + 1.0) * period + motor.lag + smooth))
    feed = bool(rng.random() < 0.5)
    feed_mass = axis.mass * float(rng.uniform(0.8, 1.1)) if feed else 0.0
    if rng.random() < 0.3:
        c = 0.8 * cross
        gains = (mass * c**2 / 3.0, mass * c, mass * c**3 / 25.0)
        return Loop("pid", period, delay, *gains, smooth, 1.0, feed_mass)
    gains = (
        cross / float(rng.uniform(4.0, 7.0)),
        mass * cross,
        mass * cross**2 / float(rng.uniform(5.0, 9.0)),
    )
    return Loop("cascade", period, delay, *gains, smooth, 1.0 if feed else 0.0, feed_mass)


def _paced(
    rng: np.random.Generator, loop: Loop, motion: Motion, stiffness: float
) -> tuple[Loop, Motion]:
    """Return loop and triangles that fit each other in pre-sliding, where the axis is a stiff spring to its loop.

    The loop follows there by its integral alone, at `pace` [rad/s]. A loop too slow gets up to six times the integral,
    and the triangles are run as slowly as it needs.
    """
    path = 1.0 if loop.kind == "pid" else loop.kp
    pace = loop.ki * path / stiffness
    more = float(np.clip(6.0 / pace, 1.0, 6.0))
    loop = replace(loop, ki=more * loop.ki)
    rate = np.clip(
        more * pace / (2.0 * np.pi) * rng.uniform(0.15, 0.4, len(motion.frequencies)), 0.05, 1.5
    )
    dwell = min(1.0, max(motion.dwell, 2.0 / (more * pace)))
    # The largest triangles, as many as the record has time for.
    times = np.cumsum((2.0 / rate + dwell)[::-1])
    count = max(1, int(np.sum(times < motion.duration)))
    sizes = motion.amplitudes[-count:]
    return loop, replace(
        motion, frequencies=tuple(rate[-count:].tolist()), amplitudes=sizes, dwell=dwell
    )


def _trace(
    rng: np.random.Generator, axis: Axis, motor: Motor, loop: Loop, motion: Motion
) -> Recording:
    per_tick = 2 if loop.period >= 0.5e-3 and rng.random() < 0.1 else 1
    trace = loop.period / per_tick
    allowed = [1] if per_tick == 2 else [n for n in (1, 2, 4) if n * trace <= 2.001e-3]
    every = int(rng.choice(allowed))
    source = str(rng.choice(["command", "acted"]))
    late = int(rng.choice([0, 1, 2, 3], p=[0.6, 0.2, 0.1, 0.1]))
    slow = [float(rng.uniform(0.2e-3, 5e-3)) if rng.random() < p else 0.0 for p in (0.35, 0.15)]
    unit, force = ("N" if axis.linear else "N*m"), 1.0
    if rng.random() < 0.3:
        unit, force = "A", motor.rated / float(rng.uniform(0.8, 6.0))
    lost: tuple[tuple[int, int], ...] = ()
    rows = int(motion.duration / (trace * every))
    if rng.random() < 0.1:
        starts = np.sort(rng.integers(rows // 10, rows - rows // 10, int(rng.integers(1, 4))))
        lost = tuple((int(s), int(rng.integers(1, 30))) for s in starts)
    return Recording(
        trace,
        per_tick,
        every,
        source,
        late,
        slow[0],
        slow[1],
        effort_noise=motor.rated * float(np.exp(rng.uniform(np.log(5e-4), np.log(5e-3))))
        if source == "acted"
        else 0.0,
        force_per_effort=force,
        effort_unit=unit,
        reference=bool(rng.random() < 0.7),
        velocity=bool(rng.random() < 0.5),
        jitter=float(rng.uniform(0.02, 0.1)) * trace * every * (rng.random() < 0.15),
        lost=lost,
    )
