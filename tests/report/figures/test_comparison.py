"""The figure of two logs: what is drawn where a log has no reference, no turns, or nothing sure."""

from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.apps.design.conftest import loop
from tests.apps.design.laws import rig
from tests.report.figures.gallery import PLAIN, T, circles_of, compared, fleet, lines
from tests.report.figures.test_figures import assert_legible

from bristle.apps.design import assess, loop_design
from bristle.apps.paper import EXPERIMENTS, rig_layout
from bristle.apps.study import many_runs
from bristle.core.palette import LIGHT
from bristle.files.experiment import read_experiment
from bristle.prediction.comparison import Change
from bristle.report.figures import report_figure
from bristle.report.figures.comparison import change_at_reversal, comparison

FIGURE, WORST = (
    report_figure.FIGURES["comparison.comparison"],
    report_figure.FIGURES["comparison.worst"],
)


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
    # What has an interval.
    assert [label.get_text() for label in changes.get_yticklabels()] == ["effort, rms"]


@pytest.mark.parametrize(
    ("without", "panels"), [({}, 5), ({"turns": ()}, 4), ({"turns": (), "friction_curve": []}, 3)]
)
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
    assert drawn["before"].get_ydata().max() == pytest.approx(
        1e9 * item.turns[1].before.max(), rel=1e-3
    )
    near, _ = change_at_reversal(without_reference()).axes
    assert (near.get_xlabel(), near.get_ylabel()[:5]) == ("Time [ms]", "Force")
    assert np.ptp(lines(near)["before"].get_xdata()) < 200.0 * T[-1]


def test_changes_without_intervals_are_not_drawn():
    item = without_reference("effort.rms")
    assert not report_figure.FIGURES["comparison.changes"].applies(item)
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


# --- Runs of a study as distributions, logs of a fleet one by one: shares, quantiles, marks of those beyond


def test_runs_are_drawn_as_shares_with_their_quantiles():
    values = np.append(1e-6 * np.arange(101.0), [np.nan, np.inf])
    (axes,) = many_runs.study_spread({"Way": {"all runs": values}}, ["m"]).axes
    span, bars = axes.patches[-1], axes.patches[0]
    shares, edges, _ = bars.get_data()
    assert shares.sum() == pytest.approx(100.0)
    assert (edges[0], edges[-1]) == pytest.approx((0.0, 100.0))
    assert lines(axes)["median"].get_xdata()[0] == pytest.approx(50.0)
    assert (span.get_x(), span.get_x() + span.get_width()) == pytest.approx((5.0, 95.0))


@pytest.mark.parametrize(("count", "bars"), [(9, 8), (100, 10), (10_000, 60)])
def test_bars_are_eight_to_sixty(count, bars):
    axes = many_runs.study_spread({"Way": {"all": np.arange(float(count))}}, ["m"]).axes[0]
    assert axes.patches[0].get_data()[0].size == bars


def test_runs_without_numbers_have_no_median():
    assert (
        not many_runs.study_spread({"Way": {"all": np.full(3, np.nan)}}, ["m"]).axes[0].get_lines()
    )


def test_the_caption_of_a_study_depends_on_its_grid():
    spread = {"m": ("Way", "m", {"all": np.arange(9.0)})}
    figure, (grid, plain) = (
        report_figure.FIGURES["many_runs.spread"],
        (Some(described={"grid": grid}) for grid in ({"a": [1]}, {})),
    )
    assert figure.caption(grid, spread).endswith("A line for each point of the grid.")
    assert figure.caption(plain, spread).endswith("Shaded: the middle 90 % of the runs.")
    told = figure.alternative(plain, spread), figure.draw(plain, spread).axes[0].get_xlabel()
    assert told == ("Distribution of m over the runs", "Way [m]")
    assert (
        report_figure.FIGURES["many_runs.fleet"].alternative(None, ["F_C", "M"], {}, [], [])
        == "F_C, M of each log with 95 % intervals"
    )


def drawn(**changes):
    runs, names, apart = fleet(["F_C"])
    runs.columns |= changes
    return runs, many_runs.fleet_parameters(runs, names, apart).axes[0]


def test_no_interval_is_clipped_except_of_a_log_far_away():
    runs, axes = drawn(
        **{"F_C.upper": fleet(["F_C"])[0].columns["F_C"] + np.where(np.arange(20) == 12, 3.0, 0.3)}
    )
    columns = runs.columns
    inside = np.isfinite(columns["F_C"]) & (np.arange(20) != 3)  # the one far away ends in an arrow
    bottom, top = axes.get_ylim()
    assert bottom < np.min(columns["F_C.lower"][inside])
    assert np.max(columns["F_C.upper"][inside]) < top < columns["F_C"][3]


def marks(axes):
    """Where marks of their own stand, by their form: logs, and height as a share of the panel."""
    names = ("above", "below", "none")
    return {
        name: item.get_offsets().data.tolist()
        for name, item in zip(names, axes.collections[-3:], strict=True)
    }


def test_logs_without_a_value_or_beyond_the_panel_have_special_marks():
    runs, axes = drawn()
    result = marks(axes)
    assert result == {
        "above": [[3.0, pytest.approx(0.97)]],
        "below": [],
        "none": [[9.0, pytest.approx(0.0)]],
    }
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
    axes = many_runs.fleet_parameters(runs, ["p"], {"p": np.array([], dtype=int)}).axes[0]
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
    (axes,) = many_runs.fleet_parameter(
        runs, "p", np.array([], dtype=int), ["axis1", "axis2", "axis3"], [2]
    ).axes
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["axis1", "axis2", "axis3"]
    low, high = axes.get_ylim()
    # Clipped at five times the spread.
    assert (low, high) == pytest.approx((5.05 - 5.0 * 2.1, 5.05 + 5.0 * 2.1), abs=1.5)
    assert axes.containers[1].lines[0].get_markerfacecolor() == LIGHT["ground"]
    assert [len(points) for points in marks(axes).values()] == [1, 1, 0]


# --- Figures of a loop that is designed: margins and poles, circle


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("delay", [1, 3])
def test_gain_phase_and_poles_are_legible(delay):
    figure = loop_design.margins(assess(rig(delay)))
    assert_legible(figure)
    assert "$" not in "".join(
        item.get_text()
        for axes in figure.axes
        for item in axes.get_xticklabels() + axes.get_yticklabels()
    )


def test_the_deviation_of_a_circle_is_in_the_unit_of_its_axis():
    assert (
        loop_design.circles(circles_of(PLAIN), "rotational").axes[1].get_ylabel().endswith("rad]")
    )


@pytest.mark.parametrize(("cutoff", "resolution"), [(200.0, 1.25e-7), (np.inf, 0.0)])
def test_the_mechanics_are_above_the_scheme_with_their_numbers(cutoff, resolution):
    figure = rig_layout.rig_layout(
        rig_layout.Mechanics(0.01, 4e-4, 3e-4, cutoff, resolution), loop("one")
    )
    (axes,) = figure.axes
    texts = " ".join(text.get_text() for text in axes.texts)
    assert all(part in texts for part in ("lead 10 mm", "J_m = 3 kg·cm²", "J − J_m = 1 kg·cm²"))
    assert ("80 000 counts a turn" in texts) == ("filter 200 Hz" in texts) == (resolution > 0.0)
    assert ("perfect" in texts) == (resolution == 0.0)


def test_the_scheme_has_the_filter_of_the_controller_and_both_break_aways():
    variant = next(
        variant
        for variant in read_experiment(EXPERIMENTS / "set_a.toml").variants
        if variant.name == "printed"
    )
    (axes,) = rig_layout.rig_layout(
        rig_layout.Mechanics(5e-3, 4e-4, 2.5e-4, 200.0, 1.25e-7), variant
    ).axes
    texts = {text.get_text() for text in axes.texts}
    assert {"cutoff = 400 Hz", "F_S_pos = 65.3 N", "F_S_neg = 35.2 N"} <= texts


def test_loops_are_bars_in_their_units_and_unknown_numbers_have_none():
    figure = loop_design.loops_proposed(
        ["as it is", "wide"], [3e-6, None], [0.05, 0.04], [50.0, 20.0], 30.0, "rotational"
    )
    assert [axes.get_xlabel() for axes in figure.axes] == [
        "Error, p-p [µrad]",
        "Torque, rms [mN·m]",
        "Phase margin [°]",
    ]
    drawn = [
        [(bar.get_y() + 0.5 * bar.get_height(), bar.get_width()) for bar in axes.patches]
        for axes in figure.axes
    ]
    assert drawn == [
        [(0.0, pytest.approx(3.0))],
        [(0.0, pytest.approx(50.0)), (1.0, pytest.approx(40.0))],
        [(0.0, pytest.approx(50.0)), (1.0, pytest.approx(20.0))],
    ]
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == [
        " 3.00 µrad",
        " 50.0 mN·m",
        " 40.0 mN·m",
        " 50.0",
        " 20.0",
    ]
    empty = loop_design.loops_proposed(["alone"], [None], [None], [None], 30.0)
    assert [axes.get_xlim()[1] for axes in empty.axes] == pytest.approx([1.45] * 3)
