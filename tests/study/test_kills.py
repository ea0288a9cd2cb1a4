"""Workers, and the process that hands out the work, are killed at any time: every run is there once, bit by bit."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pyarrow.parquet
import pytest
from tests.study.conftest import content

from bristle.core.errors import InputError
from bristle.study import run_study
from bristle.study.crew import Crew, WorkerError
from bristle.study.worker import read_message, write_message

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")

COMMAND = "import sys; from bristle.cli.main import main; sys.exit(main())"
PATIENCE = 60.0  # [s]


def begun(study, out, workers=2):
    """Return the command, begun as a process."""
    return subprocess.Popen(
        [sys.executable, "-c", COMMAND, "study", study, "--out", out, "--workers", str(workers)],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def children(pid):
    with suppress(OSError):
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return []


def lives(pid):
    """Whether a process runs: one that has ended and was not waited for does not."""
    with suppress(OSError, IndexError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def until(condition, what):
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.005)
    return value


def numbers(folder):
    tables = [pyarrow.parquet.read_table(file) for file in sorted((folder / "runs").iterdir())]
    return [number for table in tables for number in table["run"].to_pylist()]


@pytest.fixture
def slow_bench(bench):
    """Blocks that take some hundredths of a second."""
    bench.rig(duration="5 s", substeps=20)
    return bench


def test_killed_workers_and_a_killed_parent_lose_and_double_nothing(slow_bench):
    bench = slow_bench
    study = bench.study(runs=("runs = 12", "runs = 160"))
    file, out = bench.folder / "study.toml", bench.folder / "out"
    run_study(study, bench.folder / "undisturbed", workers=1)
    process = begun(file, out)
    until(lambda: len(content(out)) >= 2, "the first blocks")
    os.kill(until(lambda: children(process.pid), "a worker")[0], signal.SIGKILL)
    before = len(content(out))
    until(lambda: len(content(out)) >= min(before + 3, 12), "blocks after a worker was killed")
    workers = children(process.pid)
    process.kill()
    process.wait()
    process.stderr.close()
    until(lambda: not any(lives(worker) for worker in workers), "workers to end with their parent")
    ran = run_study(study, out, workers=1)
    assert ran.is_whole
    assert ran.before >= before
    assert numbers(out) == list(range(160))
    assert content(out) == content(bench.folder / "undisturbed")
    assert sorted(path.name for path in out.iterdir() if path.name != "report.html") >= [".lock", "runs", "study.json"]
    assert not (out / ".partial").exists()


@pytest.mark.slow
def test_ctrl_c_ends_the_workers_and_says_what_to_do(slow_bench):
    bench = slow_bench
    bench.study(runs=("runs = 12", "runs = 400"))
    out = bench.folder / "out"
    process = begun(bench.folder / "study.toml", out)
    until(lambda: content(out), "the first block")
    workers = children(process.pid)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=PATIENCE)[1].decode()
    assert process.returncode == 130
    assert "keeps the runs that are done; the same command goes on" in said
    until(lambda: not any(lives(worker) for worker in workers), "workers to end")
    assert len(content(out)) < 100


def test_a_block_whose_worker_ends_goes_to_the_next(bench, monkeypatch):
    hand_out, ended = Crew._next, []

    def deadly_once(self):
        block = hand_out(self)
        if block is not None and block.first == 4 and not ended:
            ended.extend(self.processes)
            for pid in self.processes:
                os.kill(pid, signal.SIGKILL)
        return block

    monkeypatch.setattr(Crew, "_next", deadly_once)
    ran = run_study(bench.study(), bench.folder / "out", workers=2)
    assert ended
    assert ran.lost == ()
    assert numbers(bench.folder / "out") == list(range(12))


def test_a_worker_ends_in_the_midst_of_a_block_where_its_parent_is_gone(slow_bench):
    study = slow_bench.study(runs=("runs = 12", "runs = 4000"), block=("block = 4", "block = 4000"))
    code = "from bristle.study.worker import main; main()"
    worker = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    write_message(worker.stdin, study)
    assert read_message(worker.stdout) == ("ready", None)
    write_message(worker.stdin, study.blocks[0])
    time.sleep(0.5)
    assert worker.poll() is None
    worker.stdin.close()
    worker.wait(10.0)  # its block would take a minute
    worker.stdout.close()


@pytest.mark.slow
def test_a_block_that_ends_every_worker_is_told_and_the_others_are_there(slow_bench, monkeypatch):
    study = slow_bench.study()
    begin = Crew._next

    def deadly(self):
        block = begin(self)
        if block is not None and block.first == 4:
            for pid in self.processes:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
        return block

    monkeypatch.setattr(Crew, "_next", deadly)
    monkeypatch.setattr("bristle.study.crew.TRIES", 2)
    out = slow_bench.folder / "out"
    ran = run_study(study, out, workers=2)
    lost = [block.first for block, _ in ran.lost]
    assert 4 in lost
    assert {code for _, code in ran.lost} == {-signal.SIGKILL}
    assert numbers(out) == [number for number in range(12) if number - number % 4 not in lost]
    monkeypatch.undo()
    assert run_study(study, out, workers=1).is_whole


def test_workers_that_cannot_begin_end_the_study(bench, monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(WorkerError, match="ended before they could begin: ended with code 1"):
        run_study(bench.study(), bench.folder / "out", workers=2)


@pytest.mark.parametrize("workers", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_any_number_of_workers_writes_the_same_bytes(bench, workers):
    study = bench.study()
    for count in (1, workers):
        run_study(study, bench.folder / f"out_{count}", workers=count)
    assert content(bench.folder / f"out_{workers}") == content(bench.folder / "out_1")
    assert (bench.folder / f"out_{workers}" / "study.json").read_bytes() == (
        bench.folder / "out_1" / "study.json"
    ).read_bytes()


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_thirty_kills_in_two_hundred_blocks(slow_bench):
    bench = slow_bench
    study = bench.study(runs=("runs = 12", "runs = 800"))
    assert len(study.blocks) == 200
    file, out = bench.folder / "study.toml", bench.folder / "out"
    run_study(study, bench.folder / "undisturbed", workers=2)
    chance, kills, process = random.Random(1), 0, begun(file, out)
    while kills < 30:
        time.sleep(chance.uniform(0.0, 0.7))
        if process.poll() is not None:
            assert process.returncode == 0, process.stderr.read()
            break
        victims = [*children(process.pid), process.pid]
        victim = chance.choice(victims)
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
            kills += 1
        if victim == process.pid:
            process.wait()
            process.stderr.close()
            with suppress(InputError, FileNotFoundError):
                process = begun(file, out)
    process.communicate()
    assert kills >= 15, "the study was over before it was disturbed"
    assert run_study(study, out, workers=2).is_whole
    assert numbers(out) == list(range(800))
    assert content(out) == content(bench.folder / "undisturbed")
    assert not (out / ".partial").exists()
