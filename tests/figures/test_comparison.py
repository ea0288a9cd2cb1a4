"""The figure of two logs: what is drawn where a log has no reference, no turns, or nothing sure."""

from dataclasses import replace

import numpy as np
import pytest
from tests.figures.gallery import T, compared

from bristle.comparison import Change
from bristle.figures.comparison import change_at_reversal, comparison
from bristle.figures.report_figure import FIGURES

FIGURE, WORST = FIGURES["comparison.comparison"], FIGURES["comparison.worst"]


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def without_reference(*left_out):
    item = compared()
    item.changes = {
        "effort.rms": Change("effort.rms", "force", 8.0, 9.0, (0.5, 1.5)),
        "effort.peak": Change("effort.peak", "force", 9.0, 9.5, None),
    }
    item.changes = {name: change for name, change in item.changes.items() if name not in left_out}
    item.turns, item.friction_curve = (), []
    return item


def test_efforts_are_drawn_without_a_reference():
    position, errors, changes = comparison(without_reference()).axes
    assert position.get_title(loc="right") == "position"
    assert (position.get_ylabel(), errors.get_ylabel()) == ("Position [mm]", "Force [µN]")
    assert [label.get_text() for label in changes.get_yticklabels()] == ["effort, rms"]  # what has an interval


@pytest.mark.parametrize(("without", "panels"), [({}, 5), ({"turns": ()}, 4), ({"turns": (), "friction_curve": []}, 3)])
def test_a_quantity_that_no_log_tells_has_no_panel(without, panels):
    item = compared()
    vars(item).update(without)
    assert len(comparison(item).axes) == panels


def test_an_unknown_window_after_a_reversal_is_not_shaded():
    item = compared()
    item.window = None
    assert comparison(item).axes[2].patches[0].get_width() == 0.0


def test_the_large_picture_is_the_worst_reversal_or_the_largest_value_over_the_mean_cycle():
    item = compared()
    small = replace(item.turns[0], name="backward_to_forward", before=0.1 * item.turns[0].before)
    item.turns = (small, *item.turns)
    drawn = lines(change_at_reversal(item).axes[0])
    assert drawn["before"].get_ydata().max() == pytest.approx(1e9 * item.turns[1].before.max(), rel=1e-3)
    near, _ = change_at_reversal(without_reference()).axes
    assert (near.get_xlabel(), near.get_ylabel()[:5]) == ("Time [ms]", "Force")
    assert np.ptp(lines(near)["before"].get_xdata()) < 200.0 * T[-1]


def test_changes_without_intervals_are_not_drawn():
    item = without_reference("effort.rms")
    assert not FIGURES["comparison.changes"].applies(item)
    assert len(comparison(item).axes) == 2


@pytest.mark.parametrize(
    ("item", "quantity", "panels", "worst"),
    [
        (compared(), "following error", True, "Mean following error at the worst reversal"),
        (without_reference(), "effort", False, "Mean effort around its largest value"),
    ],
)
def test_captions_name_the_panels(item, quantity, panels, worst):
    caption = FIGURE.caption(item)
    assert f"of the {quantity}: grey before" in caption
    assert ["around reversals" in caption, "at the same speeds" in caption] == [panels] * 2
    assert FIGURE.alternative(item).lower().startswith(quantity)
    assert WORST.alternative(item).startswith(worst)
