"""Coulomb friction and inertia, by least squares."""

import numpy as np


def columns(record):
    return np.column_stack([record.acceleration, np.sign(record.velocity)])


def fit(train):
    matrix = np.vstack([columns(record) for record in train])
    effort = np.concatenate([record.effort for record in train])
    return np.linalg.lstsq(matrix, effort, rcond=None)[0]


def predict(fitted, motion):
    return columns(motion) @ fitted


def feedforward(fitted, reference):
    return fitted[1] * np.sign(reference.velocity)


def parameters(fitted):
    return {"M": fitted[0], "F_C": fitted[1]}
