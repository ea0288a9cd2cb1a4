"""Laws of a motor that moves a table by an elastic screw: the efforts of the simulation in every target, and the error of the table."""

import ctypes
import math
import subprocess
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.exports.native import COMPILER, FLAGS, WARNINGS, differing

import bristle as br
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.exports.c import law_files
from bristle.exports.described import Source
from bristle.exports.law import law_facts, law_of
from bristle.exports.tunable import tunable_law
from bristle.simulation import simulate

needs_c = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT, LEAD, J, M = 1e-3, 10e-3, 5e-4, 150.0
ARM = LEAD / (2.0 * math.pi)
SCREW = br.plants.ball_screw(kind="rotational", J=J, M=M, lead=LEAD, k=3e6, d=1500.0, backlash=20e-6)
MOTOR = br.friction.coulomb(kind="rotational", F_C=0.05)
SLIPS = br.friction.maxwell_slip(kind="rotational", F_C=0.05, k_i=[60.0, 30.0], nu_i=[0.5, 0.5])
DRY = br.friction.coulomb(F_C=200.0)
RUBS = br.friction.maxwell_slip(F_C=200.0, k_i=[6e7, 3e7], nu_i=[0.5, 0.5])
CASCADE = br.controllers.cascade(kind="rotational", k_p=15.0, k_v=60.0 * J, k_i=900.0 * J, k_ff=1.0)
SLIDING = br.controllers.sliding_mode(kind="rotational", J=J + M * ARM**2, lambda_=50.0, K_1=50.0)
BOTH = Feedforward(plant=SCREW, friction=MOTOR, table=DRY)
# Controller, feedforward, delay, and side of the sensor.
CASES = {
    "both": (CASCADE, BOTH, 1, "motor"),
    "memories": (SLIDING, replace(BOTH, friction=SLIPS, table=RUBS, conditioning=1e-3, gain=0.9, asymmetry=0.1), 3, "motor"),
    "measured": (SLIDING, replace(BOTH, along="measured", wind_up_time=0.02), 2, "motor"),
    "scale": (SLIDING, Feedforward(plant=SCREW, friction=MOTOR), 0, "load"),
    "table": (CASCADE, Feedforward(plant=SCREW, table=DRY, wind_up_time=1e-3), 0, "motor"),
}
RUN = """
#include "{name}.h"
void run_{name}(const {name}_inputs *inputs, int count, double *effort)
{{
    static {name} axis;
    {name}_start(&axis);
    for (int i = 0; i < count; ++i) {{
        effort[i] = {name}_effort(&axis, &inputs[i]);
    }}
}}
"""


def variant_of(case):
    controller, feedforward, delay, side = CASES[case]
    reference = br.references.sine(kind="rotational", amplitude=12.0, frequency=0.5)
    sensor = br.sensors.encoder(kind="rotational", resolution=1e-5)
    run = Run(2.0, DT, delay=delay, substeps=4, effort_limit=20.0)
    return Variant("base", SCREW, MOTOR, controller, sensor, reference, feedforward, run, table=DRY, sensor_at=side)


@cache
def law(case):
    return law_of(variant_of(case))


def windows(law, x, v, a, measured):
    """Return the inputs of a law in rows, for all samples with a complete window."""
    given = {"position": x, "velocity": v, "acceleration": a, "measured": measured}
    for name, signal in (("place_ahead", x), ("acceleration_ahead", a)):
        given[name] = np.lib.stride_tricks.sliding_window_view(signal[1:], law.samples_ahead)
    count = min(len(given["place_ahead"]), len(measured))
    return np.column_stack([given[name][:count] for name in law.inputs])


@cache
def recorded(case):
    """Return the inputs of a law during its simulated loop, and the simulated efforts."""
    variant = variant_of(case)
    outcome = simulate(Experiment("loops", "rotational", (variant,))).variants["base"]
    t = DT * np.arange(outcome.time.size)
    return windows(law(case), *variant.reference.component.sample(t, variant.reference.parameters), outcome.measured), outcome.command


def library(folder, laws):
    sources = []
    for name, each in laws.items():
        for file, text in law_files(each, name, Source()).items():
            (folder / name).mkdir(exist_ok=True, parents=True)
            (folder / name / file).write_text(text, encoding="ascii")
        (folder / name / "run.c").write_text(RUN.format(name=name))
        sources += [f"{name}/{name}.c", f"{name}/run.c"]
    command = [COMPILER, "-O1", *FLAGS, *WARNINGS, "-shared", "-fPIC", *sources, "-o", "laws.so", "-lm"]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:4000]
    return ctypes.CDLL(str(folder / "laws.so"))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("laws")
    return folder, library(folder, {f"law_{case}": law(case) for case in CASES})


def replayed(laws, name, inputs):
    pointer, efforts = ctypes.POINTER(ctypes.c_double), np.empty(len(inputs))
    inputs = np.ascontiguousarray(inputs)
    getattr(laws, f"run_{name}")(inputs.ctypes.data_as(pointer), len(inputs), efforts.ctypes.data_as(pointer))
    return efforts


@needs_c
@pytest.mark.parametrize("case", CASES)
def test_the_efforts_are_those_of_the_simulation(exported, case):
    inputs, efforts = recorded(case)
    assert len(inputs) > 1800
    assert np.ptp(efforts) > 0.5
    assert differing(replayed(exported[1], f"law_{case}", inputs), efforts[: len(inputs)]) == 0
