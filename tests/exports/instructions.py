"""Instructions of a step on a Cortex-M, its code and its stack, of one build: what the page on the export says of them.

``python -m tests.exports.instructions [MODEL ...]``: a row for each model and core, along a motion of hard cases. It
fails if a step takes more than ten times the median, or 5 % more than files state; with ``--write``, files state the counts.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from tests.apps.targets.other_targets import FLAGS, TARGETS
from tests.exports.native import example_with

import bristle as br
from bristle.exports.subject import PART, RESTS, SEED, subject_of, walk_of

STATED = Path(br.exports.__file__).parent / "templates" / "shared" / "instructions.json"
STEPS, DT = 20_000, 5e-4
WORST = 10.0  # times the median: what a step may take
SHIFT = 10  # an instruction takes 2 to the power of this [ns], which the timer of 25 MHz resolves
TICKS = 2**SHIFT / 40.0
NOT_IN_A_STEP = ("_save", "_load", "_start")
CORES = {"Cortex-M7": False, "Cortex-M4F": True}
"""The cores, and whether single precision is counted there."""


class Count(NamedTuple):
    """Instructions of a step, in the mean, in the median and at most, in which step that is; bytes of code; of stack.

    All of one object file. That of the stack is the sum over all functions that a step may call, as if each called the
    next.
    """

    mean: float
    median: float
    worst: float
    step: int
    code: int
    stack: int


def counted(model: br.core.Model, core: str, folder: Path, steps: int = STEPS) -> Count:
    """Return what a step of a model costs on a core."""
    target, single = TARGETS[core], CORES[core]
    br.export(model, "c", folder, step=DT, float32=single)
    subject = subject_of(model)
    call = "axis_x_output(axis, x)" if subject.is_operator else f"axis_x_force(axis, x, {DT!r})"
    scales = ", ".join(repr(scale) for scale in walk_of(subject, DT).scales)
    lines = {
        "AXIS": "axis_x",
        "START": "axis_x_start",
        "SCALES": f"{{{scales}}}",
        "CALL(axis, x)": call,
        "STEPS": f"{steps}U",
        "SEED": f"{SEED}U",
        "RESTS": f"{RESTS}U",
        "PART": f"{PART}U",
    }
    text = [
        '#include "axis_x.h"',
        *(f"#define {name} {value}" for name, value in lines.items()),
        "",
    ]
    (folder / "walk.h").write_text("\n".join(text), encoding="ascii")
    built = [*target.build, *FLAGS, "-I."]
    _said([*built, "-fstack-usage", "-c", "axis_x.c", "-o", "axis_x.o"], folder)
    start = _said([*target.build[:5], "-print-file-name=rdimon-crt0.o"], folder)
    count = Path(target.further[0]).with_name("count.c")
    _said([*built, "axis_x.o", str(count), *target.further, start, "-o", "count", "-lm"], folder)
    size = (
        _said([target.build[0].replace("gcc", "size"), "axis_x.o"], folder)
        .splitlines()[1]
        .split()[0]
    )
    mean, median, worst, step = (
        int(number)
        for number in _said(
            [*target.run[:-1], "-icount", f"shift={SHIFT}", target.run[-1], "count"], folder
        ).split()
    )
    frames = [
        line.split("\t") for line in (folder / "axis_x.su").read_text(encoding="ascii").splitlines()
    ]
    stack = sum(int(size) for place, size, _ in frames if not place.endswith(NOT_IN_A_STEP))
    return Count(mean / TICKS, median / TICKS, worst / TICKS, step, int(size), stack)


def _said(command: list[str], folder: Path) -> str:
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise RuntimeError(f"{' '.join(command)}: {(ran.stdout + ran.stderr)[-800:]}")
    return ran.stdout.strip()


def main() -> int:
    """Count, tell, and return 1 if a step takes too long or not what files state; with ``--write``, let files state it."""
    models, wrong = [name for name in sys.argv[1:] if name != "--write"], []
    stated = json.loads(STATED.read_text(encoding="ascii"))
    for core, single in CORES.items():
        if TARGETS[core].lacking:
            print(f"{core}: not counted, for {TARGETS[core].lacking} is not here")
            continue
        print(
            f"{core}, {'single' if single else 'double'} precision, {' '.join(FLAGS)}, {STEPS} steps"
        )
        for name in models or br.friction.MODELS:
            with tempfile.TemporaryDirectory() as place:
                result = counted(example_with(name), core, Path(place) / "out")
            told = [round(result.median), round(result.worst)]
            is_stated = told[1] <= 1.05 * stated[core].get(name, told)[1]
            wrong += [name] if result.worst > WORST * result.median or not is_stated else []
            stated[core][name] = told
            print(
                f"  {name}: mean {result.mean:.0f}, median {told[0]}, worst {told[1]} (step {result.step}), "
                f"{result.code} B of code, {result.stack} B of stack{'' if is_stated else '; files state less'}"
            )
    if "--write" in sys.argv:
        STATED.write_text(
            json.dumps(stated).replace("], ", "],\n").replace("{", "{\n") + "\n", encoding="ascii"
        )
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
