"""A batch in lanes against the same run one by one, trajectory by trajectory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, side_by_side

TRAJECTORIES, SAMPLES, DT = 256, 500, 4e-4


def lanes() -> Iterator[Ratio]:
    """Time LuGre in lanes on one core; the ratio is of the time of one trajectory-step."""
    from bristle import friction, plants
    from bristle.engine import run_batch

    generator = np.random.default_rng(3)
    plant = plants.inertia(M=1.0)
    levels = 1.0 + 0.2 * generator.random(TRAJECTORIES)
    models = [
        friction.lugre(
            F_C=level, F_S=1.5 * level, v_S=1e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4
        )
        for level in levels
    ]
    effort = 2.5 * np.sin(40.0 * DT * np.arange(SAMPLES))

    implicit, one_by_one, _ = side_by_side(
        *(
            lambda in_lanes=in_lanes: run_batch(
                plant, models, effort, DT, threads=1, in_lanes=in_lanes
            )
            for in_lanes in (True, False)
        ),
        9,
    )
    yield Ratio(
        f"LuGre and a mass by EFIM, {TRAJECTORIES} in lanes",
        implicit / (SAMPLES * TRAJECTORIES),
        one_by_one / (SAMPLES * TRAJECTORIES),
        implicit / one_by_one,
        1.0 / 2.5,
        "one by one, on one core",
        "identical to the bit",
    )
