"""Who is let in: this machine's own page, with its token, and nobody else."""

import base64
import hashlib
import re
from types import SimpleNamespace as Some

import pytest
from starlette.testclient import TestClient
from tests.apps.lab.server.yard import PORT, TOKEN
from uvicorn.protocols.http.h11_impl import H11Protocol

from bristle.apps.lab.server import gate, limits
from bristle.apps.lab.server.application import application, protocol_with_limits

OWN = {"x-bristle-token": TOKEN}


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    return application(tmp_path_factory.mktemp("lab"), TOKEN, PORT, limits.Limits())


@pytest.fixture
def client(app):
    return TestClient(app, base_url=f"http://127.0.0.1:{PORT}", headers=OWN)


@pytest.mark.parametrize("host", [f"127.0.0.1:{PORT}", f"localhost:{PORT}"])
def test_this_machine_is_let_in(client, host):
    assert (
        client.post("/api/cases", headers={"host": host, "origin": f"http://{host}"}).status_code
        == 201
    )


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        f"evil.example:{PORT}",
        "127.0.0.1",
        "127.0.0.1:80",
        f"127.0.0.1.evil.example:{PORT}",
        "",
    ],
)
@pytest.mark.parametrize("path", ["/", "/api/cases", "/shown/x"])
def test_a_name_that_was_bound_to_this_machine_is_refused_with_and_without_the_token(
    client, host, path
):
    # DNS rebinding: the browser believes that it speaks to the other site, and says so.
    answer = client.request("POST" if "api" in path else "GET", path, headers={"host": host})
    assert answer.status_code == 421
    assert "not this machine" in answer.json()["message"]


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "null", f"http://evil.example:{PORT}", "http://127.0.0.1"]
)
@pytest.mark.parametrize("path", ["/", "/api/cases"])
def test_a_page_of_another_site_is_refused(client, origin, path):
    answer = client.request("POST" if "api" in path else "GET", path, headers={"origin": origin})
    assert answer.status_code == 403
    assert "access-control-allow-origin" not in answer.headers


def test_a_link_from_another_site_is_refused_and_a_typed_address_is_not(client):
    for site, status in (
        ("cross-site", 403),
        ("same-site", 403),
        ("none", 200),
        ("same-origin", 200),
    ):
        assert client.get("/", headers={"sec-fetch-site": site}).status_code == status


def test_no_other_site_may_ask_first(client):
    headers = {
        "origin": "https://evil.example",
        "access-control-request-method": "PUT",
        "access-control-request-headers": "x-bristle-token",
    }
    assert client.options("/api/cases", headers=headers).status_code == 403


@pytest.mark.parametrize("token", [None, "", "wrong", TOKEN + "x", TOKEN[:-1]])
def test_without_the_token_there_is_only_the_page(app, token):
    headers = {} if token is None else {"x-bristle-token": token}
    client = TestClient(app, base_url=f"http://127.0.0.1:{PORT}", headers=headers)
    for method, path in (
        ("POST", "/api/cases"),
        ("GET", "/api/cases/x"),
        ("PUT", "/api/cases/x/files"),
        ("GET", "/x"),
    ):
        assert client.request(method, path).status_code == 401
    # Neither the address nor a cookie stands for it.
    assert (
        client.post(
            f"/api/cases?token={TOKEN}", headers=headers | {"cookie": f"x-bristle-token={TOKEN}"}
        ).status_code
        == 401
    )
    page = client.get("/")
    assert (page.status_code, TOKEN in page.text, "set-cookie" in page.headers) == (
        200,
        False,
        False,
    )


def test_the_host_is_checked_before_reading(client):
    def never():
        raise AssertionError("the body was read")
        yield b""

    assert (
        client.put(
            "/api/cases/x/files", content=never(), headers={"host": "evil.example"}
        ).status_code
        == 421
    )


def test_the_policy_allows_exactly_the_scripts_of_the_page(client):
    answer = client.get("/")
    rules = dict(
        rule.strip().split(" ", 1) for rule in answer.headers["content-security-policy"].split(";")
    )
    for element, rule in (("script", "script-src"), ("style", "style-src")):
        (text,) = re.findall(rf"<{element}>(.*?)</{element}>", answer.text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert rules[rule] == f"'sha256-{digest}'"
    assert (
        rules.items()
        >= {"default-src": "'none'", "frame-ancestors": "'none'", "connect-src": "'self'"}.items()
    )
    assert "unsafe" not in answer.headers["content-security-policy"]
    assert (answer.headers["cache-control"], answer.headers["referrer-policy"]) == (
        "no-store",
        "no-referrer",
    )


def test_the_page_is_self_contained(client):
    page = client.get("/").text
    assert not re.search(
        r"https?:|//[a-z]+\.|@import|XMLHttp|importScripts|eval\(|innerHTML = `", page
    )
    assert set(re.findall(r'(?:src|href)="([^"$]*)"', page)) == {"data:,", "#step-1", "#excite"}


def test_every_answer_has_security_headers(client):
    for answer in (
        client.get("/"),
        client.post("/api/cases"),
        client.get("/api/cases/none"),
        client.get("/nowhere"),
    ):
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert "default-src 'none'" in answer.headers["content-security-policy"]
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"


# --- How long a connection is waited for, and which one makes room where there are too many, by a clock that a test turns


PROTOCOL = protocol_with_limits(
    limits.Limits(strangers=2, stranger_seconds=4.0, silence_seconds=20.0)
)


@pytest.fixture
def connected(monkeypatch):
    """A function that returns a connection which begins at 100 s: without a request, or whose request had the token or had it not."""

    def connect(token=None, connections=None):
        protocol = object.__new__(PROTOCOL)
        protocol.now, protocol.later, protocol.done = 100.0, [], []
        timer = Some(cancel=lambda: protocol.done.append("cancelled"))
        call_later = lambda seconds, call: protocol.later.append((call.__name__, seconds)) or timer  # noqa: E731
        protocol.loop = Some(time=lambda: protocol.now, call_later=call_later)
        protocol.transport = Some(
            is_closing=lambda: "closing" in protocol.done,
            abort=lambda: protocol.done.append("aborted"),
        )
        protocol.scope = (
            None if token is None else {"state": {gate.HAS_TOKEN: True} if token else {}}
        )
        protocol.cycle, protocol.connections = None, set() if connections is None else connections
        protocol.connections.add(protocol)
        protocol.connection_made(protocol.transport)
        return protocol

    for name in ("connection_made", "connection_lost", "on_response_complete"):
        monkeypatch.setattr(H11Protocol, name, lambda self, *event: None)
    return connect


@pytest.mark.parametrize(
    ("token", "seconds", "done"),
    [
        (None, 3.9, []),
        (None, 4.0, ["aborted"]),
        (False, 4.0, ["aborted"]),
        (True, 4.0, []),
        (True, 20.0, ["aborted"]),
    ],
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
    authorised, old, middle, young = (
        connected(token, connections) for token in (True, False, None, None)
    )
    for age, protocol in enumerate((authorised, old, middle, young)):
        protocol._connected_at = age
    young._make_room()
    assert [item.done for item in (authorised, old, middle, young)] == [[], ["aborted"], [], []]
    connections.discard(old)
    young._make_room()
    assert middle.done == young.done == []
