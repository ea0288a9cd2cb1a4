"""The report of a study: distributions, influential causes and worst runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.apps.study.store import OK, Runs
from bristle.core import number, scale_of, with_unit
from bristle.report.cards import Card, Step
from bristle.report.page import Figures, Front, Section, report_page
from bristle.report.table import Quantity, Table, capital, interval_text

if TYPE_CHECKING:
    from bristle.report.figures.report_figure import ReportFigure

STATISTICS = {
    "mean": "Mean",
    "mean_interval": "95 % interval of the mean",
    "std": "Std",
    "low": "5 % quantile",
    "median": "Median",
    "high": "95 % quantile",
    "high_interval": "95 % interval of the quantile",
}
FAILURES_SHOWN = 20
WORST_SHOWN = 10


def study_summary(
    runs: Runs, *, command: str, provenance: Mapping[str, str], worst: Sequence[int] = ()
) -> dict[str, Any]:
    """Return a study in numbers, in SI."""
    from bristle.apps.study.influence import rank_correlations, sobol_indices, spread_of

    described = runs.described
    columns = runs.columns
    status = columns["status"]
    reasons = columns["reason"]
    at = {int(run): place for place, run in enumerate(columns["run"])}
    failed = [place for place in range(runs.count) if status[place] != OK]
    # Runs of one draw at several points, and runs for Sobol indices, are not independent.
    independent = not described["grid"] and not described["sobol_indices"]
    names, counts = np.unique(status, return_counts=True)
    points = [
        ({"at": point, "name": _named(point, runs)}, chosen)
        for point, chosen in _points_of_grid(runs)
    ]
    metrics = {
        name: {key: described["columns"][name][key] for key in ("unit", "description")}
        | spread_of(columns[name], independent=independent)
        for name in described["metrics"]
    }
    if described["grid"]:
        for name, entry in metrics.items():
            entry["points"] = [point | spread_of(columns[name][chosen]) for point, chosen in points]
    return {name: described[name] for name in ("name", "kind", "runs")} | {
        "done": runs.count,
        "statuses": dict(zip(names.tolist(), counts.tolist(), strict=True)),
        "failures": [
            {
                "run": int(columns["run"][place]),
                "status": str(status[place]),
                "reason": str(reasons[place]),
            }
            for place in failed[:FAILURES_SHOWN]
        ],
        "metrics": metrics,
        "rank_correlations": rank_correlations(runs),
        "sobol_indices": sobol_indices(runs),
        "worst": [
            {
                "run": run,
                described["metrics"][0]: float(columns[described["metrics"][0]][at[run]]),
                "command": f"{command} --run {run} --out run_{run}",
            }
            for run in worst
            if run in at
        ],
        "provenance": dict(provenance),
    }


def _named(point: Mapping[str, Any], runs: Runs) -> str:
    """Return a point of the grid as text."""
    units = {key: runs.described["columns"][key]["unit"] for key in point}
    return ", ".join(
        f"{key} {value if isinstance(value, str) else with_unit(value, units[key] or '1')}"
        for key, value in point.items()
    )


def _points_of_grid(runs: Runs) -> list[tuple[dict[str, Any], np.ndarray]]:
    """Return each point of the grid, with a mask of its runs."""
    grid = runs.described["grid"]
    points = list(product(*grid.values()))
    place = runs.columns["run"].astype(int) % len(points)
    return [
        (dict(zip(grid, point, strict=True)), place == number)
        for number, point in enumerate(points)
    ]


def study_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return the results of a study in sentences."""
    failed = summary["done"] - summary["statuses"].get(OK, 0)
    lines = []
    if summary["done"] < summary["runs"]:
        lines.append(
            f"{summary['done']} of {summary['runs']} runs are complete: repeat the same command to continue."
        )
    if failed:
        kinds = ", ".join(
            f"{count} {name}" for name, count in summary["statuses"].items() if name != OK
        )
        lines.append(f"{failed} of {summary['done']} runs failed: {kinds}.")
    for name, entry in summary["metrics"].items():
        if entry["count"]:
            low, median, high = (
                with_unit(entry[key], entry["unit"]) for key in ("low", "median", "high")
            )
            lines.append(
                f"{capital(entry['description'])}: median {median}, 90 % of the runs from {low} to {high}."
            )
            lines += _strongest(name, summary)
    return lines


def _strongest(metric: str, summary: Mapping[str, Any]) -> list[str]:
    """Return the drawn cause with the strongest correlation to a metric."""
    at = {key for entry in summary["metrics"][metric].get("points", ()) for key in entry["at"]}
    entries = [
        entry
        for entry in summary["rank_correlations"]
        if entry["metric"] == metric and entry["cause"] not in at
    ]
    if not entries:
        return []
    first = max(entries, key=lambda entry: abs(entry["value"]))
    if first["interval"][0] <= 0.0 <= first["interval"][1]:
        return ["These runs show no correlation of this number with any drawn cause."]
    way = "falls"
    if first["value"] > 0.0:
        way = "rises"
    return [
        f"This number {way} most with {first['cause']} (rank correlation {_signed(first['value'])})."
    ]


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def spread_tables(summary: Mapping[str, Any]) -> list[Table]:
    """Return the distribution of each metric as a table, with a row for each point of the grid."""
    heads = ("At", "Runs", *STATISTICS.values())
    tables = []
    for name, entry in summary["metrics"].items():
        points = entry.get("points", ())
        column = Quantity.of(entry["unit"], [])
        if entry["count"]:
            # In one unit in all rows, to two digits of its least deviation.
            scale = scale_of(entry["unit"], max(abs(entry[key]) for key in ("mean", "low", "high")))
            widths = [row["std"] for row in (entry, *points) if row["std"] > 0.0]
            column = Quantity(scale, min(widths, default=0.1 * abs(entry["mean"])) * scale.factor)
        named = {"": entry}
        if "points" in entry:
            named = {"all": entry} | {point["name"]: point for point in points}
        rows = [
            (name, str(row["count"]), *(_cell(row, key, column) for key in STATISTICS))
            for name, row in named.items()
        ]
        unit = ""
        if column.scale.unit:
            unit = f" in {column.scale.unit}"
        tables.append(
            Table(
                f"{capital(entry['description'])}{unit} ({name})", heads, rows
            ).without_empty_columns()
        )
    return tables


def _cell(entry: Mapping[str, Any], key: str, column: Quantity) -> str:
    """Return a statistic as text, with "?" for an unknown end of an interval; empty if it is unknown."""
    if not entry["count"]:
        return ""
    ends = np.atleast_1d(entry[key]).tolist()
    if key.endswith(("std", "interval")) and not any(map(np.isfinite, ends)):
        return ""
    if len(ends) == 1:
        return column.cell(ends[0])
    return interval_text(*(column.cell(end) if np.isfinite(end) else "?" for end in ends))


def study_report(
    runs: Runs, summary: Mapping[str, Any], *, command: str, figures: Sequence[ReportFigure] = ()
) -> str:
    """Return the report of a study as an HTML page."""
    described = runs.described
    metric = next(iter(summary["metrics"]))
    worst_and_failed = []
    if summary["worst"]:
        unit = summary["metrics"][metric]["unit"]
        again = [
            (str(entry["run"]), with_unit(entry[metric], unit), entry["command"])
            for entry in summary["worst"]
        ]
        worst_and_failed.append(
            Table(
                f"The worst runs: those with the largest {metric}",
                ("Run", metric, "Command to repeat it"),
                again,
            )
        )
    if summary["failures"]:
        failures = [
            (str(entry["run"]), entry["status"], entry["reason"]) for entry in summary["failures"]
        ]
        worst_and_failed.append(
            Table(
                f"Failed runs (at most the first {FAILURES_SHOWN})",
                ("Run", "Status", "Reason"),
                failures,
            )
        )
    columns = [
        (name, about["role"], about["unit"] or "–") for name, about in described["columns"].items()
    ]
    sections = [
        Section("results", "Results", study_sentences(summary)),
        Section("spread", "Distributions", [Figures("spread"), *spread_tables(summary)]),
        Section("influence", "Influence of each cause", _influence_tables(summary), "Influence"),
        Section("worst", "The worst runs", worst_and_failed, "Worst"),
        Section(
            "files",
            "The files",
            [Table("Columns of the files in runs/", ("Column", "Role", "Unit"), columns)],
            "Files",
        ),
    ]
    spread = {
        name: (capital(entry["description"]), entry["unit"], _by_point(runs, name))
        for name, entry in summary["metrics"].items()
        if entry["count"]
    }
    drawn = f"{described['draws']} draws ({described['sampling'].replace('_', ' ')}), seed {described['seed']}"
    if described["grid"]:
        drawn += f" · {len(_points_of_grid(runs))} points of a grid"
    heading = f"{summary['name']}: a study"
    about = f"{summary['done']} of {summary['runs']} runs · {drawn}"
    influence = [entry for entry in summary["rank_correlations"] if entry["metric"] == metric]
    title, cards = _title_and_cards(summary, metric, influence)
    step = Step("Repeat with other spreads:", command)
    if summary["done"] < summary["runs"]:
        step = Step("Complete the study:", command)
    elif summary["worst"]:
        step = Step("Look at the worst run:", summary["worst"][0]["command"])
    front = Front(heading, about, title=title, basis="(90 % of the runs)", cards=cards, next=step)
    facts = {
        "study": runs,
        "spread": spread or None,
        "first_spread": spread.get(metric),
        "influence": influence or None,
    }
    options = {"command": command, "provenance": summary["provenance"], "figures": figures}
    return report_page("study", facts, front, sections, **options)


def _by_point(runs: Runs, metric: str) -> dict[str, np.ndarray]:
    """Return a metric at each point of a small grid; of all runs together without a grid or with a large one."""
    points = _points_of_grid(runs)
    if not runs.described["grid"] or len(points) > 5:
        return {"all runs": runs.columns[metric]}
    return {_named(point, runs): runs.columns[metric][at] for point, at in points}


def _title_and_cards(
    summary: Mapping[str, Any], metric: str, causes: Sequence[Mapping[str, Any]]
) -> tuple[str, list[Card]]:
    """Return the range of the first number over the runs, with its median, 95 % quantile and strongest cause."""
    entry = summary["metrics"][metric]
    failed = summary["done"] - summary["statuses"].get(OK, 0)
    failures = Card("Failed runs", str(failed), f"of {summary['done']}")
    if not entry["count"]:
        return "No run completed", [failures]
    low, median, high = (
        with_unit(entry[key], entry["unit"]).replace(" ", "\u00a0")
        for key in ("low", "median", "high")
    )
    ends = entry["high_interval"]
    half = None
    if all(map(np.isfinite, ends)) and entry["high"]:
        half = 100.0 * 0.5 * (ends[1] - ends[0]) / abs(entry["high"])
    cards = [Card("Median", median), Card("95 % quantile", high, "", half), failures]
    if causes:
        first = max(causes, key=lambda influence: abs(influence["value"]))
        cards.append(
            Card("Strongest cause", first["cause"], f"correlation {_signed(first['value'])}")
        )
    return (
        f"{capital(entry['description']).replace('root mean square', 'rms')}: {low} to {high}",
        cards,
    )


def _influence_tables(summary: Mapping[str, Any]) -> list[Table]:
    """Return the tables of Sobol indices and rank correlations."""
    shares = [
        {
            "Metric": entry["metric"],
            "Cause": entry["cause"],
            "Alone": number(entry["first"], 0.01),
            "95 % interval": _range(entry["first_interval"]),
            "With interactions": number(entry["total"], 0.01),
            "95 % interval with interactions": _range(entry["total_interval"]),
        }
        for entry in summary["sobol_indices"]
    ]
    strongest_first = sorted(summary["rank_correlations"], key=lambda entry: -abs(entry["value"]))
    ranks = [
        {
            "Metric": name,
            "Cause": entry["cause"],
            "Rank correlation": _signed(entry["value"]),
            "95 % interval": _range(entry["interval"]),
        }
        for name in summary["metrics"]
        for entry in strongest_first
        if entry["metric"] == name
    ]
    tables = {
        "Sobol indices: shares of the variance": shares,
        "Rank correlation of each cause with each metric": ranks,
    }
    return [Table.of(caption, rows) for caption, rows in tables.items() if rows]


def _range(ends: Sequence[float]) -> str:
    return f"{_signed(ends[0])} to {_signed(ends[1])}"
