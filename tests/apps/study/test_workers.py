"""What hands out blocks, here and on a Dask cluster: each comes back once, a fault is told, and processes are killed at any time."""

import asyncio
import hashlib
import io
import logging
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import CancelledError, Future
from contextlib import closing, nullcontext
from functools import partial
from pathlib import Path
from types import SimpleNamespace as Some
from unittest.mock import Mock

import pytest
from tests.apps.study.conftest import content
from tests.apps.study.processes import (
    PATIENCE,
    DaskCluster,
    Tried,
    begun,
    children,
    lives,
    numbers,
    nursed,
    own_workers,
    siege,
    until,
)

import bristle as br
from bristle.apps.study import read_study_file, run_study, workers
from bristle.apps.study.block import Simulator
from bristle.apps.study.plan import Block
from bristle.apps.study.workers import (
    Cluster,
    Here,
    OwnCluster,
    WorkerError,
    _as_ready,
    checksum_of_code,
    outcome_of,
    simulated,
)
from bristle.cli.main import main

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
    assert (
        str(WorkerError.at(Block(4, 8), "a fault")) == "a worker failed at the runs 4 to 7: a fault"
    )
    assert WorkerError.exit_code == 70


def test_the_checksum_of_code_ignores_line_ends(tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "a.py").write_bytes(b"x = 1\r\ny = 2\n")
    (tmp_path / "below" / "b.py").write_bytes(b"z = 3\n")
    (tmp_path / "c.txt").write_bytes(b"no code")
    parts = [
        f"{name} {hashlib.sha256(text).hexdigest()} "
        for name, text in (("a.py", b"x = 1\ny = 2\n"), ("below/b.py", b"z = 3\n"))
    ]
    assert checksum_of_code(tmp_path) == hashlib.sha256("".join(parts).encode()).hexdigest()[:12]


def test_a_worker_with_other_software_refuses_blocks(monkeypatch):
    monkeypatch.setattr(workers, "described", lambda: {"bristle": "2", "numpy": "1"})
    monkeypatch.setattr(workers, "platform", Some(node=lambda: "far away"))
    assert simulated(b"", {"bristle": "1", "numpy": "1"}, 0, 1) == (
        "unfit",
        "bristle 2 on far away",
    )


def test_a_worker_simulates_the_requested_block(monkeypatch):
    monkeypatch.setattr(
        workers,
        "_simulator",
        lambda plan: Some(columns=lambda block: {"plan": plan, "block": block}),
    )
    assert simulated(b"plan", workers.described(), 3, 5) == (
        "done",
        {"plan": b"plan", "block": Block(3, 5)},
    )


class KilledError(Exception):
    pass


@pytest.fixture
def cluster():
    item = object.__new__(Cluster)
    item.study, item.address, item.lost, item._library = (
        None,
        "tcp://a:1",
        [],
        Some(KilledWorker=KilledError),
    )
    item._security = Some(get_connection_args=lambda role: {"role": role})
    return item


def ended(outcome):
    future = Future()
    if isinstance(outcome, BaseException):
        future.set_exception(outcome)
    else:
        future.set_result(outcome)
    return future


def test_a_block_whose_worker_was_killed_is_noted_and_the_others_arrive(cluster):
    futures = [
        (BLOCKS[0], ended(("done", {"a": 1}))),
        (BLOCKS[1], ended(KilledError())),
        (BLOCKS[2], ended(("done", {"a": 2}))),
    ]
    assert list(cluster._arrived(iter(futures))) == [(BLOCKS[0], {"a": 1}), (BLOCKS[2], {"a": 2})]
    assert cluster.lost == [BLOCKS[1]]


@pytest.mark.parametrize(
    ("outcome", "error", "words"),
    [
        (("failed", "a trace"), WorkerError, "a worker failed at the runs 0 to 0: a trace"),
        (
            ValueError("broken"),
            WorkerError,
            "a worker failed at the runs 0 to 0: ValueError: broken",
        ),
        (
            ("unfit", "bristle 2 on far"),
            br.core.InputError,
            "tcp://a:1: the software of a worker differs.*bristle 2 on far",
        ),
        (
            CancelledError(),
            br.core.InputError,
            "--scheduler: the scheduler no longer answers.*tcp://a:1",
        ),
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
    names = ("distributed.comm", "tornado.application", "asyncio", "another")
    loggers = [logging.getLogger(name) for name in names]
    off = logging.getLogger("distributed.off")
    off.disabled = True
    with workers._silent():
        assert [logger.disabled for logger in loggers] == [True, True, True, False]
    assert [logger.disabled for logger in (*loggers, off)] == [False, False, False, False, True]
    off.disabled = False


class Dask:
    """A library whose scheduler and workers are there, or are not."""

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
        assert library.calls[1][1]["security"] is cluster._security
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
        (
            Dask(workers=TimeoutError("late")),
            "--scheduler: the scheduler has no workers.*late.*tcp://a:1",
            True,
        ),
    ],
)
def test_a_cluster_that_does_not_answer_is_reported_by_the_missing_part(
    cluster, library, words, closed
):
    cluster._library = library
    with pytest.raises(br.core.InputError, match=words), cluster._connected():
        pass
    assert (library.calls[-1][0] == "close") is closed


def test_a_scheduler_that_is_silent_is_given_up(cluster, monkeypatch):
    cluster._library = Dask()
    monkeypatch.setattr(cluster._library, "identity", lambda: asyncio.sleep(60.0))
    monkeypatch.setattr(workers, "ANSWERS", 0.05)
    with (
        pytest.raises(br.core.InputError, match="no Dask scheduler answers at this address"),
        cluster._connected(),
    ):
        pass


# --- processes of this machine: a cluster that lasts as long as the study ---------------------------------------------


def own_cluster(folder=None, workers=2, **deeds):
    return OwnCluster("study", partial(Tried, folder=folder, **deeds), workers)


class Holder:
    """A process that answers with an address, or ends before it could."""

    def __init__(self, address, ending=0):
        self.stdin, self.stdout, self.ending = Input(), io.BytesIO(address), ending
        self.is_ended = False

    def __enter__(self):
        return self

    def __exit__(self, *error):
        assert self.is_ended  # so that nobody waits for it in vain

    def wait(self, timeout=None):
        return self.ending

    def kill(self):
        self.is_ended = True


class Input(io.BytesIO):
    """An input whose content stays readable after its end."""

    def close(self):
        self.content = self.getvalue()
        super().close()


@pytest.mark.parametrize(("ending", "words"), [(3, "with code 3"), (-9, "by signal 9")])
def test_processes_that_never_begin_are_reported_by_how_they_end(monkeypatch, ending, words):
    holders = iter([*(Holder(b"", 1) for _ in range(4)), Holder(b"", ending)])
    monkeypatch.setattr(workers.subprocess, "Popen", lambda *command, **options: next(holders))
    with pytest.raises(
        WorkerError,
        match=f"the processes of this machine ended 5 times before they could start, the last time {words}",
    ):
        list(own_cluster().results(BLOCKS))


def test_processes_that_begin_at_last_are_ended_with_the_study(monkeypatch):
    last, options = Holder(b"tls://a:1\n"), []
    holders = iter([Holder(b"", 1), last])
    monkeypatch.setattr(
        workers.subprocess, "Popen", lambda *command, **how: options.append(how) or next(holders)
    )
    cluster = own_cluster()
    with cluster._held():
        assert (cluster.address, last.is_ended, len(options)) == ("tls://a:1", False, 2)
    assert last.is_ended
    assert pickle.loads(last.stdin.content)["n_workers"] == 2
    assert options[0]["stderr"] is subprocess.DEVNULL


def test_a_process_that_ended_gives_no_answer():
    ended = Some(stdin=Some(write=Mock(side_effect=BrokenPipeError)), kill=Mock())
    assert workers._answer(ended, "a message") == ""


def test_a_process_that_hangs_is_killed_at_its_start_and_at_its_end(monkeypatch):
    monkeypatch.setattr(workers, "WORKERS_JOIN", 0.05)
    monkeypatch.setattr(workers, "ENDS", 0.05)
    code = "import sys, time; print('ready' if sys.argv[1:] else '', end='\\n' * len(sys.argv[1:]), flush=True); time.sleep(60)"
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", code], stdin=pipe, stdout=pipe) as mute:
        assert workers._answer(mute, "a message") == ""
        assert mute.wait() == -signal.SIGKILL
    with subprocess.Popen(
        [sys.executable, "-c", code, "says"], stdin=pipe, stdout=pipe
    ) as stubborn:
        assert stubborn.stdout.readline() == b"ready\n"
        workers._end(stubborn)
        assert stubborn.wait() == -signal.SIGKILL


def test_processes_of_this_machine_ignore_the_settings_of_the_user_for_dask(monkeypatch):
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "1 s")
    monkeypatch.setenv("DASK_TEMPORARY_DIRECTORY", "elsewhere")
    monkeypatch.setenv("MINE", "kept")
    environment = workers._environment()
    assert environment["DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL"] == "None"
    assert "DASK_TEMPORARY_DIRECTORY" not in environment
    assert environment["MINE"] == "kept"


def test_processes_of_this_machine_are_reached_by_this_one_only(monkeypatch):
    monkeypatch.setattr(OwnCluster, "_held", lambda self: nullcontext())
    monkeypatch.setattr(Cluster, "_connected", lambda self: nullcontext("client"))
    cluster = own_cluster()
    with cluster._connected():
        assert cluster._security.require_encryption
        assert cluster._security.get_connection_args("client")["ssl_context"] is not None


def test_a_change_of_the_code_during_a_study_is_told_without_advice_on_clusters():
    changed = [(BLOCKS[0], ended(("unfit", "code 1 on here")))]
    with pytest.raises(
        WorkerError,
        match=r"the code of bristle changed while the study ran \(code 1 on here\)\. The finished runs stay",
    ):
        list(own_cluster()._arrived(iter(changed)))


def test_processes_that_start_no_more_are_given_up_after_a_while(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(workers, "time", Some(monotonic=lambda: now[0]))
    cluster, threads = own_cluster(), {"a": 1}
    client = Some(nthreads=lambda callback_timeout: threads)
    now[0] = 100.0
    assert cluster._threads(client) == 1
    threads.clear()  # the process is started again
    now[0] += workers.WORKERS_JOIN
    assert cluster._threads(client) == 0
    now[0] += 1.0
    with pytest.raises(
        WorkerError,
        match=r"on this machine, no process starts any more\. The finished runs stay.*repeat the command",
    ):
        cluster._threads(client)


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_processes_of_this_machine_are_as_this_one_and_silent(capfd, tmp_path):
    cluster, before = own_cluster(tmp_path), set(children(os.getpid()))
    outcome = dict(cluster.results(BLOCKS))
    assert {block.first: columns["run"] for block, columns in outcome.items()} == {
        k: k for k in range(9)
    }
    assert os.getpid() not in {columns["pid"] for columns in outcome.values()}
    for columns in outcome.values():
        assert {
            columns["environment"][name]
            for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        } == {"1"}
        assert columns["limits"] == {1}
        assert workers.DASK.items() <= columns["environment"].items()
        assert set(sys.path) <= set(columns["path"])
    assert capfd.readouterr() == ("", "")
    assert set(children(os.getpid())) <= before
    assert cluster.lost == []


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_only_the_study_reaches_its_processes(tmp_path):
    import distributed

    cluster = own_cluster(tmp_path, workers=1)
    with closing(cluster.results(BLOCKS)) as results:
        next(results)
        for security in (None, distributed.Security.temporary()):
            with pytest.raises((OSError, TypeError)):
                distributed.Client(
                    cluster.address.replace("tls://", "tls://" if security else "tcp://"),
                    timeout=1.0,
                    security=security,
                )


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_a_block_goes_to_the_next_process_where_a_process_ended(capfd, tmp_path):
    cluster = own_cluster(tmp_path, deadly=3)
    assert sorted(columns["run"] for _, columns in cluster.results(BLOCKS)) == list(range(9))
    assert (tmp_path / "ended").exists()
    assert cluster.lost == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_a_block_that_ends_every_process_is_lost_and_the_others_arrive(monkeypatch, tmp_path):
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    cluster = own_cluster(tmp_path, deadly=3, always=True)
    assert sorted(columns["run"] for _, columns in cluster.results(BLOCKS)) == [
        0,
        1,
        2,
        4,
        5,
        6,
        7,
        8,
    ]
    assert cluster.lost == [BLOCKS[3]]


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_a_fault_in_a_process_ends_the_study_with_its_runs_and_the_trace(tmp_path):
    with pytest.raises(
        WorkerError, match=r"(?s)a worker failed at the runs 3 to 3: Traceback.*ValueError: a fault"
    ):
        list(own_cluster(tmp_path, wrong=3).results(BLOCKS))


SCRIPT = """
from bristle.apps.study import read_study_file, run_study
print(run_study(read_study_file("study.toml"), "out", workers=2).is_whole)
"""


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_a_script_needs_no_guard_and_is_run_once(bench):
    bench.study()
    (bench.folder / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=bench.folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "True\n", "")


# --- killed at any time: every run is there once, bit by bit ---------------------------------------------------------


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
def test_processes_end_in_the_midst_of_a_block_where_the_command_is_gone(
    slow_bench, tmp_path_factory, monkeypatch
):
    temporary = tmp_path_factory.mktemp("temporary")
    monkeypatch.setenv("TMPDIR", str(temporary))
    slow_bench.study(runs=("runs = 12", "runs = 8000"), block=("block = 4", "block = 4000"))
    process = begun(slow_bench.folder / "study.toml", slow_bench.folder / "out", "--workers", "2")
    until(lambda: len(own_workers(process.pid)) == 2, "two workers")
    time.sleep(3.0)  # their blocks take a minute
    family = [*children(process.pid), *own_workers(process.pid)]
    assert len(list(temporary.iterdir())) == 1
    process.kill()
    process.communicate()
    assert len(family) == 3
    until(lambda: not any(lives(pid) for pid in family), "workers to end")
    until(lambda: not list(temporary.iterdir()), "no temporary files")


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
@pytest.mark.parametrize("is_elsewhere", [False, True])
def test_ctrl_c_keeps_written_blocks_and_cancels_the_rest(slow_bench, dask, is_elsewhere):
    import distributed

    slow_bench.study(runs=("runs = 12", "runs = 400"))
    out = slow_bench.folder / "out"
    process = begun(
        slow_bench.folder / "study.toml",
        out,
        *(("--scheduler", dask.address) if is_elsewhere else ("--workers", "2")),
    )
    until(lambda: content(out), "the first block")
    workers = [*children(process.pid), *own_workers(process.pid)]
    assert len(workers) == (0 if is_elsewhere else 3)
    for pid in (process.pid, *workers):  # Ctrl-C reaches all processes of a terminal
        os.kill(pid, signal.SIGINT)
    text = process.communicate(timeout=PATIENCE)[1].decode()
    assert process.returncode == 130
    assert text.splitlines() == [
        f"bristle: {out} keeps the finished runs. Give the same command again to continue",
        "bristle: interrupted",
    ]
    assert len(content(out)) < 100
    until(lambda: not any(lives(worker) for worker in workers), "workers to end")
    with distributed.Client(dask.address, set_as_default=False) as client:
        until(lambda: not any(client.processing().values()), "workers without work")
        assert not any(client.has_what().values())


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
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
def test_files_of_a_study_reach_the_workers_and_its_code_is_reported(own_study, bench, dask):
    for name, count in (("here", 1), ("beside", 2)):
        run_study(own_study, bench.folder / name, workers=count)
    for name in ("own.py", "axis.toml", "motion.csv", "recorded.toml"):
        (bench.folder / name).unlink()
    message = []
    with pytest.warns(
        br.core.InputWarning,
        match=r"bristle runs the code in own.py \(SHA-256 [0-9a-f]{64}\) on every worker of tcp",
    ):
        run_study(
            own_study,
            bench.folder / "there",
            scheduler=dask.address,
            progress=lambda share, text: message.append(text),
        )
    assert (
        content(bench.folder / "there")
        == content(bench.folder / "beside")
        == content(bench.folder / "here")
    )
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
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
def test_a_missing_scheduler_is_reported(bench, deaf, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("bristle.apps.study.workers.ANSWERS", 0.5)
    study = bench.study()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    for address in (
        f"tcp://127.0.0.1:{port}",
        f"tcp://127.0.0.1:{deaf}",
        "http://a:80",
        "tcp://a b:80",
    ):
        begin = time.monotonic()
        with pytest.raises(br.core.InputError) as refused:
            run_study(study, bench.folder / "out", scheduler=address)
        assert time.monotonic() < begin + 5.0
        assert "--scheduler: no Dask scheduler answers at this address" in str(refused.value)
        assert f"found '{address}'" in str(refused.value)
        assert f"Start dask scheduler --port 8786, then dask worker {address}" in str(refused.value)


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.parametrize("option", [("--workers", "2"), ("--run", "3")])
def test_options_of_this_machine_exclude_a_cluster(bench, capsys, option):
    file = str(bench.write())
    assert (
        main(
            ["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1", *option]
        )
        == 2
    )
    assert (
        f"{option[0]}: simulates on this machine, --scheduler on a cluster"
        in capsys.readouterr().err
    )
    assert not (bench.folder / "out").exists()


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
def test_without_the_cluster_library_the_extra_is_named(bench, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    file = str(bench.write())
    assert (
        main(["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1"]) == 2
    )
    text = capsys.readouterr().err
    assert (
        'bristle study --scheduler needs an optional dependency. Type: pip install "bristle[study]"'
        in text
    )
    assert not (bench.folder / "out").exists()
    with pytest.raises(br.core.MissingExtraError):
        run_study(bench.study(), bench.folder / "out", scheduler="tcp://a:1")


@pytest.mark.slow
@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
def test_a_local_run_does_not_load_the_cluster_library(bench):
    file, out = bench.write(), bench.folder / "out"
    code = f"""
import sys, bristle.apps.study.command
from bristle.apps.study import read_study_file, run_study
run_study(read_study_file({str(file)!r}), {str(out)!r}, workers=1)
sys.exit(bool({{"dask", "distributed", "tornado"}} & set(sys.modules)))
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    # What is there already needs no cluster.
    assert run_study(read_study_file(file), out, scheduler="tcp://127.0.0.1:1").before == 3


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("is_elsewhere", [False, True])
def test_twelve_kills_in_six_hundred_blocks(slow_bench, own_dask, is_elsewhere):
    study = slow_bench.study(runs=("runs = 12", "runs = 2400"))
    assert len(study.blocks) == 600
    file, out = slow_bench.folder / "study.toml", slow_bench.folder / "out"
    run_study(study, slow_bench.folder / "undisturbed", workers=1)
    joined = {"nanny": [], "plain": []}

    def workers(process):
        if not is_elsewhere:
            return own_workers(process.pid)
        for kind, options in (("nanny", ()), ("plain", ("--no-nanny",))):
            # So ends a nanny whose worker could not begin.
            if not joined[kind] or joined[kind][-1].poll() is not None:
                joined[kind].append(own_dask.worker(*options))
        return [joined["plain"][-1].pid, *nursed(joined["nanny"][-1].pid)]

    options = ("--scheduler", own_dask.address) if is_elsewhere else ("--workers", "2")
    fallen = siege(lambda: begun(file, out, *options), workers, kills=12, longest=6.0)
    assert (fallen["command"] >= 1, fallen["worker"] >= 5) == (True, True), (
        "the study was over before it was disturbed"
    )
    assert run_study(study, out, workers=3).is_whole
    assert numbers(out) == list(range(2400))
    assert content(out) == content(slow_bench.folder / "undisturbed")
    assert not (out / ".partial").exists()


@pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them"
)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("is_elsewhere", "error", "words"),
    [
        (
            True,
            br.core.InputError,
            r"--scheduler: the scheduler no longer answers; found 'tcp://.*The results written so far remain",
        ),
        (
            False,
            WorkerError,
            r"on this machine, the scheduler no longer answers\. The finished runs stay",
        ),
    ],
)
def test_a_lost_scheduler_is_reported_and_written_blocks_stay(
    slow_bench, own_dask, monkeypatch, is_elsewhere, error, words
):
    monkeypatch.setattr("bristle.apps.study.workers.ANSWERS", 2.0)
    own_dask.worker("--no-nanny")
    study, out = slow_bench.study(runs=("runs = 12", "runs = 400")), slow_bench.folder / "out"
    others = {process.pid for process in own_dask.processes}

    def end(share, text):
        if share > 0.02:
            for pid in (
                {own_dask.scheduler.pid} if is_elsewhere else set(children(os.getpid())) - others
            ):
                os.kill(pid, signal.SIGKILL)

    with pytest.raises(error, match=words):
        run_study(
            study,
            out,
            progress=end,
            **({"scheduler": own_dask.address} if is_elsewhere else {"workers": 2}),
        )
    assert 3 <= len(content(out)) < 100
    assert run_study(study, out, workers=2).is_whole
