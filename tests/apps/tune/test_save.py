"""A kept feedforward is saved in non-volatile memory on command only, and removed by undo; files are known by their hashes."""

import json
import shutil
from pathlib import Path

import pytest
from tests.apps.tune.bench import Bench, drawn
from tests.apps.tune.conftest import OPTIONS, SEED, begun, killed
from tests.apps.tune.machine import BenchMachine

from bristle.apps.tune import MachineRefusedError, save, tune, undo
from bristle.apps.tune.journal import NAME, Journal
from bristle.apps.tune.report import sentences_of
from bristle.core import InputError

EMPTY = {"guard": None, "model": None, "gain": 0.0}


class SavingBench(BenchMachine):
    """The bench with non-volatile memory: a file, from which a restart reads."""

    loads = "The controller reads stored.json."

    def __init__(self, folder):
        super().__init__(Bench(drawn(SEED)[0], SEED), memory=folder / "memory.json")
        self.stored, self.folder = folder / "stored.json", folder

    def saved(self):
        return {"stored": self.stored.read_text() if self.stored.exists() else ""}

    def save(self, folder):
        assert folder == self.folder / "out/refined"
        self.journal = [entry["event"] for entry in Journal(self.folder / "out").entries]
        assert not self.stored.exists()
        self.stored.write_text(json.dumps(self._written))
        return {"stored": json.dumps(self._written)}

    def unsave(self):
        self.stored.unlink(missing_ok=True)

    def restarted(self):
        """Return the machine behind a restart of its controller."""
        self.memory.write_text(
            self.stored.read_text() if self.stored.exists() else json.dumps(EMPTY)
        )
        return SavingBench(self.folder)


@pytest.fixture
def kept(finished, tmp_path):
    """Return a folder with a run that was kept, on a machine that is as the run left it."""
    assert finished[2].facts["refinement"]["results"] == "refined"
    shutil.copytree(finished[1] / "out", tmp_path / "out")
    shutil.copy(finished[1] / "memory.json", tmp_path)
    return tmp_path


def test_a_kept_feedforward_is_saved_and_removed_by_undo(kept):
    machine, state = SavingBench(kept), SavingBench(kept).state()
    result = save(kept / "out", machine=machine)
    assert machine.journal[-2:] == ["kept", "saving"]
    assert result.outcome == "saved"
    assert result.facts["save"]["places"] == {"stored": machine.stored.read_text()}
    entries = Journal(kept / "out").entries
    assert [(entry["event"], entry["places"]) for entry in entries[-2:]] == [
        ("saving", {"stored": ""}),
        ("saved", machine.saved()),
    ]
    assert sentences_of(result)[:2] == [
        "Saved, and read back: stored.",
        "The controller reads stored.json.",
    ]
    assert (
        sentences_of(result)[-1]
        == f"The machine has the feedforward. Undo: bristle tune --undo {kept / 'out'}"
    )
    again = machine.restarted()
    assert again.state() == state
    assert undo(kept / "out", machine=again).outcome == "undone"
    assert not again.stored.exists()
    assert again.restarted().state() == EMPTY
    assert Journal(kept / "out").entries[-1]["event"] == "removed"


def test_a_run_of_an_earlier_version_has_one_model(kept):
    machine, folders = SavingBench(kept), []
    Journal(kept / "out").write("verdict", "kept", state=dict(machine.state()))
    machine.save = lambda folder: (
        folders.append(folder) or (machine.stored.write_text("{}") and machine.saved())
    )
    assert save(kept / "out", machine=machine).outcome == "saved"
    assert folders == [kept / "out/results"]


def another(kept):
    machine = SavingBench(kept)
    machine.bench.seed = 99
    return machine


def with_another_model(kept):
    changed_byte(kept / "out/refined/model.toml")
    return SavingBench(kept)


@pytest.mark.parametrize(
    ("machine", "words", "code"),
    [
        (
            lambda kept: SavingBench(kept).restarted(),
            r"not as the run left it: state: guard, state: model, state: gain\..*--undo",
            "state_changed",
        ),
        (another, "not as the run left it: identity: bench", "state_changed"),
        (
            with_another_model,
            r"refined/model\.toml differs from its hash in the journal",
            "file_changed",
        ),
        (
            lambda kept: BenchMachine(Bench(drawn(SEED)[0], SEED), memory=kept / "memory.json"),
            r"bench\.py has no non-volatile memory\. .*run bristle tune again",
            "no_memory",
        ),
    ],
    ids=["restarted", "another", "another model", "without memory"],
)
def test_a_machine_that_is_not_as_the_run_left_it_is_refused(kept, machine, words, code):
    with pytest.raises(MachineRefusedError, match=words) as refused:
        save(kept / "out", machine=machine(kept))
    assert (refused.value.code, (kept / "stored.json").exists()) == (code, False)


@pytest.mark.parametrize("event", ["", "restored"])
def test_a_run_that_kept_nothing_is_refused(finished, kept, tmp_path_factory, event):
    folder = kept
    if event:
        Journal(folder / "out").write("restore", event)
    else:
        folder = tmp_path_factory.mktemp("begun")
        begun(finished[1], folder)
    machine = SavingBench(folder)
    with pytest.raises(MachineRefusedError) as refused:
        save(folder / "out", machine=machine)
    assert (refused.value.code, machine.stored.exists()) == ("not_kept", False)


@pytest.mark.parametrize("content", ["", "something else"])
def test_a_memory_that_reads_back_otherwise_is_refused_and_removed_by_undo(kept, content):
    class Faulty(SavingBench):
        def saved(self):
            return {"stored": content if self.stored.exists() else ""}

    with pytest.raises(
        MachineRefusedError, match="memory differs from what was written: stored"
    ) as refused:
        save(kept / "out", machine=Faulty(kept))
    assert refused.value.code == "not_saved"
    machine = SavingBench(kept)
    undo(kept / "out", machine=machine)
    assert not machine.stored.exists()


def test_a_memory_that_contains_nothing_is_refused(kept):
    class Empty(SavingBench):
        def save(self, folder):
            return {"stored": ""}

    with pytest.raises(MachineRefusedError, match="memory differs from what was written: stored"):
        save(kept / "out", machine=Empty(kept))


@pytest.mark.parametrize("behind", [1, 2])
def test_an_interrupted_save_is_removed_by_undo(kept, behind):
    entry = len(Journal(kept / "out").entries) - 1 + behind
    assert killed(entry, lambda: save(kept / "out", machine=SavingBench(kept)))
    machine = SavingBench(kept)
    undo(kept / "out", machine=machine)
    assert (machine.stored.exists(), machine.state()) == (False, EMPTY)


def test_a_memory_that_keeps_the_feedforward_is_named_and_blocks_the_next_run(kept):
    class Stuck(SavingBench):
        def unsave(self):
            pass

    save(kept / "out", machine=SavingBench(kept))
    machine = Stuck(kept)
    with pytest.raises(
        MachineRefusedError, match="memory still contains the feedforward: stored"
    ) as refused:
        undo(kept / "out", machine=machine)
    assert (refused.value.code, machine.state()) == ("not_removed", EMPTY)
    file = Journal(kept / "out").last("begun")["file"]
    with pytest.raises(InputError, match=r"finished run.*--undo"):
        tune(file, kept / "out", move=True, machine=machine, options=OPTIONS)
    undo(kept / "out", machine=SavingBench(kept))
    assert not machine.stored.exists()


def changed_byte(path: Path) -> None:
    content = bytearray(path.read_bytes())
    digit = max(place for place, byte in enumerate(content) if byte in b"12345678")
    content[digit] += 1
    path.write_bytes(bytes(content))


FILES = {
    "before": "records/before.csv",
    "excitation": "records/excitation.csv",
    "identification": "results/model.toml",
}


def test_a_record_that_was_changed_is_refused_before_anything_moves(finished, tmp_path):
    make, folder = begun(finished[1], tmp_path, "before")
    changed_byte(folder / "out" / FILES["before"])
    machine = make()
    with pytest.raises(InputError, match=r"files that were changed: records/before\.csv"):
        tune(folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS)
    assert machine.records == []


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("step", "change"), [("excitation", Path.unlink), ("identification", changed_byte)]
)
def test_a_file_that_was_changed_is_not_used_by_a_run_that_goes_on(
    finished, tmp_path, step, change
):
    make, folder = begun(finished[1], tmp_path, step)
    change(folder / "out" / FILES[step])
    machine = make()
    result = tune(
        folder / "machine.toml", folder / "out", move=True, machine=machine, options=OPTIONS
    )
    assert (result.outcome, result.code, result.restored) == ("restored", "file_changed", True)
    assert result.reason.startswith(f"{FILES[step]} differs from its hash in the journal")
    assert machine.state() == EMPTY


def test_each_record_has_its_hash_in_the_journal(finished):
    names = {
        entry["name"] for entry in Journal(finished[1] / "out").entries if entry["event"] == "file"
    }
    records = {f"records/{path.name}" for path in (finished[1] / "out/records").iterdir()}
    assert names == records | {"results/model.toml", "refined/model.toml"}


def test_the_journal_of_a_saved_run_is_chained(kept):
    save(kept / "out", machine=SavingBench(kept))
    lines = (kept / "out" / NAME).read_text()
    assert lines.count('"event": "saving"') == 1
    (kept / "out" / NAME).write_text(lines.replace('"event": "saving"', '"event": "sawing"'))
    with pytest.raises(InputError, match="was changed"):
        undo(kept / "out", machine=SavingBench(kept))
