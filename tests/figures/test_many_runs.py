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
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Way [µm]", "Share of the runs [%]")
    assert axes.get_ylim()[0] == 0.0
    span, bars, outline = axes.patches[-1], *axes.patches[:2]
    shares, edges, _ = bars.get_data()
    assert shares.size == 10  # the root of their number
    assert shares.sum() == pytest.approx(100.0)
    assert (edges[0], edges[-1]) == pytest.approx((0.0, 100.0))
    assert lines(axes)["median"].get_xdata()[0] == pytest.approx(50.0)
    assert (span.get_x(), span.get_x() + span.get_width()) == pytest.approx((5.0, 95.0))
    assert outline.get_label() == "all runs"


@pytest.mark.parametrize(("count", "bars"), [(9, 8), (100, 10), (10_000, 60)])
def test_bars_are_eight_to_sixty(count, bars):
    axes = study_spread({"Way": {"all": np.arange(float(count))}}, ["m"]).axes[0]
    assert axes.patches[0].get_data()[0].size == bars
    grouped = study_spread({"Way": {"a": np.arange(float(count)), "b": np.arange(float(count))}}, ["m"]).axes[0]
    assert grouped.patches[0].get_data()[0].size == bars


def test_points_of_a_grid_are_lines_without_bars():
    axes = study_spread({"Way": {"1 Hz": np.arange(9.0), "2 Hz": 2.0 * np.arange(9.0)}}, ["m"]).axes[0]
    assert [patch.get_label() for patch in axes.patches] == ["1 Hz", "2 Hz"]
    assert not axes.get_lines()
    assert study_spread({"a": {"x": np.arange(9.0)}}, ["m"]).get_size_inches()[1] == pytest.approx(4.4)
    assert study_spread({"a": {"x": np.arange(9.0), "y": np.arange(9.0)}}, ["m"]).get_size_inches()[1] == pytest.approx(4.4)


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


def test_the_median_is_that_of_logs_with_a_value():
    runs, axes = drawn()
    tells = np.isfinite(runs.columns["F_C"])
    assert lines(axes)["median"].get_ydata()[0] == pytest.approx(np.median(runs.columns["F_C"][tells]))
    assert axes.get_xlim() == pytest.approx((-0.6, 19.6))
    assert axes.get_ylabel() == "F_C [N]"


def test_every_log_has_its_interval_and_outliers_are_hollow():
    runs, axes = drawn()
    ordinary, apart = axes.containers
    assert (ordinary.get_label(), apart.get_label()) == ("_log, 95 % interval", "_outlier, or measure again")
    assert sorted(ordinary.lines[0].get_xdata()) == [k for k in range(20) if k not in (3, 5, 9)]
    assert apart.lines[0].get_xdata().tolist() == [5]
    assert apart.lines[0].get_markerfacecolor() == LIGHT["ground"] != ordinary.lines[0].get_markerfacecolor()
    ends = np.array([segment[:, 1] for segment in ordinary.lines[2][0].get_segments()])
    assert ends[:, 1] - ends[:, 0] == pytest.approx(0.6)
    assert ends.mean(axis=1) == pytest.approx(runs.columns["F_C"][[k for k in range(20) if k not in (3, 5, 9)]])


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
    assert low < 3.1
    assert high > 7.1
    assert (low, high) == pytest.approx((5.05 - 5.0 * 2.1, 5.05 + 5.0 * 2.1), abs=1.5)  # clipped at five times the spread
    assert axes.containers[1].lines[0].get_markerfacecolor() == LIGHT["ground"]
    assert [len(points) for points in marks(axes).values()] == [1, 1, 0]
