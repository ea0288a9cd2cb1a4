"""A tracking run of 28 s on the Maxwell rig: the engine against a loop of the same scheme, written by hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.resources import files

import numba
import numpy as np

from benchmarks.timing import Ratio, side_by_side

FORCE_TOLERANCE, VELOCITY_TOLERANCE = 1e-9, 1e-11
SAME = 1e-12  # [m]


@numba.njit(error_model="numpy")
def friction_force(f, k, nu, v, h, limit, sigma_1, sigma_2):
    side = math.copysign(1.0, v)
    way = abs(v) * h
    total, slipping = 0.0, 0.0
    for i in range(k.size):
        top = nu[i] * limit
        at = min(side * f[i], top)
        rise = k[i] * way
        total += at + 0.5 * rise
        beyond = at + rise - top
        if beyond > 0.0:
            total -= 0.5 * beyond * beyond / rise
            slipping += beyond / rise
    return side * total + (sigma_1 * (1.0 - slipping / k.size) + sigma_2) * v


@numba.njit(error_model="numpy")
def loop_by_hand(
    r, r_dot, r_ddot, noise, scales, f, k, nu, rig, law, dt, steps, lag, measured, positions
):
    M, offset, F_C_pos, F_S_pos, F_C_neg, F_S_neg, v_S, sigma_1, sigma_2, v_r = rig
    lambda_, K_1, K_2, phi, cutoff, resolution = law
    h = dt / steps
    follow, mean_follow = -math.expm1(-h / lag), 1.0 + math.expm1(-h / lag) * lag / h
    gain = -math.expm1(-2.0 * math.pi * cutoff * dt)
    x = v = drive = command = v_hat = q = 0.0
    acceleration, slope = 0.0, 1.0
    side, scale, reversals = 0.0, 1.0, 0
    b = -0.5 * h / M
    for n in range(r.size):
        q_new = resolution * math.floor((x + noise[n]) / resolution + 0.5)
        v_hat += gain * ((q_new - q) / dt - v_hat)
        q = q_new
        measured[n], positions[n] = q, x
        e, e_dot = r[n] - q, r_dot[n] - v_hat
        surface = e_dot + lambda_ * e
        u = M * (
            r_ddot[n] + lambda_ * e_dot + K_1 * surface + K_2 * max(-1.0, min(1.0, surface / phi))
        )
        for _ in range(steps):
            effort = drive + (command - drive) * mean_follow
            drive += (command - drive) * follow
            a = v - b * effort
            w, w_last, residual_last = v + 0.5 * h * acceleration, 0.0, 0.0
            for iteration in range(100):
                forward = w > 0.0 or (w == 0.0 and math.copysign(1.0, w) > 0.0)
                F_C, F_S = (F_C_pos, F_S_pos) if forward else (F_C_neg, F_S_neg)
                ratio = w / v_S
                limit = scale * (F_C + (F_S - F_C) * math.exp(-ratio * ratio))
                force = friction_force(f, k, nu, w, h, limit, sigma_1, sigma_2) + offset
                residual = w - a - b * force
                if abs(residual) <= FORCE_TOLERANCE * abs(b * force) + VELOCITY_TOLERANCE * abs(a):
                    break
                if iteration > 0 and w != w_last:
                    slope = max((residual - residual_last) / (w - w_last), 1e-3)
                w_last, residual_last = w, residual
                w -= residual / slope
            way, now = abs(w) * h, math.copysign(1.0, w)
            for i in range(k.size):
                f[i] = now * min(now * f[i] + k[i] * way, nu[i] * limit)
            if (now * side < 0.0 or side == 0.0) and abs(w) > v_r:
                scale, side, reversals = scales[reversals], now, reversals + 1
            acceleration = 2.0 * (w - v) / h
            x, v = x + h * w, 2.0 * w - v
        command = u


def tracking() -> Iterator[Ratio]:
    """Time set A without compensation: 2 kHz, 25 steps a sample, thirty elements."""
    from bristle.core.random_numbers import normal
    from bristle.engine import run_closed_loop
    from bristle.files.experiment import read_experiment

    variant = read_experiment(files("bristle.apps.paper") / "experiments" / "set_a.toml").variants[
        0
    ]
    run, rig, law = variant.run, variant.friction.values, variant.controller.values
    sensor, mass = variant.sensor.values, variant.plant.values["M"]
    count = round(run.duration / run.sample_time)
    r, r_dot, r_ddot = variant.reference.component.sample(
        run.sample_time * np.arange(count), variant.reference.parameters
    )
    desired = np.stack((r, r_dot, r_ddot, np.zeros(count)))
    noise = np.array([sensor["noise"] * normal(sensor["seed"], n) for n in range(count)])
    scales = np.array([1.0 + rig["scatter"] * normal(rig["seed"], n) for n in range(1000)])
    told = (
        mass,
        *(
            rig[name]
            for name in (
                "offset",
                "F_C_pos",
                "F_S_pos",
                "F_C_neg",
                "F_S_neg",
                "v_S",
                "sigma_1",
                "sigma_2_pos",
                "v_r",
            )
        ),
    )
    gains = (
        *(law[name] for name in ("lambda_", "K_1", "K_2", "phi", "cutoff")),
        sensor["resolution"],
    )
    measured, positions = np.empty(count), np.empty(count)

    def by_hand() -> np.ndarray:
        loop_by_hand(
            r,
            r_dot,
            r_ddot,
            noise,
            scales,
            np.zeros(rig["k_i"].size),
            rig["k_i"],
            rig["nu_i"],
            told,
            gains,
            run.sample_time,
            run.substeps,
            run.current_lag,
            measured,
            positions,
        )
        return positions

    def in_bristle() -> np.ndarray:
        trace = run_closed_loop(
            variant.plant,
            variant.friction,
            variant.controller,
            variant.sensor,
            desired,
            run.sample_time,
            steps=run.substeps,
            delay=run.delay,
            lag=run.current_lag,
        )
        return trace.position

    ours, theirs, ratio = side_by_side(in_bristle, by_hand, 9)
    # In the last digits both differ, until a count of the encoder falls otherwise and the quantised loops part.
    apart = np.abs(in_bristle() - by_hand())
    together = int(np.argmax(apart > SAME)) if np.any(apart > SAME) else count
    steps = count * run.substeps
    yield Ratio(
        "tracking for 28 s on the rig, a step",
        ours / steps,
        theirs / steps,
        ratio,
        1.5,
        "a hand-written loop",
        f"within {float(apart[:together].max()):.0e} m for {together * run.sample_time:.1f} s",
    )
