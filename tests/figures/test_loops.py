"""What is drawn over the loops: the ranges of a paper in the distribution, friction in the effort."""

import numpy as np
import pytest
from tests.figures.gallery import PLAIN, F, T, simulated

from bristle.figures import loop_rows

LATE = T >= 0.5


def drawn(axes, label):
    return [line for line in axes.get_lines() if line.get_label() == label]


def test_a_published_range_is_in_the_panel_of_its_loop_in_the_unit_of_the_axis():
    figure = loop_rows.error_distribution(simulated(PLAIN), 0.5, 0.0, {PLAIN[1]: (-3e-6, 2e-5)})
    first, second = figure.axes[:2]
    assert first.get_xlabel() == "Following error [mm]"
    (low,), (high,) = drawn(second, "range in the paper"), drawn(second, "_same")
    assert [low.get_xdata()[0], high.get_xdata()[0]] == pytest.approx([-3e-3, 2e-2], rel=1e-12)
    assert not drawn(first, "range in the paper") + drawn(first, "_same")


def test_friction_is_drawn_over_the_raw_and_the_averaged_effort():
    loops = simulated(PLAIN)
    for k, item in enumerate(loops.values()):
        item.friction = (0.5 + 0.1 * k) * F
    figure = loop_rows.control_effort(loops, 0.5, (1.0, 2.0), 3.0)
    assert figure.axes[0].get_ylabel() == "Driving torque [N·m]"
    inner = slice(5, -6)  # a mean over ten samples reaches beyond the ends
    mean = np.convolve(F, np.full(10, 0.1), "same")
    for k, (whole, near) in enumerate((figure.axes[:2], figure.axes[2:4])):
        for axes, signal, part in ((whole, mean, LATE), (near, F, (T >= 1.0) & (T <= 2.0))):
            (effort,), (friction,) = drawn(axes, "driving torque"), drawn(axes, "friction")
            np.testing.assert_allclose(effort.get_ydata()[inner], 3.0 * signal[part][inner])
            np.testing.assert_allclose(friction.get_ydata()[inner], 3.0 * (0.5 + 0.1 * k) * signal[part][inner])
