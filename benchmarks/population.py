"""One generation of the global search over an open loop: as one batch, against one simulation after the other.

Both use all cores and give the same bits. What is timed is the work of all cores together, the least of many runs: what
else the machine does is no part of it. A generation is thirty sets of parameters on one period of an effort, run in
for another one with one step for a sample, as the search looks at them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.timing import Ratio, busy_side_by_side

MEMBERS, RUNS, DT = 30, 25, 1.0 / 750.0
LENGTHS = (500, 1500, 4000)


def population() -> Iterator[Ratio]:
    """Time the simulations of a generation."""
    from bristle import friction, plants
    from bristle.core.cores import abreast
    from bristle.simulation.recorded.open_loop import LEADS, OpenLoop

    rng = np.random.default_rng(7)
    plant = plants.oscillator(M=2.0, c=40.0, k=5e4)
    models = {
        "Bouc-Wen": lambda: friction.bouc_wen_classic(alpha=4e4 * rng.uniform(0.5, 2.0), beta=1e3, gamma=0.9, delta=0.3),
        "LuGre": lambda: friction.lugre(F_C=rng.uniform(2.0, 8.0), F_S=9.0, v_S=1e-3, sigma_0=1e5, sigma_1=300.0),
    }
    for name, model in models.items():
        members = [(plant, model()) for _ in range(MEMBERS)]
        for length in LENGTHS:
            effort = 20.0 * np.sin(2.0 * np.pi * 7.0 * np.arange(length) / length)
            loop = OpenLoop(effort, 1, DT, length, periodic=True, leads=LEADS[:1])

            def batch(loop: Any = loop, members: Any = members) -> np.ndarray:
                return loop.positions(*zip(*members, strict=True))

            def alone(loop: Any = loop, members: Any = members) -> np.ndarray:
                return np.stack(abreast(lambda member: loop.position(*member)[0])(members))

            ours, theirs, ratio = busy_side_by_side(batch, alone, RUNS)
            same = np.array_equal(batch(), alone(), equal_nan=True)
            yield Ratio(
                f"{MEMBERS} sets of {name}, {length} samples",
                ours,
                theirs,
                ratio,
                1.0,
                "one run after the other",
                "the same bits" if same else "OTHER NUMBERS",
            )
