"""Pre-sliding from data: how fast a fit is, beside plain least squares of its size, and how far off it ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import Ratio, side_by_side

__all__ = ["presliding"]

SEEDS = 30
REPEATS = 9
NOISE = 0.005
MISSED = 0.0  # [s]: no time is short enough for a fit that errs by more than it may


def presliding() -> Iterator[Ratio]:
    """Fit stops and cells to known friction, and operators to the curves of a magnet where BRISTLE_DATA names them."""
    from bristle.identification.hysteresis.linear import fit_grid, fit_stops

    data = _data(0)
    for count, most in ((20, 0.0035), (40, 0.0018)):
        errors = [
            _error(lambda data, count=count: fit_stops(data, count=count), seed)
            for seed in range(SEEDS)
        ]
        told = f"{100 * np.median(errors):.3f} % of f_p on unseen paths, worst of {SEEDS} {100 * max(errors):.3f} %"
        yield _row(
            f"{count} stops on friction of stops",
            lambda count=count: fit_stops(data, count=count),
            (1601, count + 1),
            told,
            5e-3 if max(errors) <= most else MISSED,
        )
    errors = [_error(lambda data: fit_grid(data, cells=30), seed) for seed in range(3)]
    told = f"{100 * max(errors):.2f} % of f_p on unseen paths, worst of 3"
    yield _row(
        "cells with a sign, 30 a side, on friction",
        lambda: fit_grid(data, cells=30),
        (1601, 465),
        told,
        2.0 if max(errors) <= 0.01 else MISSED,
    )
    yield from _of_a_magnet()


def _path(rng: np.random.Generator) -> np.ndarray:
    turns = np.concatenate([[0.0, 3.0, -3.0], rng.uniform(-3.0, 3.0, 78)])
    return np.interp(np.linspace(0.0, 80.0, 1601), np.arange(81), turns)


def _truth() -> Any:
    from bristle import hysteresis

    return hysteresis.preisach(kernel="dahl_masing", s=1.0, f_p=1.0)


def _data(seed: int) -> Any:
    from bristle import response
    from bristle.logs.curves import Curve, Curves

    rng = np.random.default_rng(seed)
    u = _path(rng)
    return Curves((Curve(u, response(_truth(), u) + NOISE * rng.standard_normal(u.size)),))


def _error(fit: Callable[[Any], Any], seed: int) -> float:
    """Return the error of a fit on ten paths that it has not seen, root mean square over f_p."""
    from bristle import response

    rng = np.random.default_rng(1000 + seed)
    operator, truth = fit(_data(seed)).operator, _truth()
    unseen = [_path(rng) for _ in range(10)]
    return float(
        np.sqrt(np.mean([(response(operator, u) - response(truth, u)) ** 2 for u in unseen]))
    )


def _row(name: str, fit: Callable[[], Any], size: tuple[int, int], told: str, most: float) -> Ratio:
    columns = np.random.default_rng(0).standard_normal(size)
    plain = columns[:, 0].copy()
    ours, theirs, ratio = side_by_side(
        fit, lambda: np.linalg.lstsq(columns, plain, rcond=None), REPEATS
    )
    return Ratio(
        name,
        ours,
        theirs,
        ratio,
        None,
        "numpy.linalg.lstsq of this size, unbounded",
        told,
        most=most,
    )


def _of_a_magnet() -> Iterator[Ratio]:
    from bristle.files import read_curves
    from bristle.identification.hysteresis import identify_operator
    from bristle.identification.hysteresis.linear import fit_grid
    from bristle.models.hysteresis import table_of_curves

    if "BRISTLE_DATA" not in os.environ:
        print("presliding: skips the magnet, BRISTLE_DATA is not set")
        return
    axis = Path(__file__).parents[1] / "examples" / "forc" / "axis.toml"
    recorded = read_curves(Path(os.environ["BRISTLE_DATA"]) / "forc" / "forc_curves.npz", axis)
    fits: dict[str, tuple[float, Callable[[], Any], tuple[int, int]]] = {
        "reversal_table": (
            0.021,
            lambda: table_of_curves(recorded.curves, kind=recorded.kind),
            (9_700, 257),
        ),
        "preisach_grid": (0.2, lambda: fit_grid(recorded), (9_700, 465)),
    }
    found = {fit.name: fit for fit in identify_operator(recorded, list(fits)).fits}
    for name, (limit, fit, size) in fits.items():
        held_out = found[name].held_out
        error = held_out.mean_percent if held_out else float("inf")
        told = f"{error:.4f} % of full scale on curves held out"
        yield _row(f"{name} of a magnet", fit, size, told, 2.0 if error <= limit else MISSED)
