"""The figure of two logs: what is drawn where a log has no reference, no turns, or nothing sure."""

from dataclasses import replace

import numpy as np
import pytest
from tests.figures.gallery import T, compared

from bristle.comparison import Change
from bristle.figures.comparison import change_at_reversal, changes, comparison, friction_over_speed
from bristle.figures.report_figure import FIGURES
from bristle.palette import LIGHT

FIGURE, WORST = FIGURES["comparison.comparison"], FIGURES["comparison.worst"]


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


def test_before_is_grey_and_after_is_blue():
    errors = comparison(compared()).axes[1]
    before, after = lines(errors)["before"], lines(errors)["after"]
    assert (before.get_color(), after.get_color()) == (LIGHT["without"], LIGHT["with"])
    assert before.get_ydata().max() == pytest.approx(10.0, rel=1e-3)
    assert after.get_ydata().max() == pytest.approx(8.0, rel=1e-3)


def test_friction_has_a_mark_at_each_speed_before_and_after():
    friction = comparison(compared()).axes[-2]
    assert friction.get_title(loc="right") == "friction"
    assert (friction.get_xlabel(), friction.get_ylabel()) == ("Speed [mm/s]", "Friction force [µN]")
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
    assert (sure.get_markerfacecolor(), unsure.get_markerfacecolor()) == (sure.get_color(), LIGHT["ground"])
    x, y = drawn["_95 % interval"].get_data()
    assert x[[0, 1, 3, 4]] == pytest.approx([value for item in compared().changes.values() for value in item.interval_percent])
    assert np.isnan(x[[2, 5]]).all()
    assert y.tolist() == [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    assert changes.get_ylim() == (1.6, -0.6)


def test_the_large_picture_is_the_worst_reversal_or_the_largest_value_over_the_mean_cycle():
    item = compared()
    small = replace(item.turns[0], name="backward_to_forward", before=0.1 * item.turns[0].before)
    item.turns = (small, *item.turns)
    near, whole = change_at_reversal(item).axes
    assert list(lines(near)) == ["before", "after", "_aid"]
    drawn, turn = lines(near), item.turns[1]
    assert drawn["before"].get_ydata().max() / drawn["after"].get_ydata().max() == pytest.approx(turn.before.max() / turn.after.max())
    assert drawn["before"].get_ydata().max() == pytest.approx(1e9 * turn.before.max(), rel=1e-3)
    assert {text.get_text() for text in near.texts} == {"before", "after"}
    assert lines(whole)["before"].get_xdata()[-1] == pytest.approx(T[-1])
    near, _ = change_at_reversal(without_reference()).axes
    assert near.get_xlabel() == "Time [ms]"
    assert np.ptp(lines(near)["before"].get_xdata()) < 200.0 * T[-1]
    assert near.get_ylabel().startswith("Force")


def test_changes_and_friction_are_small_pictures():
    (axes,) = changes(compared()).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["error, rms", "friction"]
    (axes,) = friction_over_speed(compared()).axes
    assert {text.get_text() for text in axes.texts} == {"before", "after"}
    item = without_reference()
    item.changes.pop("effort.rms")
    assert not FIGURES["comparison.changes"].applies(item)
    assert len(comparison(item).axes) == 2


def test_captions_name_the_panels():
    single, other = compared(), without_reference()
    assert "of the following error: grey before" in FIGURE.caption(single)
    assert "of the effort: grey before" in FIGURE.caption(other)
    assert ("around reversals" in FIGURE.caption(single), "around reversals" in FIGURE.caption(other)) == (True, False)
    assert ("at the same speeds" in FIGURE.caption(single), "at the same speeds" in FIGURE.caption(other)) == (True, False)
    assert FIGURE.alternative(single).startswith("Following error and friction")
    assert WORST.alternative(single).startswith("Mean following error at the worst reversal")
    assert WORST.alternative(other).startswith("Mean effort around its largest value")
