"""Workers, and the process that hands out the work, are killed at any time: every run is there once, bit by bit."""

import copy
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace as Some

import pytest
from tests.study.conftest import content
from tests.study.processes import PATIENCE, begun, children, lives, numbers, siege, until

from bristle.study import run_study
from bristle.study.block import Simulator

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


@pytest.fixture
def worker():
    """A worker without work, and what hands it a message."""
    code = "from bristle.study.workers import serve; serve()"
    process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def hand(message):
        pickle.dump(message, process.stdin)
        process.stdin.flush()

    yield process, hand
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_worker_answers_each_block_in_turn(worker):
    process, hand = worker
    answers = []
    for message in ((copy.copy, Some(columns=eval)), "6 * 7", "print('by a model of a person')", "1 / 0"):
        hand(message)
        answers.append(pickle.load(process.stdout))
        process.send_signal(signal.SIGINT)  # Ctrl-C reaches all processes of a terminal: the parent ends this one
    assert answers[:3] == [("ready", None), ("done", 42), ("done", None)]
    assert answers[3][0] == "failed"
    assert "ZeroDivisionError" in answers[3][1]
    process.stdin.close()
    assert process.wait(10.0) == 0


@pytest.mark.slow
def test_a_worker_ends_in_the_midst_of_a_block_where_its_parent_is_gone(slow_bench, worker):
    study = slow_bench.study(runs=("runs = 12", "runs = 4000"), block=("block = 4", "block = 4000"))
    process, hand = worker
    hand((Simulator, study))
    hand(study.blocks[0])
    assert pickle.load(process.stdout) == ("ready", None)
    time.sleep(0.5)
    assert process.poll() is None
    process.stdin.close()
    process.wait(10.0)  # its block would take a minute


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
