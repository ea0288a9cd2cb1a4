"""Who is let in: this machine's own page, with its token, and nobody else."""

import base64
import hashlib
import re

import pytest
from starlette.testclient import TestClient
from tests.serve.yard import TOKEN

from bristle.server.application import application
from bristle.server.limits import Limits

PORT = 8765
OWN = {"x-bristle-token": TOKEN}


@pytest.fixture(scope="module")
def app(tmp_path_factory):
    return application(tmp_path_factory.mktemp("lab"), TOKEN, PORT, Limits())


@pytest.fixture
def client(app):
    return TestClient(app, base_url=f"http://127.0.0.1:{PORT}", headers=OWN)


@pytest.mark.parametrize("host", [f"127.0.0.1:{PORT}", f"localhost:{PORT}"])
def test_this_machine_is_let_in(client, host):
    assert client.post("/api/cases", headers={"host": host, "origin": f"http://{host}"}).status_code == 201


@pytest.mark.parametrize(
    "host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:80", f"127.0.0.1.evil.example:{PORT}", ""]
)
@pytest.mark.parametrize("path", ["/", "/api/cases", "/shown/x"])
def test_a_name_that_was_bound_to_this_machine_is_refused_with_and_without_the_token(client, host, path):
    # DNS rebinding: the browser believes that it speaks to the other site, and says so.
    answer = client.request("POST" if "api" in path else "GET", path, headers={"host": host})
    assert answer.status_code == 421
    assert "not this machine" in answer.json()["message"]


@pytest.mark.parametrize("origin", ["https://evil.example", "null", f"http://evil.example:{PORT}", "http://127.0.0.1"])
@pytest.mark.parametrize("path", ["/", "/api/cases"])
def test_a_page_of_another_site_is_refused(client, origin, path):
    answer = client.request("POST" if "api" in path else "GET", path, headers={"origin": origin})
    assert answer.status_code == 403
    assert "access-control-allow-origin" not in answer.headers


def test_a_link_from_another_site_is_refused_and_a_typed_address_is_not(client):
    for site, status in (("cross-site", 403), ("same-site", 403), ("none", 200), ("same-origin", 200)):
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
    for method, path in (("POST", "/api/cases"), ("GET", "/api/cases/x"), ("PUT", "/api/cases/x/files"), ("GET", "/x")):
        assert client.request(method, path).status_code == 401
    # Neither the address nor a cookie stands for it.
    assert client.post(f"/api/cases?token={TOKEN}", headers=headers | {"cookie": f"x-bristle-token={TOKEN}"}).status_code == 401
    page = client.get("/")
    assert page.status_code == 200
    assert TOKEN not in page.text
    assert "set-cookie" not in page.headers


def test_the_host_is_checked_before_reading(client):
    def never():
        raise AssertionError("the body was read")
        yield b""

    assert client.put("/api/cases/x/files", content=never(), headers={"host": "evil.example"}).status_code == 421


def test_the_policy_allows_exactly_the_scripts_of_the_page(client):
    answer = client.get("/")
    rules = dict(rule.strip().split(" ", 1) for rule in answer.headers["content-security-policy"].split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["frame-ancestors"] == "'none'"
    for element, rule in (("script", "script-src"), ("style", "style-src")):
        (text,) = re.findall(rf"<{element}>(.*?)</{element}>", answer.text, re.DOTALL)
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert rules[rule] == f"'sha256-{digest}'"
    assert rules["connect-src"] == "'self'"
    assert "unsafe" not in answer.headers["content-security-policy"]
    assert answer.headers["cache-control"] == "no-store"
    assert answer.headers["referrer-policy"] == "no-referrer"


def test_the_page_is_self_contained(client):
    page = client.get("/").text
    assert not re.search(r"https?:|//[a-z]+\.|@import|XMLHttp|importScripts|eval\(|innerHTML = `", page)
    assert set(re.findall(r'(?:src|href)="([^"$]*)"', page)) == {"data:,", "#step-1", "#excite"}


def test_every_answer_has_security_headers(client):
    for answer in (client.get("/"), client.post("/api/cases"), client.get("/api/cases/none"), client.get("/nowhere")):
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert "default-src 'none'" in answer.headers["content-security-policy"]
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"
