"""Run a study: simulate the missing blocks of its folder."""

import time
import warnings
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bristle.apps.study.block import FAILED, Simulator, row_of
from bristle.apps.study.plan import Block, Study
from bristle.apps.study.store import Runs, Store, opened
from bristle.apps.study.workers import Cluster, Here, Make, OwnCluster
from bristle.core import (
    InputError,
    InputWarning,
    MissingExtraError,
    Progress,
    core_count,
    guarded,
    optional,
    whole,
)
from bristle.simulation import SimulationResult

WORKERS = optional(whole(1))


@dataclass(frozen=True)
class Ran:
    """Result of running a study."""

    before: int
    lost: tuple[Block, ...]

    @property
    def is_whole(self) -> bool:
        """Whether all runs are complete."""
        return not self.lost


@guarded()
def run_study(
    study: Study,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    provenance: Mapping[str, str] | None = None,
) -> Ran:
    """Run the missing blocks of a study, and store them in a folder.

    Parameters
    ----------
    study : Study
        The study.
    folder : path
        A new folder, or the folder of the same study: bristle then runs only the missing blocks.
    workers : int, optional
        Number of processes; with 1, this process does the work. By default the number of cores, or threads of this process
        if it simulates runs in batches. Without the extra ``study``, threads of this process instead of processes.
    scheduler : str, optional
        Address of the scheduler of a Dask cluster, ``tcp://HOST:PORT``; its workers simulate instead of this machine.
    progress : callable, optional
        Called with the share done and the remaining time.
    provenance : mapping of str to str, optional
        Versions, files and checksums behind the study.

    Returns
    -------
    Ran
        Number of blocks that were complete before, and the blocks whose workers crashed.

    Raises
    ------
    InputError
        If another process writes there, the folder has other content, the disk is full, or no scheduler answers.
    """
    with opened(Path(folder), study, provenance or {}) as store:
        return run_within(store, workers=workers, scheduler=scheduler, progress=progress)


def run_within(
    store: Store,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    simulator: Make = Simulator,
) -> Ran:
    """Run the missing blocks of a study in its folder, locked by this process; see `run_study`."""
    workers = WORKERS(workers, "workers", None)
    if scheduler is not None and workers is not None:
        raise InputError(
            "cannot be chosen together with a scheduler",
            path="workers",
            value=workers,
            mend="Remove workers or scheduler",
        )
    study = store.study
    present = store.blocks_present()
    missing = [block for block in study.blocks if block.first not in present]
    before = study.count - sum(block.count for block in missing)
    if progress is not None:
        progress(before / study.count, f"{before} of {study.count} runs")
    if not missing:
        return Ran(len(present), ())
    crew = _crew(study, len(missing), workers, scheduler, simulator)
    ran = 0  # runs of this command
    at_first = 0  # of them in the first block
    started = time.monotonic()
    left = ""  # estimate of the remaining time
    with closing(crew.results(missing)) as results:  # any exit ends the workers
        for block, columns in results:
            store.write(block, columns)
            ran += block.count
            if at_first:
                left = f", {in_words((time.monotonic() - started) * (study.count - before - ran) / (ran - at_first))} left"
            else:  # the first block includes the start of the workers: no estimate yet
                at_first = ran
                started = time.monotonic()
            if progress is not None:
                progress(
                    (before + ran) / study.count, f"{before + ran} of {study.count} runs{left}"
                )
    return Ran(len(present), tuple(crew.lost))


def _crew(
    study: Any, missing: int, workers: int | None, scheduler: str | None, make: Make
) -> Cluster | Here:
    """Return the simulator of the missing blocks."""
    if scheduler is not None:
        return Cluster(study, make, scheduler)
    if workers is None and make is Simulator:
        simulator = Simulator(study)
        if simulator.in_batches:  # threads start faster than processes
            return Here(simulator.columns, core_count())
    count = min(workers or core_count(), missing)
    if count > 1:
        try:
            return OwnCluster(study, make, count)
        except MissingExtraError as error:
            if workers is not None:
                warnings.warn(
                    f"{error}. Until then, threads of one process do the work",
                    InputWarning,
                    stacklevel=2,
                )
    return Here(make(study).columns, count)


def in_words(seconds: float) -> str:
    """Return a time in words.

    Examples
    --------
    >>> in_words(0.4), in_words(42.0), in_words(600.0), in_words(20_000.0)
    ('1 s', '42 s', '10 min', '5.6 h')
    """
    if seconds < 90.0:
        return f"{max(seconds, 1.0):.0f} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"


def repeat_run(study: Study, number: int) -> SimulationResult:
    """Return one run of a study, simulated again with its signals."""
    if not 0 <= number < study.count:
        raise InputError(
            "is not a run of this study",
            path="--run",
            value=number,
            allowed=f"0 to {study.count - 1}",
        )
    return Simulator(study).run(number)


def values_of(study: Study, number: int) -> dict[str, Any]:
    """Return the values of a run, by dotted key in SI."""
    return row_of(study.values(Block(number, number + 1)), 0)


def worst_runs(runs: Runs, count: int) -> list[int]:
    """Return the numbers of the runs with the largest first metric, the worst first; of equal runs, the earlier first."""
    metric = runs.columns[runs.described["metrics"][0]]
    usable = np.flatnonzero(np.isfinite(metric) & ~np.isin(runs.columns["status"], FAILED))
    order = usable[np.argsort(-metric[usable], kind="stable")][:count]
    return runs.columns["run"][order].astype(int).tolist()
