"""Tables for drives: the steady friction in the units of the drive, and what they lose in numbers."""

import re

import numpy as np
import pytest
from tests.exports.drives import ARM, LINEAR, SCREW, STRIBECK, TURNING, listed, product_of, rows_of
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.engine import force_along
from bristle.engine.contact import steady_force
from bristle.exports.drive import reads, side_of, write
from bristle.exports.targets import Request

ONE_DEGREE = np.pi / 180.0
SIDED = br.friction.with_slots(br.friction.lugre, ["asymmetry"])(
    kind="rotational", F_C_pos=0.1, F_C_neg=0.08, F_S_pos=0.15, F_S_neg=0.12, v_S=0.5, sigma_0=100.0, sigma_2_pos=0.02, sigma_2_neg=0.02
)
UNEVEN = br.friction.with_slots(br.friction.coulomb_viscous, ["asymmetry"])(
    F_C_pos=90.0, F_C_neg=70.0, F_v_pos=100.0, F_v_neg=100.0, offset=-30.0
)
FINE = SCREW | {"effort": {"rated": f"{1.0 / (40.0 * np.pi)!r} N*m"}, "transmission": {"lead": "50 mm"}}


def numbers_of(product, end="axis_x.csv"):
    head, *rows = rows_of(product, end)
    return head, np.array(rows, dtype=float)


# --- curves -------------------------------------------------------------------------------------------------------


def test_the_table_is_the_steady_friction_in_the_units_of_the_log():
    product = product_of("table", SIDED, TURNING, points=6, speed=20.0)
    head, table = numbers_of(product)
    assert head == ["velocity [deg/s]", "effort [%]"]
    assert len(table) <= 12
    assert np.all(np.diff(table[:, 0]) >= 0.0)
    for velocity, effort in table[table[:, 0] != 0.0]:
        assert effort * 0.005 == pytest.approx(steady_force(SIDED, velocity * ONE_DEGREE), rel=1e-6)
    largest = float(re.search(r"by at most ([\d.e-]+) %", " ".join(product.notes))[1])
    speeds = np.linspace(0.01, 20.0, 300)
    forward = table[np.signbit(table[:, 0]) == 0]
    between = np.interp(speeds, forward[:, 0] * ONE_DEGREE, forward[:, 1] * 0.005)
    off = max(abs(between - [steady_force(SIDED, v) for v in speeds])) / 0.005
    assert off <= 1.3 * largest + 1e-6


def test_without_an_axis_units_are_si():
    assert rows_of(product_of("table", SIDED, speed=20.0))[0] == ["velocity [rad/s]", "effort [N*m]"]


def test_a_second_file_is_in_the_units_of_the_drive():
    product = product_of("table", axis=SCREW, points=8)
    heads, rows = numbers_of(product, "axis_x_drive.csv")
    assert heads == ["velocity [rpm of the motor]", "effort [% of rated]"]
    assert "axis_x_drive.csv: % of rated over rpm of the motor" in product.notes
    for rpm, percent in rows[rows[:, 0] != 0.0]:
        assert percent / 100.0 * 2.0 / ARM == pytest.approx(steady_force(STRIBECK, rpm / 60.0 / 2.0 * 0.01), rel=1e-6)


@pytest.mark.parametrize(("points", "rows"), [(4, 4), (5, 4), (20, 20)])
def test_points_count_both_directions(points, rows):
    assert len(numbers_of(product_of("table", points=points))[1]) == rows


@pytest.mark.parametrize(
    ("axis", "words"),
    [(LINEAR, "no rated effort: efforts are in A"), (None, "no axis file was given, so the units are SI at the axis"), (SCREW, "")],
)
def test_a_missing_rated_effort_is_reported(axis, words):
    notes = " ".join(product_of("table", axis=axis).notes)
    assert words in notes
    assert words or "rated effort" not in notes


@pytest.mark.parametrize("axis", [LINEAR, None])
def test_a_list_of_integers_requires_the_rated_effort(axis):
    with pytest.raises(br.core.InputError, match=r"needs the rated effort.*rated = "):
        product_of("tf5200", axis=axis)


def test_the_list_of_the_cnc_is_the_mean_of_both_directions():
    product = product_of("tf5200", SIDED, TURNING, points=5, speed=20.0)
    values = listed(product)
    count = int(values["table_entries"])
    assert 2 <= count <= 5
    speeds = [values[f"table[{i}].in"] for i in range(count)]
    assert speeds == sorted(speeds)
    for i in range(1, count):
        speed = speeds[i] * 1e-3 * ONE_DEGREE
        mean = 0.5 * (steady_force(SIDED, speed) - steady_force(SIDED, -speed))
        assert values[f"table[{i}].out"] * 0.0005 == pytest.approx(mean, abs=0.0003)
    text = " ".join(product.notes)
    assert "the memory of the model is lost" in text
    assert float(re.search(r"wrong by up to ([\d.]+) %", text)[1]) == pytest.approx(0.5 * (0.15 - 0.12) / 0.005, rel=0.02)
    assert all(note in product.files["axis_x.txt"] for note in product.notes)


def test_the_distance_of_a_reversal_is_that_of_the_contact():
    distances = []
    for stiffness in (1e8, 1e6):
        text = " ".join(product_of("table", br.friction.lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=stiffness)).notes)
        distances.append(float(re.search(r"over ([\d.e-]+) m", text)[1]))
    # Of the change of a bristle that slips exponentially, exp(-x sigma_0 / F_C) is left: 5 % after ln 20.
    assert distances == pytest.approx([np.log(20.0) * 1e-7, np.log(20.0) * 1e-5], rel=0.1)


def test_coulomb_friction_loses_no_memory():
    assert not any("memory" in note for note in product_of("table", br.friction.coulomb(F_C=2.0)).notes)


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
    velocities = numbers_of(product)[1][:, 0]
    assert np.all(np.diff(velocities) >= 0.0)


@pytest.mark.parametrize("points", [4, 2000])
def test_a_table_has_two_to_a_thousand_entries_for_each_direction(points):
    assert "axis_x.csv" in product_of("table", br.friction.coulomb(F_C=2.0), points=points).files


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda model: product_of("table", model, points=2), r"points: out of range; found '?2'?, allowed 3 to 2000"),
        (lambda model: product_of("table", model, points=2001), r"points: out of range; found '?2001'?, allowed 3 to 2000"),
        (lambda model: side_of(model, 1.0, 0.1, 1), "allowed 2 to 1000"),
        (lambda model: side_of(model, 1.0, 0.1, 1001), "allowed 2 to 1000"),
        *((lambda model, speed=speed: side_of(model, 1.0, speed, 4), "the largest speed of the axis") for speed in (0.0, -1.0, np.inf)),
    ],
)
def test_counts_and_speeds_out_of_range_are_refused(call, words):
    with pytest.raises(br.core.InputError, match=words):
        call(br.friction.coulomb(F_C=2.0))


# --- three values -------------------------------------------------------------------------------------------------


def values_of(product):
    head, *rows = rows_of(product)
    assert head == ["value", "amount", "unit", "meaning"]
    assert any("gravity - F-" in meaning for name, _, _, meaning in rows if name == "F-")
    return {(name, unit): float(amount) for name, amount, unit, _ in rows}


def test_three_values_give_the_friction_back_in_each_unit():
    product = product_of("table", UNEVEN, SCREW, points=3, plant=br.plants.inertia(M=40.0))
    values = values_of(product)
    newton = {name: values[name, "N"] for name in ("gravity", "F+", "F-")}
    for speed in (1e-6, 0.1, 0.2):
        forward, backward = (values[name, "N*s/m"] * speed for name in ("D+", "D-"))
        assert newton["gravity"] + newton["F+"] + forward == pytest.approx(steady_force(UNEVEN, speed), rel=1e-6)
        assert newton["gravity"] - newton["F-"] - backward == pytest.approx(steady_force(UNEVEN, -speed), rel=1e-6)
    for name, force in newton.items():
        assert values[name, "N*m at the motor"] == pytest.approx(force * ARM, rel=1e-8)
        assert values[name, "% of rated"] == pytest.approx(100.0 * force * ARM / 2.0, rel=1e-8)
    assert values["inertia", "kg"] == 40.0
    assert values["inertia", "kg*m^2 at the motor"] == pytest.approx(40.0 * ARM**2, rel=1e-8)
    (text,) = [note for note in product.notes if "below the steady friction of the model, and never above it" in note]
    assert float(re.search(r"the level alone is at most ([\d.]+) N", text)[1]) == pytest.approx(20.0)


def test_without_a_plant_a_note_says_that_the_inertia_is_unknown():
    product = product_of("table", points=3)
    assert not any(name == "inertia" for name, _ in values_of(product))
    assert any("inertia is unknown" in note for note in product.notes)


# --- along a log --------------------------------------------------------------------------------------------------

MOTION = sines(duration=1.0)


def log_along(model):
    return log_of(MOTION, 12.0 * MOTION.acceleration + force_along(model, MOTION.velocity, 1e-3))


def error_told(target, model, **options):
    """Return the largest and the mean error along the log of a model, and what was written."""
    product = product_of(target, model, **{"speed": 0.15, "log": log_along(model)} | options)
    message = next(note for note in product.notes if "largest error" in note)
    return *map(float, re.search(r"([\d.e+-]+) \S+, rms ([\d.e+-]+)", message).groups()), product


def test_the_largest_error_of_a_table_on_a_log_is_that_of_its_lines():
    largest, rms, product = error_told("table", STRIBECK, points=4)
    _, table = numbers_of(product)
    velocity = MOTION.velocity
    speeds = np.abs(velocity)
    side = np.interp(speeds, table[2:, 0], table[2:, 1]), np.interp(speeds, *(-table[1::-1]).T)
    friction = [steady_force(STRIBECK, v) if v > 0 else -steady_force(STRIBECK, v) for v in velocity.tolist()]
    gap = np.abs(np.where(velocity > 0.0, *side) - friction)
    assert largest == pytest.approx(np.max(gap), rel=0.02)
    assert rms == pytest.approx(np.sqrt(np.mean(gap**2)), rel=0.05)


def test_the_memory_loss_of_a_table_is_its_jump():
    (largest, soft, _), (_, stiff, _) = (
        error_told("tf5200", br.friction.lugre(F_C=8.0, F_S=8.0, v_S=4e-3, sigma_0=stiffness), axis=FINE) for stiffness in (1e5, 1e6)
    )
    assert largest == pytest.approx(16.0, rel=0.1)
    assert stiff < 0.7 * soft


def test_the_error_of_levels_on_a_log_is_their_distance_from_the_curve():
    fastest = float(np.max(np.abs(MOTION.velocity)))
    straight = br.friction.find("coulomb_viscous")(F_C=8.0, F_v=30.0, offset=1.5)
    assert error_told("table", straight, speed=fastest, points=3)[0] < 1e-6
    curved = br.friction.find("stribeck")(F_C=8.0, F_S=11.0, v_S=0.05, F_v=30.0)
    largest, _, product = error_told("table", curved, speed=fastest, points=3)
    speeds, values = np.linspace(0.0, fastest, 500), values_of(product)
    line = values["F+", "N"] + values["D+", "N*s/m"] * speeds
    short = np.array([steady_force(curved, max(v, 1e-9)) for v in speeds]) - line
    assert np.min(short) > -1e-4
    assert largest == pytest.approx(np.max(short), rel=0.05)


def test_the_constant_force_does_not_count_as_an_error_of_a_symmetric_table():
    largest, _, product = error_told("tf5200", br.friction.find("coulomb")(F_C=8.0, offset=40.0), axis=FINE)
    assert largest < 0.5e-3  # half a step of the list, in N
    assert not any("same for both directions" in note for note in product.notes)
