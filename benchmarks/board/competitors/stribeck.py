"""Least squares with a Stribeck curve, whose velocity is searched on a grid."""

from __future__ import annotations

import numpy as np

from benchmarks.board.competitors.least_squares import columns, solved

GRID = 30  # Stribeck velocities, up to the largest speed


def shape(record, v_S):
    return (np.sign(record.velocity) * np.exp(-((record.velocity / v_S) ** 2)),)


def fit(train):
    fastest = max(float(np.max(np.abs(record.velocity))) for record in train)
    trials = {}
    for v_S in fastest * np.geomspace(1e-3, 0.5, GRID):
        trials[v_S] = solved(train, lambda record, v_S=v_S: shape(record, v_S))
    best = min(trials, key=lambda v_S: trials[v_S][1])
    return trials[best][0], best


def predict(fitted, motion):
    return columns(motion, *shape(motion, fitted[1])) @ fitted[0]


def feedforward(fitted, reference):
    return columns(reference, *shape(reference, fitted[1]))[:, 1:] @ fitted[0][1:]


def parameters(fitted):
    M, sigma_2, offset, F_C, fall = fitted[0][:5]
    return {
        "M": M,
        "F_C": F_C,
        "F_S": F_C + fall,
        "v_S": fitted[1],
        "sigma_2": sigma_2,
        "offset": offset,
    }
