"""Run the benchmarks: ``python -m benchmarks [NAME ...]``. Print one line for each claim; exit code 1 if a claim fails.

``python -m benchmarks board --help`` shows what the score board takes.

Benchmarks on measured logs read the folder named in BRISTLE_DATA.
"""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from benchmarks.actuators import actuators
from benchmarks.board.command import main as board
from benchmarks.bootstrap import bootstrap
from benchmarks.cluster import cluster
from benchmarks.composite import composite
from benchmarks.corners import corners
from benchmarks.coverage import Share, coverage
from benchmarks.elastic import elastic
from benchmarks.exported import exported
from benchmarks.fits import fits
from benchmarks.frequency_stiffness import frequency_stiffness
from benchmarks.gradients import gradients
from benchmarks.hal import hal
from benchmarks.lanes import lanes
from benchmarks.last_digits import last_digits
from benchmarks.lies import lies
from benchmarks.loop_coverage import loop_coverage
from benchmarks.observer import observer
from benchmarks.one_loop import one_loop
from benchmarks.open_loop import open_loop
from benchmarks.preisach import preisach
from benchmarks.presliding import presliding
from benchmarks.pushes import pushes
from benchmarks.readers import readers
from benchmarks.rotors import rotors
from benchmarks.second_records import second_records
from benchmarks.stick_slip import stick_slip
from benchmarks.strange_logs import strange_logs
from benchmarks.structure import structures
from benchmarks.study import study
from benchmarks.timing import BRISTLE, EXAMPLES, HEAD, Ratio, command, python, side_by_side, wall
from benchmarks.tracking import tracking
from benchmarks.unstated_lag import unstated_lag
from benchmarks.wind_up import wind_up

HERE = Path(__file__).parent


def lugre() -> Iterator[Ratio]:
    """Time the LuGre trial loop against the same scheme in C."""
    from bristle import engine, friction

    count = 1_000_000
    generator = np.random.default_rng(5)
    v = 1e-3 * np.cumsum(generator.standard_normal(count)) / 30.0
    force_c = np.empty(count)
    for label, v_d in (
        ("constant micro-damping", float("inf")),
        ("micro-damping falls with speed", 5e-3),
    ):
        model = friction.lugre(
            F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4, v_d=v_d
        )
        with tempfile.TemporaryDirectory() as folder:
            library = Path(folder) / "lugre.so"
            subprocess.run(
                [
                    "gcc",
                    "-O3",
                    "-shared",
                    "-fPIC",
                    "-o",
                    str(library),
                    str(HERE / "lugre.c"),
                    "-lm",
                ],
                check=True,
            )
            run = ctypes.CDLL(str(library)).lugre_run
            parameters = (ctypes.c_double * 7)(*model.parameters)
            pointer = ctypes.POINTER(ctypes.c_double)

            def in_c(run=run, parameters=parameters, pointer=pointer) -> None:
                z = ctypes.c_double(0.0)
                run(
                    parameters,
                    ctypes.byref(z),
                    v.ctypes.data_as(pointer),
                    ctypes.c_double(1e-5),
                    force_c.ctypes.data_as(pointer),
                    ctypes.c_size_t(count),
                )

            def in_bristle(model=model) -> np.ndarray:
                return engine.force_along(model, v, 1e-5, v)

            ours, theirs, ratio = side_by_side(in_bristle, in_c, 15)
            difference = np.max(np.abs(in_bristle() - force_c))
        yield Ratio(
            f"LuGre step, {label}",
            ours / count,
            theirs / count,
            ratio,
            1.3,
            "the same scheme in C, gcc -O3",
            f"largest difference {difference:.1e} N of {np.max(np.abs(force_c)):.2f} N",
        )


def start_up() -> Iterator[Ratio]:
    """Time the start of bristle, against importing numpy.

    One claim is absolute: with a full cache, a process returns its first result within a second of its start (median of
    nine processes).
    """
    numpy = python("import numpy")
    yield Ratio(
        "import bristle", *side_by_side(python("import bristle"), numpy, 15), 3.0, "import numpy"
    )
    yield Ratio(
        "bristle --help", *side_by_side(command(BRISTLE, "--help"), numpy, 15), 4.5, "import numpy"
    )
    with tempfile.TemporaryDirectory() as cache:
        code = (
            "import numpy as np\nfrom bristle import friction, response\n"
            "response(friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5), np.linspace(0, 1e-3, 100), 1e-3)"
        )
        second = python(code, BRISTLE_CACHE_DIR=cache)
        yield Ratio(
            "second process, until its first result",
            *side_by_side(second, python("import numpy, numba"), 9),
            None,
            "import numpy, numba",
            "from process start, median of 9; the limit is in seconds",
            most=1.0,
        )


def identify() -> Iterator[Ratio]:
    """Time the main job on a real log, report included, against importing what it is built on."""
    data = os.environ.get("BRISTLE_DATA")
    if not data:
        print("identify: skipped, BRISTLE_DATA is not set")
        return
    with tempfile.TemporaryDirectory() as folder:
        for model in ("coulomb_viscous", "coulomb_viscous+asymmetry"):
            job = command(
                BRISTLE,
                "identify",
                f"{data}/emps/DATA_EMPS.mat",
                "--axis",
                str(EXAMPLES / "emps" / "axis.toml"),
                "--model",
                model,
                "--out",
                f"{folder}/out",
                "--force",
                "--json",
            )
            beside = python("import numpy, numba, scipy.signal")
            yield Ratio(
                f"identify EMPS, {model}, with report",
                *side_by_side(job, beside, 9),
                4.0,
                "import numpy, numba, scipy.signal",
            )


def demo() -> Iterator[Ratio]:
    """Time the demonstration, start of the process and report included: the first on a machine, and a later one.

    The first run compiles its kernels, and is timed once. Of the later runs with a full cache, the best of three counts.
    Neither has a limit: they show how long a new user waits.
    """
    with tempfile.TemporaryDirectory() as folder:
        job = command(
            BRISTLE,
            "demo",
            "--out",
            f"{folder}/out",
            "--force",
            BRISTLE_CACHE_DIR=f"{folder}/cache",
        )
        cold = wall(job)
        warm = min(wall(job) for _ in range(3))
    beside = wall(python("import numpy, numba, scipy.signal"))
    yield Ratio(
        "demo, cold cache",
        cold,
        beside,
        cold / beside,
        None,
        "import numpy, numba, scipy.signal",
        "one run, compiles",
    )
    yield Ratio(
        "demo, warm cache",
        warm,
        beside,
        warm / beside,
        None,
        "import numpy, numba, scipy.signal",
        "best of 3",
    )


def paper() -> Iterator[Ratio]:
    """Time the source paper, all of its figures and the report: the first time on a machine, and a later one.

    The limits are in seconds on two cores. The last column gives the number of compiled entries.
    """
    with tempfile.TemporaryDirectory() as folder:
        job = command(
            BRISTLE,
            "paper",
            "--out",
            f"{folder}/out",
            "--force",
            BRISTLE_CACHE_DIR=f"{folder}/cache",
        )
        cold, warm = wall(job), min(wall(job) for _ in range(2))
        compiled = sum(one.suffix == ".bin" for one in Path(folder, "cache").rglob("*"))
    beside = wall(python("import numpy, numba, scipy.signal"))
    against = "import numpy, numba, scipy.signal"
    yield Ratio(
        "paper, cold cache",
        cold,
        beside,
        cold / beside,
        None,
        against,
        f"{compiled} compiled entries",
        most=90.0,
    )
    yield Ratio(
        "paper, warm cache", warm, beside, warm / beside, None, against, "best of 2", most=30.0
    )


BENCHMARKS: dict[str, Callable[[], Iterator[Ratio]]] = {
    one.__name__: one
    for one in (
        lugre,
        preisach,
        composite,
        start_up,
        identify,
        demo,
        paper,
        lanes,
        actuators,
        stick_slip,
        open_loop,
        exported,
        gradients,
        hal,
        tracking,
        presliding,
        bootstrap,
        fits,
        readers,
        study,
        cluster,
    )
}
# No times but shares, of hundreds of identifications: half an hour, so only where it is asked for.
LONG: dict[str, Callable[[], Iterator[Share]]] = {
    one.__name__: one
    for one in (
        coverage,
        corners,
        loop_coverage,
        strange_logs,
        lies,
        structures,
        elastic,
        frequency_stiffness,
        one_loop,
        unstated_lag,
        pushes,
        last_digits,
        observer,
        rotors,
        wind_up,
        second_records,
    )
}


# Command lines of their own, which take the words behind their name.
COMMANDS: dict[str, Callable[[list[str]], int]] = {"board": board}


def main(names: list[str]) -> int:
    """Run the benchmarks of these names, or all but the long ones; or a command with the words behind its name."""
    if names and names[0] in COMMANDS:
        return COMMANDS[names[0]](names[1:])
    known = BENCHMARKS | LONG
    unknown = [name for name in names if name not in known]
    if unknown:
        print(
            f"unknown benchmark: {', '.join(unknown)}; allowed: {', '.join([*known, *COMMANDS])}",
            file=sys.stderr,
        )
        return 2
    print(HEAD)
    missed = 0
    for name in names or BENCHMARKS:
        for claim in known[name]():
            print(claim.row(), flush=True)
            missed += claim.missed
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
