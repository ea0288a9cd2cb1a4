"""Laws of a motor that moves a table by an elastic screw: the efforts of the simulation in every target, and the error of the table."""

import ctypes
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.exports.importing import Importer, needs_fmpy
from tests.exports.native import COMPILER, RUN_LAW, built, differing, library_of_laws, selected_cases
from tests.exports.test_fmu_law import stepped
from tests.exports.test_laws import recorded, replayed, told

import bristle as br
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.exports import fmu
from bristle.exports.c import law_files
from bristle.exports.described import Source
from bristle.exports.effect import effect_of_law
from bristle.exports.fmu import source_text
from bristle.exports.fmu_content import Setting, content_of_law
from bristle.exports.hal import hal_law_files
from bristle.exports.law import law_facts, law_of
from bristle.exports.st import st_law_files
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


def variant_of(case):
    controller, feedforward, delay, side = CASES[case]
    reference = br.references.sine(kind="rotational", amplitude=12.0, frequency=0.5)
    sensor = br.sensors.encoder(kind="rotational", resolution=1e-5)
    run = Run(2.0, DT, delay=delay, substeps=4, effort_limit=20.0)
    return Variant("base", SCREW, MOTOR, controller, sensor, reference, feedforward, run, table=DRY, sensor_at=side)


@cache
def law(case):
    return law_of(variant_of(case))


@cache
def record_of(case):
    """Return the inputs of a law during its simulated loop, and the simulated efforts."""
    return recorded(variant_of(case))


def exported_laws(folder, laws, calls=RUN_LAW):
    texts = {name: law_files(each, name, Source()) for name, each in laws.items()}
    return library_of_laws(folder, texts, {name: calls.format(name=name) for name in laws})


@pytest.fixture(scope="module")
def exported(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("laws")
    return folder, exported_laws(folder, {case: law(case) for (case,) in selected_cases(request, "case")})


@needs_c
@pytest.mark.fast_cases(3)
@pytest.mark.parametrize("case", CASES)
def test_the_efforts_are_those_of_the_simulation(exported, case):
    inputs, efforts = record_of(case)
    assert len(inputs) > 1800
    assert np.ptp(efforts) > 0.5
    assert differing(replayed(exported[1], case, inputs), efforts) == 0


# --- a loop that shares no code with bristle ----------------------------------------------------------------------------

STEP = """
#include "{name}.h"
static {name} axis;
void begin_{name}(void) {{ {name}_start(&axis); }}
double step_{name}(const {name}_inputs *inputs) {{ return {name}_effort(&axis, inputs); }}
"""


def slowed(v, push, mass, level, h):
    """Return the velocity of a mass with Coulomb friction after a time h."""
    free, lost = v + h / mass * push, h / mass * level
    return 0.0 if abs(free) <= lost else free - math.copysign(lost, free)


def table_of(laws, name, rows, delay, gap=20e-6):
    """Return the travel of the table [m] for the efforts of a compiled law; the motor has an encoder with steps of 10 urad."""
    begin, step = getattr(laws, f"begin_{name}"), getattr(laws, f"step_{name}")
    step.restype = ctypes.c_double
    begin()
    rows, inner = np.ascontiguousarray(rows), 8
    h, x, v, y, w = DT / inner, 0.0, 0.0, 0.0, 0.0
    queue, travel = [0.0] * delay, []
    for row in rows:
        row[3] = round(x / 1e-5) * 1e-5
        queue.append(step(row.ctypes.data_as(ctypes.POINTER(ctypes.c_double))))
        effort = queue.pop(0)
        travel.append(y)
        for _ in range(inner):
            lost = ARM * x - y
            spring = 0.0
            if abs(lost) > 0.5 * gap:
                side = math.copysign(1.0, lost)
                spring = side * max(3e6 * (abs(lost) - 0.5 * gap) + side * 1500.0 * (ARM * v - w), 0.0)
            v = slowed(v, effort - ARM * spring, J, 0.05, h)
            w = slowed(w, spring, M, 200.0, h)
            x, y = x + h * v, y + h * w
    return np.array(travel)


@needs_c
def test_a_table_of_another_simulator_follows_with_a_twelfth_of_the_error(tmp_path):
    t = DT * np.arange(1800)
    begun = np.clip(t / 0.6, 0.0, 1.0)
    x = 12.0 * begun**3 * (10.0 - 15.0 * begun + 6.0 * begun**2) * np.sin(2.0 * np.pi * 0.5 * t)
    v = np.gradient(x, DT)
    a = np.gradient(v, DT)
    summed = br.friction.coulomb(kind="rotational", F_C=0.05 + 200.0 * ARM)
    moved = br.references.recorded(kind="rotational", position=x, sample_time=DT)
    variant = replace(variant_of("both"), reference=moved, run=replace(variant_of("both").run, duration=1.8))
    rigid = replace(variant, feedforward=Feedforward(mass=J + M * ARM**2, friction=summed))
    laws = {"law_two": law_of(variant), "law_one": law_of(rigid)}
    compiled, errors = exported_laws(tmp_path, laws, STEP), {}
    for name, each in laws.items():
        rows = told(each, x, v, a, np.zeros(x.size))
        missed = ARM * x[: len(rows)] - table_of(compiled, name, rows, each.variant.run.delay)
        errors[name] = float(np.sqrt(np.mean(missed[700:1750] ** 2)))
    assert errors["law_one"] > 40e-6
    assert errors["law_two"] < errors["law_one"] / 12.0


# --- other targets and options ----------------------------------------------------------------------------------------


@needs_c
@pytest.mark.parametrize("case", ["memories", pytest.param("measured", marks=pytest.mark.slow)])
def test_the_self_test_in_c_passes(exported, case):
    ran = built(exported[0] / case, f"{case}_selftest.c", name=case)
    assert (ran.returncode, "identical to bristle" in ran.stdout) == (0, True)


@pytest.mark.parametrize("case", ["memories", pytest.param("both", marks=pytest.mark.slow)])
def test_structured_text_gives_the_efforts_of_the_simulation(tmp_path, case):
    pytest.importorskip("tree_sitter_iec61131_3_st", reason="needs the grammar of Structured Text for tree-sitter")
    from tests.exports.structured_text import StructuredText

    files = st_law_files(law(case), "led", Source())
    block = StructuredText({"led": [files["led.st"], files["led_selftest.st"]]}, tmp_path)
    inputs, efforts = record_of(case)
    result, flags = block.replay("led", inputs)
    assert differing(result, efforts) == 0
    assert not flags.any()
    assert block.selftest("led") == (True, True)


@pytest.mark.slow
@needs_c
@needs_fmpy
def test_an_fmu_gives_the_efforts_of_the_simulation(tmp_path, monkeypatch):
    monkeypatch.setattr(fmu, "zig", list)
    (tmp_path / "led.fmu").write_bytes(fmu.write_law(law("memories"), "led", Source(), fmi=2).files["led.fmu"])
    unit = Importer(tmp_path / "led.fmu", tmp_path / "unpacked").start()
    inputs, efforts = record_of("memories")
    assert differing(stepped(unit, inputs, dt=DT), efforts) == 0
    unit.close()


@needs_c
def test_the_step_of_an_fmu_holds_all_memories_apart():
    each = law("memories")
    content = content_of_law(each, "led", Source())
    text = source_text(content, Setting("led", Source(), DT, 2))[0]
    assert "now->memory, now->memory + 2, now->memory + 4, " in text
    assert content.memory.size == each.memory_size == sum(memory.size for memory in each.memories.values())
    assert content.memory.tolist()[:4] == [*each.memories["memory"].tolist(), *each.memories["table_memory"].tolist()]


def test_the_header_states_numbers_that_come_from_the_motion():
    each = law("measured")
    lines = law_facts(each, "axis_x", Source())["fed"]
    assert "the wind-up is a mean over 10 samples (10 ms) before and after each sample" in lines
    clear = each.p.screw.clear
    assert f"the motor changes the flank of the screw at a force beyond {clear:.4g} N" in lines
    assert each.samples_ahead == 2 + 10 + 4
    assert law("table").samples_ahead == 4
    head = law_files(each, "axis_x", Source())["axis_x.h"]
    assert all(len(line) <= 130 for line in head.splitlines())
    assert "double table_effort; /* friction fed forward [N] */" in head


def test_parameters_of_both_sides_can_change():
    tuned = tunable_law(law_of(variant_of("both"), tunable=True))
    assert tuned.values["table_F_C"] == 200.0
    assert tuned.values["friction_F_C"] == 0.05
    assert tuned.values["feedforward_M"] == 150.0
    units = {name: variable.unit("rotational") for name, variable in tuned.variables.items()}
    assert (units["friction_F_C"], units["table_F_C"], units["feedforward_M"]) == ("N*m", "N", "kg")
    assert (units["feedforward_k"], units["feedforward_arm"], units["feedforward_clear"]) == ("N/m", "m/rad", "N")


@needs_c
def test_single_precision_stays_close(tmp_path):
    single = law_of(variant_of("both"), single=True, tunable=True)
    inputs, efforts = record_of("both")
    result = replayed(exported_laws(tmp_path, {"law_single": single}), "law_single", inputs)
    off = np.max(np.abs(result - efforts)) / np.max(np.abs(efforts))
    assert 0.0 < off < 1e-3


def test_a_component_of_hal_with_too_many_pins_is_refused():
    with pytest.raises(InputError, match=r"hal: has too many inputs.*20 pins"):
        hal_law_files(law("both"), "led", Source())
    few = hal_law_files(law("table"), "led", Source()).files
    assert "pin in float acceleration_ahead_3" in few["led.comp"]


def test_the_effect_of_a_law_compares_the_error_of_the_table():
    effect = effect_of_law(law("measured").variant)
    lost = 2.0 * (200.0 / 3e6 + 10e-6) / ARM  # the table reverses the screw
    assert effect.distance == pytest.approx(lost)
    own = simulate(Experiment("loops", "rotational", (law("measured").variant,))).variants["base"]
    assert effect.along[-1].with_it == pytest.approx(own.true_error.peak_to_peak, rel=0.1)
    assert effect.along[-1].with_it != pytest.approx(own.following_error.peak_to_peak, rel=0.1)
    assert all(path.ratio < 0.5 for path in effect.along)
