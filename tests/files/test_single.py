"""A file that a person named is written whole, or not at all."""

import os

import pytest

from bristle.core.errors import InputError
from bristle.files.single import write_whole


def test_a_file_is_written_and_replaced_whole(tmp_path):
    path = tmp_path / "page.html"
    for content in ("first\n", b"second"):
        assert write_whole(path, content) == path
        assert [file.read_bytes() for file in tmp_path.iterdir()] == [
            content if isinstance(content, bytes) else content.encode()
        ]


def test_a_new_file_does_not_replace_an_existing_file(tmp_path):
    path = tmp_path / "page.html"
    write_whole(path, "first", new=True)
    with pytest.raises(InputError, match="cannot be written: file exists"):
        write_whole(path, "second", new=True)
    assert path.read_text() == "first"


def test_unencodable_characters_are_escaped(tmp_path):
    assert write_whole(tmp_path / "a", "\udc80µ").read_bytes() == b"\\udc80\xc2\xb5"


def test_a_file_is_on_the_disk_before_the_old_file_is_removed(tmp_path, monkeypatch):
    path, result, fsync = tmp_path / "a", [], os.fsync
    path.write_text("old")

    def noting(opened):
        result.append((path.read_text(), os.fstat(opened).st_size))
        fsync(opened)

    monkeypatch.setattr(os, "fsync", noting)
    write_whole(path, "newer")
    assert result == [("old", 5)]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("old", ["old", None])
def test_a_write_that_fails_leaves_the_old_file_alone(tmp_path, monkeypatch, old, error):
    path = tmp_path / "a"
    if old is not None:
        path.write_text(old)

    def fails(opened):
        raise error

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises((InputError, KeyboardInterrupt), match=r"no space left|^$"):
        write_whole(path, "newer")
    assert [file.read_text() for file in tmp_path.iterdir()] == ([] if old is None else [old])


def test_a_missing_folder_is_reported(tmp_path):
    with pytest.raises(
        InputError,
        match=r"gone/a.*cannot be written: no such file or directory.*Name a file in a writable",
    ):
        write_whole(tmp_path / "gone" / "a", "x")
