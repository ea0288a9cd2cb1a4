"""Contact parameters by prediction errors and by inverse dynamics, on LuGre axes that another hand simulated.

The axes, loops and channels are those of `benchmarks.strangers`: late efforts, filters, holds, scatter of the level.
Their structure is that of the model: both directions alike, no cogging, no ripple of the motor, no lost rows; pre-sliding
takes 10 to 100 steps of the encoder. Nothing is stated but that step. ``python -m benchmarks.observer 7400 30`` asks
about seeds of one's own, and adds elements that slip.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.strange_logs import STROKES, table_of, true_values
from benchmarks.strangers import Record, Truth, draw, record_of, simulate
from benchmarks.strangers.truth import Friction
from bristle.core.cores import core_count
from bristle.core.diagnostic import Diagnostic
from bristle.core.errors import InputError

__all__ = ["Judged", "made", "observer", "tried"]

FIRST, LOGS, DRAWS = 9970, 40, 40
FIRST_ELEMENTS, ELEMENT_LOGS = 52_000, 30
AT = (0.1, 0.3, 1.0)  # of the pre-sliding zone: where the virgin curve of elements is judged
STEPS = (10.0, 100.0)  # of the encoder in the pre-sliding zone
METHODS = ("prediction_error", "inverse_dynamics")
NAMES = ("M", "F_C", "F_S", "v_S", "sigma_0", "sigma_1", "sigma_2")
ASTRAY = 2.0  # half-widths of the interval: an error beyond is confidently wrong


class Judged(NamedTuple):
    """A parameter of one log: relative error and half-width of the interval [%], NaN where there is none, and whether it holds."""

    error: float
    half_width: float
    holds: bool
    warned: bool


def made(seed: int) -> tuple[Truth, Record]:
    """Return an axis with its log."""
    truth = draw(seed, "lugre", STROKES[seed % len(STROKES)])
    friction, rng = truth.friction, np.random.default_rng((seed, 424242))
    alike = {name: (float(np.mean(getattr(friction, name))),) * 2 for name in ("F_C", "F_S", "F_v")}
    friction = replace(friction, **alike)
    return recorded(truth, friction, friction.F_S[0] / friction.sigma_0, rng)


def recorded(
    truth: Truth, friction: Friction, zone: float, rng: np.random.Generator
) -> tuple[Truth, Record]:
    """Return an axis of this friction without ripple and faults of a sensor, of so many steps of the encoder in its zone, with its log."""
    truth = replace(
        truth,
        friction=friction,
        axis=replace(truth.axis, cogging=0.0),
        motor=replace(truth.motor, ripple=0.0),
        encoder=replace(
            truth.encoder,
            resolution=zone / float(np.exp(rng.uniform(*np.log(STEPS)))),
            amplitudes=(0.0, 0.0, 0.0),
        ),
        recording=replace(truth.recording, lost=(), jitter=0.0),
    )
    return truth, record_of(truth, simulate(truth))


def tried(method: str, seed: int) -> dict[str, Judged] | None:
    """Identify one log, and judge its parameters; None where it is refused."""
    truth, record = made(seed)
    kind = "translational" if truth.axis.linear else "rotational"
    axis, known = (
        br.Axis(kind=kind, resolution=truth.encoder.resolution),
        true_values(truth, record),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            fit = br.identify(
                table_of(truth, record), "lugre", axis=axis, method=method, blocks=0, draws=DRAWS
            ).best
        except InputError:
            return None
    warnings_told = [
        diagnostic for diagnostic in fit.diagnostics if diagnostic.severity == "warning"
    ]
    unexplained = any(diagnostic.code == "prediction_error" for diagnostic in warnings_told)
    judged = dict[str, Judged]()
    for name in NAMES:
        estimate, true = fit.parameters[name], known[name]
        sure = estimate.status == "identified" and estimate.interval is not None
        low, high = (
            estimate.interval if sure and estimate.interval is not None else (np.nan, np.nan)
        )
        doubted = unexplained or any(
            name in (diagnostic.parameter, *_names(diagnostic)) for diagnostic in warnings_told
        )
        judged[name] = Judged(
            100.0 * (estimate.value / true - 1.0),
            50.0 * (high - low) / abs(true),
            bool(low <= true <= high),
            doubted,
        )
    return judged


def observer(first: int = FIRST, count: int = LOGS) -> Iterator[Share]:
    """Coverage of the intervals of both methods by parameter, with errors and half-widths."""
    with ProcessPoolExecutor(core_count()) as pool:
        for method in METHODS:
            logs = [
                one
                for one in pool.map(partial(tried, method), range(first, first + count))
                if one is not None
            ]
            every, bounds = list[Judged](), (92.0, 98.0) if method == METHODS[0] else (0.0, 100.0)
            for name in NAMES:
                found = [log[name] for log in logs]
                sure = [one for one in found if np.isfinite(one.half_width)]
                every += sure
                errors, width = (
                    np.array([one.error for one in found]),
                    float(np.median([one.half_width for one in sure] or [np.nan])),
                )
                note = f"error {np.median(np.abs(errors)):.2f} % (signed {np.median(errors):+.2f}, 90 % within "
                note += f"{np.quantile(np.abs(errors), 0.9):.1f}), half-width {width:.1f}"
                yield Share(
                    f"{method}, {name}", _holds(sure), min(bounds[0], 86.0), 100.0, len(sure), note
                )
            astray = sum(
                abs(one.error) > ASTRAY * one.half_width and not one.warned for one in every
            )
            yield Share(
                f"{method}, pooled",
                _holds(every),
                *bounds,
                len(every),
                f"{astray} errors above {ASTRAY:g} half-widths without a warning",
            )
            yield Share(f"{method}, read", 100.0 * len(logs) / count, 100.0, 100.0, count)


def elements_made(seed: int) -> tuple[Truth, Record]:
    """Return an axis of seven to ten elements that slip, with its log; elements neither fall with speed nor damp."""
    truth = draw(seed, "maxwell", STROKES[seed % len(STROKES)])
    level, damping = (float(np.mean(getattr(truth.friction, name))) for name in ("F_C", "F_v"))
    friction = replace(
        truth.friction,
        F_C=(level, level),
        F_S=(level, level),
        F_v=(damping, damping),
        cell_damping=0.0,
    )
    return recorded(truth, friction, friction.break_away, np.random.default_rng((seed, 424243)))


def virgin_curve(stiffness: np.ndarray, slips: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the force of elements on the virgin curve [N or N*m] at displacements [m or rad]."""
    return np.minimum.outer(x, slips) @ stiffness


def curve_errors(method: str, seed: int) -> np.ndarray | None:
    """Identify elements of one log; return the errors of their virgin curve [%], then that of their level; None where it is refused."""
    truth, record = elements_made(seed)
    axis, friction = (
        br.Axis(
            kind="translational" if truth.axis.linear else "rotational",
            resolution=truth.encoder.resolution,
        ),
        truth.friction,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            fit = br.identify(
                table_of(truth, record),
                "maxwell_slip",
                axis=axis,
                method=method,
                blocks=0,
                draws=DRAWS,
            ).best
        except InputError:
            return None
    known, found = true_values(truth, record)["F_C"], fit.friction.values
    true = np.array(friction.cell_stiffness) * known / friction.F_C[0]
    true_slips, levels = (
        np.array(friction.cell_share) * known / true,
        np.array(found["nu_i"]) * found["F_C"],
    )
    x = np.array(AT) * float(true_slips.max())
    curve = virgin_curve(np.array(found["k_i"]), levels / np.array(found["k_i"]), x) / virgin_curve(
        true, true_slips, x
    )
    return 100.0 * (np.append(curve, found["F_C"] / known) - 1.0)


def elements(first: int = FIRST_ELEMENTS, count: int = ELEMENT_LOGS) -> Iterator[str]:
    """Errors of elements that slip, by both methods: virgin curve and level."""
    with ProcessPoolExecutor(core_count()) as pool:
        for method in METHODS:
            errors = np.abs(
                [
                    one
                    for one in pool.map(partial(curve_errors, method), range(first, first + count))
                    if one is not None
                ]
            )
            columns = zip(
                (*(f"curve at {place:g} of the zone" for place in AT), "level"),
                errors.T,
                strict=True,
            )
            parts = [
                f"{name} {np.median(column):.2f} % (90 % within {np.quantile(column, 0.9):.1f})"
                for name, column in columns
            ]
            yield f"{method}, maxwell_slip, {len(errors)} logs: {', '.join(parts)}"


def _names(diagnostic: Diagnostic) -> tuple[str, ...]:
    names = diagnostic.numbers.get("names", ())
    return names if isinstance(names, tuple) else ()


def _holds(judged: list[Judged]) -> float:
    return 100.0 * float(np.mean([one.holds for one in judged])) if judged else float("nan")


if __name__ == "__main__":
    for share in observer(*map(int, sys.argv[1:])):
        print(share.row(), flush=True)
    for line in elements():
        print(line, flush=True)
