"""Files for drives: the steady friction in their units, what a table loses, what each drive makes of its file, the effect on an axis."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.exports.drives import ARM, LINEAR, SCREW, STRIBECK, TURNING, listed, product_of, rows_of
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.cli.main import main
from bristle.engine.contact import sliding_level, steady_force
from bristle.exports import ax8000, cogging, sinumerik, tf5200
from bristle.exports.described import Request, Source
from bristle.exports.drive import Side, levels_and_curves, reads, side_of, write
from bristle.exports.loops import loop_for
from bristle.exports.moves import turning_distance
from bristle.exports.targets import TARGETS
from bristle.exports.tf5200 import merged
from bristle.exports.writing import files_for
from bristle.files.axis import axis_from
from bristle.prediction.drive_table import LevelValues, reversal_distance
from bristle.prediction.drive_units import DriveUnit

ONE_DEGREE = np.pi / 180.0
SIDED = br.friction.with_slots(br.friction.lugre, ["asymmetry"])(
    kind="rotational",
    F_C_pos=0.1,
    F_C_neg=0.08,
    F_S_pos=0.15,
    F_S_neg=0.12,
    v_S=0.5,
    sigma_0=100.0,
    sigma_2_pos=0.02,
    sigma_2_neg=0.02,
)
UNEVEN = br.friction.with_slots(br.friction.coulomb_viscous, ["asymmetry"])(
    F_C_pos=90.0, F_C_neg=70.0, F_v_pos=100.0, F_v_neg=100.0, offset=-30.0
)
FINE = SCREW | {
    "effort": {"rated": f"{1.0 / (40.0 * np.pi)!r} N*m"},
    "transmission": {"lead": "50 mm"},
}


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
    assert rows_of(product_of("table", SIDED, speed=20.0))[0] == [
        "velocity [rad/s]",
        "effort [N*m]",
    ]


def test_a_second_file_is_in_the_units_of_the_drive():
    product = product_of("table", axis=SCREW, points=8)
    heads, rows = numbers_of(product, "axis_x_drive.csv")
    assert heads == ["velocity [rpm of the motor]", "effort [% of rated]"]
    assert "axis_x_drive.csv: % of rated over rpm of the motor" in product.notes
    for rpm, percent in rows[rows[:, 0] != 0.0]:
        assert percent / 100.0 * 2.0 / ARM == pytest.approx(
            steady_force(STRIBECK, rpm / 60.0 / 2.0 * 0.01), rel=1e-6
        )


@pytest.mark.parametrize(("points", "rows"), [(4, 4), (5, 4), (20, 20)])
def test_points_count_both_directions(points, rows):
    assert len(numbers_of(product_of("table", points=points))[1]) == rows


@pytest.mark.parametrize(
    ("axis", "words"),
    [
        (LINEAR, "no rated effort: efforts are in A"),
        (None, "no axis file was given, so the units are SI at the axis"),
        (SCREW, ""),
    ],
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
    assert float(re.search(r"wrong by up to ([\d.]+) %", text)[1]) == pytest.approx(
        0.5 * (0.15 - 0.12) / 0.005, rel=0.02
    )
    assert all(note in product.files["axis_x.txt"] for note in product.notes)


def test_the_distance_of_a_reversal_is_that_of_the_contact():
    distances = []
    for stiffness in (1e8, 1e6):
        text = " ".join(
            product_of(
                "table", br.friction.lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=stiffness)
            ).notes
        )
        distances.append(float(re.search(r"over ([\d.e-]+) m", text)[1]))
    # Of the change of a bristle that slips exponentially, exp(-x sigma_0 / F_C) is left: 5 % after ln 20.
    assert distances == pytest.approx([np.log(20.0) * 1e-7, np.log(20.0) * 1e-5], rel=0.1)


def test_coulomb_friction_loses_no_memory():
    assert not any(
        "memory" in note for note in product_of("table", br.friction.coulomb(F_C=2.0)).notes
    )


@pytest.mark.slow
@pytest.mark.parametrize("points", [4, 20, 100])
@pytest.mark.parametrize("v_S", [2e-3, 0.0873])
def test_the_stated_deviation_also_bounds_errors_between_points(points, v_S):
    model = br.friction.lugre(
        F_C=65.0, F_S=85.0, v_S=v_S, sigma_0=1.5e5, sigma_1=150.0, sigma_2=4.0
    )
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
    uneven = br.friction.with_slots(br.friction.coulomb, ["asymmetry"])(
        kind="rotational", F_C_pos=0.3, F_C_neg=0.2, offset=0.05
    )
    request = Request(uneven, "axis_x", 1e-3, axis=axis, speed=2.0, points=8, rest="held")
    product = write(request)
    x = np.array([0.0, 1e-3, 2e-3, 1e-3, 1e-3])
    assert reads(product.files, request)(x, 1e-3) == pytest.approx(
        [0.05 + 0.05, 0.35, 0.35, -0.15, -0.15]
    )
    reported = any(
        "counts effort and position in opposite directions" in note for note in product.notes
    )
    assert reported == (len(against) == 1)
    velocities = numbers_of(product)[1][:, 0]
    assert np.all(np.diff(velocities) >= 0.0)


@pytest.mark.parametrize("points", [4, 2000])
def test_a_table_has_two_to_a_thousand_entries_for_each_direction(points):
    assert "axis_x.csv" in product_of("table", br.friction.coulomb(F_C=2.0), points=points).files


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda model: product_of("table", model, points=2),
            r"points: out of range; found '?2'?, allowed 3 to 2000",
        ),
        (
            lambda model: product_of("table", model, points=2001),
            r"points: out of range; found '?2001'?, allowed 3 to 2000",
        ),
        (lambda model: side_of(model, 1.0, 0.1, 1), "allowed 2 to 1000"),
        (lambda model: side_of(model, 1.0, 0.1, 1001), "allowed 2 to 1000"),
        *(
            (
                lambda model, speed=speed: side_of(model, 1.0, speed, 4),
                "the largest speed of the axis",
            )
            for speed in (0.0, -1.0, np.inf)
        ),
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
        assert newton["gravity"] + newton["F+"] + forward == pytest.approx(
            steady_force(UNEVEN, speed), rel=1e-6
        )
        assert newton["gravity"] - newton["F-"] - backward == pytest.approx(
            steady_force(UNEVEN, -speed), rel=1e-6
        )
    for name, force in newton.items():
        assert values[name, "N*m at the motor"] == pytest.approx(force * ARM, rel=1e-8)
        assert values[name, "% of rated"] == pytest.approx(100.0 * force * ARM / 2.0, rel=1e-8)
    assert values["inertia", "kg"] == 40.0
    assert values["inertia", "kg*m^2 at the motor"] == pytest.approx(40.0 * ARM**2, rel=1e-8)
    (text,) = [
        note
        for note in product.notes
        if "below the steady friction of the model, and never above it" in note
    ]
    assert float(re.search(r"the level alone is at most ([\d.]+) N", text)[1]) == pytest.approx(
        20.0
    )


def test_without_a_plant_a_note_says_that_the_inertia_is_unknown():
    product = product_of("table", points=3)
    assert not any(name == "inertia" for name, _ in values_of(product))
    assert any("inertia is unknown" in note for note in product.notes)


# --- along a log --------------------------------------------------------------------------------------------------

MOTION = sines(duration=1.0)


def log_along(model):
    return log_of(
        MOTION, 12.0 * MOTION.acceleration + br.engine.force_along(model, MOTION.velocity, 1e-3)
    )


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
    friction = [
        steady_force(STRIBECK, v) if v > 0 else -steady_force(STRIBECK, v)
        for v in velocity.tolist()
    ]
    gap = np.abs(np.where(velocity > 0.0, *side) - friction)
    assert largest == pytest.approx(np.max(gap), rel=0.02)
    assert rms == pytest.approx(np.sqrt(np.mean(gap**2)), rel=0.05)


def test_the_memory_loss_of_a_table_is_its_jump():
    (largest, soft, _), (_, stiff, _) = (
        error_told(
            "tf5200", br.friction.lugre(F_C=8.0, F_S=8.0, v_S=4e-3, sigma_0=stiffness), axis=FINE
        )
        for stiffness in (1e5, 1e6)
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
    largest, _, product = error_told(
        "tf5200", br.friction.find("coulomb")(F_C=8.0, offset=40.0), axis=FINE
    )
    assert largest < 0.5e-3  # half a step of the list, in N
    assert not any("same for both directions" in note for note in product.notes)


STRAIGHT = br.friction.coulomb_viscous(F_C=8.0, F_v=30.0)
SOFT = br.friction.dahl(F_C=8.0, sigma_0=4e5)
GEARED = br.read_axis(SCREW)


def ax8000_request(model, axis=None):
    return Request(model, "axis_x", 1e-3, speed=0.2, axis=axis)


def objects(model, axis=None):
    product = ax8000.write(ax8000_request(model, axis))
    lines = [
        line.split(",")
        for line in product.files["axis_x.csv"].splitlines()
        if line.startswith("0x")
    ]
    return {index: (float(value), unit) for index, value, unit, _ in lines}, product


PUSHING = br.friction.with_slots(br.friction.coulomb_viscous, ["asymmetry"])(
    F_C_pos=9.0, F_C_neg=5.0, F_v_pos=3.0, F_v_neg=1.0, offset=2.0
)
# Of a bristle that slips exponentially 5 % of the change are left after ln 20 of F_C over its stiffness.
SPRING = 0.95 * 16.0 / (np.log(20.0) * 8.0 / 4e5)


@pytest.mark.parametrize(
    ("model", "axis", "expected", "words", "absent"),
    [
        # Level and slope, but no spring; then a spring; both at the motor behind a gear; the mean of both directions.
        (
            STRAIGHT,
            None,
            {2: (8.0, "N"), 3: (30.0, "N*s/m")},
            "0x3144:01 is not written",
            "constant force",
        ),
        (
            SOFT,
            None,
            {1: (SPRING, "N/m"), 2: (8.0, "N")},
            "95 % of the friction reverses",
            "wrong by",
        ),
        (
            STRAIGHT,
            GEARED,
            {2: (8.0 * ARM, "N*m"), 3: (30.0 * ARM**2, "N*m*s/rad")},
            "",
            "wrong by",
        ),
        (SOFT, GEARED, {1: (SPRING * ARM**2, "N*m/rad"), 2: (8.0 * ARM, "N*m")}, "", "wrong by"),
        (
            PUSHING,
            None,
            {2: (7.0, "N"), 3: (2.0, "N*s/m")},
            "wrong by 2 N in each",
            "0x3144:01 is set",
        ),
        (
            PUSHING,
            None,
            {2: (7.0, "N")},
            "do not contain the constant force of 2 N",
            "0x3144:01 is set",
        ),
    ],
)
def test_objects_are_spring_level_and_slope_in_units_of_the_motor(
    model, axis, expected, words, absent
):
    values, product = objects(model, axis)
    assert ("0x3144:01" in values) == (model is SOFT)
    for place, (value, unit) in expected.items():
        assert values[f"0x3144:0{place}"] == (
            pytest.approx(value, rel=0.1 if place == 1 else 1e-6),
            unit,
        )
    text = " ".join(product.notes)
    assert words in text
    assert absent not in text


@pytest.mark.parametrize("axis", [None, GEARED])
def test_the_drive_turns_the_spring_between_both_levels(axis):
    request = ax8000_request(SOFT, axis)
    drive = ax8000.reads(ax8000.write(request).files, request)
    dt, spring = 1e-3, SPRING
    x = np.concatenate([[0.0, 1e-5, 2e-5], np.linspace(2e-5, 1e-3, 50)[1:], [1e-3 - 1e-5]])
    force = drive(x, dt)
    assert force[0] == 0.0
    assert force[1:3] == pytest.approx([spring * 1e-5, spring * 2e-5], rel=0.1)
    assert force[-2] == pytest.approx(8.0, rel=1e-6)
    assert force[-1] == pytest.approx(8.0 - spring * 1e-5, rel=0.1)
    assert drive(-x, dt) == pytest.approx(-force)


def test_without_a_spring_a_drive_follows_the_last_direction():
    request = ax8000_request(STRAIGHT, GEARED)
    drive = ax8000.reads(ax8000.write(request).files, request)
    x, dt = np.array([0.0, 0.0, 1e-4, 2e-4, 2e-4, 1e-4]), 1e-3
    assert drive(x, dt) == pytest.approx([0.0, 0.0, 11.0, 11.0, 8.0, -11.0], rel=1e-6)


def test_a_line_with_negative_intercept_has_no_level(monkeypatch):
    levels = LevelValues(0.0, 0.0, -0.5, -0.3, -2.0, -4.0, 0.0, 0.0)
    monkeypatch.setattr(
        ax8000, "levels_and_curves", lambda request: (levels_and_curves(request)[0], levels)
    )
    values, _ = objects(SOFT)
    assert values == {"0x3144:02": (0.0, "N"), "0x3144:03": (0.0, "N*s/m")}


ROTARY_FRICTION = br.friction.coulomb(kind="rotational", F_C=0.1)


def cogging_request(orders, axis=None, **values):
    component = br.plants.with_terms(br.plants.inertia, cogging={"motor": orders})
    plant = component(kind="rotational", M=1e-3, motor_turn=4.0, **values)
    return Request(ROTARY_FRICTION, "axis_x", 1e-3, plant=plant, axis=axis)


@pytest.mark.parametrize(
    ("axis", "unit", "size"), [(None, "N*m", 1.0), (br.read_axis(TURNING), "%", 0.005)]
)
def test_amplitude_and_phase_are_those_of_cosine_and_sine(axis, unit, size):
    request = cogging_request(
        [2, 3], axis, motor_2_cos=0.0, motor_2_sin=-0.5, motor_3_cos=3.0, motor_3_sin=4.0
    )
    product = cogging.write(request)
    head, *rows = rows_of(product)
    assert head == ["order", f"amplitude [{unit}]", "phase [deg]", "turn of"]
    assert [
        (int(order), size * float(amplitude), float(phase), turner)
        for order, amplitude, phase, turner in rows
    ] == [
        (3, pytest.approx(5.0), pytest.approx(np.degrees(np.arctan(4.0 / 3.0)), abs=1e-3), "motor"),
        (2, pytest.approx(0.5), pytest.approx(270.0), "motor"),
    ]
    x = np.array([0.0, 1.0, 2.5])  # of a turn of 4 rad
    expected = (
        3.0 * np.cos(1.5 * np.pi * x) + 4.0 * np.sin(1.5 * np.pi * x) - 0.5 * np.sin(np.pi * x)
    )
    np.testing.assert_allclose(cogging.reads(product.files, request)(x, 1e-3), expected, atol=1e-4)


def test_omitted_harmonics_are_reported_with_their_total_amplitude():
    orders = list(range(1, 12))
    request = cogging_request(
        orders,
        **{f"motor_{order}_{part}": 0.1 * order for order in orders for part in ("cos", "sin")},
    )
    product = cogging.write(request)
    assert [int(order) for order, *_ in rows_of(product)[1:]] == [11, 10, 9, 8, 7, 6, 5, 4, 3]
    assert (
        f"the file has at most 9 harmonics: bristle omitted the orders 2, 1, in total {0.3 * 2.0**0.5:.2g} N*m"
        in product.notes
    )
    assert not any(
        "at most" in note
        for note in cogging.write(cogging_request([1, 2], motor_1_cos=1.0, motor_2_cos=1.0)).notes
    )


@pytest.mark.parametrize("plant", [None, br.plants.inertia(kind="rotational", M=1.0)])
def test_missing_cogging_is_refused_and_not_read_back(plant):
    request = Request(ROTARY_FRICTION, "axis_x", 1e-3, plant=plant)
    assert plant is not None or cogging.reads({}, request) is None
    with pytest.raises(br.core.InputError, match=r"cogging: was not identified"):
        cogging.write(request)


DRY = br.friction.coulomb(F_C=8.0)
LOOP = {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm", "T_n": "20 ms"}
ROTARY = TURNING | {"controller": LOOP | {"k_v": "0.4 N*m*s/rad"}}


def sinumerik_request(loop, model=DRY):
    axis = br.read_axis(LINEAR | ({"controller": loop} if loop else {}))
    return Request(model, "axis_x", 1e-3, speed=0.2, axis=axis, plant=br.plants.inertia(M=20.0))


def data_of(product):
    return {
        name.removeprefix("$MA_"): (number, float(value), *unit)
        for number, name, value, *unit in rows_of(product, "axis_x.txt", None)
    }


@pytest.mark.parametrize(
    ("model", "axis", "pulse", "unit"),
    [
        (DRY, LINEAR | {"controller": LOOP}, 16.0 / 4000.0 * 1e3 * 60.0, "mm/min"),
        (
            br.friction.coulomb(kind="rotational", F_C=0.2),
            ROTARY,
            0.4 / 0.4 * 60.0 / (2.0 * np.pi),
            "rev/min",
        ),
    ],
)
def test_the_pulse_is_the_change_of_friction_divided_by_the_gain(model, axis, pulse, unit):
    product = product_of("sinumerik", model, axis)
    assert data_of(product) == {
        "FRICT_COMP_MODE": ("MD32490", 1.0),
        "FRICT_COMP_ENABLE": ("MD32500", 1.0),
        "FRICT_COMP_ADAPT_ENABLE": ("MD32510", 0.0),
        "FRICT_COMP_CONST_MAX": ("MD32520", pytest.approx(pulse, rel=1e-5), unit),
        "FRICT_COMP_TIME": ("MD32540", pytest.approx(0.02), "s"),
    }
    for words in ("START VALUES: tune them with the circularity test", "6FC5397-1BP40-3BA1"):
        assert words in product.files["axis_x.txt"]
    assert any("start values" in note for note in product.notes)


def test_a_pulse_with_the_time_of_the_integral_is_a_step_of_effort_at_each_reversal():
    request = sinumerik_request(LOOP)
    product = sinumerik.write(request)
    x = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0])
    assert sinumerik.reads(product.files, request)(x, 1e-3) == pytest.approx(
        [0.0, 0.0, 0.0, -16.0, -16.0, -16.0, 0.0, 0.0], abs=1e-4
    )
    longer = {"axis_x.txt": product.files["axis_x.txt"].replace("0.02 ", "0.04 ")}
    assert longer != product.files
    # What fades of it, k_v over T_n integrates: after one time constant 16 N times (1 / e + 2 (1 - 1 / e)).
    late = sinumerik.reads(longer, request)(
        np.concatenate([[0.0, 1.0], np.arange(0.0, -0.5, -0.005)]), 1e-3
    )[2 + 40]
    assert late == pytest.approx(-16.0 * (2.0 - np.exp(-1.0)), rel=1e-3)


def test_without_a_loop_or_a_time_constant_no_drive_is_read_back():
    assert (
        sinumerik.reads(sinumerik.write(sinumerik_request(LOOP)).files, sinumerik_request({}))
        is None
    )
    without = sinumerik_request({key: value for key, value in LOOP.items() if key != "T_n"})
    product = sinumerik.write(without)
    assert "FRICT_COMP_TIME" not in data_of(product)
    assert "MD32540" in product.files["axis_x.txt"]
    assert sinumerik.reads(product.files, without) is None


@pytest.mark.parametrize(
    "axis", [None, LINEAR, LINEAR | {"controller": LOOP | {"k_v": "0 N*s/mm"}}]
)
def test_the_gain_of_the_velocity_loop_is_required(axis):
    with pytest.raises(br.core.InputError, match="needs the gain of the velocity loop"):
        product_of("sinumerik", DRY, axis)


# An arm of a millimetre: 0.2 N m are 200 N, and a per mille of that is 0.2 N.
MILLIMETRE = br.read_axis(
    SCREW | {"effort": {"rated": "0.2 N*m"}, "transmission": {"lead": f"{2.0 * np.pi!r} mm"}}
)


def tf5200_request(model, axis=MILLIMETRE, **changes):
    return Request(model, "axis_x", 1e-3, axis=axis, **{"speed": 0.2, "points": 5} | changes)


def test_the_list_is_in_micrometres_a_second_and_per_mille_of_rated():
    rows = listed(tf5200.write(tf5200_request(br.friction.coulomb_viscous(F_C=8.0, F_v=20.0))))
    assert rows == {
        "mode": 3,
        "table_entries": 2,
        "position_delay": 0,
        "reversal_lookahead": 1,
        "scaling_factor": 1000,
        "delay_cycles": 0,
        "table[0].in": 0,
        "table[0].out": 40,
        "table[1].in": 200_000,
        "table[1].out": 60,
    }


def test_the_list_of_a_rotary_axis_is_in_thousandths_of_a_degree_a_second():
    viscous = br.friction.coulomb_viscous(kind="rotational", F_C=0.1, F_v=0.02)
    rows = listed(tf5200.write(tf5200_request(viscous, br.read_axis(TURNING), speed=np.pi)))
    assert [rows[f"table[1].{key}"] for key in ("in", "out")] == [
        180_000,
        round((0.1 + 0.02 * np.pi) / 0.0005),
    ]


@pytest.mark.parametrize(
    ("microns", "written", "is_noted"), [(0.4, 4, False), (1.0, 10, False), (1.2, 10, True)]
)
def test_a_delay_over_a_distance_is_limited_to_ten_tenths_of_a_micrometre(
    monkeypatch, microns, written, is_noted
):
    requested = []
    monkeypatch.setattr(
        tf5200, "reversal_distance", lambda model, speed: requested.append(speed) or microns * 1e-6
    )
    product = tf5200.write(tf5200_request(br.friction.coulomb(F_C=8.0)))
    assert listed(product)["position_delay"] == written
    reason = (
        "position_delay has its largest value, 10, but the friction needs 12 x 0.1 um to reverse"
    )
    assert (reason in product.notes) is is_noted
    assert requested == [pytest.approx(0.2)]


@pytest.mark.parametrize(("ahead", "written"), [(1, 1), (4, 4), (5, 4)])
def test_the_current_leads_a_reversal_by_four_cycles_at_most(monkeypatch, ahead, written):
    monkeypatch.setattr(tf5200, "lead_of", lambda request: ahead)
    product = tf5200.write(tf5200_request(br.friction.coulomb(F_C=8.0)))
    assert listed(product)["reversal_lookahead"] == written
    assert f"leads a reversal; this axis needs {ahead}, the largest value is 4." in str(
        product.files["axis_x.txt"]
    )


@pytest.mark.parametrize(("count", "is_refused"), [(20, False), (21, True)])
def test_the_list_has_at_most_twenty_entries(monkeypatch, count, is_refused):
    entries = np.column_stack([0.01 * np.arange(count), 1.0 + np.arange(count) % 2])
    monkeypatch.setattr(tf5200, "mean_side", lambda *passed: Side(entries, entries))
    request = tf5200_request(br.friction.coulomb(F_C=8.0))
    if is_refused:
        with pytest.raises(
            br.core.InputError,
            match="points: exceeds the length of the list of the CNC; found 21, allowed 20 entries or fewer",
        ):
            tf5200.write(request)
    else:
        assert listed(tf5200.write(request))["table_entries"] == count


@pytest.mark.parametrize(
    ("entries", "kept"),
    [
        # Of several entries at a rounded speed the first, and of equal ones both ends.
        ([[0.0, 5.0], [4e-7, 7.0], [1e-6, 9.0], [2e-6, 9.0]], [0, 2, 3]),
        (
            [[1e-3 * k, force] for k, force in enumerate([10.0, 10.0, 10.0, 20.0, 20.0, 30.0])],
            [0, 2, 3, 4, 5],
        ),
    ],
)
def test_an_entry_that_says_nothing_is_omitted(entries, kept):
    entries = np.array(entries)
    assert (
        merged(
            Side(entries, entries), DriveUnit("0.1 % of rated", 1.0), "translational"
        ).entries.tolist()
        == entries[kept].tolist()
    )


def test_the_constant_force_does_not_count_as_an_error_of_a_direction():
    lifting = br.friction.find("coulomb")(F_C=8.0, offset=4.0)
    product = tf5200.write(tf5200_request(lifting))
    assert [listed(product)[f"table[{i}].out"] for i in (0, 1)] == [40, 40]
    assert any("does not contain the constant force of 4 N" in note for note in product.notes)


GIVEN = {"table_entries": 2, "position_delay": 0, "reversal_lookahead": 0, "scaling_factor": 1000}
# 2 N, and 6 N at 100 mm/s
GIVEN |= {"table[0].in": 0, "table[0].out": 10, "table[1].in": 100_000, "table[1].out": 30}


@pytest.mark.parametrize(
    ("steps", "dt", "changes", "forces"),
    [
        # Between entries: 25 um in a millisecond are 25 mm/s, 2 N and a quarter of 4 N more; beyond the last entry it stays.
        ([25.0, 100.0, 200.0, -25.0], 1e-3, {}, [3.0, 6.0, 6.0, -3.0]),
        ([25.0, 100.0], 1e-3, {"scaling_factor": 500}, [1.5, 3.0]),
        # It stays through a stop without a reversal.
        ([0.0, 25.0, 0.0, 25.0, 0.0, -25.0, 0.0], 1e-3, {}, [0.0, 3.0, 2.0, 3.0, 2.0, -3.0, -2.0]),
        # Of 2 N with two cycles before a reversal: a third and two thirds of it are left before the turn.
        (
            [1e-3] * 4 + [-1e-3] * 2,
            1e-3,
            {"reversal_lookahead": 2},
            [2.0, 2.0, 4.0 / 3.0, 2.0 / 3.0, -2.0, -2.0],
        ),
        # 0.4 um behind the turn, in steps of 0.1 um; a reversal before that begins anew.
        (
            [-0.1] * 2 + [0.1] * 6,
            10.0,
            {"position_delay": 4},
            [-0.5, -1.0, 0.5, 1.0, 1.5, 2.0, 2.0, 2.0],
        ),
        ([-0.1, 0.1, 0.1], 10.0, {"position_delay": 4}, [-0.5, 0.5, 1.0]),
    ],
)
def test_the_control_adds_the_force_of_the_list_along_a_motion(steps, dt, changes, forces):
    text = "\n".join(f"frict_comp.{key} {value}" for key, value in (GIVEN | changes).items())
    drive = tf5200.reads(
        {"axis_x.txt": f"# a remark\n{text}"}, tf5200_request(br.friction.coulomb(F_C=8.0))
    )
    assert drive(np.cumsum([0.0, *steps]) * 1e-6, dt)[1:] == pytest.approx(forces, abs=1e-3)


# --- the effect of an export on the axis -----------------------------------------------------------------------------


DT = 1e-3
MASS = 25.0
SERVO = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        "time": {"column": "t", "unit": "s"},
        "position": {"column": "q", "unit": "mm"},
        "effort": {"column": "u", "unit": "N"},
    },
    "effort": {"rated": "2 N*m", "limit": "2 kN"},
    "transmission": {"lead": "10 mm", "gear_ratio": 2.0},
    "encoder": {"resolution": "0.1 um"},
    "controller": {"model": "cascade", "k_p": "60 1/s", "k_v": "5000 N*s/m", "k_i": "200 kN/m"},
}
AXIS = axis_from(SERVO)
WITHOUT_LOOP = axis_from({key: value for key, value in SERVO.items() if key != "controller"})
LUGRE = br.friction.lugre(F_C=40.0, F_S=50.0, v_S=5e-3, sigma_0=5e6, sigma_1=2e3, sigma_2=200.0)
FALLING = br.friction.stribeck(F_C=40.0, F_S=50.0, v_S=5e-3, F_v=200.0)


def export_request(model=LUGRE, axis=AXIS, **options):
    return Request(
        model,
        "axis_x",
        DT,
        Source({"command": "bristle export"}),
        axis=axis,
        speed=0.1,
        plant=br.plants.inertia(M=MASS),
        **options,
    )


def text_of(product, end):
    return next(str(text) for name, text in product.files.items() if name.endswith(end))


@pytest.mark.parametrize("points", [3, 20])
def test_no_table_feeds_the_peak_of_a_break_away(points):
    """A break-away force that no log determined, ten times the sliding friction, does not reach the drive."""
    peak = LUGRE.with_values(F_S=400.0, v_S=1e-5)
    request = export_request(peak, axis=None, points=points, rest="held")
    drive = TARGETS["table"].reads(TARGETS["table"].write(request).files, request)
    still, moving = np.zeros(3), 1e-9 * np.arange(3)
    assert np.max(np.abs(drive(np.concatenate([moving, moving[-1] + still]), DT))) < 1.05 * 40.0
    assert any(
        "leaves out friction that falls with speed" in note
        for note in TARGETS["table"].write(replace(request, points=20)).notes
    )


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("name", "points"), [("table", 20), ("table", 3), ("tf5200", 20)])
def test_the_force_read_back_is_the_friction_along_the_axis(name, points, turned):
    """The file alone, in its own units and signs, gives the steady friction of the model to the digits it has."""
    columns = SERVO["columns"] | {"position": {"column": "q", "unit": "mm", "sign": -1}}
    axis = axis_from(SERVO | {"columns": columns}) if turned else AXIS
    request = export_request(
        FALLING, axis=axis, points=points, rest="held" if name == "table" else ""
    )
    target = TARGETS[name]
    drive = target.reads(target.write(request).files, request)
    t = DT * np.arange(400)
    for speed in (0.09, -0.09, 0.03, -0.03):
        force = drive(speed * t, DT)[-1]
        exact = steady_force(FALLING, speed)
        allowed = 0.01 * abs(exact) if points == 20 else 0.25 * abs(exact)
        allowed += 0.5e-3 * axis.rated if name == "tf5200" else 0.0  # integers in 0.1 %
        assert force == pytest.approx(exact, abs=allowed)
        assert abs(force) <= abs(exact) * (1.001 if points == 3 else 1.02)


def test_c_and_structured_text_command_in_the_units_of_the_drive(tmp_path):
    header = text_of(files_for("c", export_request()), ".h")
    assert "double axis_x_command(axis_x *axis, double position, double dt);" in header
    assert re.search(r"#define AXIS_X_PERCENT_OF_RATED\s", header)
    block = text_of(files_for("st", export_request()), "axis_x.st")
    arm = 0.010 / (2.0 * math.pi) / 2.0
    result = re.search(r"command := feed / ([\d.]+);", block)
    assert float(result[1]) == pytest.approx(1.0 / arm, rel=1e-12)
    assert re.search(r"command .*N\*m at the motor", block)
    without = text_of(files_for("c", export_request(axis=None)), ".h")
    assert "axis_x_command" not in without


@pytest.mark.slow
def test_the_command_line_prints_and_writes_the_effect(tmp_path, capsys):
    from bristle.files.model import write_model

    folder = tmp_path / "found"
    folder.mkdir()
    write_model(folder / "model.toml", br.plants.inertia(M=MASS), LUGRE)
    axis = tmp_path / "axis.toml"
    axis.write_text(
        'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\n'
        'position = { column = "q", unit = "mm" }\neffort = { column = "u", unit = "N" }\n[effort]\nrated = "100 N"\n'
        '[controller]\nmodel = "cascade"\nk_p = "60 1/s"\nk_v = "5000 N*s/m"\nk_i = "200 kN/m"\n'
    )
    arguments = [
        "export",
        str(folder / "model.toml"),
        "--to",
        "table",
        "--axis",
        str(axis),
        "--speed",
        "0.1 m/s",
    ]
    assert main([*arguments, "--out", str(tmp_path / "out"), "--json"]) == 0
    message = json.loads(capsys.readouterr().out)
    assert message["effect"]["quantity"] == "following_error"
    assert [each["motion"] for each in message["effect"]["along"]][:4] == ["moves"] * 4
    assert (
        json.loads((tmp_path / "out" / "summary.json").read_text())["effect"] == message["effect"]
    )


def test_the_turning_distance_comes_from_the_model_the_axis_or_an_assumption():
    known = axis_from(SERVO | {"plant": {"presliding": "30 um"}})
    assert turning_distance(LUGRE, known, 0.1) == (
        pytest.approx(reversal_distance(LUGRE, 0.1)),
        0.0,
    )
    assert turning_distance(FALLING, known, 0.1) == (pytest.approx(3e-5), 0.0)
    assert (
        turning_distance(FALLING, AXIS, 0.1) == turning_distance(FALLING, None, 0.1) == (1e-5, 1e-5)
    )
    assert turning_distance(br.friction.coulomb(kind="rotational", F_C=1.0), None, 0.1) == (
        2e-4,
        2e-4,
    )


def test_sliding_friction_is_the_mean_of_both_directions():
    heavy = br.friction.with_slots(br.friction.coulomb, ["asymmetry"])(
        F_C_pos=9.0, F_C_neg=5.0, offset=40.0
    )
    assert sliding_level(heavy, 0.1) == pytest.approx(7.0)


def test_the_reference_loop_has_no_friction_feedforward_and_the_limits_of_the_axis():
    loop = loop_for(export_request())
    assert (loop.run.effort_limit, loop.run.sample_time, loop.plant.values["M"]) == (
        pytest.approx(2000.0),
        DT,
        MASS,
    )
    assert (
        loop.feedforward.friction
        is loop_for(export_request(axis=None))
        is loop_for(replace(export_request(), plant=None))
        is None
    )
    passed = loop_for(replace(export_request(), loop=loop))
    assert passed.plant is loop.plant
