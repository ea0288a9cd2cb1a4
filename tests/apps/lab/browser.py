"""Browsers without a window, Chromium over a pipe and Firefox by Marionette: what a page does, asks for and complains of."""

import json
import os
import shutil
import socket
import subprocess
import time
from contextlib import ExitStack, contextmanager

import pytest

PATIENCE = 60.0  # [s]
SETTLED = "new Promise((done) => setTimeout(done, 150))"
NO_DOCUMENT = "Cannot find default execution context"


def awaited(holds, seconds=PATIENCE, words=""):
    """Return what a condition gives once that is true."""
    until = time.monotonic() + seconds
    while not (value := holds()):
        assert time.monotonic() < until, words
        time.sleep(0.02)
    return value


class Browser:
    """A tab, and the events of it so far."""

    def __init__(self, send_to, read_from):
        self._send, self._read, self._rest, self._number, self.session = (
            send_to,
            read_from,
            b"",
            0,
            None,
        )
        self.events = []

    def call(self, method, **parameters):
        """Return what a method of the protocol gives."""
        answer = self._answer(method, parameters)
        assert "error" not in answer, answer["error"]
        return answer["result"]

    def _answer(self, method, parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self._send, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                return answer
            self.events.append(answer)

    def _next(self):
        while b"\0" not in self._rest:
            part = os.read(self._read, 1 << 20)
            assert part, "the browser is gone"
            self._rest += part
        line, _, self._rest = self._rest.partition(b"\0")
        return json.loads(line)

    def wait_for(self, method):
        """Return the first event of this name from now on."""
        while True:
            event = self._next()
            self.events.append(event)
            if event.get("method") == method:
                return event["params"]

    def open(self, address):
        """Go to a page and wait until it is there, and until the lab has its data."""
        self.call("Page.navigate", url=address)
        self.wait_for("Page.loadEventFired")
        self.run("typeof begun === 'undefined' ? 0 : begun")

    def open_anew(self, address):
        """Go to a page from nowhere, as from a link, and wait until it has drawn."""
        self.open("about:blank")
        self.open(address)
        self.run(SETTLED)

    def drag(self, start, *steps, modifiers=0):
        """Press the left button at a place, move through others, and let it go at the last."""
        kinds = ["mousePressed", *["mouseMoved"] * len(steps), "mouseReleased"]
        for kind, (x, y) in zip(kinds, (start, *steps, steps[-1]), strict=True):
            self.call(
                "Input.dispatchMouseEvent",
                type=kind,
                x=x,
                y=y,
                button="left",
                buttons=1,
                clickCount=1,
                modifiers=modifiers,
            )
        self.run(SETTLED)

    def reload(self):
        """Load the page again and wait until it is there."""
        self.call("Page.reload")
        self.wait_for("Page.loadEventFired")

    def run(self, expression):
        """Return the value of an expression, awaited where it is a promise; between two documents there is none."""
        parameters = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        until = time.monotonic() + PATIENCE
        while (
            NO_DOCUMENT
            in str((answer := self._answer("Runtime.evaluate", parameters)).get("error"))
            and time.monotonic() < until
        ):
            time.sleep(0.02)
        assert "error" not in answer, answer["error"]
        values = answer["result"]
        assert "exceptionDetails" not in values, values["exceptionDetails"]
        return values["result"].get("value")

    def waits(self, expression, seconds=PATIENCE):
        """Return the value of an expression once it is true; one that fails is not true yet."""
        return awaited(
            lambda: self.run(
                f"(() => {{ try {{ return {expression}; }} catch {{ return null; }} }})()"
            ),
            seconds,
            expression,
        )

    def asked_for(self):
        """Return the addresses of all requests."""
        return [
            e["params"]["request"]["url"]
            for e in self.events
            if e.get("method") == "Network.requestWillBeSent"
        ]

    def complaints(self):
        """Return what stands in the console, and what was not caught."""
        names = ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
        return [event["params"] for event in self.events if event.get("method") in names]


@contextmanager
def browser(profile, *, width=1366, height=768, dark=False, moving=False):
    """Give a browser with one empty tab of this size, or skip the test; unless `moving`, its user prefers reduced motion."""
    if shutil.which("chromium") is None or os.name != "posix":
        pytest.skip("needs chromium")
    to_read, to_send = os.pipe()
    from_read, from_write = os.pipe()
    fixed = (os.dup2(to_read, 63), os.dup2(from_write, 64))  # out of the way of 3 and 4
    command = [
        "chromium",
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--remote-debugging-pipe",
        "--no-first-run",
        f"--user-data-dir={profile}",
        f"--window-size={width},{height}",
        "about:blank",
    ]
    process = subprocess.Popen(
        ["bash", "-c", 'exec "$@" 3<&63 4>&64 63<&- 64>&-', "bash", *command],
        pass_fds=fixed,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for number in (to_read, from_write, *fixed):
        os.close(number)
    tab = Browser(to_send, from_read)
    try:
        target = tab.call("Target.createTarget", url="about:blank")["targetId"]
        tab.session = tab.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            tab.call(f"{domain}.enable")
        tab.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        motion = {
            "name": "prefers-reduced-motion",
            "value": "no-preference" if moving else "reduce",
        }
        tab.call("Emulation.setEmulatedMedia", features=[scheme, motion])
        yield tab
        tab.session = None
        tab.call("Browser.close")
    finally:
        os.close(to_send)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        os.close(from_read)


@pytest.fixture
def shown(tmp_path):
    """A function that gives a tab which shows an address; in the end its page has nothing to complain of, unless it may."""
    quiet = []
    with ExitStack() as stack:

        def show(address, *, complains=False, **how):
            tab = stack.enter_context(browser(tmp_path / "profile", **how))
            tab.open(address)
            tab.run(SETTLED)
            quiet.extend([tab] * (not complains))
            return tab

        yield show
        assert [tab.complaints() for tab in quiet] == [[]] * len(quiet)


# --- Firefox, spoken to by Marionette


COMPLAINTS = """
return Services.console.getMessageArray().filter((message) => message instanceof Ci.nsIScriptError)
  .filter((message) => `${message.sourceName} ${message.errorMessage}`.includes(arguments[0]))
  .map((message) => message.errorMessage);
"""


class Firefox:
    """A tab."""

    def __init__(self, connection):
        self._connection, self._rest, self._number = connection, b"", 0
        self._next()  # what it says of itself

    def call(self, method, **parameters):
        """Return what a method of the protocol gives."""
        self._number += 1
        text = json.dumps([0, self._number, method, parameters]).encode()
        self._connection.sendall(f"{len(text)}:".encode() + text)
        _, _, error, result = self._next()
        assert error is None, error
        return result

    def _next(self):
        while b":" not in self._rest:
            self._rest += self._connection.recv(1 << 20)
        size, _, self._rest = self._rest.partition(b":")
        while len(self._rest) < int(size):
            self._rest += self._connection.recv(1 << 20)
        text, self._rest = self._rest[: int(size)], self._rest[int(size) :]
        return json.loads(text)

    def run(self, script, *arguments):
        """Return what a script of the page returns, awaited where it is a promise."""
        return self.call(
            "WebDriver:ExecuteScript", script=script, args=list(arguments), sandbox="default"
        )["value"]

    def complaints(self, name):
        """Return what stands in the console of a page of this name."""
        self.call("Marionette:SetContext", value="chrome")
        result = self.call(
            "WebDriver:ExecuteScript", script=COMPLAINTS, args=[name], sandbox="system"
        )["value"]
        self.call("Marionette:SetContext", value="content")
        return result


@contextmanager
def firefox(profile):
    """Give Firefox with one empty tab."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    profile.mkdir()
    (profile / "user.js").write_text(
        f'user_pref("marionette.port", {port});\nuser_pref("datareporting.policy.dataSubmissionEnabled", false);\n'
    )
    process = subprocess.Popen(
        [
            "firefox-esr",
            "--headless",
            "--marionette",
            "--remote-allow-system-access",
            "--no-remote",
            "--profile",
            str(profile),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        with _connected(port) as connection:
            tab = Firefox(connection)
            tab.call("WebDriver:NewSession", capabilities={})
            yield tab
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _connected(port):
    end = time.monotonic() + PATIENCE
    while True:
        try:
            connection = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        except OSError:
            assert time.monotonic() < end, "Firefox does not answer"
            time.sleep(0.2)
        else:
            return connection
