"""The report of a fleet, from made-up logs with known numbers."""

from dataclasses import replace

import numpy as np
import pytest
from tests.report.pages import Page

from bristle.report import fleet as report
from bristle.report.fleet import apart, differing, fleet_ruling, fleet_sentences, fleet_summary, parameters_table, short_names
from bristle.study.store import Runs


def fleet(values=(5.0, 5.1, 4.9, 5.0, 5.05, 9.0, np.nan), half=0.2):
    """Logs with their levels of friction: one outlier, and a failure at the end."""
    level = np.array(values)
    count = level.size
    columns = {
        "run": np.arange(count),
        "folder": np.array(["a"] * 4 + ["b"] * (count - 4)),
        "log": np.array([f"{k}.csv" for k in range(count)]),
        "status": np.where(np.isfinite(level), "ok", "refused"),
        "reason": np.where(np.isfinite(level), "", "no effort"),
        "diagnostics": np.array(["clipped, one_speed", "clipped", *[""] * (count - 2)]),
        "held_out_error": 0.01 * np.arange(1.0, count + 1.0) + 0.0 * level,
        "friction.F_C": level,
        "friction.F_C.lower": level - half,
        "friction.F_C.upper": level + half,
        "friction.F_C.status": np.where(np.isfinite(level), "identified", ""),
    }
    columns |= {f"plant.M{end}": np.full(count, np.nan) for end in ("", ".lower", ".upper")} | {"plant.M.status": np.full(count, "held")}
    about = {name: {"unit": unit, "description": text, "role": "parameter"} for name, unit, text in PARAMETERS}
    described = {"name": "axes", "kind": "translational", "model": "coulomb", "runs": 9, "metrics": list(about), "columns": about}
    return Runs(described, columns)


PARAMETERS = (("friction.F_C", "N", "friction"), ("plant.M", "kg", "mass"))


def test_fleet_has_its_sentences():
    summary = fleet_summary(fleet(), provenance={})
    assert fleet_sentences(summary) == [
        "7 of 9 logs are complete: repeat the same command to continue.",
        "6 of 7 logs were identified, 1 failed.",
        "Warnings of the fits: clipped in 2 logs, one_speed in 1 log.",
        "Held-out error: median 3.5 %, largest 6 %.",
        "Outliers among the logs: 1 from b in friction.F_C.",
    ]
    assert summary["failures"] == [{"run": 6, "folder": "b", "log": "6.csv", "status": "refused", "reason": "no effort"}]
    sound = summary | {"logs": 7, "failures": [], "warnings": {"clipped": 0}, "held_out_error": {"median": None, "largest": None}}
    assert fleet_sentences(sound | {"parameters": {}, "again": []}) == ["7 of 7 logs were identified."]


def test_parameter_of_a_fleet_has_quantiles_and_half_width():
    summary = fleet_summary(fleet(), provenance={})
    level, mass = summary["parameters"]["friction.F_C"], summary["parameters"]["plant.M"]
    assert [level[key] for key in ("count", "low", "median", "high", "half_width")] == pytest.approx([6, 4.925, 5.025, 8.025, 0.2])
    assert level["apart"] == [{"run": 5, "folder": "b", "log": "5.csv", "value": 9.0}]
    assert [mass[key] for key in ("count", "low", "median", "half_width", "apart")] == [0, None, None, None, []]
    table = parameters_table(summary)
    assert table.rows == [["friction.F_C", "6", "N", "4.93", "5.03", "8.03", "0.20"], ["plant.M", "0", *[""] * 5]]
    assert (summary["held_out_error"]["median"], summary["held_out_error"]["largest"]) == pytest.approx((0.035, 0.06))


@pytest.mark.parametrize(("count", "far"), [(4, []), (5, [0])])
def test_fewer_than_five_logs_have_no_outliers(count, far):
    columns = fleet((9.0, 5.0, 5.1, 4.9, 5.0)[:count]).columns
    assert apart(columns, "friction.F_C").tolist() == far


def test_farthest_outlier_comes_first():
    columns = fleet((5.0, 5.1, 4.9, 5.0, 5.05, 9.0, 1.0, 30.0)).columns
    assert apart(columns, "friction.F_C").tolist() == [7, 6, 5]
    wide = fleet((5.0, 5.1, 4.9, 5.0, 5.05, 9.0, 1.0, 30.0), half=10.0).columns  # within three and a half deviations of its own
    assert apart(wide, "friction.F_C").tolist() == [7]


@pytest.mark.parametrize(("value", "far"), [(5.0 + 3.4 * 1.4826 * 0.1, 0), (5.0 + 3.6 * 1.4826 * 0.1, 1), (5.0 - 3.6 * 1.4826 * 0.1, 1)])
def test_outlier_is_beyond_three_and_a_half_robust_deviations(value, far):
    levels = (4.8, 4.9, 4.9, 5.0, 5.0, 5.1, 5.1, 5.2, value)  # the median of their distances from 5 is 0.1
    assert apart(fleet(levels, half=0.0).columns, "friction.F_C").size == far


def test_fleet_has_a_row_for_each_log_and_states_omissions(monkeypatch):
    summary = fleet_summary(fleet(), provenance={})
    table = report.logs_table(fleet(), summary)
    assert table.heads == ["Number", "Folder", "Log", "Held-out error", "friction.F_C [N]", "Warnings"]
    assert table.rows[0] == ["0", "a", "0.csv", "1.00 %", "5.00 ± 0.20", "clipped, one_speed"]
    assert table.rows[6] == ["6", "b", "6.csv", "", "", ""]
    assert table.caption == "The logs"
    monkeypatch.setattr(report, "LOGS_SHOWN", 3)
    short = report.logs_table(fleet(), summary)
    assert (short.caption, len(short.rows)) == ("The logs (the first 3; the folder runs/ has all)", 3)
    open_ = fleet()
    open_.columns["friction.F_C.upper"][0] = np.nan
    assert report.logs_table(open_, summary).rows[0][4] == "5.00"


def test_failed_logs_have_reasons_and_a_limited_list():
    summary = fleet_summary(fleet(), provenance={})
    assert report.failed_logs_table(summary)[::2] == ("Logs that failed", [("b", "6.csv", "no effort")])
    assert report.failed_logs_table(summary | {"failures": []}) is None
    many = report.failed_logs_table(summary | {"failures": summary["failures"] * 21})
    assert (many.caption, len(many.rows)) == ("Logs that failed (the first 20)", 20)
    assert report.failed_logs_table(summary | {"failures": summary["failures"] * 20}).caption == "Logs that failed"


@pytest.mark.usefixtures("undrawn")
def test_page_of_a_fleet_names_the_outliers():
    words = Page(report.fleet_report(fleet(), fleet_summary(fleet(), provenance={}), command="x")).words
    assert "7 of 9 logs · coulomb · translational" in words
    assert "friction.F_C b 5.csv 9 N 5.03 N" in words
    assert "Every log" in words


def test_statistic_ignores_infinities():
    assert report._of_finite(np.max, np.array([np.nan, np.inf])) is None
    assert report._of_finite(np.max, np.array([np.nan, 2.0, -3.0])) == 2.0


def sisters(*values, half=0.2, verdicts=None):
    columns = fleet(values, half).columns
    return Runs(fleet().described, columns | ({} if verdicts is None else {"verdict": np.array(verdicts)}))


def test_a_log_differs_if_its_interval_overlaps_less_than_half_of_the_others():
    assert differing(sisters(5.0, 5.1, 6.0).columns, "friction.F_C").tolist() == [2]
    assert differing(sisters(5.0, 5.39, 5.1).columns, "friction.F_C").tolist() == []
    assert differing(sisters(5.0, 6.0).columns, "friction.F_C").tolist() == [0, 1]
    assert differing(sisters(5.0, 5.05, 5.1, 5.48).columns, "friction.F_C").tolist() == [3]
    wide = sisters(5.0, 5.1, 6.0)
    wide.columns["friction.F_C.lower"][2] = np.nan  # an unknown end excludes no value
    assert differing(wide.columns, "friction.F_C").tolist() == []


def test_differing_log_is_in_the_title_and_the_verdict():
    runs = sisters(5.0, 5.1, 6.0)
    assert fleet_ruling(runs) == ("with_care", "Logs differ", ("F_C of 2 differs",))
    page = report.fleet_report(runs, fleet_summary(runs, provenance={}), command="x")
    assert "F_C of 2 differs" in page.partition('<div class="tabs">')[0].partition("<h2>")[2]
    assert fleet_ruling(sisters(5.0, 5.1)) == ("usable", "Logs agree", ())


def test_log_to_measure_again_is_not_good():
    runs = sisters(5.0, 5.1, 9.0, 5.05, verdicts=["usable", "with_care", "measure_again", "usable"])
    summary = fleet_summary(runs, provenance={})
    assert fleet_sentences(summary)[1] == "3 of 4 logs were identified, 1 to measure again."
    assert [entry["log"] for entry in summary["again"]] == ["2.csv"]
    assert summary["parameters"]["friction.F_C"]["count"] == 3
    assert summary["verdict"]["reasons"] == ("measure again: 2",)
    cards = report._cards(summary, ["friction.F_C"])
    assert (cards[0].value, cards[1].value.replace("\u00a0", " ")) == ("3 of 4", "5.05 N")
    assert cards[1].half == pytest.approx(100.0 * 0.2 / 5.05)
    assert report._next(summary | {"logs": 4}, "x").command == "bristle log 2.csv --axis axis.toml"
    nothing = sisters(5.0, verdicts=["measure_again"])
    assert fleet_ruling(nothing)[:2] == ("measure_again", "Measure again")


def test_short_names_distinguish_all_logs():
    def named(folders, logs):
        return short_names({"folder": np.array(folders), "log": np.array(logs)})

    assert named(["x", "x"], ["axis1.csv", "axis2.csv"]) == ["axis1", "axis2"]
    assert named(["data/axis1", "data/axis2"], ["log.csv", "log.csv"]) == ["axis1", "axis2"]
    assert named(["a", "a", "b"], ["1.csv", "2.csv", "1.csv"]) == ["a/1", "a/2", "b/1"]


def test_axes_of_one_log_have_a_row_with_their_verdict_and_only_friction():
    runs = fleet()
    columns = runs.columns
    columns["log"] = np.array([f"A{number}: arm.csv" for number in range(runs.count)])
    columns["verdict"] = np.array(["usable", "with_care"] * runs.count)[: runs.count]
    columns["status"] = np.full(runs.count, "ok")
    runs = replace(runs, described=runs.described | {"logs": [{"sha256": "0"}] * runs.count})
    summary = fleet_summary(runs, provenance={})
    table = report.logs_table(runs, summary, brief=True)
    assert table.heads == ["Axis", "Verdict", "Held-out error", "F_C [N]"]
    assert table.rows[1][:2] == ["A1", "Use with care"]
    ruling = report.fleet_ruling(runs)
    assert (ruling.level, ruling.words) == ("with_care", "Axes identified")
    assert ruling.reasons[0].startswith("use with care: A1, A3")
    assert fleet_sentences(summary, "axes")[0].startswith("7 of 9 axes are complete")
