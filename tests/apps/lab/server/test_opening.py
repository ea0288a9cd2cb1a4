"""A browser is opened with a file that leads to the lab, once: the token stands in no arguments of a process."""

import base64
import hashlib
import re
import stat
from pathlib import Path

import pytest
from starlette.testclient import TestClient
from tests.apps.lab.browser import awaited, browser
from tests.apps.lab.server.yard import PORT, TOKEN, lab_process, served

from bristle.apps.lab.server import gate

ELSEWHERE = {
    "sec-fetch-site": "cross-site",
    "sec-fetch-mode": "navigate",
    "sec-fetch-dest": "document",
}
"""What Chromium sends as it is led on by a file."""
BROWSER = """#!/bin/sh
printf '%s\\n' "$@" > {told}.new && mv {told}.new {told}
while [ ! -e {told}.seen ]; do sleep 0.05; done
"""


@pytest.fixture
def opening(app):
    yield app.state.opening
    app.state.opening.end()


@pytest.fixture
def client(app):
    return TestClient(app, base_url=f"http://127.0.0.1:{PORT}", headers=ELSEWHERE)


def led_to(file):
    """Return path and fragment of the address that a file leads to."""
    (address,) = re.findall(r'content="0; url=([^"]*)"', file.read_text())
    base, _, rest = address.removeprefix("http://").partition("/")
    assert base == f"127.0.0.1:{PORT}"
    path, _, fragment = rest.partition("#")
    return f"/{path}", fragment


def test_an_unused_file_is_removed_after_a_minute(opening, client, monkeypatch):
    begun = []

    class Timer:
        daemon = False

        def __init__(self, seconds, function):
            self.seconds, self.function = seconds, function

        def start(self):
            begun.append(self)

    monkeypatch.setattr(gate.threading, "Timer", Timer)
    file = opening.offer()
    path, _ = led_to(file)
    (timer,) = begun
    assert (timer.seconds, timer.daemon, file.exists()) == (60.0, True, True)
    timer.function()
    assert not file.exists()
    assert client.get(path).status_code == 404


def test_the_file_is_for_this_user_only_and_leads_to_the_page_with_the_token(opening, client):
    file = opening.offer()
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    path, fragment = led_to(file)
    answer = client.get(path)
    assert (fragment, answer.status_code, TOKEN in answer.text) == (TOKEN, 200, False)
    (script,) = re.findall("<script>(.*?)</script>", answer.text)
    assert script == 'location.replace("/" + location.hash)'
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert answer.headers["content-security-policy"] == (
        f"default-src 'none'; script-src 'sha256-{digest}'; frame-ancestors 'none'"
    )


def test_after_its_use_the_file_is_removed_and_its_ticket_invalid(opening, client):
    file = opening.offer()
    path, _ = led_to(file)
    wrong = [f"/opened/{ticket}" for ticket in ("x", path.rpartition("/")[2][:-1], "%c3%a9", "")]
    assert [client.get(address).status_code for address in wrong] == [404] * 4
    assert client.get(path, headers={"host": "evil.example"}).status_code == 421
    assert file.exists()
    assert client.get(path).status_code == 200
    assert not file.exists()
    assert client.get(path).status_code == 404
    # It is the entrance that may be come to from elsewhere.
    assert client.get("/").status_code == 403


def test_an_existing_link_is_not_written_through(opening, tmp_path):
    (tmp_path / "open.html").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FileExistsError):
        opening.offer()
    assert not (tmp_path / "elsewhere").exists()


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/cmdline").exists(), reason="reads the arguments of processes in /proc"
)
def test_no_process_has_the_token_in_its_arguments(tmp_path):
    (tmp_path / "temporary").mkdir()
    script, message = tmp_path / "browser", tmp_path / "told"
    script.write_text(BROWSER.format(told=message))
    script.chmod(0o700)
    with lab_process(tmp_path / "temporary", BROWSER=str(script)) as (process, _, token):
        awaited(message.exists, 20.0)
        arguments = {
            place.name: read(place / "cmdline")
            for place in Path("/proc").iterdir()
            if place.name.isdigit()
        }
        (values,) = message.read_text().splitlines()
        assert [number for number, text in arguments.items() if token in text] == []
        # That of the browser is among them.
        assert any(values in text for text in arguments.values())
        file = Path(values.removeprefix("file://"))
        assert token in file.read_text()
        assert [stat.S_IMODE(each.stat().st_mode) for each in (file, file.parent)] == [0o600, 0o700]
        # The browser that was opened is not waited for.
        process.terminate()
        assert process.wait(20) == 0
        assert not file.parent.exists()
        message.with_suffix(".seen").touch()


def read(place):
    try:
        return place.read_bytes().decode(errors="replace")
    except OSError:  # the process is gone
        return ""


@pytest.mark.slow
def test_chromium_comes_from_the_file_to_the_lab_and_may_load_it_again(tmp_path):
    with served() as server, browser(tmp_path / "profile") as tab:
        file = server.opening.offer()
        tab.call("Page.navigate", url=file.as_uri())
        for _ in range(2):
            assert tab.waits("state !== null && location.hash").startswith(f"#{TOKEN}.")
            assert tab.run("location.pathname") == "/"
            assert not file.exists()
            tab.run("state = null")
            tab.reload()
        assert tab.complaints() == []
