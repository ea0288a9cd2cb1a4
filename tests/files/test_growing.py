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
        assert damaged == []
        assert grown.path == out
        assert grown / "a.csv" == out / "a.csv"
        assert sorted(grown.names) == ["a.csv", "runs/b.csv"]
        assert (grown.read("a.csv"), grown.read("runs/b.csv"), grown.read("c.csv")) == (b"1,2\n", b"3,4\n", None)
        assert grown.is_whole("a.csv")
        assert not grown.is_whole("c.csv")
        assert grown.has_held("a.csv", "1,2\n")
        assert not grown.has_held("a.csv", "1,3\n")
        assert not grown.has_held("c.csv", "1,2\n")


def test_a_rewritten_file_records_both_contents(out):
    with growing_folder(out, "study") as (grown, _):
        assert grown.write("a.csv", "5\n") == out / "a.csv"
        assert (out / "a.csv").read_text() == "5\n"
        assert grown.has_held("a.csv", "1,2\n")
        assert grown.has_held("a.csv", "5\n")
        assert grown.read("a.csv") == b"5\n"


def test_a_file_that_was_changed_is_neither_read_nor_replaced_nor_removed(out):
    with growing_folder(out, "study") as (grown, _):
        (out / "a.csv").write_text("of a person")
        assert grown.read("a.csv") is None
        assert not grown.is_whole("a.csv")
        with pytest.raises(InputError, match="was changed, or was not written by bristle"):
            grown.write("a.csv", "1,2\n")
        grown.remove("a.csv")
        assert (out / "a.csv").read_text() == "of a person"
        grown.remove("runs/b.csv")
        assert not (out / "runs/b.csv").exists()
        assert grown.names == ["a.csv"]


def test_a_path_to_another_place_is_refused(out):
    with growing_folder(out, "study") as (grown, _), pytest.raises(ValueError, match="is not the name of a file"):
        grown.write("../a.csv", "x")


def test_damaged_files_are_reported_and_kept(out):
    (out / "a.csv").write_text("dama")
    with pytest.raises(InputError, match=r"contains files that were changed: a\.csv"), growing_folder(out, "study"):
        pass
    with growing_folder(out, "study", made_anew=lambda name: name == "a.csv") as (grown, damaged):
        assert damaged == ["a.csv"]
        for kept in ("a.csv.damaged", "a.csv.damaged-2"):
            (out / "a.csv").write_text("dama")
            with pytest.warns(InputWarning, match=rf"a\.csv is damaged: bristle writes it again and keeps the damaged file as {kept}$"):
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
    partial, note, folder = synced
    assert partial.endswith(".partial")
    assert (note, folder) == (NOTE, "folder")


def test_a_failed_write_leaves_no_incomplete_file(out, monkeypatch):
    with growing_folder(out, "study") as (grown, _):
        before = {file.name for file in out.iterdir()}

        def full(opened):
            raise OSError(28, "No space left on device")

        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(InputError, match=r"cannot be written: no space left on device.*Make room"):
                grown.write("c.csv", "x")
        assert {file.name for file in out.iterdir()} == before


def test_incomplete_files_of_killed_processes_are_removed(out):
    *lines, last = (out / NOTE).read_text().splitlines(keepends=True)
    partial = json.loads(lines[-1])["file"]
    assert partial.endswith(".partial")
    assert json.loads(last)["file"] == "runs/b.csv"
    (out / NOTE).write_text("".join(lines))  # killed before the file got its name
    (out / "runs" / "b.csv").unlink()
    (out / partial).write_text("3,")
    with growing_folder(out, "study") as (grown, damaged):
        assert not (out / partial).exists()
        assert damaged == []
        assert grown.names == ["a.csv"]
        grown.write("runs/b.csv", b"3,4\n")
    assert (out / "runs" / "b.csv").read_text() == "3,4\n"


def test_a_folder_of_another_kind_or_of_a_person_is_refused(out, tmp_path):
    with pytest.raises(InputError, match="contains a study, not a fleet"), growing_folder(out, "fleet"):
        pass
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    with (
        pytest.raises(InputError, match=r"is not a folder of a study, but contains notes\.txt"),
        growing_folder(tmp_path / "mine", "study"),
    ):
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file, not a folder"), growing_folder(tmp_path / "file", "study"):
        pass


def test_user_files_that_would_be_used_are_refused(out):
    (out / "runs/mine.csv").write_text("mine")
    with pytest.raises(InputError, match=r"contains files that bristle did not write: runs/mine\.csv"), growing_folder(out, "study"):
        pass
    with growing_folder(out, "study", used=lambda name: name != "runs/mine.csv") as (_, damaged):
        assert damaged == []


def test_a_process_writes_alone(out):
    with (
        growing_folder(out, "study"),
        pytest.raises(InputError, match=r"another process.*is writing to this folder"),
        growing_folder(out, "study"),
    ):
        pass


def test_files_are_verified_by_their_content(out):
    verified(out, ["a.csv", "runs/b.csv"])
    (out / "a.csv").write_text("dama")
    verified(out, ["runs/b.csv"])
    with pytest.raises(InputError, match=r"contains files that are damaged or were not written here: a\.csv"):
        verified(out, ["a.csv", "runs/b.csv"])
    (out / "runs/b.csv").write_text("dama")
    with pytest.raises(InputError, match="are damaged or were not written here"):
        verified(out, ["a.csv", "runs/b.csv"])
