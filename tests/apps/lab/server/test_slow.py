"""Clients that are slow do not hold what others need."""

import threading
import time
from contextlib import contextmanager
from http.client import HTTPResponse
from types import SimpleNamespace

import pytest
from tests.apps.lab.browser import awaited
from tests.apps.lab.server.yard import TOKEN, begun, served
from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle.apps.lab.server.application import protocol_with_limits
from bristle.apps.lab.server.gate import HAS_TOKEN
from bristle.apps.lab.server.limits import Limits

SILENCE = 0.4
HEAD = "{method} {path} HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\nx-bristle-token: {token}\r\n"


LIMITS = Limits(silence_seconds=SILENCE, stranger_seconds=SILENCE, file_size=2**26)


def head(server, method, path, *lines):
    return (
        HEAD.format(method=method, path=path, port=server.port, token=TOKEN) + "".join(lines)
    ).encode()


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


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_stalled_body_is_cut_off(server):
    with server.client() as client:
        case = begun(client)
    with server.raw(
        head(server, "PUT", f"{case}/files", "content-length: 1000\r\n\r\n"), b"abc"
    ) as connection:
        seconds, text = closed_after(connection)
    assert text.startswith(b"HTTP/1.1 408")
    assert seconds < 10 * SILENCE
    with server.client() as client:
        assert client.get(case).json()["files"] == []


@pytest.mark.slow
def test_an_unread_answer_is_dropped(server):
    with server.client() as client:
        case = begun(client)
        (opened,) = [each for each in server.cases if case.endswith(each.identifier)]
        file = opened.folder / "data.json"
        file.write_bytes(b"0" * 2**25)
        from bristle.apps.lab.server.cases import Part

        opened.keep("looked", Part(1, opened.folder, {}, (0, 0)))
        with server.raw(head(server, "GET", f"{case}/parts/looked", "\r\n")) as connection:
            time.sleep(6 * SILENCE)
            _, text = closed_after(connection)
        assert b"HTTP/1.1 200" in text
        assert len(text) < 2**25


# --- Who has no token cannot keep out who has it, whatever connections he opens


HALF = b"GET /api/cases HTTP/1.1\r\nhost: x\r\n"
UNREAD = "GET / HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\n\r\n"


@pytest.fixture
def patient():
    """A server that drops no connection for its silence, however busy the machine is."""
    with served(
        Limits(strangers=4, stranger_seconds=600.0, silence_seconds=600.0), keep_alive=600
    ) as patient:
        yield patient


@contextmanager
def strangers(patient, count, *, stubborn=False):
    """Give connections without a token: some say nothing, some half of a request, some do not read their answer.

    Stubborn ones say one byte every second, and connect again as soon as they are dropped.
    """
    kinds = [(), (HALF,), (HALF,), (UNREAD.format(port=patient.port).encode(),)]
    connections = [patient.raw(*kinds[number % len(kinds)]) for number in range(count)]
    stop = threading.Event()

    def insist():
        while not stop.wait(1.0):
            for number, connection in enumerate(connections):
                try:
                    connection.sendall(b"x")
                except OSError:
                    connection.close()
                    connections[number] = patient.raw(*kinds[number % len(kinds)])

    thread = threading.Thread(target=insist)
    if stubborn:
        thread.start()
    try:
        yield connections
    finally:
        stop.set()
        if stubborn:
            thread.join()
        for connection in connections:
            connection.close()


def longest_wait(patient, requests, pause=0.0):
    """Return how long the slowest of these requests took [s], every other one on a connection of its own."""
    waits = []
    with patient.client() as kept:
        for number in range(requests):
            begin = time.monotonic()
            with patient.client() as fresh:
                assert (kept if number % 2 else fresh).get("/api/cases/none").status_code == 404
            waits.append(time.monotonic() - begin)
            time.sleep(pause)
    return max(waits)


@pytest.mark.slow
def test_the_owner_is_answered_while_strangers_occupy_all_connections(patient):
    with strangers(patient, 40) as rest, patient.client() as client:
        assert longest_wait(patient, 8, pause=0.05) < 60.0
        assert client.get("/").status_code == 200  # the page itself is asked for without a token
        awaited(lambda: sum(map(closed, rest)) >= 36)


@pytest.mark.parametrize(("count", "dropped"), [(3, 0), (6, 2)])
def test_only_the_latest_strangers_stay_up_to_the_limit(patient, count, dropped):
    with strangers(patient, count) as rest:
        time.sleep(0.3)
        awaited(lambda: list(map(closed, rest)) == [True] * dropped + [False] * (count - dropped))


def status_of(connection):
    """Read an answer whole and return its status."""
    with HTTPResponse(connection) as answer:
        answer.begin()
        answer.read()
        return answer.status


def closed(connection):
    connection.settimeout(0.01)
    try:
        while connection.recv(2**20):
            pass
    except TimeoutError:
        return False
    except ConnectionError:
        return True
    return True


def test_a_connection_that_had_the_token_is_not_dropped_for_a_stranger(patient):
    head = f"host: 127.0.0.1:{patient.port}\r\nx-bristle-token: {TOKEN}\r\n"
    with patient.client() as client:
        case = begun(client)
    kept = patient.raw(f"GET {case} HTTP/1.1\r\n{head}\r\n".encode())
    assert status_of(kept) == 200
    sends = patient.raw(f"PUT {case}/files HTTP/1.1\r\n{head}content-length: 6\r\n\r\nabc".encode())
    awaited(lambda: patient.cases.receiving)
    with kept, sends, strangers(patient, 20):
        for _ in range(2):
            longest_wait(patient, 1)
            kept.sendall(f"GET {case} HTTP/1.1\r\n{head}\r\n".encode())
            assert status_of(kept) == 200
        sends.sendall(b"def")
        assert status_of(sends) == 201


def test_a_request_that_the_gate_has_not_judged_keeps_the_trust_of_the_last_one(monkeypatch):
    monkeypatch.setattr(H11Protocol, "on_response_complete", lambda _: None)
    connection = object.__new__(protocol_with_limits(Limits()))
    connection.loop = SimpleNamespace(time=lambda: 0.0)
    for state, is_trusted in (({HAS_TOKEN: True}, True), ({}, False)):
        connection.scope = {"state": state}
        connection.on_response_complete()
        connection.scope = {"state": {}}
        assert connection._has_token() == is_trusted


@pytest.mark.slow
def test_forty_requests_are_answered_within_a_second_despite_half_open_connections():
    with served() as patient, strangers(patient, 90, stubborn=True):
        assert longest_wait(patient, 40, pause=0.2) < 1.0


@pytest.mark.slow
def test_a_stranger_who_never_ends_his_head_is_closed_soon():
    with served() as patient, patient.raw(HALF) as connection:
        begin = time.monotonic()
        with pytest.raises(OSError):  # noqa: PT012  (which of the lines fails is a matter of time)
            for _ in range(100):
                connection.sendall(b"x")
                time.sleep(0.1)
        assert time.monotonic() - begin < 6.0
