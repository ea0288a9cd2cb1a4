"""How long a connection is waited for, and which one makes room where there are too many, by a clock that a test turns."""

from types import SimpleNamespace as Some

import pytest
from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle.server.application import protocol_with_limits
from bristle.server.gate import HAS_TOKEN
from bristle.server.limits import Limits

PROTOCOL = protocol_with_limits(Limits(strangers=2, stranger_seconds=4.0, silence_seconds=20.0))


@pytest.fixture
def connected(monkeypatch):
    """A function that returns a connection which begins at 100 s: without a request, or whose request had the token or had it not."""

    def connect(token=None, connections=None):
        protocol = object.__new__(PROTOCOL)
        protocol.now, protocol.later, protocol.done = 100.0, [], []
        timer = Some(cancel=lambda: protocol.done.append("cancelled"))
        call_later = lambda seconds, call: protocol.later.append((call.__name__, seconds)) or timer  # noqa: E731
        protocol.loop = Some(time=lambda: protocol.now, call_later=call_later)
        protocol.transport = Some(is_closing=lambda: "closing" in protocol.done, abort=lambda: protocol.done.append("aborted"))
        protocol.scope = None if token is None else {"state": {HAS_TOKEN: True} if token else {}}
        protocol.cycle, protocol.connections = None, set() if connections is None else connections
        protocol.connections.add(protocol)
        protocol.connection_made(protocol.transport)
        return protocol

    for name in ("connection_made", "connection_lost", "on_response_complete"):
        monkeypatch.setattr(H11Protocol, name, lambda self, *event: None)
    return connect


@pytest.mark.parametrize(
    ("token", "seconds", "done"),
    [(None, 3.9, []), (None, 4.0, ["aborted"]), (False, 4.0, ["aborted"]), (True, 4.0, []), (True, 20.0, ["aborted"])],
)
def test_a_silent_connection_is_ended_sooner_without_the_token(connected, token, seconds, done):
    protocol = connected(token)
    protocol.now += seconds
    protocol._watch()
    assert protocol.done == done


@pytest.mark.parametrize(("token", "seconds"), [(False, 1.0), (True, 5.0)])
def test_a_connection_is_checked_four_times_and_makes_room_after_reading(connected, token, seconds):
    assert connected(token).later == [("_watch", seconds), ("_make_room", 0.1)]


@pytest.mark.parametrize(("complete", "done"), [(False, []), (True, ["aborted"])])
def test_a_request_in_progress_does_not_count_as_silence(connected, complete, done):
    protocol = connected()
    protocol.cycle = Some(response_complete=complete)
    protocol.now += 50.0
    protocol._watch()
    assert protocol.done == done


def test_each_answer_restarts_the_silence_timer(connected):
    protocol = connected()
    protocol.now = 103.0
    protocol.on_response_complete()
    for now, done in ((106.9, []), (107.0, ["aborted"])):
        protocol.now = now
        protocol._watch()
        assert protocol.done == done


def test_closing_connections_have_until_the_next_check_and_lost_ones_are_dropped(connected):
    protocol = connected()
    protocol.done.append("closing")
    protocol._watch()
    assert protocol.done == ["closing"]
    protocol._watch()
    assert protocol.done == ["closing", "aborted"]
    protocol.connection_lost(None)
    assert protocol.done[-1] == "cancelled"


def test_the_oldest_connections_without_the_token_make_room(connected):
    connections = {"a connection of another protocol"}
    authorised, old, middle, young = (connected(token, connections) for token in (True, False, None, None))
    for age, protocol in enumerate((authorised, old, middle, young)):
        protocol._connected_at = age
    young._make_room()
    assert [item.done for item in (authorised, old, middle, young)] == [[], ["aborted"], [], []]
    connections.discard(old)
    young._make_room()
    assert middle.done == young.done == []
