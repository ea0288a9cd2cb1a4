"""Logs of a drive with two masses, from a simulator that shares no code with bristle.

A motor of inertia `motor` pulls a load through a spring and a damper, with play in a third of the logs. Friction acts on
both sides: Coulomb with a Stribeck curve, Dahl, LuGre, or Maxwell slip. A cascade of controllers (position P, velocity PI)
acts on the encoder of the motor after a delay, and the current follows with a lag. A rigid axis is a single mass with the
same loop, the same motion and the same friction. A sensor of force can sit between motor and nut. It measures the force of
the coupling, friction of the nut, and the force on the screw, a part of the motor's mass that moves behind the sensor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numba
import numpy as np

COULOMB, DAHL, LUGRE, MAXWELL = range(4)
SUBSTEP = 25e-6  # s
NUT_TURNS = 2e-6  # m, over which the friction of the nut changes its side
MOTIONS = ("multisine", "chirp", "reference", "reversing")


@dataclass(frozen=True)
class Drive:
    """A drive in a loop, with its recorder; SI units of a linear axis."""

    motor: float
    load: float  # 0 for a rigid axis
    antiresonance: float  # Hz
    damping: float  # ratio of the load on its spring
    gap: float  # of the play
    # Of motor and load: kind, level, break-away, Stribeck speed, stiffness, ...
    friction: tuple[tuple[float, ...], tuple[float, ...]]
    sample_time: float
    delay: int  # samples from the encoder to the effort
    lag: float  # of the current
    late: int  # samples by which the recorded effort lags
    step: float  # of the encoder
    noise: float  # of the effort
    motion: str
    with_reference: bool
    seed: int
    nut: float = 0.0  # friction of the motor per force of the coupling
    # Of the coupling: an element of a share of its stiffness, which slips after a distance.
    hysteresis: tuple[float, float] = (0.0, 0.0)
    sensor: float = 0.0  # noise of a sensor of force, 0 without a sensor
    screw: float = 0.0  # part of the motor's mass behind the sensor

    @property
    def total(self) -> float:
        return self.motor + self.load

    @property
    def resonance(self) -> float:
        return self.antiresonance * math.sqrt(1.0 + self.load / self.motor)

    @property
    def stiffness(self) -> float:
        return self.load * (2.0 * math.pi * self.antiresonance) ** 2


def drive_of(seed: int, *, elastic: bool = True) -> Drive:
    """Draw a drive; the same seed without elasticity is the same axis with one mass."""
    draw = np.random.default_rng([2301, seed])
    total, ratio = (
        math.exp(draw.uniform(math.log(2.0), math.log(60.0))),
        math.exp(draw.uniform(math.log(0.2), math.log(5.0))),
    )
    antiresonance, damping = (
        math.exp(draw.uniform(math.log(8.0), math.log(120.0))),
        draw.uniform(0.01, 0.06),
    )
    level, share = total * draw.uniform(0.3, 1.5), draw.uniform(0.1, 0.9)
    kinds = draw.integers(0, 4, 2)
    speeds, zones = (
        draw.uniform(0.003, 0.02, 2),
        np.exp(draw.uniform(math.log(3e-6), math.log(6e-5), 2)),
    )
    peaks, viscous = draw.uniform(1.0, 1.5, 2), draw.uniform(0.2, 2.0, 2)
    play = draw.random() < 1.0 / 3.0
    if play:  # the load rests against a flank by its friction, which also damps it
        level, share, damping = max(level, 0.6 * total), 0.3 * share, damping + 0.02
    levels = level * share, level * (1.0 - share)
    motor_side, load_side = (
        (float(kind), force, force * peak, speed, force / zone, rub * force)
        for kind, force, peak, speed, zone, rub in zip(
            kinds.tolist(),
            levels,
            peaks.tolist(),
            speeds.tolist(),
            zones.tolist(),
            viscous,
            strict=True,
        )
    )
    fast = antiresonance * math.sqrt(1.0 + ratio) > 120.0 or draw.random() < 0.3
    drive = Drive(
        motor=total / (1.0 + ratio),
        load=total * ratio / (1.0 + ratio),
        antiresonance=antiresonance,
        damping=damping,
        gap=draw.uniform(3e-6, 3e-5) if play else 0.0,
        friction=(motor_side, load_side),
        sample_time=0.5e-3 if fast else 1e-3,
        delay=int(draw.integers(1, 4)),
        lag=draw.uniform(0.2e-3, 1e-3),
        late=int(draw.integers(0, 3)),
        step=math.exp(draw.uniform(math.log(5e-8), math.log(2e-6))),
        noise=level * draw.uniform(0.003, 0.03),
        motion=MOTIONS[seed % len(MOTIONS)],
        with_reference=bool(draw.random() < 0.5),
        seed=seed,
    )
    if elastic:
        return drive
    summed = tuple(
        sum(parts) if place in (1, 2, 4, 5) else parts[0]
        for place, parts in enumerate(zip(motor_side, load_side, strict=True))
    )
    return replace(drive, motor=total, load=0.0, gap=0.0, friction=(summed, summed))


@cache
def log_of(drive: Drive) -> dict[str, np.ndarray]:
    """Return the recorded columns of a drive: time, position, effort, and the reference if recorded; and the position of the load."""
    draw = np.random.default_rng([77, drive.seed])
    return recorded(drive, *_motion(drive, draw), draw)


def recorded(
    drive: Drive, wanted: np.ndarray, injected: np.ndarray, draw: np.random.Generator
) -> dict[str, np.ndarray]:
    """Return the recorded columns of a drive that follows a reference, with an effort injected into its loop."""
    dt = drive.sample_time
    slowness = (drive.delay + 1.0) * dt + drive.lag
    pace = min(2.0 * math.pi * 25.0, 0.25 / slowness)
    gains = (
        pace / 5.0,
        drive.motor * pace * (1.0 if drive.load else 0.4),
        drive.motor * pace * pace / 6.0,
    )
    spring = 2.0 * drive.damping * drive.load * 2.0 * math.pi * drive.antiresonance
    frictions, loop = (
        [np.array(side) for side in drive.friction],
        (drive.delay, drive.lag, drive.step),
    )
    masses = np.array(
        [
            drive.motor,
            drive.load,
            drive.stiffness,
            spring,
            drive.gap,
            drive.nut,
            *drive.hysteresis,
            drive.screw,
        ]
    )
    motor, load, effort, force = _run(
        wanted, injected, dt, masses, frictions[0], frictions[1], np.array(gains), loop
    )
    if not np.ptp(motor) < 3.0 * np.ptp(wanted):
        raise ArithmeticError(f"the loop of drive {drive.seed} is unstable")
    late = np.concatenate([effort[:1].repeat(drive.late), effort[: effort.size - drive.late]])
    log = {
        "time": dt * np.arange(wanted.size),
        "position": np.round(motor / drive.step) * drive.step,
        "effort": late + draw.normal(0.0, drive.noise, late.size),
        "load_position": np.round(load / drive.step) * drive.step,
    }
    if drive.sensor:
        log["coupling_effort"] = force + np.random.default_rng([78, drive.seed]).normal(
            0.0, drive.sensor, force.size
        )
    return log | ({"reference": wanted} if drive.with_reference else {})


def columns_of(drive: Drive) -> dict[str, np.ndarray]:
    """Return the columns of a log with one encoder."""
    return of_the_motor(log_of(drive))


def of_the_motor(log: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of a log without the encoder of the load."""
    return {name: column for name, column in log.items() if name != "load_position"}


def _motion(drive: Drive, draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the reference, and the effort injected into the loop."""
    dt = drive.sample_time
    fastest, acceleration = draw.uniform(0.05, 0.3), draw.uniform(0.8, 4.0)
    speeds = fastest * np.geomspace(0.05, 1.0, int(draw.integers(4, 7)))
    parts = [
        _stroke(speed, min(max(1.2 * speed, 0.01), 0.3), acceleration, dt)
        for speed in speeds.tolist()
        for _ in range(2)
    ]
    sweeps = np.concatenate(
        [
            np.zeros(round(0.3 / dt)),
            *parts,
            *([_before_sliding(drive, dt)] if draw.random() < 0.4 else []),
        ]
    )
    seconds, highest = draw.uniform(15.0, 25.0), min(0.38 / dt, 400.0)
    count = round(seconds / dt)
    time = dt * np.arange(count)
    strength = drive.total * draw.uniform(0.05, 0.25) * (0.6 if drive.gap else 1.0)
    rise = np.clip(np.minimum(time, time[::-1]) / 0.5, 0.0, 1.0)
    if drive.motion == "multisine":
        lines = np.arange(2.0, highest, 0.5)
        phases = draw.uniform(0.0, 2.0 * np.pi, lines.size)
        once = np.arange(round(2.0 / dt)) * dt
        shape = np.sum(np.cos(2.0 * np.pi * lines[:, None] * once + phases[:, None]), axis=0)
        wave = np.tile(shape / np.std(shape), count // shape.size + 1)[:count]
    else:
        wave = math.sqrt(2.0) * np.sin(
            2.0
            * np.pi
            * 3.0
            * seconds
            / math.log(highest / 3.0)
            * ((highest / 3.0) ** (time / seconds) - 1.0)
        )
    slide, extra, injected = 0.3 * fastest, np.zeros(count), np.zeros(count)
    if drive.motion == "reference":
        # A chirp of constant acceleration in the reference, on a slow triangle.
        frequency = 3.0 * (highest / 3.0) ** (time / seconds)
        extra = (
            rise
            * wave
            * min(0.5 * strength / drive.total / (2.0 * np.pi * 3.0) ** 1.0, 0.3 * slide)
            / (2.0 * np.pi * frequency)
        )
    elif drive.motion == "reversing":
        # Reversals by a large slow sine, so that friction often turns while the chirp runs.
        injected = rise * wave * strength
    else:
        injected = rise * wave * strength
    if drive.motion == "reversing":
        extra = rise * slide / (2.0 * np.pi * 0.4) * np.sin(2.0 * np.pi * 0.4 * time)
        carried = np.zeros(count)
    else:
        period = 6.0
        phase = (time / period + 0.25) % 1.0
        triangle = (np.abs(4.0 * phase - 2.0) - 1.0) * slide * period / 4.0
        width = round(0.05 / dt)
        carried = np.convolve(
            np.pad(triangle, width, mode="edge"), np.full(width, 1.0 / width), "same"
        )[width:-width]
        carried -= carried[0]
    reference = np.concatenate(
        [sweeps, carried + extra, np.full(round(0.3 / dt), (carried + extra)[-1])]
    )
    return reference, np.concatenate([np.zeros(sweeps.size), injected, np.zeros(round(0.3 / dt))])


def _stroke(speed: float, length: float, acceleration: float, dt: float) -> np.ndarray:
    """Return a move forth and back with limited acceleration, smoothed over 20 ms, and rests."""
    speed = min(speed, math.sqrt(acceleration * length))
    rise, sail = speed / acceleration, length / speed - speed / acceleration
    pace = np.concatenate(
        [
            np.linspace(0.0, speed, max(round(rise / dt), 2)),
            np.full(max(round(sail / dt), 1), speed),
        ]
    )
    pace = np.concatenate(
        [pace, np.linspace(speed, 0.0, max(round(rise / dt), 2)), np.zeros(round(0.1 / dt))]
    )
    width = round(0.02 / dt)
    pace = np.convolve(np.pad(pace, width), np.full(width, 1.0 / width), "same")
    forth = np.cumsum(pace) * dt
    return np.concatenate([forth, forth[-1] - forth])


def _before_sliding(drive: Drive, dt: float) -> np.ndarray:
    """Return slow triangles and a chirp within the pre-sliding zone, as plans of friction tests contain."""
    _, level, _, _, stiffness, _ = drive.friction[0]
    zone = max(level / stiffness, 5.0 * drive.step)
    triangles = [
        size
        * zone
        * (2.0 * np.abs(2.0 * ((np.arange(round(1.0 / dt)) * dt + 0.25) % 1.0) - 1.0) - 1.0)
        for size in (0.3, 0.6, 0.9, 3.0)
    ]
    middle = math.sqrt(stiffness / drive.total) / (2.0 * math.pi)
    low, high = 0.125 * middle, min(2.5 * middle, 0.2 / dt)
    time = np.arange(round(5.0 / dt)) * dt
    sweep = (
        0.2 * zone * np.sin(2.0 * np.pi * (low * time + 0.5 * (high - low) * time**2 / time[-1]))
    )
    return np.concatenate([*triangles, sweep])


@numba.njit(cache=True)
def _friction(kind, p, state, v, push, mass, h):
    """Return the force of friction over a substep; Coulomb friction stops a mass if it can."""
    level, peak, fall, stiffness, viscous = p[1], p[2], p[3], p[4], p[5]
    curve = level + (peak - level) * math.exp(-((v / fall) ** 2))
    if kind == 0:
        stop = mass * v / h + push
        return min(max(stop, -curve), curve) + viscous * v
    if kind == 3:
        force = 0.0
        for i in range(4):
            reach = 0.25 * level / (stiffness * (0.6, 0.25, 0.1, 0.05)[i])
            state[i] = min(max(state[i] + h * v, -reach), reach)
            force += stiffness * (0.6, 0.25, 0.1, 0.05)[i] * state[i]
        return force + viscous * v
    if kind == 1:
        curve = level
    old = state[0]
    state[0] = (old + h * v) / (1.0 + h * stiffness * abs(v) / curve)
    damper = 0.3 * math.sqrt(stiffness * mass) if kind == 2 else 0.0
    return stiffness * state[0] + damper * (state[0] - old) / h + viscous * v


@numba.njit(cache=True)  # type: ignore[misc]
def _run(wanted, injected, dt, masses, p_1, p_2, gains, loop):
    m_1, m_2, k, d, gap, nut, element, reach, screw = masses
    delay, lag, step = loop
    count, inner = wanted.size, round(dt / 25e-6)
    h = dt / inner
    x, v, y, w, current, whole, before, smooth, side = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s_1, s_2 = np.zeros(4), np.zeros(4)
    queue, wound = np.zeros(delay + 1), 0.0
    motor, load, effort, force = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    for n in range(count):
        seen = round(x / step) * step
        smooth += 0.6 * ((seen - before) / dt - smooth)
        before = seen
        pace = (wanted[n] - wanted[n - 1]) / dt if n else 0.0
        error = pace + gains[0] * (wanted[n] - seen) - smooth
        whole += error * dt
        for i in range(delay):
            queue[i] = queue[i + 1]
        queue[delay] = gains[1] * error + gains[2] * whole + injected[n]
        motor[n], load[n] = x, y
        total, passed, begun = 0.0, 0.0, v
        for _ in range(inner):
            current += h / lag * (queue[0] - current)
            total += current
            spring = 0.0
            if m_2 > 0.0:
                lost = x - y
                if lost > 0.5 * gap:
                    spring = (
                        max(k * (lost - 0.5 * gap) + d * (v - w), 0.0)
                        if gap > 0.0
                        else k * lost + d * (v - w)
                    )
                elif lost < -0.5 * gap:
                    spring = (
                        min(k * (lost + 0.5 * gap) + d * (v - w), 0.0)
                        if gap > 0.0
                        else k * lost + d * (v - w)
                    )
            if element > 0.0:
                wound = min(max(wound + h * (v - w), -reach), reach)
                spring += element * k * wound
            side += (math.copysign(1.0, v) - side) * (1.0 - math.exp(-h * abs(v) / NUT_TURNS))
            push = current - spring - nut * abs(spring) * side
            passed += spring + nut * abs(spring) * side
            v += h / m_1 * (push - _friction(int(p_1[0]), p_1, s_1, v, push, m_1, h))
            x += h * v
            if m_2 > 0.0:
                w += h / m_2 * (spring - _friction(int(p_2[0]), p_2, s_2, w, spring, m_2, h))
                y += h * w
            else:
                y = x
        effort[n] = total / inner
        force[n] = passed / inner + screw * (v - begun) / dt
    return motor, load, effort, force
