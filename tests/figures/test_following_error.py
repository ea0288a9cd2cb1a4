"""What the figure of the following error leaves out, and where it looks closely."""

from dataclasses import replace

import numpy as np

from bristle import figures
from bristle.core import Status
from bristle.figures.following_error import has_completed


def with_status(result, name, status):
    return replace(result, variants={**result.variants, name: replace(result.variants[name], status=status)})


def legend_of(figure):
    return [text.get_text() for axes in figure.axes if axes.get_legend() for text in axes.get_legend().get_texts()]


def test_a_loop_that_diverged_is_left_out(stage):
    result = with_status(stage.looped, "compensated", Status.NOT_FINITE)
    assert legend_of(figures.following_error(result)) == ["as_recorded", "feedforward"]


def test_the_measured_error_lies_under_the_simulated_ones(stage):
    result = stage.looped
    outcome = result.variants["as_recorded"]
    measured = 3.0 * (outcome.reference - outcome.measured)
    figure = figures.following_error(result, ("feedforward", "compensated"), measured)
    assert legend_of(figure) == ["measured", "as_recorded", "feedforward", "compensated"]
    lines = [[line.get_label() for line in axes.get_lines()] for axes in figure.axes]
    assert lines[1] == ["measured", "as_recorded", "feedforward", "compensated"]
    assert lines[2] == ["feedforward", "compensated"]
    drawn, simulated = (np.ptp(line.get_ydata()) for line in figure.axes[1].get_lines()[:2])
    assert drawn > 2.9 * simulated


def test_no_figure_if_all_loops_diverged(stage):
    result = stage.looped
    for name in result.variants:
        assert has_completed(result)
        result = with_status(result, name, Status.NOT_FINITE)
    assert not has_completed(result)


def test_the_close_up_contains_a_reversal_of_the_reference(stage):
    figure = figures.following_error(stage.looped)
    close = next(axes for axes in figure.axes if "reversal" in axes.get_title(loc="right"))
    low, high = close.get_xlim()
    item = stage.looped.variants["as_recorded"]
    inside = item.reference[(item.time >= low) & (item.time <= high)]
    assert np.diff(inside).min() < 0.0 < np.diff(inside).max()


def test_a_name_with_an_underscore_in_front_is_in_the_legend(stage):
    experiment = stage.looped.experiment
    first = replace(experiment.variants[0], name="_hidden")
    result = replace(
        stage.looped, experiment=replace(experiment, variants=(first,)), variants={"_hidden": stage.looped.variants["as_recorded"]}
    )
    assert any("_hidden" in text for text in legend_of(figures.following_error(result)))
