"""Firefox without a window, spoken to by Marionette: what a page computes there, and what it complains of."""

import json
import socket
import subprocess
import time
from contextlib import contextmanager

PATIENCE = 60.0  # [s]
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
        return self.call("WebDriver:ExecuteScript", script=script, args=list(arguments), sandbox="default")["value"]

    def complaints(self, name):
        """Return what stands in the console of a page of this name."""
        self.call("Marionette:SetContext", value="chrome")
        result = self.call("WebDriver:ExecuteScript", script=COMPLAINTS, args=[name], sandbox="system")["value"]
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
        ["firefox-esr", "--headless", "--marionette", "--remote-allow-system-access", "--no-remote", "--profile", str(profile)],
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
