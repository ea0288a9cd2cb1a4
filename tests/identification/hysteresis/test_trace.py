"""The memory of a path, found without a measure: the regressors that follow from it are the operators themselves."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.golden.simulated import to_and_fro

from bristle import hysteresis, response
from bristle.identification.hysteresis.linear import _Cells, design, trace_of

turns = st.lists(st.integers(-300, 300).map(lambda n: n / 100.0), min_size=1, max_size=12)
R, W = np.array([0.1, 0.4, 1.0, 2.5]), np.array([1.0, -0.3, 0.7, 0.2])


def stops(alpha, beta):
    return np.minimum(0.5 * (alpha - beta)[:, None], R)


@settings(max_examples=60, deadline=None)
@given(path=turns, history=st.lists(st.floats(-3.0, 3.0), max_size=3))
def test_the_regressor_of_stops_is_their_response(path, history):
    u = np.interp(
        np.linspace(0.0, len(path), 40 * len(path)), np.arange(len(path) + 1), [0.0, *path]
    )
    operator = hysteresis.prandtl_ishlinskii(thresholds=R, weights=W)
    expected = response(operator, u, history=history)
    assert np.max(np.abs(design(trace_of(u, history), stops) @ W - expected)) < 1e-12


def test_the_regressor_of_cells_is_the_response_of_the_grid():
    rng = np.random.default_rng(1)
    cells = _Cells(-3.0, 3.0, 12)
    weights = rng.standard_normal(cells.i.size)
    operator = hysteresis.preisach_grid(low=-3.0, high=3.0, E=cells.everett(weights), offset=0.4)
    u = to_and_fro(rng)
    for history in ([], [30.0], [-30.0, 1.0]):
        text = design(trace_of(u, history), cells) @ weights + 0.4
        assert np.max(np.abs(text - response(operator, u, history=history))) < 1e-11


def test_some_rows_are_those_of_the_whole():
    u = to_and_fro(np.random.default_rng(2))
    trace = trace_of(u, [3.0])
    sample = np.array([0, 7, 400, 1599])
    assert np.array_equal(design(trace, stops, sample), design(trace, stops)[sample])


@pytest.mark.parametrize("u", [[], [0.0, 0.0], [1.0]])
def test_a_path_that_hardly_moves_has_a_trace(u):
    assert design(trace_of(np.array(u)), stops).shape == (len(u), 4)
