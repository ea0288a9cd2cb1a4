"""Three values, start values for a control, cogging, and what a table loses on a log: each file is read back."""

import re

import numpy as np
import pytest
from tests.exports.test_drive import AXIS, listed
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.core.contracts import Reference
from bristle.engine import force_along
from bristle.engine.contact import steady_force
from bristle.plants.terms import effort_of_place

STRIBECK = br.friction.find("stribeck")(F_C=8.0, F_S=11.0, v_S=4e-3, F_v=30.0, offset=2.5)
LINEAR = {
    "schema": 1,
    "kind": "translational",
    "columns": {"time": {"column": "t", "unit": "s"}, "position": {"column": "q", "unit": "mm"}, "effort": {"column": "u", "unit": "A"}},
    "effort": {"force_constant": "50 N/A"},
}
SCREW = {
    "schema": 1,
    "kind": "translational",
    "columns": {"time": {"column": "t", "unit": "s"}, "position": {"column": "q", "unit": "mm"}, "effort": {"column": "u", "unit": "N"}},
    "effort": {"rated": "2 N*m"},
    "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
}
FINE = br.read_axis(SCREW | {"effort": {"rated": f"{1.0 / (40.0 * np.pi)!r} N*m"}, "transmission": {"lead": "50 mm"}})
LOOP = {"controller": {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm", "T_n": "20 ms"}}


def values_in(folder):
    lines = (folder / "axis_x.csv").read_text().splitlines()
    head, *rows = [line for line in lines if not line.startswith("#")]
    assert head == "value,amount,unit,meaning"
    assert "gravity - F-" in next(row for row in rows if row.startswith("F-,"))
    return {(name, unit): float(amount) for name, amount, unit, _ in (row.split(",") for row in rows)}


def numbers_in(path):
    rows = [row for row in path.read_text().splitlines() if not row.startswith("#")]
    return rows[0].split(","), [row.split(",") for row in rows[1:]]


def test_three_values_give_the_friction_back_in_each_unit(tmp_path):
    model = br.friction.with_slots(br.friction.coulomb_viscous, ["asymmetry"])(
        F_C_pos=90.0, F_C_neg=70.0, F_v_pos=100.0, F_v_neg=100.0, offset=-30.0
    )
    plant = br.plants.inertia(M=40.0)
    result = br.export(model, "table", tmp_path / "out", points=3, speed=0.2, axis=br.read_axis(SCREW), plant=plant)
    values = values_in(tmp_path / "out")
    newton = {"gravity": values["gravity", "N"], "F+": values["F+", "N"], "F-": values["F-", "N"]}
    for speed in (1e-6, 0.1, 0.2):
        forward, backward = (values[name, "N*s/m"] * speed for name in ("D+", "D-"))
        assert newton["gravity"] + newton["F+"] + forward == pytest.approx(steady_force(model, speed), rel=1e-6)
        assert newton["gravity"] - newton["F-"] - backward == pytest.approx(steady_force(model, -speed), rel=1e-6)
    torque = 0.01 / (2.0 * np.pi * 2.0)
    for name, force in newton.items():
        assert values[name, "N*m at the motor"] == pytest.approx(force * torque, rel=1e-8)
        assert values[name, "% of rated"] == pytest.approx(100.0 * force * torque / 2.0, rel=1e-8)
    assert values["inertia", "kg"] == 40.0
    assert values["inertia", "kg*m^2 at the motor"] == pytest.approx(40.0 * torque**2, rel=1e-8)
    (text,) = [note for note in result.notes if "below the steady friction of the model, and never above it" in note]
    assert float(re.search(r"the level alone is at most ([\d.]+) N", text)[1]) == pytest.approx(20.0)


def test_without_a_plant_a_note_says_that_the_inertia_is_unknown(tmp_path):
    result = br.export(STRIBECK, "table", tmp_path / "out", points=3, speed=0.2)
    assert not any(name == "inertia" for name, _ in values_in(tmp_path / "out"))
    assert any("inertia is unknown" in note for note in result.notes)


@pytest.mark.parametrize(("points", "rows"), [(4, 4), (5, 4), (20, 20)])
def test_points_count_both_directions(tmp_path, points, rows):
    br.export(STRIBECK, "table", tmp_path / "out", points=points, speed=0.2)
    assert len(numbers_in(tmp_path / "out" / "axis_x.csv")[1]) == rows


def test_a_second_file_is_in_the_units_of_the_drive(tmp_path):
    result = br.export(STRIBECK, "table", tmp_path / "out", points=8, speed=0.2, axis=br.read_axis(SCREW))
    heads, rows = numbers_in(tmp_path / "out" / "axis_x_drive.csv")
    assert heads == ["velocity [rpm of the motor]", "effort [% of rated]"]
    assert "axis_x_drive.csv: % of rated over rpm of the motor" in result.notes
    for rpm, percent in np.array(rows, dtype=float):
        if rpm:
            torque = percent / 100.0 * 2.0
            assert torque / (0.01 / (2.0 * np.pi * 2.0)) == pytest.approx(steady_force(STRIBECK, rpm / 60.0 / 2.0 * 0.01), rel=1e-6)


@pytest.mark.parametrize(
    ("axis", "words"),
    [
        (br.read_axis(LINEAR), "no rated effort: efforts are in A"),
        (None, "no axis file was given, so the units are SI at the axis"),
        (br.read_axis(SCREW), ""),
    ],
)
def test_a_missing_rated_effort_is_reported(tmp_path, axis, words):
    notes = " ".join(br.export(STRIBECK, "table", tmp_path / "out", speed=0.2, axis=axis).notes)
    assert words in notes
    assert words or "rated effort" not in notes


@pytest.mark.parametrize("axis", [br.read_axis(LINEAR), None])
def test_a_list_of_integers_requires_the_rated_effort(tmp_path, axis):
    with pytest.raises(br.core.InputError, match=r"needs the rated effort.*rated = "):
        br.export(STRIBECK, "tf5200", tmp_path / "out", speed=0.2, axis=axis)
    assert not (tmp_path / "out").exists()


def test_currents_are_per_mille_of_rated_for_any_source_of_the_rated_effort(tmp_path):
    result = br.export(STRIBECK, "tf5200", tmp_path / "out", speed=0.2, points=2, axis=br.read_axis(SCREW))
    values = listed(tmp_path / "out" / "axis_x.txt")
    force = 0.5 * (steady_force(STRIBECK, 0.2) - steady_force(STRIBECK, -0.2))
    assert values["table[1].out"] == pytest.approx(1000.0 * force * 0.01 / (4.0 * np.pi) / 2.0, abs=0.5)
    assert any(re.search(r"does not contain the constant force of 2\.5 N", note) for note in result.notes)


def test_entries_equal_after_rounding_merge_and_a_delay_out_of_range_is_reported(tmp_path):
    flat = br.friction.lugre(F_C=90.0, F_S=91.0, v_S=0.02, sigma_0=1e6)  # falls by less than half a per mille of rated
    result = br.export(flat, "tf5200", tmp_path / "out", speed=0.2, points=20, axis=br.read_axis(SCREW))
    values = listed(tmp_path / "out" / "axis_x.txt")
    assert values["table_entries"] == 2
    assert (values["table[0].in"], values["table[1].in"]) == (0, 2e5)
    assert values["table[0].out"] == values["table[1].out"] > 0
    assert "table[2].in" not in values
    assert values["position_delay"] == 10
    assert any(note.startswith("position_delay has its largest value, 10") for note in result.notes)
    soon = br.export(STRIBECK, "tf5200", tmp_path / "soon", speed=0.2, axis=br.read_axis(SCREW))
    assert not any("position_delay" in note for note in soon.notes)


def machine_data(path):
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith(";")]
    return {name.removeprefix("$MA_"): (number, float(value), *unit) for number, name, value, *unit in lines}


@pytest.mark.parametrize("kind", ["translational", "rotational"])
def test_the_pulse_of_a_sinumerik_commands_the_change_of_friction(tmp_path, kind):
    if kind == "translational":
        model, axis, si = STRIBECK, br.read_axis(LINEAR | LOOP), ("mm/min", 1e-3 / 60.0)
    else:
        loop = {"model": "cascade", "k_p": "30 1/s", "k_v": "0.4 N*m*s/rad", "T_n": "20 ms"}
        model = br.friction.coulomb(kind=kind, F_C=0.2)
        axis, si = br.read_axis(AXIS | {"controller": loop}), ("rev/min", 2.0 * np.pi / 60.0)
    br.export(model, "sinumerik", tmp_path / "out", speed=0.2, axis=axis)
    data = machine_data(tmp_path / "out" / "axis_x.txt")
    number, pulse, unit = data["FRICT_COMP_CONST_MAX"]
    assert (number, unit) == ("MD32520", si[0])
    number, lasts, unit = data["FRICT_COMP_TIME"]
    assert (number, unit) == ("MD32540", "s")
    law, dt = axis.controller, 1e-5
    state = law.component.start(0.0, 0.0, 0.0, dt, law.parameters)
    turns_by = steady_force(model, 1e-9) - steady_force(model, -1e-9)
    for k in range(5000):
        velocity = pulse * si[1] * np.exp(-k * dt / lasts)
        requested = Reference(velocity / law.values["k_p"], 0.0, 0.0)
        effort, state = law.component.step(state, requested, 0.0, dt, law.parameters)
        assert effort == pytest.approx(turns_by, rel=1e-3)


def test_sinumerik_files_contain_only_documented_machine_data(tmp_path):
    result = br.export(STRIBECK, "sinumerik", tmp_path / "out", speed=0.2, axis=br.read_axis(LINEAR | LOOP))
    text = (tmp_path / "out" / "axis_x.txt").read_text()
    data = machine_data(tmp_path / "out" / "axis_x.txt")
    assert {name: value[:2] for name, value in data.items() if name.split("_")[2] not in ("CONST", "TIME")} == {
        "FRICT_COMP_MODE": ("MD32490", 1.0),
        "FRICT_COMP_ENABLE": ("MD32500", 1.0),
        "FRICT_COMP_ADAPT_ENABLE": ("MD32510", 0.0),
    }
    assert "START VALUES: tune them with the circularity test" in text
    assert "6FC5397-1BP40-3BA1" in text
    assert any("start values" in note for note in result.notes)


def test_without_an_integral_no_time_constant_is_written(tmp_path):
    loop = {"controller": {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm"}}
    br.export(STRIBECK, "sinumerik", tmp_path / "out", speed=0.2, axis=br.read_axis(LINEAR | loop))
    assert "FRICT_COMP_TIME" not in machine_data(tmp_path / "out" / "axis_x.txt")
    assert "MD32540" in (tmp_path / "out" / "axis_x.txt").read_text()


@pytest.mark.parametrize("axis", [None, br.read_axis(LINEAR)])
def test_a_sinumerik_needs_the_gain_of_the_loop(tmp_path, axis):
    with pytest.raises(br.core.InputError, match="velocity loop"):
        br.export(STRIBECK, "sinumerik", tmp_path / "out", speed=0.2, axis=axis)


def plant_with(orders):
    from bristle.plants.terms import with_terms

    rng = np.random.default_rng(5)
    values = {f"motor_{order}_{part}": rng.normal() * 1e-2 for order in orders for part in ("cos", "sin")}
    component = with_terms(br.plants.inertia, cogging={"motor": orders})
    return component(kind="rotational", M=1e-3, motor_turn=2.0 * np.pi, **values)


def test_the_cogging_file_reproduces_the_effort_at_each_position(tmp_path):
    plant, friction = plant_with([6, 12, 36]), br.friction.coulomb(kind="rotational", F_C=0.1)
    br.export(friction, "cogging", tmp_path / "out", plant=plant, axis=br.read_axis(AXIS))
    heads, rows = numbers_in(tmp_path / "out" / "axis_x.csv")
    assert heads == ["order", "amplitude [%]", "phase [deg]", "turn of"]
    assert [float(row[1]) for row in rows] == sorted((float(row[1]) for row in rows), reverse=True)
    places = np.linspace(-4.0, 9.0, 200)
    effort = sum(
        float(amplitude) * np.cos(int(order) * places - np.radians(float(phase)))
        for order, amplitude, phase, turner in rows
        if turner == "motor"
    )
    assert 0.005 * effort == pytest.approx(effort_of_place(places, plant.parameters.terms), abs=1e-6)
    assert all(0.0 <= float(row[2]) < 360.0 for row in rows)


def test_nine_harmonics_are_written_and_the_rest_is_reported(tmp_path):
    orders = list(range(6, 72, 6))
    plant, friction = plant_with(orders), br.friction.coulomb(kind="rotational", F_C=0.1)
    result = br.export(friction, "cogging", tmp_path / "out", plant=plant)
    kept = [int(row[0]) for row in numbers_in(tmp_path / "out" / "axis_x.csv")[1]]
    assert len(kept) == 9
    left = re.search(r"omitted the orders ([\d, ]+), in total", " ".join(result.notes))[1]
    assert sorted([*kept, *(int(order) for order in left.split(", "))]) == orders


@pytest.mark.parametrize("plant", [None, br.plants.inertia(M=1.0)])
def test_missing_cogging_is_refused_by_name(tmp_path, plant):
    with pytest.raises(br.core.InputError, match=r"cogging: was not identified"):
        br.export(STRIBECK, "cogging", tmp_path / "out", plant=plant)


MOTION = sines(duration=4.0)


def error_told(result):
    message = next(note for note in result.notes if "largest error" in note)
    return [float(number) for number in re.search(r"([\d.e+-]+) \S+, rms ([\d.e+-]+)", message).groups()], message


def log_along(model):
    force = force_along(model, MOTION.velocity, 1e-3)
    return log_of(MOTION, 12.0 * MOTION.acceleration + force)


def test_the_largest_error_of_a_table_on_a_log_is_that_of_its_lines(tmp_path):
    log = log_along(STRIBECK)
    result = br.export(STRIBECK, "table", tmp_path / "out", speed=0.15, points=4, log=log)
    (largest, rms), message = error_told(result)
    table = np.array(numbers_in(tmp_path / "out" / "axis_x.csv")[1], dtype=float)
    speeds = np.abs(MOTION.velocity)
    side = np.interp(speeds, table[2:, 0], table[2:, 1]), np.interp(speeds, *(-table[1::-1]).T)
    friction = [steady_force(STRIBECK, v) if v > 0 else -steady_force(STRIBECK, v) for v in MOTION.velocity.tolist()]
    gap = np.abs(np.where(MOTION.velocity > 0.0, *side) - friction)
    assert largest == pytest.approx(np.max(gap), rel=0.02)
    assert rms == pytest.approx(np.sqrt(np.mean(gap**2)), rel=0.05)
    assert "along the log of the identification" not in message


def test_the_memory_loss_of_a_table_is_its_jump(tmp_path):
    soft = br.friction.lugre(F_C=8.0, F_S=8.0, v_S=4e-3, sigma_0=1e5)
    result = br.export(soft, "tf5200", tmp_path / "out", speed=0.15, axis=FINE, log=log_along(soft))
    (largest, rms), _ = error_told(result)
    assert largest == pytest.approx(16.0, rel=0.1)
    stiff = br.friction.lugre(F_C=8.0, F_S=8.0, v_S=4e-3, sigma_0=1e6)
    result = br.export(stiff, "tf5200", tmp_path / "one", speed=0.15, axis=FINE, log=log_along(stiff))
    (_, smaller), _ = error_told(result)
    assert smaller < 0.7 * rms


def test_the_error_of_levels_on_a_log_is_their_distance_from_the_curve(tmp_path):
    viscous = br.friction.find("coulomb_viscous")(F_C=8.0, F_v=30.0, offset=1.5)
    fastest = float(np.max(np.abs(MOTION.velocity)))
    result = br.export(viscous, "table", tmp_path / "out", speed=fastest, points=3, log=log_along(viscous))
    (largest, _), _ = error_told(result)
    assert largest < 1e-6  # a straight line loses nothing
    curved = br.friction.find("stribeck")(F_C=8.0, F_S=11.0, v_S=0.05, F_v=30.0)
    result = br.export(curved, "table", tmp_path / "curved", speed=fastest, points=3, log=log_along(curved))
    (largest, _), _ = error_told(result)
    speeds = np.linspace(0.0, fastest, 500)
    values = values_in(tmp_path / "curved")
    line = values["F+", "N"] + values["D+", "N*s/m"] * speeds
    short = np.array([steady_force(curved, max(v, 1e-9)) for v in speeds]) - line
    assert np.min(short) > -1e-4
    assert largest == pytest.approx(np.max(short), rel=0.05)


def test_the_constant_force_does_not_count_as_an_error_of_a_symmetric_table(tmp_path):
    heavy = br.friction.find("coulomb")(F_C=8.0, offset=40.0)
    result = br.export(heavy, "tf5200", tmp_path / "out", speed=0.15, axis=FINE, log=log_along(heavy))
    (largest, _), _ = error_told(result)
    assert largest < 0.5e-3  # half a step of the list, in N
    assert not any("same for both directions" in note for note in result.notes)


@pytest.mark.parametrize("target", ["c", "mjcf", "sinumerik"])
def test_only_tables_accept_a_log(tmp_path, target):
    with pytest.raises(br.core.InputError, match="is not a table"):
        br.export(br.friction.coulomb(F_C=1.0), target, tmp_path / "out", log=log_along(STRIBECK))
