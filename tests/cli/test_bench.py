"""Commands on a machine and on competitors: ``bristle bench``, ``bristle tune``."""

import json
from pathlib import Path

import numpy as np
import pytest

from bristle.bench.child import answered
from bristle.bench.record import Data, Record
from bristle.cli.main import main
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


def run(*arguments):
    return main(["bench", *arguments, "--task", "cogging", "--out", "out", "--workers", "1"])


def test_a_failed_competitor_has_its_reason_and_the_exit_code_1(folder, capsys):
    assert run("wrong.py", "right.py", "least_squares") == 1
    assert "line 2: KeyError: 'mass'" in capsys.readouterr().out
    assert run("least_squares") == 0
    text = capsys.readouterr().out
    assert "KeyError" not in text
    assert "out holds 2 results" in text


def test_a_run_without_a_possible_task_leaves_the_board(folder, capsys, monkeypatch):
    assert run("right.py", "least_squares") == 0
    before = (folder / "out" / "score-board.json").read_text()
    monkeypatch.setattr("bristle.bench.task.Task.missing", "BRISTLE_DATA is not set")
    assert run("right.py", "least_squares") == 1
    assert (folder / "out" / "score-board.json").read_text() == before
    assert set(json.loads(before)["scores"]["force"]["tasks"]["cogging"]) == {"right", "least_squares"}
    assert "no task can run with these competitors" in capsys.readouterr().err


RIG = Path(__file__).parents[2] / "examples/tune/machine.toml"


def test_a_machine_without_memory_is_refused_by_name(bristle, tmp_path, monkeypatch):
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    (tmp_path / "out").mkdir()
    Journal(tmp_path / "out").write("verdict", "begun", file=str(RIG))
    bristle("tune", "--save", str(tmp_path / "out"), code=1, said="the machine experiment has no non-volatile memory")
