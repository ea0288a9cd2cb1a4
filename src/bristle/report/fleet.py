"""The report of a fleet: what each log says of each parameter, which logs stand apart, and which failed."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from bristle.core.normal import DEVIATION_OVER_MEDIAN, NORMAL_95
from bristle.core.typography import number, with_unit
from bristle.report.page import Figures, Front, Section, report_page
from bristle.report.study import FAILURES_SHOWN, WORST_SHOWN
from bristle.report.table import Quantity, Table
from bristle.study.dataset import OK, Runs

LOGS_SHOWN = 200
APART = 3.5  # robust standard deviations, its own interval counted in


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
    """Return which logs tell a parameter, shape (log,)."""
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
    """Return which logs stand apart from the others in a parameter, the farthest first.

    Their distance from the median is more than `APART` times what the median absolute deviation of all logs and their
    own interval allow (Iglewicz and Hoaglin 1993).
    """
    tells = np.flatnonzero(identified(columns, name))
    # Of fewer logs no log stands apart.
    if tells.size < 5:
        return tells[:0]
    values = columns[name][tells]
    std = np.nan_to_num((columns[f"{name}.upper"] - columns[f"{name}.lower"])[tells]) / (2.0 * NORMAL_95)
    distance = np.abs(values - np.median(values))
    allowed = APART * np.hypot(DEVIATION_OVER_MEDIAN * float(np.median(distance)), std)
    far = np.flatnonzero(distance > allowed)
    return tells[far[np.argsort(-(distance[far] / np.maximum(allowed[far], np.finfo(float).tiny)))]]


def fleet_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return what a fleet comes to, in sentences."""
    lines = []
    if summary["done"] < summary["logs"]:
        lines.append(f"{summary['done']} of {summary['logs']} logs are there: the same command goes on.")
    failed = len(summary["failures"])
    good = summary["done"] - failed
    lines.append(f"{good} of {summary['done']} logs were fitted" + (f", {failed} failed." if failed else "."))
    warned = {name: count for name, count in summary["warnings"].items() if count}
    if warned:
        words = ", ".join(f"{name} in {count}" for name, count in warned.items())
        lines.append(f"Fits with warnings: {words}.")
    error = summary["held_out_error"]
    if error["median"] is not None:
        lines.append(f"Error on what was held out: median {100.0 * error['median']:.3g} %, largest {100.0 * error['largest']:.3g} %.")
    counts_apart = Counter((entry["folder"], name) for name, about in summary["parameters"].items() for entry in about["apart"])
    if counts_apart:
        words = ", ".join(f"{count} of {folder} in {name}" for (folder, name), count in counts_apart.most_common())
        lines.append(f"Logs that stand apart from the others: {words}.")
    return lines


def parameters_table(summary: Mapping[str, Any]) -> Table:
    """Return how each parameter is distributed over the logs."""
    rows = []
    for name, entry in summary["parameters"].items():
        if not entry["count"]:
            rows.append((name, "0", *[""] * 5))
            continue
        column = Quantity.of(entry["unit"], [entry["median"]])
        cells = [column.cell(entry[key]) if entry[key] is not None else "" for key in ("low", "median", "high", "half_width")]
        rows.append((name, str(entry["count"]), column.scale.unit, *cells))
    heads = ("Parameter", "Logs that tell it", "Unit", "5 %", "Median", "95 %", "± of one log")
    return Table("The parameters over the logs", heads, rows).without_empty_columns()


def failed_logs_table(summary: Mapping[str, Any]) -> Table | None:
    """Return the logs that failed, with their reason."""
    rows = [(entry["folder"], entry["log"], entry["reason"]) for entry in summary["failures"][:FAILURES_SHOWN]]
    if not rows:
        return None
    caption = "Logs that failed" + (" (the first of them)" if len(summary["failures"]) > len(rows) else "")
    return Table(caption, ("Folder", "Log", "Reason"), rows)


def fleet_report(runs: Runs, summary: Mapping[str, Any], *, command: str) -> str:
    """Return the report of a fleet as one HTML page."""
    names = [name for name, entry in summary["parameters"].items() if entry["count"]][:12]
    rows = [
        (name, entry["folder"], entry["log"], *(with_unit(value, about["unit"] or "1") for value in (entry["value"], about["median"])))
        for name, about in summary["parameters"].items()
        for entry in about["apart"][:WORST_SHOWN]
    ]
    heads = ("Parameter", "Folder", "Log", "Here", "Median of all")
    logs_apart = Table("Logs that stand apart from the others", heads, rows) if rows else None
    sections = [
        Section("", "", fleet_sentences(summary)),
        Section("parameters", "The parameters", [Figures("parameters"), parameters_table(summary)]),
        Section("apart", "Logs to look at", [failed_logs_table(summary), logs_apart]),
        Section("logs", "Every log", [_logs_table(runs, summary, names)], folded=True),
    ]
    facts = {"fleet": runs, "names": names or None, "apart": {name: apart(runs.columns, name) for name in names}}
    about = f"{summary['done']} of {summary['logs']} logs · {summary['model']} · {summary['kind']}"
    front = Front(f"{summary['name']}: a fleet", about)
    return report_page("fleet", facts, front, sections, command=command, provenance=summary["provenance"])


def _logs_table(runs: Runs, summary: Mapping[str, Any], names: Sequence[str]) -> Table:
    """Return each log with these parameters, half of their intervals, and the codes of its warnings."""
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
    more = f" (the first {LOGS_SHOWN}; all are in runs/)" if runs.count > LOGS_SHOWN else ""
    return Table(f"The logs{more}", heads, rows).without_empty_columns()
