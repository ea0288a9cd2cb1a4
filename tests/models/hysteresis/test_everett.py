"""Everett functions: their derivatives, their inverse, and what a table of one is worth."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.models.hysteresis.paths import along, of, walk

from bristle import hysteresis, response
from bristle.core.dispatch import everett, everett_slope, virgin_curve, virgin_slope
from bristle.models.hysteresis.everett import KERNELS, loading_curve, loading_inverse

inputs = st.floats(-20.0, 20.0)


def measure(operator):
    return operator.component.measure(operator.parameters)


MEASURES = {kernel: measure(of(kernel)) for kernel in KERNELS} | {
    "exponent 1.5": measure(of("dahl_masing", exponent=1.5)),
    "exponent 0.5": measure(of("dahl_masing", exponent=0.5)),
    "table": measure(
        hysteresis.tabulated(
            lambda a, b: (a - b) * (1.0 + 0.02 * (a + b)), 25.0, rows=11, columns=11
        )
    ),
}
every_measure = pytest.mark.parametrize("q", MEASURES.values(), ids=MEASURES)


@every_measure
@settings(max_examples=20, deadline=None)
@given(one=inputs, other=inputs)
def test_the_measure_is_zero_without_area_and_grows_with_the_triangle(q, one, other):
    alpha, beta = max(one, other), min(one, other)
    assert everett(alpha, alpha, q) == 0.0
    assert everett(alpha, beta, q) <= everett(alpha + 0.1, beta, q) + 1e-15
    assert everett(alpha, beta, q) <= everett(alpha, beta - 0.1, q) + 1e-15


@every_measure
def test_slopes_are_derivatives(q):
    generator = np.random.default_rng(3)
    h = 1e-6
    for _ in range(100):
        beta, alpha = np.sort(generator.uniform(-10.0, 10.0, 2)).tolist()
        if alpha - beta < 1e-3 or abs(alpha + beta) < 1e-3 or abs(alpha - beta - 4.0) < 1e-3:
            continue
        by_alpha = (everett(alpha + h, beta, q) - everett(alpha - h, beta, q)) / (2.0 * h)
        by_beta = (everett(alpha, beta - h, q) - everett(alpha, beta + h, q)) / (2.0 * h)
        assert abs(everett_slope(alpha, beta, 1.0, q) - by_alpha) <= 1e-8
        assert abs(everett_slope(alpha, beta, -1.0, q) - by_beta) <= 1e-8
        first = (virgin_curve(alpha + h, q) - virgin_curve(alpha - h, q)) / (2.0 * h)
        assert abs(virgin_slope(alpha, q) - first) <= 1e-8


@every_measure
@settings(max_examples=20, deadline=None)
@given(z=st.floats(0.0, 20.0))
def test_the_virgin_curve_and_the_branch_from_its_mirror_meet(q, z):
    # Only so can a branch merge with the virgin curve on the other side.
    assert abs(virgin_curve(z, q) - virgin_curve(-z, q) - 2.0 * everett(z, -z, q)) <= 1e-14 * (
        1.0 + z
    )


@pytest.mark.parametrize("exponent", [0.5, 0.9, 1.0, 1.2, 2.0, 3.0])
@pytest.mark.parametrize("shape", [0, 1, 3])
def test_the_inverse_curve_undoes_the_loading_curve(shape, exponent):
    for x in np.geomspace(1e-12, 1.9, 60).tolist():
        assert abs(
            loading_inverse(loading_curve(x, shape, exponent), shape, exponent) - x
        ) <= 1e-14 * (1.0 + x)
    assert np.isnan(loading_inverse(1.0, shape, exponent))


# --- tables -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kernel", "error"), [("dahl_masing", 3e-4), ("reformed_dahl_exact", 6e-4)]
)
def test_a_table_of_a_hundred_nodes_is_accurate_to_second_order(kernel, error):
    exact = of(kernel)
    q, path = measure(exact), walk(4, 2000)
    errors = []
    for nodes in (51, 101, 201):
        table = hysteresis.tabulated(
            lambda a, b, q=q: everett(a, b, q), 4.0, rows=nodes, columns=nodes
        )
        errors.append(np.max(np.abs(response(table, path) - response(exact, path))))
    assert errors[1] <= error
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]


def lopsided(q, alpha, beta):
    """A measure that is stronger at large inputs than at small ones."""
    return everett(alpha, beta, q) * (1.0 + 0.1 * (alpha + beta) / 6.0)


def test_a_measure_without_symmetry_is_that_of_its_relays():
    q = MEASURES["reformed_dahl_exact"]
    table = hysteresis.tabulated(lambda a, b: lopsided(q, a, b), 3.0, rows=201, columns=201)
    levels = np.linspace(-3.0, 3.0, 121)
    path = levels[np.random.default_rng(5).integers(0, 121, 100)]
    assert (
        np.max(
            np.abs(response(hysteresis.relays_of(table, 3.0, 120), path) - response(table, path))
        )
        < 1e-4
    )
    assert abs(response(table, [3.0])[0] + response(table, [-3.0])[0]) < 1e-12


@pytest.mark.parametrize(("count", "error"), [(30, 1e-2), (120, 2e-3)])
def test_reversal_curves_reproduce_their_operator(count, error):
    exact = of("reformed_dahl_exact")
    curves = []
    for alpha in np.linspace(-3.0, 3.0, count + 1)[1:].tolist():
        beta = along([alpha, -3.0], 80)
        curves.append((beta, response(exact, beta, history=[-3.0])))
    table = hysteresis.from_reversal_curves(curves[::-1])
    path = walk(6, 1000, 3.0)
    assert np.max(np.abs(response(table, path) - response(exact, path))) < error


def test_turns_below_the_first_curve_follow_it():
    down = np.linspace(0.0, 1.0, 5)
    curves = [(0.5 - 1.5 * down, -2.0 * down), (1.0 - 2.0 * down, -6.0 * down)]
    table = hysteresis.from_reversal_curves(curves, rows=41, columns=41)
    q = measure(table)
    # Half of what the first curve falls by over the same way; the second one falls faster.
    for alpha, beta in ((0.5, -0.25), (0.0, -0.75), (-0.25, -1.0)):
        assert everett(alpha, beta, q) == pytest.approx(0.5, abs=0.01)
    assert everett(1.0, 0.25, q) == pytest.approx(1.125, abs=0.01)


def test_outside_its_table_the_output_stays():
    table = hysteresis.tabulated(lambda a, b: a - b, 1.0, rows=5, columns=5)
    f = response(table, [0.5, 1.0, 3.0, 1.0, 0.5, -7.0, -1.0])
    assert f[1] == f[2] == f[3] == 2.0
    assert f[5] == f[6] == -2.0
    assert f[4] < f[3]
    q = measure(table)
    assert (
        virgin_slope(2.0, q)
        == everett_slope(2.0, 0.0, 1.0, q)
        == everett_slope(0.0, -2.0, -1.0, q)
        == 0.0
    )
