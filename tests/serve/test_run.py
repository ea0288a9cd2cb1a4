"""Where the lab listens, how it is served, and the folder that goes with it."""

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
        with pytest.raises(InputError, match=r"--port: cannot be opened: .*bristle takes a free port"):
            listening_on(port)
        with socket.create_connection(("127.0.0.1", port), timeout=5):
            pass


def test_a_folder_is_private_and_removed_with_its_contents(temporary):
    with own_folder() as folder:
        note = folder / NOTE
        assert (folder.parent, folder.name[: len(PREFIX)]) == (temporary, PREFIX)
        assert [place.stat().st_mode & 0o777 for place in (folder, note)] == [0o700, 0o600]
        assert note.read_text() == f"bristle lab --serve keeps its logs here: {folder.name} {folder.stat().st_ino}\n"
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
    monkeypatch.setattr(run.webbrowser, "open", lambda address: opened.append(Path(address.removeprefix("file://")).read_text()))
    monkeypatch.setattr(run, "threading", SimpleNamespace(Thread=thread))
    serve(opens=opens, limits=limits, announce=announced.append)
    (address,) = announced
    base, _, token = address.partition("/#")
    assert served == [limits, int(base.rpartition(":")[2])]
    assert base.startswith("http://127.0.0.1:")
    assert len(token) >= 40
    assert len(opened) == opens
    assert all(f"{base}/opened/" in text and f"#{token}" in text for text in opened)
    assert list(temporary.iterdir()) == []


def test_a_server_sends_no_server_header_and_trusts_no_proxy():
    async def app(scope, receive, send):
        raise AssertionError

    config = server_of(app, Limits()).config
    assert (config.server_header, config.access_log, config.proxy_headers, config.ws) == (False, False, False, "none")
    assert (config.lifespan, config.log_config, config.backlog) == ("on", None, 128)
    assert (config.timeout_keep_alive, config.timeout_graceful_shutdown) == (5, 1)
