"""A server of the lab in this process, what speaks to it, and workers that do what a test wants."""

import os
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from urllib.parse import quote

import httpx2 as httpx
from tests.apps.lab.browser import awaited

from bristle.apps.lab.server.application import application
from bristle.apps.lab.server.limits import Limits
from bristle.apps.lab.server.run import listening_on, own_folder, server_of

TOKEN = "a-token-of-the-tests"
PORT = 8765


@dataclass
class Served:
    """A server that runs, and its address."""

    port: int
    cases: object
    opening: object

    @property
    def base(self):
        return f"http://127.0.0.1:{self.port}"

    @property
    def address(self):
        return f"{self.base}/#{TOKEN}"

    def client(self):
        return httpx.Client(
            base_url=self.base, headers={"x-bristle-token": TOKEN}, timeout=60, trust_env=False
        )

    def raw(self, *pieces):
        """Return a connection on which these pieces were sent."""
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=30)
        for piece in pieces:
            connection.sendall(piece)
        return connection


@contextmanager
def served(limits=Limits(), keep_alive=5):  # noqa: B008  (it is frozen)
    with listening_on(0) as listening, own_folder() as folder:
        port = listening.getsockname()[1]
        app = application(folder, TOKEN, port, limits)
        server = server_of(app, limits)
        server.config.timeout_keep_alive = keep_alive
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            awaited(lambda: server.started)
            yield Served(port, app.state.cases, app.state.opening)
        finally:
            server.should_exit = True
            thread.join(20)
            assert not thread.is_alive()


def begun(client):
    """Return the path of a new analysis."""
    return f"/api/cases/{client.post('/api/cases').json()['id']}"


def put(client, case, data, name="log.csv", role="fit"):
    headers = {"x-bristle-name": quote(name, safe=""), "x-bristle-role": role}
    return client.put(f"{case}/files", content=data, headers=headers)


def ended(client, case, task, seconds=120, **options):
    """Start a job, wait for its end and return where the analysis stands."""
    answer = client.post(f"{case}/jobs", json={"task": task, "options": options})
    assert answer.status_code == 202, answer.text
    return settled(client, case, seconds)


def settled(client, case, seconds=120):
    awaited(lambda: client.get(case).json()["job"]["state"] != "runs", seconds, case)
    return client.get(case).json()


@contextmanager
def lab_process(folder, *options, **environment):
    """Give a process of ``bristle lab --serve`` whose temporary folder this is, and what speaks to it once it does."""
    code = "import sys; from bristle.cli.main import main; sys.exit(main(['lab', '--serve', *sys.argv[1:]]))"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"TMPDIR": str(folder)} | environment,
    )
    try:
        base, _, token = process.stdout.readline().strip().partition("/#")
        assert token, process.stderr.read()
        with httpx.Client(
            base_url=base,
            headers={"x-bristle-token": token},
            timeout=60,
            trust_env=False,
            transport=httpx.HTTPTransport(retries=5),
        ) as client:
            yield process, client, token
    finally:
        process.kill()
        process.communicate()


WORKER = """
import sys, time, os, types
tasks = types.ModuleType("bristle.apps.lab.server.tasks")
class Errand:
    @classmethod
    def of(cls, request, report, interruptible, is_cancelled):
        errand = cls()
        errand.__dict__.update(request, report=report, interruptible=interruptible, is_cancelled=is_cancelled)
        from pathlib import Path
        errand.folder = Path(request["folder"])
        return errand
def work(errand):
{body}
tasks.Errand, tasks.TASKS = Errand, dict.fromkeys(("look", "check", "identify", "predict", "export", "excite", "tune"), work)
tasks.DATA = "data.json"
sys.modules["bristle.apps.lab.server.tasks"] = sys.modules["bristle.apps.lab.server.errand"] = tasks
from bristle.apps.lab.server.worker import main
main()
"""


def worker_that(body):
    """Return the code of a worker whose every task is this body; it loads nothing that takes time."""
    return WORKER.replace("{body}", "\n".join(f"    {line}" for line in body.strip().splitlines()))
