"""Least squares of inertia, Coulomb and viscous friction and a constant, on filtered columns."""

from __future__ import annotations

import numpy as np

from benchmarks.board.record import smoothed

NAMES = ("M", "sigma_2", "offset", "F_C")


def columns(record, *shapes):
    """Return the regressors of a record: inertia, viscous friction, constant, Coulomb friction, other shapes, known terms."""
    v = record.velocity
    terms = [np.sin(record.position), np.cos(record.position)] if record.axis.gravity else []
    terms += [record.position] if record.axis.spring else []
    return np.column_stack([record.acceleration, v, np.ones(v.size), np.sign(v), *shapes, *terms])


def solved(train, shape):
    """Return the coefficients and the sum of squared residuals; a known mass is held."""
    rows, efforts = [], []
    for record in train:
        stride = max(
            round(0.1 / (record.axis.cutoff or 0.1 / record.sample_time) / record.sample_time), 1
        )
        inner = slice(record.edge, -record.edge, stride)
        rows.append(
            smoothed(columns(record, *shape(record)), record.sample_time, record.axis)[inner]
        )
        efforts.append(smoothed(record.effort, record.sample_time, record.axis)[inner])
    matrix, effort, mass = np.vstack(rows), np.concatenate(efforts), train[0].axis.mass
    held, mass = int(mass is not None), mass or 0.0
    target = effort - mass * matrix[:, 0]
    coefficients = np.linalg.lstsq(matrix[:, held:], target, rcond=None)[0]
    left = target - matrix[:, held:] @ coefficients
    return np.concatenate([np.full(held, mass), coefficients]), float(left @ left)


def fit(train):
    return solved(train, lambda record: ())[0]


def predict(fitted, motion):
    return columns(motion) @ fitted


def feedforward(fitted, reference):
    return columns(reference)[:, 1:] @ fitted[1:]


def parameters(fitted):
    return dict(zip(NAMES, fitted, strict=False))
