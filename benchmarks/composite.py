"""An implicit step of the composite with an inertia against one of LuGre, on three motions of a ball screw."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, side_by_side

# A ball screw of 5 mm lead in micrometres and mN*m.
UM = 2.0 * math.pi / 5000.0
J, STEP = 0.1 * UM, 1e-5
SLIDING = {"F_C": 100.0, "F_S": 130.0, "v_S": 0.3 / UM, "sigma_1": 100.0 * UM, "sigma_2": 2.0 * UM}
STIFFNESS, SATURATION = 1e5 * UM, 156.0


def composite() -> Iterator[Ratio]:
    """Time the implicit step of Preisach-LuGre, by case and slip law."""
    from bristle import friction, plants
    from bristle.engine import run_open_loop

    lugre = friction.lugre(sigma_0=STIFFNESS, **SLIDING)
    inertia, pulled = plants.inertia(M=J), plants.pulled_inertia(M=J, k=20.0, v_e=200.0)
    t = STEP * np.arange(40_000)
    cases = {
        "pre-sliding": (inertia, 70.0 * np.sin(20.0 * np.pi * t) + 40.0 * np.sin(54.0 * np.pi * t)),
        "break-away": (inertia, 160.0 * np.sin(20.0 * np.pi * t[:30_000])),
        "stick-slip": (pulled, np.zeros(25_000)),
    }
    for transition in ("elastoplastic", "paper", "leuven"):
        model = friction.preisach_lugre(
            s=STIFFNESS, f_p=SATURATION, **SLIDING, transition=transition
        )
        for case, (plant, effort) in cases.items():
            ours, theirs, ratio = side_by_side(
                lambda plant=plant, effort=effort, model=model: run_open_loop(
                    plant, model, effort, STEP
                ),
                lambda plant=plant, effort=effort: run_open_loop(plant, lugre, effort, STEP),
                25,
            )
            count = effort.size
            yield Ratio(
                f"composite ({transition}), {case}",
                ours / count,
                theirs / count,
                ratio,
                1.75,
                "a step of LuGre",
            )
