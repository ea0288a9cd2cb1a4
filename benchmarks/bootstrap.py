"""What intervals cost: 500 fits of elements that slip to simulated logs, against fitting each of them afresh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.coverage import AXIS, FITTED, MAXWELL, motion, recorded
from benchmarks.timing import Ratio, wall
from bristle.identification.bootstrap import bootstrap as resampled
from bristle.identification.element_models import Elements
from bristle.identification.fixed_shape import shaped
from bristle.identification.parameters import parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.request import prior_knowledge_of
from bristle.models.friction import find

__all__ = ["bootstrap"]

DRAWS, RUNS = 500, 3
AFRESH = 10


def bootstrap() -> Iterator[Ratio]:
    """Time 500 draws of the bootstrap of a fit by non-negative least squares, the treatment of each log included."""
    log = recorded(MAXWELL, motion(*FITTED, pairs=11), seed=0)
    component, known = find("maxwell_slip"), prior_knowledge_of(AXIS, None, None, log.kind)
    dataset = treat(log, AXIS)

    def elements() -> Elements:
        prototype = shaped(component, np.ones(1), np.ones(1))
        return Elements(dataset, component, parameters_of(prototype, known, dataset))

    problem, solution = elements().all_elements()
    resampled(problem, solution, 20)
    afresh = DRAWS * min(wall(lambda: elements().all_elements()) for _ in range(AFRESH))
    ours = min(wall(lambda: resampled(problem, solution, DRAWS)) for _ in range(RUNS))
    yield Ratio(
        f"{DRAWS} draws, {len(log)} samples, {len(solution.space.names)} columns",
        ours,
        afresh,
        ours / afresh,
        None,
        "as many fits from scratch",
        "best of 3",
        most=2.0,
    )
