"""References as people run them: position, velocity and acceleration at the ticks of the loop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.strangers.truth import Floats, Motion

__all__ = ["reference"]


def reference(motion: Motion, period: float) -> tuple[Floats, Floats, Floats]:
    """Return position, velocity and acceleration at each tick, from the start of the lead-in to the end."""
    count = 1 + int(np.ceil((motion.lead + motion.duration) / period))
    t = period * np.arange(count, dtype=float) - motion.lead
    if motion.kind in ("multisine", "sine"):
        r = _sines(motion, t)
        return r, np.gradient(r, period), np.gradient(np.gradient(r, period), period)
    if motion.kind == "presliding":
        r = _mean_of(_triangles(motion, t), motion.smoothing, period)
        return r, np.gradient(r, period), np.gradient(np.gradient(r, period), period)
    corners_t, corners_v = _corners(motion)
    v = _mean_of(np.interp(t, corners_t, corners_v), motion.smoothing, period)
    r = np.concatenate([[0.0], np.cumsum(0.5 * period * (v[1:] + v[:-1]))])
    return r, v, np.gradient(v, period)


def _mean_of(x: Floats, width: float, period: float) -> Floats:
    """A moving mean over the past: what makes ramps of velocity into S-curves."""
    n = max(1, round(width / period))
    total = np.cumsum(np.concatenate([np.full(n, x[0]), x]))
    return (total[n:] - total[:-n]) / n


def _sines(motion: Motion, t: Floats) -> Floats:
    r = np.zeros_like(t)
    for f, a, p in zip(motion.frequencies, motion.amplitudes, motion.phases, strict=True):
        r += a * np.sin(2.0 * np.pi * f * t + p)
    # The first second ramps the amplitude up, without a jump of acceleration.
    s = np.clip(t / 1.0, 0.0, 1.0)
    return r * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def _triangles(motion: Motion, t: Floats) -> Floats:
    """Triangles of each amplitude, two of a kind, at the frequencies given, again from the first when done."""
    corners_t, corners_r = [-motion.lead, 0.2], [0.0, 0.0]
    k = 0
    while corners_t[-1] < motion.duration:
        a = motion.amplitudes[k % len(motion.amplitudes)]
        quarter = 0.25 / motion.frequencies[k % len(motion.frequencies)]
        for _ in range(2):
            for step, level in ((1, a), (2, -a), (1, 0.0)):
                corners_t.append(corners_t[-1] + step * quarter)
                corners_r.append(level)
        corners_t.append(corners_t[-1] + motion.dwell)
        corners_r.append(0.0)
        k += 1
    return np.interp(t, corners_t, corners_r)


def _corners(motion: Motion) -> tuple[Floats, Floats]:
    """Corners of the velocity over time: trapezoids, one after the other with dwells between."""
    times, speeds = [-motion.lead - 1.0, 0.2], [0.0, 0.0]
    for distance, speed in _moves(motion):
        if times[-1] > motion.duration:
            break
        peak = min(speed, np.sqrt(motion.acceleration * abs(distance)))
        ramp, cruise = peak / motion.acceleration, abs(distance) / peak - peak / motion.acceleration
        for after, v in ((ramp, peak), (max(cruise, 1e-9), peak), (ramp, 0.0), (motion.dwell, 0.0)):
            times.append(times[-1] + after)
            speeds.append(float(np.sign(distance)) * v)
    return np.asarray(times), np.asarray(speeds)


def _moves(motion: Motion) -> Iterator[tuple[float, float]]:
    """(signed distance, speed), without end. Slow strokes are cut short, so that each speed has its turn."""
    while True:
        if motion.kind == "cycle":
            fast, slow = motion.speeds
            yield 0.7 * motion.stroke, fast
            yield min(0.3 * motion.stroke, 1.0 * slow), slow
            yield -0.7 * motion.stroke - min(0.3 * motion.stroke, 1.0 * slow), fast
            continue
        for speed in motion.speeds:
            distance = min(motion.stroke, 1.5 * speed)
            yield distance, speed
            if motion.kind != "one_direction":
                yield -distance, speed
