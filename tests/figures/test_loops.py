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


def test_the_bars_of_a_distribution_are_shares_of_the_samples_and_its_mean_is_their_middle():
    figure = loop_rows.error_distribution(simulated(PLAIN), 0.5, 0.0)
    for axes in figure.axes[:2]:
        shares, edges, _ = axes.patches[1].get_data()
        assert shares.sum() == pytest.approx(100.0, rel=1e-12)
        (mean,) = drawn(axes, "mean")
        middle = 0.5 * (edges[1:] + edges[:-1])
        assert mean.get_xdata()[0] == pytest.approx(shares @ middle / 100.0, abs=np.diff(edges)[0])


def test_panels_with_a_common_scale_contain_the_highest_of_all():
    loops = simulated(PLAIN)
    loops[PLAIN[1]].measured = loops[PLAIN[1]].reference + 1e-4 * np.sin(9.0 * T)
    *first, last = loop_rows.tracking_error(loops, 0.5).axes
    assert all(axes.get_ylim() == last.get_ylim() for axes in first)
    assert last.get_ylim()[1] > 0.1  # mm
    loops[PLAIN[1]].measured = loops[PLAIN[1]].reference - 1e-5 * (T > 2.0)
    first, last = loop_rows.error_distribution(loops, 0.5, 0.0).axes
    assert first.get_ylim() == last.get_ylim()
    assert first.get_ylim()[0] == 0.0
    assert first.get_ylim()[1] > max(float(np.max(patch.get_data().values)) for axes in (first, last) for patch in axes.patches[1:])


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
