"""Where the lab listens, how it is served, and the folder that goes with it."""

import os
import re
import shutil
import signal
import socket
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.apps.lab.browser import awaited
from tests.apps.lab.server.yard import begun, lab_process, put

from bristle.apps.lab.server import Limits, run
from bristle.apps.lab.server.run import NOTE, PREFIX, listening_on, own_folder, serve, server_of
from bristle.core.errors import InputError


@pytest.mark.parametrize("port", [-1, 2**16, 10**9])
def test_an_invalid_port_is_refused(port):
    with pytest.raises(InputError, match=r"--port: is not a port.*0 to 65535, 0 for any free port"):
        listening_on(port)


def test_only_this_machine_connects_and_a_port_is_used_once():
    with listening_on(0) as listening:
        host, port = listening.getsockname()
        assert host == "127.0.0.1"
        with pytest.raises(
            InputError, match=r"--port: cannot be opened: .*bristle takes a free port"
        ):
            listening_on(port)
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass


def test_a_folder_is_private_and_removed_with_its_contents(temporary):
    with own_folder() as folder:
        note = folder / NOTE
        assert (folder.parent, folder.name[: len(PREFIX)]) == (temporary, PREFIX)
        assert [place.stat().st_mode & 0o777 for place in (folder, note)] == [0o700, 0o600]
        assert (
            note.read_text()
            == f"bristle lab --serve keeps its logs here: {folder.name} {folder.stat().st_ino}\n"
        )
        (folder / "below").mkdir()
        (folder / "below" / "log.csv").write_text("x")
    assert list(temporary.iterdir()) == []


@pytest.mark.parametrize("opens", [True, False])
def test_an_address_is_announced_and_a_browser_opened_with_a_file(temporary, monkeypatch, opens):
    announced, opened, served = [], [], []

    class Server:
        def run(self, sockets):
            served.append(sockets[0].getsockname()[1])

    def thread(target, args, daemon):
        return SimpleNamespace(start=lambda: target(*args))

    limits = Limits(jobs=1)
    monkeypatch.setattr(run, "server_of", lambda app, bounds: served.append(bounds) or Server())
    monkeypatch.setattr(
        run.webbrowser,
        "open",
        lambda address: opened.append(Path(address.removeprefix("file://")).read_text()),
    )
    monkeypatch.setattr(run, "threading", SimpleNamespace(Thread=thread))
    serve(opens=opens, limits=limits, announce=announced.append)
    (address,) = announced
    base, _, token = address.partition("/#")
    assert (served[0], base, len(opened)) == (limits, f"http://127.0.0.1:{served[1]}", opens)
    assert len(token) >= 40
    assert all(f"{base}/opened/" in text and f"#{token}" in text for text in opened)
    assert list(temporary.iterdir()) == []


def test_a_server_sends_no_server_header_and_trusts_no_proxy():
    async def app(scope, receive, send):
        raise AssertionError

    config = server_of(app, Limits()).config
    expected = {
        "server_header": False,
        "access_log": False,
        "proxy_headers": False,
        "ws": "none",
        "lifespan": "on",
        "log_config": None,
    }
    expected |= {"backlog": 128, "timeout_keep_alive": 5, "timeout_graceful_shutdown": 1}
    assert {name: getattr(config, name) for name in expected} == expected


# --- However a server ends, nothing of what it was given stays: it removes it, or the next one does


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
        workers = awaited(lambda: children_of(process.pid))
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
    return {
        each.relative_to(place): each.read_text()
        if each.is_file() and not each.is_symlink()
        else None
        for each in place.rglob("*")
    }


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
        assert [dead.is_symlink(), (tmp_path / "elsewhere" / "case" / "file-1").exists()] == [
            True,
            True,
        ]


@pytest.mark.parametrize(
    ("name", "instead"),
    [("os.getuid", lambda: -1), ("bristle.apps.lab.server.run.lock", lambda opened: False)],
    ids=["another user", "no locks"],
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


# --- The limits of the served lab are those that its page tells


PAGE = Path(__file__).parents[4] / "docs" / "how-to" / "identify-in-the-browser.md"
MIB, GIB = 2**20, 2**30


@pytest.mark.parametrize(
    ("row", "words", "limits"),
    [
        (
            "size of a log; of all logs",
            "512 MiB, or `BRISTLE_SIZE_LIMIT`; four times this size",
            {"file_size": 512 * MIB, "total_size": 4 * 512 * MIB},
        ),
        ("analyses; logs in each", "16; 32", {"cases": 16, "files": 32}),
        (
            "jobs at once; time and memory of each",
            "2; one hour, 16 GiB of address space",
            {"jobs": 2, "job_seconds": 3600.0, "job_memory": 16 * GIB},
        ),
        ("silence within a request", "10 s", {"silence_seconds": 10.0}),
        (
            "connections without the token; their time for a request",
            "32 (a new connection replaces the oldest); 3 s",
            {"strangers": 32, "stranger_seconds": 3.0},
        ),
    ],
)
def test_limits_are_those_of_the_page(row, words, limits):
    assert (
        dict(re.findall(r"^\| (.+?) \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))[
            row
        ]
        == words
    )
    assert {name: getattr(Limits(), name) for name in limits} == limits


def test_a_job_has_a_minute_to_end_and_a_message_a_mebibyte():
    assert (Limits().grace_seconds, Limits().body_size) == (60.0, MIB)
