"""A folder that is held open stays that folder, whatever its path leads to by now; links in it are not followed."""

import errno
import os
import sys
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from bristle.files import owned
from bristle.files.owned import NOTE, Folder, line_of, note_in, remove_own

pytestmark = pytest.mark.skipif(
    os.unlink not in os.supports_dir_fd, reason="this system cannot hold folders open"
)


@pytest.fixture
def exchanged(tmp_path):
    """A folder held open, in whose place there is by now another with a file of the same name."""
    ours, thesis = tmp_path / "results", tmp_path / "thesis"
    ours.mkdir()
    thesis.mkdir()
    (ours / "a.txt").write_text("ours")
    (thesis / "a.txt").write_text("years of work")
    with Folder(ours) as fixed:
        ours.rename(tmp_path / "elsewhere")
        thesis.rename(ours)
        yield fixed, tmp_path


def test_reading_listing_and_removal_act_on_the_opened_folder(exchanged):
    fixed, place = exchanged
    (place / "results" / "b.txt").write_text("another")
    assert (fixed.names(), fixed.is_file("b.txt")) == (["a.txt"], False)
    with os.fdopen(fixed.open("a.txt")) as file:
        assert file.read() == "ours"
    fixed.remove("a.txt")
    assert (place / "results" / "a.txt").read_text() == "years of work"
    assert not (place / "elsewhere" / "a.txt").exists()


def test_a_link_is_no_folder(tmp_path):
    (tmp_path / "way").symlink_to(tmp_path)
    with pytest.raises(OSError), Folder(tmp_path / "way"):
        pass


def test_without_a_note_all_files_belong_to_the_user(tmp_path):
    (tmp_path / "thesis").mkdir()
    assert remove_own(tmp_path / "thesis", half_written=True) is False
    assert (tmp_path / "thesis").is_dir()


HEAD = {"bristle": "0.1.0", "folder": "00", "target": "run", "began": "1"}


def note_of(folder, head, *lines):
    (folder / NOTE).write_text("".join(map(line_of, (head, *lines))))
    with Folder(folder) as fixed:
        return note_in(fixed)


@pytest.mark.parametrize("key", HEAD)
def test_an_incomplete_note_is_invalid(tmp_path, key):
    assert note_of(tmp_path, HEAD) is not None
    wrong = [{name: value for name, value in HEAD.items() if name != key}]
    wrong += [HEAD | {key: 1}, HEAD | {key: [HEAD[key]]}] if key != "bristle" else []
    assert [note_of(tmp_path, head) for head in wrong] == [None] * len(wrong)


@pytest.mark.parametrize(
    "line",
    [{"file": 1}, {"file": "a", "sha256": 1}, {"file": "../a"}, {"file": NOTE}, {"sha256": ""}],
)
def test_a_note_with_a_foreign_line_is_invalid(tmp_path, line):
    assert note_of(tmp_path, HEAD, {"file": "a", "sha256": "00"}) is not None
    assert note_of(tmp_path, HEAD, {"file": "a"}, line) is None


@pytest.mark.parametrize("is_held", [False, True])
def test_windows_locks_a_byte_after_the_note_and_keeps_the_position(tmp_path, monkeypatch, is_held):
    requested = []

    def locking(opened, mode, count):
        requested.append((os.lseek(opened, 0, os.SEEK_CUR), mode, count))
        if is_held:
            raise OSError(errno.EACCES, "held")

    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(locking=locking, LK_NBLCK=2))
    (tmp_path / "note").write_bytes(b"0123456789")
    with (tmp_path / "note").open("r+b", buffering=0) as note:
        note.seek(4)
        with pytest.raises(BlockingIOError) if is_held else nullcontext():
            assert owned._lock_byte(note.fileno()) is True
        assert note.read(2) == b"45"
    ((place, mode, count),) = requested
    assert place > owned.LARGEST_NOTE  # where nobody reads
    assert (mode, count) == (2, 1)
