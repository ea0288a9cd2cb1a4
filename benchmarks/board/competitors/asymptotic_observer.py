"""The law of the loop with the reduced-order observer of friction, for the level and the stiffness of a Dahl model of the log."""

from __future__ import annotations

import math

from benchmarks.board.of_bristle import OBSERVED, gains, identified, numbers
from bristle import controllers

BAND = 2.0  # encoder steps: a reversal


def fit(train):
    return numbers(identified(train, "dahl"))


def feedforward(fitted, reference):
    loop, contact = gains(reference), {name: fitted[name] for name in ("F_C", "sigma_0")}
    slow = OBSERVED * loop["K_1"]
    # The condition of real eigenvalues.
    fast = 1.001 * (slow + 2.0 * math.sqrt(2.0 * contact["sigma_0"] / loop["J"]))
    return controllers.asymptotic_observer(
        **loop, **contact, g_1=slow, g_2=fast, band=BAND * reference.axis.resolution
    )
