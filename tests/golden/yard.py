"""Write a folder with all files that the golden command lines read."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import scipy.io
from tests.cli import conftest as bench
from tests.golden import logs, simulated
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.cli.demonstration import axis_simulated
from bristle.files import read_experiment
from bristle.logs.log import Log
from bristle.simulation import simulate

LUGRE = """
schema = 1
kind = "rotational"

[friction]
model = "lugre"
F_C = "100 mN*m"
F_S = "130 mN*m"
v_S = "0.3 rad/s"
sigma_0 = "100 N*m/rad"
sigma_1 = "0.1 N*m*s/rad"
"""
COMPOSITE = (
    LUGRE.replace('"lugre"', '"preisach_lugre"').replace("sigma_0", "s")
    + 'f_p = "156 mN*m"\nsigma_2 = "0.03 N*m*s/rad"\n'
)
CURVES = """
schema = 1
name = "loops"
kind = "translational"

[columns]
input = { column = "x", unit = "um" }
output = { column = "F", unit = "N" }
"""
STUDY = """
schema = 1
experiment = "experiment.toml"
runs = 6
seed = 1
block = 4

[vary]
"friction.F_C" = { uniform = ["6 N", "10 N"] }

[grid]
"plant.M" = ["19 kg", "21 kg"]

[keep]
metrics = ["following_error.rms", "effort.peak"]
"""
PLAIN = """
schema = 1
name = "plain"
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "m" }
effort = { column = "u", unit = "N" }
"""
LEARNING = """
[controller.learning]
trials = 3
k_e = "1e5 N/m"
cutoff = "40 Hz"
"""
_CONTROLLER = bench.AXIS.index("[controller]")
_COMPARED = bench.EXPERIMENT.index("[compare")
_RUN = bench.EXPERIMENT.index("[run]")
TEXTS = {
    "axis.toml": bench.AXIS,
    "bare.toml": bench.AXIS[:_CONTROLLER],
    "loop.toml": bench.AXIS.replace("[effort]", '[effort]\nlag = "identify"').replace(
        "[identification]", '[identification]\nmethod = "output_error"'
    ),
    "late.toml": PLAIN + '[timing]\ndelay = "identify"\n',
    "pulls.toml": PLAIN + '[encoder]\nresolution = "20 nm"\n',
    "curves.toml": CURVES,
    "reversals.toml": CURVES.replace('"x"', '"column_1"').replace('"F"', '"column_2"')
    + '[log]\ntables = "curve_*"\n\n[curves]\nstart = "saturated"\n',
    "experiment.toml": bench.EXPERIMENT,
    "study.toml": STUDY,
    "seeds.toml": bench.EXPERIMENT.replace("[run]", "[run]\nseeds = 2"),
    "learning.toml": bench.EXPERIMENT[:_RUN] + LEARNING + bench.EXPERIMENT[_RUN:_COMPARED],
    "diverging.toml": bench.EXPERIMENT.replace('"4 N*s/mm"', '"400 N*s/mm"').replace(
        'limit = "300 N"', ""
    ),
    "model.toml": bench.MODEL,
    "own.py": bench.USER_MODEL,
    "lugre.toml": LUGRE,
    "composite.toml": COMPOSITE,
}


@cache
def _kept() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="golden")  # cleared when the process ends


@cache
def yard() -> Path:
    """Return the folder; what commands write goes there too."""
    folder = Path(_kept().name)
    for name, text in TEXTS.items():
        (folder / name).write_text(text)
    shutil.copyfile(axis_simulated.AXIS_FILE, folder / "axis_of_demo.toml")
    shutil.copyfile(logs.EXAMPLES / "bouc_wen" / "axis.toml", folder / "ringing.toml")
    shutil.copytree(logs.EXAMPLES / "tune", folder / "machine")
    _write_loop(folder)
    late = simulated.late()
    _write_rows(folder / "late.csv", late)
    _write_rows(folder / "slower.csv", replace(late, effort=1.1 * np.asarray(late.effort)))
    _write_rows(folder / "pulls.csv", simulated.pulled(simulated.pulling()))
    motion = sines(12.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    _write_rows(
        folder / "cogged.csv",
        log_of(
            motion,
            sliding_effort(motion, 0) + 5.0 * np.sin(200.0 * np.pi * motion.position),
            step=1e-7,
        ),
    )
    steady = simulated.ringing()
    assert steady.effort is not None
    np.savez(folder / "ringing.npz", u=steady.effort.values, y=steady.position.values)
    _write_curves(folder)
    return folder


def _write_loop(folder: Path) -> None:
    """Write the log of the bench, once whole, once with holes, and once as MAT with a constant."""
    variants = simulate(read_experiment(folder / "experiment.toml")).variants
    columns, fed = (
        np.column_stack((variant.time, variant.measured, variant.reference, variant.effort))
        for variant in (
            variants["none"],
            next(item for name, item in variants.items() if name != "none"),
        )
    )
    for name, rows in {"log.csv": columns, "second.csv": columns[:4000], "fed.csv": fed}.items():
        np.savetxt(folder / name, rows, delimiter=",", header="t,q,r,u", comments="", fmt="%.9g")
    (folder / "parts").mkdir(exist_ok=True)
    for day in range(6):
        name = folder / "parts" / f"2026-03-0{day + 1}.csv"
        # The first has another gain of the drive.
        rows = columns[500 * day : 500 * day + 3000] * (1.0, 1.0, 1.0, 1.0 if day else 1.5)
        np.savetxt(name, rows, delimiter=",", header="t,q,r,u", comments="", fmt="%.9g")
    lines = (folder / "log.csv").read_text().splitlines()
    for row in (100, 300):
        lines[row] = lines[row].rpartition(",")[0] + ",nan"
    (folder / "holes.csv").write_text("\n".join(lines))
    np.savetxt(folder / "nameless.txt", columns, fmt="%.9g")
    scipy.io.savemat(
        folder / "constants.mat", {"t": columns[:, 0], "q": columns[:, 1], "gain": 35.0}
    )


def _write_rows(path: Path, log: Log) -> None:
    assert log.effort is not None
    columns = np.column_stack((log.time.values, log.position.values, log.effort.values))
    np.savetxt(path, columns, delimiter=",", header="t,q,u", comments="", fmt="%.12g")


def _write_curves(folder: Path) -> None:
    rng = np.random.default_rng(11)
    (curve,) = simulated.recorded(
        simulated.MASING, simulated.to_and_fro(rng, turns=40, samples=600), rng
    ).curves
    np.savetxt(
        folder / "curves.csv",
        np.column_stack(curve),
        delimiter=",",
        header="x,F",
        comments="",
        fmt="%.9g",
    )
    curves = {
        f"curve_{k:02}": np.column_stack(item)
        for k, item in enumerate(simulated.reversal_curves(simulated.MASING, 21))
    }
    np.savez(folder / "reversals.npz", **curves)
