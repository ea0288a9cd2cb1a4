"""Loops along a reference, of made-up errors: what is settled, what is looked at closely, and what stands in which panel."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.figures.gallery import F, T, V, X, looped

from bristle.core import Status
from bristle.figures.following_error import AT_REVERSAL, FIGURE, following_error, has_completed, loops_at_reversal, open_loop

NAMES = ("base", "plain", "fed")


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_samples_before_the_settling_time_are_left_out():
    motion, errors, *_ = following_error(looped(NAMES)).axes
    assert motion.get_lines()[0].get_xdata()[[0, -1]] == pytest.approx([0.5, T[-1]])
    drawn = lines(errors)["plain"]
    assert drawn.get_xdata()[0] == pytest.approx(0.5)
    assert drawn.get_ydata().max() == pytest.approx(20.0 * np.tanh(V / 1e-3)[100:].max(), rel=1e-3)
    assert errors.get_ylabel() == "Following error [µm]"


def test_an_error_is_the_reference_minus_the_encoder_reading():
    result = looped(("a",))
    result.variants["a"].measured = X - 2e-6
    assert lines(following_error(result).axes[1])["a"].get_ydata() == pytest.approx(2.0)


def test_zero_errors_have_bars():
    result = looped(("a",))
    result.variants["a"].measured = X
    spread = following_error(result).axes[2]
    shares, edges, _ = spread.patches[0].get_data()
    assert (shares.size, shares[0], edges[0], edges[-1]) == (80, 100.0, 0.0, 1.0)
    assert spread.get_xlim() == (0.01, 100.0)
    assert [label.get_text() for label in spread.get_xticklabels()] == ["0.01", "0.1", "1", "10", "100"]


@pytest.mark.parametrize(
    ("focus", "panels", "title"), [((), 5, ""), (("plain", "fed"), 6, "plain and fed only"), (NAMES, 5, ""), (("none",), 5, "")]
)
def test_flattened_loops_get_a_separate_panel(focus, panels, title):
    figure = following_error(looped(NAMES), focus)
    assert len(figure.axes) == panels
    assert figure.get_size_inches()[1] == pytest.approx(1.6 * (panels - 1))
    assert figure.axes[panels - 4].get_title(loc="right") == title
    shares = sum(patch.get_data()[0].sum() for patch in figure.axes[panels - 3].patches)
    assert shares == pytest.approx(100.0 * (2 if title else 3))


def test_a_measured_error_is_below_all_and_not_a_loop():
    figure = following_error(looped(NAMES), ("fed",), np.full(T.size, 9e-6))
    whole, compensated = lines(figure.axes[1]), lines(figure.axes[2])
    assert list(whole) == ["measured", *NAMES]
    assert list(compensated) == ["fed"]
    assert whole["measured"].get_ydata() == pytest.approx(9.0)
    assert whole["measured"].get_linewidth() > whole["base"].get_linewidth()
    assert list(lines(figure.axes[-1])) == [f"_{name}" for name in NAMES]


def test_two_loops_are_light_and_dark_with_a_third_loop_behind():
    full, close, effort = loops_at_reversal(looped(NAMES), NAMES).axes
    styles = [(line.get_linestyle(), line.get_linewidth()) for line in full.get_lines()]
    assert styles == [("--", 1.1), ("-", 2.2), ("-", 0.9)]
    assert close.get_title(loc="right") == "at the worst reversal"
    assert list(lines(effort)) == [f"_{name}" for name in NAMES]
    full, close, _ = loops_at_reversal(looped(NAMES), NAMES, NAMES[1:]).axes
    assert close.get_title(loc="right") == "at the worst reversal, plain and fed only"
    assert list(lines(close)) == ["plain", "fed"]
    assert [line.get_linewidth() for line in loops_at_reversal(looped(NAMES), NAMES[:1]).axes[0].get_lines()] == [0.9]
    assert [line.get_linewidth() for line in loops_at_reversal(looped(NAMES), NAMES[:2]).axes[0].get_lines()] == [2.2, 0.9]


def test_without_a_reversal_the_close_up_is_around_the_largest_error():
    result = looped(("a",))
    item = result.variants["a"]
    item.reference = T.copy()
    item.measured = T - 1e-6 * (np.abs(T - 3.0) < 0.01)
    _, close, _ = loops_at_reversal(result, ("a",)).axes
    x = close.get_lines()[0].get_xdata()
    assert x[0] < (3.0 if x[-1] < 10.0 else 3000.0) < x[-1]
    assert x.size == 40 or np.ptp(x) > 0.0


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


def test_an_open_loop_has_four_panels_and_a_legend_for_several():
    figure = open_loop(looped(NAMES))
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "Position [mm]",
        "Velocity [mm/s]",
        "Friction force [N]",
        "Force of the drive [N]",
    ]
    assert list(lines(figure.axes[0])) == list(NAMES)
    assert figure.axes[2].get_lines()[0].get_ydata().max() == pytest.approx(F.max())
    assert figure.get_size_inches()[1] == pytest.approx(4 * 1.6)
    assert figure.axes[0].get_legend() is not None
    assert open_loop(looped(("one",))).axes[0].get_legend() is None
    result = looped(NAMES)
    result.variants["plain"].status = Status.NOT_FINITE
    assert list(lines(open_loop(result).axes[0])) == ["base", "fed"]


def test_captions_follow_the_drawing():
    assert "Reference minus encoder reading: over time" in FIGURE.caption(None, (), None)
    assert "Reference minus encoder reading, measured and simulated: over time" in FIGURE.caption(None, (), 1)
    single, two = (["a"], ["a"]), (["a", "b", "c"], ["b", "c"])
    assert AT_REVERSAL.caption(None, single).endswith("and the effort there.")
    assert AT_REVERSAL.caption(None, two).endswith("and the effort there. The close-ups show only b and c.")
    assert AT_REVERSAL.alternative(None, two).startswith("Following error of a, b, c over time")
    error = Some(error=np.full(T.size, 9e-6))
    assert "measured" in lines(FIGURE.draw(looped(NAMES), (), error).axes[1])
    assert "measured" not in lines(FIGURE.draw(looped(NAMES), (), None).axes[1])
    assert AT_REVERSAL.draw(looped(NAMES), (["base", "fed"], ["fed"])).axes[1].get_title(loc="right").endswith("fed only")
