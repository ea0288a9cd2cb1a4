"""Draws an axis, its friction, loop, motion and record from one integer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.strangers import draw_loop, draw_motion
from benchmarks.strangers.recording import record_of, simulate
from benchmarks.strangers.truth import FAMILIES, Axis, Friction, Record, Truth

__all__ = ["draw", "make"]

UM = 1e-6  # [m] one micrometre of a linear axis
# [rad/m]: by which a rotary axis takes it, as a screw of 10 mm a turn does
SCREW = 2.0 * np.pi / 0.01


def draw(
    seed: int, family: str = "lugre", motion: str | None = None, linear: bool | None = None
) -> Truth:
    """Return a truth: the same for the same arguments.

    Parameters
    ----------
    seed
        Decides all that the other arguments leave open.
    family
        One of `truth.FAMILIES`.
    motion
        One of `truth.MOTIONS`; None draws one.
    linear
        True or False; None draws it.

    """
    if family not in FAMILIES:
        raise ValueError(f"unknown family {family!r}, allowed: {', '.join(FAMILIES)}")
    rng = np.random.default_rng((seed, FAMILIES.index(family), 77))
    drawn = bool(rng.random() < 0.55)
    axis, speed, acceleration, level = _axis(rng, drawn if linear is None else linear)
    friction = _friction(rng, family, axis, speed, level)
    if family == "backlash":
        axis = _play(rng, axis)
    moves = draw_motion.motion(rng, axis, friction, speed, acceleration, motion)
    friction = replace(friction, heat_time=float(rng.uniform(0.3, 1.0)) * moves.duration)
    return draw_loop.drive(rng, seed, family, axis, friction, moves, speed)


def make(
    seed: int, family: str = "lugre", motion: str | None = None, linear: bool | None = None
) -> tuple[Truth, Record]:
    """Return a truth and its record."""
    truth = draw(seed, family, motion, linear)
    return truth, record_of(truth, simulate(truth))


def _spread(rng: np.random.Generator, width: float) -> float:
    """A factor around one, of that standard deviation in its logarithm."""
    return float(np.exp(width * rng.standard_normal()))


def _axis(rng: np.random.Generator, linear: bool) -> tuple[Axis, float, float, float]:
    """Return axis, top speed, acceleration and friction level. Heavier axes are faster, and slow down sooner.

    Linear from a piezo stage of 30 g to a gantry of 300 kg, rotary from 3e-6 to 3e-2 kg*m^2.
    """
    if linear:
        mass = float(10.0 ** rng.uniform(-1.5, 2.5))
        speed = 0.3 * mass**0.3 * _spread(rng, 0.3)
        acceleration = float(np.exp(rng.uniform(np.log(1.0), np.log(8.0))))
        level = mass * 1.5 * mass**-0.35 * _spread(rng, 0.4)
        # Piezo and linear motors, screws, belts: the travel per (electrical) turn grows with the axis.
        turn = float(rng.choice([0.002, 0.005, 0.01] if mass < 3.0 else [0.01, 0.02, 0.04, 0.1]))
    else:
        mass = float(10.0 ** rng.uniform(-5.5, -1.5))
        speed = float(rng.uniform(40.0, 300.0)) * (mass / 3e-6) ** -0.1
        acceleration = 3000.0 * (mass / 1e-4) ** -0.25 * _spread(rng, 0.4)
        level = mass * 200.0 * (mass / 1e-3) ** -0.25 * _spread(rng, 0.4)
        turn = 2.0 * np.pi
    gravity = 0.0
    if rng.random() < 1.0 / 3.0:
        gravity = level * float(rng.uniform(0.3, 3.0))
        gravity = min(gravity, 9.81 * mass) if linear else gravity
    cogging = level * float(rng.uniform(0.02, 0.08)) if rng.random() < 1.0 / 3.0 else 0.0
    axis = Axis(linear, mass, turn, gravity, cogging, 6, float(rng.uniform(0.0, 2.0 * np.pi)))
    return axis, speed, acceleration, level


def _friction(
    rng: np.random.Generator, family: str, axis: Axis, speed: float, level: float
) -> Friction:
    unequal = float(rng.uniform(0.01, 0.12)) if rng.random() < 0.5 else 0.0
    unequal *= float(rng.choice([-1.0, 1.0]))
    drag = level * float(rng.uniform(0.2, 1.2)) / speed
    drags = (drag * (1.0 + 0.7 * unequal), drag * (1.0 - 0.7 * unequal))
    F_C = (level * (1.0 + unequal), level * (1.0 - unequal))
    over = float(rng.uniform(1.1, 1.7))
    distance = (
        float(np.exp(rng.uniform(np.log(1.0), np.log(50.0)))) * UM * (1.0 if axis.linear else SCREW)
    )
    stiffness = over * level / distance
    damping = 2.0 * float(rng.uniform(0.15, 0.7)) * np.sqrt(stiffness * axis.mass)
    # More would give forces beyond F_S whenever a bristle is bent fast.
    damping = min(damping, 4e-3 * stiffness)
    f = Friction(
        "lugre",
        F_C,
        (over * F_C[0], over * F_C[1]),
        speed * float(np.exp(rng.uniform(np.log(3e-3), np.log(3e-2)))),
        2.0,
        drags,
        sigma_0=stiffness,
        sigma_1=damping,
        scatter=float(rng.uniform(0.0, 0.03)),
        reversal_travel=3.0 * distance,
        break_away=distance,
    )
    if family == "coulomb":
        return replace(f, law="static", F_S=F_C, sigma_0=0.0, sigma_1=0.0, break_away=0.0)
    if family == "maxwell":
        return _cells(rng, f, over * level)
    if family == "lag":
        return replace(f, lag=float(rng.uniform(5e-3, 20e-3)))
    if family == "ripple":
        period = axis.turn * float(rng.choice([1.0, 1.0, 0.5]))
        return replace(
            f, ripple=0.1, ripple_period=period, ripple_phase=float(rng.uniform(0.0, 2.0 * np.pi))
        )
    if family == "root_viscous":
        small = (0.1 * drags[0], 0.1 * drags[1])
        return replace(f, F_v=small, F_root=drag * np.sqrt(speed), root_floor=1e-4 * speed)
    if family == "stribeck_half":
        return replace(f, shape=0.5)
    if family == "stribeck_cubic":
        return replace(f, shape=3.0)
    if family == "heat":
        return replace(f, heat=(1.2, 0.8))
    return f


def _cells(rng: np.random.Generator, f: Friction, highest: float) -> Friction:
    """Seven to ten cells, which give way at distances spread over a factor of thirty, the last at `break_away`."""
    count = int(rng.integers(7, 11))
    distances = (
        f.break_away
        * np.geomspace(1.0 / 30.0, 1.0, count)
        * np.exp(0.1 * rng.standard_normal(count))
    )
    share = rng.uniform(0.5, 1.5, count)
    share /= share.sum()
    stiffness = share * highest / distances
    return replace(
        f,
        law="cells",
        sigma_0=0.0,
        sigma_1=0.0,
        cell_stiffness=tuple(stiffness.tolist()),
        cell_share=tuple(share.tolist()),
        cell_damping=f.sigma_1 / f.sigma_0 * 0.3,
        break_away=float(distances.max()),
    )


def _play(rng: np.random.Generator, axis: Axis) -> Axis:
    share = float(rng.uniform(0.3, 0.7))
    half = float(rng.uniform(2.0, 20.0)) * UM * (1.0 if axis.linear else SCREW)
    reduced = axis.mass * share * (1.0 - share)
    wave = 2.0 * np.pi * float(rng.uniform(150.0, 400.0))  # [rad/s]: a closed contact rings there
    return replace(
        axis,
        half_play=half,
        load_share=share,
        contact_stiffness=reduced * wave**2,
        contact_damping=2.0 * 0.15 * reduced * wave,
    )
