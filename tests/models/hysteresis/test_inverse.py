"""Inverses: the displacement from the force, over many reversals and back."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.models.hysteresis.paths import along, of, walk

from bristle import hysteresis, response
from bristle.models.hysteresis.everett import KERNELS

THIRTEEN = [0.0, 3.0, -2.0, 2.4, -1.0, 1.1, 0.3, 0.9, -0.5, 2.0, -3.5, 1.0, -3.0, 0.5, 3.9]
STOPS = hysteresis.prandtl_ishlinskii(
    thresholds=[0.2, 0.5, 0.5, 1.0, 2.5], weights=[2.0, 1.0, 0.5, 0.7, 0.3], spring=0.05
)


def test_stops_and_their_inverse_over_thirteen_reversals():
    path = along(THIRTEEN, 30)
    inverse = hysteresis.inverse_of(STOPS)
    assert inverse.component.input == "force"
    assert np.max(np.abs(response(inverse, response(STOPS, path)) - path)) <= 1e-12
    force = 1.5 * path
    assert np.max(np.abs(response(STOPS, response(inverse, force)) - force)) <= 1e-12


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.01, 5.0), st.floats(-0.4, 3.0)), min_size=1, max_size=6),
    st.lists(st.floats(-8.0, 8.0), min_size=1, max_size=20),
)
def test_any_stops_whose_virgin_curve_rises_have_an_inverse(elements, path):
    thresholds, weights = zip(*elements, strict=True)
    stops = hysteresis.prandtl_ishlinskii(
        thresholds=list(thresholds), weights=list(weights), spring=3.0
    )
    force = response(stops, path)
    assert np.max(np.abs(response(hysteresis.inverse_of(stops), force) - path)) <= 1e-12


@pytest.mark.parametrize("kernel", KERNELS)
def test_preisach_and_its_inverse_over_thirteen_reversals(kernel):
    path, operator = along(THIRTEEN, 30), of(kernel)
    inverse = hysteresis.inverse_of(operator)
    assert np.max(np.abs(response(inverse, response(operator, path)) - path)) <= 1e-13 * 50
    path = walk(3, 3000)
    assert np.max(np.abs(response(inverse, response(operator, path)) - path)) <= 1e-12


@pytest.mark.parametrize("exponent", [1.0, 1.3, 3.0])
def test_every_exponent_has_its_inverse(exponent):
    path, operator = along(THIRTEEN, 30), of("dahl_masing", exponent=exponent)
    assert (
        np.max(np.abs(response(hysteresis.inverse_of(operator), response(operator, path)) - path))
        <= 1e-12
    )


def test_an_inverse_has_the_units_of_an_inverse():
    stops = hysteresis.prandtl_ishlinskii(
        thresholds=[1e-3], weights=[100.0], spring=1.0, kind="rotational"
    )
    assert "rad/(N*m)" in repr(hysteresis.inverse_of(stops))
