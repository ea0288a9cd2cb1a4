"""Figures of a loop that is designed: margins and poles, circle."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from tests.figures.test_figures import assert_legible
from tests.loop.conftest import loop
from tests.loop.laws import rig

from bristle.figures import loop_design, rig_layout
from bristle.figures.loop_design import margins
from bristle.files.experiment import read_experiment
from bristle.loop import assess, run_circles
from bristle.palette import LIGHT
from bristle.paper import EXPERIMENTS


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


@pytest.mark.parametrize(("cutoff", "resolution"), [(200.0, 1.25e-7), (np.inf, 0.0)])
def test_the_mechanics_are_above_the_scheme_with_their_numbers(cutoff, resolution):
    figure = rig_layout.rig_layout(rig_layout.Mechanics(0.01, 4e-4, 3e-4, cutoff, resolution), loop("one"))
    assert_legible(figure)
    (axes,) = figure.axes
    texts = " ".join(text.get_text() for text in axes.texts)
    assert all(part in texts for part in ("lead 10 mm", "J_m = 3 kg·cm²", "J − J_m = 1 kg·cm²"))
    assert ("80 000 counts a turn" in texts) == ("filter 200 Hz" in texts) == (resolution > 0.0)
    assert ("perfect" in texts) == (resolution == 0.0)


def test_the_scheme_has_the_filter_of_the_controller_and_both_break_aways():
    variant = next(variant for variant in read_experiment(EXPERIMENTS / "set_a.toml").variants if variant.name == "printed")
    (axes,) = rig_layout.rig_layout(rig_layout.Mechanics(5e-3, 4e-4, 2.5e-4, 200.0, 1.25e-7), variant).axes
    texts = {text.get_text() for text in axes.texts}
    assert {"cutoff = 400 Hz", "F_S_pos = 65.3 N", "F_S_neg = 35.2 N"} <= texts


def test_loops_are_bars_in_their_units_and_margins_show_the_usual_least():
    figure = loop_design.loops_proposed(["as it is", "wide"], [3e-6, None], [0.05, 0.04], [50.0, 20.0], 30.0, "rotational")
    *_, phase = figure.axes
    assert [axes.get_xlabel() for axes in figure.axes] == ["Error, p-p [µrad]", "Torque, rms [mN·m]", "Phase margin [°]"]
    drawn = [
        [(bar.get_y() + 0.5 * bar.get_height(), bar.get_width(), to_hex(bar.get_facecolor())) for bar in axes.patches]
        for axes in figure.axes
    ]
    assert drawn[0] == [(0.0, pytest.approx(3.0), LIGHT["without"])]
    assert drawn[1] == [(0.0, pytest.approx(50.0), LIGHT["without"]), (1.0, pytest.approx(40.0), LIGHT["with"])]
    assert [width for _, width, _ in drawn[2]] == [50.0, 20.0]
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == [" 3.00 µrad", " 50.0 mN·m", " 40.0 mN·m", " 50.0", " 20.0"]
    assert phase.get_lines()[0].get_xdata()[0] == 30.0
    assert [axes.get_xlim() for axes in figure.axes] == [pytest.approx((0.0, 1.45 * most)) for most in (3.0, 50.0, 50.0)]
    assert [axes.yaxis.label.get_visible() for axes in figure.axes] == [True, False, False]
    empty = loop_design.loops_proposed(["alone"], [None], [None], [None], 30.0)
    assert [axes.get_xlim()[1] for axes in empty.axes] == pytest.approx([1.45] * 3)
