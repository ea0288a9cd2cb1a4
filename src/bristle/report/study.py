"""The report of a study: distributions, influential causes and worst runs; and the report of a fleet, log by log."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core import DEVIATION_OVER_MEDIAN, NORMAL_95, number, scale_of, with_unit
from bristle.report.page import Figures, Front, Section, report_page
from bristle.report.table import Quantity, Table, capital, interval_text
from bristle.study.store import OK, Runs

if TYPE_CHECKING:
    from bristle.figures.report_figure import ReportFigure

FAILURES_SHOWN = 20
WORST_SHOWN = 10


def study_summary(runs: Runs, *, command: str, provenance: Mapping[str, str], worst: Sequence[int] = ()) -> dict[str, Any]:
    """Return a study in numbers, in SI."""
    from bristle.study.influence import rank_correlations, sobol_indices, spread_of

    described, columns = runs.described, runs.columns
    status, reasons = columns["status"], columns["reason"]
    at = {int(run): place for place, run in enumerate(columns["run"])}
    failed = [place for place in range(runs.count) if status[place] != OK]
    # Runs of one draw at several points, and runs for Sobol indices, are not independent.
    independent = not described["grid"] and not described["sobol_indices"]
    names, counts = np.unique(status, return_counts=True)
    points = [({"at": point, "name": _named(point, runs)}, chosen) for point, chosen in _points_of_grid(runs)]
    metrics = {
        name: {key: described["columns"][name][key] for key in ("unit", "description")}
        | spread_of(columns[name], independent=independent)
        | ({"points": [point | spread_of(columns[name][chosen]) for point, chosen in points]} if described["grid"] else {})
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
    return ", ".join(f"{key} {value if isinstance(value, str) else with_unit(value, units[key] or '1')}" for key, value in point.items())


def _points_of_grid(runs: Runs) -> list[tuple[dict[str, Any], np.ndarray]]:
    """Return each point of the grid, with a mask of its runs."""
    grid = runs.described["grid"]
    points = list(product(*grid.values()))
    place = runs.columns["run"].astype(int) % len(points)
    return [(dict(zip(grid, point, strict=True)), place == number) for number, point in enumerate(points)]


def study_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return the results of a study in sentences."""
    failed = summary["done"] - summary["statuses"].get(OK, 0)
    lines = []
    if summary["done"] < summary["runs"]:
        lines.append(f"{summary['done']} of {summary['runs']} runs are complete: repeat the same command to continue.")
    if failed:
        kinds = ", ".join(f"{count} {name}" for name, count in summary["statuses"].items() if name != OK)
        lines.append(f"{failed} of {summary['done']} runs failed: {kinds}.")
    for name, entry in summary["metrics"].items():
        if entry["count"]:
            low, median, high = (with_unit(entry[key], entry["unit"]) for key in ("low", "median", "high"))
            lines.append(f"{capital(entry['description'])}: median {median}, 90 % of the runs from {low} to {high}.")
            lines += _strongest(name, summary)
    return lines


def _strongest(metric: str, summary: Mapping[str, Any]) -> list[str]:
    """Return the drawn cause with the strongest correlation to a metric."""
    at = {key for entry in summary["metrics"][metric].get("points", ()) for key in entry["at"]}
    entries = [entry for entry in summary["rank_correlations"] if entry["metric"] == metric and entry["cause"] not in at]
    if not entries:
        return []
    first = max(entries, key=lambda entry: abs(entry["value"]))
    if first["interval"][0] <= 0.0 <= first["interval"][1]:
        return ["These runs show no correlation of this number with any drawn cause."]
    way = "rises" if first["value"] > 0.0 else "falls"
    return [f"This number {way} most with {first['cause']} (rank correlation {_signed(first['value'])})."]


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def spread_tables(summary: Mapping[str, Any]) -> list[Table]:
    """Return the distribution of each metric as a table, with a row for each point of the grid."""
    heads, tables = (
        (
            "At",
            "Runs",
            "Mean",
            "95 % interval of the mean",
            "Std",
            "5 % quantile",
            "Median",
            "95 % quantile",
            "95 % interval of the quantile",
        ),
        [],
    )
    for name, entry in summary["metrics"].items():
        points = entry.get("points", ())
        column = Quantity.of(entry["unit"], [])
        if entry["count"]:
            # In one unit in all rows, to two digits of its least deviation.
            scale = scale_of(entry["unit"], max(abs(entry[key]) for key in ("mean", "low", "high")))
            widths = [row["std"] for row in (entry, *points) if row["std"] > 0.0]
            column = Quantity(scale, min(widths, default=0.1 * abs(entry["mean"])) * scale.factor)
        rows = [
            ("all" if "points" in entry else "", *_cells(entry, column)),
            *((point["name"], *_cells(point, column)) for point in points),
        ]
        unit = f" in {column.scale.unit}" if column.scale.unit else ""
        tables.append(Table(f"{capital(entry['description'])}{unit} ({name})", heads, rows).without_empty_columns())
    return tables


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


def study_report(runs: Runs, summary: Mapping[str, Any], *, command: str, figures: Sequence[ReportFigure] = ()) -> str:
    """Return the report of a study as an HTML page."""
    described, metric = runs.described, next(iter(summary["metrics"]))
    failures = [(str(entry["run"]), entry["status"], entry["reason"]) for entry in summary["failures"]]
    failed = Table(f"Failed runs (at most the first {FAILURES_SHOWN})", ("Run", "Status", "Reason"), failures) if failures else None
    worst: Table | None = None
    if summary["worst"]:
        unit, shown = summary["metrics"][metric]["unit"], summary["worst"]
        again = [(str(entry["run"]), with_unit(entry[metric], unit), entry["command"]) for entry in shown]
        worst = Table(f"The worst runs: those with the largest {metric}", ("Run", metric, "Command to repeat it"), again)
    columns = [(name, about["role"], about["unit"] or "–") for name, about in described["columns"].items()]
    sections = [
        Section("", "", study_sentences(summary)),
        Section("spread", "Distributions", [Figures("spread"), *spread_tables(summary)]),
        Section("influence", "Influence of each cause", _influence_tables(summary)),
        Section("worst", "The worst runs", [worst, failed]),
        Section("files", "The files", [Table("Columns of the files in runs/", ("Column", "Role", "Unit"), columns)]),
    ]
    entries, points = {name: entry for name, entry in summary["metrics"].items() if entry["count"]}, _points_of_grid(runs)
    together = not described["grid"] or len(points) > 5
    spread = {
        name: (
            capital(entry["description"]),
            entry["unit"],
            {"all runs": runs.columns[name]} if together else {_named(point, runs): runs.columns[name][at] for point, at in points},
        )
        for name, entry in entries.items()
    }
    drawn = f"{described['draws']} draws ({described['sampling'].replace('_', ' ')}), seed {described['seed']}"
    beside = f" · {len(points)} points of a grid" if described["grid"] else ""
    front = Front(f"{summary['name']}: a study", f"{summary['done']} of {summary['runs']} runs · {drawn}{beside}")
    options = {"command": command, "provenance": summary["provenance"], "figures": figures}
    return report_page("study", {"study": runs, "spread": spread or None}, front, sections, **options)


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
        {"Metric": name, "Cause": entry["cause"], "Rank correlation": _signed(entry["value"]), "95 % interval": _range(entry["interval"])}
        for name in summary["metrics"]
        for entry in strongest_first
        if entry["metric"] == name
    ]
    tables = {"Sobol indices: shares of the variance": shares, "Rank correlation of each cause with each metric": ranks}
    return [Table.of(caption, rows) for caption, rows in tables.items() if rows]


def _range(ends: Sequence[float]) -> str:
    return f"{_signed(ends[0])} to {_signed(ends[1])}"


LOGS_SHOWN = 200
APART = 3.5  # robust standard deviations, including the interval of the log


def fleet_summary(runs: Runs, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a fleet in numbers, in SI."""
    described, columns = runs.described, runs.columns
    names, counts = np.unique(columns["status"], return_counts=True)
    failed = np.flatnonzero(columns["status"] != OK)
    errors = columns["held_out_error"]
    return {
        "name": described["name"],
        "kind": described["kind"],
        "model": described["model"],
        "logs": described["runs"],
        "done": runs.count,
        "statuses": dict(zip(names.tolist(), counts.tolist(), strict=True)),
        "failures": [
            _log(columns, place) | {"status": str(columns["status"][place]), "reason": str(columns["reason"][place])}
            for place in failed.tolist()
        ],
        "parameters": {name: _spread(columns, name, described["columns"][name]) for name in described["metrics"]},
        "held_out_error": {"median": _of_finite(np.median, errors), "largest": _of_finite(np.max, errors)},
        "warnings": dict(Counter(code for codes in columns["diagnostics"].tolist() for code in codes.split(", ") if code).most_common()),
        "provenance": dict(provenance),
    }


def _log(columns: Mapping[str, np.ndarray], place: int) -> dict[str, Any]:
    return {name: columns[name][place].item() for name in ("run", "folder", "log")}


def _of_finite(statistic: Callable[[np.ndarray], float], values: np.ndarray) -> float | None:
    finite = values[np.isfinite(values)]
    return float(statistic(finite)) if finite.size else None


def identified(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the mask of logs that identify a parameter, shape (log,)."""
    return np.isfinite(columns[name]) & (columns[f"{name}.status"] == "identified")


def _spread(columns: Mapping[str, np.ndarray], name: str, about: Mapping[str, str]) -> dict[str, Any]:
    tells = identified(columns, name)
    values = columns[name][tells]
    low, median, high = np.quantile(values, (0.05, 0.5, 0.95)).tolist() if values.size else (None, None, None)
    half = 0.5 * (columns[f"{name}.upper"] - columns[f"{name}.lower"])[tells]
    return {
        "unit": about["unit"],
        "description": about["description"],
        "count": int(tells.sum()),
        "low": low,
        "median": median,
        "high": high,
        "half_width": _of_finite(np.median, half),
        "apart": [_log(columns, place) | {"value": float(columns[name][place])} for place in apart(columns, name).tolist()],
    }


def apart(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the logs that are outliers in a parameter, the farthest first.

    Their distance from the median is more than `APART` robust standard deviations, from the median absolute deviation of
    all logs and the interval of the log (Iglewicz and Hoaglin 1993).
    """
    tells = np.flatnonzero(identified(columns, name))
    # Fewer logs have no outliers.
    if tells.size < 5:
        return tells[:0]
    values = columns[name][tells]
    std = np.nan_to_num((columns[f"{name}.upper"] - columns[f"{name}.lower"])[tells]) / (2.0 * NORMAL_95)
    distance = np.abs(values - np.median(values))
    allowed = APART * np.hypot(DEVIATION_OVER_MEDIAN * float(np.median(distance)), std)
    far = np.flatnonzero(distance > allowed)
    return tells[far[np.argsort(-(distance[far] / np.maximum(allowed[far], np.finfo(float).tiny)))]]


def fleet_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return the results of a fleet in sentences."""
    lines = []
    if summary["done"] < summary["logs"]:
        lines.append(f"{summary['done']} of {summary['logs']} logs are complete: repeat the same command to continue.")
    failed = len(summary["failures"])
    good = summary["done"] - failed
    lines.append(f"{good} of {summary['done']} logs were fitted" + (f", {failed} failed." if failed else "."))
    warned = {name: count for name, count in summary["warnings"].items() if count}
    if warned:
        words = ", ".join(f"{name} in {count} {'log' if count == 1 else 'logs'}" for name, count in warned.items())
        lines.append(f"Warnings of the fits: {words}.")
    error = summary["held_out_error"]
    if error["median"] is not None:
        lines.append(f"Held-out error: median {100.0 * error['median']:.3g} %, largest {100.0 * error['largest']:.3g} %.")
    counts_apart = Counter((entry["folder"], name) for name, about in summary["parameters"].items() for entry in about["apart"])
    if counts_apart:
        words = ", ".join(f"{count} from {folder} in {name}" for (folder, name), count in counts_apart.most_common())
        lines.append(f"Outliers among the logs: {words}.")
    return lines


def parameters_table(summary: Mapping[str, Any]) -> Table:
    """Return the distribution of each parameter over the logs."""
    rows = []
    for name, entry in summary["parameters"].items():
        if not entry["count"]:
            rows.append((name, "0", *[""] * 5))
            continue
        column = Quantity.of(entry["unit"], [entry["median"]])
        cells = [column.cell(entry[key]) if entry[key] is not None else "" for key in ("low", "median", "high", "half_width")]
        rows.append((name, str(entry["count"]), column.scale.unit, *cells))
    heads = ("Parameter", "Identified in logs", "Unit", "5 % quantile", "Median", "95 %", "Median half-width")
    return Table("The parameters over the logs", heads, rows).without_empty_columns()


def failed_logs_table(summary: Mapping[str, Any]) -> Table | None:
    """Return the logs that failed, with their reason."""
    rows = [(entry["folder"], entry["log"], entry["reason"]) for entry in summary["failures"][:FAILURES_SHOWN]]
    if not rows:
        return None
    caption = "Logs that failed" + (f" (the first {len(rows)})" if len(summary["failures"]) > len(rows) else "")
    return Table(caption, ("Folder", "Log", "Reason"), rows)


def fleet_report(runs: Runs, summary: Mapping[str, Any], *, command: str) -> str:
    """Return the report of a fleet as an HTML page."""
    names = [name for name, entry in summary["parameters"].items() if entry["count"]][:12]
    rows = [
        (name, entry["folder"], entry["log"], *(with_unit(value, about["unit"] or "1") for value in (entry["value"], about["median"])))
        for name, about in summary["parameters"].items()
        for entry in about["apart"][:WORST_SHOWN]
    ]
    heads = ("Parameter", "Folder", "Log", "This log", "Median of all logs")
    logs_apart = Table("Outliers among the logs", heads, rows) if rows else None
    sections = [
        Section("", "", fleet_sentences(summary)),
        Section("parameters", "The parameters", [Figures("parameters"), parameters_table(summary)]),
        Section("apart", "Logs to check", [failed_logs_table(summary), logs_apart]),
        Section("logs", "Every log", [_logs_table(runs, summary, names)]),
    ]
    facts = {"fleet": runs, "names": names or None, "apart": {name: apart(runs.columns, name) for name in names}}
    about = f"{summary['done']} of {summary['logs']} logs · {summary['model']} · {summary['kind']}"
    front = Front(f"{summary['name']}: a fleet", about)
    return report_page("fleet", facts, front, sections, command=command, provenance=summary["provenance"])


def _logs_table(runs: Runs, summary: Mapping[str, Any], names: Sequence[str]) -> Table:
    """Return each log with these parameters, their half-widths, and the codes of its warnings."""
    columns = runs.columns
    scales = {name: Quantity.of(summary["parameters"][name]["unit"], [summary["parameters"][name]["median"]]) for name in names}
    heads = ("Number", "Folder", "Log", "Held-out error", *(scales[name].head(name) for name in names), "Warnings")
    rows = []
    for place in range(min(runs.count, LOGS_SHOWN)):
        run, folder, log, codes = (str(columns[name][place]) for name in ("run", "folder", "log", "diagnostics"))
        error = columns["held_out_error"][place]
        cells = []
        for name, scale in scales.items():
            half = 0.5 * (columns[f"{name}.upper"][place] - columns[f"{name}.lower"][place])
            text = scale.cell(float(columns[name][place])) + (f" ± {scale.cell(float(half))}" if np.isfinite(half) else "")
            cells.append(text if identified(columns, name)[place] else "")
        rows.append((run, folder, log, f"{number(100.0 * error, 0.1)} %" if np.isfinite(error) else "", *cells, codes))
    more = f" (the first {LOGS_SHOWN}; the folder runs/ has all)" if runs.count > LOGS_SHOWN else ""
    return Table(f"The logs{more}", heads, rows).without_empty_columns()
