"""Structured Text through MATIEC, a compiler of IEC 61131-3, where `BRISTLE_MATIEC` names its folder."""

import ctypes
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.exports.native import COMPILER

import bristle as br
from bristle.files import read_experiment
from bristle.friction import MODELS, with_slots
from bristle.testing import example_of

FOLDER = os.environ.get("BRISTLE_MATIEC", "")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FOLDER or COMPILER is None, reason="BRISTLE_MATIEC names no MATIEC, or no C compiler"),
]
DT = 1e-3
MAIN = """
#include "iec_std_lib.h"
#include "accessor.h"
TIME __CURRENT_TIME;
BOOL __DEBUG;
#include "POUS.h"
#include "POUS.c"
static AXIS_X axis;
void begin(void) { AXIS_X_init__(&axis, 0); }
double force(double position, double period)
{
    __SET_VAR((&axis)->, POSITION, , position);
    __SET_VAR((&axis)->, PERIOD, , period);
    AXIS_X_body__(&axis);
    return __GET_VAR(axis.FORCE);
}
"""


def compiled(source: Path, out: Path) -> None:
    """Turn Structured Text into C in a folder."""
    out.mkdir()
    made = subprocess.run(
        [Path(FOLDER) / "iec2c", "-I", Path(FOLDER) / "lib", "-T", out, source],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr


@pytest.mark.parametrize("slots", [(), ("asymmetry",)])
@pytest.mark.parametrize("name", MODELS)
def test_a_model_is_taken_and_gives_the_same_bits(tmp_path, name, slots):
    model = example_of(with_slots(MODELS[name], slots))
    br.export(model, "st", tmp_path / "st", name="axis_x")
    compiled(tmp_path / "st" / "axis_x.st", tmp_path / "c")
    (tmp_path / "c" / "main.c").write_text(MAIN)
    library = tmp_path / "axis_x.so"
    flags = ("-std=gnu99", "-O1", "-ffp-contract=off", "-fno-strict-aliasing", "-w", "-shared", "-fPIC", "-I")
    subprocess.run([COMPILER, *flags, Path(FOLDER) / "lib" / "C", "-o", library, tmp_path / "c" / "main.c", "-lm"],
                   check=True)  # fmt: skip
    run = ctypes.CDLL(str(library))
    run.force.restype, run.force.argtypes = ctypes.c_double, [ctypes.c_double] * 2
    run.begin()
    steps = np.random.default_rng(4).standard_normal(3000) * np.repeat([1e-7, 1e-6, 1e-5], 1000)
    x = np.cumsum(steps) - steps[0]
    assert [run.force(each, DT) for each in x] == br.response(model, x, DT, rest="held").tolist()


@pytest.mark.parametrize("tunable", [False, True])
def test_a_law_is_taken(tmp_path, tunable):
    (tmp_path / "experiment.toml").write_text(
        'schema = 1\n[plant]\nmodel = "inertia"\nM = "10 kg"\n[friction]\nmodel = "dahl"\nF_C = "8 N"\n'
        'sigma_0 = "1 N/um"\n[controller]\nmodel = "cascade"\nk_p = "60 1/s"\nk_v = "2000 N*s/m"\nk_i = "100 kN/m"\n'
        '[controller.feedforward]\nmass = "10 kg"\nfriction = { model = "dahl", F_C = "8 N", sigma_0 = "1 N/um" }\n'
        '[reference]\nmodel = "sine"\namplitude = "1 mm"\nfrequency = "1 Hz"\n'
        '[run]\nduration = "1 s"\nsample_time = "1 ms"\n'
    )
    law = read_experiment(tmp_path / "experiment.toml").variants[0]
    br.export(law, "st", tmp_path / "st", name="axis_x", tunable=tunable, accept_harm=True)
    compiled(tmp_path / "st" / "axis_x.st", tmp_path / "c")
