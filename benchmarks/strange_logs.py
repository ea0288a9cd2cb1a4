"""Do 95 % intervals hold the truth on logs of axes that another hand simulated, with nothing said of them?

The axes, their drives and their records are those of `benchmarks.strangers`, which shares no code with the package:
efforts that are late or held either way, channel filters, periodic errors of the encoder, gravity, cogging.
``python -m benchmarks.strange_logs 60000 100 lugre`` asks about seeds and a family of one's own.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np

import bristle as br
from benchmarks.coverage import Share
from benchmarks.strangers import Record, Truth, make
from bristle.core.cores import core_count
from bristle.core.errors import InputError

__all__ = ["StrangeLog", "strange_logs", "table_of", "tried"]

LOGS, DRAWS = 100, 100
MODELS = {"coulomb": "coulomb_viscous", "lugre": "lugre"}
MOVES = 0.01  # of the largest speed
STROKES = ("strokes", "multisine", "cycle")  # what shows inertia and sliding friction at all


class StrangeLog(NamedTuple):
    """What was found on one log: why it was refused, or the relative error of M [%], and what intervals hold."""

    refused: str
    mass_error: float
    inside: dict[str, bool]
    identified: int


def table_of(truth: Truth, record: Record) -> dict[str, np.ndarray]:
    """Return a record as columns in SI: what a person has who knows the force constant of the motor."""
    return {
        "time": record.t,
        "position": record.position,
        "effort": record.effort * truth.recording.force_per_effort,
    }


def true_values(truth: Truth, record: Record) -> dict[str, float]:
    """Return the parameters of the same friction laws, as the mean of both directions where they differ.

    By how much friction differs by direction pushes to one side as an offset does, damping by its mean where it moves.
    """
    law, speed = truth.friction, np.abs(np.gradient(record.position, record.t))
    moving = np.mean(speed[speed > MOVES * np.max(speed)])
    by_direction = (np.diff(law.F_C)[0] + np.diff(law.F_v)[0] * moving) / 2.0
    values = {name: float(np.mean(getattr(law, name))) for name in ("F_C", "F_S", "F_v")}
    return values | {
        "M": truth.mass,
        "v_S": law.v_S,
        "sigma_0": law.sigma_0,
        "sigma_1": law.sigma_1,
        "sigma_2": values["F_v"],
        "offset": truth.axis.gravity - float(by_direction),
    }


def tried(family: str, seed: int) -> StrangeLog:
    """Identify one log of a family with nothing told but whether it turns."""
    truth, record = make(seed, family, STROKES[seed % len(STROKES)])
    axis = br.Axis(kind="translational" if truth.axis.linear else "rotational")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = br.identify(
                table_of(truth, record), MODELS[family], axis=axis, blocks=0, draws=DRAWS
            )
        except InputError as error:
            return StrangeLog(str(error), np.nan, {}, 0)
    known, inside = true_values(truth, record), {}
    for name, estimate in found.parameters.items():
        if estimate.status == "identified" and estimate.interval is not None and name in known:
            inside[name] = bool(estimate.interval[0] <= known[name] <= estimate.interval[1])
    mass = found.parameters["M"].value
    return StrangeLog("", 100.0 * (mass / truth.mass - 1.0), inside, len(inside))


def strange_logs(
    first: int = 0, count: int = LOGS, families: Iterable[str] = MODELS
) -> Iterator[Share]:
    """Coverage of the intervals of each family on logs of seeds from the `first` on, pooled and by parameter."""
    with ProcessPoolExecutor(core_count()) as pool:
        for family in families:
            trials = list(pool.map(tried, [family] * count, range(first, first + count)))
            read = [trial for trial in trials if not trial.refused]
            every = [inside for trial in read for inside in trial.inside.values()]
            errors = np.array([trial.mass_error for trial in read])
            remark = f"error of M: {np.median(errors):.2f} % (median), {np.sqrt(np.mean(errors**2)):.2f} % (rms)"
            yield Share(
                f"{family}, pooled", 100.0 * float(np.mean(every)), 90.0, 98.0, len(every), remark
            )
            for parameter in dict.fromkeys(name for trial in read for name in trial.inside):
                inside = [trial.inside[parameter] for trial in read if parameter in trial.inside]
                yield Share(
                    f"{family}, {parameter}",
                    100.0 * float(np.mean(inside)),
                    85.0,
                    100.0,
                    len(inside),
                )
            yield Share(
                f"{family}, read", 100.0 * len(read) / len(trials), 100.0, 100.0, len(trials)
            )


if __name__ == "__main__":
    first, count, *families = sys.argv[1:]
    for share in strange_logs(int(first), int(count), families or MODELS):
        print(share.row(), flush=True)
