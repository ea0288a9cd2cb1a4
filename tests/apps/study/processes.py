"""Commands, their workers and those of a Dask cluster as processes, which are killed at any time; what they simulate."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.parquet
from tests.apps.lab.browser import PATIENCE, awaited
from threadpoolctl import threadpool_info

# A job of a shell without job control ignores Ctrl-C from its start, and so would its children.
COMMAND = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from bristle.cli.main import main
sys.exit(main())
"""


def begun(study, out, *options):
    """Return the command, begun as a process."""
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, "study", study, "--out", out, *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def children(pid):
    """Return the processes that a process has begun, from whichever of its threads."""
    result = []
    for thread in Path(f"/proc/{pid}/task").glob("*"):
        with suppress(OSError):
            result += [int(child) for child in (thread / "children").read_text().split()]
    return result


def _command_line(pid):
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


def nursed(pid):
    """Return the workers of a process, which starts them again where they end."""
    return [child for child in children(pid) if b"spawn_main" in _command_line(child)]


def own_workers(pid):
    """Return the workers of a study on this machine, by the number of the process that runs it."""
    return [worker for holder in children(pid) for worker in nursed(holder)]


def lives(pid):
    """Whether a process runs: one that has ended and was not waited for does not."""
    with suppress(OSError, IndexError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def until(condition, what, patience=PATIENCE):
    return awaited(condition, patience, f"waited in vain for {what}")


def end_once(mark, again=False):
    """Kill this process, unless it has been done before."""
    if again or not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGKILL)


@dataclass
class Tried:
    """A simulator whose block does what the study tells of it: it ends the process, once or always, or raises an error."""

    study: Any
    folder: Path
    deadly: int = -1
    always: bool = False
    wrong: int = -1

    def columns(self, block):
        print("by a model of a person", flush=True)
        if block.first == self.wrong:
            raise ValueError("a fault")
        if block.first == self.deadly:
            end_once(self.folder / "ended", again=self.always)
        limits = {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}
        return {
            "run": block.first,
            "pid": os.getpid(),
            "limits": limits,
            "environment": dict(os.environ),
            "path": sys.path,
        }


def numbers(folder):
    tables = [pyarrow.parquet.read_table(file) for file in sorted((folder / "runs").iterdir())]
    return [number for table in tables for number in table["run"].to_pylist()]


def siege(begin, workers, *, kills, longest, seed=1):
    """Kill workers of a study, and the command itself, which is given again, at random times; return how many fell.

    Parameters
    ----------
    begin : callable
        What begins the command as a process.
    workers : callable
        What returns the workers by the number of their process, of the command as it runs now.
    kills : int
        How many are killed, unless the study is over before.
    longest : float
        Time between two of them, at most [s].
    """
    chance, fallen, process = random.Random(seed), {"command": 0, "worker": 0}, begin()
    while sum(fallen.values()) < kills:
        time.sleep(chance.uniform(0.0, longest))
        if process.poll() is not None:
            assert process.returncode == 0, process.stderr.read()
            break
        # Each fourth is the command.
        others = workers(process) if sum(fallen.values()) % 4 < 3 else []
        victim = chance.choice(others or [process.pid])
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
            fallen["command" if victim == process.pid else "worker"] += 1
        if victim == process.pid:
            process.wait()
            process.stderr.close()
            process = begin()
    workers(process)  # where those join that are missing
    text = process.communicate()[1].decode()
    assert all(line.startswith("bristle: ") for line in text.splitlines()), text
    return fallen


class DaskCluster:
    """A scheduler on this machine, and workers that join it, each a process.

    Parameters
    ----------
    folder : Path
        What they keep.
    **environment : str
        Settings of the scheduler.
    """

    def __init__(self, folder, **environment):
        self.folder, self.processes = folder, []
        at = folder / "scheduler.json"
        self.scheduler = self._dask(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", at, **environment
        )
        self.address = until(lambda: self._address(at), "a scheduler")

    @staticmethod
    def _address(file):
        with suppress(OSError, ValueError):
            return json.loads(file.read_text())["address"]
        return None

    def _dask(self, *arguments, **environment):
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *arguments, "--no-dashboard"],
            env=os.environ | environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self.folder,
        )
        self.processes.append(process)
        return process

    def worker(self, *options, **environment):
        """Let a worker join; return its process."""
        folder = self.folder / f"worker_{len(self.processes)}"
        return self._dask(
            "worker",
            self.address,
            "--nthreads",
            "1",
            "--local-directory",
            folder,
            *options,
            **environment,
        )

    def joined(self):
        """Return the threads of the workers that the scheduler knows, by their addresses."""
        import distributed

        with distributed.Client(self.address, set_as_default=False) as client:
            return client.nthreads()

    def close(self):
        for process in self.processes:
            for child in children(process.pid):  # of a nanny
                with suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
            process.kill()
            process.wait()
