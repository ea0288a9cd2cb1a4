"""What hands out blocks: each comes back once, a fault is told, other software is refused; and processes are killed at any time."""

import asyncio
import copy
import hashlib
import io
import logging
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import CancelledError, Future
from pathlib import Path
from types import SimpleNamespace as Some

import pytest
from tests.study.conftest import content
from tests.study.processes import PATIENCE, begun, children, lives, numbers, siege, until

from bristle.core import InputError
from bristle.study import run_study, workers
from bristle.study.block import Simulator
from bristle.study.plan import Block
from bristle.study.workers import Cluster, Crew, Here, WorkerError, _as_ready, checksum_of_code, outcome_of, simulated

BLOCKS = [Block(k, k + 1) for k in range(9)]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_every_block_arrives_once_with_its_columns(count):
    at_once, most, lock, threads = [0], [0], threading.Lock(), set()

    def simulate(block):
        with lock:
            threads.add(threading.get_ident())
            at_once[0] += 1
            most[0] = max(most[0], at_once[0])
        time.sleep(0.01)
        with lock:
            at_once[0] -= 1
        return {"run": block.first}

    outcome = list(Here(simulate, count).results(BLOCKS))
    assert sorted(columns["run"] for _, columns in outcome) == list(range(9))
    assert all(block.first == columns["run"] for block, columns in outcome)
    assert (most[0] > 1) is (count > 1)
    assert (threads == {threading.get_ident()}) is (count == 1)


def test_blocks_in_work_are_limited():
    futures, under_way = [], []

    def submit(block):
        future = Future()
        futures.append(future)
        under_way.append(len(futures))
        return future

    ready = _as_ready(submit, BLOCKS, lambda: 4)
    threading.Timer(0.05, lambda: [future.set_result("done") for future in futures[:1]]).start()
    block, future = next(ready)
    assert (block, future.result(), len(futures)) == (BLOCKS[0], "done", 4)
    futures[2].set_result("later")
    block, future = next(ready)
    assert (block, future.result(), len(futures)) == (BLOCKS[2], "later", 5)
    assert list(_as_ready(submit, [], lambda: 4)) == []


def test_a_fault_is_reported_with_the_trace():
    def broken():
        raise ValueError("a fault")

    assert outcome_of(lambda: {"a": 1}) == ("done", {"a": 1})
    outcome, text = outcome_of(broken)
    assert outcome == "failed"
    assert "ValueError: a fault" in text
    assert str(WorkerError.at(Block(4, 8), "a fault")) == "a worker failed at the runs 4 to 7: a fault"
    assert WorkerError.exit_code == 70


def test_the_checksum_of_code_ignores_line_ends(tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "a.py").write_bytes(b"x = 1\r\ny = 2\n")
    (tmp_path / "below" / "b.py").write_bytes(b"z = 3\n")
    (tmp_path / "c.txt").write_bytes(b"no code")
    parts = [f"{name} {hashlib.sha256(text).hexdigest()} " for name, text in (("a.py", b"x = 1\ny = 2\n"), ("below/b.py", b"z = 3\n"))]
    assert checksum_of_code(tmp_path) == hashlib.sha256("".join(parts).encode()).hexdigest()[:12]


def test_a_worker_with_other_software_refuses_blocks(monkeypatch):
    monkeypatch.setattr(workers, "described", lambda: {"bristle": "2", "numpy": "1"})
    monkeypatch.setattr(workers, "platform", Some(node=lambda: "far away"))
    assert simulated(b"", {"bristle": "1", "numpy": "1"}, 0, 1) == ("unfit", "bristle 2 on far away")


def test_a_worker_simulates_the_requested_block(monkeypatch):
    monkeypatch.setattr(workers, "_simulator", lambda plan: Some(columns=lambda block: {"plan": plan, "block": block}))
    assert simulated(b"plan", workers.described(), 3, 5) == ("done", {"plan": b"plan", "block": Block(3, 5)})


class KilledError(Exception):
    pass


@pytest.fixture
def cluster():
    item = object.__new__(Cluster)
    item.study, item.address, item.lost, item._library = None, "tcp://a:1", [], Some(KilledWorker=KilledError)
    return item


def ended(outcome):
    future = Future()
    if isinstance(outcome, BaseException):
        future.set_exception(outcome)
    else:
        future.set_result(outcome)
    return future


def test_a_block_whose_worker_was_killed_is_noted_and_the_others_arrive(cluster):
    futures = [(BLOCKS[0], ended(("done", {"a": 1}))), (BLOCKS[1], ended(KilledError())), (BLOCKS[2], ended(("done", {"a": 2})))]
    assert list(cluster._arrived(iter(futures))) == [(BLOCKS[0], {"a": 1}), (BLOCKS[2], {"a": 2})]
    assert cluster.lost == [(BLOCKS[1], None)]


@pytest.mark.parametrize(
    ("outcome", "error", "words"),
    [
        (("failed", "a trace"), WorkerError, "a worker failed at the runs 0 to 0: a trace"),
        (ValueError("broken"), WorkerError, "a worker failed at the runs 0 to 0: ValueError: broken"),
        (("unfit", "bristle 2 on far"), InputError, "tcp://a:1: the software of a worker differs.*bristle 2 on far"),
        (CancelledError(), InputError, "--scheduler: the scheduler no longer answers.*tcp://a:1"),
    ],
)
def test_faults_on_a_cluster_are_reported(cluster, outcome, error, words):
    with pytest.raises(error, match=words):
        list(cluster._arrived(iter([(BLOCKS[0], ended(outcome))])))


def test_threads_of_a_cluster_are_counted_and_a_lost_scheduler_is_reported(cluster):
    assert cluster._threads(Some(nthreads=lambda callback_timeout: {"a": 2, "b": 3})) == 5

    def gone(callback_timeout):
        raise OSError

    with pytest.raises(InputError, match="the scheduler no longer answers"):
        cluster._threads(Some(nthreads=gone))


def test_loggers_of_dask_are_silent_and_others_are_not():
    names = ("distributed.comm", "asyncio", "another")
    loggers = [logging.getLogger(name) for name in names]
    off = logging.getLogger("distributed.off")
    off.disabled = True
    with workers._silent():
        assert [logger.disabled for logger in loggers] == [True, True, False]
    assert [logger.disabled for logger in (*loggers, off)] == [False, False, False, True]
    off.disabled = False


class Fake:
    """A process that ends as often as it is told to, and then answers."""

    def __init__(self):
        self.stdin = self.stdout = Some(close=lambda: None)

    def kill(self):
        pass

    def wait(self):
        return -9


def crew_of(answers, monkeypatch):
    crew, requested = Crew(None, 2), []
    monkeypatch.setattr(workers.subprocess, "Popen", lambda *a, **k: Fake())

    def answered(process, message):
        requested.append(message)
        answer = next(answers)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    monkeypatch.setattr(crew, "_asked", answered)
    return crew, requested


def test_a_block_that_ends_five_workers_is_lost_with_how_they_ended(monkeypatch):
    crew, requested = crew_of(iter([("ready", None), EOFError()] * 9), monkeypatch)
    assert crew._simulated(BLOCKS[0]) is None
    assert crew.lost == [(BLOCKS[0], -9)]
    assert requested.count(BLOCKS[0]) == 5
    assert crew.processes == set()


def test_a_block_goes_to_the_next_worker_where_a_worker_ended(monkeypatch):
    crew, _ = crew_of(iter([("ready", None), EOFError(), ("ready", None), ("done", {"a": 1}), ("failed", "why")]), monkeypatch)
    assert crew._simulated(BLOCKS[0]) == {"a": 1}
    assert crew.lost == []
    with pytest.raises(WorkerError, match="at the runs 3 to 3: why"):
        crew._simulated(BLOCKS[3])


def test_workers_that_never_begin_are_reported_by_how_they_end(monkeypatch):
    crew, requested = crew_of(iter([EOFError()] * 20), monkeypatch)
    with pytest.raises(WorkerError, match="10 workers ended before they could start, the last one by signal 9"):
        crew._simulated(BLOCKS[0])
    assert len(requested) == 10
    crew, _ = crew_of(iter([EOFError()] * 20), monkeypatch)
    monkeypatch.setattr(Fake, "wait", lambda self: 3)
    with pytest.raises(WorkerError, match="the last one with code 3"):
        crew._simulated(BLOCKS[0])


def test_no_worker_begins_once_the_study_ends(monkeypatch):
    crew, _ = crew_of(iter([("ready", None)] * 3), monkeypatch)
    crew._end()
    with pytest.raises(WorkerError, match="the study ends"):
        crew._simulated(BLOCKS[0])


def test_a_crew_yields_the_blocks_that_were_simulated_and_ends_the_processes(monkeypatch):
    crew = Crew(None, 2)
    crew.processes.update(Fake() for _ in range(2))
    monkeypatch.setattr(crew, "_simulated", lambda block: None if block.first == 4 else {"run": block.first})
    arrived = dict(crew.results(BLOCKS))
    assert {block.first: columns["run"] for block, columns in arrived.items()} == {k: k for k in range(9) if k != 4}
    assert crew.processes == set()


class Dask:
    """A library whose scheduler and workers are there, or are not."""

    class Security:
        def get_connection_args(self, role):
            return {"role": role}

    def __init__(self, scheduler=None, workers=None):
        self.scheduler, self.workers, self.calls = scheduler, workers, []
        self.rpc = self.Client = self

    def __call__(self, address, **options):
        self.calls.append((address, options))
        return self

    async def __aenter__(self):
        return self

    async def __aexit__(self, *ends):
        pass

    async def identity(self):
        if self.scheduler is not None:
            raise self.scheduler

    def wait_for_workers(self, count, timeout):
        self.calls.append((count, {"timeout": timeout}))
        if self.workers is not None:
            raise self.workers

    def close(self, timeout):
        self.calls.append(("close", {"timeout": timeout}))


def test_a_cluster_is_connected_to_for_a_while_and_left_again(cluster):
    cluster._library = library = Dask()
    with cluster._connected() as client:
        assert client is library
        assert [name for name, _ in library.calls] == ["tcp://a:1", "tcp://a:1", 1]
        assert library.calls[0][1] == {"connection_args": {"role": "client"}}
        assert library.calls[1][1]["set_as_default"] is False
        assert library.calls[1][1]["timeout"] < library.calls[2][1]["timeout"]
    assert library.calls[3][0] == "close"


@pytest.mark.parametrize(
    ("library", "words", "closed"),
    [
        (
            Dask(scheduler=OSError("nobody")),
            "--scheduler: no Dask scheduler answers at this address.*nobody.*tcp://a:1.*dask worker tcp://a:1",
            False,
        ),
        (Dask(workers=TimeoutError("late")), "--scheduler: the scheduler has no workers.*late.*tcp://a:1", True),
    ],
)
def test_a_cluster_that_does_not_answer_is_reported_by_the_missing_part(cluster, library, words, closed):
    cluster._library = library
    with pytest.raises(InputError, match=words), cluster._connected():
        pass
    assert (library.calls[-1][0] == "close") is closed


def test_a_scheduler_that_is_silent_is_given_up(cluster, monkeypatch):
    cluster._library = Dask()
    monkeypatch.setattr(cluster._library, "identity", lambda: asyncio.sleep(60.0))
    monkeypatch.setattr(workers, "ANSWERS", 0.05)
    with pytest.raises(InputError, match="no Dask scheduler answers at this address"), cluster._connected():
        pass


def test_a_process_is_asked_by_a_message_and_answers_by_another():
    orders, crew = io.BytesIO(), Crew(None, 1)
    process = Some(stdin=orders, stdout=io.BytesIO(pickle.dumps(("done", {"a": 1}))))
    assert crew._asked(process, BLOCKS[3]) == ("done", {"a": 1})
    assert pickle.loads(orders.getvalue()) == BLOCKS[3]
    with pytest.raises(EOFError):
        crew._asked(process, BLOCKS[3])


def test_a_process_has_a_single_thread_for_linear_algebra_and_finds_the_same_modules(monkeypatch):
    begun, queries, crew = [], [], Crew("study", 1, "make")
    monkeypatch.setattr(workers.subprocess, "Popen", lambda command, **how: begun.append((command, how)) or Fake())
    monkeypatch.setattr(crew, "_asked", lambda process, message: queries.append(message))
    assert crew._process() is crew._process()
    ((_, _, code), how), *rest = begun
    assert (len(rest), queries) == (0, [("make", "study")])
    assert repr(workers.sys.path) in code
    assert code.endswith("serve()")
    assert {how["env"][name] for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")} == {"1"}
    assert (how["stdin"], how["stdout"], how["stderr"]) == (subprocess.PIPE, subprocess.PIPE, subprocess.DEVNULL)


# --- killed at any time: every run is there once, bit by bit ---------------------------------------------------------


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
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


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
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


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
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


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
@pytest.mark.slow
@pytest.mark.parametrize("workers", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_any_number_of_workers_writes_the_same_bytes(bench, workers):
    study = bench.study()
    for count in (1, workers):
        run_study(study, bench.folder / f"out_{count}", workers=count)
    assert content(bench.folder / f"out_{workers}") == content(bench.folder / "out_1")
    assert (bench.folder / f"out_{workers}" / "study.json").read_bytes() == (bench.folder / "out_1" / "study.json").read_bytes()


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
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
