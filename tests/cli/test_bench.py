"""Commands on a machine and on competitors: ``bristle bench``, ``bristle tune``."""

import json
from pathlib import Path

import numpy as np
import pytest

from bristle.bench.child import answered
from bristle.bench.record import Data, Record
from bristle.core import Axis
from bristle.tune.journal import Journal

TIME = 1e-3 * np.arange(4000)
AXIS = Axis(kind="translational", cutoff=40.0)
RIGHT = "def fit(train): return None\ndef predict(fitted, motion): return 3.0 * motion.acceleration\n"
WRONG = "def fit(train):\n    return {}['mass']\ndef predict(fitted, motion): return fitted\n"


def in_this_process(orders, limit):
    """The answers of a competitor without a process of its own; a fault of its fit is the answer to all."""
    replies = dict(answered(orders))
    return {name: replies.get(name, replies.get("fit")) for name in orders.names}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two competitors, and a mass of 3 kg as the record of a task."""
    motion = Record.of(TIME, 0.02 * np.sin(6.0 * TIME), None, AXIS)
    record = Record.of(TIME, motion.position, 3.0 * motion.acceleration, AXIS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("bristle.bench.run._data", lambda *_: Data([record], [record]))
    monkeypatch.setattr("bristle.bench.run.answers", in_this_process)
    monkeypatch.setattr("bristle.bench.task.Task.missing", "")
    for name, text in {"right": RIGHT, "wrong": WRONG}.items():
        (tmp_path / f"{name}.py").write_text(text)
    return tmp_path


def bench(bristle, *competitors, **ends):
    return bristle("bench", *competitors, "--task", "cogging", "--out", "out", "--workers", "1", **ends)


def test_a_failed_competitor_has_its_reason_and_the_exit_code_1(bristle, folder):
    bench(bristle, "wrong.py", "right.py", "least_squares", code=1, shown="line 2: KeyError: 'mass'")
    assert "KeyError" not in bench(bristle, "least_squares", code=0, shown="out holds 2 results").out


def test_a_run_without_a_possible_task_leaves_the_board(bristle, folder, monkeypatch):
    bench(bristle, "right.py", "least_squares", code=0)
    before = (folder / "out" / "score-board.json").read_text()
    monkeypatch.setattr("bristle.bench.task.Task.missing", "BRISTLE_DATA is not set")
    bench(bristle, "right.py", "least_squares", code=1, said="no task can run with these competitors")
    assert (folder / "out" / "score-board.json").read_text() == before
    assert set(json.loads(before)["scores"]["force"]["tasks"]["cogging"]) == {"right", "least_squares"}


RIG = Path(__file__).parents[2] / "examples/tune/machine.toml"


def test_a_machine_without_memory_is_refused_by_name(bristle, tmp_path, monkeypatch):
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    (tmp_path / "out").mkdir()
    Journal(tmp_path / "out").write("verdict", "begun", file=str(RIG))
    bristle("tune", "--save", str(tmp_path / "out"), code=1, said="the machine experiment has no non-volatile memory")
