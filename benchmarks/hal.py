"""A step of a component of LinuxCNC against the same step in C with the flags of a release.

The component has the flags of halcompile, which make code small, and its pins are volatile. On the other side, the same function
of a component has plain numbers as pins, and calls the C export, a unit of its own. Therefore both sides extrapolate the
command, scale, ramp and limit. The last column states what this work adds to the bare step of the C export.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.exported import DT, ripple
from benchmarks.timing import Ratio, busy_side_by_side

if TYPE_CHECKING:
    from bristle.core.contracts import Model

STEPS, RUNS, LIMIT = 20_000, 50, 1.2
SLOTS = ("position", "periodic", "load", "temperature", "asymmetry")
RELEASE = ("-O3", "-DNDEBUG", "-ffp-contract=off")
CODE = re.compile(r"#include <stdint\.h>\n.*?(?=#pragma pop_macro)", re.DOTALL)
CALLED = """#include <stdint.h>
#include <stdbool.h>
#include "stage.h"
static inline bool is_finite(double x) { return x - x == 0.0; }
"""


def hal() -> Iterator[Ratio]:
    """Time the component in place of HAL, along a ripple on a slow sine: each model, without and with all slots."""
    import bristle as br
    from bristle.contract import example_of
    from bristle.models.friction import with_slots

    for name, component in br.friction.MODELS.items():
        for label, slots in (("", ()), (" with slots", SLOTS)):
            model = example_of(with_slots(component, slots) if slots else component)
            with tempfile.TemporaryDirectory() as place:
                yield _cost(f"{name}{label}, a HAL component", model, Path(place))


def _cost(label: str, model: Model, place: Path) -> Ratio:
    from tests.apps.targets.linuxcnc import Component
    from tests.exports.native import Native

    from bristle.apps.targets import hal as target
    from bristle.exports.described import Request

    files = target.write(Request(model, "stage", DT, rest="held")).files
    native = Native({"stage": model}, place / "c", optimise="-O3", more=("-DNDEBUG",))
    text, cut = CODE.subn(lambda _: CALLED, str(files["stage.comp"]))
    assert cut == 1
    unit, plain = place / "c" / "out_stage", place / "plain"
    plain.mkdir()
    component = Component(files, place)
    in_c = Component(
        {"stage.comp": text},
        plain,
        more=[*RELEASE, "-Dvolatile=", f"-I{unit}", f"{unit / 'stage.c'}"],
    )
    x = ripple()[:STEPS]

    def feed(component: Component) -> np.ndarray:
        return component.feed(x, round(1e9 * DT), gain=1.0, slew=1e9, scale=1.0)

    differing = np.count_nonzero(feed(component).view(np.int64) != feed(in_c).view(np.int64))
    ours, theirs, ratio = busy_side_by_side(lambda: feed(component), lambda: feed(in_c), RUNS)
    _, bare, to_bare = busy_side_by_side(
        lambda: feed(component), lambda: native.forces("stage", x, DT), RUNS
    )
    remark = f"{differing} of {STEPS} feeds differ; {to_bare:.2f} of a bare step, adds {1e9 * (ours - bare) / STEPS:.0f} ns"
    return Ratio(label, ours / STEPS, theirs / STEPS, ratio, LIMIT, "C", remark)
