"""What hands out blocks, here and on a Dask cluster: each comes back once, a fault is told, and processes are killed at any time."""

import asyncio
import copy
import hashlib
import io
import logging
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import CancelledError, Future
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace as Some

import pytest
from tests.study.conftest import content
from tests.study.processes import PATIENCE, DaskCluster, begun, children, lives, numbers, siege, until

import bristle as br
from bristle.cli.main import main
from bristle.study import read_study_file, run_study, workers
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
        (("unfit", "bristle 2 on far"), br.core.InputError, "tcp://a:1: the software of a worker differs.*bristle 2 on far"),
        (CancelledError(), br.core.InputError, "--scheduler: the scheduler no longer answers.*tcp://a:1"),
    ],
)
def test_faults_on_a_cluster_are_reported(cluster, outcome, error, words):
    with pytest.raises(error, match=words):
        list(cluster._arrived(iter([(BLOCKS[0], ended(outcome))])))


def test_threads_of_a_cluster_are_counted_and_a_lost_scheduler_is_reported(cluster):
    assert cluster._threads(Some(nthreads=lambda callback_timeout: {"a": 2, "b": 3})) == 5

    def gone(callback_timeout):
        raise OSError

    with pytest.raises(br.core.InputError, match="the scheduler no longer answers"):
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
    with pytest.raises(br.core.InputError, match=words), cluster._connected():
        pass
    assert (library.calls[-1][0] == "close") is closed


def test_a_scheduler_that_is_silent_is_given_up(cluster, monkeypatch):
    cluster._library = Dask()
    monkeypatch.setattr(cluster._library, "identity", lambda: asyncio.sleep(60.0))
    monkeypatch.setattr(workers, "ANSWERS", 0.05)
    with pytest.raises(br.core.InputError, match="no Dask scheduler answers at this address"), cluster._connected():
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


@pytest.mark.slow
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


# --- on a Dask cluster, whose workers join and are killed: the bytes of a study on this machine ----------------------


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    """A scheduler and two workers."""
    pytest.importorskip("distributed")
    with closing(DaskCluster(tmp_path_factory.mktemp("dask"))) as cluster:
        cluster.worker("--no-nanny")
        cluster.worker("--no-nanny")
        yield cluster


RECORDED = """
schema = 1
[axis]
file = "axis.toml"
[plant]
M = "20 kg"
[friction]
file = "own.py"
F_C = "8 N"
F_q = 40.0
[controller]
model = "cascade"
k_p = "80 1/s"
k_v = "4 N*s/mm"
[reference]
model = "recorded"
file = "motion.csv"
[run]
settle = "20 ms"
"""
AXIS = """
schema = 1
kind = "translational"
columns.time = { column = "t", unit = "s" }
columns.position = { column = "x", unit = "m" }
"""
OF_TABLES = """
schema = 1
experiment = "recorded.toml"
runs = 6
seed = 3
block = 2
[vary]
"friction.F_C" = { uniform = ["6 N", "10 N"] }
"run.delay" = { choice = [0, 1, 2] }
"""


@pytest.fixture
def own_study(bench):
    """A study with code, an axis and a motion of its own, whose tables each run reads anew."""
    text = Path("examples/quadratic_drag.py").read_text()
    (bench.folder / "own.py").write_text(text)
    (bench.folder / "axis.toml").write_text(AXIS)
    time = [0.001 * k for k in range(200)]
    lines = [f"{t:.3f},{0.002 * t * t:.9f}" for t in time]
    (bench.folder / "motion.csv").write_text("\n".join(["t,x", *lines]))
    (bench.folder / "recorded.toml").write_text(RECORDED)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", br.core.InputWarning)
        study = read_study_file(bench.write(OF_TABLES), allow_code=True)
    assert not Simulator(study).varied.is_direct
    return study


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_files_of_a_study_reach_the_workers_and_its_code_is_reported(own_study, bench, dask):
    run_study(own_study, bench.folder / "here", workers=1)
    names = ("own.py", "axis.toml", "motion.csv", "recorded.toml")
    for name in names:
        (bench.folder / name).unlink()
    message = []
    with pytest.warns(br.core.InputWarning, match=r"bristle runs the code in own.py \(SHA-256 [0-9a-f]{64}\) on every worker of tcp"):
        run_study(own_study, bench.folder / "there", scheduler=dask.address, progress=lambda share, text: message.append(text))
    assert content(bench.folder / "there") == content(bench.folder / "here")
    assert len(content(bench.folder / "there")) == 3
    assert message[-1] == "6 of 6 runs, 1 s left"


@pytest.fixture
def own_dask(tmp_path_factory):
    """A scheduler without workers, for what ends it or them."""
    pytest.importorskip("distributed")
    with closing(DaskCluster(tmp_path_factory.mktemp("dask"))) as cluster:
        yield cluster


@pytest.fixture
def deaf():
    """A port at which something listens that never answers."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        yield listener.getsockname()[1]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_a_missing_scheduler_is_reported(bench, deaf, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("bristle.study.workers.ANSWERS", 0.5)
    study = bench.study()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    for address in (f"tcp://127.0.0.1:{port}", f"tcp://127.0.0.1:{deaf}", "http://a:80", "tcp://a b:80"):
        begin = time.monotonic()
        with pytest.raises(br.core.InputError) as refused:
            run_study(study, bench.folder / "out", scheduler=address)
        assert time.monotonic() < begin + 5.0
        assert "--scheduler: no Dask scheduler answers at this address" in str(refused.value)
        assert f"found '{address}'" in str(refused.value)
        assert f"Start dask scheduler --port 8786, then dask worker {address}" in str(refused.value)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
@pytest.mark.parametrize("option", [("--workers", "2"), ("--run", "3")])
def test_options_of_this_machine_exclude_a_cluster(bench, capsys, option):
    file = str(bench.write())
    assert main(["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1", *option]) == 2
    assert f"{option[0]}: simulates on this machine, --scheduler on a cluster" in capsys.readouterr().err
    assert not (bench.folder / "out").exists()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_without_the_cluster_library_the_extra_is_named(bench, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    file = str(bench.write())
    assert main(["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1"]) == 2
    text = capsys.readouterr().err
    assert 'bristle study --scheduler needs an optional dependency. Type: pip install "bristle[study]"' in text
    assert not (bench.folder / "out").exists()
    with pytest.raises(br.core.MissingExtraError):
        run_study(bench.study(), bench.folder / "out", scheduler="tcp://a:1")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_a_local_run_does_not_load_the_cluster_library(bench):
    file, out = bench.write(), bench.folder / "out"
    code = f"""
import sys, bristle.cli.study
from bristle.study import read_study_file, run_study
run_study(read_study_file({str(file)!r}), {str(out)!r}, workers=1)
sys.exit(bool({{"dask", "distributed", "tornado"}} & set(sys.modules)))
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    # What is there already needs no cluster.
    assert run_study(read_study_file(file), out, scheduler="tcp://127.0.0.1:1").before == 3


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_ctrl_c_keeps_written_blocks_and_cancels_the_rest(slow_bench, dask):
    import distributed

    slow_bench.study(runs=("runs = 12", "runs = 400"))
    out = slow_bench.folder / "out"
    process = begun(slow_bench.folder / "study.toml", out, "--scheduler", dask.address)
    until(lambda: content(out), "the first block")
    process.send_signal(signal.SIGINT)
    text = process.communicate(timeout=60.0)[1].decode()
    assert process.returncode == 130
    assert text.splitlines() == [f"bristle: {out} keeps the finished runs. Give the same command again to continue", "bristle: interrupted"]
    assert len(content(out)) < 100
    with distributed.Client(dask.address, set_as_default=False) as client:
        until(lambda: not any(client.processing().values()), "workers without work")
        assert not any(client.has_what().values())


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
@pytest.mark.timeout(1200)
def test_ten_kills_in_a_hundred_blocks(bench, own_dask):
    bench.rig(duration="10 s", substeps=20)
    study = bench.study(runs=("runs = 12", "runs = 400"))
    assert len(study.blocks) == 100
    file, out = bench.folder / "study.toml", bench.folder / "out"
    run_study(study, bench.folder / "here", workers=2)
    joined = {"nanny": [], "plain": []}

    def workers(_):
        for kind, options in (("nanny", ()), ("plain", ("--no-nanny",))):
            if not joined[kind] or joined[kind][-1].poll() is not None:  # so ends a nanny whose worker could not begin
                joined[kind].append(own_dask.worker(*options))
        return [joined["plain"][-1].pid, *own_dask.nursed(joined["nanny"][-1])]

    fallen = siege(lambda: begun(file, out, "--scheduler", own_dask.address), workers, kills=10, longest=3.0)
    print(fallen, {kind: len(processes) for kind, processes in joined.items()})
    assert fallen["command"] >= 1, "the study was over before it was disturbed"
    assert fallen["worker"] >= 5, "the study was over before it was disturbed"
    until(lambda: own_dask.joined() or (workers(None) and False), "a worker")
    assert run_study(study, out, scheduler=own_dask.address).is_whole
    assert numbers(out) == list(range(400))
    assert content(out) == content(bench.folder / "here")
    assert not (out / ".partial").exists()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_a_lost_scheduler_is_reported_and_written_blocks_stay(slow_bench, own_dask, monkeypatch):
    monkeypatch.setattr("bristle.study.workers.ANSWERS", 2.0)
    own_dask.worker("--no-nanny")
    study, out = slow_bench.study(runs=("runs = 12", "runs = 400")), slow_bench.folder / "out"

    def end(share, text):
        if share > 0.02:
            own_dask.scheduler.kill()

    with pytest.raises(
        br.core.InputError, match=r"--scheduler: the scheduler no longer answers; found 'tcp://.*The results written so far remain"
    ):
        run_study(study, out, scheduler=own_dask.address, progress=end)
    assert 3 <= len(content(out)) < 100
    assert run_study(study, out, workers=2).is_whole


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")
def test_threads_of_a_worker_write_the_same_bytes(slow_bench, own_dask):
    own_dask.worker("--no-nanny", "--nthreads", "3")
    study = slow_bench.study(runs=("runs = 12", "runs = 80"))
    run_study(study, slow_bench.folder / "here", workers=1)
    run_study(study, slow_bench.folder / "there", scheduler=own_dask.address)
    assert content(slow_bench.folder / "there") == content(slow_bench.folder / "here")
