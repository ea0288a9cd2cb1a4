"""The journal of a run: chained lines, a killed writer, a changed line."""

import json

import pytest

from bristle.apps.tune.journal import NAME, Journal
from bristle.core import InputError


@pytest.fixture
def journal(tmp_path):
    journal = Journal(tmp_path)
    for number in range(3):
        journal.write("check", "write", value=number)
    return journal


def test_entries_are_read_again_in_order(journal, tmp_path):
    assert [entry["value"] for entry in Journal(tmp_path).entries] == [0, 1, 2]


def test_a_line_that_a_kill_left_incomplete_is_skipped_and_the_chain_goes_on(journal, tmp_path):
    with (tmp_path / NAME).open("ab") as file:
        file.write(b'{"n": 3, "step": "ch')
    Journal(tmp_path).write("check", "done", value=9)
    assert [entry["value"] for entry in Journal(tmp_path).entries] == [0, 1, 2, 9]


def test_a_write_that_the_operator_interrupts_does_not_break_the_chain(journal, tmp_path):
    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bristle.apps.tune.journal.os.fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            journal.write("check", "write", value=3)
    journal.write("check", "restored", value=4)
    assert [entry["value"] for entry in Journal(tmp_path).entries] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("changed", [0, 1])
def test_a_changed_entry_is_refused_with_its_line(journal, tmp_path, changed):
    lines = (tmp_path / NAME).read_text().splitlines()
    lines[changed] = json.dumps(json.loads(lines[changed]) | {"value": 7})
    (tmp_path / NAME).write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=f"line {changed + 2}: was changed"):
        Journal(tmp_path)


def test_a_removed_entry_is_refused(journal, tmp_path):
    lines = (tmp_path / NAME).read_text().splitlines(keepends=True)
    (tmp_path / NAME).write_text(lines[0] + lines[2])
    with pytest.raises(InputError, match="was changed"):
        Journal(tmp_path)


@pytest.mark.parametrize(
    ("events", "expected"),
    [(("write",), True), (("write", "restored"), False), (("write", "kept"), False), ((), False)],
)
def test_a_machine_may_differ_from_its_backup_after_a_write(tmp_path, events, expected):
    journal = Journal(tmp_path)
    for event in events:
        journal.write("stages", event)
    assert Journal(tmp_path).has_written is expected
