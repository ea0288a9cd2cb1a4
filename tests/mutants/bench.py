"""Places where tests run: copies of the tree, each with one fault in it, several at a time."""

from __future__ import annotations

import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tests.mutants.mutations import Mutant, applied

__all__ = ["Bench", "Job", "Verdict", "abreast", "files_of"]

# Without the budget of fast tests: on a busy machine it would fail a test, and count a fault as noticed.
WITHOUT = ("-p", "no:cacheprovider", "-p", "no:tests.plugins.budget")
PYTEST = (sys.executable, "-m", "pytest", "-x", "-q", "-m", "not slow", *WITHOUT, "--tb=no")
LIMITED = ("sh", "-c", 'ulimit -t "$1"; shift; exec "$@"', "sh")  # processors work no longer [s]
PASSED, NOTHING_COLLECTED = 0, 5
POLL = 0.05  # [s]
WAITING = 20.0  # how many times as long as its processor works a job may last, on a machine with other work


class Job(NamedTuple):
    """Test files to run, with a fault or without one, and how long a processor may work on them [s]."""

    tests: tuple[str, ...]
    limit: float
    mutant: Mutant | None = None


class Verdict(NamedTuple):
    """What became of a job: the exit code of its tests, None where they were ended; work [s]; what failed first."""

    code: int | None
    seconds: float
    failed: str


def files_of(root: Path) -> list[str]:
    """Return the files of a working tree that belong to it, those that are not committed yet included."""
    listed = [
        "git",
        "-C",
        str(root),
        "ls-files",
        "-z",
        "--cached",
        "--others",
        "--exclude-standard",
    ]
    names = subprocess.run(listed, capture_output=True, check=True, text=True).stdout.split("\0")
    return [name for name in names if name and (root / name).is_file()]


@dataclass
class Bench:
    """A copy of the tree, with a cache of compiled code of its own.

    Parameters
    ----------
    root : Path
        The working tree; it is read and nothing else.
    place : Path
        A folder for the copy.
    """

    root: Path
    place: Path
    job: Job | None = None
    _process: subprocess.Popen[bytes] | None = None
    _begun: float = 0.0
    _faults: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        shutil.rmtree(self.place / "tree", ignore_errors=True)
        for name in files_of(self.root):
            copy = self.place / "tree" / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(self.root / name, copy)

    @property
    def cache(self) -> Path:
        """Where compiled code is kept. What a fault has changed is compiled anew: the key is the code itself."""
        return self.place / "cache"

    def begin(self, job: Job) -> None:
        """Put the fault in and start the tests."""
        self.job, self._begun = job, time.monotonic()
        if job.mutant is not None:
            self._write(applied(job.mutant, self._original(job.mutant)), job.mutant)
        folders = {
            "BRISTLE_CACHE_DIR": "cache",
            "BRISTLE_STATE_DIR": "state",
            "MPLCONFIGDIR": "matplotlib",
        }
        environment = {name: str(self.place / folder) for name, folder in folders.items()}
        with (self.place / "said").open("wb") as text:
            self._process = subprocess.Popen(
                [
                    *LIMITED,
                    str(math.ceil(job.limit)),
                    *PYTEST,
                    f"--basetemp={self.place / 'temporary'}",
                    *job.tests,
                ],
                cwd=self.place / "tree",
                env=os.environ | environment | {"PYTHONPATH": str(self.place / "tree" / "src")},
                stdin=subprocess.DEVNULL,
                stdout=text,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def poll(self) -> Verdict | None:
        """Return what became of the job, None while it runs; the fault is out again then."""
        if self.job is None or self._process is None:
            raise RuntimeError("nothing has begun here")
        code, took = self._worked()
        if code is None and time.monotonic() - self._begun < WAITING * self.job.limit:
            return None
        self.end()
        code = None if code in (-signal.SIGXCPU, -signal.SIGKILL) else code
        text = (self.place / "said").read_text(encoding="utf-8", errors="replace")
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE)
        return Verdict(code, took, failed[1] if failed else text.strip().rpartition("\n")[2][:200])

    def end(self) -> None:
        """End the tests with all that they have started, and put the tree back as it was."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        if self.job is not None and self.job.mutant is not None:
            self._write(self._original(self.job.mutant), self.job.mutant)
        self.job = None

    def _worked(self) -> tuple[int | None, float]:
        """Return the exit code, None while the tests run, and for how long processors have worked on them [s]."""
        process = self._process
        if process is None or process.returncode is not None:
            return None, 0.0
        pid, status, used = os.wait4(process.pid, os.WNOHANG)
        if pid == 0:
            return None, time.monotonic() - self._begun
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, used.ru_utime + used.ru_stime

    def _original(self, mutant: Mutant) -> bytes:
        return (self.root / mutant.path).read_bytes()

    def _write(self, source: bytes, mutant: Mutant) -> None:
        """Write a source with a time of its own: by time and length it is known whose byte code is kept."""
        file = self.place / "tree" / mutant.path
        file.write_bytes(source)
        self._faults += 1
        stamp = time.time() + 10.0 * self._faults
        os.utime(file, (stamp, stamp))


def abreast(
    benches: list[Bench], jobs: Iterator[Job], done: Callable[[Job, Verdict], None]
) -> None:
    """Run jobs, one on each bench at a time, in the order in which they come."""
    try:
        busy: list[Bench] = []
        free, coming = list(benches), True
        while coming or busy:
            while free and coming:
                job = next(jobs, None)
                coming = job is not None
                if job is not None:
                    bench = free.pop()
                    bench.begin(job)
                    busy.append(bench)
            for bench in list(busy):
                job = bench.job
                if job is not None and (verdict := bench.poll()) is not None:
                    busy.remove(bench)
                    free.append(bench)
                    done(job, verdict)
            time.sleep(POLL)
    finally:
        for bench in benches:
            bench.end()
