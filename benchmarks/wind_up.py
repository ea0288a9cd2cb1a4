"""Compensation of a table behind a soft screw: how much of the following error of the table remains with both frictions fed forward?

The drives are drawn like those of `benchmarks.two_mass`, with antiresonances of 8 to 40 Hz, and simulated in a loop that
shares no code with bristle. The position is measured on the motor, or on a scale at the table with the velocity of the
motor. bristle supplies only the reference and the feedforward. The baseline feeds one mass forward: the sum of both masses, and the sum of
both frictions along the reference. Friction acts as Coulomb with a Stribeck curve, Dahl, LuGre or Maxwell slip.
In a third of the drives the friction of the table falls with velocity by more than the damping of the screw: such a table
sticks and slips on its screw, and no reference of the motor prevents that.
``python -m benchmarks.wind_up [FIRST COUNT]`` prints the figures.

``python -m benchmarks.wind_up identified [FIRST COUNT]`` takes the parameters from a log of effort, motor encoder and scale of the same
drive. Its baseline is one mass with its friction, identified from the motor encoder.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numba
import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.two_mass import COULOMB, LUGRE, Drive, _friction as friction_force, drive_of, log_of
from bristle import friction, plants
from bristle.core import Feedforward
from bristle.core.cores import core_count
from bristle.simulation import feedforward_effort, friction_along, motor_reference

__all__ = [
    "Identified",
    "Tried",
    "identified",
    "soft_drive",
    "tried",
    "wind_up",
    "with_identification",
]

FIRST, COUNT = 0, 60
FIRST_IDENTIFIED, COUNT_IDENTIFIED = 4200, 20
MODELS = "coulomb_viscous,stribeck,lugre"
ERROR = 0.05  # of each parameter of the feedforward
SETTLE = 1.5  # s
SIDES = ("motor", "scale")
MOTIONS = ("sine", "strokes", "decaying")
MOST, MOST_SCALE = 25.0, 50.0  # % of the baseline; for a scale and parameters with errors


class Tried(NamedTuple):
    """Rms error of the table of one drive [m]: baseline and two-mass feedforward, with true parameters and with errors."""

    side: str
    motion: str
    one: float
    two: float
    one_off: float
    two_off: float
    slips: bool

    @property
    def percent(self) -> float:
        return 100.0 * self.two / self.one

    @property
    def percent_off(self) -> float:
        return 100.0 * self.two_off / self.one_off


def soft_drive(seed: int) -> Drive:
    """Draw a drive with a soft screw and most of its friction at the table."""
    draw = np.random.default_rng([4711, seed])
    drive = drive_of(seed)
    antiresonance, share = (
        math.exp(draw.uniform(math.log(8.0), math.log(40.0))),
        draw.uniform(0.1, 0.5),
    )
    level = sum(side[1] for side in drive.friction)
    sides = tuple(
        (
            law,
            part * level,
            part * level * peak / own,
            speed,
            part * level * stiffness / own,
            part * level * rub / own,
        )
        for part, (law, own, peak, speed, stiffness, rub) in zip(
            (share, 1.0 - share), drive.friction, strict=True
        )
    )
    return replace(
        drive,
        antiresonance=antiresonance,
        friction=sides,
        sample_time=0.5e-3,
        step=min(drive.step, 5e-7),
    )


def sticks_and_slips(drive: Drive) -> bool:
    """Return whether the friction of the table falls with velocity by more than the damping of screw and table."""
    law, level, peak, speed, _, rub = drive.friction[1]
    steepest = (peak - level) * math.sqrt(2.0 / math.e) / speed if law in (COULOMB, LUGRE) else 0.0
    return bool(steepest > rub + damper_of(drive))


def damper_of(drive: Drive) -> float:
    """Return the damping of the screw [N*s/m]."""
    return 4.0 * math.pi * drive.damping * drive.load * drive.antiresonance


def reference_of(
    drive: Drive, motion: str, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the desired position [m] and acceleration [m/s^2] of the table, of 6 s."""
    dt, count = drive.sample_time, round(6.0 / drive.sample_time)
    time = dt * np.arange(count)
    if motion == "strokes":  # there and back, with rests, of limited jerk
        leg, rest, stroke = draw.uniform(0.4, 0.9), 0.15, draw.uniform(0.005, 0.05)
        phase = (time % (2.0 * (leg + rest))) / (leg + rest)
        part = np.clip((phase % 1.0) * (leg + rest) / leg, 0.0, 1.0)
        rise = part**4 * (35.0 - 84.0 * part + 70.0 * part**2 - 20.0 * part**3)
        position = stroke * np.where(phase < 1.0, rise, 1.0 - rise)
    else:
        frequency, size = draw.uniform(0.3, 1.0), draw.uniform(0.002, 0.03)
        begun = np.clip(time / 0.5, 0.0, 1.0)
        size = (
            size
            * begun**3
            * (10.0 - 15.0 * begun + 6.0 * begun**2)
            * (np.exp(-0.5 * time) if motion == "decaying" else 1.0)
        )
        position = size * np.sin(2.0 * np.pi * frequency * time)
    acceleration = np.diff(position, 2, prepend=position[0], append=position[-1]) / dt**2
    return position, acceleration


def model_of(side: tuple[float, ...], mass: float, kind: Any) -> Any:
    """Return the friction of one side as a model of bristle."""
    law, level, peak, speed, stiffness, rub = side
    match int(law):
        case 0:
            return friction.stribeck(kind=kind, F_C=level, F_S=peak, v_S=speed, F_v=rub)
        case 1:
            return friction.dahl(kind=kind, sigma_0=stiffness, F_C=level, sigma_2=rub, exponent=1.0)
        case 2:
            damper = 0.3 * math.sqrt(stiffness * mass)
            return friction.lugre(
                kind=kind,
                F_C=level,
                F_S=peak,
                v_S=speed,
                sigma_0=stiffness,
                sigma_1=damper,
                sigma_2=rub,
                v_d=math.inf,
                validate=False,
            )
        case _:
            shares = np.array([0.6, 0.25, 0.1, 0.05])
            return friction.maxwell_slip(
                kind=kind, F_C=level, k_i=stiffness * shares, nu_i=[0.25] * 4, sigma_2=rub
            )


class Fed(NamedTuple):
    """Reference of the position loop and of the motor, and effort fed forward."""

    position: np.ndarray
    motor: np.ndarray
    effort: np.ndarray


def fed_forward(
    drive: Drive, wanted: np.ndarray, acceleration: np.ndarray, side: str
) -> tuple[Fed, Fed]:
    """Return the feedforward of one mass and of two masses, for a drive as the controller knows it."""
    dt, (motor_side, table_side) = drive.sample_time, drive.friction
    motor, table = (
        model_of(motor_side, drive.motor, "rotational"),
        model_of(table_side, drive.load, "translational"),
    )
    one = one_mass(drive.total, [motor, table], wanted, acceleration, dt)
    # A lead of 2 pi: one radian of the motor is one metre of the table.
    screw = plants.ball_screw(
        kind="rotational",
        J=drive.motor,
        M=drive.load,
        lead=2.0 * math.pi,
        k=drive.stiffness,
        d=damper_of(drive),
        backlash=drive.gap,
    )
    return one, two_masses(
        Feedforward(plant=screw, friction=motor, table=table), wanted, acceleration, dt, side
    )


def one_mass(
    mass: float, frictions: Sequence[Any], wanted: np.ndarray, acceleration: np.ndarray, dt: float
) -> Fed:
    """Return the feedforward of one mass with the sum of frictions."""
    steps = np.diff(wanted, append=wanted[-1]) / dt
    return Fed(
        wanted,
        wanted,
        mass * acceleration + sum(friction_along(model, steps, dt) for model in frictions),
    )


def two_masses(
    fed: Feedforward, wanted: np.ndarray, acceleration: np.ndarray, dt: float, side: str
) -> Fed:
    """Return the feedforward of both masses with the wind-up."""
    led = motor_reference(fed, wanted, acceleration, dt)
    return Fed(
        led if side == "motor" else wanted, led, feedforward_effort(fed, wanted, acceleration, dt)
    )


def tried(seed: int, side: str) -> Tried:
    """Run one drive with both kinds of feedforward."""
    drive, draw = soft_drive(seed), np.random.default_rng([815, seed])
    motion = MOTIONS[seed % len(MOTIONS)]
    wanted, acceleration = reference_of(drive, motion, draw)
    errors = []
    for known in (drive, _mistaken(drive, draw)):
        for fed in fed_forward(known, wanted, acceleration, side):
            errors.append(_missed(drive, wanted, fed, side))
    return Tried(side, motion, *errors, slips=sticks_and_slips(drive))


class Identified(NamedTuple):
    """Rms error of the table of one drive [m], with feedforward from a log: one mass, two masses; and two masses with true parameters."""

    seed: int
    side: str
    one: float
    two: float
    true: float
    slips: bool

    @property
    def percent(self) -> float:
        return 100.0 * self.two / self.one


def identified(seed: int) -> list[Identified] | str:
    """Identify one drive from a log of both encoders and run it with both feedforwards, or return why the log shows no two masses."""
    drive, draw = soft_drive(seed), np.random.default_rng([815, seed])
    columns: Any = log_of(drive)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = br.identify(columns, MODELS, axis=br.Axis(resolution=drive.step), blocks=0, draws=0)
    both = found.two_masses
    if both is None:
        return found.left_out["the plant with two masses"]
    wanted, acceleration = reference_of(drive, MOTIONS[seed % len(MOTIONS)], draw)
    motion = wanted, acceleration, drive.sample_time
    one = one_mass(found.best.parameters["M"].value, [found.best.friction], *motion)
    fed = Feedforward(plant=both.plant, friction=both.motor_friction, table=both.table_friction)
    results = []
    for side in SIDES:
        feeds = (
            one,
            two_masses(fed, *motion, side),
            fed_forward(drive, wanted, acceleration, side)[1],
        )
        results.append(
            Identified(
                seed,
                side,
                *(_missed(drive, wanted, feed, side) for feed in feeds),
                sticks_and_slips(drive),
            )
        )
    return results


def _missed(drive: Drive, wanted: np.ndarray, fed: Fed, side: str) -> float:
    """Return the rms error of the table after the settling time [m]."""
    error = wanted - table_of(drive, fed, side)
    return float(np.sqrt(np.mean(error[round(SETTLE / drive.sample_time) :] ** 2)))


def _mistaken(drive: Drive, draw: np.random.Generator) -> Drive:
    """Return the drive with errors of all parameters."""
    signs = 1.0 + ERROR * draw.choice([-1.0, 1.0], 12)
    sides = tuple(
        (
            side[0],
            side[1] * level,
            side[2] * level,
            side[3] * speed,
            side[4] * stiff,
            side[5] * level,
        )
        for side, level, speed, stiff in zip(
            drive.friction, signs[:2], signs[2:4], signs[4:6], strict=True
        )
    )
    motor, load = drive.motor * signs[6], drive.load * signs[7]
    # The stiffness is that of the antiresonance and the load.
    stiffness = math.sqrt(signs[8] / signs[7])
    return replace(
        drive,
        motor=motor,
        load=load,
        antiresonance=drive.antiresonance * stiffness,
        gap=drive.gap * signs[9],
        friction=sides,
    )


def table_of(drive: Drive, fed: Fed, side: str) -> np.ndarray:
    """Return the motion of the table in the loop."""
    slowness = (drive.delay + 1.0) * drive.sample_time + drive.lag
    pace = min(2.0 * math.pi * 25.0, 0.25 / slowness)
    place = pace / 5.0
    if side == "scale":  # half of the gain at which the table on its spring rings
        place = min(place, drive.damping * 2.0 * math.pi * drive.antiresonance)
    gains = np.array([place, drive.motor * pace, drive.motor * pace * pace / 6.0])
    masses = np.array([drive.motor, drive.load, drive.stiffness, damper_of(drive), drive.gap])
    # The feedforward is known in advance, so the controller receives it earlier, by the delay.
    ahead = np.concatenate([fed.effort[drive.delay :], fed.effort[-1:].repeat(drive.delay)])
    frictions = [np.array(part) for part in drive.friction]
    inputs, loop = np.stack([fed.position, fed.motor, ahead]), (drive.delay, drive.lag, drive.step)
    table = _loop(inputs, drive.sample_time, masses, *frictions, gains, loop, side == "scale")
    if not np.ptp(table) < 3.0 * np.ptp(fed.position):
        raise ArithmeticError(f"the loop of drive {drive.seed} is unstable")
    return table


@numba.njit(cache=True)  # type: ignore[misc]
def _loop(wanted, dt, masses, p_1, p_2, gains, loop, at_table):
    m_1, m_2, k, d, gap = masses
    delay, lag, step = loop
    count, inner = wanted.shape[1], round(dt / 25e-6)
    h = dt / inner
    x, v, y, w, current, whole, before, missed = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s_1, s_2, queue, table = np.zeros(4), np.zeros(4), np.zeros(delay + 1), np.empty(count)
    for n in range(count):
        seen, scale = round(x / step) * step, round(y / step) * step
        # Measured and desired velocity pass the same filter.
        missed += 0.6 * ((wanted[1, n] - seen - before) / dt - missed)
        before = wanted[1, n] - seen
        error = gains[0] * (wanted[0, n] - (scale if at_table else seen)) + missed
        whole += error * dt
        for i in range(delay):
            queue[i] = queue[i + 1]
        queue[delay] = gains[1] * error + gains[2] * whole + wanted[2, n]
        table[n] = y
        for _ in range(inner):
            current += h / lag * (queue[0] - current)
            lost, spring = x - y, 0.0
            if gap == 0.0:
                spring = k * lost + d * (v - w)
            elif lost > 0.5 * gap:
                spring = max(k * (lost - 0.5 * gap) + d * (v - w), 0.0)
            elif lost < -0.5 * gap:
                spring = min(k * (lost + 0.5 * gap) + d * (v - w), 0.0)
            push = current - spring
            v += h / m_1 * (push - friction_force(int(p_1[0]), p_1, s_1, v, push, m_1, h))
            x += h * v
            w += h / m_2 * (spring - friction_force(int(p_2[0]), p_2, s_2, w, spring, m_2, h))
            y += h * w
    return table


def wind_up(first: int = FIRST, count: int = COUNT) -> Iterator[Share]:
    """Yield the share of the error of the table that remains, in percent of the feedforward of one mass."""
    jobs = [(seed, side) for side in SIDES for seed in range(first, first + count)]
    with ProcessPoolExecutor(core_count()) as pool:
        results = list(pool.map(tried, *zip(*jobs, strict=True)))
    for (seed, _), one in zip(jobs, results, strict=True):
        print(seed, one, f"{one.percent:.1f} % {one.percent_off:.1f} %", file=sys.stderr)
    for side in SIDES:
        place = {"motor": "encoder", "scale": "scale"}[side]
        for slips, text in ((False, ""), (True, ", stick-slip")):
            drives = [one for one in results if one.side == side and one.slips is slips]
            for known, percents in (
                ("true", [one.percent for one in drives]),
                ("5 % off", [one.percent_off for one in drives]),
            ):
                most = (
                    100.0
                    if slips
                    else MOST_SCALE
                    if (side, known) == ("scale", "5 % off")
                    else MOST
                )
                below = 100.0 * float(np.mean(np.array(percents) < MOST))
                yield Share(
                    f"{place}, {known}{text}: median error",
                    float(np.median(percents)),
                    0.0,
                    most,
                    len(drives),
                )
                yield Share(
                    f"{place}, {known}{text}: below {MOST:g} %", below, 0.0, 100.0, len(drives)
                )


def with_identification(
    first: int = FIRST_IDENTIFIED, count: int = COUNT_IDENTIFIED
) -> Iterator[Share]:
    """Yield the share of the error of the table that remains with identified parameters, in percent of one identified mass."""
    tries = [identified(seed) for seed in range(first, first + count)]
    for seed, one in zip(range(first, first + count), tries, strict=True):
        print(seed, one, file=sys.stderr)
    found = [one for one in tries if not isinstance(one, str)]
    yield Share("both masses identified", 100.0 * len(found) / count, 90.0, 100.0, count)
    for place, side in enumerate(SIDES):
        name = {"motor": "encoder", "scale": "scale"}[side]
        for slips, text in ((False, ""), (True, ", stick-slip")):
            drives = [pair[place] for pair in found if pair[place].slips is slips]
            for known, percents in (
                ("identified", [one.percent for one in drives]),
                ("true", [100.0 * one.true / one.one for one in drives]),
            ):
                yield Share(
                    f"{name}, {known}{text}: median error",
                    float(np.median(percents)),
                    0.0,
                    100.0 if slips else MOST,
                    len(drives),
                )


if __name__ == "__main__":
    mode, numbers = (
        (with_identification, sys.argv[2:])
        if sys.argv[1:2] == ["identified"]
        else (wind_up, sys.argv[1:])
    )
    for share in mode(*map(int, numbers)):
        print(share.row())
