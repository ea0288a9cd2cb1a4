"""Where the lab listens, how it is served, and the folder that goes with it."""

import os
import socket
from pathlib import Path
from types import SimpleNamespace

import pytest

from bristle.core.errors import InputError
from bristle.server import run
from bristle.server.limits import Limits
from bristle.server.run import NOTE, PREFIX, listening_on, own_folder, serve, server_of


@pytest.mark.parametrize("port", [-1, 2**16, 10**9])
def test_an_invalid_port_is_refused(port):
    with pytest.raises(InputError, match=r"--port: is not a port.*0 to 65535, 0 for any free port"):
        listening_on(port)


def test_only_this_machine_connects_and_a_port_is_used_once():
    with listening_on(0) as listening:
        host, port = listening.getsockname()
        assert host == "127.0.0.1"
        assert port > 0
        with pytest.raises(InputError, match=r"--port: cannot be opened: .*bristle takes a free port"):
            listening_on(port)
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass


def test_a_folder_is_private_and_removed_with_its_contents(temporary):
    with own_folder() as folder:
        assert folder.parent == temporary
        assert folder.name.startswith(PREFIX)
        assert folder.stat().st_mode & 0o777 == 0o700
        note = folder / NOTE
        assert note.stat().st_mode & 0o777 == 0o600
        assert note.read_text() == f"bristle lab --serve keeps its logs here: {folder.name} {folder.stat().st_ino}\n"
        (folder / "below").mkdir()
        (folder / "below" / "log.csv").write_text("x")
    assert list(temporary.iterdir()) == []


def test_the_folder_of_a_live_server_is_kept(temporary):
    with own_folder() as first, own_folder() as second:
        assert first.exists()
        assert second.exists()


def dead(temporary, name=f"{PREFIX}dead"):
    """A folder that a dead server left."""
    folder = temporary / name
    (folder / "below").mkdir(parents=True)
    (folder / "file").write_text("x")
    (folder / NOTE).write_text(f"bristle lab --serve keeps its logs here: {name} {folder.stat().st_ino}\n")
    return folder


@pytest.mark.skipif(os.name != "posix", reason="owners of POSIX")
def test_the_folder_of_a_dead_server_is_removed_and_a_copy_kept(temporary):
    left, copy = dead(temporary), dead(temporary, f"{PREFIX}copy")
    (copy / NOTE).write_text((left / NOTE).read_text())
    elsewhere = dead(temporary, "bristle-else")
    with own_folder():
        assert not left.exists()
        assert copy.exists()
        assert elsewhere.exists()
    assert {file.name for file in copy.iterdir()} == {"below", "file", NOTE}


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
    monkeypatch.setattr(run.webbrowser, "open", lambda address: opened.append(Path(address.removeprefix("file://")).read_text()))
    monkeypatch.setattr(run, "threading", SimpleNamespace(Thread=thread))
    serve(opens=opens, limits=limits, announce=announced.append)
    (address,) = announced
    base, _, token = address.partition("/#")
    assert served == [limits, int(base.rpartition(":")[2])]
    assert base.startswith("http://127.0.0.1:")
    assert len(token) >= 40
    assert len(opened) == opens
    if opens:
        assert f"{base}/opened/" in opened[0]
        assert f"#{token}" in opened[0]
    assert list(temporary.iterdir()) == []


def test_a_server_sends_no_server_header_and_trusts_no_proxy():
    async def app(scope, receive, send):
        raise AssertionError

    config = server_of(app, Limits()).config
    assert (config.server_header, config.access_log, config.proxy_headers, config.ws) == (False, False, False, "none")
    assert (config.lifespan, config.log_config, config.backlog) == ("on", None, 128)
    assert (config.timeout_keep_alive, config.timeout_graceful_shutdown) == (5, 1)
