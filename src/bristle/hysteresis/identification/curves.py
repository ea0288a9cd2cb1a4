r"""Is a Preisach operator adequate at all? Its minor loops between the same inputs are congruent.

Branches that turned at the same input must change alike from there on, whatever came before. The residual is the root
mean square by which a branch differs, at the same distance from the turning point, from what two others that turned
just before and behind it say in between; scaled so that it reads as the error of one. Noise of the output is part of
it, and so is its error at the turning point. If branches are alike wherever they turned, the operator is one of Prandtl
and Ishlinskii.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.hysteresis.identification.trace import trace_of
from bristle.logs.curves import Curve, Curves

NEARNESS = 0.02  # of the range of inputs: turning points between which branches change evenly
SAMPLES_LEAST = 5  # of a branch
WINDOWS = (1, 5, 9, 13)  # samples
SHARES = np.linspace(0.0, 1.0, 101)  # of the way along a curve, at which it is compared
GAIN = 0.999  # of the error, at most: a wider window has to earn its place
POINTS = 20  # of a branch, at which it is compared


class Congruency(NamedTuple):
    """By how much branches differ [N, N*m or A*m^2]; None where no two can be compared.

    ``alike`` compares branches that turned at the same input: an error that no Preisach operator can avoid.
    ``anywhere`` compares branches that turned far apart: one that no Prandtl-Ishlinskii operator can avoid.
    """

    alike: float | None
    anywhere: float | None


class Branch(NamedTuple):
    """What followed on a turning point, mirrored if need be so that it rises."""

    turn: float
    travel: np.ndarray
    change: np.ndarray


def congruency_of(recorded: Curves) -> Congruency:
    """Return how far recorded branches are from congruent."""
    close, far = [], []
    nearness = NEARNESS * (recorded.high - recorded.low)
    for side in (1.0, -1.0):
        branches = _branches(recorded, side)
        third = len(branches) // 3
        near = zip(branches, branches[1:], branches[2:], strict=False)
        close += [_difference(*three) for three in near if three[2].turn - three[0].turn <= nearness]
        apart = zip(branches, branches[third:], branches[2 * third :], strict=False)
        far += [_difference(first, last, middle) for first, middle, last in apart if third]
    return Congruency(_level(close), _level(far))


def _branches(recorded: Curves, side: float) -> list[Branch]:
    """Return the branches in one direction, in the order of where they turned."""
    branches = []
    for curve in recorded.curves:
        trace = trace_of(curve.u, recorded.history(curve))
        base, rising = trace.base[trace.first :] - trace.first, trace.side[trace.first :] == side
        for turned in np.unique(base[rising & (base >= 0)]):
            part = np.flatnonzero((base == turned) & rising)
            if part.size >= SAMPLES_LEAST:
                travel, change = side * (curve.u[part] - curve.u[turned]), side * (curve.f[part] - curve.f[turned])
                branches.append(Branch(float(curve.u[turned]), travel, change))
    return sorted(branches, key=lambda branch: branch.turn)


def _difference(before: Branch, branch: Branch, behind: Branch) -> np.ndarray:
    """Return by how much a branch differs from what two others say in between, over the part that all have."""
    three = (before, branch, behind)
    travel = np.linspace(0.0, min(branch.travel[-1] for branch in three), POINTS + 1)[1:]
    low, inner, high = (np.interp(travel, [0.0, *branch.travel], [0.0, *branch.change]) for branch in three)
    width = behind.turn - before.turn
    share = float(np.clip((branch.turn - before.turn) / width, 0.0, 1.0)) if width > 0.0 else 0.5
    return (inner - low - share * (high - low)) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)


def _level(differences: list[np.ndarray]) -> float | None:
    return float(np.sqrt(np.mean(np.square(differences)))) if differences else None


class Smoothed(NamedTuple):
    """Curves behind a cubic over `window` samples; as they were recorded where it is 1.

    Neighbouring curves share their shape, and not the noise of the output: the window is the one with which smoothed
    neighbours say best what the recorded curve between them is.
    """

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

    return Curve(curve.u, np.asarray(savgol_filter(curve.f, window, 3)))


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
