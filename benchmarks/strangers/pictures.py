"""A record as a picture, for the eye of a servo engineer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.strangers.truth import Record, Truth

__all__ = ["picture"]


def picture(truth: Truth, record: Record, path: Path) -> None:
    """Draw position, effort and following error over time, and effort over velocity and over position."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 9), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 3)
    force = record.effort * truth.recording.force_per_effort
    t, q = record.t, record.position
    n = max(1, round(0.004 / truth.period))
    v = np.gradient(np.convolve(q, np.ones(n) / n, "same"), truth.period)
    unit, F = record.position_unit, max(truth.friction.F_C)
    axes[0, 0].plot(t, q, lw=0.8)
    if record.reference is not None:
        axes[0, 0].plot(t, record.reference, "--", lw=0.6)
    axes[0, 0].set(title=f"position [{unit}]", xlabel="time [s]")
    axes[0, 1].plot(t, force / F, lw=0.4)
    axes[0, 1].set(title=f"effort / F_C, limit {truth.motor.limit / F:.1f}", xlabel="time [s]")
    if record.reference is not None:
        axes[0, 2].plot(t, (record.reference - q) / truth.encoder.resolution, lw=0.4)
    axes[0, 2].set(title="following error [counts]", xlabel="time [s]")
    few = slice(n, -n)
    axes[1, 0].plot(v[few], force[few] / F, ".", ms=0.8)
    s = np.linspace(v[few].min(), v[few].max(), 801)
    axes[1, 0].plot(s, (truth.steady(s) + truth.axis.gravity) / F, "r", lw=0.8)
    axes[1, 0].set(
        title="effort / F_C over velocity; red: true steady friction", xlabel=f"velocity [{unit}/s]"
    )
    axes[1, 1].plot(q, force / F, lw=0.3)
    axes[1, 1].set(title="effort / F_C over position", xlabel=f"position [{unit}]")
    middle = (t > 0.3 * t[-1]) & (t < 0.3 * t[-1] + 1.5)
    axes[1, 2].plot(t[middle], force[middle] / F, lw=0.7)
    twin = axes[1, 2].twinx()
    twin.plot(t[middle], q[middle], "k", lw=0.7)
    axes[1, 2].set(title="1.5 s of effort / F_C (colour) and position (black)", xlabel="time [s]")
    a, lo, rec, k = truth.axis, truth.loop, truth.recording, truth.friction
    figure.suptitle(
        f"{truth.family} seed {truth.seed} {truth.motion.kind}: m={a.mass:.3g} F_C={F:.3g} g={a.gravity:.3g} "
        f"cog={a.cogging / F:.2f} z_ba={k.break_away:.2g} res={truth.encoder.resolution:.2g}\n"
        f"{lo.kind} T={lo.period * 1e3:.2g} ms delay={lo.delay} kp={lo.kp:.3g} wv={lo.kv / a.mass:.0f} rad/s "
        f"ff={lo.feed_velocity:.0f}/{lo.feed_mass / a.mass:.2f} rec {rec.source} late={rec.effort_late} "
        f"filters={rec.effort_filter * 1e3:.1f}/{rec.position_filter * 1e3:.1f} ms every={rec.every} {rec.effort_unit}",
        fontsize=9,
    )
    figure.savefig(path, dpi=70)
