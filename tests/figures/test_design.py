"""Figures of a loop that is designed: margins and poles, circle."""

import numpy as np
import pytest
from tests.figures.gallery import PLAIN, circles_of
from tests.figures.test_figures import assert_legible
from tests.loop.conftest import loop
from tests.loop.laws import rig

from bristle.figures import loop_design, rig_layout
from bristle.figures.loop_design import margins
from bristle.files.experiment import read_experiment
from bristle.loop import assess
from bristle.paper import EXPERIMENTS


@pytest.mark.parametrize("delay", [1, 3])
def test_gain_phase_and_poles_are_legible(delay):
    figure = margins(assess(rig(delay)))
    assert_legible(figure)
    assert "$" not in "".join(item.get_text() for axes in figure.axes for item in axes.get_xticklabels() + axes.get_yticklabels())


def test_the_deviation_of_a_circle_is_in_the_unit_of_its_axis():
    assert loop_design.circles(circles_of(PLAIN), "rotational").axes[1].get_ylabel().endswith("rad]")


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


def test_loops_are_bars_in_their_units_and_unknown_numbers_have_none():
    figure = loop_design.loops_proposed(["as it is", "wide"], [3e-6, None], [0.05, 0.04], [50.0, 20.0], 30.0, "rotational")
    assert [axes.get_xlabel() for axes in figure.axes] == ["Error, p-p [µrad]", "Torque, rms [mN·m]", "Phase margin [°]"]
    drawn = [[(bar.get_y() + 0.5 * bar.get_height(), bar.get_width()) for bar in axes.patches] for axes in figure.axes]
    assert drawn == [
        [(0.0, pytest.approx(3.0))],
        [(0.0, pytest.approx(50.0)), (1.0, pytest.approx(40.0))],
        [(0.0, pytest.approx(50.0)), (1.0, pytest.approx(20.0))],
    ]
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == [" 3.00 µrad", " 50.0 mN·m", " 40.0 mN·m", " 50.0", " 20.0"]
    empty = loop_design.loops_proposed(["alone"], [None], [None], [None], 30.0)
    assert [axes.get_xlim()[1] for axes in empty.axes] == pytest.approx([1.45] * 3)
