"""A small axis that an effort drives, a small loop, and studies of both."""

import hashlib

import numpy as np
import pytest

from bristle.apps.study import read_study_file

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
duration = "{duration}"
sample_time = "1 ms"
substeps = {substeps}
settle = "20 ms"
"""

LOOP = """
schema = 1
[plant]
M = "20 kg"
[friction]
model = "coulomb_viscous"
F_C = "8 N"
F_v = "40 N*s/m"
[controller]
model = "cascade"
k_p = "80 1/s"
k_v = "4 N*s/mm"
limit = "300 N"
[sensor]
resolution = "0.1 um"
noise = "0.2 um"
seed = 5
[reference]
model = "sine"
amplitude = "2 mm"
frequency = "2 Hz"
[run]
duration = "0.2 s"
sample_time = "1 ms"
settle = "20 ms"
seeds = 3
[compare.plain]
[compare.stiff.controller]
k_p = "120 1/s"
"""

STUDY = """
schema = 1
experiment = "rig.toml"
runs = 12
seed = 7
block = 4
[vary]
"friction.F_C" = { normal = ["1 N", "0.1 N"] }
"plant.M" = { uniform = ["0.8 kg", "1.2 kg"] }
[keep]
metrics = ["motion.peak_to_peak", "effort.rms"]
"""


class Bench:
    """A folder with an axis, a loop and studies."""

    def __init__(self, folder):
        self.folder = folder
        self.rig()
        (folder / "loop.toml").write_text(LOOP)

    def rig(self, duration="0.1 s", substeps=2):
        (self.folder / "rig.toml").write_text(RIG.format(duration=duration, substeps=substeps))

    def write(self, text=STUDY, name="study.toml", **changes):
        for before, after in changes.values():
            assert before in text
            text = text.replace(before, after)
        (self.folder / name).write_text(text)
        return self.folder / name

    def study(self, text=STUDY, **changes):
        return read_study_file(self.write(text, **changes))


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


@pytest.fixture
def slow_bench(bench):
    """Blocks that take some hundredths of a second."""
    bench.rig(duration="5 s", substeps=20)
    return bench


def content(folder):
    """Return a checksum of each file with runs, and what stands beside them."""
    return {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.glob("runs/*.parquet"))
    }


def same(first, second):
    """Whether two blocks hold the same, to the bit."""
    return first.keys() == second.keys() and all(
        list(first[name]) == list(second[name])
        if isinstance(first[name], list)
        else np.asarray(first[name]).tobytes() == np.asarray(second[name]).tobytes()
        for name in first
    )
