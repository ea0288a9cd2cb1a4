"""A study on two workers of a Dask cluster on this machine, beside two of its own: a block, a run, a whole study."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

from benchmarks.study import LOOP, RIG, STUDY
from benchmarks.timing import Ratio

WORKERS, PAIRS = 2, 3
BLOCKS, LARGE = 200, 200_000
QUICK = RIG.replace('duration = "1 s"', 'duration = "10 ms"')


def cluster() -> Iterator[Ratio]:
    """Time what the way to the workers and back costs, from the first block on: how workers begin is told apart."""
    import distributed

    from bristle.study import read_study_file
    from bristle.study.cluster import Cluster

    with (
        distributed.LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None) as there,
        tempfile.TemporaryDirectory() as name,
    ):
        folder, address = Path(name), there.scheduler_address

        def plan(rig: str, runs: int, level: float, spread: float, block: int | None) -> Any:
            (folder / "rig.toml").write_text(rig)
            text = STUDY.format(runs=runs, level=level, spread=spread)
            (folder / "study.toml").write_text(
                text if block is None else text.replace("seed", f"block = {block}\nseed")
            )
            return read_study_file(folder / "study.toml")

        single = plan(QUICK, BLOCKS, 1, 0.1, 1)
        ours, theirs, ratio = _beside(single, folder, address)
        yield Ratio("a block of one run of 10 steps", ours, theirs, ratio, None, "two workers of this machine",
                    f"{1.0 / ours:.0f} blocks a second reach the disk")  # fmt: skip
        many = plan(QUICK, LARGE, 1, 0.1, None)
        ours, theirs, ratio = (seconds / many.block for seconds in _beside(many, folder, address))
        yield Ratio("a run of 10 steps, in its block", ours, theirs, ours / theirs, None,
                    "two workers of this machine", f"{many.block} runs a block")  # fmt: skip
        loops = plan(LOOP, 400, 12, 0.5, None)
        ours, theirs, ratio = (seconds / loops.block for seconds in _beside(loops, folder, address))
        yield Ratio("a closed loop of 80 000 steps, in its block", ours, theirs, ours / theirs, 1.15,
                    "two workers of this machine", f"{loops.block} runs a block")  # fmt: skip

        def meet() -> float:
            begin = time.perf_counter()
            with Cluster(loops, address):
                return time.perf_counter() - begin

        seconds = statistics.median(meet() for _ in range(PAIRS))
        yield Ratio("connecting, and asking two workers", seconds, seconds, 1.0, None, "")


def _beside(study: Any, folder: Path, address: str) -> tuple[float, float, float]:
    """Return the time for each block on the cluster and on this machine [s], and the median of their ratios."""
    pairs = [
        (_each(study, folder, scheduler=address), _each(study, folder, workers=WORKERS)) for _ in range(PAIRS)
    ]  # fmt: skip
    return (
        statistics.median(ours for ours, _ in pairs), statistics.median(theirs for _, theirs in pairs),
        statistics.median(ours / theirs for ours, theirs in pairs),
    )  # fmt: skip


_numbers = count()


def _each(study: Any, folder: Path, **how: Any) -> float:
    """Return the time for each block but the first of each worker [s]."""
    from bristle.study import run_study

    ends: list[float] = []

    def note(share: float, text: str) -> None:
        ends.append(time.perf_counter())

    run_study(study, folder / f"out_{next(_numbers)}", progress=note, **how)
    counted = ends[1 + WORKERS :]  # the first call comes before any block
    return (counted[-1] - counted[0]) / (len(counted) - 1)
