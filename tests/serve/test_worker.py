"""What the process of a job says and does, run here with a standard input, an output and limits of its own."""

import io
import json
import os
import signal
import threading
import time
from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.server import tasks, worker
from bristle.server.worker import Interruption, main

resource = pytest.importorskip("resource")


class Ended(BaseException):
    """The process ends with this code."""


class Process:
    """What a worker sees of its process."""

    def __init__(self, monkeypatch, folder):
        self.done, self.folder, self.said = [], folder, folder / "said"
        self.patch = monkeypatch
        reading, writing = os.pipe()
        self.input, self.orders = os.fdopen(reading), os.fdopen(writing, "w")
        self.output = self.said.open("w", encoding="utf-8")
        calls = {"dup2": self.noted("dup2"), "chdir": self.noted("chdir"), "_exit": self.exit}
        copied = {1: self.output}  # of the standard output alone
        monkeypatch.setattr(worker, "os", Some(dup=copied.__getitem__, fdopen=lambda stream, mode, encoding: stream, **calls))
        monkeypatch.setattr(worker.sys, "stdin", self.input)
        monkeypatch.setattr(signal, "signal", self.noted("signal"))
        monkeypatch.setattr(resource, "setrlimit", self.noted("limit"))

    def noted(self, name):
        return lambda *arguments: self.done.append((name, *arguments))

    def exit(self, code):
        if threading.current_thread() is threading.main_thread():
            raise Ended(code)
        self.done.append(("ended", code))

    def runs(self, task, **request):
        """Let it do a task, and return the code that it ends with and the events that it tells."""
        told = {"folder": str(self.folder), "logs": [], "axis_text": "", "axis_label": "a.toml", "options": {}, "size_limit": 9}
        self.orders.write(json.dumps(told | {"results": None, "memory": 2**30, "task": "look"} | request) + "\n")
        self.orders.flush()
        self.patch.setattr(tasks, "TASKS", {"look": task})
        code = None
        try:
            main()
        except Ended as end:
            (code,) = end.args
        except ValueError:
            pass
        return code, [json.loads(line) for line in self.said.read_text().splitlines()]

    def hangs_up(self):
        self.orders.close()
        until = time.monotonic() + 5.0
        while ("ended", 1) not in self.done and time.monotonic() < until:
            time.sleep(0.001)


@pytest.fixture
def process(monkeypatch, tmp_path):
    item = Process(monkeypatch, tmp_path)
    yield item
    item.hangs_up()
    item.input.close()
    item.output.close()


def test_an_answer_is_facts_for_the_page_and_data_in_the_folder(process):
    def task(errand):
        errand.report(0.5, "half of the work")
        return {"ready": True}, {"numbers": np.arange(3), "size": errand.size_limit}

    code, events = process.runs(task, size_limit=7)
    assert code == 0
    assert events == [{"share": 0.5, "text": "half of the work"}, {"facts": {"ready": True}}]
    assert json.loads((process.folder / "data.json").read_text()) == {"numbers": [0, 1, 2], "size": 7}


def test_a_worker_has_limits_and_a_folder_and_prints_to_the_complaints(process):
    process.runs(lambda errand: ({}, {}), memory=5_000)
    assert ("limit", resource.RLIMIT_AS, (5_000, 5_000)) in process.done
    assert ("limit", resource.RLIMIT_CORE, (0, 0)) in process.done
    assert ("chdir", str(process.folder)) in process.done
    assert ("dup2", 2, 1) in process.done
    assert ("signal", signal.SIGINT, signal.default_int_handler) in process.done


@pytest.mark.parametrize("refusal", [ValueError, OSError])
def test_a_limit_that_the_system_does_not_take_is_no_fault(process, monkeypatch, refusal):
    def refused(*limit):
        raise refusal

    monkeypatch.setattr(resource, "setrlimit", refused)
    assert process.runs(lambda errand: ({"a": 1}, {})) == (0, [{"facts": {"a": 1}}])


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (KeyboardInterrupt(), "cancelled before anything was found"),
        (MemoryError("x"), "there is not enough memory for this. Take a shorter log"),
        (np._core._exceptions._ArrayMemoryError((9,), np.dtype(float)), "there is not enough memory for this. Take a shorter log"),
        (InputError("is wrong", path="log"), "log: is wrong"),
    ],
)
def test_work_that_is_refused_says_why_and_leaves_no_data(process, error, words):
    def task(errand):
        raise error

    assert process.runs(task) == (2, [{"refused": words}])
    assert not (process.folder / "data.json").exists()


def test_a_fault_of_bristle_is_not_that_of_the_person(process):
    def task(errand):
        raise ValueError("a bug")

    assert process.runs(task) == (None, [{"refused": "this is a fault of bristle, not yours: ValueError: a bug"}])


# --- interruption ---------------------------------------------------------------------------------------------------


@pytest.fixture
def interrupted(monkeypatch):
    """How often the work was interrupted."""
    calls = []
    monkeypatch.setattr("_thread.interrupt_main", lambda: calls.append(True))
    return calls


def orders(monkeypatch, text=""):
    """Give a worker these lines; the end of them is the end of the server, which is noted."""
    ended = []
    monkeypatch.setattr(worker, "os", Some(_exit=ended.append))
    monkeypatch.setattr(worker.sys, "stdin", io.StringIO(text))
    thread = threading.Thread
    monkeypatch.setattr(worker.threading, "Thread", lambda target, daemon: Some(start=lambda: None, target=target, daemon=daemon))
    item = Interruption()
    monkeypatch.setattr(worker.threading, "Thread", thread)
    return item, ended


@pytest.mark.parametrize(("text", "count"), [("", 0), ("cancel\n", 1), ("  cancel \n", 1), ("cancelled\n", 0), ("cancel\ncancel\n", 1)])
def test_work_is_interrupted_once_for_a_cancellation(monkeypatch, interrupted, text, count):
    item, ended = orders(monkeypatch, text)
    with item.allowed():
        item._listen()
        assert len(interrupted) == count
    assert ended == [1]


def test_a_cancellation_before_the_work_interrupts_it_as_it_begins(monkeypatch, interrupted):
    item, _ = orders(monkeypatch, "cancel\n")
    item._listen()
    assert interrupted == []
    with item.allowed():
        assert interrupted == [True]
    with item.allowed():
        assert interrupted == [True, True]


def test_no_work_is_interrupted_after_its_end(monkeypatch, interrupted):
    item, _ = orders(monkeypatch, "cancel\n")
    with pytest.raises(KeyError), item.allowed():
        raise KeyError
    item._listen()
    assert interrupted == []


def frames(*files):
    """The frames of the main thread, the innermost first."""
    frame = None
    for file in reversed(files):
        frame = Some(f_code=Some(co_filename=file), f_back=frame)
    return {threading.main_thread().ident: frame}


@pytest.mark.parametrize(
    ("files", "imports"),
    [
        ((), False),
        (("a.py", "b.py"), False),
        (("a.py", "<frozen importlib._bootstrap>", "b.py"), True),
        (("<frozen importlib.util>",), True),
    ],
)
def test_an_import_is_seen_wherever_it_stands_among_the_frames(monkeypatch, files, imports):
    monkeypatch.setattr(worker.sys, "_current_frames", lambda: frames(*files))
    assert worker._imports() is imports


def test_work_is_not_interrupted_in_an_import_but_after_it(monkeypatch, interrupted):
    item, _ = orders(monkeypatch, "cancel\n")
    states = iter([True, True, False])
    monkeypatch.setattr(worker, "_imports", lambda: next(states))
    with item.allowed():
        item._listen()
    assert interrupted == [True]
    assert next(states, None) is None
