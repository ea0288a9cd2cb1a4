"""How long a connection is waited for, and which one makes room where there are too many, by a clock that a test turns."""

from types import SimpleNamespace as Some

import pytest
from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle.server.application import protocol_with_limits
from bristle.server.gate import HAS_TOKEN
from bristle.server.limits import Limits

LIMITS = Limits(strangers=2, stranger_seconds=4.0, silence_seconds=20.0)
PROTOCOL = protocol_with_limits(LIMITS)


class Clock:
    """A loop of events whose time is set, and which notes what is to be called later."""

    def __init__(self):
        self.now, self.later, self.cancelled = 0.0, [], 0

    def time(self):
        return self.now

    def call_later(self, seconds, call):
        self.later.append((seconds, call.__name__))
        return Some(cancel=self._cancel)

    def _cancel(self):
        self.cancelled += 1


class Transport:
    """What a protocol writes to: it is closing once that is asked for, and notes that it was aborted."""

    def __init__(self):
        self.closing, self.aborted = False, False

    def is_closing(self):
        return self.closing

    def abort(self):
        self.aborted = True


@pytest.fixture
def clock(monkeypatch):
    for name in ("connection_made", "connection_lost", "on_response_complete"):
        monkeypatch.setattr(H11Protocol, name, lambda self, *event: None)
    return Clock()


def connected(clock, connections=None, *, token=None, at=0.0):
    """A connection, without a request or with one that had the token or had it not."""
    protocol, clock.now = object.__new__(PROTOCOL), at
    protocol.loop, protocol.transport, protocol.cycle = clock, Transport(), None
    protocol.scope = None if token is None else {"state": {HAS_TOKEN: True} if token else {}}
    protocol.connections = set() if connections is None else connections
    protocol.connections.add(protocol)
    protocol.connection_made(protocol.transport)
    return protocol


@pytest.mark.parametrize(
    ("token", "seconds", "aborted"), [(None, 3.9, False), (None, 4.0, True), (False, 4.0, True), (True, 4.0, False), (True, 20.0, True)]
)
def test_a_silent_connection_is_ended_sooner_without_the_token(clock, token, seconds, aborted):
    protocol = connected(clock, token=token, at=100.0)
    clock.now = 100.0 + seconds
    protocol._watch()
    assert protocol.transport.aborted is aborted


@pytest.mark.parametrize(("token", "seconds"), [(False, 1.0), (True, 5.0)])
def test_four_looks_are_taken_while_a_connection_is_waited_for(clock, token, seconds):
    connected(clock, token=token)
    assert clock.later[0] == (seconds, "_watch")


def test_what_was_sent_with_a_connection_is_read_before_room_is_made(clock):
    connected(clock)
    assert [seconds for seconds, name in clock.later if name == "_make_room"] == [pytest.approx(0.1)]


@pytest.mark.parametrize(("complete", "aborted"), [(False, False), (True, True)])
def test_a_request_that_is_being_answered_is_no_silence(clock, complete, aborted):
    protocol = connected(clock)
    protocol.cycle = Some(response_complete=complete)
    clock.now = 50.0
    protocol._watch()
    assert protocol.transport.aborted is aborted


def test_silence_begins_anew_with_each_answer(clock):
    protocol = connected(clock)
    clock.now = 3.0
    protocol.on_response_complete()
    for now, aborted in ((6.9, False), (7.0, True)):
        clock.now = now
        protocol._watch()
        assert protocol.transport.aborted is aborted


def test_a_connection_that_is_closing_has_until_the_next_look(clock):
    protocol = connected(clock)
    protocol.transport.closing = True
    protocol._watch()
    assert not protocol.transport.aborted
    protocol._watch()
    assert protocol.transport.aborted


def test_a_lost_connection_is_looked_at_no_more(clock):
    protocol = connected(clock)
    protocol.connection_lost(None)
    assert clock.cancelled == 1


def test_the_oldest_connections_without_the_token_make_room(clock):
    connections = set()
    old, own, middle, young = (
        connected(clock, connections, token=token, at=at) for token, at in ((False, 1.0), (True, 0.0), (None, 2.0), (None, 3.0))
    )
    connections.add("a connection of another protocol")
    young._make_room()
    assert [item.transport.aborted for item in (old, own, middle, young)] == [True, False, False, False]
    connections.discard(old)
    middle._make_room()
    assert not middle.transport.aborted
    connections.discard(middle)
    young._make_room()
    assert not young.transport.aborted
