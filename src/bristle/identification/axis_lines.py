"""Lines for the axis file: gravity, a spring, offset, cogging."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from operator import itemgetter

from bristle.core.axis import Axis, Cogging
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.variable import KINDS, unit_of
from bristle.identification.result import Fit, ProposedLine, SecondPass
from bristle.logs.log import Log

Pairs = list[tuple[Log, Axis | None]]


def proposed_lines(fit: Fit, axis: Axis) -> tuple[ProposedLine, ...]:
    """Return the lines that the diagnostics of a fit propose; a key that the axis states is not proposed."""
    lines: list[ProposedLine] = []
    for diagnostic in fit.diagnostics:
        if diagnostic.code == "weight_guessed" and axis.offset == "identify":
            weight = float(f"{diagnostic.numbers['weight']:.5g}")
            lines.append(ProposedLine("plant", "offset", weight, diagnostic.code))
    return tuple(lines)


def axis_with(axis: Axis, lines: Sequence[ProposedLine]) -> Axis:
    """Return an axis with proposed lines, also in the text of its file."""
    values, changed = {line.key: line.value for line in lines}, axis
    if "travel" in values:
        # As the reader of a file with this lead computes it.
        turn = math.tau * (values["travel"] / math.tau)
        lead = values["travel"] if axis.pitch is None and axis.kind == KINDS[0] else axis.pitch
        changed = replace(
            changed,
            cogging=(Cogging(values["turner"], turn, tuple(values["harmonics"])),),
            pitch=lead,
        )
    text = axis.text.decode("utf-8", "surrogateescape")
    for table, key, value in reversed(_written(lines, axis)) if text else ():
        head = re.search(rf"^{re.escape(table)}.*\n", text, re.MULTILINE)
        text, place = (
            (text, head.end()) if head else (f"{text}\n{table}\n", len(text) + len(table) + 2)
        )
        text = f"{text[:place]}{key} = {value}\n{text[place:]}"
    facts = {
        "offset": values.get("offset", axis.offset),
        "gravity": axis.gravity or "gravity" in values,
    }
    facts["spring"] = values.get("spring", axis.spring)
    return replace(changed, text=text.encode("utf-8", "surrogateescape"), **facts)


def _written(lines: Sequence[ProposedLine], axis: Axis) -> list[tuple[str, str, str]]:
    """Return lines as in an axis file: table, key and value."""
    written = {
        "offset": lambda value: ("[plant]", "offset", f'"{value!r} {unit_of("force", axis.kind)}"'),
        "gravity": lambda value: ("[plant]", "gravity", f'"{value}"'),
        "spring": lambda value: ("[plant]", "spring", f'"{value}"'),
        "turner": lambda value: ("[[cogging]]", "turn", f'"{value}"'),
        "harmonics": lambda value: ("[[cogging]]", "harmonics", str(list(value))),
        "travel": lambda value: ("[transmission]", "lead", f'"{value!r} m"'),
    }
    has_lead = any(line.value == "screw" for line in lines)
    return [written[line.key](line.value) for line in lines if line.key != "travel" or not has_lead]


def with_lines(pairs: Pairs, second: SecondPass) -> Pairs:
    """Return logs with axes that have the found lines."""
    return [(log, axis_with(axis or Axis(kind=log.kind), second.lines)) for log, axis in pairs]


def about_lines(second: SecondPass, axis: Axis) -> Diagnostic:
    """Return the note about the lines that bristle took into the axis."""
    tables = groupby(_written(second.lines, axis), itemgetter(0))
    texts = (
        f"{' and '.join(f'`{key} = {value}`' for _, key, value in keys)} under `{table}`"
        for table, keys in tables
    )
    numbers: dict[str, Number] = {line.key: line.value for line in second.lines}
    numbers |= {
        "before": second.error_without,
        "percent": second.error_with,
        "taken": int(second.taken),
        "lines": tuple(texts),
    }
    return Diagnostic("second_pass", "", "note", numbers, axis.kind)
