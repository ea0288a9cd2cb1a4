"""Paths and recorded curves with a known truth, in units of the saturation and of f_p/s."""

import numpy as np

from bristle import hysteresis, response
from bristle.logs.curves import Curve, Curves

TRUTH = hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)
NOISE = 0.005


def to_and_fro(rng, turns=80, amplitude=3.0, samples=1601):
    """A path through random turning points, once through its whole range first."""
    at = np.concatenate([[0.0, amplitude, -amplitude], rng.uniform(-amplitude, amplitude, turns - 2)])
    return np.interp(np.linspace(0.0, turns, samples), np.arange(turns + 1), at)


def recorded(truth, u, rng=None, offset=0.0):
    """The output of an operator along a path, with noise, as one curve from the virgin state."""
    noise = 0.0 if rng is None else NOISE * rng.standard_normal(u.size)
    return Curves((Curve(u, response(truth, u) + offset + noise),))


def error_on_unseen(operator, truth, rng, offset=0.0, paths=10, **path):
    """Root mean square error on other paths."""
    unseen = [to_and_fro(rng, **path) for _ in range(paths)]
    return float(np.sqrt(np.mean([(response(operator, u) + offset - response(truth, u)) ** 2 for u in unseen])))


def reversal_curves(operator, count=41, extent=3.0, samples=60, rising=True):
    """First-order reversal curves of an operator, each from saturation."""
    side = 1.0 if rising else -1.0
    curves = []
    for turn in np.linspace(-extent, 0.9 * extent, count).tolist():
        u = side * np.linspace(turn, extent, samples)
        curves.append(Curve(u, response(operator, u, history=[side * extent])))
    return tuple(curves)
