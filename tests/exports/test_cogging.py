"""Harmonics of cogging: largest first, amplitude and phase of each, and what a drive makes of them."""

import numpy as np
import pytest
from tests.exports.drives import TURNING, rows_of

import bristle as br
from bristle.exports.cogging import reads, write
from bristle.exports.targets import Request
from bristle.plants.terms import with_terms

FRICTION = br.friction.coulomb(kind="rotational", F_C=0.1)


def request_for(orders, axis=None, **values):
    component = with_terms(br.plants.inertia, cogging={"motor": orders})
    plant = component(kind="rotational", M=1e-3, motor_turn=4.0, **values)
    return Request(FRICTION, "axis_x", 1e-3, plant=plant, axis=axis)


@pytest.mark.parametrize(("axis", "unit", "size"), [(None, "N*m", 1.0), (br.read_axis(TURNING), "%", 0.005)])
def test_amplitude_and_phase_are_those_of_cosine_and_sine(axis, unit, size):
    request = request_for([2, 3], axis, motor_2_cos=0.0, motor_2_sin=-0.5, motor_3_cos=3.0, motor_3_sin=4.0)
    product = write(request)
    head, *rows = rows_of(product)
    assert head == ["order", f"amplitude [{unit}]", "phase [deg]", "turn of"]
    assert [(int(order), size * float(amplitude), float(phase), turner) for order, amplitude, phase, turner in rows] == [
        (3, pytest.approx(5.0), pytest.approx(np.degrees(np.arctan(4.0 / 3.0)), abs=1e-3), "motor"),
        (2, pytest.approx(0.5), pytest.approx(270.0), "motor"),
    ]
    x = np.array([0.0, 1.0, 2.5])  # of a turn of 4 rad
    expected = 3.0 * np.cos(1.5 * np.pi * x) + 4.0 * np.sin(1.5 * np.pi * x) - 0.5 * np.sin(np.pi * x)
    np.testing.assert_allclose(reads(product.files, request)(x, 1e-3), expected, atol=1e-4)


def test_omitted_harmonics_are_reported_with_their_total_amplitude():
    orders = list(range(1, 12))
    request = request_for(orders, **{f"motor_{order}_{part}": 0.1 * order for order in orders for part in ("cos", "sin")})
    product = write(request)
    assert [int(order) for order, *_ in rows_of(product)[1:]] == [11, 10, 9, 8, 7, 6, 5, 4, 3]
    assert f"the file has at most 9 harmonics: bristle omitted the orders 2, 1, in total {0.3 * 2.0**0.5:.2g} N*m" in product.notes
    assert not any("at most" in note for note in write(request_for([1, 2], motor_1_cos=1.0, motor_2_cos=1.0)).notes)


@pytest.mark.parametrize("plant", [None, br.plants.inertia(kind="rotational", M=1.0)])
def test_missing_cogging_is_refused_and_not_read_back(plant):
    request = Request(FRICTION, "axis_x", 1e-3, plant=plant)
    assert plant is not None or reads({}, request) is None
    with pytest.raises(br.core.InputError, match=r"cogging: was not identified"):
        write(request)
