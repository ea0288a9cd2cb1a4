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
def effort_unsigned(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The magnitude of the current: many drives show just that under this name."""
    return truth, replace(record, effort=np.abs(record.effort)), "effort without its sign", 0.0


@listed
def effort_stale(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The effort travels in a slower object of the fieldbus: a new value each eighth row, the rest repeat it."""
    rows = 8 * (np.arange(record.t.size) // 8)
    return truth, replace(record, effort=record.effort[rows]), "effort is new each eighth row only", 8.0


@listed
def effort_in_percent(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """Percent of the rated force declared as N or N*m."""
    factor = 100.0 * truth.recording.force_per_effort / truth.motor.rated
    unit = "N" if truth.axis.linear else "N*m"
    return (truth, replace(record, effort=factor * record.effort, effort_unit=unit), f"percent declared as {unit}", factor)


@listed
def effort_offset(truth: Truth, record: Record, rng: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The zero of the current sensor is off by 3 to 8 % of rated: friction of one direction looks larger."""
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.08)) * truth.motor.rated
    return truth, replace(record, effort=record.effort + off / truth.recording.force_per_effort), "effort offset", off


@listed
def effort_without_feedforward(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The trace taps the controller's output before the feedforward of force is added: 90 % of the mass is missing."""
    r = record.reference if record.reference is not None else record.position
    n = max(3, round(0.01 / truth.period))
    smooth = np.convolve(np.pad(r, n, mode="edge"), np.hanning(2 * n + 1) / np.hanning(2 * n + 1).sum(), "valid")
    a = np.gradient(np.gradient(smooth, truth.period), truth.period)
    a[: 2 * n], a[-2 * n :] = a[2 * n], a[-2 * n - 1]  # the smoothing sees no motion beyond the ends
    mass = 0.9 * truth.mass
    effort = record.effort - mass * a / truth.recording.force_per_effort
    return truth, replace(record, effort=effort), "effort lacks the feedforward of 90 % of the mass", mass


@listed
def effort_coarse(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The effort has seven bits and a sign over twice the rated force."""
    step = 2.0 * truth.motor.rated / 127.0 / truth.recording.force_per_effort
    effort = np.clip(np.round(record.effort / step), -127, 127) * step
    return truth, replace(record, effort=effort), "effort has seven bits", step


@listed
def position_is_reference(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """The channel called position is the reference (where the record has none, the trace smoothed over 20 ms)."""
    if record.reference is not None:
        return truth, replace(record, position=record.reference.copy()), "position is the reference", 0.0
    n = max(3, round(0.01 / truth.period))
    x = np.convolve(np.pad(record.position, n, mode="edge"), np.ones(2 * n + 1) / (2 * n + 1), "valid")
    return truth, replace(record, position=x), "position is a smooth target", 0.02


@listed
def two_clocks(truth: Truth, record: Record, rng: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """Effort comes from another device, whose clock runs 200 to 1000 ppm off: late by many rows at the end."""
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(2e-4, 1e-3))
    effort = np.interp(record.t * (1.0 + off), record.t, record.effort)
    return truth, replace(record, effort=effort), f"the clock of the effort runs {1e6 * off:.0f} ppm off", off


@listed
def two_logs_glued(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """Two logs in one file: the second half first, its position counted from zero anew."""
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
def one_turn_only(truth: Truth, record: Record, _: np.random.Generator) -> tuple[Truth, Record, str, float]:
    """A single-turn encoder: the position starts anew after each turn (each 10 mm of a linear axis)."""
    period = truth.encoder.period
    return truth, replace(record, position=np.mod(record.position, period)), "position starts anew each turn", period
