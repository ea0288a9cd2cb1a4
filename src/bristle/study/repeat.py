"""One run of a study again, with its signals; and the signals of its worst runs."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.simulation import SimulationResult
from bristle.study.block import FAILED, Simulator
from bristle.study.dataset import Runs
from bristle.study.plan import Block, Study
from bristle.study.store import TRACES, Store
from bristle.study.varied import row_of

__all__ = ["repeat_run", "values_of", "worst_runs", "write_traces"]

SIGNALS = ("time", "reference", "measured", "position", "velocity", "command", "effort", "feedforward", "friction")


def repeat_run(study: Study, number: int) -> SimulationResult:
    """Return one run of a study, simulated again with its signals."""
    if not 0 <= number < study.count:
        raise InputError("is no run of this study", path="--run", value=number, allowed=f"0 to {study.count - 1}")
    return Simulator(study).run(number)


def values_of(study: Study, number: int) -> dict[str, Any]:
    """Return what a run is made with, by dotted key in SI."""
    return row_of(study.values(Block(number, number + 1)), 0)


def worst_runs(runs: Runs, count: int) -> list[int]:
    """Return the numbers of the worst runs, the worst first: those with the largest first metric.

    Runs without numbers, which failed, are not among them; of equal ones the earlier comes first.
    """
    metric = runs.columns[runs.described["metrics"][0]]
    usable = np.flatnonzero(np.isfinite(metric) & ~np.isin(runs.columns["status"], FAILED))
    order = usable[np.argsort(-metric[usable], kind="stable")][:count]
    return runs.columns["run"][order].astype(int).tolist()


def write_traces(store: Store, numbers: list[int]) -> list[str]:
    """Write the signals of runs into the folder of their study, a file for each; return the names of the files."""
    simulator, names = Simulator(store.study), []
    for number in numbers:
        result = simulator.run(number)
        columns: dict[str, Any] = {"variant": []}
        for variant in result.variants.values():
            columns["variant"] += [variant.name] * variant.time.size
        for signal in SIGNALS:
            columns[signal] = np.concatenate([getattr(variant, signal) for variant in result.variants.values()])
        name, sink = f"{TRACES}/{number:010d}.parquet", io.BytesIO()
        store.parquet.write_table(store.pyarrow.table(columns), sink)
        store.grown.write(name, sink.getvalue())
        names.append(name)
    return names
