"""Tune a machine from the page: plan, run and undo as jobs; the state of a run and its latest record from its folder."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.core import InputError, unit_of
from bristle.server.cases import RefusedRequestError
from bristle.server.errand import Answer, Errand, as_table, thinned

if TYPE_CHECKING:
    from bristle.core import Axis

AT_REST = ("rest", "rest_after_check", "test_effort")  # records without motion
COMPLETE = 0.3  # time since the last write of a complete record [s]


@dataclass(frozen=True)
class TunedMachine:
    """A machine file and the folder of its run, both below the folder where the server was started, with their names on the page."""

    file: Path
    folder: Path
    names: dict[str, str]
    axis: Axis

    @classmethod
    def of(cls, home: Path, request: dict[str, Any]) -> TunedMachine:
        """Return the machine that a page names; without a name, the machine file is that of the journal in the folder."""
        from bristle.files import read_machine
        from bristle.tune.journal import Journal

        folder = _below(home, request.get("folder"), "folder of the run")
        names = {"file": str(request.get("file") or ""), "folder": str(request["folder"])}
        try:
            begun = None if names["file"] else Journal(folder).last("begun")
            file = _below(home, begun["file"] if begun else names["file"], "machine file")
            if not file.is_file():
                raise RefusedRequestError(404, "does not exist", path="machine file", value=str(file))
            return cls(file, folder, names, read_machine(file).axis)
        except RefusedRequestError:
            raise
        except (InputError, OSError) as error:
            raise RefusedRequestError(400, str(error)) from None

    def as_data(self) -> dict[str, Any]:
        """Return the state of the run for the page, read without a connection to the machine."""
        from bristle.tune.status import run_status

        try:
            run = run_status(self.folder, self.axis.kind)
        except InputError as error:
            raise RefusedRequestError(409, str(error)) from None
        written = {file.stem: file.stat().st_mtime for file in self.folder.glob("records/*.csv") if file.stem not in AT_REST}
        complete = {name: at for name, at in written.items() if time.time() - at > COMPLETE}
        name = max(complete, key=complete.__getitem__, default=None)
        return {"run": run, "record": name and {"name": name, "revision": complete[name]}}

    def record(self, name: str) -> dict[str, Any]:
        """Return the curves of a record: reference and position, following error, effort."""
        from bristle.logs import read_log

        files = {file.stem: file for file in self.folder.glob("records/*.csv")}
        if name not in files:
            raise RefusedRequestError(404, "does not exist", path="record", value=name)
        try:
            log = read_log(files[name], self.axis)
        except InputError:
            raise RefusedRequestError(409, "is not complete yet", path="record", value=name) from None
        assert log.reference is not None
        assert log.effort is not None
        at, reference, position = (channel.values for channel in (log.time, log.reference, log.position))
        length, force = (unit_of(quantity, self.axis.kind) for quantity in ("length", "force"))
        curves = {"motion": (length, (reference, position)), "error": (length, (reference - position,)), "effort": (force, (log.effort.values,))}
        return {name: {"unit": unit, "curves": thinned(at, *signals)} for name, (unit, signals) in curves.items()}


def _below(home: Path, text: object, name: str) -> Path:
    """Return a path that a page names; refuse a path outside the folder where the server was started."""
    if not isinstance(text, str) or not text.strip() or "\0" in text:
        raise RefusedRequestError(400, "is missing", path=name, mend=f"Name it relative to {home}")
    path = home / text.strip()
    try:
        inside = home.resolve() in path.resolve().parents
    except (OSError, RuntimeError):  # a loop of links
        inside = False
    if not inside:
        mend = "Start bristle lab --serve in the folder of the machine file"
        raise RefusedRequestError(403, "is outside the folder of this server", path=name, value=text, allowed=f"below {home}", mend=mend)
    return path


def plan(errand: Errand) -> Answer:
    """Return each step with its moves and writes, as `bristle tune` without --move."""
    from bristle.report.table import Table
    from bristle.tune import tune
    from bristle.tune.report import plan_rows
    from bristle.tune.tuning import COMPUTES

    errand.report(0.3, "reading the machine")
    planned = tune(errand.text("file"), errand.text("folder"))
    table = Table("Plan", ("Step", "Duration", "Travel", "Writes"), plan_rows(planned))
    return {}, {"table": as_table(table), "seconds": [facts["seconds"] or COMPUTES for facts in planned.facts.values()]}


def tune(errand: Errand) -> Answer:
    """Run the steps on the machine, as `bristle tune --move`; a cancelled run restores the machine."""
    from bristle.tune import MachineStoppedError
    from bristle.tune import tune as tune_machine

    def report(share: float, text: str) -> None:
        if errand.is_cancelled():
            raise MachineStoppedError("operator", "stopped in the lab")
        errand.report(share, text)

    result = tune_machine(errand.text("file"), errand.text("folder"), move=True, progress=report)
    return {"outcome": result.outcome, "code": result.code}, {}


def undo(errand: Errand) -> Answer:
    """Restore the machine as before the run, as `bristle tune --undo`."""
    from bristle.tune import undo as undo_run

    errand.report(0.3, "restoring the machine")
    return {"outcome": undo_run(errand.text("folder")).outcome}, {}
