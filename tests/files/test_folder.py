"""A folder held open, and names exchanged by whatever the system knows for it."""

import ctypes
import errno
import hashlib
import os
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from bristle.core.errors import InputError
from bristle.files import folder as folders
from bristle.files.folder import Folder, exchange, folder_wanted, rename_new


@pytest.fixture
def opened(tmp_path):
    """A folder with a file, a folder below, and links to both."""
    place = tmp_path / "held"
    (place / "below").mkdir(parents=True)
    (place / "a").write_bytes(b"first" * 100_000)
    (place / "below/b").write_text("second")
    (place / "link").symlink_to(place / "a")
    (place / "lost").symlink_to(place / "nowhere")
    with Folder(place) as opened:
        yield opened


def test_the_content_of_a_folder_is_listed_in_order(opened):
    with opened.below("below") as inside:
        assert (opened.names(), inside.names()) == (["a", "below", "link", "lost"], ["b"])


def test_links_are_there_and_are_no_files(opened):
    assert [opened.is_file(name) for name in ("a", "below/b", "link", "lost", "below", "gone")] == [
        True,
        True,
        False,
        False,
        False,
        False,
    ]
    assert [opened.is_there(name) for name in ("a", "link", "lost", "gone", "gone/b")] == [
        True,
        True,
        True,
        False,
        False,
    ]
    for name in ("link", "lost"):
        with pytest.raises(OSError, match=r"symbolic link"):
            opened.open(name)


def test_a_file_has_a_size_and_a_checksum(opened):
    assert (opened.size("a"), opened.size("below/b")) == (500_000, 6)
    assert opened.checksum("a") == hashlib.sha256(b"first" * 100_000).hexdigest()


def test_a_file_is_renamed_only_to_an_unused_name(opened):
    opened.rename("a", "c")
    opened.rename("below/b", "below/d")
    with opened.below("below") as inside:
        assert (opened.names(), inside.names()) == (["below", "c", "link", "lost"], ["d"])
    for taken in ("below", "link", "lost"):
        with pytest.raises(FileExistsError):
            opened.rename("c", taken)
    assert opened.is_file("c")


def test_where_files_have_a_single_name_an_own_look_comes_first(opened, monkeypatch):
    def refuses(*names, **places):
        raise OSError(errno.EPERM, "no such names")

    monkeypatch.setattr(os, "link", refuses)
    monkeypatch.setattr(os, "supports_dir_fd", os.supports_dir_fd | {refuses})
    opened.rename("a", "c")
    assert opened.names() == ["below", "c", "link", "lost"]
    with pytest.raises(FileExistsError):
        opened.rename("c", "lost")


def test_a_file_takes_the_place_of_another(opened):
    opened.replace("a", "link")
    assert (opened.names(), opened.is_file("link")) == (["below", "link", "lost"], True)


def test_files_and_empty_folders_are_removed(opened):
    opened.remove("link")
    assert opened.is_file("a")
    with pytest.raises(OSError, match="not empty"):
        opened.remove_empty("below")
    opened.remove("below/b")
    opened.remove_empty("below")
    assert opened.names() == ["a", "lost"]


def test_a_folder_is_made_once_and_not_through_a_link(opened, tmp_path):
    opened.make("new")
    opened.make("new")
    assert opened.is_there("new")
    for name in ("a", "lost"):
        with pytest.raises(OSError, match=r"[Nn]ot a directory|symbolic link"):
            opened.make(name)
    with pytest.raises(OSError, match=r"[Nn]ot a directory"), Folder(tmp_path / "held/a"):
        pass


def test_a_system_without_open_folders_works_by_paths(tmp_path, monkeypatch):
    (tmp_path / "below").mkdir()
    monkeypatch.setattr(os, "supports_dir_fd", set())
    with Folder(tmp_path) as place:
        descriptor = place.open("below/a", os.O_WRONLY | os.O_CREAT)
        os.write(descriptor, b"x")
        os.close(descriptor)
        assert (place.names(), place.size("below/a")) == (["below"], 1)
        place.rename("below/a", "below/b")
        assert place.is_file("below/b")
    with pytest.raises(OSError, match="Not a directory"), Folder(tmp_path / "below/b"):
        pass


# --- exchanged names -------------------------------------------------------------------------------------------------


def pair(tmp_path):
    for name in ("old", "new"):
        (tmp_path / name).mkdir()
        (tmp_path / name / name).write_text("")
    return tmp_path / "old", tmp_path / "new"


@pytest.mark.parametrize("system_knows_it", [True, False])
def test_a_folder_is_renamed_only_to_an_unused_name(tmp_path, monkeypatch, system_knows_it):
    old, new = pair(tmp_path)
    if not system_knows_it:
        monkeypatch.setattr(folders, "_rename", lambda *requested: False)
        assert not exchange(old, new)
    with pytest.raises(FileExistsError):
        rename_new(old, new)
    rename_new(old, tmp_path / "third")
    assert sorted(str(item.relative_to(tmp_path)) for item in tmp_path.rglob("*")) == [
        "new",
        "new/new",
        "third",
        "third/old",
    ]


def test_two_folders_exchange_their_names(tmp_path):
    old, new = pair(tmp_path)
    if exchange(old, new):
        assert ((old / "new").exists(), (new / "old").exists()) == (True, True)


@pytest.mark.parametrize(("system", "arguments"), [("renameat2", 5), ("renamex_np", 3)])
@pytest.mark.parametrize(
    ("code", "outcome"),
    [(0, True), (errno.EINVAL, False), (errno.ENOSYS, False), (errno.EEXIST, None)],
)
def test_the_exchange_of_names_reports_its_success(
    monkeypatch, tmp_path, system, arguments, code, outcome
):
    requested = []

    def call(*passed):
        requested.append(passed)
        return -1 if code else 0

    monkeypatch.setattr(folders.sys, "platform", "other")
    monkeypatch.setattr(ctypes, "CDLL", lambda name, use_errno: SimpleNamespace(**{system: call}))
    monkeypatch.setattr(ctypes, "get_errno", lambda: code)
    with pytest.raises(FileExistsError) if outcome is None else nullcontext():
        assert folders._rename(tmp_path / "a", tmp_path / "b", 7) is outcome
    names = os.fsencode(tmp_path / "a"), os.fsencode(tmp_path / "b")
    assert requested == [(-100, names[0], -100, names[1], 7) if arguments == 5 else (*names, 7)]


def test_an_unsupported_exchange_changes_no_names(monkeypatch, tmp_path):
    monkeypatch.setattr(ctypes, "CDLL", lambda name, use_errno: SimpleNamespace())
    assert not folders._rename(tmp_path / "a", tmp_path / "b", 1)
    monkeypatch.setattr(folders.sys, "platform", "win32")
    assert not folders._rename(tmp_path / "a", tmp_path / "b", 1)


# --- places ----------------------------------------------------------------------------------------------------------


def test_a_folder_is_wanted_without_links(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    wanted = [folder_wanted(tmp_path / name) for name in ("link/new", "link", "real/..")]
    assert wanted == [tmp_path / "real" / "new", tmp_path / "real", tmp_path]


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("a\0b", "contains a NUL character"),
        ("/", "is the root of a file system"),
        ("/no/such/place", "its parent folder does not exist.*Make /no/such first"),
    ],
)
def test_invalid_places_for_a_folder_are_refused(path, words):
    with pytest.raises(InputError, match=words):
        folder_wanted(path)
