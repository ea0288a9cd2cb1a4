"""The page on its use that an FMU carries: what it is, its variables with units and ranges, how it is stepped."""

from __future__ import annotations

import math

from bristle.exports.described import Source
from bristle.exports.fmu_content import Content
from bristle.exports.fmu_description import FLAGS
from bristle.exports.fmu_variables import CONSTANT, INPUT, MARGIN, OUTPUT, PARAMETER, RATE, START, STATE, TIME, Port
from bristle.exports.identity import LICENCE, copyright_line, model_version
from bristle.exports.rendering import rendered, version

__all__ = ["page_text"]

ROLES = {
    INPUT: "input",
    OUTPUT: "output",
    START: "output, set before the start",
    PARAMETER: "parameter",
    CONSTANT: "constant",
    STATE: "state",
    RATE: "rate of a state",
    MARGIN: "event indicator",
}


def page_text(content: Content, name: str, source: Source, step: float, fmi: int) -> str:
    """Return the page as HTML."""
    rows = [_row(port, content) for port in content.ports.listed if port.role != TIME]
    of_model = [row for row in rows if row["role"] in (ROLES[PARAMETER], ROLES[CONSTANT])]
    return rendered(
        "fmu/index.html",
        {
            "name": name,
            "title": content.title,
            "version": version(),
            "model_version": model_version(source),
            "hash": source.model_hash,
            "licence": LICENCE,
            "copyright": copyright_line(),
            "remarks": source.remarks,
            "provenance": source.provenance,
            "signals": [row for row in rows if row not in of_model],
            "parameters": of_model,
            "guidance": content.guidance,
            "notes": content.notes,
            "step": f"{step:g}",
            "fmi": fmi,
            "flags": FLAGS,
            "exchange": content.exchange is not None,
            "tuned": bool(content.ports.tuned),
        },
    )


def _row(port: Port, content: Content) -> dict[str, str]:
    variable, unit = port.variable, port.variable.unit(content.kind)
    bounded = math.isfinite(variable.min) or math.isfinite(variable.max)
    return {
        "name": port.name,
        "role": ROLES[port.role],
        "unit": "" if unit == "1" else unit,
        "start": f"{port.value:.9g}",
        "allowed": variable.allowed(content.kind) if bounded else "",
        "sure": port.sure,
        "description": variable.description,
    }
