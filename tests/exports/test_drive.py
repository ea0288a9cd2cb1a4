"""Tables for drives: the steady friction in the units of the drive, and what they lose in numbers."""

import re

import numpy as np
import pytest

import bristle as br
from bristle.engine.contact import steady_force
from bristle.exports.drive import Side, reads, side_of, write
from bristle.exports.targets import Request
from bristle.exports.tf5200 import merged
from bristle.prediction.drive_units import DriveUnit

AXIS = {
    "schema": 1,
    "kind": "rotational",
    "columns": {"time": {"column": "t", "unit": "s"}, "position": {"column": "q", "unit": "deg"}, "effort": {"column": "u", "unit": "%"}},
    "effort": {"rated": "0.5 N*m"},
}
ONE_DEGREE = np.pi / 180.0


@pytest.fixture(scope="module")
def model():
    return br.friction.with_slots(br.friction.lugre, ["asymmetry"])(
        kind="rotational", F_C_pos=0.1, F_C_neg=0.08, F_S_pos=0.15, F_S_neg=0.12, v_S=0.5, sigma_0=100.0, sigma_2_pos=0.02, sigma_2_neg=0.02
    )


def exported(model, folder, to, **options):
    return br.export(model, to, folder / to, speed=20.0, **options)


def test_the_table_is_the_steady_friction_in_the_units_of_the_log(model, tmp_path):
    result = exported(model, tmp_path, "table", axis=br.read_axis(AXIS), points=6)
    lines = (tmp_path / "table" / "axis_x.csv").read_text().splitlines()
    head, *rows = [line for line in lines if not line.startswith("#")]
    assert head == "velocity [deg/s],effort [%]"
    table = np.array([row.split(",") for row in rows], dtype=float)
    assert len(table) <= 12
    assert np.all(np.diff(table[:, 0]) >= 0.0)
    for velocity, effort in table[table[:, 0] != 0.0]:
        assert effort * 0.005 == pytest.approx(steady_force(model, velocity * ONE_DEGREE), rel=1e-6)
    largest = float(re.search(r"by at most ([\d.e-]+) %", " ".join(result.notes))[1])
    speeds = np.linspace(0.01, 20.0, 300)
    forward = table[np.signbit(table[:, 0]) == 0]
    between = np.interp(speeds, forward[:, 0] * ONE_DEGREE, forward[:, 1] * 0.005)
    off = max(abs(between - [steady_force(model, v) for v in speeds])) / 0.005
    assert off <= 1.3 * largest + 1e-6


def test_without_an_axis_units_are_si(model, tmp_path):
    exported(model, tmp_path, "table")
    assert "\nvelocity [rad/s],effort [N*m]\n" in (tmp_path / "table" / "axis_x.csv").read_text()


def listed(path):
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {key.removeprefix("frict_comp."): float(value) for key, value in lines}


def test_the_list_of_the_cnc_reads_back(model, tmp_path):
    result = exported(model, tmp_path, "tf5200", axis=br.read_axis(AXIS), points=5)
    path = tmp_path / "tf5200" / "axis_x.txt"
    values = listed(path)
    count = int(values["table_entries"])
    assert values["mode"] == 3.0
    assert 2 <= count <= 5
    speeds = [values[f"table[{i}].in"] for i in range(count)]
    assert speeds[0] == 0.0
    assert speeds == sorted(speeds)
    for i in range(1, count):
        speed = speeds[i] * 1e-3 * ONE_DEGREE
        mean = 0.5 * (steady_force(model, speed) - steady_force(model, -speed))
        assert values[f"table[{i}].out"] * 0.0005 == pytest.approx(mean, abs=0.0003)
    text = " ".join(result.notes)
    assert "the memory of the model is lost" in text
    wrong = 0.5 * (0.15 - 0.12) / 0.005
    assert float(re.search(r"wrong by up to ([\d.]+) %", text)[1]) == pytest.approx(wrong, rel=0.02)
    assert all(note in path.read_text() for note in result.notes)


def test_an_entry_is_omitted_only_if_it_equals_both_neighbours():
    entries = np.column_stack([1e-3 * np.arange(6), [10.0, 10.0, 10.0, 20.0, 20.0, 30.0]])
    kept = merged(Side(entries, entries), DriveUnit("0.1 % of rated", 1.0), "translational").entries
    assert kept[:, 0].tolist() == entries[[0, 2, 3, 4, 5], 0].tolist()
    assert np.interp(entries[:, 0], *kept.T).tolist() == entries[:, 1].tolist()


def test_the_distance_of_a_reversal_is_that_of_the_contact(tmp_path):
    stiff, soft = (br.friction.lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=stiffness) for stiffness in (1e8, 1e6))
    distances = []
    for name, model in (("stiff", stiff), ("soft", soft)):
        text = " ".join(br.export(model, "table", tmp_path / name, speed=0.1).notes)
        distances.append(float(re.search(r"over ([\d.e-]+) m", text)[1]))
    # Of the change of a bristle that slips exponentially, exp(-x sigma_0 / F_C) is left: 5 % after ln 20.
    assert distances[1] == pytest.approx(np.log(20.0) * 1e-5, rel=0.1)
    assert distances[1] / distances[0] == pytest.approx(100.0, rel=0.1)


def test_coulomb_friction_loses_no_memory(tmp_path):
    notes = br.export(br.friction.coulomb(F_C=2.0), "table", tmp_path / "out", speed=0.1).notes
    assert not any("memory" in note for note in notes)


def test_a_table_requires_a_speed(model, tmp_path):
    with pytest.raises(br.core.InputError, match="speed"):
        br.export(model, "table", tmp_path / "out")
    with pytest.raises(br.core.InputError, match="change at run time"):
        br.export(model, "table", tmp_path / "out", speed=1.0, tunable=True)


@pytest.mark.slow
@pytest.mark.parametrize("points", [4, 20, 100])
@pytest.mark.parametrize("v_S", [2e-3, 0.0873])
def test_the_stated_deviation_also_bounds_errors_between_points(points, v_S):
    model = br.friction.lugre(F_C=65.0, F_S=85.0, v_S=v_S, sigma_0=1.5e5, sigma_1=150.0, sigma_2=4.0)
    side = side_of(model, 1.0, 4.0, points)
    speeds = np.union1d(np.geomspace(1e-5, 4.0, 1500), np.linspace(1e-5, 4.0, 1500))
    steady = np.array([steady_force(model, v) for v in speeds])
    off = np.max(np.abs(np.interp(speeds, *side.entries.T) - steady))
    assert off <= 1.01 * side.deviation
    assert side.deviation < 1.2 * off + 1e-4 * 85.0


@pytest.mark.parametrize("against", [(), ("position",), ("effort",), ("position", "effort")])
def test_a_table_is_read_back_for_any_signs_of_the_columns(against):
    columns = {
        name: {"column": name[0], "unit": unit} | ({"sign": -1} if name in against else {})
        for name, unit in (("time", "s"), ("position", "deg"), ("effort", "N*m"))
    }
    axis = br.read_axis({"schema": 1, "kind": "rotational", "columns": columns})
    uneven = br.friction.with_slots(br.friction.coulomb, ["asymmetry"])(kind="rotational", F_C_pos=0.3, F_C_neg=0.2, offset=0.05)
    request = Request(uneven, "axis_x", 1e-3, axis=axis, speed=2.0, points=8, rest="held")
    product = write(request)
    x = np.array([0.0, 1e-3, 2e-3, 1e-3, 1e-3])
    assert reads(product.files, request)(x, 1e-3) == pytest.approx([0.05 + 0.05, 0.35, 0.35, -0.15, -0.15])
    reported = any("counts effort and position in opposite directions" in note for note in product.notes)
    assert reported == (len(against) == 1)
    rows = [line.split(",") for line in product.files["axis_x.csv"].splitlines() if not line.startswith("#")][1:]
    velocities = [float(velocity) for velocity, _ in rows]
    assert velocities == sorted(velocities)


@pytest.mark.parametrize(("points", "taken"), [(2, False), (4, True), (2000, True), (2001, False)])
def test_a_table_has_two_to_a_thousand_entries_for_each_direction(points, taken):
    request = Request(br.friction.coulomb(F_C=2.0), "axis_x", 1e-3, speed=0.1, points=points, rest="held")
    if taken:
        assert "axis_x.csv" in write(request).files
        assert len(side_of(request.model, 1.0, 0.1, points // 2).entries) == 2
    else:
        with pytest.raises(br.core.InputError, match=r"points: out of range; found '?\d+'?, allowed 3 to 2000"):
            write(request)


@pytest.mark.parametrize("points", [1, 1001])
def test_a_direction_has_two_to_a_thousand_entries(points):
    with pytest.raises(br.core.InputError, match="allowed 2 to 1000"):
        side_of(br.friction.coulomb(F_C=2.0), 1.0, 0.1, points)


@pytest.mark.parametrize("speed", [0.0, -1.0, np.inf])
def test_a_table_ends_at_a_speed_above_zero(speed):
    with pytest.raises(br.core.InputError, match="the largest speed of the axis"):
        side_of(br.friction.coulomb(F_C=2.0), 1.0, speed, 4)
