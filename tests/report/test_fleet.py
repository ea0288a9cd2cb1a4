"""The report of a fleet, from made-up logs with known numbers."""

import re
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.pages import Page, seen_by

from bristle.apps.arm import report as arm
from bristle.apps.arm.joints import effort_of_joints
from bristle.apps.study import report as study_module
from bristle.apps.study.fleet import report as report
from bristle.apps.study.store import Runs
from bristle.report.page import Front
from bristle.report.table import Table


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
    columns |= {f"plant.M{end}": np.full(count, np.nan) for end in ("", ".lower", ".upper")} | {
        "plant.M.status": np.full(count, "held")
    }
    about = {
        name: {"unit": unit, "description": text, "role": "parameter"}
        for name, unit, text in PARAMETERS
    }
    described = {
        "name": "axes",
        "kind": "translational",
        "model": "coulomb",
        "runs": 9,
        "metrics": list(about),
        "columns": about,
    }
    return Runs(described, columns)


PARAMETERS = (("friction.F_C", "N", "friction"), ("plant.M", "kg", "mass"))


def test_fleet_has_its_sentences():
    summary = report.fleet_summary(fleet(), provenance={})
    assert report.fleet_sentences(summary) == [
        "7 of 9 logs are complete: repeat the same command to continue.",
        "6 of 7 logs were identified, 1 failed.",
        "Warnings of the fits: clipped in 2 logs, one_speed in 1 log.",
        "Held-out error: median 3.5 %, largest 6 %.",
        "Outliers among the logs: 1 from b in friction.F_C.",
    ]
    assert summary["failures"] == [
        {"run": 6, "folder": "b", "log": "6.csv", "status": "refused", "reason": "no effort"}
    ]
    sound = summary | {
        "logs": 7,
        "failures": [],
        "warnings": {"clipped": 0},
        "held_out_error": {"median": None, "largest": None},
    }
    assert report.fleet_sentences(sound | {"parameters": {}, "again": []}) == [
        "7 of 7 logs were identified."
    ]


def test_parameter_of_a_fleet_has_quantiles_and_half_width():
    summary = report.fleet_summary(fleet(), provenance={})
    level, mass = summary["parameters"]["friction.F_C"], summary["parameters"]["plant.M"]
    assert [
        level[key] for key in ("count", "low", "median", "high", "half_width")
    ] == pytest.approx([6, 4.925, 5.025, 8.025, 0.2])
    assert level["apart"] == [{"run": 5, "folder": "b", "log": "5.csv", "value": 9.0}]
    assert [mass[key] for key in ("count", "low", "median", "half_width", "apart")] == [
        0,
        None,
        None,
        None,
        [],
    ]
    rows = [["friction.F_C", "6", "N", "4.93", "5.03", "8.03", "0.20"], ["plant.M", "0", *[""] * 5]]
    assert report.parameters_table(summary).rows == rows


SPREAD = (5.0, 5.1, 4.9, 5.0, 5.05, 9.0, 1.0, 30.0)
# The median of their distances from 5 is 0.1
AROUND_FIVE = (4.8, 4.9, 4.9, 5.0, 5.0, 5.1, 5.1, 5.2)


@pytest.mark.parametrize(
    ("levels", "half", "far"),
    [
        ((9.0, 5.0, 5.1, 4.9), 0.2, []),  # too few to tell
        ((9.0, 5.0, 5.1, 4.9, 5.0), 0.2, [0]),
        (SPREAD, 0.2, [7, 6, 5]),  # the farthest first
        (SPREAD, 10.0, [7]),  # the others within three and a half deviations of their own
        ((*AROUND_FIVE, 5.0 + 3.4 * 1.4826 * 0.1), 0.0, []),
        ((*AROUND_FIVE, 5.0 + 3.6 * 1.4826 * 0.1), 0.0, [8]),
        ((*AROUND_FIVE, 5.0 - 3.6 * 1.4826 * 0.1), 0.0, [8]),
    ],
)
def test_outlier_is_beyond_three_and_a_half_robust_deviations(levels, half, far):
    assert report.apart(fleet(levels, half=half).columns, "friction.F_C").tolist() == far


def test_fleet_has_a_row_for_each_log_and_states_omissions(monkeypatch):
    summary = report.fleet_summary(fleet(), provenance={})
    table = report.logs_table(fleet(), summary)
    assert (table.caption, table.heads) == (
        "The logs",
        ["Number", "Folder", "Log", "Held-out error", "friction.F_C [N]", "Warnings"],
    )
    assert table.rows[0] == ["0", "a", "0.csv", "1.00 %", "5.00 ± 0.20", "clipped, one_speed"]
    assert table.rows[6] == ["6", "b", "6.csv", "", "", ""]
    monkeypatch.setattr(report, "LOGS_SHOWN", 3)
    short = report.logs_table(fleet(), summary)
    assert (short.caption, len(short.rows)) == (
        "The logs (the first 3; the folder runs/ has all)",
        3,
    )
    open_ = fleet()
    open_.columns["friction.F_C.upper"][0] = np.nan
    assert report.logs_table(open_, summary).rows[0][4] == "5.00"


def test_failed_logs_have_reasons_and_a_limited_list():
    summary = report.fleet_summary(fleet(), provenance={})
    assert report.failed_logs_table(summary)[::2] == (
        "Logs that failed",
        [("b", "6.csv", "no effort")],
    )
    assert report.failed_logs_table(summary | {"failures": []}) is None
    many = report.failed_logs_table(summary | {"failures": summary["failures"] * 21})
    assert (many.caption, len(many.rows)) == ("Logs that failed (the first 20)", 20)
    assert (
        report.failed_logs_table(summary | {"failures": summary["failures"] * 20}).caption
        == "Logs that failed"
    )


@pytest.mark.usefixtures("undrawn")
def test_page_of_a_fleet_names_the_outliers():
    words = Page(
        report.fleet_report(fleet(), report.fleet_summary(fleet(), provenance={}), command="x")
    ).words
    for told in (
        "7 of 9 logs · coulomb · translational",
        "friction.F_C b 5.csv 9 N 5.03 N",
        "Every log",
    ):
        assert told in words


def sisters(*values, half=0.2, verdicts=None):
    columns = fleet(values, half).columns
    return Runs(
        fleet().described, columns | ({} if verdicts is None else {"verdict": np.array(verdicts)})
    )


def test_an_open_interval_does_not_differ():
    wide = sisters(5.0, 5.1, 6.0)
    wide.columns["friction.F_C.lower"][2] = np.nan  # an unknown end excludes no value
    assert report.differing(wide.columns, "friction.F_C").tolist() == []


def test_differing_log_is_in_the_title_and_the_verdict():
    runs = sisters(5.0, 5.1, 6.0)
    assert report.fleet_ruling(runs) == ("with_care", "Logs differ", ("F_C of 2 differs",))
    page = report.fleet_report(runs, report.fleet_summary(runs, provenance={}), command="x")
    assert "F_C of 2 differs" in page.partition('<div class="tabs">')[0].partition("<h2>")[2]
    assert report.fleet_ruling(sisters(5.0, 5.1)) == ("usable", "Logs agree", ())


def test_log_to_measure_again_is_not_good():
    runs = sisters(5.0, 5.1, 9.0, 5.05, verdicts=["usable", "with_care", "measure_again", "usable"])
    summary = report.fleet_summary(runs, provenance={})
    assert report.fleet_sentences(summary)[1] == "3 of 4 logs were identified, 1 to measure again."
    assert [entry["log"] for entry in summary["again"]] == ["2.csv"]
    assert (summary["parameters"]["friction.F_C"]["count"], summary["verdict"]["reasons"]) == (
        3,
        ("measure again: 2",),
    )
    cards = report._cards(summary, ["friction.F_C"])
    assert (cards[0].value, cards[1].value.replace("\u00a0", " ")) == ("3 of 4", "5.05 N")
    assert cards[1].half == pytest.approx(100.0 * 0.2 / 5.05)
    assert report._next(summary | {"logs": 4}, "x").command == "bristle log 2.csv --axis axis.toml"
    assert report.fleet_ruling(sisters(5.0, verdicts=["measure_again"]))[:2] == (
        "measure_again",
        "Measure again",
    )


def differing(*values):
    return report.differing(sisters(*values).columns, "friction.F_C").tolist()


def names_of(folders, logs):
    return report.short_names({"folder": np.array(folders), "log": np.array(logs)})


@pytest.mark.parametrize(
    ("found", "given", "result"),
    [
        # A log differs if its interval overlaps less than half of the others.
        (differing, (5.0, 5.1, 6.0), [2]),
        (differing, (5.0, 5.39, 5.1), []),
        (differing, (5.0, 6.0), [0, 1]),
        (differing, (5.0, 5.05, 5.1, 5.48), [3]),
        # Short names distinguish all logs.
        (names_of, (["x", "x"], ["axis1.csv", "axis2.csv"]), ["axis1", "axis2"]),
        (names_of, (["data/axis1", "data/axis2"], ["log.csv", "log.csv"]), ["axis1", "axis2"]),
        (names_of, (["a", "a", "b"], ["1.csv", "2.csv", "1.csv"]), ["a/1", "a/2", "b/1"]),
        # A statistic ignores infinities.
        (report._of_finite, (np.max, np.array([np.nan, np.inf])), None),
        (report._of_finite, (np.max, np.array([np.nan, 2.0, -3.0])), 2.0),
    ],
)
def test_logs_that_differ_are_told_apart(found, given, result):
    assert found(*given) == result


def test_axes_of_one_log_have_a_row_with_their_verdict_and_only_friction():
    runs = fleet()
    verdicts = np.array(["usable", "with_care"] * runs.count)[: runs.count]
    names = np.array([f"A{number}: arm.csv" for number in range(runs.count)])
    runs.columns.update(log=names, verdict=verdicts, status=np.full(runs.count, "ok"))
    runs = replace(runs, described=runs.described | {"logs": [{"sha256": "0"}] * runs.count})
    summary = report.fleet_summary(runs, provenance={})
    table = report.logs_table(runs, summary, brief=True)
    assert (table.heads, table.rows[1][:2]) == (
        ["Axis", "Verdict", "Held-out error", "F_C [N]"],
        ["A1", "Use with care"],
    )
    level, words, (reason,) = report.fleet_ruling(runs)
    assert (level, words, reason[:21]) == ("with_care", "Axes identified", "use with care: A1, A3")
    assert report.fleet_sentences(summary, "axes")[0].startswith("7 of 9 axes are complete")


# --- The first screen of an arm: a row and a picture per joint, the verdict first


TIME = np.arange(0.0, 8.0, 0.01)
ANGLE = np.sin(TIME)


def predicted(force, error):
    effort = force * np.sign(np.cos(TIME))
    return Some(time=TIME, position=ANGLE, effort=effort, effort_predicted=effort * (1.0 + error))


def summary(percent, level):
    metrics = {"force_error_percent": percent, "force_rmse": 1.5, "force_unit": "N*m"}
    verdict = {"level": level, "words": level, "reasons": ["a reason"]}
    return {
        "metrics": metrics,
        "inside_band_percent": None,
        "verdict": verdict,
        "completed": True,
        "kind": "rotational",
        "provenance": {"bristle": "0"},
    }


def page_of(names=("A1", "A2")):
    summaries = {
        name: summary(percent, level)
        for name, percent, level in zip(names, (4.0, 31.0), ("usable", "with_care"), strict=True)
    }
    predictions = {name: predicted(10.0 * (place + 1), 0.1) for place, name in enumerate(names)}
    return arm.arm_prediction(summaries, predictions, "arm", "other.csv", "bristle predict")


def test_the_first_screen_has_the_row_of_each_joint_and_the_largest_error():
    data, table, page = page_of()
    assert (data["verdict"]["level"], [row[0] for row in table.rows]) == ("with_care", ["A1", "A2"])
    first = page[: page.index('<div class="tabs">')]
    assert re.search(r"Largest prediction error: 31.0\s% of the effort \(A2\)", Page(page).words)
    assert first.count('<th scope="row"') == 2
    assert (
        first.index("The model is valid, with care")
        < first.index("<figure")
        < first.index('<th scope="row"')
    )
    assert page[len(first) :].count('<th scope="row">A1') == 0  # each row once
    assert re.search('<figure id="figure-joints"', first)


def test_each_joint_has_a_picture_with_its_measured_and_predicted_effort():
    figure = effort_of_joints(
        {"A1": predicted(10.0, 0.1), "A2": predicted(20.0, 0.2), "A3": predicted(5.0, 0.0)},
        "rotational",
    )
    for axes, size, error in zip(figure.axes, (10.0, 20.0, 5.0), (0.1, 0.2, 0.0), strict=True):
        measured, model = axes.get_lines()
        assert np.max(np.abs(measured.get_ydata())) == size
        assert np.max(np.abs(model.get_ydata())) == size * (1.0 + error)
    assert [axes.get_ylabel() for axes in figure.axes] == 3 * ["Torque [N·m]"]


def test_an_identified_arm_names_the_joint_of_the_largest_error():
    table = Table("The axes", ("Axis",), [("A1",)])
    front = arm.arm_front(Front("arm: a fleet", "2 of 2 axes"), table, {"A1": 0.05, "A2": 0.12})
    assert (front.heading, front.title, front.table) == (
        "arm: an arm",
        "Largest model error: 12.0\u00a0% (A2)",
        table,
    )
    assert front.next.command.startswith("bristle predict arm ")
    assert arm.arm_front(Front("arm: a fleet", ""), table, {}).title == ""


# --- The study_module of a study, from made-up runs with known numbers


COLUMNS = {
    "friction.F_C": {"role": "grid", "unit": "N"},
    "plant.M": {"role": "drawn", "unit": "kg"},
    "motion.rms": {"role": "metric", "unit": "m", "description": "position, rms"},
}
SAID = {
    "name": "rig",
    "kind": "translational",
    "runs": 10,
    "draws": 5,
    "sampling": "latin_hypercube",
    "seed": 7,
    "columns": COLUMNS,
}
SAID |= {
    "sobol_indices": False,
    "grid": {"friction.F_C": [1.0, 2.0]},
    "causes": {"plant.M": ["plant.M"]},
    "metrics": ["motion.rms"],
}


def runs(**changes):
    """Eight runs of ten: 1 to 6 mm, and two failures."""
    columns = {
        "run": np.arange(8),
        "status": np.array(["ok"] * 6 + ["refused", "raised"]),
        "reason": np.array([""] * 6 + ["F_C < 0", "boom"]),
        "friction.F_C": np.tile([1.0, 2.0], 4),
        "plant.M": np.repeat([1.0, 3.0, 2.0, 5.0], 2),
        "motion.rms": np.array([1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, np.nan, np.nan]),
    }
    return Runs(SAID | changes, columns)


@pytest.fixture
def reported():
    return study_module.study_summary(
        runs(), command="bristle study a.toml", provenance={"bristle": "0"}, worst=[5, 4, 9]
    )


def goes_with(summary, *entries):
    names = ("cause", "value", "interval")
    return summary | {
        "rank_correlations": [
            {"metric": "motion.rms"} | dict(zip(names, entry, strict=True)) for entry in entries
        ]
    }


def test_study_counts_runs_by_status(reported):
    assert (reported["runs"], reported["done"], reported["statuses"]) == (
        10,
        8,
        {"ok": 6, "raised": 1, "refused": 1},
    )
    assert reported["failures"] == [
        {"run": 6, "status": "refused", "reason": "F_C < 0"},
        {"run": 7, "status": "raised", "reason": "boom"},
    ]
    assert study_module.study_sentences(reported)[:2] == [
        "8 of 10 runs are complete: repeat the same command to continue.",
        "2 of 8 runs failed: 1 raised, 1 refused.",
    ]


def test_first_of_many_failures_are_listed():
    many = Runs(
        SAID, {name: np.repeat(column, 20)[-30:] for name, column in runs().columns.items()}
    )
    assert len(study_module.study_summary(many, command="", provenance={})["failures"]) == 20


def test_worst_runs_have_the_command_to_repeat_them(reported):
    assert [(entry["run"], entry["motion.rms"]) for entry in reported["worst"]] == [
        (5, 6e-3),
        (4, 5e-3),
    ]
    assert reported["worst"][0]["command"] == "bristle study a.toml --run 5 --out run_5"


def test_metric_is_reported_for_all_runs_and_each_point(reported):
    entry = reported["metrics"]["motion.rms"]
    assert (
        entry["count"],
        entry["mean"],
        entry["median"],
        entry["low"],
        entry["high"],
    ) == pytest.approx((6, 3.5e-3, 3.5e-3, 1.25e-3, 5.75e-3))
    assert np.all(np.isnan(entry["mean_interval"]))  # runs of one draw are not independent
    points = [(point["name"], point["count"], point["mean"]) for point in entry["points"]]
    assert points == [
        ("friction.F_C 1 N", 3, pytest.approx(3e-3)),
        ("friction.F_C 2 N", 3, pytest.approx(4e-3)),
    ]
    assert np.all(np.isfinite(entry["points"][0]["mean_interval"]))


@pytest.mark.parametrize(("indices", "known"), [(False, True), (True, False)])
def test_intervals_need_independent_runs(indices, known, monkeypatch):
    monkeypatch.setattr("bristle.apps.study.influence.sobol_indices", lambda runs: [])
    summary = study_module.study_summary(
        runs(grid={}, sobol_indices=indices), command="", provenance={}
    )
    assert "points" not in summary["metrics"]["motion.rms"]
    assert bool(np.all(np.isfinite(summary["metrics"]["motion.rms"]["mean_interval"]))) is known


def test_sentence_of_a_metric_names_the_strongest_cause(reported):
    assert study_module.study_sentences(reported)[2:] == [
        "Position, rms: median 3.5 mm, 90 % of the runs from 1.25 mm to 5.75 mm."
    ]
    entries = [
        ("plant.M", -0.6, (-0.8, -0.3)),
        ("x", 0.4, (-0.1, 0.7)),
        ("friction.F_C", 0.9, (0.8, 0.95)),
    ]
    # What the grid sets was not drawn.
    assert study_module.study_sentences(goes_with(reported, *entries))[3:] == [
        "This number falls most with plant.M (rank correlation −0.60)."
    ]
    assert (
        "rises most with x (rank correlation +0.70)"
        in study_module.study_sentences(goes_with(reported, *entries, ("x", 0.7, (0.1, 0.9))))[3]
    )


def test_study_of_failed_runs_has_a_sentence(reported):
    failed = {"done": 2, "runs": 2, "statuses": {"refused": 2}, "metrics": {}}
    assert study_module.study_sentences(reported | failed) == ["2 of 2 runs failed: 2 refused."]


@pytest.mark.parametrize("interval", [(-0.1, 0.4), (0.0, 0.4), (-0.4, 0.0)])
def test_cause_with_zero_in_its_interval_is_left_out(reported, interval):
    lines = study_module.study_sentences(goes_with(reported, ("plant.M", 0.2, interval)))
    assert lines[-1] == "These runs show no correlation of this number with any drawn cause."


def test_complete_study_has_no_sentence_on_failures(reported):
    whole = reported | {"runs": 8, "statuses": {"ok": 8}}
    assert study_module.study_sentences(whole) == study_module.study_sentences(reported)[2:]
    without = reported["metrics"]["motion.rms"] | {"count": 0}
    assert study_module.study_sentences(whole | {"metrics": {"motion.rms": without}}) == []


def test_table_of_a_distribution_has_two_digits_of_the_scatter(reported):
    (table,) = study_module.spread_tables(reported)
    assert table.caption == "Position, rms in mm (motion.rms)"
    assert table.heads == [
        "At",
        "Runs",
        "Mean",
        "95 % interval of the mean",
        "Std",
        "5 % quantile",
        "Median",
        "95 % quantile",
        "95 % interval of the quantile",
    ]
    assert table.rows == [
        ["all", "6", "3.5", "", "1.9", "1.2", "3.5", "5.8", ""],
        ["friction.F_C 1 N", "3", "3.0", "0.7 to 5.3", "2.0", "1.2", "3.0", "4.8", "3.0 to ?"],
        ["friction.F_C 2 N", "3", "4.0", "1.7 to 6.3", "2.0", "2.2", "4.0", "5.8", "4.0 to ?"],
    ]


def test_numbers_without_scatter_have_a_tenth_of_their_value(reported):
    entry = reported["metrics"]["motion.rms"] | {"std": 0.0, "mean": 3.5e-3, "points": []}
    (table,) = study_module.spread_tables({"metrics": {"motion.rms": entry}})
    assert table.rows[0][table.heads.index("Mean")] == "3.50"
    del entry["points"]
    (table,) = study_module.spread_tables({"metrics": {"motion.rms": entry | {"std": np.nan}}})
    assert not {"At", "Std"} & set(table.heads)


def test_metric_without_numbers_has_an_empty_row(reported):
    entry = reported["metrics"]["motion.rms"] | {"count": 0}
    (table,) = study_module.spread_tables({"metrics": {"motion.rms": entry | {"unit": "1"}}})
    assert table.caption == "Position, rms (motion.rms)"
    assert table.rows[0] == ["all", "0", *[""] * (len(table.heads) - 2)]


def test_causes_are_sorted_by_strength_with_intervals(reported):
    entries = [
        ("plant.M", -0.6, (-0.8, -0.3)),
        ("x", 0.4, (-0.1, 0.7)),
        ("friction.F_C", 0.9, (0.8, 0.95)),
    ]
    index = {"metric": "motion.rms", "cause": "x", "first": 0.123, "first_interval": (0.1, 0.2)}
    index |= {"total": 0.5, "total_interval": (-0.4, 0.6)}
    shares, ranks = study_module._influence_tables(
        goes_with(reported, *entries) | {"sobol_indices": [index]}
    )
    assert shares.heads == [
        "Metric",
        "Cause",
        "Alone",
        "95 % interval",
        "With interactions",
        "95 % interval with interactions",
    ]
    assert shares.rows == [
        ["motion.rms", "x", "0.123", "+0.10 to +0.20", "0.500", "−0.40 to +0.60"]
    ]
    assert ranks.rows == [
        ["motion.rms", "friction.F_C", "+0.90", "+0.80 to +0.95"],
        ["motion.rms", "plant.M", "−0.60", "−0.80 to −0.30"],
        ["motion.rms", "x", "+0.40", "−0.10 to +0.70"],
    ]
    assert study_module._influence_tables(reported) == []


def study_page(item, summary, monkeypatch, **facts):
    """The words of the page of a study, and the facts of its figures."""
    seen = seen_by(monkeypatch, study_module)
    study_module.study_report(item, summary, command="x")
    return seen | {"page": (seen["front"], {section.id: section for section in seen["sections"]})}


def test_figure_has_a_line_for_each_of_few_points(reported, monkeypatch):
    seen = study_page(runs(), reported, monkeypatch)
    words, unit, groups = seen["spread"]["motion.rms"]
    assert (words, unit, list(groups)) == (
        "Position, rms",
        "m",
        ["friction.F_C 1 N", "friction.F_C 2 N"],
    )
    assert groups["friction.F_C 2 N"][:3].tolist() == [2e-3, 4e-3, 6e-3]
    front, sections = seen["page"]
    assert front[:2] == (
        "rig: a study",
        "8 of 10 runs · 5 draws (latin hypercube), seed 7 · 2 points of a grid",
    )
    worst, failed = sections["worst"].blocks
    assert worst.rows == [
        ("5", "6 mm", "bristle study a.toml --run 5 --out run_5"),
        ("4", "5 mm", "bristle study a.toml --run 4 --out run_4"),
    ]
    assert failed.rows == [("6", "refused", "F_C < 0"), ("7", "raised", "boom")]
    (files,) = sections["files"].blocks
    assert files.rows[0] == ("friction.F_C", "grid", "N")


@pytest.mark.parametrize(("points", "together"), [(0, True), (5, False), (6, True)])
def test_figure_pools_many_points(reported, monkeypatch, points, together):
    grid = {"friction.F_C": [float(k) for k in range(points)]} if points else {}
    seen = study_page(runs(grid=grid), reported | {"worst": [], "failures": []}, monkeypatch)
    assert (list(seen["spread"]["motion.rms"][2]) == ["all runs"]) is together
    assert seen["page"][1]["worst"].blocks == []
    assert ("points of a grid" in seen["page"][0].facts) is (points > 0)


def test_first_screen_of_a_study_has_range_median_and_worst_run(reported, monkeypatch):
    front = study_page(runs(), reported, monkeypatch)["page"][0]
    assert front.title.replace("\u00a0", " ") == "Position, rms: 1.25 mm to 5.75 mm"
    values = {card.label: card.value.replace("\u00a0", " ") for card in front.cards}
    assert (
        values.items()
        >= {"Median": "3.5 mm", "95 % quantile": "5.75 mm", "Failed runs": "2"}.items()
    )
    assert (front.next.text, front.next.command) == ("Complete the study:", "x")
    done = reported | {"runs": 8}
    assert (
        study_page(runs(), done, monkeypatch)["page"][0].next.command == done["worst"][0]["command"]
    )
    assert (
        study_page(runs(), done | {"worst": []}, monkeypatch)["page"][0].next.text
        == "Repeat with other spreads:"
    )
