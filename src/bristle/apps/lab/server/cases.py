"""Open analyses with their files and results, the job in a separate process, and the parsing of requests."""

import asyncio
import json
import os
import secrets
import shutil
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from starlette.requests import ClientDisconnect, Request

from bristle.apps.lab.server.limits import RESTORING, Limits, RefusedRequestError
from bristle.apps.lab.server.tune import TunedMachine
from bristle.core import in_one_line, shortened, size_in_words

DAY = 86400.0  # [s]
TAIL = 2000  # of the error output of a library
CODE = "from bristle.apps.lab.server.worker import main; main()"


class Job:
    """Work in a separate process."""

    def __init__(self, task: str, limits: Limits) -> None:
        self.task, self.restores = task, task in RESTORING
        self._limits = replace(limits, job_seconds=DAY) if self.restores else limits
        self.state, self.share, self.text, self.message = "runs", 0.0, "starting", ""
        self.facts: dict[str, Any] = {}
        self._begun, self._ended = time.monotonic(), 0.0
        self._cancelled = self._killed = self._late = self._answered = False
        self._process: asyncio.subprocess.Process | None = None

    @property
    def runs(self) -> bool:
        """Whether the job is running."""
        return self.state == "runs"

    def as_data(self) -> dict[str, Any]:
        """Return the state for the page."""
        facts = {
            name: getattr(self, name) for name in ("task", "state", "share", "text", "message")
        }
        seconds = (self._ended or time.monotonic()) - self._begun
        return facts | {"seconds": round(seconds, 1), "cancelled": self._cancelled}

    async def run(self, request: Mapping[str, Any]) -> bool:
        """Do the work; return whether it succeeded."""
        code, complaint = 1, ""
        try:
            code, complaint = await self._ended_with(request)
        except Exception as error:  # noqa: BLE001  (the page shows any error, and the application continues)
            self.message = f"bristle could not run the job: {error}"
        self._ended = time.monotonic()
        if self._answered and code == 0:
            self.state = "done"
        else:
            self.state = (
                "cancelled" if self._killed or (self._cancelled and not self._late) else "failed"
            )
            self.message = self.message or self._ending(code, complaint)
        return self.state == "done"

    async def _ended_with(self, request: Mapping[str, Any]) -> tuple[int, str]:
        """Run the work in a process; return its exit code and the last line of its error output."""
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
            # A separate group: Ctrl-C goes to the server, which ends its jobs.
            start_new_session=sys.platform != "win32",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        asking = asyncio.get_running_loop().call_later(
            max(0.0, self._limits.job_seconds - self._limits.grace_seconds), self.cancel
        )
        complaints = asyncio.create_task(_last_of(process.stderr))
        try:
            async with asyncio.timeout(self._limits.job_seconds):
                await self._listen(process, {**request, "task": self.task})
                await process.wait()
        except TimeoutError:
            self._late = True
        finally:
            asking.cancel()
            if not self.restores:
                _kill(process)
            elif process.returncode is None:  # the server ends
                self.cancel()
            code, complaint = await process.wait(), await complaints
        return code, complaint

    async def _listen(
        self, process: asyncio.subprocess.Process, request: Mapping[str, Any]
    ) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        if self._killed:  # during its start
            _kill(process)
        with suppress(ConnectionError):
            process.stdin.write(
                json.dumps(request).encode() + (b"\ncancel\n" if self._cancelled else b"\n")
            )
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
            return (
                f"stopped after {self._limits.job_seconds:g} s. Use fewer models, or a shorter log"
            )
        if code < 0:
            return (
                f"signal {-code} ended the process of this job, perhaps because memory ran out. The other results remain. "
                "Run the job again, or use a shorter log"
            )
        return f"the process of this job ended with code {code}. {complaint}".strip()

    def cancel(self) -> None:
        """Ask the job to end with its best result."""
        self._cancelled = self._cancelled or self.restores
        if not self.runs or self._process is None or self._process.stdin is None:
            return
        self._cancelled = True
        with suppress(ConnectionError, RuntimeError):
            self._process.stdin.write(b"cancel\n")

    def kill(self) -> None:
        """End the job at once; a job that may write on a machine restores it first."""
        if self.restores:
            self.cancel()
            return
        self._killed = True
        if self._process is not None:
            _kill(self._process)


def _kill(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        with suppress(ProcessLookupError):
            process.kill()


async def _last_of(stream: asyncio.StreamReader | None) -> str:
    """Return the last line of the error output of a process."""
    tail = b""
    while stream is not None and (piece := await stream.read(TAIL)):
        tail = (tail + piece)[-TAIL:]
    lines = tail.decode("utf-8", "replace").strip().splitlines()
    return in_one_line(shortened(lines[-1], 300)) if lines else ""


async def stored(request: Request, target: Path, most: int, silence: float) -> int:
    """Write the body of a request to a new file and return its size [byte]."""
    size = 0
    try:
        with target.open("xb") as file:
            async for piece in _pieces(request, most, silence):
                size += len(piece)
                await asyncio.to_thread(file.write, piece)
    except BaseException:
        target.unlink(missing_ok=True)
        raise
    return size


async def json_of(request: Request, most: int, silence: float) -> dict[str, Any]:
    """Return the body of a request as a JSON object, or refuse it."""
    text = b"".join([piece async for piece in _pieces(request, most, silence)])
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise RefusedRequestError(400, "must be a JSON object", path="request")
    return data


def announced_by(request: Request) -> int:
    """Return the size of the body in the header, or 0 without one [byte]; h11 accepts only digits."""
    return int(request.headers.get("content-length", 0))


async def _pieces(request: Request, most: int, silence: float) -> AsyncIterator[bytes]:
    too_large = RefusedRequestError(
        413,
        "is larger than allowed",
        path="file",
        allowed=f"up to {size_in_words(most)}",
        mend='Shorten the log, or start bristle lab again with BRISTLE_SIZE_LIMIT="2 GB" in the environment',
    )
    if announced_by(request) > most:
        raise too_large
    size, stream = 0, request.stream()
    try:
        while True:
            try:
                piece = await asyncio.wait_for(anext(stream), silence)
            except StopAsyncIteration:
                return
            size += len(piece)
            if size > most:
                raise too_large
            yield piece
    except TimeoutError:
        raise RefusedRequestError(
            408, f"has sent no data for {silence:g} s", path="request"
        ) from None
    except ClientDisconnect:
        raise RefusedRequestError(400, "ended before all data arrived", path="request") from None


ROLES = ("fit", "held_out", "axis")  # use of a file: fit, prediction only, description of the axis
# Result -> its inputs. A result becomes old when an input changes: a file, the loop in the axis file, the identified model.
DEPENDS = {
    "looked": ("fit", "axis"),
    "checked": ("fit", "axis", "held_out"),
    "identified": ("fit", "axis"),
    "predicted": ("fit", "axis", "held_out"),
    "compensated": ("fit", "axis", "loop", "model"),
    "exported": ("fit", "axis"),
    "excited": (),
    **dict.fromkeys(("planned", "tuned", "undone"), ("machine",)),
}


@dataclass(frozen=True)
class StoredFile:
    """A dropped file. Its label is its name for the user, and never a path on this machine."""

    number: int
    label: str
    role: str
    size: int
    place: Path

    def as_data(self) -> dict[str, Any]:
        """Return the data for the page."""
        return {"number": self.number, "label": self.label, "role": self.role, "size": self.size}


@dataclass(frozen=True)
class Part:
    """The result of a job."""

    revision: int
    folder: Path
    facts: Mapping[str, Any]
    made_of: tuple[int, ...]


@dataclass
class Case:
    """One analysis: from logs to drive tables."""

    identifier: str
    folder: Path
    files: dict[int, StoredFile] = field(default_factory=dict)
    axis: str | None = None
    axis_label: str = "axis.toml"
    parts: dict[str, Part] = field(default_factory=dict)
    job: Job | None = None
    machine: TunedMachine | None = None
    turn: asyncio.Lock = field(default_factory=asyncio.Lock)
    seen_at: float = field(default_factory=time.monotonic)
    _numbers: int = 0
    _changes: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys((*ROLES, "loop", "model", "machine"), 0)
    )

    def number(self) -> int:
        """Return a number that is new in this analysis."""
        self._numbers += 1
        return self._numbers

    def changed(self, role: str) -> None:
        """Record a change of the files of a role, or of another input."""
        self._changes[role] += 1

    def inputs_of(self, part: str) -> tuple[int, ...]:
        """Return how often each input of a part has changed."""
        return tuple(self._changes[role] for role in DEPENDS[part])

    def is_old(self, name: str) -> bool:
        """Return whether an input of a part has changed since."""
        return name in self.parts and self.parts[name].made_of != self.inputs_of(name)

    def logs(self, *roles: str) -> list[StoredFile]:
        """Return the files of these roles, in order."""
        return [file for file in self.files.values() if file.role in roles]

    def keep(self, name: str, part: Part) -> None:
        """Keep the result of a job, and remove the earlier result."""
        before = self.parts.get(name)
        self.parts[name] = part
        if before is not None:
            shutil.rmtree(before.folder, ignore_errors=True)

    def as_data(self) -> dict[str, Any]:
        """Return the complete state for the page."""
        return {
            "id": self.identifier,
            "files": [file.as_data() for file in self.files.values()],
            "axis": {"label": self.axis_label, "text": self.axis},
            "parts": {
                name: {"revision": part.revision, "old": self.is_old(name), **part.facts}
                for name, part in self.parts.items()
            },
            "machine": None if self.machine is None else self.machine.names,
            "job": None if self.job is None else self.job.as_data(),
        }


class Cases:
    """All open analyses, in a separate folder."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder, self._limits, self._cases = folder, limits, dict[str, Case]()
        self.receiving = 0

    def __getitem__(self, identifier: str) -> Case:
        case = self._cases.get(identifier)
        if case is None:
            raise RefusedRequestError(
                404, "is no longer open", path="analysis", mend="Begin a new analysis"
            )
        case.seen_at = time.monotonic()
        return case

    def __iter__(self):
        return iter(list(self._cases.values()))

    def new(self) -> Case:
        """Return a new analysis. Remove an abandoned analysis to make room."""
        if len(self._cases) >= self._limits.cases:
            oldest = min(self, key=lambda case: case.seen_at)
            # Ten minutes without a tab.
            if time.monotonic() - oldest.seen_at < 600.0 or (
                oldest.job is not None and oldest.job.runs
            ):
                raise RefusedRequestError(
                    429,
                    f"{len(self._cases)} analyses are open",
                    path="analysis",
                    allowed=f"up to {self._limits.cases}",
                    mend="Close an analysis",
                )
            self.close(oldest)
        identifier = secrets.token_urlsafe(12)
        folder = self._folder / secrets.token_hex(8)
        folder.mkdir(mode=0o700)
        self._cases[identifier] = Case(identifier, folder)
        return self._cases[identifier]

    def close(self, case: Case) -> None:
        """Drop an analysis, and remove its files."""
        if case.job is not None:
            case.job.kill()
        del self._cases[case.identifier]
        shutil.rmtree(case.folder, ignore_errors=True)

    def room_for(self, case: Case, announced: int) -> int:
        """Return the largest size of the next file [byte]."""
        if len(case.files) >= self._limits.files:
            raise RefusedRequestError(
                413,
                f"the analysis has {len(case.files)} files already",
                path="file",
                allowed=f"up to {self._limits.files}",
                mend="Remove a file",
            )
        stored_size = (
            sum(file.size for open_case in self for file in open_case.files.values())
            + self.receiving
        )
        available = self._limits.total_size - stored_size
        if available <= 0 or available < announced <= self._limits.file_size:
            raise RefusedRequestError(
                413, "all files together are too large", path="file", mend="Remove some files"
            )
        return min(self._limits.file_size, available)


def label_of(name: str) -> str:
    r"""Return the label of a file from its name in the browser: without folders, printable, short.

    Examples
    --------
    >>> label_of("..%2F..%2Fetc%2Fpasswd"), label_of("C:%5Caxis%0A.csv"), label_of("..")
    ('passwd', 'axis .csv', 'log')
    """
    last = unquote(name).replace("\\", "/").rpartition("/")[2]
    plain = "".join(letter if letter.isprintable() else " " for letter in last).strip()
    stem, dot, ending = plain.rpartition(".")
    return f"{shortened(stem, 100)}{dot}{ending[:10]}" if plain.strip(".") else "log"
