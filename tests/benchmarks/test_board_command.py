"""The command line of the score board: exit codes, messages and what stays in the folder."""

import json

import numpy as np
import pytest
from benchmarks.board.child import answered
from benchmarks.board.command import NAME, main
from benchmarks.board.record import Data, Record

from bristle.core import Axis

TIME = 1e-3 * np.arange(4000)
AXIS = Axis(kind="translational", cutoff=40.0)
RIGHT = (
    "def fit(train): return None\ndef predict(fitted, motion): return 3.0 * motion.acceleration\n"
)
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
    monkeypatch.setattr("benchmarks.board.run._data", lambda *_: Data([record], [record]))
    monkeypatch.setattr("benchmarks.board.run.answers", in_this_process)
    monkeypatch.setattr("benchmarks.board.task.Task.missing", "")
    for name, text in {"right": RIGHT, "wrong": WRONG}.items():
        (tmp_path / f"{name}.py").write_text(text)
    return tmp_path


@pytest.fixture
def board(capsys):
    """Run the command line on a task; return its exit code and what it printed."""

    def run(*words):
        capsys.readouterr()
        code = main([*words, "--task", "cogging", "--out", "out"])
        return code, *(" ".join(text.split()) for text in capsys.readouterr())

    return run


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_failed_competitor_has_its_reason_and_the_exit_code_1(board, folder, workers):
    code, out, _ = board("wrong.py", "right.py", "least_squares", "--workers", workers)
    assert (code, "line 2: KeyError: 'mass'" in out) == (1, True)
    code, out, _ = board("least_squares", "--workers", workers)
    assert (code, "out holds 2 results" in out, "KeyError" in out) == (0, True, False)


def test_a_run_without_a_possible_task_leaves_the_board(board, folder, monkeypatch):
    assert board("right.py", "least_squares")[0] == 0
    before = (folder / "out" / "score-board.json").read_text()
    monkeypatch.setattr("benchmarks.board.task.Task.missing", "BRISTLE_DATA is not set")
    code, _, err = board("right.py", "least_squares")
    assert (code, "no task can run with these competitors" in err) == (1, True)
    assert (folder / "out" / "score-board.json").read_text() == before
    assert set(json.loads(before)["scores"]["force"]["tasks"]["cogging"]) == {
        "right",
        "least_squares",
    }


def test_an_interrupted_run_says_that_the_results_are_kept(board, folder, monkeypatch):
    def interrupted(orders, limit):
        raise KeyboardInterrupt

    monkeypatch.setattr("benchmarks.board.run.answers", interrupted)
    code, _, err = board("right.py", "least_squares", "--workers", "1")
    assert (code, "out keeps the finished results" in err) == (130, True)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--help"], 0, f"Example: {NAME} my_competitor.py stribeck --task known_axis"),
        ([], 2, f"{NAME}: runs for half an hour"),
        (["--date", "yesterday"], 2, "'yesterday' is not a date"),
        (["lugree"], 2, "Did you mean 'lugre'?"),
    ],
)
def test_words_are_explained_or_refused(capsys, words, code, said):
    assert main(words) == code
    assert said in " ".join("".join(capsys.readouterr()).split())
