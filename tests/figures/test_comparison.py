"""The figure of two logs: what is drawn where a log has no reference, no turns, or nothing sure."""

import numpy as np
import pytest
from tests.figures.gallery import compared

from bristle.comparison import Change
from bristle.figures.comparison import FIGURE, SHORT, comparison, comparison_in_short


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def without_reference():
    item = compared()
    item.changes = {
        "effort.rms": Change("effort.rms", "force", 8.0, 9.0, (0.5, 1.5)),
        "effort.peak": Change("effort.peak", "force", 9.0, 9.5, None),
    }
    item.turns, item.friction_curve = (), []
    return item


def test_errors_are_drawn_with_a_reference_and_efforts_without():
    position, errors, *_ = comparison(compared()).axes
    assert position.get_title(loc="right") == "reference"
    assert errors.get_ylabel() == "Following error [µm]"
    position, errors, changes = comparison(without_reference()).axes
    assert position.get_title(loc="right") == "position"
    assert (position.get_ylabel(), errors.get_ylabel()) == ("Position [mm]", "Force [µN]")
    assert [label.get_text() for label in changes.get_yticklabels()] == ["effort, rms"]  # what has an interval


def test_before_is_light_below_after():
    errors = comparison(compared()).axes[1]
    before, after = lines(errors)["before"], lines(errors)["after"]
    assert before.get_linewidth() > after.get_linewidth()
    assert before.get_ydata().max() == pytest.approx(10.0, rel=1e-3)
    assert after.get_ydata().max() == pytest.approx(8.0, rel=1e-3)


def test_friction_has_a_mark_at_each_speed_before_and_after():
    friction = comparison(compared()).axes[-2]
    assert friction.get_title(loc="right") == "friction"
    assert (friction.get_xlabel(), friction.get_ylabel()) == ("Speed [mm/s]", "Force [µN]")
    assert lines(friction)["before"].get_data() == (pytest.approx([10.0, 50.0]), pytest.approx([20.0, 20.0]))
    assert lines(friction)["after"].get_ydata() == pytest.approx([21.0, 21.0])
    item = compared()
    item.turns = ()
    assert len(comparison(item).axes) == 4
    item.friction_curve = []
    assert len(comparison(item).axes) == 3


def test_the_window_after_a_reversal_is_shaded_over_the_zero_line():
    turn = comparison(compared()).axes[2]
    (shade,) = turn.patches
    assert (shade.get_x(), shade.get_x() + shade.get_width()) == pytest.approx((0.0, 150.0))
    assert turn.get_title(loc="right") == "forward to backward"
    assert lines(turn)["_aid"].get_ydata() == [0.0, 0.0]
    item = compared()
    item.window = None
    assert comparison(item).axes[2].patches[0].get_width() == 0.0


def test_a_full_point_has_an_interval_without_zero():
    changes = comparison(compared()).axes[-1]
    drawn = lines(changes)
    sure, unsure = drawn["_change"], drawn["_no change detected"]
    assert sure.get_data() == (pytest.approx([-50.0]), pytest.approx([0.0]))
    assert unsure.get_data() == (pytest.approx([5.0]), pytest.approx([1.0]))
    assert (sure.get_markerfacecolor(), unsure.get_markerfacecolor()) == (sure.get_color(), "white")
    x, y = drawn["_95 % interval"].get_data()
    assert x[[0, 1, 3, 4]] == pytest.approx([value for item in compared().changes.values() for value in item.interval_percent])
    assert np.isnan(x[[2, 5]]).all()
    assert y.tolist() == [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    assert changes.get_ylim() == (1.6, -0.6)


def test_the_short_figure_has_reversals_or_the_motion_above_the_changes():
    turn, changes = comparison_in_short(compared()).axes
    assert turn.get_title(loc="right") == "forward to backward"
    assert changes.get_xlabel() == "Change [%]"
    whole, _ = comparison_in_short(without_reference()).axes
    assert whole.get_title(loc="right") == ""
    item = without_reference()
    item.changes.pop("effort.rms")
    assert len(comparison_in_short(item).axes) == 1
    assert len(comparison(item).axes) == 2


def test_captions_name_the_panels():
    single, other = compared(), without_reference()
    assert "of the following error: light before" in FIGURE.caption(single)
    assert "of the effort: light before" in FIGURE.caption(other)
    assert ("around reversals" in FIGURE.caption(single), "around reversals" in FIGURE.caption(other)) == (True, False)
    assert ("at the same speeds" in FIGURE.caption(single), "at the same speeds" in FIGURE.caption(other)) == (True, False)
    assert SHORT.caption(single).startswith("Above, the mean following error around reversals")
    assert SHORT.caption(other).startswith("Above, the mean effort over the cycles")
    assert FIGURE.alternative(single).startswith("Following error and friction")
    assert SHORT.alternative(other) == "Effort before and after, and each change"
