"""A job: work in a process of its own, which can be ended, and whose end is no end of the application."""

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from bristle.core.errors import in_one_line, shortened
from bristle.server.limits import Limits

TAIL = 2000  # of what a library complains of
CODE = "from bristle.server.worker import main; main()"


class Job:
    """Work in a process of its own."""

    def __init__(self, task: str, limits: Limits) -> None:
        self.task, self._limits = task, limits
        self.state, self.share, self.text, self.message = "runs", 0.0, "starting", ""
        self.facts: dict[str, Any] = {}
        self._begun, self._ended = time.monotonic(), 0.0
        self._cancelled = self._killed = self._late = self._answered = False
        self._process: asyncio.subprocess.Process | None = None

    @property
    def runs(self) -> bool:
        """Whether it has not ended."""
        return self.state == "runs"

    def as_data(self) -> dict[str, Any]:
        """Return what the page is told."""
        facts = {name: getattr(self, name) for name in ("task", "state", "share", "text", "message")}
        seconds = (self._ended or time.monotonic()) - self._begun
        return facts | {"seconds": round(seconds, 1), "cancelled": self._cancelled}

    async def run(self, request: Mapping[str, Any]) -> bool:
        """Do the work; return whether it was done."""
        code, complaint = 1, ""
        try:
            code, complaint = await self._ended_with(request)
        except Exception as error:  # noqa: BLE001  (whatever it is, the page is told, and the application goes on)
            self.message = f"the job could not be run: {error}"
        self._ended = time.monotonic()
        if self._answered and code == 0:
            self.state = "done"
        else:
            self.state = "cancelled" if self._killed or (self._cancelled and not self._late) else "failed"
            self.message = self.message or self._ending(code, complaint)
        return self.state == "done"

    async def _ended_with(self, request: Mapping[str, Any]) -> tuple[int, str]:
        """Let a process do the work; return its exit code and the last line that it complained of."""
        self._process = process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-P",
            "-c",
            CODE,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(place for place in sys.path if place)},
            limit=2**20,
            # A group of its own: Ctrl-C goes to the server, which ends its jobs.
            start_new_session=sys.platform != "win32",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        asking = asyncio.get_running_loop().call_later(max(0.0, self._limits.job_seconds - self._limits.grace_seconds), self.cancel)
        complaints = asyncio.create_task(_last_of(process.stderr))
        try:
            async with asyncio.timeout(self._limits.job_seconds):
                await self._listen(process, {**request, "task": self.task})
                await process.wait()
        except TimeoutError:
            self._late = True
        finally:
            asking.cancel()
            _kill(process)
            code, complaint = await process.wait(), await complaints
        return code, complaint

    async def _listen(self, process: asyncio.subprocess.Process, request: Mapping[str, Any]) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        if self._killed:  # while it was starting
            _kill(process)
        with suppress(ConnectionError):
            process.stdin.write(json.dumps(request).encode() + b"\n")
            await process.stdin.drain()
        while line := await process.stdout.readline():
            event = json.loads(line)
            if "share" in event:
                self.share, self.text = float(event["share"]), str(event["text"])
            elif "facts" in event:
                self.facts, self.share, self._answered = dict(event["facts"]), 1.0, True
            else:
                self.message = str(event.get("refused", ""))

    def _ending(self, code: int, complaint: str) -> str:
        if self._killed:
            return "stopped"
        if self._late:
            return f"stopped after {self._limits.job_seconds:g} s. Take fewer models, or a shorter log"
        if code < 0:
            return (
                f"the process of this job was ended by signal {-code}, perhaps for want of memory. Nothing else is "
                "lost: run it again, or take a shorter log"
            )
        return f"the process of this job ended with code {code}. {complaint}".strip()

    def cancel(self) -> None:
        """Ask it to end with the best that it has."""
        if not self.runs or self._process is None or self._process.stdin is None:
            return
        self._cancelled = True
        with suppress(ConnectionError, RuntimeError):
            self._process.stdin.write(b"cancel\n")

    def kill(self) -> None:
        """End it at once."""
        self._killed = True
        if self._process is not None:
            _kill(self._process)


def _kill(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        with suppress(ProcessLookupError):
            process.kill()


async def _last_of(stream: asyncio.StreamReader | None) -> str:
    """Return the last line of what a process complained of."""
    tail = b""
    while stream is not None and (piece := await stream.read(TAIL)):
        tail = (tail + piece)[-TAIL:]
    lines = tail.decode("utf-8", "replace").strip().splitlines()
    return in_one_line(shortened(lines[-1], 300)) if lines else ""
