"""A step of an exported model in C, against one of the same model here, which is handed the velocity in place of both.

C makes the velocity of two positions, looks whether its inputs are numbers, and keeps its state in a structure.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.timing import Ratio, busy_side_by_side

MODELS = ("lugre", "dahl", "elastoplastic", "maxwell_slip", "gms", "preisach_lugre")
# Those of a release by the CMakeLists.txt of an export.
FLAGS = ("-O3", "-DNDEBUG", "-std=c99", "-ffp-contract=off")
STEPS, DT, RUNS, LIMIT = 50_000, 5e-4, 25, 1.15
LOOP = """
#include "axis_x.h"
void run(const double *x, int count, double dt, double *force)
{
    static axis_x axis;
    axis_x_start(&axis);
    for (int i = 0; i < count; ++i) {
        force[i] = axis_x_force(&axis, x[i], dt);
    }
}
"""


def ripple() -> np.ndarray:
    """Return positions [m] of a ripple on a slow sine."""
    time = DT * np.arange(STEPS)
    return 5e-5 * np.sin(2.0 * np.pi * time) + 2e-6 * np.sin(2.0 * np.pi * 17.0 * time)


def exported() -> Iterator[Ratio]:
    """Time the C of models that the compiler of this machine made, along a ripple on a slow sine."""
    import bristle as br
    from bristle.contract import example_of
    from bristle.engine import force_along

    x = ripple()
    v = np.diff(x) / DT
    pointer = ctypes.POINTER(ctypes.c_double)
    for name in MODELS:
        model, force = example_of(br.friction.MODELS[name]), np.empty(STEPS)
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            br.export(model, "c", folder / "axis")
            (folder / "run.c").write_text(LOOP, encoding="ascii")
            # Two units, as a firmware has them: the step is called, not taken into the loop.
            line = [
                "gcc",
                *FLAGS,
                "-shared",
                "-fPIC",
                "-Iaxis",
                "axis/axis_x.c",
                "run.c",
                "-o",
                "axis.so",
                "-lm",
            ]
            subprocess.run(line, cwd=folder, check=True)
            run = ctypes.CDLL(str(folder / "axis.so")).run

            def in_c(run=run, force=force) -> None:
                run(
                    x.ctypes.data_as(pointer),
                    STEPS,
                    ctypes.c_double(DT),
                    force.ctypes.data_as(pointer),
                )

            def here(model=model) -> np.ndarray:
                return force_along(model, v, DT, x[1:])

            ours, theirs, ratio = busy_side_by_side(in_c, here, RUNS)
            differing = np.count_nonzero(force[1:].view(np.int64) != here().view(np.int64))
        yield Ratio(
            f"{name}, a step in C",
            ours / STEPS,
            theirs / STEPS,
            ratio,
            LIMIT,
            "compiled Python",
            f"{differing} of {STEPS} forces differ",
        )
