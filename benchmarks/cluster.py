"""A study on two workers of a Dask cluster on this machine, beside one process: a block, a run, a closed loop.

Told is the time of the processor, of all processes together: what else the machine does is no part of it, nor is what
scheduler and workers spend on waiting, which is told apart.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Any

from benchmarks.study import LOOP, RIG, STUDY
from benchmarks.timing import Ratio

WORKERS = 2
QUICK = RIG.replace('duration = "1 s"', 'duration = "10 ms"')
# Experiment, its friction and how that spreads [N], runs in a block, blocks of a small study and of a large one.
CASES = {
    "a block of one run of 10 steps": (QUICK, 1.0, 0.1, 1, (20, 120)),
    "a run of 10 steps, 4 096 in a block": (QUICK, 1.0, 0.1, 4096, (2, 8)),
    "a closed loop of 80 000 steps, 12 in a block": (LOOP, 12.0, 0.5, 12, (4, 16)),
}
WAITS = 5.0  # [s]
_numbers = count()


def cluster() -> Iterator[Ratio]:
    """Time what a study costs for each block that is added to it, so that how processes begin is no part of it."""
    from tests.apps.study.processes import DaskCluster, until

    with tempfile.TemporaryDirectory() as name, closing(DaskCluster(Path(name))) as there:
        parts = {
            "scheduler": [there.scheduler.pid],
            "workers": [there.worker("--no-nanny").pid for _ in range(WORKERS)],
        }
        until(lambda: len(there.joined()) == WORKERS, "two workers")
        idle = _idle(parts)
        spent = sum(idle.values())
        yield Ratio(
            "processor time of an idle second", spent, 1.0, spent, None, "a second of one core"
        )
        for label, (rig, level, spread, block, counts) in CASES.items():
            studies = [
                _study(Path(name), rig, level, spread, block, block * blocks) for blocks in counts
            ]
            # What is needed is compiled.
            _spent(studies[0], Path(name), idle, parts, scheduler=there.address)
            ours = _for_a_block(studies, Path(name), idle, parts, scheduler=there.address)
            theirs = _for_a_block(studies, Path(name), {}, {}, workers=1)
            shares = ", ".join(f"{part} {1e3 * seconds:.1f} ms" for part, seconds in ours.items())
            total, beside = sum(ours.values()), sum(theirs.values())
            yield Ratio(
                label,
                total / block,
                beside / block,
                total / beside,
                None,
                "one process; processor time",
                f"for each block: {shares}",
            )


def _study(folder: Path, rig: str, level: float, spread: float, block: int, runs: int) -> Any:
    from bristle.apps.study import read_study_file

    (folder / "rig.toml").write_text(rig)
    text = STUDY.format(runs=runs, level=level, spread=spread)
    (folder / "study.toml").write_text(text.replace("seed", f"block = {block}\nseed"))
    return read_study_file(folder / "study.toml")


def _for_a_block(
    studies: Sequence[Any],
    folder: Path,
    idle: Mapping[str, float],
    parts: Mapping[str, list[int]],
    **where: Any,
) -> dict[str, float]:
    """Return the time that each part spends for a block [s]: of the large study less that of the small one."""
    small, large = (_spent(study, folder, idle, parts, **where) for study in studies)
    more = len(studies[1].blocks) - len(studies[0].blocks)
    return {part: (large[part] - small[part]) / more for part in large}


def _spent(
    study: Any,
    folder: Path,
    idle: Mapping[str, float],
    parts: Mapping[str, list[int]],
    **where: Any,
) -> dict[str, float]:
    """Return the time of the processor that each part spends on a study [s]."""
    from bristle.apps.study import run_study

    before, begin = _processor(parts), time.perf_counter()
    run_study(study, folder / f"out_{next(_numbers)}", **where)
    wall = time.perf_counter() - begin
    return {
        part: spent - before[part] - wall * idle.get(part, 0.0)
        for part, spent in _processor(parts).items()
    }


def _idle(parts: Mapping[str, list[int]]) -> dict[str, float]:
    """Return what each part spends in a second in which nothing is asked of it [s/s]."""
    time.sleep(1.0)
    before, begin = _processor(parts), time.perf_counter()
    time.sleep(WAITS)
    return {
        part: (spent - before[part]) / (time.perf_counter() - begin)
        for part, spent in _processor(parts).items()
    }


def _processor(parts: Mapping[str, list[int]]) -> dict[str, float]:
    import psutil

    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {"command": time.process_time() + children.ru_utime + children.ru_stime} | {
        part: sum(sum(psutil.Process(pid).cpu_times()[:2]) for pid in pids)
        for part, pids in parts.items()
    }
