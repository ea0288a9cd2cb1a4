"""Do `identify`, `run` and `design` promise the same following error for one file? Ten axes of another simulator."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.coverage import Share
from benchmarks.rigs import Gains, Rig, drawn, motion
from benchmarks.timing import BRISTLE

__all__ = ["described", "one_loop"]

AXES, MOST, SEED = 10, 5.0, 700  # MOST [%]
REACH, SPEED, DURATION = 0.02, 0.05, 12.0
LAGS = (0.0, 4e-4, 8e-4)


def described(
    rig: Rig, gains: Gains, folder: Path, reference: np.ndarray, *, lag: bool = True
) -> None:
    """Write the log of an axis and its axis file into a folder."""
    record, t = rig.run(gains, reference), rig.dt * np.arange(reference.size)
    columns = np.column_stack([t, record.position, record.reference, record.effort])
    np.savetxt(folder / "log.csv", columns, "%.10g", ",", header="t,q,r,u", comments="")
    stated = f'lag = "{rig.lag:.9g} s"\n' if lag and rig.lag else ""
    (folder / "axis.toml").write_text(
        'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\n'
        'position = { column = "q", unit = "m" }\nreference = { column = "r", unit = "m" }\n'
        f'effort = {{ column = "u", unit = "N" }}\n[effort]\nheld = true\n{stated}'
        f'[encoder]\nresolution = "{rig.resolution:g} m"\n[plant]\noffset = "identify"\n'
        '[controller]\nmodel = "cascade"\n'
        f'k_p = "{gains.k_p:.9g} 1/s"\nk_v = "{gains.k_v:.9g} N*s/m"\nk_i = "{gains.k_i:.9g} N/m"\n',
        encoding="utf-8",
    )


def bristle(*arguments: str, folder: Path) -> dict[str, object]:
    """Return what a command of bristle prints as JSON."""
    ran = subprocess.run(
        [BRISTLE, *arguments, "--json"], cwd=folder, capture_output=True, text=True, check=False
    )
    if ran.returncode not in (0, 1):
        raise RuntimeError(ran.stderr)
    return json.loads(ran.stdout)


def one_loop() -> Iterator[Share]:
    """Compare what three commands promise of the loop with friction fed forward, on ten axes."""
    for number in range(AXES):
        rig = replace(drawn(SEED + number), lag=LAGS[number % len(LAGS)], delay=0)
        fast = 250.0
        gains = Gains(0.25 * fast, rig.mass * fast, 0.1 * rig.mass * fast**2)
        model = ("lugre", "stribeck+asymmetry", "maxwell_slip", "coulomb_viscous")[number % 4]
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            described(rig, gains, folder, motion(rig, DURATION, SEED + number, REACH, SPEED))
            fit = ("--axis", "axis.toml", "--model", model, "--draws", "0", "--out", "found")
            said = bristle("identify", "log.csv", *fit, folder=folder)
            ran = bristle("run", "found/experiment.toml", folder=folder)
            designed = bristle("design", "found/experiment.toml", folder=folder)
        errors = (
            said["compensation"]["compensated"]["following_error"]["peak_to_peak"],
            ran["variants"]["compensated"]["following_error"]["peak_to_peak"],
            designed["budget"]["everything"]["peak_to_peak"],
        )
        apart = max(errors) / min(errors) - 1.0
        micro = " / ".join(f"{1e6 * error:.3g}" for error in errors)
        yield Share(
            f"predictions differ, axis {number}",
            100.0 * apart,
            0.0,
            MOST,
            3,
            f"{model}: {micro} um",
        )
