"""The best of three identified models, with a passive residual model if held-out blocks gain by it."""

from __future__ import annotations

import warnings

import numpy as np

from benchmarks.board import log_of
from benchmarks.passive import Passive, Rows
from benchmarks.residual import Extended, deciding_gain
from bristle.engine.motion import along
from bristle.prediction import effort_of_motion

NEEDS = ("numba",)


def fit(train):
    """Return the model, and the residual model; None if it gains too little."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = Extended.of([log_of(record) for record in train], train[0].axis)
    gain = deciding_gain(Passive, model.rows, [])
    return model, Passive().fit(Rows.joined(model.rows)) if gain.percent > gain.spread else None


def predict(fitted, motion):
    """Return the effort along a motion."""
    model, residual = fitted
    best, columns = model.found.best, {"time": motion.time, "position": motion.position}
    effort = effort_of_motion(
        best.plant, best.friction, columns, motion.axis, model.found.treatment
    )
    known = np.flatnonzero(np.isfinite(effort))
    effort = np.interp(np.arange(effort.size), known, effort[known])  # the ends are held
    if residual is None:
        return effort
    passive, count = _passive(model, motion), motion.time.size
    lossless = np.column_stack([motion.acceleration, np.ones(count)])
    return effort + np.column_stack([passive, lossless]) @ residual.weights


def feedforward(fitted, reference):
    """Return the friction along a desired motion."""
    model, residual = fitted
    passive = _passive(model, reference)
    return -passive[:, -1] + (
        0.0 if residual is None else passive @ residual.weights[: passive.shape[1]]
    )


def _passive(model, motion):
    """Return the passive columns along a motion: the residual forces, and the friction of the model with the sign reversed."""
    v, dt = np.ascontiguousarray(motion.velocity), motion.sample_time
    friction = along(
        model.found.best.friction, v, dt, np.ascontiguousarray(motion.position) + 0.5 * dt * v
    )
    return np.column_stack([*model.grid.columns(v, dt), -friction])
