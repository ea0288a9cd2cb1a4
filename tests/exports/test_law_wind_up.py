"""Laws of a motor that moves a table by an elastic screw: the efforts of the simulation in every target, and the error of the table."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.exports.native import COMPILER, RUN_LAW, built, differing, library_of_laws, selected_cases
from tests.exports.test_laws import recorded, replayed

import bristle as br
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
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
