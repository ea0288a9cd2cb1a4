"""The six stop operators of adaptive_hysteresis, with weights from the log in place of learning on line."""

from __future__ import annotations

import numpy as np

from benchmarks.board.record import smoothed
from bristle import hysteresis
from bristle.core import non_negative
from bristle.engine import response

COUNT = 6


def stops(position, reach):
    """Return the outputs of stop operators, between -1 and 1, after a motion; thresholds divide the reach evenly."""
    thresholds = reach / COUNT * np.arange(1, COUNT + 1)
    operators = (
        hysteresis.prandtl_ishlinskii(thresholds=[threshold], weights=[1.0 / threshold])
        for threshold in thresholds
    )
    return np.column_stack([response(operator, position - position[0]) for operator in operators])


def columns(record, reach):
    """Return both signs of constant and inertia, and the stop operators."""
    ones = np.ones(record.time.size)
    return np.column_stack(
        [ones, -ones, record.acceleration, -record.acceleration, stops(record.position, reach)]
    )


def fit(train):
    reach = max(float(np.ptp(record.position)) for record in train)
    trials = []
    for share in np.geomspace(0.02, 1.0, 12):  # the reach of pre-sliding is searched on a grid
        rows, efforts = [], []
        for record in train:
            inner = slice(record.edge, -record.edge)
            rows.append(
                smoothed(columns(record, share * reach), record.sample_time, record.axis)[inner]
            )
            efforts.append(smoothed(record.effort, record.sample_time, record.axis)[inner])
        matrix, effort = np.vstack(rows), np.concatenate(efforts)
        weights = non_negative(matrix, effort)
        trials.append((np.sum((effort - matrix @ weights) ** 2), share * reach, weights))
    return min(trials, key=lambda trial: trial[0])[1:]


def predict(fitted, motion):
    reach, weights = fitted
    return columns(motion, reach) @ weights


def feedforward(fitted, reference):
    reach, weights = fitted
    kept = [0, 1, *range(4, 4 + COUNT)]
    return columns(reference, reach)[:, kept] @ weights[kept]
