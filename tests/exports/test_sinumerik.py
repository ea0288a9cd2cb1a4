"""The pulse of a SINUMERIK through the loop of velocity: friction that turns at each reversal, and stays."""

import numpy as np
import pytest

import bristle as br
from bristle.exports.sinumerik import reads, write
from bristle.exports.targets import Request

COULOMB = br.friction.coulomb(F_C=8.0)
AXIS = {
    "schema": 1,
    "kind": "translational",
    "columns": {name: {"column": name[0], "unit": unit} for name, unit in (("time", "s"), ("position", "mm"), ("effort", "N"))},
}
LOOP = {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm", "T_n": "20 ms"}


def request_for(loop, model=COULOMB):
    axis = br.read_axis(AXIS | ({"controller": loop} if loop else {}))
    return Request(model, "axis_x", 1e-3, speed=0.2, axis=axis, plant=br.plants.inertia(M=20.0))


def data_of(product):
    lines = [line.split() for line in product.files["axis_x.txt"].splitlines() if not line.startswith(";")]
    return {name: value for _, name, value, *_ in lines}


def test_the_pulse_is_the_change_of_friction_divided_by_the_gain():
    data = data_of(write(request_for(LOOP)))
    assert float(data["$MA_FRICT_COMP_CONST_MAX"]) == pytest.approx(16.0 / 4000.0 * 1e3 * 60.0, rel=1e-5)  # [mm/min]
    assert float(data["$MA_FRICT_COMP_TIME"]) == pytest.approx(0.02)


def test_a_pulse_with_the_time_of_the_integral_is_a_step_of_effort_at_each_reversal():
    request = request_for(LOOP)
    product = write(request)
    drive = reads(product.files, request)
    x = np.array([0.0, 1.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0])
    assert drive(x, 1e-3) == pytest.approx([0.0, 0.0, 0.0, -16.0, -16.0, -16.0, 0.0, 0.0], abs=1e-4)
    longer = {"axis_x.txt": product.files["axis_x.txt"].replace("0.02 ", "0.04 ")}
    assert longer != product.files
    # What fades of it, k_v over T_n integrates: after one time constant 16 N times (1 / e + 2 (1 - 1 / e)).
    late = reads(longer, request)(np.concatenate([[0.0, 1.0], np.arange(0.0, -0.5, -0.005)]), 1e-3)[2 + 40]
    assert late == pytest.approx(-16.0 * (2.0 - np.exp(-1.0)), rel=1e-3)


def test_without_a_loop_or_a_time_constant_no_drive_is_read_back():
    request = request_for(LOOP)
    files = write(request).files
    assert reads(files, request_for({})) is None
    without = request_for({key: value for key, value in LOOP.items() if key != "T_n"})
    product = write(without)
    assert "$MA_FRICT_COMP_TIME" not in data_of(product)
    assert reads(product.files, without) is None


@pytest.mark.parametrize("loop", [{}, {"model": "cascade", "k_p": "30 1/s", "k_v": "0 N*s/mm"}])
def test_the_gain_of_the_velocity_loop_is_required(loop):
    with pytest.raises(br.core.InputError, match="needs the gain of the velocity loop"):
        write(request_for(loop))
