"""A step of a component of LinuxCNC against a step of the same model in C, which has no pins, no look-ahead and no ramp.

The component has the flags of halcompile, which make code small; the C has those of a release.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.exported import DT, MODELS, RUNS, STEPS, ripple
from benchmarks.timing import Ratio, busy_side_by_side


def hal() -> Iterator[Ratio]:
    """Time the component in place of HAL, along a ripple on a slow sine."""
    from tests.exports.linuxcnc import Component
    from tests.exports.native import Native

    import bristle as br
    from bristle.exports import hal as target
    from bristle.exports.targets import Request
    from bristle.testing import example_of

    x = ripple()
    for name in MODELS:
        model = example_of(br.friction.MODELS[name])
        with tempfile.TemporaryDirectory() as place:
            component = Component(target.write(Request(model, "axis_x", DT, rest="held")).files, Path(place))
            native = Native({"axis_x": model}, Path(place) / "c", optimise="-O3", more=("-DNDEBUG",))

            def in_hal(component=component) -> np.ndarray:
                return component.feed(x, round(1e9 * DT), gain=1.0, scale=1.0)

            def in_c(native=native) -> np.ndarray:
                return native.forces("axis_x", x, DT)

            ours, theirs, ratio = busy_side_by_side(in_hal, in_c, RUNS)
        yield Ratio(
            f"{name}, a step of a HAL component",
            ours / STEPS,
            theirs / STEPS,
            ratio,
            None,
            "C",
            f"adds {1e9 * (ours - theirs) / STEPS:.0f} ns",
        )
