"""An FMU of a motor with a table behind an elastic screw: the bits of bristle for both masses, and frictions on both sides."""

import numpy as np
import pytest
from tests.exports.importing import Importer, needs_compiler, needs_fmpy
from tests.exports.native import differing

import bristle as br
from bristle.engine import interpreted, run_open_loop
from bristle.engine.screwed import through_screw
from bristle.exports import fmu
from bristle.exports.described import Source
from bristle.exports.fmu_content import content_of
from bristle.exports.subject import subject_of

SCREW = br.plants.ball_screw(kind="rotational", J=5e-4, M=150.0, lead=10e-3, k=3e6, d=1500.0, backlash=2e-5)
LUGRE = br.friction.lugre(kind="rotational", F_C=0.05, F_S=0.06, v_S=0.1, sigma_0=100.0, sigma_1=1e-2, sigma_2=1e-4)
COULOMB = br.friction.coulomb(kind="rotational", F_C=0.05)
SLIPS = br.friction.maxwell_slip(kind="rotational", F_C=0.05, k_i=[60.0], nu_i=[1.0])
TURNS = br.friction.preisach_contact(kind="rotational", kernel="reformed_dahl_exact", s=100.0, f_p=0.05)
TABLES = {
    "preisach": br.friction.preisach_contact(kernel="reformed_dahl_exact", s=1e7, f_p=200.0),
    "lugre": br.friction.lugre(F_C=200.0, F_S=260.0, v_S=1e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=10.0),
    "maxwell_slip": br.friction.maxwell_slip(F_C=200.0, k_i=[6e7, 3e7], nu_i=[0.5, 0.5]),
    "coulomb": br.friction.coulomb(F_C=200.0),
}
CASES = [("lugre", 2, LUGRE), ("maxwell_slip", 3, LUGRE), ("coulomb", 2, COULOMB), ("maxwell_slip", 2, SLIPS), ("preisach", 3, TURNS)]
STEP, COUNT = 1e-4, 800


def written(folder, table, motor=LUGRE, fmi=2):
    return br.export(motor, f"fmu{fmi}", folder, plant=SCREW, table=table, step=STEP)


@pytest.mark.slow
@needs_compiler
@needs_fmpy
@pytest.mark.parametrize(("name", "fmi", "motor"), CASES)
def test_both_masses_move_as_in_bristle(tmp_path, monkeypatch, name, fmi, motor):
    from fmpy.validation import validate_fmu

    monkeypatch.setattr(fmu, "zig", list)
    table = TABLES[name]
    assert "axis_x_mass.fmu" in written(tmp_path / "out", table, motor, fmi).files
    assert validate_fmu(str(tmp_path / "out" / "axis_x_mass.fmu")) == []
    unit = Importer(tmp_path / "out" / "axis_x_mass.fmu", tmp_path / "unpacked").start(x=0.02, x_table=0.02)
    effort = 0.9 * np.sin(np.arange(COUNT) * 0.012) * np.repeat(np.random.default_rng(6).uniform(0, 1, COUNT // 50), 50)
    seen = unit.along(STEP, [{"effort": value} for value in effort], "force", before=("x", "v", "x_table", "v_table"))
    unit.close()
    with interpreted():
        trace = run_open_loop(SCREW, motor, effort, STEP, table=table, x=0.02)
    assert np.min(trace.velocity) < 0.0 < np.max(trace.velocity)
    signals = (trace.motor_position, trace.motor_velocity, trace.position, trace.velocity, trace.friction)
    assert differing(seen, np.transpose(signals)) == 0


def test_parameters_of_both_sides_have_their_units():
    component = through_screw(SCREW, LUGRE, TABLES["lugre"], exported=True).component
    units = {name: variable.unit("rotational") for name, variable in component.variables.items()}
    assert (units["motor_F_C"], units["table_F_C"]) == ("N*m", "N")
    assert (units["motor_sigma_0"], units["table_sigma_0"]) == ("N*m/rad", "N/m")
    assert (units["motor_v_S"], units["table_v_S"]) == ("rad/s", "m/s")


def test_memories_of_both_sides_are_apart_with_the_bounds_of_each():
    motor, table = TURNS.with_values(capacity=20), TABLES["preisach"].with_values(capacity=50)
    content = content_of(subject_of(through_screw(SCREW, motor, table, exported=True)), SCREW, Source())
    sizes = [model.component.memory_size(model.parameters) for model in (motor, table)]
    assert sizes[0] != sizes[1]
    assert content.memory_at == {"motor_memory": 0, "table_memory": sizes[0]}
    assert content.memory.size == sum(sizes)
    assert [bound for bound in content.most if 0 < bound < 2**31] == [size // 2 for size in sizes]
