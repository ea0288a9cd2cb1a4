"""How many loops have to be measured: error on motions that were not measured, for three ways to a model.

The paper replaces the many experiments that a Preisach plane asks for by the two numbers of the reformed Dahl model.
Here the contact is measured along a growing number of transition branches (first-order reversal curves), and from the
same records come

* the operator with the loops of the reformed Dahl model, stiffness and saturation by least squares;
* a Prandtl-Ishlinskii operator, its weights by non-negative least squares;
* an Everett function tabulated from the branches.

Each has an offset, and is judged on random pre-sliding motions of the same contact. A contact that scatters from
reversal to reversal does not repeat itself either: two runs of its own along the same path tell what a model that
knew its mean would still leave.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bristle import hysteresis
from bristle.core.contracts import Model
from bristle.core.least_squares import non_negative
from bristle.engine import response
from bristle.paper.measurement import Record, measured
from bristle.paper.setting import Setting

__all__ = ["WAYS", "Economy", "Fitted", "economy", "fitted_reformed_dahl", "fitted_stops", "fitted_table", "quiet", "repeated", "seeded"]

STOPS = 25
UNSEEN = 6  # random motions
TURNS = 24  # of each


class Fitted(NamedTuple):
    """An operator at the table, the offset beside it [N*m], and the torque of the screw over the force."""

    operator: Model
    offset: float
    arm: float

    def torque(self, x: np.ndarray) -> np.ndarray:
        """Return the friction torque [N*m] along a path of the table [m] that begins at the end of the run-in."""
        return self.offset + self.arm * response(self.operator, x, history=[x[0]])


class Economy(NamedTuple):
    """Errors in percent of the largest torque."""

    counts: list[int]
    errors: dict[str, np.ndarray]
    floor: float
    duration: float


def seeded(friction: Model, seed: int) -> Model:
    """Return a contact with another seed of its scatter; one that repeats itself exactly as it is."""
    return friction.with_values(seed=seed) if "seed" in friction.values else friction


def repeated(setting: Setting, friction: Model) -> list[Model]:
    """Return a contact for each of the `seeds` of an experiment, the first one as it is."""
    first = round(friction.values.get("seed", 0))
    return [seeded(friction, first + index) for index in range(round(setting["measurement", "seeds"]))]


def quiet(friction: Model) -> Model:
    """Return a contact that repeats itself exactly."""
    return friction.with_values(scatter=0.0) if "scatter" in friction.values else friction


def economy(setting: Setting, friction: Model, seeds: int, progress: Callable[[float, str], None] | None = None) -> Economy:
    """Return the errors of models made from few and many measured branches of a contact."""
    counts = [round(count) for count in setting["measurement", "branches"]]
    extent, speed = setting["measurement", "extent"], setting["measurement", "speed"]
    unseen = [_unseen(setting, friction, index) for index in range(UNSEEN)]
    errors = {name: np.full((len(counts), seeds), np.nan) for name in WAYS}
    for row, count in enumerate(counts):
        for seed in range(seeds):
            if progress is not None:
                progress((row * seeds + seed) / (len(counts) * seeds), f"branches measured: {count}")
            record = _branches(setting, seeded(friction, seed), extent, count, np.random.default_rng(seed))
            for name, fit in WAYS.items():
                fitted = fit(record, setting.arm)
                if fitted is not None:
                    errors[name][row, seed] = _error(fitted, unseen)
    floor = np.mean([_percent(first.torque - again.torque, again.torque) for first, again in unseen])
    return Economy(counts, errors, float(floor) / math.sqrt(2.0), 2.0 * extent / speed)


def _branches(setting: Setting, friction: Model, extent: float, count: int, generator: np.random.Generator) -> Record:
    """Return the record of a contact run in at its lower end, and of this many branches from there."""
    tops = extent * (1.0 - 2.0 * np.arange(count) / count)
    turns = [-extent, extent, -extent]
    for top in tops.tolist():
        turns += [top, -extent]
    return measured(setting, friction, turns, generator).since(2)


def _unseen(setting: Setting, friction: Model, index: int) -> tuple[Record, Record]:
    """Return two runs of the contact along one random motion, with other scatter and noise."""
    generator = np.random.default_rng(1000 + index)
    extent = setting["measurement", "extent"]
    turns = [-extent, extent, -extent, *(0.9 * extent * generator.uniform(-1.0, 1.0, TURNS))]
    first, second = (measured(setting, seeded(friction, seed), turns, generator).since(2) for seed in (100 + index, 200 + index))
    return first, second


def _error(fitted: Fitted, unseen: list[tuple[Record, Record]]) -> float:
    return float(np.mean([_percent(record.torque - fitted.torque(record.x), record.torque) for record, _ in unseen]))


def _percent(difference: np.ndarray, torque: np.ndarray) -> float:
    return 100.0 * float(np.sqrt(np.mean(difference**2))) / float(np.max(np.abs(torque)))


def fitted_reformed_dahl(record: Record, arm: float) -> Fitted:
    """Return the operator with the loops of (16) and (17): s and f_p by least squares."""
    from scipy.optimize import least_squares

    x, force = _decimated(record.x), _decimated(record.torque) / arm
    reach, height = float(np.ptp(x)), float(np.ptp(force))

    def operator(p: np.ndarray) -> Model:
        s, f_p = np.exp(p) * (height / reach, height)
        return hysteresis.preisach(kernel="reformed_dahl_exact", s=s, f_p=f_p)

    def residual(p: np.ndarray) -> np.ndarray:
        left = force - response(operator(p), x, history=[x[0]])
        return (left - left.mean()) / height

    best = operator(least_squares(residual, np.log([5.0, 1.0]), method="lm").x)
    return _with_offset(best, record, arm)


def fitted_stops(record: Record, arm: float) -> Fitted:
    """Return the Prandtl-Ishlinskii operator by non-negative least squares, thresholds spaced geometrically."""
    x, force = _decimated(record.x), _decimated(record.torque) / arm
    reach = float(np.ptp(x))
    thresholds = reach * np.append(np.geomspace(5e-3, 0.5, STOPS - 1), 10.0)  # the last one never slips: a spring
    columns = [response(hysteresis.stop(r=r), x, history=[x[0]]) for r in thresholds.tolist()]
    # What the constant leaves over has the same sign both ways, so that weights stay non-negative.
    design = np.column_stack([*columns, np.ones(x.size), -np.ones(x.size)])
    size = np.linalg.norm(design, axis=0)
    weights = non_negative(design / size, force) / size
    operator = hysteresis.prandtl_ishlinskii(thresholds=thresholds, weights=weights[:-2], spring=0.0)
    return Fitted(operator, arm * float(weights[-2] - weights[-1]), arm)


def fitted_table(record: Record, arm: float) -> Fitted | None:
    """Return the operator with an Everett function tabulated from descending branches; None from fewer than two."""
    turns = record.turns
    if turns.size < 5:
        return None
    curves = [_curve(record, int(a), int(b), arm) for a, b in zip(turns[1::2], turns[2::2], strict=True)]
    return _with_offset(hysteresis.from_reversal_curves(curves), record, arm)


def _with_offset(operator: Model, record: Record, arm: float) -> Fitted:
    """Return an operator with the offset that is left over."""
    x, torque = _decimated(record.x), _decimated(record.torque)
    return Fitted(operator, float(np.mean(torque - arm * response(operator, x, history=[x[0]]))), arm)


def _curve(record: Record, top: int, bottom: int, arm: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a descending branch with one point for each count of the encoder, the mean of what was read there."""
    x, torque = record.x[top : bottom + 1], record.torque[top : bottom + 1]
    counts, index = np.unique(-x, return_inverse=True)
    return -counts, np.bincount(index, torque) / np.bincount(index) / arm


def _decimated(signal: np.ndarray, points: int = 4000) -> np.ndarray:
    return signal[:: max(signal.size // points, 1)]


WAYS: dict[str, Callable[[Record, float], Fitted | None]] = {
    "reformed Dahl": fitted_reformed_dahl,
    "Prandtl-Ishlinskii": fitted_stops,
    "tabulated surface": fitted_table,
}
