"""`tune`: run the steps on a machine, keep the feedforward if it helps, and restore the machine in every other case."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bristle.core import BristleError, InputError, Kind, Progress
from bristle.files import MachineFile, as_json, lock, provenance, read_machine, state_folder, write_whole
from bristle.tune.journal import NAME, Journal
from bristle.tune.machine import Machine, MachineRefusedError, MachineStoppedError
from bristle.tune.machines import connected
from bristle.tune.run import Options, Run
from bristle.tune.steps import STEPS, Step

SUMMARY = "summary.json"
WRITING = ("check", "stages", "comparison", "verdict")  # steps that write on the machine


@dataclass
class Tuning:
    """The result of a run.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    outcome : {"kept", "restored", "planned", "undone"}
        Whether the feedforward stays in the machine.
    code, reason : str
        Why the machine was restored; empty if it was not.
    facts : mapping
        Facts of each finished step.
    restored : bool
        Whether the machine reads back as before the run, if it was restored.
    kind : {"translational", "rotational"}
        Kind of axis.
    """

    folder: Path
    outcome: str
    code: str = ""
    reason: str = ""
    facts: dict[str, dict[str, Any]] = field(default_factory=dict)
    restored: bool = True
    kind: Kind = "translational"

    @property
    def change_percent(self) -> float | None:
        """Change of the rms following error [%]."""
        change = self.facts.get("comparison", {}).get("changes", {}).get("following_error.rms")
        return None if change is None else change["change_percent"]

    def as_data(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {"outcome": self.outcome, "code": self.code, "reason": self.reason, "steps": self.facts}


def tune(
    file: MachineFile | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    move: bool = False,
    options: Options | None = None,
    progress: Progress | None = None,
    machine: Machine | None = None,
) -> Tuning:
    """Tune the friction feedforward of a running axis; keep it if the following error is lower, restore the machine otherwise.

    Parameters
    ----------
    file : MachineFile or path-like
        The machine file.
    folder : path-like
        Folder of the run. If it contains a journal, the run resumes; a run that was killed restores the machine first.
    move : bool
        Whether the axis may move. Without it, `tune` reads the machine and returns the plan.
    options : Options, optional
        Models, duration of the excitation, draws.
    progress : callable, optional
        Called with the share of the work done and the current task.
    machine : Machine, optional
        A connected machine, in place of the machine of the file.

    Returns
    -------
    Tuning
        The outcome, with the facts of each step.

    Raises
    ------
    InputError
        If the machine file is not valid, another run uses the machine, or the journal was changed.
    """
    described = file if isinstance(file, MachineFile) else read_machine(file)
    path = Path(folder).absolute()
    if path.exists() and any(path.iterdir()) and not (path / NAME).exists():
        raise InputError("contains files that are not of a run of tune", path=str(path), mend="Name a new folder")
    with _only_run(described, path), contextlib.closing(machine or connected(described)) as used:
        path.mkdir(parents=True, exist_ok=True)
        run = Run(described, used, path, Journal(path), options or Options(), progress)
        _same_file(run)
        if run.journal.has_written:
            _restore(run, "a run that was interrupted")
        if not move:
            return Tuning(path, "planned", facts=_planned(run), kind=described.axis.kind)
        outcome = _steps(run)
        _write(run, outcome)
        return outcome


def undo(folder: str | os.PathLike[str], *, machine: Machine | None = None) -> Tuning:
    """Restore the machine as it was before the run in a folder, and prove it by reading back."""
    path = Path(folder).absolute()
    journal = Journal(path)
    begun = journal.last("begun")
    if begun is None:
        raise InputError("contains no run of tune", path=str(path), mend="Name the folder of a run")
    described = read_machine(begun["file"])
    with _only_run(described, path), contextlib.closing(machine or connected(described)) as used:
        run = Run(described, used, path, journal)
        if not _restore(run, "undo"):
            raise MachineRefusedError(
                "not_restored", "the machine differs from its backup", f"The backup is in {journal.path}, entry backup"
            )
    return Tuning(path, "undone")


def _steps(run: Run) -> Tuning:
    """Do the steps; restore the machine after any failure."""
    code, reason, identical = "", "", True
    try:
        for number, step in enumerate(STEPS):
            _do(run, step, number)
    except BristleError as error:
        code = error.code if isinstance(error, MachineRefusedError) else error.reason if isinstance(error, MachineStoppedError) else "input"
        reason = str(error)
        run.journal.write(run.step, "stopped", code=code, reason=reason)
        identical = _restore(run, reason)
    except BaseException as error:
        run.journal.write(run.step, "stopped", code=type(error).__name__, reason=str(error))
        _restore(run, type(error).__name__)
        raise
    return Tuning(run.folder, "restored" if code else "kept", code, reason, run.facts, identical, run.axis.kind)


def _write(run: Run, outcome: Tuning) -> None:
    """Write summary and report."""
    from bristle.report.compared import compare
    from bristle.tune.report import tune_report

    source = provenance(f"bristle tune {run.file.source.name} --out {run.folder.name} --move", machine=run.file.content)
    compared = compare(*run.sides(), axis=run.axis) if "comparison" in outcome.facts else None
    page = tune_report(
        run, outcome, compared, command=f"bristle tune {run.file.source.name} --out {run.folder.name} --move", provenance=source
    )
    write_whole(run.folder / "report.html", page)
    write_whole(run.folder / SUMMARY, as_json(outcome.as_data() | {"provenance": source}))


def _do(run: Run, step: Step, number: int) -> None:
    """Do a step, or take its facts from the journal if an interrupted run finished it."""
    run.step = step.name
    entry = run.journal.last("done", step=step.name)
    if step.resumes and entry is not None:
        run.facts[step.name] = entry["facts"]
        return
    run.journal.write(step.name, "begun", file=str(run.file.source), sha256=_checksum(run.file))
    inner = run.progress
    if inner is not None:
        run.progress = lambda share, text: inner((number + share) / len(STEPS), f"{step.title}: {text}")
        run.progress(0.0, "")
    try:
        step.act(run)
    finally:
        run.progress = inner


def _restore(run: Run, cause: str) -> bool:
    """Restore the machine from the backup in the journal; return whether all of it reads back as before."""
    entry = run.journal.last("done", step="backup")
    if entry is None:
        return True
    state = entry["facts"]["state"]
    run.machine.restore(state)
    present = json.loads(json.dumps(dict(run.machine.state())))
    identical = present == json.loads(json.dumps(state))
    different = _differences(state, present)
    run.journal.write(run.step or "restore", "restored", cause=cause, identical=identical, different=different)
    return identical


def _differences(state: dict[str, Any], present: dict[str, Any], path: str = "") -> dict[str, list[Any]]:
    """Return each entry that differs, before and now."""
    different: dict[str, list[Any]] = {}
    for name in [*state, *(name for name in present if name not in state)]:
        old, new = state.get(name), present.get(name)
        if isinstance(old, dict) and isinstance(new, dict):
            different |= _differences(old, new, f"{path}{name}: ")
        elif old != new:
            different[f"{path}{name}"] = [old, new]
    return different


def _same_file(run: Run) -> None:
    """Refuse to resume a run with another machine file."""
    begun = run.journal.last("begun")
    if begun is not None and begun["sha256"] != _checksum(run.file):
        mend = "Name a new folder, or restore the file. bristle tune --undo restores the machine"
        raise InputError("changed since the run began", path=str(run.file.source), mend=mend)


def _planned(run: Run) -> dict[str, dict[str, Any]]:
    """Return each step with its moves and writes, without touching the machine."""
    writes, sample_time = run.machine.writes(), run.sample_time
    cycle = run.file.cycle.size * sample_time
    seconds = {
        "check": 8.0,
        "warm_up": 4 * cycle,
        "before": run.file.cycles * cycle,
        "excitation": run.options.duration,
        "stages": 12 * cycle,
    }
    seconds["comparison"] = 4 * run.file.cycles * cycle
    low, high = float(run.file.cycle.min()), float(run.file.cycle.max())
    stroke = run.limits.travel
    travel = dict.fromkeys(seconds, (low, high)) | {"check": (low, low), "excitation": stroke}
    return {
        step.name: {
            "title": step.title,
            "moves": step.moves,
            "seconds": round(seconds.get(step.name, 0.0), 1),
            "travel": travel.get(step.name),
            "writes": writes if step.name in WRITING else [],
        }
        for step in STEPS
    }


@contextlib.contextmanager
def _only_run(file: MachineFile, folder: Path) -> Iterator[None]:
    """Hold the lock of a machine, which names the folder of its run; refuse a second run."""
    key = hashlib.sha256(f"{file.machine} {file.source}".encode()).hexdigest()[:16]
    path = state_folder("tune") / f"{key}.lock"
    with path.open("a+b") as opened:
        try:
            lock(opened.fileno())
        except BlockingIOError:
            raise InputError(
                "is used by another run of bristle tune", path=str(file.source), mend="Wait until it ends, or end it"
            ) from None
        opened.seek(0)
        earlier = Path(opened.read().decode(errors="replace").strip() or folder)
        if earlier != folder and (earlier / NAME).exists() and Journal(earlier).has_written:
            mend = f"Restore the machine first: bristle tune --undo {earlier}"
            raise InputError("was left by an interrupted run in another folder", path=str(file.source), value=str(earlier), mend=mend)
        opened.truncate(0)
        opened.write(str(folder).encode())
        opened.flush()
        yield


def _checksum(file: MachineFile) -> str:
    return file.content.checksum if file.content is not None else ""
