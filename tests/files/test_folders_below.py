"""Results in a folder below appear and go with all others; what a person put there is kept, and no link is followed."""

import os

import pytest

from bristle.core import InputError
from bristle.files.owned import NOTE, Folder, note_in, remove_own, strangers_in
from bristle.files.results import results_folder


def write_results(out, mark, force=True):
    with results_folder(out, force=force) as folder:
        folder.write("summary.json", mark)
        for name in ("a", "b"):
            folder.write(f"figures/{name}.svg", mark)


@pytest.fixture
def out(tmp_path):
    write_results(tmp_path / "run", "old", force=False)
    return tmp_path / "run"


def held_by(out):
    return {
        str(item.relative_to(out)): item.read_text()
        for item in out.rglob("*")
        if item.is_file() and item.name != NOTE
    }


def test_they_appear_and_are_replaced_whole(out):
    assert held_by(out) == dict.fromkeys(("summary.json", "figures/a.svg", "figures/b.svg"), "old")
    with results_folder(out, force=True) as folder:
        folder.write("figures/c.svg", "new")
    assert held_by(out) == {"figures/c.svg": "new"}
    with results_folder(out, force=True) as folder:
        folder.write("summary.json", "newer")
    assert sorted(item.name for item in out.iterdir()) == [NOTE, "summary.json"]
    assert [item.name for item in out.parent.iterdir()] == ["run"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("figures/mine.svg", "besides the results: figures"),
        ("figures/deep/mine.svg", "besides the results: figures/deep"),
        ("drawings/mine.svg", "besides the results: drawings"),
        ("figures/a.svg", "were changed: figures/a.svg"),
    ],
)
def test_added_and_changed_files_are_not_replaced(out, name, words):
    (out / name).parent.mkdir(exist_ok=True)
    (out / name).write_text("mine")
    before = held_by(out)
    with pytest.raises(InputError, match=words):
        write_results(out, "new")
    assert held_by(out) == before


@pytest.mark.parametrize("what", ["link", "file"])
def test_a_user_file_in_place_of_the_folder_is_kept(out, what, tmp_path):
    (out / "figures").rename(tmp_path / "moved")
    if what == "link":
        (out / "figures").symlink_to(tmp_path / "moved")
    else:
        (out / "figures").write_text("mine")
    with pytest.raises(InputError, match="besides the results: figures"):
        write_results(out, "new")
    assert remove_own(out) is False
    # Behind the link lie the very files that the note names: they are not in the folder.
    assert sorted(item.name for item in (tmp_path / "moved").iterdir()) == ["a.svg", "b.svg"]
    assert (out / "figures").exists()


def test_input_files_are_not_replaced(out):
    reads = [out / "figures" / "a.svg"]
    with (
        pytest.raises(InputError, match="contains input files of this command: figures"),
        results_folder(out, force=True, reads=reads),
    ):
        pytest.fail("the work must not begin")


def fail_in(out, *added):
    with results_folder(out) as folder:
        folder.write("figures/a.svg", "half")
        for name in added:
            (folder.path / name).write_text("mine")
        raise ZeroDivisionError


def test_an_error_leaves_only_user_files(tmp_path):
    with pytest.raises(ZeroDivisionError):
        fail_in(tmp_path / "run")
    assert not any(tmp_path.iterdir())
    with pytest.warns(UserWarning, match="bristle keeps"), pytest.raises(ZeroDivisionError):
        fail_in(tmp_path / "run", "figures/mine.svg")
    (kept,) = tmp_path.iterdir()
    assert held_by(kept) == {"figures/mine.svg": "mine"}


def test_all_of_them_are_on_the_disk_before_they_appear(tmp_path, monkeypatch):
    synced, fsync = set(), os.fsync

    def noting(opened):
        synced.add(os.fstat(opened).st_ino)
        fsync(opened)

    monkeypatch.setattr(os, "fsync", noting)
    write_results(tmp_path / "run", "new")
    assert {item.stat().st_ino for item in (tmp_path / "run").rglob("*")} <= synced


@pytest.mark.skipif(
    os.unlink not in os.supports_dir_fd, reason="this system cannot hold folders open"
)
def test_a_subfolder_belongs_to_the_opened_folder(out, tmp_path):
    with Folder(out) as fixed:
        note = note_in(fixed)
        out.rename(tmp_path / "elsewhere")
        (out / "figures").mkdir(parents=True)
        (out / "figures/a.svg").write_text("years of work")
        assert strangers_in(fixed, note) == ([], [])
        fixed.remove("figures/a.svg")
    assert (out / "figures/a.svg").read_text() == "years of work"
    assert not (tmp_path / "elsewhere/figures/a.svg").exists()
