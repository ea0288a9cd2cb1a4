"""Competitors of bristle itself: identified models, their effort along a motion, their feedforward and parameters."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.board.record import Record, log_of
from bristle.core import Feedforward
from bristle.identification import identify
from bristle.prediction import effort_of_motion
from bristle.simulation import feedforward_effort

OBSERVED = 0.4  # bandwidth of an observer, of that of the loop
NAMES = {"s": "sigma_0", "F_v": "sigma_2"}  # names of some models, and those of the scores


def identified(train: Sequence[Record], models: str) -> Any:
    """Return the identification of the best of these models, without intervals."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # No second pass, which would fit everything again with further lines of the axis.
        logs = [log_of(record) for record in train]
        return identify(logs, models, axis=train[0].axis, draws=0, settings={"lines_gain": 1.0})


def effort(identification: Any, motion: Record) -> np.ndarray:
    """Return the effort of the best model along a motion."""
    columns = {"time": motion.time, "position": motion.position}
    predicted = effort_of_motion(
        identification.best.plant,
        identification.best.friction,
        columns,
        motion.axis,
        identification.treatment,
    )
    inside = np.flatnonzero(np.isfinite(predicted))
    return np.interp(np.arange(predicted.size), inside, predicted[inside])  # the ends are held


def friction_force(identification: Any, reference: Record, **changes: str) -> np.ndarray:
    """Return the friction of the best model, with some other parameters, along a desired motion."""
    fed = Feedforward(friction=identification.best.friction.with_values(**changes))
    return feedforward_effort(
        fed, reference.position, reference.acceleration, reference.sample_time
    )


def numbers(identification: Any) -> dict[str, float]:
    """Return the parameters of the best model."""
    values = {**identification.best.plant.values, **identification.best.friction.values}
    sides = {
        name: [values[f"{name}_{side}"] for side in ("pos", "neg")]
        for name in ("F_C", "F_S", "sigma_2")
        if f"{name}_pos" in values
    }
    values |= {name: np.mean(pair) for name, pair in sides.items()} | {
        new: values[old] for old, new in NAMES.items() if old in values
    }
    if "k_i" in values:
        values["sigma_0"] = float(np.sum(values["k_i"]))
    return {
        name: float(value)
        for name, value in values.items()
        if np.ndim(value) == 0 and not isinstance(value, str)
    }


def gains(reference: Record) -> dict[str, Any]:
    """Return inertia, gains and cut-off of the law in the loop of a desired motion."""
    law = reference.axis.controller
    assert law is not None
    return {name: law.values[name] for name in ("J", "lambda_", "K_1", "cutoff")}
