"""Whatever ends a run, the machine is restored or named as not restored, and the last line says so."""

import os

import pytest
from tests.apps.tune.faults import (
    DISK,
    FAULTS,
    INITIAL,
    Faulty,
    Small,
    small_files,
    with_faulty_journal,
    with_short_steps,
)

from bristle.apps.tune.journal import NAME, Journal
from bristle.apps.tune.restoring import restored
from bristle.cli.main import main

ENDS = {0, 1, 2, 143}


class Axis:
    """A folder with the files of a machine, and runs of the command line on it."""

    def __init__(self, folder, patch):
        self.folder, self.patch, self.memory = folder, patch, folder / "memory.json"
        small_files(folder)
        self.patch.setenv("BRISTLE_STATE_DIR", str(folder / "state"))
        self.patch.chdir(folder)

    def runs(self, capsys, machine, *words):
        """Run the command line on a machine; return its exit code and what it says, in one line."""
        self.patch.setattr("bristle.apps.tune.tuning.connected", lambda link, allow_code: machine)
        code = main(["tune", *words])
        said = capsys.readouterr()
        return code, " ".join((said.out + said.err if code >= 2 else said.out).split())

    def state(self):
        return Small(self.memory).state()


RUN = ("machine.toml", "--out", "out", "--move", "--quiet")


def calls_of_a_run(folder, patch, capsys):
    """Return the calls of the machine and the writes of the journal of a run without a fault."""
    folder.mkdir()
    axis = Axis(folder, patch)
    machine, writes = Faulty(axis.memory), with_faulty_journal(patch, None, -2)
    code, line = axis.runs(capsys, machine, *RUN)
    assert code == 0
    assert line.endswith(
        f"The machine has the feedforward. Undo: bristle tune --undo {folder / 'out'}"
    )
    assert axis.state()["gain"] == 1.0
    return machine.count, writes.count


def failing(axis, capsys, machine):
    """Run into a fault, and return what is wrong about its end; empty if nothing is."""
    code, line = axis.runs(capsys, machine, *RUN)
    state, undo = axis.state(), f"bristle tune --undo {axis.folder / 'out'}"
    if code not in ENDS:
        return f"exit {code}: {line}"
    if (
        code == 0
        and state["gain"] == 1.0
        and line.endswith(f"The machine has the feedforward. Undo: {undo}")
    ):
        return ""
    again = f"bristle tune machine.toml --out {axis.folder / 'out'} --move"
    states = ("The machine reads back as before the run.", "The run wrote nothing on the machine.")
    if state == INITIAL and (
        line.endswith(tuple(f"{state} Run again: {again}" for state in states)) or code == 2
    ):
        return ""
    if "NOT RESTORED" in line and line.endswith(undo):
        after, told = axis.runs(capsys, Small(axis.memory), "--undo", "out")
        fine = (after, axis.state()) == (0, INITIAL) and "reads back as before" in told
        return "" if fine else f"undo: exit {after}, {axis.state()}: {told}"
    return f"exit {code}, {state}: {line}"


def dying(axis, capsys, machine):
    """Run into a kill in another process, and return what is wrong behind the command that follows; empty if nothing is."""
    child = os.fork()
    if child == 0:
        try:
            axis.runs(capsys, machine, *RUN)
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    if not (axis.folder / "out" / NAME).exists():
        return "" if axis.state() == INITIAL else f"no journal, {axis.state()}"
    code, line = axis.runs(capsys, Small(axis.memory), "--undo", "out")
    if axis.state() != INITIAL or code not in ENDS:
        return f"undo: exit {code}, {axis.state()}: {line}"
    has_backup = any(
        entry["step"] == "backup" and entry["event"] == "done"
        for entry in Journal(axis.folder / "out").entries
    )
    return (
        ""
        if ("reads back as before" in line) == has_backup
        else f"undo with backup {has_backup}: {line}"
    )


def wrong(folder, capsys, name, make):
    """Return what is wrong behind one fault."""
    folder.mkdir()
    with pytest.MonkeyPatch.context() as patch:
        with_short_steps(patch)
        axis = Axis(folder, patch)
        machine = make(axis, patch)
        return (dying if name == "killed" else failing)(axis, capsys, machine)


def at_a_call(name, number, *, behind):
    return lambda axis, patch: Faulty(axis.memory, FAULTS[name], number, behind=behind)


def at_a_write(name, number):
    def make(axis, patch):
        with_faulty_journal(patch, DISK[name], number)
        return Faulty(axis.memory)

    return make


@pytest.fixture(scope="module")
def size(tmp_path_factory):
    """How many calls of the machine and writes of the journal a run has."""
    return {}


@pytest.fixture
def counted(tmp_path, capsys, size):
    if not size:
        with pytest.MonkeyPatch.context() as patch:
            with_short_steps(patch)
            size["calls"], size["writes"] = calls_of_a_run(tmp_path / "clean", patch, capsys)
    return size


@pytest.mark.parametrize(("failures", "identical"), [(2, True), (3, False)])
def test_a_restoration_has_three_attempts_and_a_signal_ends_one(
    tmp_path, monkeypatch, failures, identical
):
    machine, faults = (
        Small(tmp_path / "memory.json"),
        [ConnectionResetError("gone"), KeyboardInterrupt(), ValueError()][:failures],
    )
    machine.set(gain=0.5)
    monkeypatch.setattr(
        machine,
        "state",
        lambda: Small.state(machine) if not faults else (_ for _ in ()).throw(faults.pop()),
    )
    found = restored(machine, INITIAL)
    assert (found.is_identical, Small.state(machine)) == (identical, INITIAL)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_the_machine_restores_it(name, counted, tmp_path, capsys):
    number = counted["calls"] // 2
    assert wrong(tmp_path / "run", capsys, name, at_a_call(name, number, behind=True)) == ""


@pytest.mark.parametrize("name", DISK)
def test_a_fault_of_the_disk_restores_the_machine(name, counted, tmp_path, capsys):
    assert wrong(tmp_path / "run", capsys, name, at_a_write(name, counted["writes"])) == ""


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_no_fault_at_any_call_of_the_machine_leaves_it_armed(name, counted, tmp_path, capsys):
    """The fault is in front of every second call, and behind the others."""
    found = {}
    for number in range(counted["calls"]):
        found[number] = wrong(
            tmp_path / f"{number}", capsys, name, at_a_call(name, number, behind=number % 2 == 1)
        )
    assert {number: text for number, text in found.items() if text} == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", DISK)
def test_no_fault_at_any_write_of_the_journal_leaves_the_machine_armed(
    name, counted, tmp_path, capsys
):
    """Half of its line is on the disk at every second write, and all of it at the others."""
    numbers = [2 * number + number % 2 for number in range(counted["writes"])]
    found = {
        number: wrong(tmp_path / f"{number}", capsys, name, at_a_write(name, number))
        for number in numbers
    }
    assert {number: text for number, text in found.items() if text} == {}
