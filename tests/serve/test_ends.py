"""However a server ends, nothing of what it was given stays: it removes it, or the next one does."""

import os
import shutil
import signal
import time
from pathlib import Path

import pytest
from tests.serve.yard import begun, lab_process, put

from bristle.server.run import NOTE, PREFIX, own_folder

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and owners of POSIX")


def children_of(number):
    """Return the processes that one has started, without those that have ended."""
    listed = Path(f"/proc/{number}/task/{number}/children").read_text().split()
    return [int(child) for child in listed]


def is_there(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes in /proc")
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_in_good_order_with_its_job_and_its_folder(temporary, number):
    with lab_process(temporary, "--no-open") as (process, client, _):
        case = begun(client)
        put(client, case, b"time,position\n0,1\n")
        assert client.post(f"{case}/jobs", json={"task": "look"}).status_code == 202
        while not (workers := children_of(process.pid)):
            time.sleep(0.01)
        (folder,) = temporary.iterdir()
        assert [file.read_bytes() for file in folder.glob("*/file-1")] == [b"time,position\n0,1\n"]
        process.send_signal(number)
        assert process.wait(20) == 0
        assert list(temporary.iterdir()) == []
        assert [worker for worker in workers if is_there(worker)] == []
        assert process.stderr.read().splitlines()[1:] == ["bristle: the lab is closed"]


@pytest.mark.slow
def test_the_folder_of_a_killed_server_is_removed_by_the_next(temporary):
    with lab_process(temporary, "--no-open") as (process, client, _):
        put(client, begun(client), b"time,position\n0,1\n")
        (folder,) = temporary.iterdir()
        (kept,) = folder.glob("*/file-1")
        with own_folder():
            assert kept.exists()  # its server lives
        process.kill()
        process.wait()
        assert kept.exists()
        with own_folder():
            assert not folder.exists()


def planted(temporary, name):
    """Return a folder that is called like one of a server, and holds what a person keeps."""
    folder = temporary / f"{PREFIX}{name}"
    folder.mkdir()
    (folder / "log.csv").write_text("mine")
    return folder


def left_alone(temporary, dead):
    """Return what looks like the folder of a dead server, each in one way, and is none."""
    copied = temporary / f"{PREFIX}copied"
    shutil.copytree(dead, copied, symlinks=True)
    names = ("noted-by-a-person", "begins-just-now", "with-a-linked-note", "with-a-pipe")
    noted, begins, linked, pipe = (planted(temporary, name) for name in names)
    (noted / NOTE).write_text("to be kept")
    (begins / NOTE).touch()
    (linked / NOTE).symlink_to(dead / NOTE)
    os.mkfifo(pipe / NOTE)
    link = temporary / f"{PREFIX}link"
    link.symlink_to(noted, target_is_directory=True)
    file = temporary / f"{PREFIX}file"
    file.write_text("mine")
    other = temporary / "lab-of-another-name"
    other.mkdir()
    return [copied, noted, begins, linked, pipe, link, file, other]


def contents(place):
    """Return all that is in a folder, links as such."""
    if place.is_symlink() or place.is_file():
        return os.readlink(place) if place.is_symlink() else place.read_text()
    return {each.relative_to(place): each.read_text() if each.is_file() and not each.is_symlink() else None for each in place.rglob("*")}


@pytest.fixture
def dead(temporary):
    """The folder of a server that is dead, as it stands."""
    with own_folder() as folder:
        (folder / "case").mkdir()
        (folder / "case" / "file-1").write_text("a log")
        os.rename(folder, temporary / "aside")
    os.rename(temporary / "aside", folder)
    return folder


def test_only_the_folder_of_a_dead_server_is_removed(dead, temporary):
    mine = planted(temporary, "of-a-person")
    (dead / "elsewhere").symlink_to(mine)
    stay = {each: contents(each) for each in (mine, *left_alone(temporary, dead))}
    with own_folder() as living, own_folder():
        assert [living.is_dir(), dead.exists()] == [True, False]
    assert {each: contents(each) for each in temporary.iterdir()} == stay


def test_a_link_to_a_folder_of_a_dead_server_is_not_followed(dead, temporary, tmp_path):
    os.rename(dead, tmp_path / "elsewhere")
    dead.symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    with own_folder():
        assert dead.is_symlink()
        assert (tmp_path / "elsewhere" / "case" / "file-1").exists()


@pytest.mark.parametrize(
    ("name", "instead"), [("os.getuid", lambda: -1), ("bristle.server.run.lock", lambda opened: False)], ids=["another user", "no locks"]
)
def test_the_folder_of_another_user_or_without_file_locks_is_left(dead, monkeypatch, name, instead):
    monkeypatch.setattr(name, instead)
    with own_folder():
        assert (dead / "case" / "file-1").exists()


def test_an_error_at_the_start_leaves_no_files(temporary):
    def begin():
        with own_folder() as folder:
            (folder / "case").mkdir()
            assert folder.stat().st_mode & 0o077 == 0
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        begin()
    assert list(temporary.iterdir()) == []
