"""Clients that are slow do not hold what others need."""

import time

import pytest
from tests.serve.yard import TOKEN, begun, served

from bristle.server.limits import Limits

SILENCE = 0.4
HEAD = "{method} {path} HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\nx-bristle-token: {token}\r\n"


@pytest.fixture(scope="module")
def server():
    limits = Limits(silence_seconds=SILENCE, stranger_seconds=SILENCE, file_size=2**26)
    with served(limits) as server:
        yield server


def head(server, method, path, *lines):
    return (HEAD.format(method=method, path=path, port=server.port, token=TOKEN) + "".join(lines)).encode()


def closed_after(connection):
    """Return how long the server kept a connection, and what it said."""
    begin, text = time.monotonic(), b""
    while True:
        try:
            piece = connection.recv(65536)
        except ConnectionError:
            piece = b""
        if not piece:
            return time.monotonic() - begin, text
        text += piece


def test_an_endless_head_is_cut_off(server):
    with server.raw(b"GET / HTTP/1.1\r\n") as connection:
        begin = time.monotonic()
        with pytest.raises(OSError):  # noqa: PT012  (which of the lines fails is a matter of time)
            for _ in range(200):  # a byte now and then is no answer either
                connection.sendall(b"x")
                time.sleep(0.05)
        assert time.monotonic() - begin < 10 * SILENCE


def test_a_silent_connection_is_closed(server):
    with server.raw() as connection:
        seconds, text = closed_after(connection)
    assert text == b""
    assert seconds < 10 * SILENCE


def test_a_stalled_body_is_cut_off(server):
    with server.client() as client:
        case = begun(client)
    with server.raw(head(server, "PUT", f"{case}/files", "content-length: 1000\r\n\r\n"), b"abc") as connection:
        seconds, text = closed_after(connection)
    assert text.startswith(b"HTTP/1.1 408")
    assert seconds < 10 * SILENCE
    with server.client() as client:
        assert client.get(case).json()["files"] == []


def test_an_unread_answer_is_dropped(server):
    with server.client() as client:
        case = begun(client)
        (opened,) = [each for each in server.cases if case.endswith(each.identifier)]
        file = opened.folder / "data.json"
        file.write_bytes(b"0" * 2**25)
        from bristle.server.cases import Part

        opened.keep("looked", Part(1, opened.folder, {}, (0, 0)))
        with server.raw(head(server, "GET", f"{case}/parts/looked", "\r\n")) as connection:
            time.sleep(6 * SILENCE)
            _, text = closed_after(connection)
        assert b"HTTP/1.1 200" in text
        assert len(text) < 2**25
