"""`known_truth`: what a log can and cannot determine, told parameter by parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from bristle.core import PROGRESS, Axis, Card, InputError, Progress, WithCard, guarded, number, whole, with_unit
from bristle.files import SUMMARY, axes_for, read_axis
from bristle.identification import Determined, determined_by
from bristle.logs import Log, read_log
from bristle.report.identified import Identified
from bristle.report.model_in_hand import load
from bristle.report.table import Table

NOTE = "The simulated axis is exactly as the model says: what the model does not explain of the recorded log comes on top of these errors."
KEYS = ("truth", "unit", "description", "relative_to", "median_error_percent", "spread_percent", "within_percent")
KEYS += ("identified", "intervals", "hold", "verdict")
VERDICTS = {
    "determined": ("determines {}", "determines no parameter"),
    "rough": ("determines {} roughly", ""),
    "not determined": ("does not determine {}", ""),
}


@dataclass(frozen=True, eq=False)
class KnownTruth(WithCard):
    """What simulated logs with known truth say of the log of an identification.

    Parameters
    ----------
    model : str
        Name of the friction model.
    parameters : dict of str to Determined
        Every parameter that was identified, by name.
    draws : int
        How many logs were simulated.
    """

    model: str
    parameters: Mapping[str, Determined]
    draws: int

    @property
    def sentence(self) -> str:
        """Which parameters the log determines."""
        parts = list[str]()
        for verdict, (some, none) in VERDICTS.items():
            names = [one.name for one in self.parameters.values() if one.verdict == verdict]
            parts += [some.format(" and ".join(filter(None, (", ".join(names[:-1]), names[-1]))))] if names else [none] if none else []
        return f"This log {'; '.join(parts)}."

    @property
    def table(self) -> Table:
        """The parameters: truth, errors, intervals, verdict."""
        rows = [
            {
                "Parameter": one.name,
                "True value": with_unit(one.truth, one.unit, digits=4),
                "Median error [%]": _percent(one.median_error_percent),
                "Spread [%]": _percent(one.spread_percent),
                "Intervals that hold": f"{one.hold} of {one.intervals}" if one.intervals else "–",
                "Verdict": _words(one),
            }
            for one in self.parameters.values()
        ]
        return Table.of(f"What this log can and cannot determine: {self.model}, {self.draws} simulated logs", rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, in SI of the axis, as ``bristle check --json`` prints them."""
        parameters = {name: {key: getattr(one, key) for key in KEYS} for name, one in self.parameters.items()}
        return {"model": self.model, "draws": self.draws, "sentence": self.sentence, "parameters": parameters}

    def _card(self) -> Card:
        table = self.table
        return Card(self.sentence, tuple(table.heads), tuple(map(tuple, table.rows)), (NOTE,))


def _percent(value: float | None) -> str:
    return "–" if value is None else number(value, digits=2)


def _words(one: Determined) -> str:
    """Return the verdict on a parameter in words."""
    of = f" of {one.relative_to}" if one.relative_to != one.name else ""
    within = f"within {_percent(one.within_percent)} %{of}{'; intervals too narrow' if one.too_narrow else ''}"
    if one.verdict != "not determined":
        return f"{one.verdict}{':' if one.verdict == 'rough' else ''} {within}"
    if one.truth == 0.0 and not of:
        return "not determined: the true value is 0"
    if one.within_percent is None or one.is_rare:
        return f"not determined: identified in {one.identified} of {one.logs} logs"
    return f"not determined: error up to {_percent(one.within_percent)} %{of}"


@guarded(draws=whole(3, 1000), progress=PROGRESS)
def known_truth(
    results: Identified | str | PathLike[str],
    log: Log | str | PathLike[str] | Sequence[Log | str | PathLike[str]] | None = None,
    *,
    draws: int = 10,
    allow_code: bool = False,
    progress: Progress | None = None,
) -> KnownTruth:
    """Simulate the identified axis along its log, identify it again, and compare with the known truth.

    Parameters
    ----------
    results : Identified or path-like
        What `identify` returned, or the folder that ``save`` or ``bristle identify --out`` wrote: its ``model.toml``
        holds the truth.
    log : path-like or Log, or list of these, optional
        The log of the identification, where it does not lie beside the folder or in the current folder.
    draws : int
        How many logs are simulated and identified.
    allow_code : bool
        Whether a model of a person's own, in a file beside the model file, may run without having been allowed before.
    progress : callable, optional
        Called with the share of the work done and what is being done.

    Returns
    -------
    KnownTruth
        Each parameter with its errors, its intervals and a verdict.

    Raises
    ------
    InputError
        If the folder holds no identification with intervals, or the log is not the one that was identified.
    """
    if isinstance(results, Identified):
        best, logs, axes = results.best, [results.log, *results.further_logs], list(results.axes)
        treatment, settings = results.treatment, results.settings.as_data()
    else:
        folder = Path(results)
        folder = folder.parent if folder.name == SUMMARY else folder
        if not (folder / SUMMARY).is_file():
            mend = "Name a folder that bristle identify --out wrote"
            raise InputError("is no folder of results", path=str(folder), allowed=f"a folder with {SUMMARY}", mend=mend)
        loaded = load(folder, allow_code=allow_code)
        best, treatment, settings = loaded.best, loaded.treatment, loaded.summary["settings"]
        files = sorted(folder.glob("axis*.toml"), key=lambda file: (len(file.name), file.name))
        given = list(log) if isinstance(log, (list, tuple)) else [] if log is None else [log]
        logs, axes = _logs_of(folder, loaded.summary["provenance"], given, [read_axis(file) for file in files])
    found = determined_by(logs, axes, best, treatment, settings, count=draws, progress=progress)
    return KnownTruth(best.name, {one.name: one for one in found}, draws)


def _logs_of(
    folder: Path, provenance: Mapping[str, str], given: Sequence[Any], axes: Sequence[Axis]
) -> tuple[list[Log], list[Axis | None]]:
    """Return the logs of the results in a folder, each with its axis; a log with another content is refused."""
    keys = [key for key in provenance if re.fullmatch(r"log(_\d+)?", key)]
    if given and len(given) != len(keys):
        message = "are another number of logs than were identified together"
        raise InputError(message, path="log", value=len(given), allowed=str(len(keys)), mend="Name each of them once")
    described, logs = axes_for(axes, len(keys)), list[Log]()
    for key, axis, named in zip(keys, described, given or [None] * len(keys), strict=True):
        file = named if named is not None else _beside(folder, provenance[key])
        read, checksum = file if isinstance(file, Log) else read_log(file, axis), provenance[f"{key}_sha256"]
        if checksum and read.origin.checksum != checksum:
            raise InputError(
                "is not the log of these results, or has changed since",
                path=str(read.source),
                value=f"SHA-256 {read.origin.checksum[:12]}…",
                allowed=f"{checksum[:12]}…",
                mend=f"Name {provenance[key]} as it was identified (--log), or identify this one",
            )
        logs.append(read)
    return logs, described


def _beside(folder: Path, name: str) -> Path:
    """Return a log of a name that lies beside a folder of results, in it, or in the current folder."""
    for place in (folder.absolute().parent, folder, Path()):
        if name and (place / name.partition("::")[0]).is_file():
            return place / name
    raise InputError(
        "the log of these results is not there" if name else "holds no file name of its log, which was identified from memory",
        path=str(folder),
        value=name,
        allowed="beside the folder, in it, or in the current folder",
        mend="Name the log: --log PATH",
    )
