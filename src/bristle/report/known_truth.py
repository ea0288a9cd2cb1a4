"""The parameters that a log determines, by simulated logs with known truth."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bristle.core import Axis, Card, InputError, WithCard, number, with_unit
from bristle.files import axes_for, read_axis
from bristle.identification import Determined
from bristle.logs import Log, read_log
from bristle.report.table import Table

NOTE = "The simulated axis follows the model exactly. The unexplained force of the recorded log adds to these errors."
KEYS = (
    "truth",
    "unit",
    "description",
    "relative_to",
    "median_error_percent",
    "spread_percent",
    "within_percent",
)
KEYS += ("identified", "intervals", "hold", "verdict")
VERDICTS = {
    "determined": ("determines {}", "determines no parameter"),
    "rough": ("determines {} roughly", ""),
    "not determined": ("does not determine {}", ""),
}


@dataclass(frozen=True, eq=False)
class KnownTruth(WithCard):
    """The parameters that the log of an identification determines, by simulated logs with known truth.

    Parameters
    ----------
    model : str
        Name of the friction model.
    parameters : dict of str to Determined
        Every fitted parameter, by name.
    draws : int
        Number of simulated logs.
    """

    model: str
    parameters: Mapping[str, Determined]
    draws: int

    @property
    def sentence(self) -> str:
        """The verdict: the parameters that the log determines."""
        parts = list[str]()
        for verdict, (phrase, lacking) in VERDICTS.items():
            names = [
                parameter.name
                for parameter in self.parameters.values()
                if parameter.verdict == verdict
            ]
            listed = " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
            parts += filter(None, [phrase.format(listed) if names else lacking])
        return f"This log {'; '.join(parts)}."

    @property
    def table(self) -> Table:
        """The parameters: truth, errors, intervals, verdict."""
        rows = [
            {
                "Parameter": parameter.name,
                "True value": with_unit(parameter.truth, parameter.unit, digits=4),
                "Median error [%]": _percent(parameter.median_error_percent),
                "Spread [%]": _percent(parameter.spread_percent),
                "Correct intervals": f"{parameter.hold} of {parameter.intervals}"
                if parameter.intervals
                else "–",
                "Verdict": _words(parameter),
            }
            for parameter in self.parameters.values()
        ]
        return Table.of(
            f"Parameters that this log determines: {self.model}, {self.draws} simulated logs", rows
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, in SI units of the axis, as ``bristle check --json`` prints them."""
        parameters = {
            name: {key: getattr(parameter, key) for key in KEYS}
            for name, parameter in self.parameters.items()
        }
        return {
            "model": self.model,
            "draws": self.draws,
            "sentence": self.sentence,
            "parameters": parameters,
        }

    def _card(self) -> Card:
        table = self.table
        return Card(self.sentence, tuple(table.heads), tuple(map(tuple, table.rows)), (NOTE,))


def _percent(value: float | None) -> str:
    return "–" if value is None else number(value, digits=2)


def _words(parameter: Determined) -> str:
    """Return the verdict on a parameter in words."""
    of = f" of {parameter.relative_to}" if parameter.relative_to != parameter.name else ""
    within = f"within {_percent(parameter.within_percent)} %{of}{'; intervals too narrow' if parameter.too_narrow else ''}"
    if parameter.verdict != "not determined":
        return f"{parameter.verdict}{':' if parameter.verdict == 'rough' else ''} {within}"
    if parameter.truth == 0.0 and not of:
        return "not determined: the true value is 0"
    if parameter.within_percent is None or parameter.is_rare:
        within = "" if parameter.within_percent is None else f", in those {within}"
        return (
            f"not determined: identified in {parameter.identified} of {parameter.logs} logs{within}"
        )
    return f"not determined: error up to {_percent(parameter.within_percent)} %{of}"


def logs_of(
    folder: Path, provenance: Mapping[str, str], log: Any = None
) -> tuple[list[Log], list[Axis | None]]:
    """Return the logs of the results in a folder, each with its axis; a changed log raises an error."""
    named = list(log) if isinstance(log, (list, tuple)) else [] if log is None else [log]
    axes = [
        read_axis(file)
        for file in sorted(folder.glob("axis*.toml"), key=lambda file: (len(file.name), file.name))
    ]
    keys = [key for key in provenance if re.fullmatch(r"log(_\d+)?", key)]
    if named and len(named) != len(keys):
        raise InputError(
            "the number of logs differs from that of the identification",
            path="log",
            value=len(named),
            allowed=str(len(keys)),
            mend="Name each log once",
        )
    described, logs = axes_for(axes, len(keys)), list[Log]()
    for key, axis, path in zip(keys, described, named or [None] * len(keys), strict=True):
        file = path if path is not None else _beside(folder, provenance[key])
        read, checksum = (
            file if isinstance(file, Log) else read_log(file, axis),
            provenance[f"{key}_sha256"],
        )
        if checksum and read.origin.checksum != checksum:
            raise InputError(
                "is not the log of these results, or has changed since the identification",
                path=str(read.source),
                value=f"SHA-256 {read.origin.checksum[:12]}…",
                allowed=f"{checksum[:12]}…",
                mend=f"Name the identified {provenance[key]} (--log), or identify this log",
            )
        logs.append(read)
    return logs, described


def _beside(folder: Path, name: str) -> Path:
    """Return a log by name from the parent of a folder of results, the folder, or the current folder."""
    for place in (folder.absolute().parent, folder, Path()):
        if name and (place / name.partition("::")[0]).is_file():
            return place / name
    raise InputError(
        "the log of these results is missing"
        if name
        else "contains no file name of the log, because the log was in memory",
        path=str(folder),
        value=name or None,
        allowed="a file in this folder, in its parent folder, or in the current folder",
        mend="Name the log: --log PATH",
    )
