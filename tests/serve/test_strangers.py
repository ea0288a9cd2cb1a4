"""Who has no token cannot keep out who has it, whatever connections he opens."""

import threading
import time
from contextlib import contextmanager
from http.client import HTTPResponse

import pytest
from tests.serve.yard import TOKEN, begun, served

from bristle.server.limits import Limits

HALF = b"GET /api/cases HTTP/1.1\r\nhost: x\r\n"
UNREAD = "GET / HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\n\r\n"


@pytest.fixture
def server():
    """A server that drops no connection for its silence, however busy the machine is."""
    with served(Limits(strangers=4, stranger_seconds=600.0, silence_seconds=600.0), keep_alive=600) as server:
        yield server


@contextmanager
def strangers(server, count, *, stubborn=False):
    """Give connections without a token: some say nothing, some half of a request, some do not read their answer.

    Stubborn ones say one byte every second, and connect again as soon as they are dropped.
    """
    kinds = [(), (HALF,), (HALF,), (UNREAD.format(port=server.port).encode(),)]
    connections = [server.raw(*kinds[number % len(kinds)]) for number in range(count)]
    stop = threading.Event()

    def insist():
        while not stop.wait(1.0):
            for number, connection in enumerate(connections):
                try:
                    connection.sendall(b"x")
                except OSError:
                    connection.close()
                    connections[number] = server.raw(*kinds[number % len(kinds)])

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


def longest_wait(server, requests, pause=0.0):
    """Return how long the slowest of these requests took [s], every other one on a connection of its own."""
    waits = []
    with server.client() as kept:
        for number in range(requests):
            begin = time.monotonic()
            with server.client() as fresh:
                assert (kept if number % 2 else fresh).get("/api/cases/none").status_code == 404
            waits.append(time.monotonic() - begin)
            time.sleep(pause)
    return max(waits)


def waits(holds, seconds=60.0):
    until = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_the_owner_is_answered_while_strangers_occupy_all_connections(server):
    with strangers(server, 40) as rest, server.client() as client:
        assert longest_wait(server, 8, pause=0.05) < 60.0
        assert client.get("/").status_code == 200  # the page itself is asked for without a token
        waits(lambda: sum(map(closed, rest)) >= 36)


@pytest.mark.parametrize(("count", "dropped"), [(3, 0), (6, 2)])
def test_only_the_latest_strangers_stay_up_to_the_limit(server, count, dropped):
    with strangers(server, count) as rest:
        time.sleep(0.3)
        waits(lambda: list(map(closed, rest)) == [True] * dropped + [False] * (count - dropped))


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


def test_a_connection_that_had_the_token_is_not_dropped_for_a_stranger(server):
    head = f"host: 127.0.0.1:{server.port}\r\nx-bristle-token: {TOKEN}\r\n"
    with server.client() as client:
        case = begun(client)
    kept = server.raw(f"GET {case} HTTP/1.1\r\n{head}\r\n".encode())
    assert status_of(kept) == 200
    sends = server.raw(f"PUT {case}/files HTTP/1.1\r\n{head}content-length: 6\r\n\r\nabc".encode())
    waits(lambda: server.cases.receiving)
    with kept, sends, strangers(server, 20):
        for _ in range(2):
            longest_wait(server, 1)
            kept.sendall(f"GET {case} HTTP/1.1\r\n{head}\r\n".encode())
            assert status_of(kept) == 200
        sends.sendall(b"def")
        assert status_of(sends) == 201


@pytest.mark.slow
def test_forty_requests_are_answered_within_a_second_despite_half_open_connections():
    with served() as server, strangers(server, 90, stubborn=True):
        assert longest_wait(server, 40, pause=0.2) < 1.0


@pytest.mark.slow
def test_a_stranger_who_never_ends_his_head_is_closed_soon():
    with served() as server, server.raw(HALF) as connection:
        begin = time.monotonic()
        with pytest.raises(OSError):  # noqa: PT012  (which of the lines fails is a matter of time)
            for _ in range(100):
                connection.sendall(b"x")
                time.sleep(0.1)
        assert time.monotonic() - begin < 6.0
