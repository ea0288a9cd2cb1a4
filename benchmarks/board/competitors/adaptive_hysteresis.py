"""The law of the loop with six stop operators that learn on line; their first weights are those of `stops`."""

from __future__ import annotations

from benchmarks.board.competitors.stops import COUNT, fit
from benchmarks.board.of_bristle import gains
from bristle import controllers

__all__ = ["feedforward", "fit"]

RATE, LARGEST = 8.0, 2.0  # [1/s] of the learning; times the largest first weight


def feedforward(fitted, reference):
    (reach, weights), loop = fitted, gains(reference)
    first = {"w_0": weights[0] - weights[1]} | {
        f"w_{number}": weights[3 + number] for number in range(1, COUNT + 1)
    }
    learning = {
        "Gamma": RATE * loop["J"] * loop["K_1"],
        "delta": loop["K_1"] * reference.axis.resolution,
    }
    return controllers.adaptive_hysteresis(
        **loop, **first, **learning, reach=reach, w_max=LARGEST * max(map(abs, first.values()))
    )
