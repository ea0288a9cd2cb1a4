"""The law of the loop with Stribeck's force ahead of each reversal, with the parameters of a LuGre model of the log."""

from __future__ import annotations

from benchmarks.board.of_bristle import gains, identified, numbers
from bristle import controllers

LEAD = 2.0  # samples


def fit(train):
    return numbers(identified(train, "lugre"))


def feedforward(fitted, reference):
    curve = {name: fitted[name] for name in ("F_C", "F_S", "v_S")} | {
        "F_v": fitted["sigma_2"],
        "x_0": fitted["F_C"] / fitted["sigma_0"],
    }
    return controllers.predictive_reversal(
        **gains(reference), **curve, lead=LEAD * reference.sample_time
    )
