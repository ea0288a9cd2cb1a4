"""Parameters of hysteresis operators: their examples in a loop by hand, and their curves."""

import math

import numpy as np
import pytest

from bristle import response
from bristle.models.hysteresis import (
    everett_table,
    inverse_of,
    inverse_prandtl_ishlinskii,
    play,
    prandtl_ishlinskii,
    preisach_grid,
    relay_grid,
    reversal_table,
    stop,
    tabulated,
)
from bristle.models.hysteresis.everett import (
    DAHL_MASING,
    EXP_MASING,
    REFORMED_DAHL_EXACT,
    TIP_MASING,
    ClosedForm,
    loading_curve,
    loading_slope,
    loop_tip,
    loop_tip_slope,
    reformed_value,
    slope,
    value,
    virgin,
    virgin_slope,
)


@pytest.mark.parametrize(
    ("operator", "inputs", "outputs"),
    [
        # Everything reaches half of its table on the first way to its end, and all of it on the way back.
        (everett_table, [1e-5, -1e-5, 1e-5], [10.0, -10.0, 10.0]),
        (preisach_grid, [1e-5, -1e-5, 1e-5], [6.0, -6.0, 6.0]),
        # Each way from a turn is twice the measure of its triangle: 3, 6, 4, 2, 5, 3 and 5 N.
        (
            preisach_grid,
            [-2e-5, -1e-5 / 3, -2e-5, 1e-5 / 3, -1e-5 / 3, 2e-5, 1e-5 / 3, -1e-5 / 3],
            [-6.0, 0.0, -6.0, 2.0, -2.0, 6.0, 0.0, -4.0],
        ),
        (reversal_table, [1e-5, -1e-5, 1e-5], [8.0, -8.0, 8.0]),
        (relay_grid, [1e-6, -1e-6, 0.1e-6], [5.0, -5.0, 1.0]),
        # Three stops of 6, 6 and 5 N, and a spring.
        (prandtl_ishlinskii, [1e-5, -1e-5], [18.0, -18.0]),
        (play, [1e-5, 0.0], [9e-6, 1e-6]),
        (stop, [1e-5, 0.0], [1e-6, -1e-6]),
        # 1e-7 m/N from the beginning, and 1.5e-7 and 6.7e-7 more from 10 and 13 N on.
        (inverse_prandtl_ishlinskii, [12.0, 14.0], [15e-7, 14e-7 + 6e-7 + 6.7e-7]),
    ],
)
def test_examples_go_through_a_loop_by_hand(operator, inputs, outputs):
    assert response(operator(**operator.example), inputs) == pytest.approx(outputs)


def test_the_inverse_of_the_example_of_stops_has_kinks_at_its_forces():
    inverse = inverse_of(
        prandtl_ishlinskii(thresholds=[1e-6, 2e-6], weights=[6e6, 3e6], spring=1e6)
    )
    assert inverse.values["thresholds"].tolist() == pytest.approx([10.0, 14.0])
    assert inverse.values["weights"].tolist() == pytest.approx([0.25e-6 - 0.1e-6, 1e-6 - 0.25e-6])
    assert inverse.values["compliance"] == pytest.approx(1e-7)


@pytest.mark.parametrize(
    ("shape", "exponent", "at_one"),
    [
        (DAHL_MASING, 2.0, 0.5),
        (DAHL_MASING, 1.0, 1.0 - math.exp(-1.0)),
        (DAHL_MASING, 3.0, 1.0 - 1.0 / math.sqrt(3.0)),
        (DAHL_MASING, 0.5, 0.75),
        (EXP_MASING, 2.0, 1.0 - math.exp(-1.0)),
        (TIP_MASING, 2.0, 2.0 / (math.sqrt(8.0) + 2.0)),
    ],
)
def test_virgin_curves_have_risen_so_far_over_the_length_of_their_tangent(shape, exponent, at_one):
    assert loading_curve(1.0, shape, exponent) == pytest.approx(at_one)
    assert loading_curve(0.0, shape, exponent) == 0.0
    assert loading_curve(1e12, shape, exponent) == pytest.approx(1.0, abs=1e-5)


# 1 - (1 - x / 2)^2 is there after a travel of 2.
@pytest.mark.parametrize("x", [2.0, 3.0])
def test_an_exponent_below_one_saturates_at_a_finite_travel(x):
    assert (loading_curve(x, DAHL_MASING, 0.5), loading_slope(x, DAHL_MASING, 0.5)) == (1.0, 0.0)


@pytest.mark.parametrize("k", [0.1, 1.0, 10.0])
def test_a_loop_tip_is_where_a_loop_of_the_reformed_model_closes(k):
    # From -f_r with a slope of 1 toward 1: -f_r + p d / (p + d) = f_r, p = 1 + f_r, d = 2 k.
    tip = loop_tip(k)
    assert -tip + (1.0 + tip) * 2.0 * k / (1.0 + tip + 2.0 * k) == pytest.approx(tip)
    assert loop_tip_slope(k) == pytest.approx(
        (loop_tip(k + 1e-6) - loop_tip(k - 1e-6)) / 2e-6, rel=1e-6
    )
    assert loop_tip(math.inf) == loop_tip(1e200) == pytest.approx(1.0)
    assert loop_tip_slope(1e200) == pytest.approx(0.0, abs=1e-100)


@pytest.mark.parametrize("kernel", [DAHL_MASING, TIP_MASING, REFORMED_DAHL_EXACT, EXP_MASING])
def test_everett_functions_begin_with_half_of_the_stiffness_and_end_at_saturation(kernel):
    q = ClosedForm(kernel, 1e7, 20.0)
    assert slope(1e-6, 1e-6, 1.0, q) == slope(1e-6, 1e-6, -1.0, q) == pytest.approx(5e6)
    assert value(1e-6, 1e-6, q) == 0.0
    assert value(1.0, -1.0, q) == pytest.approx(20.0, rel=1e-4)
    assert virgin_slope(0.0, q) == pytest.approx(1e7)
    assert virgin(-3e-6, q) == -virgin(3e-6, q)
    for side in (1.0, -1.0):
        h = 1e-12
        for alpha, beta in ((3e-6, -1e-6), (1e-6, -3e-6)):
            moved = value(alpha + h, beta, q) if side > 0.0 else value(alpha, beta - h, q)
            assert slope(alpha, beta, side, q) == pytest.approx(
                (moved - value(alpha, beta, q)) / h, rel=1e-3
            )
    assert virgin_slope(2e-6, q) == pytest.approx(
        (virgin(2e-6 + h, q) - virgin(2e-6 - h, q)) / (2.0 * h), rel=1e-3
    )


def test_the_exact_kernel_gives_the_loop_of_the_reformed_model():
    q, x = ClosedForm(REFORMED_DAHL_EXACT, 1e7, 20.0), 2e-6
    # From the tip f_r on, back over the whole loop of 2 x: twice E is twice f_r.
    assert reformed_value(x, -x, q) == pytest.approx(20.0 * loop_tip(1.0))
    assert virgin(x, q) == pytest.approx(20.0 * loop_tip(1.0))


def test_virgin_relays_are_up_below_the_line_of_demagnetisation():
    made = relay_grid(levels=[-2.0, -1.0, 0.0, 1.0, 2.0], weights=np.ones(10))
    # Of (alpha, beta) in the middles of the cells those with a sum below zero are up, on the line half of each.
    assert made.component.new_memory(made.parameters).tolist() == [
        1.0,
        1.0,
        1.0,
        1.0,
        0.0,
        -1.0,
        0.0,
        -1.0,
        -1.0,
        -1.0,
    ]


def test_a_table_has_three_rows_and_columns_at_least():
    assert (
        tabulated(lambda alpha, beta: alpha - beta, 1.0, rows=3, columns=3).values["upper"].size
        == 3
    )
