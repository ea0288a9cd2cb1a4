"""Friction of 4096 axes in Warp on the processor: the time of one step of one axis, and the difference from bristle."""

from __future__ import annotations

import importlib
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.timing import Ratio, wall

AXES, SAMPLES, COMPARED, DT = 4096, 200, 16, 5e-4
MOST = 1e-6  # [s], for each step of an axis


def walked(friction, rows, velocity, out):
    """Step an actuator along the rows of a motion."""
    for row in rows:
        friction.force(row, DT, velocity, out)


def actuators() -> Iterator[Ratio]:
    """Time the exported actuator; the other program is `bristle.response`, one axis at a time."""
    import warp

    import bristle as br
    from bristle.contract import example_of
    from bristle.models.friction import MODELS

    warp.config.quiet = True
    x = np.cumsum(1e-6 * np.random.default_rng(11).standard_normal((SAMPLES, AXES)), axis=0)
    rows = [warp.array(row, dtype=warp.float64, device="cpu") for row in x]
    speed = warp.zeros(AXES, dtype=warp.float64, device="cpu")
    for name in ("maxwell_slip", "lugre", "preisach_lugre"):
        model = example_of(MODELS[name])
        with tempfile.TemporaryDirectory() as place:
            br.export(model, "warp", Path(place) / "out", name=f"timed_{name}")
            sys.path.insert(0, str(Path(place) / "out"))
            module = importlib.import_module(f"timed_{name}_warp")
            sys.path.pop(0)
            friction = module.Friction(AXES, "cpu")  # compiles the kernels
        out, forces = warp.empty(AXES, dtype=warp.float64, device="cpu"), np.empty_like(x)
        for at, row in enumerate(rows):
            forces[at] = friction.force(row, DT, out=out).numpy()
        expected = np.transpose([br.response(model, x[:, axis], DT) for axis in range(COMPARED)])
        difference = float(np.max(np.abs(forces[:, :COMPARED] - expected)))
        one_by_one = wall(
            lambda model=model: [br.response(model, x[:, axis], DT) for axis in range(COMPARED)]
        ) / (COMPARED * SAMPLES)
        for kind, velocity in (("", None), (", predicted", speed)):
            friction.reset()
            walk = partial(walked, friction, rows, velocity, out)
            ours = min(wall(walk) for _ in range(5)) / (AXES * SAMPLES)
            error = f"{1.0 / ours:.2g} steps/s; largest difference of a force {difference:g}"
            yield Ratio(
                f"{name}{kind}, {AXES} axes in Warp",
                ours,
                one_by_one,
                ours / one_by_one,
                None,
                "one axis at a time",
                error,
                MOST,
            )
