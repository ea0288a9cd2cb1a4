"""A small neural network, two layers of 32, on the features of the gradient-boosted trees."""

from __future__ import annotations

import numpy as np

from benchmarks.board.competitors.gradient_boosting import features, rows

NEEDS = ("sklearn",)


def fit(train):
    from sklearn.neural_network import MLPRegressor
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    X, y = rows(train)
    scale = float(np.std(y))
    network = make_pipeline(
        StandardScaler(),
        MLPRegressor(
            hidden_layer_sizes=(32, 32), early_stopping=True, max_iter=200, random_state=0
        ),
    )
    return network.fit(X, y / scale), scale


def predict(fitted, motion):
    return fitted[1] * fitted[0].predict(features(motion))


def feedforward(fitted, reference):
    return fitted[1] * fitted[0].predict(features(reference, acceleration=False))
