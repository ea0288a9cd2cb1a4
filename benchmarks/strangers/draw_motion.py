"""Draws what somebody had the axis do while the trace ran."""

from __future__ import annotations

import numpy as np

from benchmarks.strangers.truth import MOTIONS, Axis, Friction, Motion

__all__ = ["motion"]

LEAD = 0.6  # [s]
WEIGHTS = (0.3, 0.15, 0.15, 0.1, 0.15, 0.08, 0.07)  # how often each of MOTIONS is drawn


def motion(
    rng: np.random.Generator,
    axis: Axis,
    friction: Friction,
    speed: float,
    acceleration: float,
    kind: str | None,
) -> Motion:
    """Return a motion within a top speed and an acceleration; None draws its kind."""
    drawn = str(rng.choice(MOTIONS, p=WEIGHTS))
    kind = drawn if kind is None else kind
    if kind not in MOTIONS:
        raise ValueError(f"unknown motion {kind!r}, allowed: {', '.join(MOTIONS)}")
    duration = float(rng.uniform(15.0, 40.0))
    stroke = max(float(rng.uniform(1.3, 4.0)) * speed**2 / acceleration, 0.1 * speed)
    smoothing = float(rng.uniform(0.01, 0.08))
    dwell = float(rng.choice([0.05, 0.1, 0.2, 0.5]))
    if kind in ("multisine", "sine"):
        return _sines(rng, kind, duration, speed, acceleration, stroke)
    if kind == "presliding":
        return _small(rng, axis, friction, duration)
    return Motion(
        kind, duration, LEAD, _speeds(rng, kind, speed), acceleration, smoothing, stroke, dwell
    )


def _speeds(rng: np.random.Generator, kind: str, speed: float) -> tuple[float, ...]:
    if kind == "one_speed":
        return (speed * float(np.exp(rng.uniform(np.log(0.1), 0.0))),)
    if kind == "cycle":
        return (speed, speed * float(np.exp(rng.uniform(np.log(0.03), np.log(0.2)))))
    count = int(rng.integers(4, 8))
    low = float(np.exp(rng.uniform(np.log(0.005), np.log(0.05))))
    return tuple(float(s) for s in rng.permutation(speed * np.geomspace(low, 1.0, count)))


def _sines(
    rng: np.random.Generator,
    kind: str,
    duration: float,
    speed: float,
    acceleration: float,
    stroke: float,
) -> Motion:
    """One slow sine, or six to twelve up to 10 Hz whose amplitudes fall with frequency, at the axis's limits or below.

    A sine of 0.05 to 0.5 Hz at the top speed would need a long axis: its amplitude is half a stroke at the most.
    """
    if kind == "sine":
        f = np.exp(rng.uniform(np.log(0.05), np.log(0.5), 1))
        a = np.minimum(
            speed * np.exp(rng.uniform(np.log(0.1), 0.0, 1)) / (2.0 * np.pi * f), 0.5 * stroke
        )
        return Motion(
            kind,
            duration,
            LEAD,
            frequencies=tuple(f.tolist()),
            amplitudes=tuple(a.tolist()),
            phases=(0.0,),
        )
    f = np.sort(np.exp(rng.uniform(np.log(0.1), np.log(10.0), int(rng.integers(6, 13)))))
    phases = rng.uniform(0.0, 2.0 * np.pi, f.size)
    a = f ** -float(rng.uniform(1.2, 2.0))
    t = np.arange(0.0, 40.0, 2e-3)
    waves = np.sin(2.0 * np.pi * f[:, None] * t + phases[:, None])
    peak_v = np.abs(
        (a * 2.0 * np.pi * f) @ np.cos(2.0 * np.pi * f[:, None] * t + phases[:, None])
    ).max()
    peak_a = np.abs((a * (2.0 * np.pi * f) ** 2) @ waves).max()
    a = a * min(0.8 * speed / peak_v, acceleration / peak_a, stroke / np.abs(a @ waves).max())
    return Motion(
        kind,
        duration,
        LEAD,
        frequencies=tuple(f.tolist()),
        amplitudes=tuple(a.tolist()),
        phases=tuple(phases.tolist()),
    )


def _small(rng: np.random.Generator, axis: Axis, friction: Friction, duration: float) -> Motion:
    """Triangles of 1 to 50 micrometres (or what a screw of 10 mm a turn makes of them), small ones first."""
    per = 1e-6 if axis.linear else 1e-6 * 2.0 * np.pi / 0.01
    highest = float(rng.uniform(5.0, 50.0))
    if friction.break_away > 0.0:
        # Somebody who looks for pre-sliding goes some way past break-away, and not ten times as far.
        highest = float(
            np.clip(highest, 0.7 * friction.break_away / per, 5.0 * friction.break_away / per)
        )
    highest = float(np.clip(highest, 2.0, 50.0))
    sizes = np.geomspace(max(1.0, 0.1 * highest), highest, int(rng.integers(3, 6)))
    rates = rng.uniform(0.4, 1.5, sizes.size)
    return Motion(
        "presliding",
        duration,
        LEAD,
        smoothing=0.01,
        dwell=0.3,
        frequencies=tuple(rates.tolist()),
        amplitudes=tuple((per * sizes).tolist()),
    )
