"""`Fleet`: a description of many logs, each identified separately with one model. It is a study with one run per log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from bristle.apps.study.plan import Block
from bristle.core import Axis, Content, FrictionModel, InputError, Kind, Variable, cached_property
from bristle.identification import prior_knowledge_of
from bristle.logs import LogFile

RUN = {
    "run": "number of the log in the fleet",
    "folder": "folder of the log",
    "log": "name of the log, with its table",
    "time_of_log": "time of recording, by the clock of the log",
    "status": "result of the run",
    "reason": "reason for missing numbers",
    "diagnostics": "codes of the warnings about the fit",
    "verdict": "usable, with_care or measure_again",
}
OF_FIT = {
    "held_out_error": ("", "error on held-out blocks, as a share of the effort"),
    "error": ("", "error on the fitted rows, as a share of the effort"),
    "scatter": (
        "",
        "standard deviation of the level of friction from reversal to reversal, as a share of the level",
    ),
    "temperature": ("K", "mean of the temperature column"),
    "duration": ("s", "length of the log"),
}


@dataclass(frozen=True, eq=False)
class Fleet:
    """Many logs, identified separately."""

    name: str
    logs: tuple[LogFile, ...]
    axes: tuple[Axis | None, ...]
    kind: Kind
    model: FrictionModel
    options: Mapping[str, Any]
    readers: tuple[Content, ...]
    size_limit: int
    described: Mapping[str, Any]

    @property
    def count(self) -> int:
        """Number of logs."""
        return len(self.logs)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """A block for each log: a fleet can grow, and a log that crashes its process does not affect the others."""
        return tuple(Block(number, number + 1) for number in range(self.count))

    @cached_property
    def parameters(self) -> dict[str, Variable]:
        """The parameters, by the column of each: those of the plant first."""
        plants = [prior_knowledge_of(axis, None, None, self.kind).plant for axis in self.axes]
        friction = {
            name: variable
            for name, variable in self.model.variables.items()
            if not self.model.is_array(name)
        }
        sections = {
            "plant": {
                name: variable for plant in plants for name, variable in plant.variables.items()
            },
            "friction": friction,
        }
        named = {
            f"{section}.{name}": variable
            for section, variables in sections.items()
            for name, variable in variables.items()
        }
        return {column: variable for column, variable in named.items() if not variable.choices}

    @cached_property
    def columns(self) -> dict[str, dict[str, str]]:
        """Description of each column of a block: the run, each parameter with status and interval, results of the fit."""
        columns = {name: _column("run", "", description) for name, description in RUN.items()}
        for name, variable in self.parameters.items():
            unit = variable.unit(self.kind)
            if variable.quantity == "1":
                unit = ""
            columns[name] = _column("parameter", unit, variable.description)
            columns[f"{name}.status"] = _column(
                "run", "", "identified, held, at_edge or unidentifiable"
            )
            columns |= _ends(name, unit)
        for name, (unit, description) in OF_FIT.items():
            columns[name] = _column("fit", unit, description)
            if name == "scatter":
                columns |= _ends(name, "")
        return columns

    def following(self, listed: Sequence[Mapping[str, Any]]) -> Fleet:
        """Return the fleet with the logs already in its folder at their numbers there."""
        named = {log.identity: log for log in self.logs}
        places = {(log.folder, log.name): log.place for log in self.logs}
        logs = []
        for entry in listed:
            past = LogFile("", entry["folder"], entry["log"], entry["sha256"], entry["time"])
            log = named.pop(past.identity, None)
            if log is None and (past.folder, past.name) in places:
                raise InputError(
                    "is already in this fleet, with different content",
                    path=places[past.folder, past.name],
                    mend="Rename the log, or name another folder for the fleet",
                )
            if log is None:
                log = past
            logs.append(log)
        return replace(self, logs=(*logs, *named.values()))


def _column(role: str, unit: str, description: str) -> dict[str, str]:
    return {"role": role, "unit": unit, "description": description}


def _ends(column: str, unit: str) -> dict[str, dict[str, str]]:
    return {
        f"{column}.{end}": _column("interval", unit, f"{end} end of the 95 % interval of {column}")
        for end in ("lower", "upper")
    }
