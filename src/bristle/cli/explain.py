"""``bristle explain``: the meaning of a warning, and advice."""

from typing import Annotated

import typer

from bristle.cli.options import Json, print_json
from bristle.cli.terminal import show_lines, show_table
from bristle.core.former import successor

EXAMPLE = """Example:
  bristle explain one_direction"""


def explain(
    code: Annotated[
        str | None,
        typer.Argument(
            metavar="[CODE]", help="The code in brackets behind a warning; all codes by default."
        ),
    ] = None,
    *,
    as_json: Json = False,
) -> None:
    """Explain a warning: its meaning, and advice."""
    from bristle.core import InputError, did_you_mean
    from bristle.report.brief import Line
    from bristle.report.messages import fields_of
    from bristle.report.sentences import SENTENCES
    from bristle.report.table import Table, capital

    if code is not None and code not in SENTENCES:
        mend = (
            successor(f"explain {code}")
            or did_you_mean(code, SENTENCES)
            or "bristle explain lists all codes"
        )
        raise InputError("is not the code of a warning or note", path="CODE", value=code, mend=mend)
    entries = {name: sentence for name, sentence in SENTENCES.items() if code in (None, name)}
    if as_json:
        keys = {
            name: {"means": entry.means, "advice": entry.advice, "numbers": list(fields_of(name))}
            for name, entry in entries.items()
        }
        print_json({"codes": keys})
    elif code is None:
        show_table(
            Table(
                "Warnings and notes",
                ("Code", "Meaning"),
                [(name, entry.means) for name, entry in entries.items()],
            )
        )
    else:
        advice = entries[code].advice
        if advice == "nothing":
            advice = "no action needed"
        numbers = ", ".join(name for name in fields_of(code) if name != "std_percent")
        lines = [
            Line("Code", code),
            Line("Meaning", f"{capital(entries[code].means)}."),
            Line("Do", f"{capital(advice)}."),
        ]
        if numbers:
            lines.append(Line("Numbers", f"{numbers} (in the JSON)"))
        show_lines(lines)
