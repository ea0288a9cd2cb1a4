"""A folder that is held open stays that folder, whatever its path leads to by now; links in it are not followed."""

import os

import pytest

from bristle.files.owned import Folder

pytestmark = pytest.mark.skipif(os.unlink not in os.supports_dir_fd, reason="this system cannot hold folders open")


@pytest.fixture
def exchanged(tmp_path):
    """A folder held open, in whose place there is by now another with a file of the same name."""
    ours, thesis = tmp_path / "results", tmp_path / "thesis"
    ours.mkdir()
    thesis.mkdir()
    (ours / "a.txt").write_text("ours")
    (thesis / "a.txt").write_text("years of work")
    with Folder(ours) as held:
        ours.rename(tmp_path / "elsewhere")
        thesis.rename(ours)
        yield held, tmp_path


def test_what_is_removed_is_removed_from_the_folder_that_was_opened(exchanged):
    held, place = exchanged
    held.remove("a.txt")
    assert (place / "results" / "a.txt").read_text() == "years of work"
    assert not (place / "elsewhere" / "a.txt").exists()


def test_what_is_read_and_listed_is_of_the_folder_that_was_opened(exchanged):
    held, place = exchanged
    (place / "results" / "b.txt").write_text("another")
    assert held.names() == ["a.txt"]
    assert not held.is_file("b.txt")
    with os.fdopen(held.open("a.txt")) as file:
        assert file.read() == "ours"


def test_a_link_is_neither_a_file_nor_opened_nor_a_folder(tmp_path):
    (tmp_path / "results").mkdir()
    (tmp_path / "a.txt").write_text("mine")
    (tmp_path / "results" / "link").symlink_to(tmp_path / "a.txt")
    with Folder(tmp_path / "results") as held:
        assert not held.is_file("link")
        with pytest.raises(OSError, match="symbolic"):
            held.open("link")
    (tmp_path / "way").symlink_to(tmp_path / "results")
    with pytest.raises(OSError), Folder(tmp_path / "way"):
        pass
