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
from bristle.tune.machine import Machine, MachineRefusedError, MachineStoppedError, SavingMachine
from bristle.tune.machines import connected
from bristle.tune.run import MODEL, RESULTS, Options, Run
from bristle.tune.steps import GAINS, ORDER, RUN_IN, STAGE_CYCLES, STEPS, Step, cycles_compared

SUMMARY = "summary.json"
COMPUTES = 5.0  # weight of a step without motion, for the remaining time [s]
ADDRESS = ("net_id", "url", "prefix")  # settings that identify a controller
WRITING = ("check", "stages", "refinement", "comparison", "verdict")  # steps that write on the machine


@dataclass
class Tuning:
    """The result of a run.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    outcome : {"kept", "restored", "planned", "undone", "saved"}
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
    allow_code: bool = False,
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
    allow_code : bool
        Whether a Python file with the machine may run without earlier permission.

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
    with _only_run(described, path), contextlib.closing(machine or connected(described, allow_code=allow_code)) as used:
        path.mkdir(parents=True, exist_ok=True)
        run = Run(described, used, path, Journal(path), options or Options(), progress)
        _same_request(run)
        if run.journal.is_kept:
            mend = f"Restore the machine first: bristle tune --undo {path}"
            raise InputError("is a finished run, whose feedforward the machine keeps", path=str(path), mend=mend)
        if run.journal.has_written:
            _put_back(run, "a run that was interrupted")
        if not move:
            return Tuning(path, "planned", facts=_planned(run), kind=described.axis.kind)
        outcome = _steps(run)
        _write(run, outcome)
        return outcome


def undo(folder: str | os.PathLike[str], *, machine: Machine | None = None) -> Tuning:
    """Restore the machine as it was before the run in a folder, also its non-volatile memory, and prove it by reading back."""
    with _reopened(folder, machine) as run:
        try:
            _put_back(run, "undo")
        finally:
            if run.journal.is_saved and isinstance(run.machine, SavingMachine):
                run.machine.unsave()
                left = [place for place, content in run.machine.saved().items() if content]
                if left:
                    raise MachineRefusedError("not_removed", f"the memory still contains the feedforward: {', '.join(left)}")
                run.journal.write("save", "removed")
    return Tuning(run.folder, "undone")


def save(folder: str | os.PathLike[str], *, machine: Machine | None = None) -> Tuning:
    """Save the kept feedforward of the run in a folder in the non-volatile memory of its machine, and prove it by reading back.

    Raises
    ------
    MachineRefusedError
        If the machine has no such memory, the run was not kept, the machine changed since, or the memory does not read back as written.
    """
    with _reopened(folder, machine) as run:
        journal, used = run.journal, run.machine
        if not isinstance(used, SavingMachine):
            mend = "Its feedforward lasts until the controller restarts. Then run bristle tune again, or export the model: bristle export"
            raise MachineRefusedError("no_memory", f"the machine {run.file.machine} has no non-volatile memory", mend)
        kept, identified = journal.last("kept"), journal.last("done", step="identity")
        if kept is None or identified is None or not journal.is_kept:
            raise MachineRefusedError("not_kept", "this run did not keep a feedforward", "Save a run whose outcome is kept")
        present = {"identity": dict(used.identity()), "state": dict(used.state())}
        different = _differences({"identity": identified["facts"]["identity"], "state": kept["state"]}, json.loads(json.dumps(present)))
        if different:
            reason = f"the machine is not as the run left it: {', '.join(different)}"
            raise MachineRefusedError("state_changed", reason, f"Restore it, and tune again: bristle tune --undo {run.folder}")
        results = kept.get("results", RESULTS)  # a run of an earlier version has one model
        run.noted(f"{results}/{MODEL}")
        journal.write("save", "saving", places=dict(used.saved()))
        written, places = dict(used.save(run.folder / results)), dict(used.saved())
        if written != places or not all(places.values()):
            mend = f"Remove it: bristle tune --undo {run.folder}"
            raise MachineRefusedError("not_saved", f"the memory differs from what was written: {', '.join(places)}", mend)
        journal.write("save", "saved", places=places)
    return Tuning(run.folder, "saved", facts={"save": {"places": places, "loads": getattr(used, "loads", "")}})


@contextlib.contextmanager
def _reopened(folder: str | os.PathLike[str], machine: Machine | None) -> Iterator[Run]:
    """Connect the machine of the run in a folder."""
    path = Path(folder).absolute()
    journal = Journal(path)
    begun = journal.last("begun")
    if begun is None:
        raise InputError("contains no run of tune", path=str(path), mend="Name the folder of a run")
    described = read_machine(begun["file"])
    with _only_run(described, path), contextlib.closing(machine or connected(described)) as used:
        yield Run(described, used, path, journal)


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
    from bristle.tune.report import tune_report

    command = f"bristle tune {run.file.source.name} --out {run.folder.name} --move"
    source = provenance(command, machine=run.file.content)
    write_whole(run.folder / "report.html", tune_report(run, outcome, command=command, provenance=source))
    write_whole(run.folder / SUMMARY, as_json(outcome.as_data() | {"provenance": source}))


def _do(run: Run, step: Step, number: int) -> None:
    """Do a step, or take its facts from the journal if an interrupted run finished it."""
    run.step = step.name
    entry = run.journal.last("done", step=step.name)
    if step.resumes and entry is not None:
        run.facts[step.name] = entry["facts"]
        return
    run.journal.write(step.name, "begun", file=str(run.file.source.absolute()), sha256=_checksum(run.file), options=vars(run.options))
    inner = run.progress
    if inner is not None:
        planned = [facts["seconds"] or COMPUTES for facts in _planned(run).values()]
        begin, share_of_step = sum(planned[:number]) / sum(planned), planned[number] / sum(planned)
        run.progress = lambda share, text: inner(begin + share * share_of_step, f"{step.title}: {text}" if text else step.title)
        run.played, run.planned = 0.0, planned[number]
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


def _put_back(run: Run, cause: str) -> None:
    """Restore the machine; refuse to go on if it does not read back as before."""
    if not _restore(run, cause):
        mend = f"The backup is in {run.journal.path}, entry backup"
        raise MachineRefusedError("not_restored", "the machine differs from its backup", mend)


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


def _same_request(run: Run) -> None:
    """Refuse to resume a run with another machine file or other options."""
    begun = run.journal.last("begun")
    if begun is None:
        return
    mend = f"Name a new folder, or go on as begun. bristle tune --undo {run.folder} restores the machine"
    if begun["sha256"] != _checksum(run.file):
        raise InputError("changed since the run began", path=str(run.file.source), mend=mend)
    for name, value in vars(run.options).items():
        if begun["options"][name] != value:
            raise InputError("differs from the run in this folder", path=name, value=value, allowed=str(begun["options"][name]), mend=mend)


def _planned(run: Run) -> dict[str, dict[str, Any]]:
    """Return each step with its moves and writes, without touching the machine."""
    writes, sample_time = run.machine.writes(), run.sample_time
    cycle = run.file.cycle.size * sample_time
    seconds = {
        "check": 8.0,
        "warm_up": 4 * cycle,
        "before": run.file.cycles * cycle,
        "excitation": run.options.duration,
        "stages": len(GAINS) * STAGE_CYCLES * cycle,
    }
    seconds["refinement"] = seconds["excitation"] + STAGE_CYCLES * cycle + seconds["stages"]
    seconds["comparison"] = len(ORDER) * (cycles_compared(run.file.cycles) + RUN_IN) * cycle
    low, high = float(run.file.cycle.min()), float(run.file.cycle.max())
    stroke = run.limits.travel
    travel = dict.fromkeys(seconds, (low, high)) | {"check": (low, low), "excitation": stroke, "refinement": stroke}
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
    # A computer has one HAL; a controller is known by its address, a simulated or own machine by its file.
    address = [file.settings[key] for key in ADDRESS if key in file.settings] or [file.source.absolute()]
    own = ["linuxcnc"] if file.machine == "linuxcnc" else address
    key = hashlib.sha256(" ".join(map(str, (file.machine, *own))).encode()).hexdigest()[:16]
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
        journal = Journal(earlier) if earlier != folder and (earlier / NAME).exists() else None
        if journal is not None and (journal.has_written or journal.is_kept):
            reason = "was left by an interrupted run" if journal.has_written else "keeps the feedforward of a run"
            mend = f"Restore the machine first: bristle tune --undo {earlier}"
            raise InputError(f"{reason} in another folder", path=str(file.source), value=str(earlier), mend=mend)
        opened.truncate(0)
        opened.write(str(folder).encode())
        opened.flush()
        yield


def _checksum(file: MachineFile) -> str:
    return file.content.checksum if file.content is not None else ""
