"""How long a person waits: models identified from measured logs, whole commands from their start to the report."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.timing import BRISTLE, EXAMPLES, Ratio, command, python, wall

__all__ = ["fits"]

A_FIT, A_COMPARISON = 10.0, 60.0  # [s]
RUNS = 3
REFINED = "stribeck_free+position+periodic+asymmetry"


class Job(NamedTuple):
    """A command: its name here, logs within the folder of measured logs, axis file, models, options, limit [s]."""

    name: str
    logs: tuple[str, ...]
    axis: str
    model: str
    options: tuple[str, ...] = ()
    most: float | None = A_FIT


EMPS = ("emps/DATA_EMPS.mat",)
LOOP = ("--method", "output_error")
JOBS = (
    *(
        Job(f"EMPS, {one}", EMPS, "emps/axis.toml", one)
        for one in ("lugre", "maxwell_slip", "gms", "preisach_lugre")
    ),
    Job(f"EMPS, {REFINED}", EMPS, "emps/axis.toml", REFINED),
    Job(
        "EMPS in its loop, stribeck_free+asymmetry",
        EMPS,
        "emps/axis.toml",
        "stribeck_free+asymmetry",
        LOOP,
    ),
    Job(f"EMPS in its loop, {REFINED}", EMPS, "emps/axis.toml", REFINED, LOOP),
    Job("EMPS, all models", EMPS, "emps/axis.toml", "all", most=A_COMPARISON),
    Job(
        "bouc_wen, bouc_wen_classic",
        ("bouc_wen/train.h5",),
        "bouc_wen/axis.toml",
        "bouc_wen_classic",
    ),
    Job(
        "tribometer, maxwell_slip+position",
        ("tribometer/test_data_2.txt",),
        "tribometer/axis.toml",
        "maxwell_slip+position",
    ),
)
DAMPER = "friction_damper/brfd_all.npz"
TESTS = r"dataset-{}__.*__([\d.]+)Hz{}lb"
FAST = 2.0  # [Hz]: predicted, not fitted
SMALLEST, LARGEST = (1, 80), (2, 30)  # groups: set and tension [lb]


def fits() -> Iterator[Ratio]:
    """Time identification where BRISTLE_DATA names measured logs; compiled code lies in the cache."""
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        print("fits: skipped, BRISTLE_DATA is not set")
        return
    data, beside = Path(folder), wall(python("import numpy, numba, scipy.signal"))
    for job in (*JOBS, *_of_the_damper(data / DAMPER)):
        with tempfile.TemporaryDirectory() as out:
            run = command(
                BRISTLE,
                "identify",
                *(str(data / one) for one in job.logs),
                "--axis",
                str(EXAMPLES / job.axis),
                "--model",
                job.model,
                "--out",
                f"{out}/out",
                "--force",
                *job.options,
            )
            run()
            yield _row(job.name, min(wall(run) for _ in range(RUNS)), beside, job.most)
    yield _of_nine_tests(data / DAMPER, beside)


def _row(name: str, ours: float, beside: float, most: float | None) -> Ratio:
    against = "import numpy, numba, scipy.signal"
    return Ratio(name, ours, beside, ours / beside, None, against, f"best of {RUNS}", most=most)


def _tests(file: Path, place: int, tension: int) -> list[str]:
    import numpy as np

    wanted = re.compile(TESTS.format(place, tension))
    found = {one: wanted.match(one) for one in np.load(file).files}
    return [one for one, match in found.items() if match and float(match[1]) < FAST]


def _of_the_damper(file: Path) -> Iterator[Job]:
    """The tests of one set and tension, each held out in turn: two of them, and nine, which is nine fits more."""
    for group, most in ((SMALLEST, A_FIT), (LARGEST, None)):
        logs = tuple(f"{DAMPER}::{one}" for one in _tests(file, *group))
        name = f"damper, gap_slider+asymmetry, {len(logs)} tests in turn"
        yield Job(name, logs, "friction_damper/axis.toml", "gap_slider+asymmetry", most=most)


def _of_nine_tests(file: Path, beside: float) -> Ratio:
    """The largest group of tests, fitted once."""
    import bristle as br
    from bristle.files import read_axis

    axis = read_axis(EXAMPLES / "friction_damper" / "axis.toml")
    logs = [br.read_log(f"{file}::{one}", axis) for one in _tests(file, *LARGEST)]
    ours = min(
        wall(lambda: br.identify(logs, "gap_slider+asymmetry", axis=axis, blocks=0, draws=0))
        for _ in range(RUNS)
    )
    return _row(f"damper, gap_slider+asymmetry, {len(logs)} tests, one fit", ours, beside, A_FIT)
