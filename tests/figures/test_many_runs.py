"""Runs of a study as distributions, logs of a fleet one by one: shares, quantiles, marks of those beyond."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.figures.gallery import fleet

from bristle.figures.many_runs import fleet_parameter, fleet_parameters, study_spread
from bristle.figures.report_figure import FIGURES
from bristle.palette import LIGHT


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_runs_are_drawn_as_shares_with_their_quantiles():
    values = np.append(1e-6 * np.arange(101.0), [np.nan, np.inf])
    (axes,) = study_spread({"Way": {"all runs": values}}, ["m"]).axes
    span, bars = axes.patches[-1], axes.patches[0]
    shares, edges, _ = bars.get_data()
    assert shares.sum() == pytest.approx(100.0)
    assert (edges[0], edges[-1]) == pytest.approx((0.0, 100.0))
    assert lines(axes)["median"].get_xdata()[0] == pytest.approx(50.0)
    assert (span.get_x(), span.get_x() + span.get_width()) == pytest.approx((5.0, 95.0))


@pytest.mark.parametrize(("count", "bars"), [(9, 8), (100, 10), (10_000, 60)])
def test_bars_are_eight_to_sixty(count, bars):
    axes = study_spread({"Way": {"all": np.arange(float(count))}}, ["m"]).axes[0]
    assert axes.patches[0].get_data()[0].size == bars


def test_runs_without_numbers_have_no_median():
    axes = study_spread({"Way": {"all": np.full(3, np.nan)}}, ["m"]).axes[0]
    assert not axes.get_lines()


def test_the_caption_of_a_study_depends_on_its_grid():
    spread = {"m": ("Way", "m", {"all": np.arange(9.0)})}
    grid, plain = (Some(described={"grid": grid}) for grid in ({"a": [1]}, {}))
    assert FIGURES["many_runs.spread"].caption(grid, spread).endswith("A line for each point of the grid.")
    assert FIGURES["many_runs.spread"].caption(plain, spread).endswith("Shaded: the middle 90 % of the runs.")
    assert FIGURES["many_runs.spread"].alternative(plain, spread) == "Distribution of m over the runs"
    assert FIGURES["many_runs.spread"].draw(plain, spread).axes[0].get_xlabel() == "Way [m]"
    assert FIGURES["many_runs.fleet"].alternative(None, ["F_C", "M"], {}, [], []) == "F_C, M of each log with 95 % intervals"


def drawn(**changes):
    runs, names, apart = fleet(["F_C"])
    runs.columns |= changes
    return runs, fleet_parameters(runs, names, apart).axes[0]


def test_no_interval_is_clipped_except_of_a_log_far_away():
    runs, axes = drawn(**{"F_C.upper": fleet(["F_C"])[0].columns["F_C"] + np.where(np.arange(20) == 12, 3.0, 0.3)})
    columns = runs.columns
    inside = np.isfinite(columns["F_C"]) & (np.arange(20) != 3)  # the one far away ends in an arrow
    bottom, top = axes.get_ylim()
    assert bottom < np.min(columns["F_C.lower"][inside])
    assert np.max(columns["F_C.upper"][inside]) < top < columns["F_C"][3]


def marks(axes):
    """Where marks of their own stand, by their form: logs, and height as a share of the panel."""
    names = ("above", "below", "none")
    return {name: item.get_offsets().data.tolist() for name, item in zip(names, axes.collections[-3:], strict=True)}


def test_logs_without_a_value_or_beyond_the_panel_have_special_marks():
    runs, axes = drawn()
    result = marks(axes)
    assert [place for place, _ in result["above"]] == [3.0]
    assert [place for place, _ in result["none"]] == [9.0]
    assert result["below"] == []
    assert [height for _, height in result["above"] + result["none"]] == pytest.approx([0.97, 0.0])
    value = runs.columns["F_C"].copy()
    value[4] = -40.0
    assert marks(drawn(F_C=value)[1])["below"] == [[4.0, pytest.approx(0.03)]]
    statuses = np.where(np.arange(20) == 7, "held", runs.columns["F_C.status"])
    assert [place for place, _ in marks(drawn(**{"F_C.status": statuses})[1])["none"]] == [7.0, 9.0]


@pytest.mark.parametrize(("count", "size"), [(60, 3.4), (61, 2.0)])
def test_marks_are_smaller_for_many_logs(count, size):
    value = 8.0 + 0.01 * np.arange(float(count))
    columns = {
        "run": np.arange(count),
        "p": value,
        "p.lower": value - 1.0,
        "p.upper": value + 1.0,
        "p.status": np.full(count, "identified"),
    }
    runs = Some(columns=columns, count=count, described={"columns": {"p": {"unit": "N"}}})
    axes = fleet_parameters(runs, ["p"], {"p": np.array([], dtype=int)}).axes[0]
    assert axes.containers[0].lines[0].get_markersize() == size


def test_first_screen_has_whole_intervals_names_of_logs_and_hollow_doubts():
    value = np.array([5.0, 5.1, 8.0])
    columns = {
        "run": np.arange(3),
        "p": value,
        "p.lower": value - np.array([0.1, 2.0, 40.0]),
        "p.upper": value + np.array([0.1, 2.0, 40.0]),
    }
    columns["p.status"] = np.full(3, "identified")
    runs = Some(columns=columns, count=3, described={"columns": {"p": {"unit": "N"}}})
    (axes,) = fleet_parameter(runs, "p", np.array([], dtype=int), ["axis1", "axis2", "axis3"], [2]).axes
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["axis1", "axis2", "axis3"]
    low, high = axes.get_ylim()
    assert (low, high) == pytest.approx((5.05 - 5.0 * 2.1, 5.05 + 5.0 * 2.1), abs=1.5)  # clipped at five times the spread
    assert axes.containers[1].lines[0].get_markerfacecolor() == LIGHT["ground"]
    assert [len(points) for points in marks(axes).values()] == [1, 1, 0]
