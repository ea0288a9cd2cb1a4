"""Further lies, from practice: what drives, gateways and colleagues do to a record without a word."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.strangers.lies import listed
from benchmarks.strangers.truth import Record, Truth

__all__ = ["HABITS"]

HABITS = (
    "effort_unsigned",
    "effort_stale",
    "effort_in_percent",
    "effort_offset",
    "effort_without_feedforward",
    "effort_coarse",
    "position_is_reference",
    "two_clocks",
    "two_logs_glued",
    "one_turn_only",
)


@listed
def effort_unsigned(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The current is recorded without sign, as in many drives."""
    return truth, replace(record, effort=np.abs(record.effort)), "effort without its sign", 0.0


@listed
def effort_stale(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """A slow fieldbus object transmits the effort: a new value in every eighth row, repeated in the next seven."""
    rows = 8 * (np.arange(record.t.size) // 8)
    return (
        truth,
        replace(record, effort=record.effort[rows]),
        "effort is new each eighth row only",
        8.0,
    )


@listed
def effort_in_percent(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The effort in percent of the rated force is declared as N or N*m."""
    factor = 100.0 * truth.recording.force_per_effort / truth.motor.rated
    unit = "N" if truth.axis.linear else "N*m"
    return (
        truth,
        replace(record, effort=factor * record.effort, effort_unit=unit),
        f"percent declared as {unit}",
        factor,
    )


@listed
def effort_offset(
    truth: Truth, record: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The current sensor has an offset of 3 to 8 % of the rated value: friction looks larger in one direction."""
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.08)) * truth.motor.rated
    return (
        truth,
        replace(record, effort=record.effort + off / truth.recording.force_per_effort),
        "effort offset",
        off,
    )


@listed
def effort_without_feedforward(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The record contains the controller output without the force feedforward: 90 % of the mass is missing."""
    r = record.reference if record.reference is not None else record.position
    n = max(3, round(0.01 / truth.period))
    smooth = np.convolve(
        np.pad(r, n, mode="edge"), np.hanning(2 * n + 1) / np.hanning(2 * n + 1).sum(), "valid"
    )
    a = np.gradient(np.gradient(smooth, truth.period), truth.period)
    # The smoothing sees no motion beyond the ends.
    a[: 2 * n], a[-2 * n :] = (a[2 * n], a[-2 * n - 1])
    mass = 0.9 * truth.mass
    effort = record.effort - mass * a / truth.recording.force_per_effort
    return (
        truth,
        replace(record, effort=effort),
        "effort lacks the feedforward of 90 % of the mass",
        mass,
    )


@listed
def effort_coarse(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The effort has seven bits and a sign, for twice the rated force."""
    step = 2.0 * truth.motor.rated / 127.0 / truth.recording.force_per_effort
    effort = np.clip(np.round(record.effort / step), -127, 127) * step
    return truth, replace(record, effort=effort), "effort has seven bits", step


@listed
def position_is_reference(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The position channel contains the reference (without a reference, the position smoothed over 20 ms)."""
    if record.reference is not None:
        return (
            truth,
            replace(record, position=record.reference.copy()),
            "position is the reference",
            0.0,
        )
    n = max(3, round(0.01 / truth.period))
    x = np.convolve(
        np.pad(record.position, n, mode="edge"), np.ones(2 * n + 1) / (2 * n + 1), "valid"
    )
    return truth, replace(record, position=x), "position is a smooth target", 0.02


@listed
def two_clocks(
    truth: Truth, record: Record, rng: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The effort comes from a device whose clock is wrong by 200 to 1000 ppm: late by many rows at the end."""
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(2e-4, 1e-3))
    effort = np.interp(record.t * (1.0 + off), record.t, record.effort)
    return (
        truth,
        replace(record, effort=effort),
        f"the clock of the effort runs {1e6 * off:.0f} ppm off",
        off,
    )


@listed
def two_logs_glued(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """One file contains two logs: the second half comes first, and its position begins at zero."""
    first = record.t.size - record.t.size // 2
    rows = np.roll(np.arange(record.t.size), first)
    zero = np.where(np.arange(record.t.size) < first, record.position[rows[0]], 0.0)
    glued = replace(
        record,
        position=record.position[rows] - zero,
        effort=record.effort[rows],
        reference=None if record.reference is None else record.reference[rows] - zero,
        velocity=None if record.velocity is None else record.velocity[rows],
    )
    return truth, glued, f"two logs glued at row {first}", float(first)


@listed
def one_turn_only(
    truth: Truth, record: Record, _: np.random.Generator
) -> tuple[Truth, Record, str, float]:
    """The encoder is single-turn: the position restarts after each turn (linear axis: after each 10 mm)."""
    period = truth.encoder.period
    return (
        truth,
        replace(record, position=np.mod(record.position, period)),
        "position starts anew each turn",
        period,
    )
