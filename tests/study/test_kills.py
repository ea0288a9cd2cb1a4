"""Workers, and the process that hands out the work, are killed at any time: every run is there once, bit by bit."""

import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.study.conftest import content
from tests.study.processes import PATIENCE, begun, children, lives, numbers, siege, until

from bristle.study import run_study
from bristle.study.block import Simulator
from bristle.study.workers import Crew, WorkerError

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")


@pytest.mark.slow
def test_ctrl_c_ends_the_workers_and_prints_advice(slow_bench):
    bench = slow_bench
    bench.study(runs=("runs = 12", "runs = 400"))
    out = bench.folder / "out"
    process = begun(bench.folder / "study.toml", out, "--workers", "2")
    until(lambda: content(out), "the first block")
    workers = children(process.pid)
    process.send_signal(signal.SIGINT)
    text = process.communicate(timeout=PATIENCE)[1].decode()
    assert process.returncode == 130
    assert "keeps the finished runs. Give the same command again to continue" in text
    until(lambda: not any(lives(worker) for worker in workers), "workers to end")
    assert len(content(out)) < 100


def kill(crew):
    for process in list(crew.processes):
        process.kill()


@pytest.mark.slow
def test_a_block_whose_worker_ends_goes_to_the_next(bench, monkeypatch):
    simulated, ended = Crew._simulated, []

    def deadly_once(crew, block):
        if block.first == 4 and not ended:
            crew._process()
            ended.extend(crew.processes)
            kill(crew)
        return simulated(crew, block)

    monkeypatch.setattr(Crew, "_simulated", deadly_once)
    ran = run_study(bench.study(), bench.folder / "out", workers=2)
    assert ended
    assert ran.lost == ()
    assert numbers(bench.folder / "out") == list(range(12))


def test_a_worker_ends_in_the_midst_of_a_block_where_its_parent_is_gone(slow_bench):
    study = slow_bench.study(runs=("runs = 12", "runs = 4000"), block=("block = 4", "block = 4000"))
    code = "from bristle.study.workers import serve; serve()"
    worker = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    for message in ((Simulator, study), study.blocks[0]):
        pickle.dump(message, worker.stdin)
        worker.stdin.flush()
    assert pickle.load(worker.stdout) == ("ready", None)
    time.sleep(0.5)
    assert worker.poll() is None
    worker.stdin.close()
    worker.wait(10.0)  # its block would take a minute
    worker.stdout.close()


@pytest.mark.slow
def test_a_block_that_ends_every_worker_is_reported_and_the_others_are_complete(slow_bench, monkeypatch):
    study = slow_bench.study()
    requested = Crew._asked

    def deadly(crew, process, message):
        if getattr(message, "first", None) == 4:
            kill(crew)
        return requested(crew, process, message)

    monkeypatch.setattr(Crew, "_asked", deadly)
    monkeypatch.setattr("bristle.study.workers.TRIES", 2)
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
    with pytest.raises(WorkerError, match="ended before they could start, the last one with code 1"):
        run_study(bench.study(), bench.folder / "out", workers=2)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_any_number_of_workers_writes_the_same_bytes(bench, workers):
    study = bench.study()
    for count in (1, workers):
        run_study(study, bench.folder / f"out_{count}", workers=count)
    assert content(bench.folder / f"out_{workers}") == content(bench.folder / "out_1")
    assert (bench.folder / f"out_{workers}" / "study.json").read_bytes() == (bench.folder / "out_1" / "study.json").read_bytes()


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_thirty_kills_in_two_hundred_blocks(slow_bench):
    bench = slow_bench
    study = bench.study(runs=("runs = 12", "runs = 800"))
    assert len(study.blocks) == 200
    file, out = bench.folder / "study.toml", bench.folder / "out"
    run_study(study, bench.folder / "undisturbed", workers=2)
    fallen = siege(lambda: begun(file, out, "--workers", "2"), lambda process: children(process.pid), kills=30, longest=0.7)
    assert sum(fallen.values()) >= 15, "the study was over before it was disturbed"
    assert run_study(study, out, workers=2).is_whole
    assert numbers(out) == list(range(800))
    assert content(out) == content(bench.folder / "undisturbed")
    assert not (out / ".partial").exists()
