"""The law of the loop with a disturbance observer of 0.4 times its bandwidth, and without a model of friction."""

from __future__ import annotations

from benchmarks.board.of_bristle import OBSERVED, gains
from bristle import controllers


def fit(train):
    return None


def feedforward(fitted, reference):
    loop = gains(reference)
    return controllers.disturbance_observer(**loop, g=OBSERVED * loop["K_1"])
