"""Columns, units and signs as a log speaks of them, or as a person changed them, shown on its data."""

from __future__ import annotations

from typing import Any

import numpy as np

from bristle.core.errors import InputError
from bristle.files.components import FILL_IN
from bristle.report.log import Inspected, inspect_log
from bristle.server.axis_form import CHANNELS, EMPTY, edited, form_of
from bristle.server.errand import Answer, Errand, thinned

PLOTTED = ("position", "velocity", "reference", "effort")


def look(errand: Errand) -> Answer:
    """Return the axis file of the first log, proposed where there is none, and the data as it reads them."""
    content = errand.fitted[0].content
    errand.report(0.1, "reading the log")
    text, proposed = errand.options.get("text") or errand.axis_text, None
    if not text:
        proposed = inspect_log(content, size_limit=errand.size_limit)
        text = proposed.proposal.text if proposed.proposal else f"{EMPTY}\n[columns]\n"
    text = edited(text, errand.options.get("edits") or {}, errand.axis_label)
    errand = Errand(**{**vars(errand), "axis_text": text})
    axis, refusal = None, ""
    try:
        axis = errand.axis()
    except InputError as error:  # why its file does not serve yet
        refusal = str(error)
    if axis is not None or proposed is None:
        inspected = inspect_log(content, axis, size_limit=errand.size_limit)
    else:
        inspected = proposed
    form = form_of(errand.axis_file)
    if axis is not None and inspected.log:  # channels in SI of the axis
        plots = [
            {
                "word": name,
                "unit": channel.unit,
                "column": channel.column,
                "curve": thinned(inspected.log.time.values, channel.values),
                "time_unit": "s",
            }
            for name, channel in inspected.log.channels()
            if name in PLOTTED
        ]
    else:
        plots = _of_columns(inspected, form["tables"]["columns"])
    problems = inspected.summary["problems"] if axis is not None else []
    data = {
        "log": errand.fitted[0].label,
        "form": form,
        "channels": CHANNELS,
        "refusal": refusal,
        "columns": inspected.summary["columns"],
        "notes": inspected.summary["notes"],
        "problems": problems,
        "diagnostics": inspected.summary["diagnostics"] if axis is not None else [],
        "kind": inspected.summary["kind"],
        "plots": plots,
    }
    facts = {"axis_text": text, "missing": form["missing"], "ready": axis is not None and not problems}
    return facts, data


def _of_columns(inspected: Inspected, columns: dict[str, Any]) -> list[dict[str, Any]]:
    """Return columns as they are recorded, as long as the axis file does not say what they are."""
    plots, recorded = [], inspected.table.columns
    time = recorded.get(columns.get("time", {}).get("column"))
    for name in PLOTTED:
        entry = columns.get(name, {})
        values = recorded.get(entry.get("column"))
        if values is None or not values.size:
            continue
        timed = time is not None and time.size == values.size
        along = np.arange(values.size) if time is None or not timed else time
        unit = entry.get("unit", "")
        plots.append(
            {
                "word": name,
                "unit": "as recorded" if unit in ("", FILL_IN) else unit,
                "column": entry["column"],
                "curve": thinned(along, values),
                "time_unit": columns["time"].get("unit", "") if timed else "sample",
            }
        )
    return plots
