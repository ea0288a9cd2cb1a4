"""How many loops must be measured: error on unseen motions, for three ways to a model.

The paper replaces the many experiments for a Preisach plane by the two numbers of the reformed Dahl model. Here the
contact is measured along a growing number of transition branches (first-order reversal curves). The same records give

* the operator with the loops of the reformed Dahl model, stiffness and saturation by least squares;
* a Prandtl-Ishlinskii operator, its weights by non-negative least squares;
* an Everett function tabulated from the branches.

Each has an offset, and is tested on random pre-sliding motions of the same contact. A contact that scatters from
reversal to reversal does not repeat exactly: two of its runs along the same path show the error that remains even with
its mean as the model.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.apps.paper.bench import Record, measured
from bristle.apps.paper.reproduced import Verdict, spread
from bristle.apps.paper.setting import Setting
from bristle.core import Model, non_negative, number
from bristle.engine import response
from bristle.models import hysteresis
from bristle.report.table import Table

STOPS = 25
UNSEEN = 6  # random motions
TURNS = 24  # of each


class Fitted(NamedTuple):
    """An operator at the table, its additional offset [N*m], and the torque of the screw over the force."""

    operator: Model
    offset: float
    arm: float

    def torque(self, x: np.ndarray) -> np.ndarray:
        """Return the friction torque [N*m] along a path of the table [m] that starts after the run-in."""
        return self.offset + self.arm * response(self.operator, x, history=[x[0]])


class Economy(NamedTuple):
    """Errors in percent of the largest torque."""

    counts: list[int]
    errors: dict[str, np.ndarray]
    floor: float
    duration: float

    @property
    def means(self) -> dict[str, np.ndarray]:
        """The mean over seeds for each kind of model, in the order of the branches; NaN without a model."""
        return {name: errors.mean(axis=1) for name, errors in self.errors.items()}


def seeded(friction: Model, seed: int) -> Model:
    """Return a contact with another seed of its scatter; unchanged if it has no scatter."""
    if "seed" not in friction.values:
        return friction
    return friction.with_values(seed=seed)


def repeated(setting: Setting, friction: Model) -> list[Model]:
    """Return a contact for each of the `seeds` of an experiment, the first one unchanged."""
    first = round(friction.values.get("seed", 0))
    return [
        seeded(friction, first + index) for index in range(round(setting["measurement", "seeds"]))
    ]


def quiet(friction: Model) -> Model:
    """Return a contact without scatter."""
    if "scatter" not in friction.values:
        return friction
    return friction.with_values(scatter=0.0)


def economy(
    setting: Setting,
    friction: Model,
    seeds: int,
    progress: Callable[[float, str], None] | None = None,
) -> Economy:
    """Return the errors of models from few to many measured branches of a contact."""
    counts = [round(count) for count in setting["measurement", "branches"]]
    extent = setting["measurement", "extent"]
    speed = setting["measurement", "speed"]
    unseen = [_unseen(setting, friction, index) for index in range(UNSEEN)]
    errors = {name: np.full((len(counts), seeds), np.nan) for name in WAYS}
    for row, count in enumerate(counts):
        for seed in range(seeds):
            if progress is not None:
                progress(
                    (row * seeds + seed) / (len(counts) * seeds), f"branches measured: {count}"
                )
            # A contact run in at its lower end, with this many branches from there.
            tops = extent * (1.0 - 2.0 * np.arange(count) / count)
            turns = [
                -extent,
                extent,
                -extent,
                *(turn for top in tops.tolist() for turn in (top, -extent)),
            ]
            record = measured(
                setting, seeded(friction, seed), turns, np.random.default_rng(seed)
            ).since(2)
            for name, fit in WAYS.items():
                fitted = fit(record, setting.arm)
                if fitted is not None:
                    left = [
                        _percent(record.torque - fitted.torque(record.x), record.torque)
                        for record, _ in unseen
                    ]
                    errors[name][row, seed] = np.mean(left)
    floor = np.mean(
        [_percent(first.torque - again.torque, again.torque) for first, again in unseen]
    )
    return Economy(counts, errors, float(floor) / math.sqrt(2.0), 2.0 * extent / speed)


def _unseen(setting: Setting, friction: Model, index: int) -> tuple[Record, Record]:
    """Return two runs of the contact along one random motion, with different scatter and noise."""
    generator = np.random.default_rng(1000 + index)
    extent = setting["measurement", "extent"]
    turns = [-extent, extent, -extent, *(0.9 * extent * generator.uniform(-1.0, 1.0, TURNS))]
    first, second = (
        measured(setting, seeded(friction, seed), turns, generator).since(2)
        for seed in (100 + index, 200 + index)
    )
    return first, second


def _percent(difference: np.ndarray, torque: np.ndarray) -> float:
    return 100.0 * float(np.sqrt(np.mean(difference**2))) / float(np.max(np.abs(torque)))


def fitted_reformed_dahl(record: Record, arm: float) -> Fitted:
    """Return the operator with the loops of (16) and (17): s and f_p by least squares."""
    from scipy.optimize import least_squares

    x = _decimated(record.x)
    force = _decimated(record.torque) / arm
    reach = float(np.ptp(x))
    height = float(np.ptp(force))

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
    x = _decimated(record.x)
    force = _decimated(record.torque) / arm
    reach = float(np.ptp(x))
    # The last one never slips: a spring.
    thresholds = reach * np.append(np.geomspace(5e-3, 0.5, STOPS - 1), 10.0)
    columns = [response(hysteresis.stop(r=r), x, history=[x[0]]) for r in thresholds.tolist()]
    # The residual of the constant has the same sign both ways, so that weights stay non-negative.
    design = np.column_stack([*columns, np.ones(x.size), -np.ones(x.size)])
    size = np.linalg.norm(design, axis=0)
    weights = non_negative(design / size, force) / size
    operator = hysteresis.prandtl_ishlinskii(
        thresholds=thresholds, weights=weights[:-2], spring=0.0
    )
    return Fitted(operator, arm * float(weights[-2] - weights[-1]), arm)


def fitted_table(record: Record, arm: float) -> Fitted | None:
    """Return the operator with an Everett function tabulated from descending branches; None with fewer than two."""
    turns = record.turns
    if turns.size < 5:
        return None
    curves = []
    for top, bottom in zip(turns[1::2], turns[2::2], strict=True):
        # One point for each count of the encoder: the mean of the readings there.
        counts, index = np.unique(-record.x[top : bottom + 1], return_inverse=True)
        curves.append(
            (
                -counts,
                np.bincount(index, record.torque[top : bottom + 1]) / np.bincount(index) / arm,
            )
        )
    return _with_offset(hysteresis.from_reversal_curves(curves), record, arm)


def _with_offset(operator: Model, record: Record, arm: float) -> Fitted:
    """Return an operator with the mean residual as its offset."""
    x = _decimated(record.x)
    torque = _decimated(record.torque)
    return Fitted(
        operator, float(np.mean(torque - arm * response(operator, x, history=[x[0]]))), arm
    )


def _decimated(signal: np.ndarray) -> np.ndarray:
    return signal[:: max(signal.size // 4000, 1)]


WAYS: dict[str, Callable[[Record, float], Fitted | None]] = {
    "reformed Dahl": fitted_reformed_dahl,
    "Prandtl-Ishlinskii": fitted_stops,
    "tabulated surface": fitted_table,
}


CAPTION = (
    "Error on unseen motions, over the number of measured branches",
    "Error on random unseen motions, for models from more and more measured branches: mean and range over the seeds. "
    "Dotted: error of the mean of the rig, because the rig does not repeat exactly.",
)
AS_GOOD = 1.5  # ratio of errors up to which two numbers from few loops replace a surface from many


def verdict(cost: Economy) -> Verdict:
    """Return whether the reformed Dahl model from the fewest branches is about as good as the surface from the most."""
    # In part, if an operator fitted to the same few branches is better.
    means = cost.means
    few = float(means["reformed Dahl"][0])
    many = float(means["tabulated surface"][-1])
    if few > AS_GOOD * many:
        return "refuted"
    if float(means["Prandtl-Ishlinskii"][0]) < few:
        return "found in part"
    return "found"


def sentences(cost: Economy, still: Economy) -> list[str]:
    """Return the gain of more measurements, in sentences."""
    first, second = list(WAYS)[:2]
    gained = cost.errors[first][0] - cost.errors[second][0]
    branches = "branches"
    if cost.counts[0] == 1:
        branches = "branch"
    on_rig = [
        f"On unseen motions: {_both_ends(cost)}. One branch takes {number(cost.duration, digits=2)} s."
    ]
    if gained.size > 1:
        on_rig.append(
            f"From the same {branches}, {second} is better than {first} in {np.count_nonzero(gained > 0.0)} of {gained.size} "
            f"repetitions, by {spread(gained)} %."
        )
    return [
        *on_rig,
        f"The scatter of the rig alone is {number(cost.floor, digits=2)} %, a lower bound for every model.",
        f"On a rig without scatter: {_both_ends(still)}.",
    ]


def _both_ends(cost: Economy) -> str:
    """Return the errors with the fewest and with the most branches, in words."""
    ends = []
    for row in sorted({0, len(cost.counts) - 1}):
        complete = {
            name: errors[row]
            for name, errors in cost.errors.items()
            if np.all(np.isfinite(errors[row]))
        }
        texts = {
            name: spread(errors) if errors.size > 1 else number(float(errors[0]), digits=2)
            for name, errors in complete.items()
        }
        listed = ", ".join(f"{name} {text} %" for name, text in texts.items())
        branches = "branch"
        if cost.counts[row] > 1:
            branches = "branches"
        ends.append(f"from {cost.counts[row]} {branches} {listed}")
    return "; ".join(ends)


def numbers(cost: Economy, still: Economy) -> dict[str, Any]:
    """Return the errors [%] for the summary, by kind of model, in the order of the branches."""
    deviations = {name: np.zeros(len(errors)) for name, errors in cost.errors.items()}
    if cost.errors[next(iter(WAYS))].shape[1] > 1:
        deviations = {name: np.std(errors, axis=1, ddof=1) for name, errors in cost.errors.items()}
    means = {"error_percent": cost.means, "error_percent_without_scatter": still.means}
    return {
        "branches": cost.counts,
        **means,
        "error_deviation_percent": deviations,
        "scatter_percent": cost.floor,
    }


def table(cost: Economy, still: Economy) -> Table:
    """Return the errors side by side."""
    columns = [economy.errors[name] for economy in (cost, still) for name in WAYS]
    rows = [
        (str(count), *(spread(column[row], 0.1) for column in columns))
        for row, count in enumerate(cost.counts)
    ]
    heads = ("Branches", *WAYS, *(f"{name}, no scatter" for name in WAYS))
    return Table(
        "Error on unseen motions [% of the largest torque]; mean and standard deviation over seeds",
        heads,
        rows,
    )
