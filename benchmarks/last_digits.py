"""Does a status or a verdict change where a log changes in its last digits?

Two measured logs and three of axes of another simulator; every column is moved by up to 1e-13 of its range, 40 times.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.rigs import Gains, drawn, motion
from bristle.logs.log import Log
from bristle.report.judgement import judged

__all__ = ["last_digits", "moved", "told_of"]

EXAMPLES = Path(__file__).parents[1] / "examples"
TIMES, SHARE = 40, 1e-13
MODELS = {"one": "coulomb_viscous,stribeck+asymmetry,lugre", "other": "stribeck,lugre+asymmetry"}


def columns_of(log: Log) -> dict[str, np.ndarray]:
    """Return the columns of a log in SI."""
    columns = {
        "time": log.time.values,
        "position": log.position.values,
        "effort": log.effort.values,
    }
    return columns | ({} if log.reference is None else {"reference": log.reference.values})


def moved(columns: dict[str, np.ndarray], rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Return the columns with all but the time changed in their last digits."""
    return {
        name: values
        if name == "time"
        else values + SHARE * np.ptp(values) * rng.uniform(-1.0, 1.0, values.size)
        for name, values in columns.items()
    }


def told_of(columns: dict[str, np.ndarray], models: str, axis: br.Axis) -> dict[str, Any]:
    """Return every status, each verdict with its reasons, and the order of the models."""
    found = br.identify(columns, models, axis=axis, draws=0, blocks=0)
    statuses = {
        (fit.name, name): estimate.status
        for fit in found.fits
        for name, estimate in fit.parameters.items()
    }
    verdicts = {}
    for fit in found.fits:
        verdict = judged(fit, found.settings, None)
        verdicts[fit.name] = (
            verdict.level,
            tuple(str(reason).translate(WITHOUT_DIGITS) for reason in verdict.reasons),
        )
    return {"statuses": statuses, "verdicts": verdicts, "order": [fit.name for fit in found.fits]}


WITHOUT_DIGITS = str.maketrans("", "", "0123456789.")


def logs() -> Iterator[tuple[str, dict[str, np.ndarray], str, br.Axis]]:
    """Yield name, columns, models and axis of each log."""
    data = os.environ.get("BRISTLE_DATA")
    if data:
        for folder, file in (("emps", "DATA_EMPS.mat"), ("servo_pendulum", "arm_200g.json")):
            axis = br.read_axis(EXAMPLES / folder / "axis.toml")
            columns = columns_of(br.read_log(Path(data) / folder / file, axis))
            yield file, columns, MODELS["one"], br.Axis(kind=axis.kind)
    else:
        print("last_digits: skips the measured logs, BRISTLE_DATA is not set")
    for seed in (31, 32, 33):
        rig = drawn(seed)
        reference = motion(rig, 8.0, seed, 0.02, 0.05)
        record = rig.run(Gains(60.0, 250.0 * rig.mass, 6000.0 * rig.mass), reference)
        columns = {
            "time": rig.dt * np.arange(reference.size),
            "position": record.position,
            "effort": record.effort,
        }
        yield (
            f"simulated {seed}",
            columns,
            MODELS["other"],
            br.Axis(kind="translational", resolution=rig.resolution),
        )


def last_digits() -> Iterator[Share]:
    """Count logs, changed in their last digits, with the statuses and verdicts of the log as it is."""
    for name, columns, models, axis in logs():
        rng, as_it_is = np.random.default_rng(7), told_of(columns, models, axis)
        same, changed = 0, set()
        for _ in range(TIMES):
            told = told_of(moved(columns, rng), models, axis)
            same += told == as_it_is
            changed |= {part for part in told if told[part] != as_it_is[part]}
        note = f"changed: {', '.join(sorted(changed))}" if changed else models
        yield Share(
            f"unchanged by last digits, {name}", 100.0 * same / TIMES, 100.0, 100.0, TIMES, note
        )
