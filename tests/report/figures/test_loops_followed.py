"""Loops along a reference, of made-up errors: what is settled, what is looked at closely, and what stands in which panel."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.figures.gallery import PLAIN, F, T, X, lines, looped, simulated

from bristle.core import Status
from bristle.report.figures import gain_at_reversal, loop_rows, report_figure
from bristle.report.figures.following_error import following_error, has_completed, open_loop

AT_REVERSAL, FIGURE = (
    report_figure.FIGURES["first_screen.reversal"],
    report_figure.FIGURES["following_error.following"],
)
NAMES = ("base", "plain", "fed")


def test_zero_errors_have_bars():
    result = looped(("a",))
    result.variants["a"].measured = X
    spread = following_error(result).axes[2]
    shares, edges, _ = spread.patches[0].get_data()
    assert (shares.size, shares[0], edges[0], edges[-1]) == (80, 100.0, 0.0, 1.0)
    assert spread.get_xlim() == (0.01, 100.0)
    assert [label.get_text() for label in spread.get_xticklabels()] == [
        "0.01",
        "0.1",
        "1",
        "10",
        "100",
    ]


@pytest.mark.parametrize(
    ("focus", "panels", "title"),
    [((), 5, ""), (("plain", "fed"), 6, "plain and fed only"), (NAMES, 5, ""), (("none",), 5, "")],
)
def test_flattened_loops_get_a_separate_panel(focus, panels, title):
    figure = following_error(looped(NAMES), focus)
    assert (len(figure.axes), figure.get_size_inches()[1]) == (
        panels,
        pytest.approx(1.6 * (panels - 1)),
    )
    assert figure.axes[panels - 4].get_title(loc="right") == title
    shares = sum(patch.get_data()[0].sum() for patch in figure.axes[panels - 3].patches)
    assert shares == pytest.approx(100.0 * (2 if title else 3))


def test_a_measured_error_is_below_all_and_not_a_loop():
    figure = following_error(looped(NAMES), ("fed",), np.full(T.size, 9e-6))
    whole = lines(figure.axes[1])
    assert [list(whole), list(lines(figure.axes[2])), list(lines(figure.axes[-1]))] == [
        ["measured", *NAMES],
        ["fed"],
        [f"_{name}" for name in NAMES],
    ]
    assert whole["measured"].get_ydata() == pytest.approx(9.0)
    assert whole["measured"].get_linewidth() > whole["base"].get_linewidth()


def test_the_worst_reversal_of_a_single_loop_has_its_name():
    x = lines(gain_at_reversal(looped(NAMES), NAMES[1:]).axes[0])["without"].get_xdata()
    assert np.ptp(X[(x[0] <= T) & (x[-1] >= T)]) < 0.5 * np.ptp(X)
    named = AT_REVERSAL.draw(looped(NAMES), ["base"]).axes[0]
    assert [name for name in lines(named) if not name.startswith("_")] == ["base"]


def test_a_name_with_an_underscore_in_front_is_in_the_legend():
    figure = following_error(looped(("_hidden", "plain")))
    legends = [
        legend
        for legend in (*figure.legends, *(axes.get_legend() for axes in figure.axes))
        if legend
    ]
    assert any("_hidden" in text.get_text() for legend in legends for text in legend.get_texts())


def test_without_a_reversal_the_close_up_is_around_the_largest_error():
    result = looped(("a",))
    item = result.variants["a"]
    item.reference = T.copy()
    item.measured = T - 1e-6 * (np.abs(T - 3.0) < 0.01)
    x = gain_at_reversal(result, ("a",)).axes[0].get_lines()[0].get_xdata()
    assert x[0] < (3.0 if x[-1] < 10.0 else 3000.0) < x[-1]


def test_a_completed_loop_is_finite_and_longer_than_the_settling_time():
    result = looped(NAMES)
    assert has_completed(result) is True
    for name in NAMES[1:]:
        result.variants[name].status = Status.NOT_FINITE
    assert has_completed(result)
    assert list(lines(following_error(result).axes[1])) == ["base"]
    short = result.variants["base"]
    short.time = short.time[:100]
    assert has_completed(result) is False


def test_an_open_loop_has_a_legend_for_several_that_completed():
    result = looped(NAMES)
    result.variants["plain"].status = Status.NOT_FINITE
    figure = open_loop(result)
    assert list(lines(figure.axes[0])) == ["base", "fed"]
    assert [text.get_text() for text in figure.axes[1].texts] == ["base", "fed"]
    assert not open_loop(looped(("one",))).axes[1].texts


def test_captions_follow_the_drawing():
    assert "Reference minus encoder reading: over time" in FIGURE.caption(looped(NAMES), (), None)
    assert "Reference minus encoder reading, measured and simulated: over time" in FIGURE.caption(
        looped(NAMES), (), 1
    )
    assert (
        AT_REVERSAL.alternative(None, ["a", "b"])
        == "Error of a and b at the worst reversal; below, the whole run"
    )
    assert "measured" in lines(
        FIGURE.draw(looped(NAMES), (), Some(error=np.full(T.size, 9e-6))).axes[1]
    )
    assert "measured" not in lines(FIGURE.draw(looped(NAMES), (), None).axes[1])


# --- What is drawn over the loops: the ranges of a paper in the distribution, friction in the effort


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
            np.testing.assert_allclose(
                friction.get_ydata()[inner], 3.0 * (0.5 + 0.1 * k) * signal[part][inner]
            )
