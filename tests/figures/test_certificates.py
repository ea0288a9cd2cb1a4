"""Figures of friction with memory: drift, closure, and loops side by side."""

import re

import numpy as np
import pytest
from tests.certificates.ballscrew import UM, composite, lugre, maxwell_slip
from tests.figures.test_figures import assert_legible

from bristle import figures
from bristle.certificates import Path, check, traced

MODELS = {"LuGre": lugre(), "as printed": composite("paper"), "gate": composite(), "Maxwell slip": maxwell_slip()}
RIPPLE, LOOP = (0.04, 0.08), (3 * UM, 1.5 * UM)


@pytest.fixture(scope="module")
def result():
    return {name: check(model, force_ripple=RIPPLE, loop=LOOP) for name, model in MODELS.items()}


def drift_of(result):
    traces = {name: traced(model, Path.to_force, [RIPPLE[1], *(RIPPLE * 4)]) for name, model in MODELS.items()}
    return figures.drift(traces, {name: item["drift"].value for name, item in result.items()}, "rotational")


def closure_of(result):
    traces = {name: traced(model, Path.to_position, [*LOOP, LOOP[0]]) for name, model in MODELS.items()}
    return figures.closure(traces, {name: item["closure"].value for name, item in result.items()}, "rotational")


def loops_of(result):
    turns = [5 * UM, -5 * UM, UM, -2 * UM, UM, 5 * UM]
    return figures.minor_loops({name: traced(m, Path.to_position, turns) for name, m in MODELS.items()}, "rotational")


@pytest.mark.parametrize("draw", [drift_of, closure_of, loops_of])
def test_every_model_has_a_legible_panel_of_one_scale(draw, result):
    figure = draw(result)
    assert_legible(figure)
    assert len(figure.axes) == len(MODELS)
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    for axes in figure.axes:
        assert re.fullmatch(r"Angle \[[µm]?rad\]", axes.get_xlabel())
    assert "torque [mN·m]" in figure.axes[0].get_ylabel()


def test_drawn_cycles_drift_as_far_as_the_certificate_states(result):
    x, force = traced(MODELS["LuGre"], Path.to_force, [RIPPLE[1], *(RIPPLE * 4)])
    tops = x[np.isclose(force, RIPPLE[1], rtol=1e-9)]
    assert np.diff(tops)[-1] == pytest.approx(result["LuGre"]["drift"].value, rel=1e-6)


def test_the_drawn_loop_misses_the_force_of_the_certificate(result):
    x, force = traced(MODELS["LuGre"], Path.to_position, [*LOOP, LOOP[0]])
    first, last = force[x == LOOP[0]]
    assert (last - first) / 0.13 == pytest.approx(result["LuGre"]["closure"].value, rel=1e-9)
