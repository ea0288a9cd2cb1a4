"""The report of a fleet: many logs, identified separately, with the logs that differ or that must be measured again."""

import shlex
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

from bristle.apps.arm.report import arm_front
from bristle.apps.study.report import FAILURES_SHOWN, WORST_SHOWN
from bristle.apps.study.store import OK, Runs
from bristle.core import DEVIATION_OVER_MEDIAN, NORMAL_95, number, with_unit
from bristle.report.cards import Card, Step, quantity_text
from bristle.report.compensation import names_text
from bristle.report.judgement import LEVELS
from bristle.report.page import Block, Figures, Front, Ruling, Section, report_page
from bristle.report.table import Quantity, Table, capital, percent_text
from bristle.simulation import Prediction

LOGS_SHOWN = 200
PARAMETERS_SHOWN = 12
BRIEF = 3  # parameters in a brief table
APART = 3.5  # robust standard deviations, including the interval of the log


def fleet_summary(runs: Runs, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a fleet in numbers, in SI."""
    described = runs.described
    columns = runs.columns
    names, counts = np.unique(columns["status"], return_counts=True)
    failed = np.flatnonzero(columns["status"] != OK)
    errors = columns["held_out_error"]
    parameters = described["metrics"]
    return {name: described[name] for name in ("name", "kind", "model")} | {
        "logs": described["runs"],
        "done": runs.count,
        "statuses": dict(zip(names.tolist(), counts.tolist(), strict=True)),
        "failures": [
            _log(columns, place)
            | {"status": str(columns["status"][place]), "reason": str(columns["reason"][place])}
            for place in failed.tolist()
        ],
        "again": [_log(columns, place) for place in measure_again(columns).tolist()],
        "verdict": fleet_ruling(runs).as_data(),
        "parameters": {
            name: _spread(
                columns, name, described["columns"][name], compared=not holds_several_axes(runs)
            )
            for name in parameters
        },
        "held_out_error": {
            "median": _of_finite(np.median, errors),
            "largest": _of_finite(np.max, errors),
        },
        "warnings": dict(
            Counter(
                code
                for codes in columns["diagnostics"].tolist()
                for code in codes.split(", ")
                if code
            ).most_common()
        ),
        "provenance": dict(provenance),
    }


def holds_several_axes(runs: Runs) -> bool:
    """Return whether one log contains all axes of a fleet; their parameters need not agree."""
    logs = runs.described.get("logs", ())
    return len(logs) > 1 and len({log["sha256"] for log in logs}) == 1


def _log(columns: Mapping[str, np.ndarray], place: int) -> dict[str, Any]:
    return {name: columns[name][place].item() for name in ("run", "folder", "log")}


def _of_finite(statistic: Callable[[np.ndarray], float], values: np.ndarray) -> float | None:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return None
    return float(statistic(finite))


def identified(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the mask of logs that identify a parameter, without those to measure again, shape (log,)."""
    mask = np.isfinite(columns[name]) & (columns[f"{name}.status"] == "identified")
    mask[measure_again(columns)] = False
    return mask


def measure_again(columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the logs with the verdict to measure again."""
    return np.flatnonzero(
        columns.get("verdict", np.full(len(columns["run"]), "")) == "measure_again"
    )


def differing(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return the logs whose interval of a parameter overlaps the intervals of less than half of the other logs."""
    tells = np.flatnonzero(identified(columns, name))
    low, high = (columns[f"{name}.{end}"][tells] for end in ("lower", "upper"))
    # An unknown end excludes no value.
    low = np.where(np.isfinite(low), low, -np.inf)
    high = np.where(np.isfinite(high), high, np.inf)
    overlaps = (low[:, None] <= high[None, :]) & (low[None, :] <= high[:, None])
    return tells[2 * (overlaps.sum(axis=1) - 1) < tells.size - 1]


def short_names(columns: Mapping[str, np.ndarray]) -> list[str]:
    """Return a short name of each log: its file or its folder, whichever distinguishes all logs, or both."""
    files, folders = (
        [PurePath(str(text)).stem for text in columns[key]] for key in ("log", "folder")
    )
    if len(set(files)) == len(files):
        return files
    if len(set(folders)) == len(folders):
        return folders
    return [f"{folder}/{file}" for folder, file in zip(folders, files, strict=True)]


def fleet_ruling(runs: Runs) -> Ruling:
    """Return whether the logs of a fleet agree, with the parameters that differ and the logs to measure again."""
    columns = runs.columns
    of_one = holds_several_axes(runs)
    if of_one:
        names = _axes_in(columns)
        compared = ()
    else:
        names = short_names(columns)
        compared = runs.described["metrics"]
    again, failed = (
        [names[place] for place in places]
        for places in (measure_again(columns), np.flatnonzero(columns["status"] != OK))
    )
    apart_in = {name: [names[place] for place in differing(columns, name)] for name in compared}
    reasons = [
        f"{name.rpartition('.')[2]} of {names_text(logs)} differs"
        for name, logs in apart_in.items()
        if logs
    ]
    if reasons:
        words = "Logs differ"
    elif again or failed:
        words = "Check some logs"
    elif compared:
        words = "Logs agree"
    else:
        words = "Axes identified"
    if of_one and "verdict" in columns:
        care = [names[place] for place in np.flatnonzero(columns["verdict"] == "with_care")]
        if care:
            reasons.append(f"use with care: {names_text(care)}")
    if again:
        reasons.append(f"measure again: {names_text(again)}")
    if failed:
        reasons.append(f"not fitted: {names_text(failed)}")
    if not any(identified(columns, name).any() for name in runs.described["metrics"]):
        return Ruling("measure_again", "Measure again", ("no log identifies a parameter", *reasons))
    if reasons:
        return Ruling("with_care", words, tuple(reasons))
    return Ruling("usable", words, ())


def _spread(
    columns: Mapping[str, np.ndarray], name: str, about: Mapping[str, str], *, compared: bool
) -> dict[str, Any]:
    tells = identified(columns, name)
    values = columns[name][tells]
    low = median = high = None
    if values.size:
        low, median, high = np.quantile(values, (0.05, 0.5, 0.95)).tolist()
    outliers = []
    if compared:
        outliers = [
            _log(columns, place) | {"value": float(columns[name][place])}
            for place in apart(columns, name).tolist()
        ]
    half = 0.5 * (columns[f"{name}.upper"] - columns[f"{name}.lower"])[tells]
    return {
        "unit": about["unit"],
        "description": about["description"],
        "count": int(tells.sum()),
        "low": low,
        "median": median,
        "high": high,
        "half_width": _of_finite(np.median, half),
        "apart": outliers,
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
    std = np.nan_to_num((columns[f"{name}.upper"] - columns[f"{name}.lower"])[tells]) / (
        2.0 * NORMAL_95
    )
    distance = np.abs(values - np.median(values))
    allowed = APART * np.hypot(DEVIATION_OVER_MEDIAN * float(np.median(distance)), std)
    far = np.flatnonzero(distance > allowed)
    return tells[far[np.argsort(-(distance[far] / np.maximum(allowed[far], np.finfo(float).tiny)))]]


def fleet_sentences(summary: Mapping[str, Any], word: str = "logs") -> list[str]:
    """Return the results of a fleet in sentences; the `word` of its members may be ``"axes"`` of one log."""
    lines = []
    if summary["done"] < summary["logs"]:
        lines.append(
            f"{summary['done']} of {summary['logs']} {word} are complete: repeat the same command to continue."
        )
    failed = len(summary["failures"])
    again = len(summary["again"])
    counts = f"{summary['done'] - failed - again} of {summary['done']} {word} were identified"
    if failed:
        counts += f", {failed} failed"
    if again:
        counts += f", {again} to measure again"
    lines.append(f"{counts}.")
    warned = {name: count for name, count in summary["warnings"].items() if count}
    if warned:
        one = "log"
        if word == "axes":
            one = "axis"
        words = ", ".join(
            f"{name} in {count} {one if count == 1 else word}" for name, count in warned.items()
        )
        lines.append(f"Warnings of the fits: {words}.")
    error = summary["held_out_error"]
    if error["median"] is not None:
        lines.append(
            f"Held-out error: median {100.0 * error['median']:.3g} %, largest {100.0 * error['largest']:.3g} %."
        )
    counts_apart = Counter(
        (entry["folder"], name)
        for name, about in summary["parameters"].items()
        for entry in about["apart"]
    )
    if counts_apart:
        words = ", ".join(
            f"{count} from {folder} in {name}"
            for (folder, name), count in counts_apart.most_common()
        )
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
        cells = [
            column.cell(entry[key]) if entry[key] is not None else ""
            for key in ("low", "median", "high", "half_width")
        ]
        rows.append((name, str(entry["count"]), column.scale.unit, *cells))
    heads = (
        "Parameter",
        "Identified in logs",
        "Unit",
        "5 % quantile",
        "Median",
        "95 %",
        "Median half-width",
    )
    return Table("The parameters over the logs", heads, rows).without_empty_columns()


def failed_logs_table(summary: Mapping[str, Any]) -> Table | None:
    """Return the logs that failed, with their reason."""
    rows = [
        (entry["folder"], entry["log"], entry["reason"])
        for entry in summary["failures"][:FAILURES_SHOWN]
    ]
    if not rows:
        return None
    caption = "Logs that failed"
    if len(summary["failures"]) > len(rows):
        caption += f" (the first {len(rows)})"
    return Table(caption, ("Folder", "Log", "Reason"), rows)


def fleet_report(
    runs: Runs,
    summary: Mapping[str, Any],
    *,
    command: str,
    further: Sequence[Section] = (),
    joints: Mapping[str, Prediction] | None = None,
) -> str:
    """Return the report of a fleet as an HTML page, with further sections; `joints` are the predicted efforts of those of an arm."""
    names = [name for name, entry in summary["parameters"].items() if entry["count"]][
        :PARAMETERS_SHOWN
    ]
    rows = [
        (
            name,
            entry["folder"],
            entry["log"],
            *(
                with_unit(value, about["unit"] or "1")
                for value in (entry["value"], about["median"])
            ),
        )
        for name, about in summary["parameters"].items()
        for entry in about["apart"][:WORST_SHOWN]
    ]
    ruling = fleet_ruling(runs)
    columns = runs.columns
    word = "axes"
    # Axes of one log are not compared.
    differ = outliers = {name: np.zeros(0, dtype=int) for name in names}
    if not holds_several_axes(runs):
        word = "logs"
        differ = {name: differing(columns, name) for name in names}
        outliers = {name: apart(columns, name) for name in names}
    # First the parameters that differ between logs.
    ordered = sorted(names, key=lambda name: not differ[name].size)
    logs_apart = None
    if rows:
        heads = ("Parameter", "Folder", "Log", "This log", "Median of all logs")
        logs_apart = Table("Outliers among the logs", heads, rows)
    sections = [
        Section(
            "summary", "Summary", [Block("items", ruling.reasons), *fleet_sentences(summary, word)]
        ),
        Section(
            "parameters",
            "The parameters",
            [Figures("parameters"), parameters_table(summary)],
            "Parameters",
        ),
        Section("apart", "Logs to check", [failed_logs_table(summary), logs_apart], "Check"),
        Section("logs", "Every log", [logs_table(runs, summary)], "Logs"),
        *further,
    ]
    facts = {
        "fleet": runs,
        "names": ordered or None,
        "apart": {name: np.union1d(outliers[name], differ[name]).astype(int) for name in names},
        "labels": short_names(columns),
        "again": measure_again(columns),
        "joints": joints or None,
        "kind": summary["kind"],
    }
    front = Front(
        f"{summary['name']}: a fleet",
        f"{summary['done']} of {summary['logs']} {word} · {summary['model']} · {summary['kind']}",
        ruling,
        title=_title(summary, ruling, ordered),
        basis=f"({summary['model']})",
        cards=_cards(summary, ordered),
        next=_next(summary, command),
    )
    if joints is not None:
        errors = dict(zip(_axes_in(columns), columns["held_out_error"].tolist(), strict=True))
        front = arm_front(
            front,
            logs_table(runs, summary, brief=True),
            {name: error for name, error in errors.items() if np.isfinite(error)},
        )
    return report_page(
        "fleet", facts, front, sections, command=command, provenance=summary["provenance"]
    )


def _title(summary: Mapping[str, Any], ruling: Ruling, names: Sequence[str]) -> str:
    """Return the first difference between logs, else the range of the first parameter."""
    if ruling.words == "Logs differ" or not names:
        return capital(ruling.reasons[0])
    entry = summary["parameters"][names[0]]
    low, high = (
        with_unit(entry[key], entry["unit"] or "1").replace(" ", "\u00a0")
        for key in ("low", "high")
    )
    return f"{names[0].rpartition('.')[2]}: {low} to {high} over {entry['count']} logs"


def _cards(summary: Mapping[str, Any], names: Sequence[str]) -> list[Card]:
    """Return the number of identified logs, and the medians of the first parameters with the usual half-width of a log."""
    bad = len(summary["failures"]) + len(summary["again"])
    cards = [Card("Identified", f"{summary['done'] - bad} of {summary['done']}", "logs")]
    for name in names[:2]:
        entry = summary["parameters"][name]
        half = None
        if entry["half_width"] is not None and entry["median"]:
            half = 100.0 * entry["half_width"] / abs(entry["median"])
        cards.append(
            Card(
                name.rpartition(".")[2],
                quantity_text(entry["median"], half, entry["unit"] or "1"),
                "median",
                half,
            )
        )
    error = summary["held_out_error"]["largest"]
    if error is not None:
        cards.append(Card("Largest model error", percent_text(100.0 * error), "held out"))
    return cards


def _next(summary: Mapping[str, Any], command: str) -> Step:
    if summary["done"] < summary["logs"]:
        return Step("Complete the fleet:", command)
    suspects = [
        *summary["again"],
        *summary["failures"],
        *(entry for about in summary["parameters"].values() for entry in about["apart"]),
    ]
    if suspects:
        return Step(
            "Check the first log in doubt:",
            shlex.join(
                ["bristle", "log", suspects[0]["log"].rpartition(": ")[2], "--axis", "axis.toml"]
            ),
        )
    return Step("Add logs of further axes, or later logs, with the same command:", command)


def _axes_in(columns: Mapping[str, np.ndarray]) -> list[str]:
    """Return the name of each axis of a common log."""
    return [str(log).partition(": ")[0] for log in columns["log"]]


def logs_table(runs: Runs, summary: Mapping[str, Any], *, brief: bool = False) -> Table:
    """Return each log, or each axis of one log, with the first parameters and the codes of its warnings; in `brief` only its friction."""
    columns = runs.columns
    names = [name for name, entry in summary["parameters"].items() if entry["count"]][
        :PARAMETERS_SHOWN
    ]
    labels = names
    if brief:
        names = [name for name in names if name.rpartition(".")[2].startswith("F_")][:BRIEF]
        labels = [name.rpartition(".")[2] for name in names]
    scales = {
        name: Quantity.of(
            summary["parameters"][name]["unit"], [summary["parameters"][name]["median"]]
        )
        for name in names
    }
    of_one = holds_several_axes(runs)
    caption = "The logs"
    names_of: tuple[str, ...] = ("Number", "Folder", "Log")
    if of_one:
        caption = "The axes"
        names_of = ("Axis", "Verdict")
    if runs.count > LOGS_SHOWN:
        caption += f" (the first {LOGS_SHOWN}; the folder runs/ has all)"
    axes = _axes_in(columns)
    levels = [LEVELS.get(str(level), "") for level in columns.get("verdict", [""] * runs.count)]
    heads = (
        *names_of,
        "Held-out error",
        *(scales[name].head(label) for name, label in zip(names, labels, strict=True)),
        "Warnings",
    )
    rows = []
    for place in range(min(runs.count, LOGS_SHOWN)):
        *about, codes = (
            str(columns[name][place]) for name in ("run", "folder", "log", "diagnostics")
        )
        if of_one:
            about = [axes[place], levels[place]]
        if brief:
            codes = ""
        error = ""
        if np.isfinite(columns["held_out_error"][place]):
            error = f"{number(100.0 * columns['held_out_error'][place], 0.1)} %"
        rows.append(
            (
                *about,
                error,
                *(_parameter_cell(columns, name, place, scale) for name, scale in scales.items()),
                codes,
            )
        )
    return Table(caption, heads, rows).without_empty_columns()


def _parameter_cell(
    columns: Mapping[str, np.ndarray], name: str, place: int, scale: Quantity
) -> str:
    """Return a parameter of a log with its half-width; empty if the log does not identify it."""
    if not identified(columns, name)[place]:
        return ""
    text = scale.cell(float(columns[name][place]))
    half = 0.5 * (columns[f"{name}.upper"][place] - columns[f"{name}.lower"][place])
    if np.isfinite(half):
        text += f" ± {scale.cell(float(half))}"
    return text
