"""What goes into a folder of results: the numbers, the report, the logs of a simulation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from bristle.core.axis import Axis
from bristle.files.motion import write_log
from bristle.files.results import SUMMARY, Results
from bristle.files.summary import as_json

if TYPE_CHECKING:
    from bristle.simulation import SimulationResult

REPORT = "report.html"


class ResultsFolder(Protocol):
    """What takes the files of results: a folder that appears whole, or another that is added to."""

    def write(self, name: str, content: str | bytes, /) -> object:
        """Write a file by its name in the folder, text in UTF-8."""
        ...


def write_report(folder: ResultsFolder, report: str, summary: Mapping[str, Any]) -> None:
    """Write a report and the numbers that it rests on into a folder of results."""
    folder.write(REPORT, report)
    folder.write(SUMMARY, as_json(summary))


def log_names(variants: Sequence[str]) -> dict[str, str]:
    """Return the name of the log of each variant, by variant: ``log.csv`` of one alone.

    Where names of variants make no names of files, too long or alike without case, they are numbered.
    """
    if len(variants) == 1:
        return {variants[0]: "log.csv"}
    labels = [re.sub(r"[^\w.-]", "_", name) for name in variants]
    # Some systems tell no capital letters from small ones.
    # File systems take names of 255 bytes.
    if len({label.casefold() for label in labels}) < len(labels) or max(len(label.encode()) for label in labels) > 200:
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
