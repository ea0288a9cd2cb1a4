"""The blocks of a study on a Dask cluster, whose workers join and are killed: the bytes of a study on this machine."""

import signal
import socket
import subprocess
import sys
import time
import warnings
from contextlib import closing
from pathlib import Path

import pytest
from tests.study.conftest import content
from tests.study.processes import DaskCluster, begun, numbers, siege, until

from bristle.cli.main import main
from bristle.core.errors import InputError, InputWarning, MissingExtraError
from bristle.study import read_study_file, run_study
from bristle.study.block import Simulator

pytest.importorskip("distributed")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for processes as Linux shows them")]


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    """A scheduler and two workers."""
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
        warnings.simplefilter("ignore", InputWarning)
        study = read_study_file(bench.write(OF_TABLES), allow_code=True)
    assert not Simulator(study).varied.is_direct
    return study


def test_files_of_a_study_reach_the_workers_and_its_code_is_reported(own_study, bench, dask):
    run_study(own_study, bench.folder / "here", workers=1)
    names = ("own.py", "axis.toml", "motion.csv", "recorded.toml")
    for name in names:
        (bench.folder / name).unlink()
    message = []
    with pytest.warns(InputWarning, match=r"bristle runs the code in own.py \(SHA-256 [0-9a-f]{64}\) on every worker of tcp"):
        run_study(own_study, bench.folder / "there", scheduler=dask.address, progress=lambda share, text: message.append(text))
    assert content(bench.folder / "there") == content(bench.folder / "here")
    assert len(content(bench.folder / "there")) == 3
    assert message[-1] == "6 of 6 runs, 1 s left"


@pytest.fixture
def own_dask(tmp_path_factory):
    """A scheduler without workers, for what ends it or them."""
    with closing(DaskCluster(tmp_path_factory.mktemp("dask"))) as cluster:
        yield cluster


@pytest.fixture
def deaf():
    """A port at which something listens that never answers."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        yield listener.getsockname()[1]


def test_a_missing_scheduler_is_reported(bench, deaf, monkeypatch):
    monkeypatch.setattr("bristle.study.workers.ANSWERS", 0.5)
    study = bench.study()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    for address in (f"tcp://127.0.0.1:{port}", f"tcp://127.0.0.1:{deaf}", "http://a:80", "tcp://a b:80"):
        begin = time.monotonic()
        with pytest.raises(InputError) as refused:
            run_study(study, bench.folder / "out", scheduler=address)
        assert time.monotonic() < begin + 5.0
        assert "--scheduler: no Dask scheduler answers at this address" in str(refused.value)
        assert f"found '{address}'" in str(refused.value)
        assert f"Start dask scheduler --port 8786, then dask worker {address}" in str(refused.value)


@pytest.mark.parametrize("option", [("--workers", "2"), ("--run", "3")])
def test_options_of_this_machine_exclude_a_cluster(bench, capsys, option):
    file = str(bench.write())
    assert main(["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1", *option]) == 2
    assert f"{option[0]}: simulates on this machine, --scheduler on a cluster" in capsys.readouterr().err
    assert not (bench.folder / "out").exists()


def test_without_the_cluster_library_the_extra_is_named(bench, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    file = str(bench.write())
    assert main(["study", file, "--out", str(bench.folder / "out"), "--scheduler", "tcp://a:1"]) == 2
    text = capsys.readouterr().err
    assert 'bristle study --scheduler needs an optional dependency. Type: pip install "bristle[study]"' in text
    assert not (bench.folder / "out").exists()
    with pytest.raises(MissingExtraError):
        run_study(bench.study(), bench.folder / "out", scheduler="tcp://a:1")


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


def test_a_lost_scheduler_is_reported_and_written_blocks_stay(slow_bench, own_dask, monkeypatch):
    monkeypatch.setattr("bristle.study.workers.ANSWERS", 2.0)
    own_dask.worker("--no-nanny")
    study, out = slow_bench.study(runs=("runs = 12", "runs = 400")), slow_bench.folder / "out"

    def end(share, text):
        if share > 0.02:
            own_dask.scheduler.kill()

    with pytest.raises(InputError, match=r"--scheduler: the scheduler no longer answers; found 'tcp://.*The results written so far remain"):
        run_study(study, out, scheduler=own_dask.address, progress=end)
    assert 3 <= len(content(out)) < 100
    assert run_study(study, out, workers=2).is_whole


def test_threads_of_a_worker_write_the_same_bytes(slow_bench, own_dask):
    own_dask.worker("--no-nanny", "--nthreads", "3")
    study = slow_bench.study(runs=("runs = 12", "runs = 80"))
    run_study(study, slow_bench.folder / "here", workers=1)
    run_study(study, slow_bench.folder / "there", scheduler=own_dask.address)
    assert content(slow_bench.folder / "there") == content(slow_bench.folder / "here")
