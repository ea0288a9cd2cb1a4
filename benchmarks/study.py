"""A study against a loop over ``simulate``: open loops, closed loops on two workers, what a run costs more."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.timing import Ratio, busy_side_by_side, wall

RIG = """
schema = 1
kind = "translational"
[plant]
M = "1 kg"
[friction]
model = "lugre"
F_C = "1 N"
F_S = "1.5 N"
v_S = "1 mm/s"
sigma_0 = "1e5 N/m"
sigma_1 = "316 N*s/m"
sigma_2 = "0.4 N*s/m"
[effort]
model = "sine"
amplitude = "2.5 N"
frequency = "4 Hz"
[run]
duration = "1 s"
sample_time = "1 ms"
substeps = 1
"""
LOOP = """
schema = 1
[plant]
M = "20 kg"
[friction]
model = "lugre"
F_C = "12 N"
F_S = "15 N"
v_S = "5 mm/s"
sigma_0 = "3e6 N/m"
sigma_1 = "1 N*s/mm"
[controller]
model = "cascade"
k_p = "80 1/s"
k_v = "4 N*s/mm"
[sensor]
noise = "0.05 um"
[reference]
model = "sine"
amplitude = "5 mm"
frequency = "1 Hz"
[run]
duration = "5 s"
sample_time = "0.5 ms"
substeps = 8
"""
STUDY = """
schema = 1
experiment = "rig.toml"
runs = {runs}
seed = 7
[vary]
"friction.F_C" = {{ normal = ["{level} N", "{spread} N"] }}
"""
OPEN_RUNS, LOOP_RUNS, SERIAL, ROWS = 20_000, 6_000, 300, 1_000_000


def study() -> Iterator[Ratio]:
    """Time studies on all cores beside loops of Python that are warm; of closed loops with the start of workers."""
    from bristle import simulate
    from bristle.apps.study import read_study, read_study_file, run_study
    from bristle.apps.study.block import Simulator
    from bristle.apps.study.plan import Block
    from bristle.core.cores import core_count
    from bristle.files.owned import NOTE

    cores = core_count()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "rig.toml").write_text(RIG)
        (folder / "study.toml").write_text(STUDY.format(runs=OPEN_RUNS, level=1, spread=0.1))
        plan = read_study_file(folder / "study.toml")
        base = plan.experiment.variants[0]
        levels = plan.values(Block(0, SERIAL))["friction.F_C"].tolist()

        def loop() -> None:
            for level in levels:
                variant = replace(base, friction=base.friction.with_values(F_C=level))
                simulate(replace(plan.experiment, variants=(variant,)))

        loop()
        run_study(plan, folder / "first")  # all is compiled and loaded, as for the loop
        pairs = [
            (
                wall(loop) / SERIAL,
                wall(lambda k=k: run_study(plan, folder / f"open-{k}")) / OPEN_RUNS,
            )
            for k in range(3)
        ]
        one, ours = (min(times) for times in zip(*pairs, strict=True))
        yield Ratio(
            f"{OPEN_RUNS} open loops of LuGre, 1 000 steps",
            ours,
            one,
            ours / one,
            1.0 / 15.0,
            "a loop over simulate, compiled; one run",
            f"{cores} cores, identical to the bit",
        )

        (folder / "rig.toml").write_text(LOOP)
        (folder / "study.toml").write_text(STUDY.format(runs=LOOP_RUNS, level=12, spread=0.5))
        plan = read_study_file(folder / "study.toml")
        simulator = Simulator(plan)
        block = Block(0, 40)
        simulator.columns(block)
        experiments = [
            simulator.varied.experiment({"friction.F_C": float(value)}, seed)
            for value, seed in zip(
                plan.values(block)["friction.F_C"], plan.seeds(block), strict=True
            )
        ]
        ours, theirs, _ = busy_side_by_side(
            lambda: simulator.columns(block), lambda: [simulate(one) for one in experiments], 7
        )
        more, beside = (ours - theirs) / block.count, theirs / block.count
        yield Ratio(
            "extra time of a run in a study",
            max(more, 0.0),
            beside,
            max(more, 0.0) / beside,
            None,
            "simulate of a closed loop; processor time",
            most=3e-4,
        )
        alone = wall(lambda: run_study(plan, folder / "alone", workers=1))
        both = wall(lambda: run_study(plan, folder / "both", workers=2))
        yield Ratio(
            f"{LOOP_RUNS} closed loops on two workers",
            both,
            alone,
            both / alone,
            1.0 / 1.7,
            "one worker",
        )

        import pyarrow
        import pyarrow.parquet

        file = next((folder / "both" / "runs").iterdir())
        table = pyarrow.parquet.read_table(file)
        places = np.arange(ROWS) % table.num_rows
        many = table.take(places).set_column(
            0, table.schema.field(0), pyarrow.array(np.arange(ROWS))
        )
        file.parent.joinpath("read").mkdir()
        for first in range(0, ROWS, 4096):
            pyarrow.parquet.write_table(
                many.slice(first, 4096), file.parent / "read" / f"{first:010d}.parquet"
            )
        for old in file.parent.glob("*.parquet"):
            old.unlink()
        (file.parent / "read").rename(folder / "read")
        file.parent.rmdir()
        (folder / "read").rename(folder / "both" / "runs")
        (folder / "both" / NOTE).unlink()  # these files have no checksums
        read_study(folder / "both")
        seconds = min(wall(lambda: read_study(folder / "both")) for _ in range(3))
        yield Ratio(
            "a million runs read into xarray",
            seconds,
            seconds,
            1.0,
            None,
            "",
            "4 096 runs in each file",
            most=2.0,
        )
