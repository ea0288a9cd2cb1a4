"""Figures of hysteresis operators: what they show, legible and with units."""

import re

import numpy as np
import pytest
from tests.figures.test_figures import assert_legible

from bristle import figures, hysteresis
from bristle.core.errors import InputError
from bristle.engine.path import after
from bristle.figures.preisach import staircase

SIZES = {"translational": {"s": 1.25e7, "f_p": 150.0}, "rotational": {"s": 100.0, "f_p": 0.15}}
EXTENT = {"translational": 5e-5, "rotational": 6e-3}
HISTORY = (0.9, -0.6, 0.5, -0.1, 0.3)


@pytest.mark.parametrize("kind", SIZES)
def test_figures_of_operators_are_legible_and_named_for_their_axis(kind):
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", kind=kind, **SIZES[kind])
    figure = figures.preisach_plane(exact, EXTENT[kind] * np.array(HISTORY))
    assert_legible(figure)
    words = " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in figure.axes)
    foreign = r"\[[kmµ]?N\]|\[[mµn]?m\]|Force" if kind == "rotational" else r"rad|N·m|torque"
    assert not re.search(foreign, words, re.IGNORECASE)
    assert all(re.search(r"\[[^\]]+\]$", ax.get_xlabel()) for ax in figure.axes)


@pytest.mark.parametrize("history", [HISTORY, (0.7,), (-0.7,), (0.8, -0.3), (-0.9, 0.4, -0.2, 0.1)])
def test_below_the_staircase_are_the_relays_that_are_up(history):
    operator = hysteresis.preisach(s=1.0, f_p=1.0)
    grid = hysteresis.relays_of(operator, 1.0, 40)
    _, relays = after(grid, history)
    state, memory = after(operator, history)
    beta, alpha = staircase(memory[: state.depth], state.z).T
    cells = 0.5 * (grid.parameters.levels[1:] + grid.parameters.levels[:-1])
    for i, j, relay in zip(*np.tril_indices(40), relays, strict=True):
        if relay and abs(cells[i] + cells[j]) > 1e-9:
            # The line falls from the left: at a threshold beta its height is that of the corner before it.
            height = -cells[j] if cells[j] < beta[0] else float(alpha[np.searchsorted(beta, cells[j], "right") - 1])
            assert relay == (1.0 if cells[i] < height else -1.0)


def test_an_operator_without_turning_points_has_no_plane():
    with pytest.raises(InputError, match="has no turning points"):
        figures.preisach_plane(hysteresis.play(r=1.0), [1.0])
    with pytest.raises(InputError, match="is empty"):
        figures.preisach_plane(hysteresis.preisach(s=1.0, f_p=1.0), [])
