"""The report of a study: how its numbers are distributed, which cause matters, and which runs are worst."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.typography import interval_text, number, scale_of, with_unit
from bristle.report.page import Figures, Front, Section, report_page
from bristle.report.table import Quantity, Table
from bristle.study.dataset import OK

if TYPE_CHECKING:
    from bristle.figures.report_figure import ReportFigure
    from bristle.study.dataset import Runs

__all__ = ["spread_tables", "study_report", "study_sentences", "study_summary"]

FAILURES_SHOWN = 20
GROUPS_DRAWN = 5
WORST_SHOWN = 10


def study_summary(
    runs: Runs, *, command: str, provenance: Mapping[str, str], worst: Sequence[int] = (), traces: Sequence[str] = ()
) -> dict[str, Any]:
    """Return a study in numbers, in SI."""
    from bristle.study.influence import rank_correlations, sobol_indices, spread_of

    described, columns = runs.described, runs.columns
    status, reasons = columns["status"], columns["reason"]
    at = {int(run): place for place, run in enumerate(columns["run"])}
    failed = [place for place in range(runs.count) if status[place] != OK]
    # Runs of one draw at several points are not independent, nor are those that Sobol indices need.
    independent = not described["grid"] and not described["sobol_indices"]
    names, counts = np.unique(status, return_counts=True)
    points = [({"at": point, "name": _named(point, runs)}, chosen) for point, chosen in _points_of_grid(runs)]
    metrics = {
        name: {key: described["columns"][name][key] for key in ("unit", "description")}
        | asdict(spread_of(columns[name], independent=independent))
        | ({"points": [point | asdict(spread_of(columns[name][chosen])) for point, chosen in points]} if described["grid"] else {})
        for name in described["metrics"]
    }
    return {
        "name": described["name"],
        "kind": described["kind"],
        "runs": described["runs"],
        "done": runs.count,
        "statuses": dict(zip(names.tolist(), counts.tolist(), strict=True)),
        "failures": [
            {"run": int(columns["run"][place]), "status": str(status[place]), "reason": str(reasons[place])}
            for place in failed[:FAILURES_SHOWN]
        ],
        "metrics": metrics,
        "rank_correlations": [asdict(entry) for entry in rank_correlations(runs)],
        "sobol_indices": [asdict(entry) for entry in sobol_indices(runs)],
        "worst": [
            {
                "run": run,
                described["metrics"][0]: float(columns[described["metrics"][0]][at[run]]),
                "command": f"{command} --run {run} --out run_{run}",
            }
            for run in worst
            if run in at
        ],
        "traces": list(traces),
        "provenance": dict(provenance),
    }


def _named(point: Mapping[str, Any], runs: Runs) -> str:
    """Return a point of the grid as a person says it."""
    units = {key: runs.described["columns"][key]["unit"] for key in point}
    return ", ".join(f"{key} {value if isinstance(value, str) else with_unit(value, units[key] or '1')}" for key, value in point.items())


def _points_of_grid(runs: Runs) -> list[tuple[dict[str, Any], np.ndarray]]:
    """Return each point of the grid, with which runs are made there."""
    grid = runs.described["grid"]
    points = list(product(*grid.values()))
    place = runs.columns["run"].astype(int) % len(points)
    return [(dict(zip(grid, point, strict=True)), place == number) for number, point in enumerate(points)]


def study_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return what a study comes to, in sentences."""
    failed = summary["done"] - summary["statuses"].get(OK, 0)
    lines = []
    if summary["done"] < summary["runs"]:
        lines.append(f"{summary['done']} of {summary['runs']} runs are there: the same command goes on.")
    if failed:
        kinds = ", ".join(f"{count} {name}" for name, count in summary["statuses"].items() if name != OK)
        lines.append(f"{failed} of {summary['done']} runs did not end well: {kinds}.")
    for name, entry in summary["metrics"].items():
        if entry["count"]:
            low, median, high = (with_unit(entry[key], entry["unit"]) for key in ("low", "median", "high"))
            lines.append(f"{_capital(entry['description'])}: median {median}, 90 % of the runs from {low} to {high}.")
            lines += _strongest(name, summary)
    return lines


def _strongest(metric: str, summary: Mapping[str, Any]) -> list[str]:
    at = {key for entry in summary["metrics"][metric].get("points", ()) for key in entry["at"]}
    entries = [entry for entry in summary["rank_correlations"] if entry["metric"] == metric]
    entries = [entry for entry in entries if entry["cause"] not in at]
    if not entries:
        return []
    first = max(entries, key=lambda entry: abs(entry["value"]))
    low, high = first["interval"]
    if low <= 0.0 <= high:
        return ["It goes with nothing that was drawn, as far as these runs tell."]
    way = "rises" if first["value"] > 0.0 else "falls"
    return [f"Of what was drawn it {way} most with {first['cause']} (rank correlation {_signed(first['value'])})."]


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def spread_tables(summary: Mapping[str, Any]) -> list[Table]:
    """Return how each metric is distributed, a table for each, with a row for each point of the grid."""
    return [_spread_table(name, entry) for name, entry in summary["metrics"].items()]


def _spread_table(name: str, entry: Mapping[str, Any]) -> Table:
    column = _column_of(entry)
    rows = [("all" if "points" in entry else "", *_cells(entry, column))]
    rows += [(point["name"], *_cells(point, column)) for point in entry.get("points", ())]
    heads = ("At", "Runs", "Mean", "its 95 % interval", "Std", "5 %", "Median", "95 %", "its 95 % interval")
    unit = f" in {column.scale.unit}" if column.scale.unit else ""
    return Table(f"{_capital(entry['description'])}{unit} ({name})", heads, rows).without_empty_columns()


def _column_of(entry: Mapping[str, Any]) -> Quantity:
    """Return in which unit a metric is told in all rows, and to which step: two digits of its least deviation."""
    if not entry["count"]:
        return Quantity.of(entry["unit"], [])
    scale = scale_of(entry["unit"], max(abs(entry[key]) for key in ("mean", "low", "high")))
    widths = [row["std"] for row in (entry, *entry.get("points", ())) if row["std"] > 0.0]
    return Quantity(scale, min(widths, default=0.1 * abs(entry["mean"])) * scale.factor)


def _cells(entry: Mapping[str, Any], column: Quantity) -> tuple[str, ...]:
    if not entry["count"]:
        return ("0", *[""] * 7)

    def interval(ends: Sequence[float]) -> str:
        if not any(map(np.isfinite, ends)):
            return ""
        low, high = (column.cell(end) if np.isfinite(end) else "?" for end in ends)
        return interval_text(low, high)

    return (
        str(entry["count"]),
        column.cell(entry["mean"]),
        interval(entry["mean_interval"]),
        column.cell(entry["std"]) if np.isfinite(entry["std"]) else "",
        column.cell(entry["low"]),
        column.cell(entry["median"]),
        column.cell(entry["high"]),
        interval(entry["high_interval"]),
    )


def _worst_table(summary: Mapping[str, Any]) -> Table | None:
    """Return the worst runs with what repeats them."""
    if not summary["worst"]:
        return None
    metric = next(iter(summary["metrics"]))
    unit = summary["metrics"][metric]["unit"]
    rows = [(str(entry["run"]), with_unit(entry[metric], unit), entry["command"]) for entry in summary["worst"][:WORST_SHOWN]]
    return Table(f"The worst runs: those with the largest {metric}", ("Run", metric, "Again, with its signals"), rows)


def study_report(runs: Runs, summary: Mapping[str, Any], *, command: str, figures: Sequence[ReportFigure] = ()) -> str:
    """Return the report of a study as one HTML page."""
    failures = [(str(entry["run"]), entry["status"], entry["reason"]) for entry in summary["failures"]]
    failed = Table("Runs that did not end well (the first of them)", ("Run", "Status", "Reason"), failures) if failures else None
    tables = [_index_table(summary), _influence_table(summary)]
    columns = [(name, about["role"], about["unit"] or "–") for name, about in runs.described["columns"].items()]
    sections = [
        Section("", "", study_sentences(summary)),
        Section("spread", "What comes out", [Figures("spread"), *spread_tables(summary)]),
        Section("influence", "Which cause matters", [Figures("influence"), *tables] if any(tables) else []),
        Section("worst", "The worst runs", [_worst_table(summary), failed]),
        Section("files", "The files", [Table("Columns of the files in runs/", ("Column", "Role", "Unit"), columns)], folded=True),
    ]
    entries = {name: entry for name, entry in summary["metrics"].items() if entry["count"]}
    spread = {name: (_capital(entry["description"]), entry["unit"], _groups(runs, name)) for name, entry in entries.items()}
    facts = {"study": runs, "spread": spread or None, "influence": _influence(summary, next(iter(entries))) if entries else None}
    front = Front(f"{summary['name']}: a study", _facts(summary, runs.described))
    options = {"command": command, "provenance": summary["provenance"], "figures": figures}
    return report_page("study", facts, front, sections, **options)


def _facts(summary: Mapping[str, Any], described: Mapping[str, Any]) -> str:
    drawn = f"{described['draws']} draws ({described['sampling'].replace('_', ' ')}), seed {described['seed']}"
    points = int(np.prod([len(values) for values in described["grid"].values()], dtype=int))
    beside = f" · {points} points of a grid" if described["grid"] else ""
    return f"{summary['done']} of {summary['runs']} runs · {drawn}{beside}"


def _influence_table(summary: Mapping[str, Any]) -> Table | None:
    entries = sorted(summary["rank_correlations"], key=lambda entry: -abs(entry["value"]))
    rows = [
        (entry["metric"], entry["cause"], _signed(entry["value"]), _range(entry["interval"]))
        for name in summary["metrics"]
        for entry in entries
        if entry["metric"] == name
    ]
    heads = ("Metric", "Cause", "Rank correlation", "95 % interval")
    return Table("How strongly each cause goes with each metric", heads, rows) if rows else None


def _range(ends: Sequence[float]) -> str:
    return f"{_signed(ends[0])} to {_signed(ends[1])}"


def _index_table(summary: Mapping[str, Any]) -> Table | None:
    rows = [
        (
            entry["metric"],
            entry["cause"],
            number(entry["first"], 0.01),
            _range(entry["first_interval"]),
            number(entry["total"], 0.01),
            _range(entry["total_interval"]),
        )
        for entry in summary["sobol_indices"]
    ]
    heads = ("Metric", "Cause", "Alone", "95 % interval", "With others", "its 95 % interval")
    return Table("Sobol indices: shares of the variance", heads, rows) if rows else None


def _groups(runs: Runs, name: str) -> dict[str, np.ndarray]:
    points = _points_of_grid(runs)
    if not runs.described["grid"] or len(points) > GROUPS_DRAWN:
        return {"all runs": runs.columns[name]}
    return {_named(point, runs): runs.columns[name][chosen] for point, chosen in points}


def _influence(summary: Mapping[str, Any], metric: str) -> tuple[list[str], dict[str, list[Any]], str] | None:
    """Return the causes, the numbers of each and what these are, of a metric; Sobol indices where there are some."""
    indices = sorted((entry for entry in summary["sobol_indices"] if entry["metric"] == metric), key=lambda entry: -entry["total"])
    ranks = [entry for entry in summary["rank_correlations"] if entry["metric"] == metric]
    if indices:
        names = {"alone": "first", "with others": "total"}
        bars = {word: [(entry[key], entry[f"{key}_interval"]) for entry in indices] for word, key in names.items()}
        return [entry["cause"] for entry in indices], bars, f"Share of the variance of {metric}"
    ranks.sort(key=lambda entry: -abs(entry["value"]))
    bars = {"rank correlation": [(entry["value"], entry["interval"]) for entry in ranks]}
    return ([entry["cause"] for entry in ranks], bars, f"Rank correlation with {metric}") if ranks else None
