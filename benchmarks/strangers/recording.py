"""From a truth to its record: the loop is run, and its signals pass through what the drive's trace does to them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.strangers.contact import contact_of
from benchmarks.strangers.encoder import read_out, scale_of
from benchmarks.strangers.kernel import COLUMNS, Inputs, controller_of, drive_of, run
from benchmarks.strangers.motion import reference
from benchmarks.strangers.steps import body_of
from benchmarks.strangers.truth import Floats, Friction, Record, Truth

__all__ = ["Run", "fine_steps", "low_pass", "make_record", "plain", "record_of", "simulate"]

STEP = (
    0.04  # [rad]: of the fastest bristle, per fine step; a contact that opens and closes takes less
)
REVERSALS = 20_000  # more than any record holds


@dataclass(frozen=True)
class Run:
    """The true signals at each instant of the trace, from the start of the record on; forces as in `kernel.COLUMNS`."""

    t: Floats  # [s]
    q: Floats  # [m or rad]
    v: Floats
    command: Floats  # [N or N*m]
    motor: Floats
    force: Floats
    friction: Floats
    position_force: Floats  # gravity and cogging
    measured_velocity: Floats
    load: Floats  # [m or rad]: position of the load
    reference: Floats


def _generator(truth: Truth, purpose: int) -> np.random.Generator:
    return np.random.default_rng((truth.seed, purpose))


def _heat(f: Friction, t: Floats, duration: float) -> Floats:
    first, last = f.heat
    if first == last:
        return np.full_like(t, first)
    tau = f.heat_time
    left = np.exp(-np.clip(t, 0.0, None) / tau)
    end = np.exp(-duration / tau)
    return last + (first - last) * (left - end) / (1.0 - end)


def fine_steps(truth: Truth) -> int:
    """Return how many fine steps a row of the trace takes: 40 kHz or more, and what bristles and contact need."""
    f, a, fastest = truth.friction, truth.axis, 0.0
    if f.law == "lugre":
        fastest = np.sqrt(f.sigma_0 / a.mass)
    elif f.law == "cells":
        fastest = np.sqrt(sum(f.cell_stiffness) / a.mass)
    step = min(25e-6, STEP / fastest) if fastest > 0.0 else 25e-6
    if a.load_share > 0.0:
        reduced = a.mass * a.load_share * (1.0 - a.load_share)
        step = min(step, 0.4 * STEP / np.sqrt(a.contact_stiffness / reduced))
    return int(np.ceil(truth.recording.trace_period / max(step, 4e-6)))


def simulate(truth: Truth, finer: int = 1) -> Run:
    """Run the loop. `finer` divides the fine step."""
    loop, rec, motion = truth.loop, truth.recording, truth.motion
    r, r_v, r_a = reference(motion, loop.period)
    t = loop.period * np.arange(r.size, dtype=float) - motion.lead
    noise = truth.motor.noise * _generator(truth, 1).standard_normal(r.size)
    scatter = truth.friction.scatter * _generator(truth, 2).standard_normal(REVERSALS)
    inputs = Inputs(
        r,
        r_v,
        r_a,
        noise,
        _heat(truth.friction, t, motion.duration),
        np.clip(scatter, -0.5, 0.5),
        truth.axis.gravity,
    )
    rows = run(
        contact_of(truth.friction),
        body_of(truth.axis),
        drive_of(truth.motor, truth.axis.turn),
        controller_of(loop),
        scale_of(truth.encoder),
        inputs,
        rec.per_tick,
        finer * fine_steps(truth),
    )
    first = round(motion.lead / loop.period) * rec.per_tick
    last = first + round(motion.duration / rec.trace_period)
    stamps = rec.trace_period * np.arange(rows.shape[0]) - motion.lead
    target = np.repeat(r, rec.per_tick)
    columns = {name: rows[first:last, i].copy() for i, name in enumerate(COLUMNS)}
    return Run(stamps[first:last], reference=target[first:last], **columns)


def low_pass(x: Floats, tau: float, period: float) -> Floats:
    """First-order, exact for a held input, from its steady state."""
    if tau <= 0.0:
        return x
    keep = float(np.exp(-period / tau))
    out = np.empty_like(x)
    y = x[0]
    for i, value in enumerate(x.tolist()):
        y = keep * y + (1.0 - keep) * value
        out[i] = y
    return out


def _late(x: Floats, rows: int) -> Floats:
    return x if rows == 0 else np.concatenate([np.full(rows, x[0]), x[:-rows]])


def record_of(truth: Truth, made: Run) -> Record:
    """Return what the drive records of a run."""
    rec, period = truth.recording, truth.recording.trace_period
    shown = made.command if rec.source == "command" else made.motor
    shown = shown + rec.effort_noise * _generator(truth, 3).standard_normal(shown.size)
    shown = (
        _late(low_pass(shown, rec.effort_filter, period), rec.effort_late) / rec.force_per_effort
    )
    position = low_pass(read_out(made.q, scale_of(truth.encoder)), rec.position_filter, period)
    kept = np.arange(0, made.t.size, rec.every)
    here = np.ones(kept.size, dtype=bool)
    for start, count in rec.lost:
        here[start : start + count] = False
    kept = kept[here]
    # Lost rows leave no gap: the recorder stamps what it has, one period apart.
    t = truth.period * np.arange(kept.size)
    t = t + rec.jitter * _generator(truth, 4).standard_normal(t.size)
    return Record(
        np.maximum.accumulate(t + 1e-9 * np.arange(t.size)) if rec.jitter > 0.0 else t,
        position[kept],
        shown[kept],
        "m" if truth.axis.linear else "rad",
        rec.effort_unit,
        made.reference[kept] if rec.reference else None,
        made.measured_velocity[kept] if rec.velocity else None,
    )


def make_record(truth: Truth) -> Record:
    """Return the record of a truth."""
    return record_of(truth, simulate(truth))


def plain(truth: Truth) -> Truth:
    """Return the truth with a trace that hides nothing: acted force, no filter, noise, jitter or loss."""
    rec = replace(
        truth.recording,
        source="acted",
        effort_late=0,
        effort_filter=0.0,
        position_filter=0.0,
        effort_noise=0.0,
        force_per_effort=1.0,
        jitter=0.0,
        lost=(),
        every=1,
    )
    return replace(truth, recording=rec)
