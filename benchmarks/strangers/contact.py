"""Friction over one fine step: mean force and the state after it, for a velocity that is constant over the step.

Bristles are stepped by the exact solution for that velocity, so that their stiffness, at speed far beyond what a step
resolves, costs neither steps nor stability. Forces are means over the step: the momentum of a step is exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from benchmarks.strangers.truth import Floats, Friction

__all__ = [
    "CELLS",
    "LUGRE",
    "STATIC",
    "Contact",
    "contact_of",
    "dry_level",
    "memory",
    "push",
    "viscous",
]

STATIC, LUGRE, CELLS = 0, 1, 2


class Contact(NamedTuple):
    """A friction law for compiled code; see `benchmarks.strangers.truth.Friction` for each name."""

    law: int
    F_C_p: float
    F_C_n: float
    F_S_p: float
    F_S_n: float
    v_S: float
    shape: float
    F_v_p: float
    F_v_n: float
    F_root: float
    root_floor: float
    sigma_0: float
    sigma_1: float
    cell_stiffness: Floats
    cell_share: Floats
    cell_damping: float
    lag: float
    ripple: float
    ripple_wave: float
    ripple_phase: float
    reversal_travel: float


def contact_of(f: Friction) -> Contact:
    return Contact(
        {"static": STATIC, "lugre": LUGRE, "cells": CELLS}[f.law],
        *f.F_C,
        *f.F_S,
        f.v_S,
        f.shape,
        *f.F_v,
        f.F_root,
        f.root_floor,
        f.sigma_0,
        f.sigma_1,
        np.array(f.cell_stiffness, dtype=float),
        np.array(f.cell_share, dtype=float),
        f.cell_damping,
        f.lag,
        f.ripple,
        2.0 * np.pi / f.ripple_period,
        f.ripple_phase,
        f.reversal_travel,
    )


@njit(cache=True)
def dry_level(c: Contact, w: float, positive: bool) -> float:
    """Return the level of sliding friction at the speed w, before heat, scatter and ripple."""
    if positive:
        low, high = c.F_C_p, c.F_S_p
    else:
        low, high = c.F_C_n, c.F_S_n
    if high == low:
        return low
    x = w / c.v_S
    power = x * x if c.shape == 2.0 else x**c.shape
    return low + (high - low) * np.exp(-power)


@njit(cache=True)
def viscous(c: Contact, v: float) -> float:
    """Return the viscous force, before heat."""
    force = (c.F_v_p if v >= 0.0 else c.F_v_n) * v
    if c.F_root != 0.0:
        force += c.F_root * v / np.sqrt(abs(v) + c.root_floor)
    return force


@njit(cache=True)
def memory(c: Contact, v: float, w: float, h: float) -> tuple[float, float]:
    """Return the speed that the Stribeck level sees over the step, and the lagged speed after it."""
    if c.lag <= 0.0:
        return abs(v), w
    after = abs(v) + (w - abs(v)) * np.exp(-h / c.lag)
    return 0.5 * (w + after), after


@njit(cache=True)
def push(
    c: Contact,
    z: Floats,
    after: Floats,
    v: float,
    w: float,
    w_end: float,
    dry: float,
    wet: float,
    h: float,
) -> float:
    """Return the mean friction force over a step of h at the mean velocity v; `after` receives the bristles after it.

    The level sees the speed w amid the step, and w_end after it. `dry` and `wet` multiply the level and the viscous
    part.
    """
    if c.law == LUGRE:
        g = dry * dry_level(c, w, v >= 0.0)
        k = c.sigma_0 * abs(v) * h / g
        if k < 1e-9:
            after[0] = z[0] + v * h - z[0] * k
            mean = 0.5 * (z[0] + after[0])
        else:
            end = np.sign(v) * g / c.sigma_0
            fall = -np.expm1(-k)
            after[0] = z[0] + (end - z[0]) * fall
            mean = end + (z[0] - end) * fall / k
        return c.sigma_0 * mean + c.sigma_1 * (after[0] - z[0]) / h + wet * viscous(c, v)
    # Cells that slide end at the level of the end, whose mean with that of the start is the mean over the step.
    up, down = dry * dry_level(c, w_end, True), dry * dry_level(c, w_end, False)
    force = wet * viscous(c, v)
    for i in range(z.size):
        stiffness = c.cell_stiffness[i]
        high, low = c.cell_share[i] * up / stiffness, -c.cell_share[i] * down / stiffness
        after[i] = min(max(z[i] + v * h, low), high)
        force += stiffness * (0.5 * (z[i] + after[i]) + c.cell_damping * (after[i] - z[i]) / h)
    return force
