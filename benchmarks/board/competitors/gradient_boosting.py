"""Gradient-boosted trees on velocity, acceleration, position and the travel since the last reversals."""

from __future__ import annotations

import numpy as np

from benchmarks.board.record import smoothed

NEEDS = ("sklearn",)
MOST = 20_000  # rows
CALM = 0.01  # of the largest speed: slower samples keep their direction


def features(record, *, acceleration=True):
    """Return the features of a motion: local memory only, of the last two reversals."""
    v, x, index = record.velocity, record.position, np.arange(record.time.size)
    moving = np.where(np.abs(v) > CALM * np.max(np.abs(v)), index, 0)
    direction = np.sign(v[np.maximum.accumulate(moving)])
    turn = np.concatenate([[False], np.diff(direction) != 0.0])
    last = np.maximum.accumulate(np.where(turn, index, 0))
    before = last[np.maximum(last - 1, 0)]
    a = record.acceleration if acceleration else np.zeros(v.size)
    return np.column_stack([v, a, x, np.sin(x), direction, x - x[last], x[last] - x[before]])


def rows(train):
    inner = [slice(record.edge, -record.edge) for record in train]
    X = np.vstack([features(record)[part] for record, part in zip(train, inner, strict=True)])
    y = np.concatenate(
        [
            smoothed(record.effort, record.sample_time, record.axis)[part]
            for record, part in zip(train, inner, strict=True)
        ]
    )
    stride = max(len(X) // MOST, 1)
    return X[::stride], y[::stride]


def fit(train):
    from sklearn.ensemble import HistGradientBoostingRegressor

    return HistGradientBoostingRegressor(max_iter=300, learning_rate=0.05, random_state=0).fit(
        *rows(train)
    )


def predict(fitted, motion):
    return fitted.predict(features(motion))


def feedforward(fitted, reference):
    return fitted.predict(features(reference, acceleration=False))
