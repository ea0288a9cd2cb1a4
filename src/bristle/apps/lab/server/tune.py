"""Tune a machine from the page: plan, run and undo as jobs; the state of a run and its latest record from its folder."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bristle.apps.lab.server.errand import Answer, Errand, as_table, thinned
from bristle.apps.lab.server.limits import RefusedRequestError
from bristle.core import Axis, unit_of

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
        from bristle.apps.tune.journal import Journal
        from bristle.files import read_machine

        folder = _below(home, request.get("folder"), "folder of the run")
        names = {"file": str(request.get("file") or ""), "folder": str(request["folder"])}
        begun = None if names["file"] else Journal(folder).last("begun")
        file = _below(home, begun["file"] if begun else names["file"], "machine file")
        if not file.is_file():
            raise RefusedRequestError(404, "does not exist", path="machine file", value=str(file))
        return cls(file, folder, names, read_machine(file).axis)

    def as_data(self) -> dict[str, Any]:
        """Return the state of the run for the page, read without a connection to the machine."""
        written = {
            file.stem: file.stat().st_mtime
            for file in self.folder.glob("records/*.csv")
            if file.stem not in AT_REST
        }
        complete = {name: at for name, at in written.items() if time.time() - at > COMPLETE}
        name = max(complete, key=complete.__getitem__, default=None)
        run = self._run()
        # The comparison changes the pictures of its records.
        return {
            "run": run,
            "record": name
            and {"name": name, "revision": f"{complete[name]} {bool(run and run['change'])}"},
        }

    def _run(self) -> dict[str, Any] | None:
        from bristle.apps.tune.status import run_status

        return run_status(self.folder, self.axis.kind)

    def record(self, name: str) -> list[dict[str, Any]]:
        """Return pictures of a record: motion, following error, effort; after a comparison, without and with the feedforward."""
        if name not in {file.stem for file in self.folder.glob("records/*.csv")}:
            raise RefusedRequestError(404, "does not exist", path="record", value=name)
        (side, _, number), run, names = name.partition("_"), self._run(), [name]
        if number and run and run["change"] and side in ("before", "after"):
            names = [f"before_{number}", f"after_{number}"]
        logs = [self._signals(single) for single in names]
        at, reference, position, _ = logs[0]
        keys = ["without", "with"] if len(logs) > 1 else []
        length, force = (unit_of(quantity, self.axis.kind) for quantity in ("length", "force"))
        pictures = (
            ("position", length, ["measured", "reference"], [position, reference]),
            (
                "following error",
                length,
                keys,
                [planned - measured for _, planned, measured, _ in logs],
            ),
            ("effort", force, keys, [effort for *_, effort in logs]),
        )
        return [
            {"word": word, "unit": unit, "keys": keys, "curves": thinned(at, *curves)}
            for word, unit, keys, curves in pictures
        ]

    def _signals(self, name: str) -> tuple[np.ndarray, ...]:
        """Return time, reference, position and effort of a record."""
        from bristle.logs import read_log

        log = read_log(self.folder / "records" / f"{name}.csv", self.axis)
        assert log.reference is not None
        assert log.effort is not None
        return log.time.values, log.reference.values, log.position.values, log.effort.values


def _below(home: Path, text: object, name: str) -> Path:
    """Return a path that a page names; refuse a path outside the folder where the server was started."""
    if not isinstance(text, str) or not text.strip():
        raise RefusedRequestError(400, "is missing", path=name, mend=f"Name it relative to {home}")
    path = home / text.strip()
    try:
        path.exists()  # its name may be too long
        inside = home.resolve() in path.resolve().parents
    except (OSError, RuntimeError, ValueError) as error:
        raise RefusedRequestError(400, f"cannot be read ({error})", path=name) from None
    if not inside:
        raise RefusedRequestError(
            403,
            "is outside the folder of this server",
            path=name,
            value=text,
            allowed=f"below {home}",
            mend="Start bristle lab --serve in the folder of the machine file",
        )
    return path


def plan(errand: Errand) -> Answer:
    """Return each step with its moves and writes, as `bristle tune` without --move."""
    from bristle.apps.tune import tune
    from bristle.apps.tune.report import plan_rows
    from bristle.apps.tune.tuning import COMPUTES
    from bristle.report.table import Table

    errand.report(0.3, "reading the machine")
    planned = tune(errand.text("file"), errand.text("folder"))
    table = Table("Moves and writes", ("Step", "Duration", "Travel", "Writes"), plan_rows(planned))
    return {}, {
        "table": as_table(table),
        "seconds": [facts["seconds"] or COMPUTES for facts in planned.facts.values()],
    }


def tune(errand: Errand) -> Answer:
    """Run the steps on the machine, as `bristle tune --move`; a cancelled run restores the machine."""
    from bristle.apps.tune import MachineStoppedError, tune as tune_machine

    def report(share: float, text: str) -> None:
        if errand.is_cancelled():
            raise MachineStoppedError("operator", "stopped in the lab")
        errand.report(share, text)

    result = tune_machine(errand.text("file"), errand.text("folder"), move=True, progress=report)
    return {"outcome": result.outcome, "code": result.code}, {}


def undo(errand: Errand) -> Answer:
    """Restore the machine as before the run, as `bristle tune --undo`."""
    from bristle.apps.tune import undo as undo_run

    errand.report(0.3, "restoring the machine")
    return {"outcome": undo_run(errand.text("folder")).outcome}, {}
