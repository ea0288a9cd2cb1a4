"""What goes into a folder of results: the model file, the numbers, the report, the table for the drive."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from bristle.core.axis import Axis
from bristle.files.model import write_model
from bristle.files.motion import gcode_of, moves_table, write_log, write_motion
from bristle.files.results import SUMMARY, Results
from bristle.files.summary import as_json
from bristle.files.user_model import codes_of
from bristle.report.messages import note_of, sentence_of
from bristle.report.model_tables import as_csv

if TYPE_CHECKING:
    from bristle.core.content import Content
    from bristle.excitation import Excitation
    from bristle.identification.result import Fit, Identification
    from bristle.simulation import SimulationResult

__all__ = ["REPORT", "ResultsFolder", "log_names", "write_identification", "write_logs", "write_motion_folder", "write_report"]

REPORT = "report.html"
LONGEST = 200  # bytes: file systems take 255


class ResultsFolder(Protocol):
    """What takes the files of results: a folder that appears whole, or another that is added to."""

    def write(self, name: str, content: str | bytes, /) -> object:
        """Write a file by its name in the folder, text in UTF-8."""
        ...


def write_report(folder: ResultsFolder, report: str, summary: Mapping[str, Any]) -> None:
    """Write a report and the numbers that it rests on into a folder of results."""
    folder.write(REPORT, report)
    folder.write(SUMMARY, as_json(summary))


def write_identification(
    folder: Results,
    identification: Identification,
    *,
    table: Sequence[tuple[float, float]],
    report: str,
    summary: Mapping[str, Any],
    provenance: Mapping[str, str],
) -> None:
    """Write an identification into a folder of results: ``model.toml``, ``drive_table.csv``, report and numbers."""
    best = identification.best
    for code in codes_of(best.friction.component):
        folder.write(code.source.name, code.data)
    write_model(
        folder / "model.toml",
        best.plant,
        best.friction,
        estimates=best.estimates,
        provenance=provenance,
        treatment=identification.treatment,
        bands=best.resampling.bands if best.resampling else None,
        notes={estimate.name: note_of(estimate) for estimate in best.estimates} | _of_presliding(best),
    )
    if table:
        folder.write("drive_table.csv", as_csv(table, best.friction.kind) + "\n")
    write_report(folder, report, summary)


def _of_presliding(fit: Fit) -> dict[str, str]:
    """Return by name of a parameter that it was told by a log that never slides; nothing where the log does."""
    sticking = next((diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "never_slides"), None)
    names = sticking.numbers.get("names", ()) if sticking is not None else ()
    explained = {estimate.name for estimate in fit.estimates if estimate.reason is not None}
    means = sentence_of("never_slides").means
    return {str(name): means for name in names if name not in explained} if isinstance(names, tuple) else {}


def write_motion_folder(folder: Results, excitation: Excitation, *, axis_file: Content, report: str, summary: Mapping[str, Any]) -> None:
    """Write a motion into a folder of results: ``motion.csv``, the axis file that its log is read with, and both."""
    from bristle.excitation.motion import moves_of

    motion = excitation.motion
    signals = {name: getattr(motion, name) for name in ("time", "position", "velocity", "acceleration")}
    write_motion(folder / summary["files"]["motion"], excitation.axis, signals)
    moves, left_out = moves_of(motion)
    folder.write(summary["files"]["moves"], moves_table(moves, excitation.axis))
    folder.write(summary["files"]["program"], gcode_of(moves, excitation.axis, left_out))
    folder.write(summary["files"]["axis"], axis_file.data)
    write_report(folder, report, summary)


def log_names(variants: Sequence[str]) -> dict[str, str]:
    """Return the name of the log of each variant, by variant: ``log.csv`` of one alone.

    Where names of variants make no names of files, too long or alike without case, they are numbered.
    """
    if len(variants) == 1:
        return {variants[0]: "log.csv"}
    labels = [re.sub(r"[^\w.-]", "_", name) for name in variants]
    # Some systems tell no capital letters from small ones.
    if len({label.casefold() for label in labels}) < len(labels) or max(len(label.encode()) for label in labels) > LONGEST:
        labels = [str(number) for number in range(1, len(labels) + 1)]
    return {name: f"log_{label}.csv" for name, label in zip(variants, labels, strict=True)}


def write_logs(folder: Results, result: SimulationResult) -> dict[str, str]:
    """Write what the drive of each variant would record; return the files by variant.

    The position is what the encoder reads, the effort what the controller commands, both at the instant of a sample.
    """
    names = log_names(tuple(result.variants))
    for variant in result.experiment.variants:
        if variant.name not in names:
            continue
        outcome = result.variants[variant.name]
        signals = {"time": outcome.time, "position": outcome.measured, "effort": outcome.command} | (
            {} if outcome.is_open else {"reference": outcome.reference}
        )
        write_log(folder / names[variant.name], variant.axis or Axis(kind=variant.plant.kind), signals)
    return names
