"""Operators made from data: a grid of cells and a table along reversal curves, against what they are made of."""

import numpy as np
import pytest
from tests.models.hysteresis.paths import of, walk

from bristle import hysteresis, response
from bristle.core.dispatch import everett, everett_slope, virgin_curve, virgin_slope
from bristle.models.hysteresis import relays_of, table_of_curves

GRID = hysteresis.preisach_grid(**hysteresis.preisach_grid.example)


def curves_of(operator, extent=4.0, count=81, side=1.0, samples=80):
    # Denser where a curve is steepest.
    result = []
    for turn in np.linspace(-extent, 0.95 * extent, count).tolist():
        u = side * (turn + (extent - turn) * np.linspace(0.0, 1.0, samples) ** 2)
        result.append((u, response(operator, u, history=[side * extent])))
    return result


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_table_along_curves_is_the_operator_of_these_curves(side):
    truth = of("reformed_dahl_exact")
    table = table_of_curves(curves_of(truth, side=side))
    u = walk(1, 1500)
    # From saturation on, of which the curves tell; the virgin curve is half-way for this symmetric measure too.
    for history in ([4.0], [-4.0], []):
        difference = response(table, u, history=history) - response(truth, u, history=history)
        assert np.max(np.abs(difference)) < 0.01


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_constant_part_of_the_output_stays_in_a_table_along_curves(side):
    truth, u = of("reformed_dahl_exact"), walk(1, 300)
    table = table_of_curves([(u, f + 3.0) for u, f in curves_of(truth, side=side)])
    assert response(table, u, history=[4.0]) == pytest.approx(
        response(truth, u, history=[4.0]) + 3.0, abs=0.01
    )


def test_a_table_reproduces_its_curves_and_is_constant_beyond():
    curves = curves_of(of("dahl_masing"), count=9)
    table = table_of_curves(curves, columns=4001)
    for u, f in curves:
        assert np.max(np.abs(response(table, u, history=[4.0]) - f)) < 2e-5
    assert np.ptp(response(table, [4.0, 9.0, 50.0])) == 0.0
    assert np.ptp(response(table, [-4.0, -9.0, -50.0], history=[4.0])) == 0.0


MIRRORED = table_of_curves(curves_of(of("dahl_masing"), extent=1e-5, count=7, side=-1.0))
REVERSAL = hysteresis.reversal_table(**hysteresis.reversal_table.example)


@pytest.mark.parametrize("operator", [REVERSAL, GRID, MIRRORED], ids=lambda item: item.name)
def test_slopes_are_those_of_the_surface(operator):
    q, h, allowed = (
        operator.component.measure(operator.parameters),
        1e-11,
        {"rel": 1e-3, "abs": 1e3},
    )
    for alpha, beta in np.sort(np.random.default_rng(0).uniform(-0.95e-5, 0.95e-5, (60, 2)))[
        :, ::-1
    ].tolist():
        up = (everett(alpha + h, beta, q) - everett(alpha - h, beta, q)) / (2.0 * h)
        down = (everett(alpha, beta - h, q) - everett(alpha, beta + h, q)) / (2.0 * h)
        both = (virgin_curve(alpha + h, q) - virgin_curve(alpha - h, q)) / (2.0 * h)
        slopes = [
            everett_slope(alpha, beta, 1.0, q),
            everett_slope(alpha, beta, -1.0, q),
            virgin_slope(alpha, q),
        ]
        assert slopes == pytest.approx([up, down, both], **allowed)
    assert everett_slope(2e-5, 0.0, 1.0, q) == everett_slope(0.0, -2e-5, -1.0, q) == 0.0


def test_cells_agree_with_their_relays_where_both_are_exact():
    relays = relays_of(GRID, 1e-5, 3)
    levels = np.linspace(-1e-5, 1e-5, 4)
    path = levels[np.random.default_rng(2).integers(0, 4, 200)]
    assert np.allclose(
        response(GRID, path, history=[1e-5]), response(relays, path, history=[1e-5]), atol=1e-12
    )
