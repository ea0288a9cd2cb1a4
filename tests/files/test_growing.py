"""A folder that grows: what is in it, what is damaged, and that files are on the disk before they appear."""

import json
import os

import pytest

from bristle.core.errors import InputError, InputWarning
from bristle.files.growing import growing_folder, verified
from bristle.files.owned import NOTE


@pytest.fixture
def out(tmp_path):
    """A folder with two files that were written."""
    with growing_folder(tmp_path / "out", "study") as (grown, damaged):
        assert damaged == []
        grown.write("a.csv", "1,2\n")
        grown.make("runs")
        grown.write("runs/b.csv", b"3,4\n")
    return tmp_path / "out"


def test_files_survive_a_round_trip(out):
    with growing_folder(out, "study") as (grown, damaged):
        assert (damaged, grown.path, grown / "a.csv", sorted(grown.names)) == (
            [],
            out,
            out / "a.csv",
            ["a.csv", "runs/b.csv"],
        )
        assert (grown.read("a.csv"), grown.read("runs/b.csv"), grown.read("c.csv")) == (
            b"1,2\n",
            b"3,4\n",
            None,
        )
        assert (grown.is_whole("a.csv"), grown.is_whole("c.csv")) == (True, False)
        held = (("a.csv", "1,2\n"), ("a.csv", "1,3\n"), ("c.csv", "1,2\n"))
        assert [grown.has_held(name, text) for name, text in held] == [True, False, False]


def test_a_rewritten_file_records_both_contents(out):
    with growing_folder(out, "study") as (grown, _):
        assert grown.write("a.csv", "5\n") == out / "a.csv"
        assert (out / "a.csv").read_bytes() == grown.read("a.csv") == b"5\n"
        assert [grown.has_held("a.csv", text) for text in ("1,2\n", "5\n")] == [True, True]


def test_a_file_that_was_changed_is_neither_read_nor_replaced_nor_removed(out):
    with growing_folder(out, "study") as (grown, _):
        (out / "a.csv").write_text("of a person")
        assert (grown.read("a.csv"), grown.is_whole("a.csv")) == (None, False)
        with pytest.raises(InputError, match="was changed, or was not written by bristle"):
            grown.write("a.csv", "1,2\n")
        for name in ("a.csv", "runs/b.csv"):
            grown.remove(name)
        assert ((out / "a.csv").read_text(), (out / "runs/b.csv").exists()) == (
            "of a person",
            False,
        )
        assert grown.names == ["a.csv"]


def test_a_path_to_another_place_is_refused(out):
    with (
        growing_folder(out, "study") as (grown, _),
        pytest.raises(ValueError, match="is not the name of a file"),
    ):
        grown.write("../a.csv", "x")


def test_damaged_files_are_reported_and_kept(out):
    (out / "a.csv").write_text("dama")
    refused(out, r"contains files that were changed: a\.csv")
    with growing_folder(out, "study", made_anew=lambda name: name == "a.csv") as (grown, damaged):
        assert damaged == ["a.csv"]
        for kept in ("a.csv.damaged", "a.csv.damaged-2"):
            (out / "a.csv").write_text("dama")
            with pytest.warns(
                InputWarning,
                match=rf"/a\.csv is damaged, .*: bristle keeps it as {kept}, and writes the file again$",
            ):
                grown.set_all_aside(["a.csv"])
            assert (out / kept).read_text() == "dama"
        grown.write("a.csv", "1,2\n")
    with growing_folder(out, "study") as (grown, damaged):
        assert damaged == []


def test_all_of_a_file_is_on_the_disk_before_its_name_is_there(out, monkeypatch):
    synced, fsync = [], os.fsync

    def noting(opened):
        here = os.fstat(opened).st_ino
        names = {file.stat().st_ino: file.name for file in out.rglob("*")}
        synced.append(names.get(here, "folder"))
        fsync(opened)

    monkeypatch.setattr(os, "fsync", noting)
    with growing_folder(out, "study") as (grown, _):
        synced.clear()
        grown.write("c.csv", "x" * 1000)
    assert [name.rpartition(".")[2] for name in synced[:1]] + synced[1:] == [
        "partial",
        NOTE,
        "folder",
    ]


def test_a_failed_write_leaves_no_incomplete_file(out, monkeypatch):
    with growing_folder(out, "study") as (grown, _):
        before = {file.name for file in out.iterdir()}

        def full(opened):
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(
                InputError, match=r"cannot be written: no space left on device.*Make room"
            ):
                grown.write("c.csv", "x")
        assert {file.name for file in out.iterdir()} == before


def test_incomplete_files_of_killed_processes_are_removed(out):
    *lines, last = (out / NOTE).read_text().splitlines(keepends=True)
    partial = json.loads(lines[-1])["file"]
    assert (partial.rpartition(".")[2], json.loads(last)["file"]) == ("partial", "runs/b.csv")
    (out / NOTE).write_text("".join(lines))  # killed before the file got its name
    (out / "runs" / "b.csv").unlink()
    (out / partial).write_text("3,")
    with growing_folder(out, "study") as (grown, damaged):
        assert ((out / partial).exists(), damaged, grown.names) == (False, [], ["a.csv"])
        grown.write("runs/b.csv", b"3,4\n")
    assert (out / "runs" / "b.csv").read_text() == "3,4\n"


def refused(place, words, kind="study"):
    """Ask for a folder that must be refused."""
    with pytest.raises(InputError, match=words), growing_folder(place, kind):
        pytest.fail("the work must not begin")


def test_a_folder_of_another_kind_of_a_person_or_of_another_process_is_refused(out, tmp_path):
    refused(out, "contains a study, not a fleet", "fleet")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    refused(tmp_path / "mine", r"is not a folder of a study, but contains notes\.txt")
    refused(tmp_path / "mine/notes.txt", "is a file, not a folder")
    with growing_folder(out, "study"):
        refused(out, r"another process.*is writing to this folder")


def test_user_files_that_would_be_used_are_refused(out):
    (out / "runs/mine.csv").write_text("mine")
    refused(out, r"contains files that bristle did not write: runs/mine\.csv")
    with growing_folder(out, "study", used=lambda name: name != "runs/mine.csv") as (_, damaged):
        assert damaged == []


def test_files_are_verified_by_their_content(out):
    verified(out, ["a.csv", "runs/b.csv"])
    (out / "a.csv").write_text("dama")
    verified(out, ["runs/b.csv"])
    with pytest.raises(
        InputError, match=r"contains files that are damaged or were not written here: a\.csv"
    ):
        verified(out, ["a.csv", "runs/b.csv"])
