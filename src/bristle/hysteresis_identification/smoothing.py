"""Reversal curves behind a cubic that slides along them, over as many samples as the curves themselves allow.

Neighbouring curves share their shape, and not the noise of the output. Over how many samples the cubic reaches, if
any, is decided by what smoothed neighbours say of the recorded curve between them: its own noise is not theirs, so a
window that bends the curves shows as well as one that leaves noise.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.logs.curves import Curve, Curves

__all__ = ["Smoothed", "smoothed"]

WINDOWS = (1, 5, 9, 13)  # samples
ORDER = 3
SHARES = np.linspace(0.0, 1.0, 101)  # of the way along a curve, at which it is compared
GAIN = 0.999  # of the error, at most: a wider window has to earn its place


class Smoothed(NamedTuple):
    """Curves behind a cubic over `window` samples; as they were recorded where it is 1."""

    recorded: Curves
    window: int


def smoothed(recorded: Curves) -> Smoothed:
    """Return reversal curves with as much noise taken off as their neighbours say is noise."""
    order = sorted(recorded.curves, key=lambda curve: float(curve.u[0]))
    if len(order) < 3:
        return Smoothed(recorded, 1)
    raw, best, window = _rows(order), np.inf, 1
    for width in WINDOWS:
        error = _error_between(_rows([_behind(curve, width) for curve in order]), raw, order)
        if error < GAIN * best:
            best, window = error, width
    return Smoothed(replace(recorded, curves=tuple(_behind(curve, window) for curve in recorded.curves)), window)


def _behind(curve: Curve, window: int) -> Curve:
    """Return a curve behind the sliding cubic; one that is shorter than its window stays."""
    if window == 1 or curve.f.size < window:
        return curve
    from scipy.signal import savgol_filter

    return Curve(curve.u, np.asarray(savgol_filter(curve.f, window, ORDER)))


def _rows(curves: list[Curve]) -> np.ndarray:
    """Return the outputs at equal shares of each curve, shape (curve, share)."""
    rows = []
    for curve in curves:
        side = 1.0 if curve.u[-1] >= curve.u[0] else -1.0
        rows.append(np.interp(side * (curve.u[0] + SHARES * (curve.u[-1] - curve.u[0])), side * curve.u, curve.f))
    return np.array(rows)


def _error_between(rows: np.ndarray, raw: np.ndarray, curves: list[Curve]) -> float:
    """Return the root mean square by which recorded curves miss what their neighbours say."""
    turn = np.array([float(curve.u[0]) for curve in curves])
    width = turn[2:] - turn[:-2]
    share = np.divide(turn[1:-1] - turn[:-2], width, out=np.full(width.size, 0.5), where=width > 0.0)[:, None]
    return float(np.sqrt(np.mean((raw[1:-1] - (1.0 - share) * rows[:-2] - share * rows[2:]) ** 2)))
