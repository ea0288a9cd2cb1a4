"""The gradient of a sum over the forces of a long walk, in reverse mode, against the walk itself: both in compiled C."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.timing import Ratio, busy_side_by_side

STEPS, DT, RUNS = 100_000, 1e-3, 7
LIMITS = {"lugre": 10.0, "dahl": 10.0}
LIMIT = 20.0  # of the other models


def gradients() -> Iterator[Ratio]:
    """Time the gradient with respect to all positions and parameters."""
    from bristle.contract import example_of
    from bristle.exports import CompiledWalk
    from bristle.models.friction import MODELS

    time, random = DT * np.arange(STEPS), np.random.default_rng(3)
    x = 1e-4 * np.sin(6.0 * np.pi * time) * np.sin(0.37 * time) + 1e-7 * np.cumsum(
        random.standard_normal(STEPS)
    )
    for name in MODELS:
        compiled = CompiledWalk(example_of(MODELS[name]))
        around = [np.full(STEPS, usual) for usual in compiled.signals.values()]
        inputs = [
            compiled.start,
            x,
            np.array([DT]),
            np.concatenate(list(compiled.parameters.values())),
            *around,
        ]
        results, adjoints = (
            [np.empty_like(part) for part in inputs[:2]],
            [np.empty_like(part) for part in inputs],
        )
        bars = [np.zeros_like(compiled.start), random.standard_normal(STEPS)]

        def reverse(compiled=compiled, inputs=inputs, bars=bars, adjoints=adjoints) -> None:
            compiled.run("walk_reverse", 1, STEPS, [*inputs, *bars], adjoints)

        def forward(compiled=compiled, inputs=inputs, results=results) -> None:
            compiled.run("walk", 1, STEPS, inputs, results)

        ours, theirs, ratio = busy_side_by_side(reverse, forward, RUNS)
        finite = all(np.isfinite(part).all() for part in adjoints)
        fault = "" if finite else "not finite"
        yield Ratio(
            f"{name}, gradient of a step",
            ours / STEPS,
            theirs / STEPS,
            ratio,
            LIMITS.get(name, LIMIT),
            "walk",
            fault,
        )
