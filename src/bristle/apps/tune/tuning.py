"""`tune`: run the steps on a machine, keep the feedforward if it helps, and restore the machine in every other case."""

import contextlib
import hashlib
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from bristle.apps.tune.journal import NAME, Journal
from bristle.apps.tune.machine import Machine, MachineRefusedError, SavingMachine, State
from bristle.apps.tune.machines import Connection, code_of, connected
from bristle.apps.tune.report import last_line
from bristle.apps.tune.restoring import answering, differences, named, plain, restored
from bristle.apps.tune.run import MODEL, REFINED, RESULTS, Options, Run, Tuning, noted
from bristle.apps.tune.steps import GAINS, ORDER, RUN_IN, STAGE_CYCLES, STEPS, Step, cycles_compared
from bristle.core import InputError, InputWarning, Progress, guarded
from bristle.files import (
    MachineFile,
    as_json,
    growing_folder,
    lock,
    provenance,
    read_machine,
    state_folder,
)
from bristle.identification import models_of

SUMMARY, REPORT = "summary.json", "report.html"
KIND = "run of tune"
COMPUTES = 5.0  # weight of a step without motion, for the remaining time [s]
ADDRESS = ("net_id", "url", "prefix")  # settings that identify a controller
# Steps that write on the machine.
WRITING = ("check", "stages", "refinement", "comparison", "verdict")


@guarded()
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
    described, options = (
        file if isinstance(file, MachineFile) else read_machine(file),
        options or Options(),
    )
    models_of(options.models)
    if machine is not None and not callable(getattr(machine, "writes", None)):
        raise InputError(
            "must be a machine",
            path="machine",
            value=machine,
            mend="Give an object with the methods of bristle.apps.tune.Machine",
        )
    path = Path(folder).absolute()
    link = Connection(
        described.machine, described.settings, described.source.absolute(), described.axis.kind
    )
    with _only_run(link, path, notes=move), _held(machine, link, allow_code=allow_code) as used:
        journal = _resumable(path, described, options)
        if not move:
            return _plan(described, used, journal, options)
        if journal.has_written:
            _put_back(used, journal)
        with growing_folder(path, KIND, made_anew=_is_own, used=lambda name: not _is_own(name)) as (
            grown,
            _,
        ):
            grown.claim(NAME)
            run = Run(described, used, grown, journal, options, progress)
            return _reported(run, _steps(run, link))


def _is_own(name: str) -> bool:
    """Return whether a file is made anew by each run, or keeps its own list of files."""
    return name in (NAME, SUMMARY, REPORT) or name.partition("/")[0] in (RESULTS, REFINED)


def _resumable(path: Path, file: MachineFile, options: Options) -> Journal:
    """Return the journal in a folder; refuse another folder, and a run that was finished or begun with another request."""
    if os.path.lexists(path) and not path.is_dir():
        raise InputError("is a file, not a folder", path=str(path), mend="Name another folder")
    if path.exists() and any(path.iterdir()) and not os.path.lexists(path / NAME):
        raise InputError(
            "contains files that are not of a run of tune", path=str(path), mend="Name a new folder"
        )
    journal = Journal(path)
    _same_request(journal, file, options)
    if journal.is_kept:
        raise InputError(
            "is a finished run, whose feedforward the machine keeps",
            path=str(path),
            mend=f"Restore the machine first: bristle tune --undo {path}",
        )
    return journal


def _plan(described: MachineFile, used: Machine, journal: Journal, options: Options) -> Tuning:
    """Return the plan of a run; nothing is written, neither on the machine nor on the disk."""
    path = journal.path.parent
    with answering():
        facts = _planned(described, used, options)
    plan = Tuning(path, "planned", facts=facts, kind=described.axis.kind)
    if journal.has_written:
        plan.remarks.append(
            f"an interrupted run has left the machine changed. Restore it: bristle tune --undo {path}"
        )
    return plan


@guarded()
def undo(
    folder: str | os.PathLike[str], *, machine: Machine | None = None, allow_code: bool = False
) -> Tuning:
    """Restore the machine as it was before the run in a folder, also its non-volatile memory, and prove it by reading back.

    Raises
    ------
    MachineRefusedError
        If the journal contains no backup, or the machine does not read back as before.
    """
    with _reopened(folder, machine, allow_code=allow_code) as run, answering():
        result = Tuning(run.folder, "undone", kind=run.link.kind)
        backup = _backup_in(run.journal)
        if backup is None:
            reads = ", ".join(
                f"{name} {value}" for name, value in plain(run.machine.state()).items()
            )
            raise MachineRefusedError(
                "no_backup",
                f"the journal contains no backup of the machine, so bristle cannot restore it. The machine reads {reads}",
                "Compare these values with those before the run",
            )
        result.way_out = restored(run.machine, backup)
        _try_to_note(
            run.journal, result, "undo", "restored", cause="undo", **result.way_out.as_data()
        )
        if (
            not result.way_out.fault
            and run.journal.is_saved
            and isinstance(run.machine, SavingMachine)
        ):
            run.machine.unsave()
            left = [place for place, content in run.machine.saved().items() if content]
            if left:
                raise MachineRefusedError(
                    "not_removed", f"the memory still contains the feedforward: {', '.join(left)}"
                )
            _try_to_note(run.journal, result, "save", "removed")
        if not result.restored:
            raise MachineRefusedError("not_restored", last_line(result))
    return result


@guarded()
def save(
    folder: str | os.PathLike[str], *, machine: Machine | None = None, allow_code: bool = False
) -> Tuning:
    """Save the kept feedforward of the run in a folder in the non-volatile memory of its machine, and prove it by reading back.

    Raises
    ------
    MachineRefusedError
        If the machine has no such memory, the run was not kept, the machine changed since, or the memory does not read back as written.
    """
    with _reopened(folder, machine, allow_code=allow_code) as run, answering():
        journal, used = run.journal, run.machine
        if not isinstance(used, SavingMachine):
            raise MachineRefusedError(
                "no_memory",
                f"the machine {run.link.machine} has no non-volatile memory",
                "Its feedforward lasts until the controller restarts. Then run bristle tune again, or export the model: bristle export",
            )
        kept, identified = journal.last("kept"), journal.last("done", step="identity")
        if kept is None or identified is None or not journal.is_kept:
            raise MachineRefusedError(
                "not_kept",
                "this run did not keep a feedforward",
                "Save a run whose outcome is kept",
            )
        present = {"identity": dict(used.identity()), "state": dict(used.state())}
        different = differences(
            {"identity": identified["facts"]["identity"], "state": kept["state"]}, plain(present)
        )
        if different:
            raise MachineRefusedError(
                "state_changed",
                f"the machine is not as the run left it: {', '.join(different)}",
                f"Restore it, and tune again: bristle tune --undo {run.folder}",
            )
        results = kept.get("results", RESULTS)  # a run of an earlier version has one model
        noted(journal, f"{results}/{MODEL}")
        journal.write("save", "saving", places=dict(used.saved()))
        written, places = dict(used.save(run.folder / results)), dict(used.saved())
        if written != places or not all(places.values()):
            raise MachineRefusedError(
                "not_saved",
                f"the memory differs from what was written: {', '.join(places)}",
                f"Remove it: bristle tune --undo {run.folder}",
            )
        journal.write("save", "saved", places=places)
    return Tuning(
        run.folder, "saved", facts={"save": {"places": places, "loads": getattr(used, "loads", "")}}
    )


class _Reopened(NamedTuple):
    """An earlier run, and its machine, connected again."""

    folder: Path
    journal: Journal
    link: Connection
    machine: Machine


@contextlib.contextmanager
def _reopened(
    folder: str | os.PathLike[str], machine: Machine | None, *, allow_code: bool
) -> Iterator[_Reopened]:
    """Connect the machine of the run in a folder, as the run connected it; its machine file may be gone."""
    path = Path(folder).absolute()
    journal = Journal(path)
    begun = journal.last("begun")
    if begun is None:
        raise InputError("contains no run of tune", path=str(path), mend="Name the folder of a run")
    if "link" in begun:
        link = Connection(**begun["link"] | {"source": Path(begun["file"])})
    else:  # of an earlier version
        described = read_machine(begun["file"])
        link = Connection(
            described.machine, described.settings, described.source, described.axis.kind
        )
    allowed = allow_code or (begun.get("code", "") != "" and begun["code"] == code_of(link))
    with _only_run(link, path, notes=False), _held(machine, link, allow_code=allowed) as used:
        yield _Reopened(path, journal, link, used)


@contextlib.contextmanager
def _held(machine: Machine | None, link: Connection, *, allow_code: bool) -> Iterator[Machine]:
    """Connect a machine, and disconnect it in the end; whatever goes wrong then does not change how the run ended."""
    if machine is None:
        with answering():
            machine = connected(link, allow_code=allow_code)
    try:
        yield machine
    finally:
        try:
            machine.close()
        except BaseException as error:  # noqa: BLE001
            warnings.warn(
                f"the connection to the machine did not end well: {named(error)[1]}",
                InputWarning,
                stacklevel=3,
            )


def _steps(run: Run, link: Connection) -> Tuning:
    """Do the steps; restore the machine after whatever ends them."""
    result = Tuning(
        run.folder,
        "kept",
        facts=run.facts,
        kind=run.axis.kind,
        again=f"bristle tune {run.file.source} --out {run.folder} --move",
    )
    begun = {
        "file": str(link.source),
        "sha256": _checksum(run.file),
        "options": vars(run.options),
        "link": link.as_data(),
        "code": code_of(link),
    }
    try:
        for number, step in enumerate(STEPS):
            _do(run, step, number, begun)
    except BaseException as error:
        result.outcome, (result.code, result.reason) = "restored", named(error)
        if run.journal.has_written and run.backup is not None:
            result.way_out = restored(run.machine, run.backup)
        _try_to_note(
            run.journal, result, run.step, "stopped", code=result.code, reason=result.reason
        )
        if result.way_out is not None:
            _try_to_note(
                run.journal,
                result,
                run.step,
                "restored",
                cause=result.reason,
                **result.way_out.as_data(),
            )
        if not isinstance(error, Exception):
            error.args = (f"{result.reason}. {last_line(result)}",)
            raise
    return result


def _try_to_note(journal: Journal, result: Tuning, step: str, event: str, **facts: Any) -> None:
    """Write an entry; a journal that cannot be written is a remark."""
    try:
        journal.write(step, event, **facts)
    except Exception as error:  # noqa: BLE001  (the machine was restored; a full disk takes nothing from that)
        result.remarks.append(f"the journal has no entry {event!r}: {named(error)[1]}")


def _reported(run: Run, result: Tuning) -> Tuning:
    """Write summary and report; one that cannot be written is a remark."""
    from bristle.apps.tune.report import tune_report

    command = f"bristle tune {run.file.source.name} --out {run.folder.name} --move"
    try:
        source = provenance(command, machine=run.file.content)
        run.grown.write(REPORT, tune_report(run, result, command=command, provenance=source))
        run.grown.write(SUMMARY, as_json(result.as_data() | {"provenance": source}))
    except Exception as error:  # noqa: BLE001
        result.remarks.append(f"the report was not written: {named(error)[1]}")
    except BaseException as error:
        error.args = (f"{named(error)[1]}. {last_line(result)}",)
        raise
    return result


def _do(run: Run, step: Step, number: int, begun: State) -> None:
    """Do a step, or take its facts from the journal if an interrupted run finished it."""
    run.step = step.name
    entry = run.journal.last("done", step=step.name)
    if step.resumes and entry is not None:
        run.facts[step.name] = entry["facts"]
        return
    run.journal.write(step.name, "begun", **begun)
    inner = run.progress
    if inner is not None:
        planned = [
            facts["seconds"] or COMPUTES
            for facts in _planned(run.file, run.machine, run.options).values()
        ]
        begin, share_of_step = sum(planned[:number]) / sum(planned), planned[number] / sum(planned)
        run.progress = lambda share, text: inner(
            begin + share * share_of_step, f"{step.title}: {text}" if text else step.title
        )
        run.played, run.planned = 0.0, planned[number]
        run.progress(0.0, "")
    try:
        step.act(run)
    finally:
        run.progress = inner


def _backup_in(journal: Journal) -> State | None:
    """Return the backup of the machine in a journal."""
    entry = journal.last("done", step="backup")
    return None if entry is None else entry["facts"]["state"]


def _put_back(machine: Machine, journal: Journal) -> None:
    """Restore the machine behind an interrupted run; refuse to go on if it does not read back as before."""
    backup, result = _backup_in(journal), Tuning(journal.path.parent, "restored")
    if backup is None:
        raise InputError("contains no backup", path=str(journal.path), mend="Name a new folder")
    result.way_out = restored(machine, backup)
    _try_to_note(
        journal,
        result,
        "restore",
        "restored",
        cause="a run that was interrupted",
        **result.way_out.as_data(),
    )
    if not result.restored:
        raise MachineRefusedError("not_restored", last_line(result))


def _same_request(journal: Journal, file: MachineFile, options: Options) -> None:
    """Refuse to resume a run with another machine file or other options."""
    begun = journal.last("begun")
    if begun is None:
        return
    mend = f"Name a new folder, or go on as begun. bristle tune --undo {journal.path.parent} restores the machine"
    if begun["sha256"] != _checksum(file):
        raise InputError("changed since the run began", path=str(file.source), mend=mend)
    for name, value in vars(options).items():
        if begun["options"][name] != value:
            raise InputError(
                "differs from the run in this folder",
                path=name,
                value=value,
                allowed=str(begun["options"][name]),
                mend=mend,
            )


def _planned(file: MachineFile, machine: Machine, options: Options) -> dict[str, dict[str, Any]]:
    """Return each step with its moves and writes, without touching the machine."""
    writes, sample_time = machine.writes(), machine.sample_time
    cycle = file.cycle.size * sample_time
    seconds = {
        "check": 8.0,
        "warm_up": 4 * cycle,
        "before": file.cycles * cycle,
        "excitation": options.duration,
        "stages": len(GAINS) * STAGE_CYCLES * cycle,
    }
    seconds |= {
        "refinement": seconds["excitation"] + STAGE_CYCLES * cycle + seconds["stages"],
        "comparison": len(ORDER) * (cycles_compared(file.cycles) + RUN_IN) * cycle,
    }
    low, high = float(file.cycle.min()), float(file.cycle.max())
    stroke = file.axis.stroke
    travel = dict.fromkeys(seconds, (low, high)) | {
        "check": (low, low),
        "excitation": stroke,
        "refinement": stroke,
    }
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
def _only_run(file: Connection | MachineFile, folder: Path, *, notes: bool) -> Iterator[None]:
    """Hold the lock of a machine, which names the folder of its run; refuse a second run.

    A lock is made and written for a run only: a plan writes nothing, and a full disk does not stop an undo.
    """
    # A computer has one HAL; a controller is known by its address, a simulated or own machine by its file.
    address = [file.settings[key] for key in ADDRESS if key in file.settings] or [
        file.source.absolute()
    ]
    own = ["linuxcnc"] if file.machine == "linuxcnc" else address
    key = hashlib.sha256(" ".join(map(str, (file.machine, *own))).encode()).hexdigest()[:16]
    opened = _lock_file(key, notes=notes)
    if opened is None:
        yield
        return
    with opened:
        try:
            lock(opened.fileno())
        except BlockingIOError:
            raise InputError(
                "is used by another run of bristle tune",
                path=str(file.source),
                mend="Wait until it ends, or end it",
            ) from None
        opened.seek(0)
        earlier = Path(opened.read().decode(errors="replace").strip() or folder)
        journal = Journal(earlier) if earlier != folder and (earlier / NAME).exists() else None
        if journal is not None and (journal.has_written or journal.is_kept):
            reason = (
                "was left by an interrupted run"
                if journal.has_written
                else "keeps the feedforward of a run"
            )
            raise InputError(
                f"{reason} in another folder",
                path=str(file.source),
                value=str(earlier),
                mend=f"Restore the machine first: bristle tune --undo {earlier}",
            )
        if notes:
            with answering():
                opened.truncate(0)
                opened.write(str(folder).encode())
                opened.flush()
        yield


def _lock_file(key: str, *, notes: bool) -> BinaryIO | None:
    """Open the lock of a machine, None if there is none and this is no run."""
    try:
        return (state_folder("tune", makes=notes) / f"{key}.lock").open("a+b" if notes else "rb")
    except OSError as error:
        if not notes:
            return None
        reason = f"cannot be written: {(error.strerror or str(error)).lower()}"
        raise InputError(
            reason,
            path=str(error.filename),
            mend="Set BRISTLE_STATE_DIR to a folder in which you may write",
        ) from None


def _checksum(file: MachineFile) -> str:
    return file.content.checksum if file.content is not None else ""
