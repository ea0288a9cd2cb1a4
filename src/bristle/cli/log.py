"""``bristle log``: contents and problems of a log."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from bristle.cli.options import (
    LOG_FILE,
    AxisFile,
    Listing,
    Output,
    Readers,
    own_readers,
    print_json,
    refuse,
    size_limit,
    toml_content,
)
from bristle.cli.terminal import complain, exit_code, show


class _OfFormats(Listing):
    """Command whose help lists the log formats."""

    heads = ("Format", "Needs")

    @staticmethod
    def rows() -> list[tuple[str, str]]:
        """Return the formats, and the package that each one needs."""
        from bristle.logs import FORMATS

        rows = []
        for known in reversed(FORMATS):
            needs = "no extra package"
            if known.extra:
                needs = f'pip install "bristle[{known.extra}]"'
            rows.append((known.title, needs))
        return rows


COMMAND = _OfFormats
EXAMPLE = """Example:
  bristle log recording.csv --write axis.toml
  bristle log recording.csv --axis axis.toml --out inspected
  bristle log recording.csv --axis axis.toml --explain"""
MOST_COLUMNS = 100  # in the terminal


def log(
    file: Annotated[Path, typer.Argument(metavar="FILE", help=f"A log: {LOG_FILE}")],
    *,
    axis: AxisFile = None,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            metavar="AXIS.toml",
            help="Write the recognized columns and units as an axis file.",
        ),
    ] = None,
    explain: Annotated[
        bool,
        typer.Option(
            "--explain",
            help="Explain the effort: shares of friction, springs, cables, cogging and load, inertia and delay.",
        ),
    ] = False,
    output: Output,
    reader: Readers = None,
) -> int:
    """Show the contents and problems of a log.

    Lists the columns, channels, sample rates and ranges of the log, its kinds of motion, and every problem.
    Without an axis file, bristle recognizes the columns by their names, units and correlations. --write saves the
    recognized columns as AXIS.toml. Replace each "?" in AXIS.toml. If AXIS.toml already exists, bristle does not change
    this file, but reads the log with it. The exit code is 1 if the log has problems.

    --explain fits all forces at once and prints the share of each with its evidence. It needs position and effort in known units.

    Writes summary.json into DIR, and report.html if the log has no problems and all units are known.
    """
    from bristle.files import axes_in, provenance, read_axis, write_whole
    from bristle.report.explained import explanation_parts
    from bristle.report.log import inspect_log

    output.context.with_resource(own_readers(reader))
    if axis is None and write is not None and write.exists():
        axis = write
    described = toml_content(axis)
    joints = {}
    if described:
        joints = axes_in(described)
    if joints:
        refuse(
            {"--out": output.out, "--json": output.as_json, "--explain": explain},
            "describes one axis, but AXIS.toml describes several",
            "Omit it",
        )
        return max(
            _show_joint(name, inspect_log(file, joint, size_limit=size_limit()))
            for name, joint in joints.items()
        )
    with output.opened("reading", [file, axis]) as (folder, _):
        inspected = inspect_log(
            file,
            read_axis(described) if described else None,
            size_limit=size_limit(),
            with_explanation=explain,
        )
        summary = inspected.summary
        if folder:
            source = provenance(output.command, log=inspected.content, axis=described)
            replace(inspected, summary=summary | {"provenance": source}).write(
                folder, output.command
            )
    if output.out:
        wrote = f"wrote {output.out}"
        if inspected.log:
            wrote += f"; open {output.out / 'report.html'} in a browser"
        complain(wrote)
    proposal = inspected.proposal
    if write is not None and proposal is None:
        if write.exists():
            complain(f"{write} already exists: bristle used it and did not replace it")
        else:
            complain(f"bristle did not write {write}")
    elif write is not None and proposal is not None:
        write_whole(write, proposal.text, new=True)
        complain(f"wrote {write}")
        for key in proposal.missing:
            complain(f"fill in: {key}")
    if output.as_json:
        print_json(summary)
    else:
        if inspected.explanation is not None:
            show(*explanation_parts(inspected.explanation))
        show(*_parts(summary))
    for problem in summary["problems"]:
        complain(f"problem: {problem}")
    return exit_code(summary["problems"])


def _show_joint(name: str, inspected: Any) -> int:
    """Show the channels and problems of one joint, and return the exit code."""
    summary = inspected.summary | {"columns": []}
    show(f"Joint {name}", *_parts(summary)[1:])
    for problem in summary["problems"]:
        complain(f"problem of {name}: {problem}")
    return exit_code(summary["problems"])


def _parts(summary: dict[str, Any]) -> list[Any]:
    from bristle.report.log_tables import passage_table

    columns = summary["columns"]
    parts: list[Any] = [_table("Columns of the file", columns[:MOST_COLUMNS])]
    if len(columns) > MOST_COLUMNS:
        parts.append(
            f"... and {len(columns) - MOST_COLUMNS} more columns. --json lists all columns."
        )
    if "roles" in summary["proposal"]:
        parts += [_roles_table(summary["proposal"]["roles"])]
    if summary["channels"]:
        parts += [_table(f"Channels of the axis, {summary['kind']}", summary["channels"])]
    if summary["passages"]:
        parts += [passage_table(summary["passages"], summary["kind"])]
    if summary["rate"]:
        duration = ""
        if summary["duration"]:
            duration = f", {summary['duration']:.6g} s"
        parts.append(f"{summary['rate']:.6g} samples a second{duration}.")
    parts += [f"Note: {note}" for note in summary["notes"]]
    return parts + [
        f"{entry['severity'].capitalize()}: {entry['message']} ({entry['code']})"
        for entry in summary["diagnostics"]
    ]


def _roles_table(entries: list[dict[str, Any]]) -> Any:
    from bristle.report.table import Table

    rows = []
    for entry in entries:
        if entry["joint"]:
            role = f"{entry['role']} {entry['joint']}"
        else:
            role = entry["role"] or "open"
        step = "–"
        if entry["step"]:
            step = f"{entry['step']:.3g}"
        rows.append(
            [
                entry["column"],
                f"{entry['low']:.4g} to {entry['high']:.4g}",
                step,
                role,
                entry["evidence"],
            ]
        )
    return Table(
        "Proposed roles: accept them with --write AXIS.toml",
        ("Column", "Range", "Step", "Role", "Evidence"),
        rows,
    )


def _table(caption: str, entries: list[dict[str, Any]]) -> Any:
    from bristle.core import is_unit, typeset
    from bristle.report.table import Table

    units = [entry.get("unit") or "1" for entry in entries]
    printed = [typeset(unit) if is_unit(unit) else f"{unit} (unknown)" for unit in units]
    numbers = ("samples", "min", "max", "mean", "std", "step")
    rows = [
        [entry["name"], entry.get("column") or "", unit]
        + ["–" if entry[key] is None else f"{entry[key]:.6g}" for key in numbers]
        for entry, unit in zip(entries, printed, strict=True)
    ]
    return Table(caption, ("Name", "Column", "Unit", *(key.capitalize() for key in numbers)), rows)
