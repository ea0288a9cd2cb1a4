"""A sensor of torque or force between motor and load; the simulated drives share no code with the identification."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.elastic import with_sensor
from benchmarks.two_mass import drive_of, log_of, of_the_motor
from tests.identification.known_logs import STATED
from tests.identification.rigid import identify

import bristle as br
from bristle.core import InputError
from bristle.files import read_axis, results_folder
from bristle.identification.lost_motion import Hysteresis, LostMotion
from bristle.identification.side_logs import alone, behind_sensor, effort_delay, side_logs, without_sensor
from bristle.identification.two_encoders import Masses
from bristle.identification.two_masses import apart, two_masses
from bristle.report.two_masses import two_masses_lines, two_masses_table, write_two_masses

DT = 1e-3  # s


def sensed(share=0.4, delay=0, **columns):
    """A motor of 2 kg with friction of 3 N, in front of a sensor; the effort is late by some samples."""
    t = DT * np.arange(4000)
    position = 0.05 * np.sin(2.0 * t) + 1e-4 * np.sin(60.0 * t)
    speed, acceleration = 0.1 * np.cos(2.0 * t) + 6e-3 * np.cos(60.0 * t), -0.2 * np.sin(2.0 * t) - 0.36 * np.sin(60.0 * t)
    of_motor = 2.0 * acceleration + 3.0 * np.tanh(speed / 1e-3) * (1.0 - share)
    force = 8.0 * acceleration + 3.0 * np.tanh(speed / 1e-3) * share
    effort = np.concatenate([(of_motor + force)[:1].repeat(delay), (of_motor + force)[: t.size - delay]])
    return br.Log.from_columns({"time": t, "position": position, "effort": effort, "coupling_effort": force} | columns), of_motor


def test_the_log_of_the_motor_has_the_effort_that_the_sensor_does_not_measure():
    log, of_motor = sensed(delay=3)
    delay = effort_delay([log], 0.0)
    assert delay == pytest.approx(3.0 * DT, abs=0.05 * DT)
    effort = without_sensor(log, 0.0, delay).effort.values
    assert effort[50:-50] == pytest.approx(of_motor[50:-50], abs=0.05)


@pytest.mark.parametrize(
    ("factor", "fault"),
    [(-1.0, "has the opposite sign of the effort.*Write sign = -1"), (1e3, "does not measure a part of the effort.*Check unit and side")],
)
def test_a_sensor_with_a_wrong_sign_or_unit_is_refused(factor, fault):
    log, _ = sensed()
    wrong, _ = sensed(coupling_effort=factor * log.further["coupling_effort"].values)
    with pytest.raises(InputError, match=rf"columns\.coupling_effort: {fault}"):
        two_masses([(wrong, None)], identify)
    assert behind_sensor(log).effort.values == pytest.approx(log.further["coupling_effort"].values)


AXIS = """
schema = 1
kind = "translational"
columns.position = { column = "m", unit = "rev", side = "motor" }
columns.effort = { column = "i", unit = "A" }
columns.coupling_effort = { column = "T", unit = "UNIT", sign = -1 }
effort.torque_constant = "0.1 N*m/A"
transmission.lead = "10 mm"
"""


def test_an_axis_file_names_the_sensor_in_its_own_unit_and_sign():
    t = DT * np.arange(500)
    columns = {"time": t, "m": np.sin(3.0 * t), "i": np.cos(t), "T": -50.0 * np.cos(t)}
    log = br.Log.from_columns(columns, axis=read_axis(AXIS.replace("UNIT", "mN*m").encode()), sample_time=DT)
    assert log.further["coupling_effort"].values == pytest.approx(0.5 * log.effort.values)
    assert log.further["coupling_effort"].unit == "N"
    with pytest.raises(InputError, match=r"columns\.coupling_effort\.unit: is not a unit of torque or force; found 'A'"):
        read_axis(AXIS.replace("UNIT", "A").encode())


def test_the_result_for_one_mass_does_not_depend_on_the_sensor():
    log, _ = sensed()
    alone, pairs = apart([(log, None)])
    assert [each.further for each, _ in alone] == [{}]
    assert len(pairs) == 1
    assert apart([(log, None), (replace(log, further={}), None)])[1] == ()


def test_without_a_scale_the_load_is_rigid_behind_the_sensor(tmp_path):
    log, _ = sensed(share=0.4)
    found = two_masses([(log, None)], partial(identify, model="coulomb_viscous", axis=STATED, draws=0, blocks=0))
    assert {name: item.value for name, item in found.by_name.items()} == pytest.approx({"motor": 2.0, "load": 8.0}, rel=0.02)
    assert found.motor.best.parameters["F_C"].value == pytest.approx(1.8, rel=0.05)
    assert found.load.best.parameters["F_C"].value == pytest.approx(1.2, rel=0.05)
    assert not found.is_elastic
    assert found.as_data()["quantities"]["load"]["half_width"] is None  # unknown without the motion of the load
    low, high = found.load.best.parameters["F_C"].ends
    assert high - low > 0.29 * 1.2
    result = SimpleNamespace(two_masses=found, log=log)
    assert any(line.text.startswith("Without a second encoder, the load is rigid behind the sensor") for line in two_masses_lines(result))
    assert "from the sensor in the coupling" in two_masses_table(result).caption
    with results_folder(tmp_path / "out") as folder:
        folder.write("note.txt", "no plant")
        write_two_masses(folder, result, {})
    assert not list((tmp_path / "out").glob("two_masses*"))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4003, 4000])
def test_a_sensor_separates_friction_of_the_motor_from_that_behind_it(seed):
    drive = with_sensor(seed, has_nut=True)
    fit = partial(identify, model="lugre", blocks=0, draws=0)
    pairs = [(br.Log.from_columns(columns), br.Axis(resolution=drive.step)) for columns in (log_of(drive), of_the_motor(log_of(drive)))]
    both, without_scale = two_masses(pairs[:1], fit), two_masses(pairs[1:], fit)
    truths = {"motor": drive.motor - drive.screw, "load": drive.load, "stiffness": drive.stiffness, "nut": drive.nut}
    for name, truth in truths.items():
        assert abs(both.by_name[name].value - truth) <= both.by_name[name].half_width
    levels = [side.best.parameters["F_C"] for side in (both.motor, both.load, without_scale.motor)]
    for level, truth in zip(levels, [drive.friction[0][1], drive.friction[1][1], drive.friction[0][1]], strict=True):
        assert level.ends[0] < truth < level.ends[1]
        assert level.ends[1] - level.ends[0] < 0.1 * truth


def test_the_force_between_both_sides_has_the_loss_of_a_coupling_with_hysteresis():
    """A triangular twist at a constant speed: the force on the load returns less work than it took."""
    t, amplitude, reach = DT * np.arange(8000), 2e-5, 5e-6
    twist = amplitude * (4.0 * np.abs((0.5 * t) % 1.0 - 0.5) - 1.0)
    log = br.Log.from_columns({"time": t, "position": 0.01 * t, "effort": 70.0 + t})
    log = replace(log, further={"load_position": replace(log.position, values=log.position.values - twist)})
    lost = LostMotion(0.0, 0.0, 0.0, 4e6, 0.0, 0.0, hysteresis=Hysteresis(30.0, 0.0, 4e6, 7e6, 0.0, ((15.0, reach),)))
    motor, load = (side.effort.values for side in side_logs(log, Masses(np.zeros(9), np.zeros(9), 4e6, 0.0), lost))
    assert motor + load == pytest.approx(log.effort.values)
    cycle = slice(4000, 6001)
    assert np.trapezoid(load[cycle], twist[cycle]) == pytest.approx(4.0 * 15.0 * (amplitude - reach), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [905, 3009])
def test_hysteresis_of_the_coupling_does_not_bias_friction_of_either_side(seed):
    drive = drive_of(seed)
    twist = log_of(drive)["position"] - log_of(drive)["load_position"]
    drive = replace(drive, hysteresis=(0.2, 0.15 * float(np.ptp(np.quantile(twist, [0.005, 0.995])))))
    log = br.Log.from_columns(log_of(drive))
    found = two_masses([(log, br.Axis(resolution=drive.step))], partial(identify, model="lugre", blocks=0, draws=0))
    for side, truth in zip(found.sides.values(), drive.friction, strict=True):
        assert side.best.parameters["F_C"].value == pytest.approx(truth[1], rel=0.03)


def test_a_load_behind_a_coupling_is_where_its_spring_holds_it():
    log, _ = sensed()
    stiffness, force = 2e5, log.further["coupling_effort"].values
    load = alone(log, force, load=True, softness=1.0 / stiffness)
    assert stiffness * (log.position.values - load.position.values) == pytest.approx(force, abs=1e-9)
    assert np.array_equal(load.effort.values, force)
