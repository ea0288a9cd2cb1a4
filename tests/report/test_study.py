"""The report of a study, from made-up runs with known numbers."""

import numpy as np
import pytest

from bristle.report import study as report
from bristle.report.study import spread_tables, study_sentences, study_summary
from bristle.study.store import Runs

COLUMNS = {
    "friction.F_C": {"role": "grid", "unit": "N"},
    "plant.M": {"role": "drawn", "unit": "kg"},
    "motion.rms": {"role": "metric", "unit": "m", "description": "position, rms"},
}
SAID = {"name": "rig", "kind": "translational", "runs": 10, "draws": 5, "sampling": "latin_hypercube", "seed": 7, "columns": COLUMNS}
SAID |= {"sobol_indices": False, "grid": {"friction.F_C": [1.0, 2.0]}, "causes": {"plant.M": ["plant.M"]}, "metrics": ["motion.rms"]}


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
    return study_summary(runs(), command="bristle study a.toml", provenance={"bristle": "0"}, worst=[5, 4, 9])


def goes_with(summary, *entries):
    names = ("cause", "value", "interval")
    return summary | {"rank_correlations": [{"metric": "motion.rms"} | dict(zip(names, entry, strict=True)) for entry in entries]}


def test_study_counts_runs_by_status(reported):
    assert (reported["runs"], reported["done"], reported["statuses"]) == (10, 8, {"ok": 6, "raised": 1, "refused": 1})
    assert reported["failures"] == [{"run": 6, "status": "refused", "reason": "F_C < 0"}, {"run": 7, "status": "raised", "reason": "boom"}]
    assert study_sentences(reported)[:2] == [
        "8 of 10 runs are complete: repeat the same command to continue.",
        "2 of 8 runs failed: 1 raised, 1 refused.",
    ]


def test_first_of_many_failures_are_listed():
    many = Runs(SAID, {name: np.repeat(column, 20)[-30:] for name, column in runs().columns.items()})
    assert len(study_summary(many, command="", provenance={})["failures"]) == 20


def test_worst_runs_have_the_command_to_repeat_them(reported):
    assert [(entry["run"], entry["motion.rms"]) for entry in reported["worst"]] == [(5, 6e-3), (4, 5e-3)]
    assert reported["worst"][0]["command"] == "bristle study a.toml --run 5 --out run_5"


def test_metric_is_reported_for_all_runs_and_each_point(reported):
    entry = reported["metrics"]["motion.rms"]
    assert (entry["count"], entry["mean"], entry["median"], entry["low"], entry["high"]) == pytest.approx(
        (6, 3.5e-3, 3.5e-3, 1.25e-3, 5.75e-3)
    )
    assert np.all(np.isnan(entry["mean_interval"]))  # runs of one draw are not independent
    points = entry["points"]
    assert [(point["name"], point["count"]) for point in points] == [("friction.F_C 1 N", 3), ("friction.F_C 2 N", 3)]
    assert [point["mean"] for point in points] == pytest.approx([3e-3, 4e-3])
    assert np.all(np.isfinite(points[0]["mean_interval"]))


@pytest.mark.parametrize(("indices", "known"), [(False, True), (True, False)])
def test_intervals_need_independent_runs(indices, known, monkeypatch):
    monkeypatch.setattr("bristle.study.influence.sobol_indices", lambda runs: [])
    summary = study_summary(runs(grid={}, sobol_indices=indices), command="", provenance={})
    assert "points" not in summary["metrics"]["motion.rms"]
    assert bool(np.all(np.isfinite(summary["metrics"]["motion.rms"]["mean_interval"]))) is known


def test_sentence_of_a_metric_names_the_strongest_cause(reported):
    assert study_sentences(reported)[2:] == ["Position, rms: median 3.5 mm, 90 % of the runs from 1.25 mm to 5.75 mm."]
    entries = [("plant.M", -0.6, (-0.8, -0.3)), ("x", 0.4, (-0.1, 0.7)), ("friction.F_C", 0.9, (0.8, 0.95))]
    # What the grid sets was not drawn.
    assert study_sentences(goes_with(reported, *entries))[3:] == ["This number falls most with plant.M (rank correlation −0.60)."]
    assert "rises most with x (rank correlation +0.70)" in study_sentences(goes_with(reported, *entries, ("x", 0.7, (0.1, 0.9))))[3]


def test_study_of_failed_runs_has_a_sentence(reported):
    lines = study_sentences(reported | {"done": 2, "runs": 2, "statuses": {"refused": 2}, "metrics": {}})
    assert lines == ["2 of 2 runs failed: 2 refused."]


@pytest.mark.parametrize("interval", [(-0.1, 0.4), (0.0, 0.4), (-0.4, 0.0)])
def test_cause_with_zero_in_its_interval_is_left_out(reported, interval):
    lines = study_sentences(goes_with(reported, ("plant.M", 0.2, interval)))
    assert lines[-1] == "These runs show no correlation of this number with any drawn cause."


def test_complete_study_has_no_sentence_on_failures(reported):
    whole = reported | {"runs": 8, "statuses": {"ok": 8}}
    assert study_sentences(whole) == study_sentences(reported)[2:]
    without = reported["metrics"]["motion.rms"] | {"count": 0}
    assert study_sentences(whole | {"metrics": {"motion.rms": without}}) == []


def test_table_of_a_distribution_has_two_digits_of_the_scatter(reported):
    (table,) = spread_tables(reported)
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
    (table,) = spread_tables({"metrics": {"motion.rms": entry}})
    assert table.rows[0][table.heads.index("Mean")] == "3.50"
    del entry["points"]
    (table,) = spread_tables({"metrics": {"motion.rms": entry | {"std": np.nan}}})
    assert "At" not in table.heads
    assert "Std" not in table.heads


def test_metric_without_numbers_has_an_empty_row(reported):
    entry = reported["metrics"]["motion.rms"] | {"count": 0}
    (table,) = spread_tables({"metrics": {"motion.rms": entry | {"unit": "1"}}})
    assert table.caption == "Position, rms (motion.rms)"
    assert table.rows[0] == ["all", "0", *[""] * (len(table.heads) - 2)]


def test_causes_are_sorted_by_strength_with_intervals(reported):
    entries = [("plant.M", -0.6, (-0.8, -0.3)), ("x", 0.4, (-0.1, 0.7)), ("friction.F_C", 0.9, (0.8, 0.95))]
    index = {"metric": "motion.rms", "cause": "x", "first": 0.123, "first_interval": (0.1, 0.2)}
    index |= {"total": 0.5, "total_interval": (-0.4, 0.6)}
    shares, ranks = report._influence_tables(goes_with(reported, *entries) | {"sobol_indices": [index]})
    assert shares.heads == ["Metric", "Cause", "Alone", "95 % interval", "With interactions", "95 % interval with interactions"]
    assert shares.rows == [["motion.rms", "x", "0.123", "+0.10 to +0.20", "0.500", "−0.40 to +0.60"]]
    assert ranks.rows == [
        ["motion.rms", "friction.F_C", "+0.90", "+0.80 to +0.95"],
        ["motion.rms", "plant.M", "−0.60", "−0.80 to −0.30"],
        ["motion.rms", "x", "+0.40", "−0.10 to +0.70"],
    ]
    assert report._influence_tables(reported) == []


def page_of(item, summary, monkeypatch, **facts):
    """The words of the page of a study, and the facts of its figures."""
    seen = {}

    def report_page(kind, facts, front, sections, **options):
        seen.update(facts)
        page = front, {section.id: section for section in sections}
        seen["page"] = page
        return ""

    monkeypatch.setattr(report, "report_page", report_page)
    report.study_report(item, summary, command="x")
    return seen


def test_figure_has_a_line_for_each_of_few_points(reported, monkeypatch):
    seen = page_of(runs(), reported, monkeypatch)
    words, unit, groups = seen["spread"]["motion.rms"]
    assert (words, unit, list(groups)) == ("Position, rms", "m", ["friction.F_C 1 N", "friction.F_C 2 N"])
    assert groups["friction.F_C 2 N"][:3].tolist() == [2e-3, 4e-3, 6e-3]
    front, sections = seen["page"]
    assert front[:2] == ("rig: a study", "8 of 10 runs · 5 draws (latin hypercube), seed 7 · 2 points of a grid")
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
    seen = page_of(runs(grid=grid), reported | {"worst": [], "failures": []}, monkeypatch)
    assert (list(seen["spread"]["motion.rms"][2]) == ["all runs"]) is together
    assert seen["page"][1]["worst"].blocks == [None, None]
    assert ("points of a grid" in seen["page"][0].facts) is (points > 0)


def test_first_screen_of_a_study_has_range_median_and_worst_run(reported, monkeypatch):
    front = page_of(runs(), reported, monkeypatch)["page"][0]
    entry = reported["metrics"]["motion.rms"]
    assert entry["median"] == pytest.approx(3.5e-3)
    assert front.title.replace("\u00a0", " ") == "Position, rms: 1.25 mm to 5.75 mm"
    values = {card.label: (card.value.replace("\u00a0", " "), card.half) for card in front.cards}
    assert values["Median"] == ("3.5 mm", None)
    assert values["95 % quantile"][0] == "5.75 mm"
    assert values["Failed runs"] == ("2", None)
    assert (front.next.text, front.next.command) == ("Complete the study:", "x")
    done = reported | {"runs": 8}
    assert page_of(runs(), done, monkeypatch)["page"][0].next.command == done["worst"][0]["command"]
    assert page_of(runs(), done | {"worst": []}, monkeypatch)["page"][0].next.text == "Repeat with other spreads:"
