"""The pulse of a SINUMERIK through the loop of velocity: friction that turns at each reversal, and stays."""

import numpy as np
import pytest
from tests.exports.drives import LINEAR, TURNING, product_of, rows_of

import bristle as br
from bristle.exports.sinumerik import reads, write
from bristle.exports.targets import Request

COULOMB = br.friction.coulomb(F_C=8.0)
LOOP = {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm", "T_n": "20 ms"}
ROTARY = TURNING | {"controller": LOOP | {"k_v": "0.4 N*m*s/rad"}}


def request_for(loop, model=COULOMB):
    axis = br.read_axis(LINEAR | ({"controller": loop} if loop else {}))
    return Request(model, "axis_x", 1e-3, speed=0.2, axis=axis, plant=br.plants.inertia(M=20.0))


def data_of(product):
    return {name.removeprefix("$MA_"): (number, float(value), *unit) for number, name, value, *unit in rows_of(product, "axis_x.txt", None)}


@pytest.mark.parametrize(
    ("model", "axis", "pulse", "unit"),
    [
        (COULOMB, LINEAR | {"controller": LOOP}, 16.0 / 4000.0 * 1e3 * 60.0, "mm/min"),
        (br.friction.coulomb(kind="rotational", F_C=0.2), ROTARY, 0.4 / 0.4 * 60.0 / (2.0 * np.pi), "rev/min"),
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
    request = request_for(LOOP)
    product = write(request)
    x = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0])
    assert reads(product.files, request)(x, 1e-3) == pytest.approx([0.0, 0.0, 0.0, -16.0, -16.0, -16.0, 0.0, 0.0], abs=1e-4)
    longer = {"axis_x.txt": product.files["axis_x.txt"].replace("0.02 ", "0.04 ")}
    assert longer != product.files
    # What fades of it, k_v over T_n integrates: after one time constant 16 N times (1 / e + 2 (1 - 1 / e)).
    late = reads(longer, request)(np.concatenate([[0.0, 1.0], np.arange(0.0, -0.5, -0.005)]), 1e-3)[2 + 40]
    assert late == pytest.approx(-16.0 * (2.0 - np.exp(-1.0)), rel=1e-3)


def test_without_a_loop_or_a_time_constant_no_drive_is_read_back():
    assert reads(write(request_for(LOOP)).files, request_for({})) is None
    without = request_for({key: value for key, value in LOOP.items() if key != "T_n"})
    product = write(without)
    assert "FRICT_COMP_TIME" not in data_of(product)
    assert "MD32540" in product.files["axis_x.txt"]
    assert reads(product.files, without) is None


@pytest.mark.parametrize("axis", [None, LINEAR, LINEAR | {"controller": LOOP | {"k_v": "0 N*s/mm"}}])
def test_the_gain_of_the_velocity_loop_is_required(axis):
    with pytest.raises(br.core.InputError, match="needs the gain of the velocity loop"):
        product_of("sinumerik", COULOMB, axis)
