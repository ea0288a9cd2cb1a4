"""Figures of a loop that is designed: margins and poles, circle."""

import numpy as np
import pytest
from tests.figures.test_figures import assert_legible
from tests.loop.conftest import loop
from tests.loop.laws import rig

from bristle.figures import loop_design
from bristle.figures.loop_design import margins
from bristle.loop import assess, run_circles


@pytest.mark.parametrize("delay", range(4))
def test_gain_phase_and_poles_are_legible(delay):
    figure = margins(assess(rig(delay)))
    assert_legible(figure)
    assert "$" not in "".join(item.get_text() for axes in figure.axes for item in axes.get_xticklabels() + axes.get_yticklabels())


def test_the_phase_margin_is_drawn_where_the_gain_crosses_one():
    result = assess(rig(1)).bare[0]
    _, _, phase = sorted(margins(assess(rig(1))).axes, key=lambda axes: axes.get_position().y1)[::-1]
    hertz, degrees = next(line.get_data() for line in phase.get_lines() if len(line.get_xdata()) == 2 and line.get_xdata()[0])
    assert hertz[0] == pytest.approx(result.margins.crossover / (2.0 * np.pi))
    assert degrees[1] - degrees[0] == pytest.approx(result.margins.phase)


def test_the_circle_is_drawn_around_and_unrolled():
    round_trip = run_circles((loop("without compensation", None), loop("as it is")), 5e-3, 5e-3)
    figure = loop_design.circles(round_trip, "translational")
    assert_legible(figure)
    around, unrolled = figure.axes
    assert around.name == "polar"
    for axes in (around, unrolled):
        highest = max(float(np.max(line.get_ydata())) for line in axes.get_lines())
        assert highest == pytest.approx(1e6 * max(float(np.max(circle.deviation)) for circle in round_trip), rel=1e-6)
    assert loop_design.circles(round_trip, "rotational").axes[1].get_ylabel().endswith("rad]")
