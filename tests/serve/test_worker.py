"""What the process of a job says and does, run here with a standard input, an output and limits of its own."""

import io
import json
import signal
import threading
from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.server import tasks, worker
from bristle.server.worker import Interruption, main

resource = pytest.importorskip("resource")


class Output(io.StringIO):
    """A stream of which the other side sees what was flushed."""

    seen = ""

    def flush(self):
        self.seen = self.getvalue()


@pytest.fixture
def process(monkeypatch, tmp_path):
    """A function that lets a worker do a task: the code that it ends with, the events that it tells, and what else it did."""

    def noted(name):
        return lambda *arguments: done.append((name, *arguments))

    def run(task, **request):
        known = {"folder": str(tmp_path), "logs": [], "axis_text": "", "axis_label": "a.toml", "options": {}, "size_limit": 9}
        request = known | {"results": None, "memory": 2**30, "task": "look"} | request
        monkeypatch.setattr(worker.sys, "stdin", io.StringIO(json.dumps(request) + "\ncancel\n"))
        monkeypatch.setattr(tasks, "TASKS", {"look": task})
        with pytest.raises((SystemExit, ValueError)) as ended:
            main()
        return getattr(ended.value, "code", None), [json.loads(line) for line in output.seen.splitlines()], done

    done, output = [], Output()
    copied = {1: output}  # of the standard output alone
    calls = {"dup2": noted("dup2"), "chdir": noted("chdir"), "_exit": worker.sys.exit}
    monkeypatch.setattr(worker, "os", Some(dup=copied.__getitem__, fdopen=lambda stream, mode, encoding: stream, **calls))
    monkeypatch.setattr(worker, "Interruption", lambda **_: Some(allowed="allowed"))
    monkeypatch.setattr(signal, "signal", noted("signal"))
    monkeypatch.setattr(resource, "setrlimit", noted("limit"))
    return run


def test_an_answer_is_facts_for_the_page_and_data_in_the_folder(process, tmp_path):
    def task(errand):
        errand.report(0.5, "half of the work")
        return {"ready": True}, {"numbers": np.arange(3), "size": errand.size_limit, "may": errand.interruptible}

    code, events, _ = process(task, size_limit=7)
    assert (code, events) == (0, [{"share": 0.5, "text": "half of the work"}, {"facts": {"ready": True}}])
    assert json.loads((tmp_path / "data.json").read_text()) == {"numbers": [0, 1, 2], "size": 7, "may": "allowed"}


def test_a_worker_has_limits_and_a_folder_and_prints_to_the_complaints(process, tmp_path):
    *_, done = process(lambda errand: ({}, {}), memory=5_000)
    limits = [("limit", resource.RLIMIT_AS, (5_000, 5_000)), ("limit", resource.RLIMIT_CORE, (0, 0))]
    assert done == [("signal", signal.SIGINT, signal.default_int_handler), ("dup2", 2, 1), *limits, ("chdir", str(tmp_path))]


@pytest.mark.parametrize("refusal", [ValueError, OSError])
def test_a_limit_rejected_by_the_system_is_no_fault(process, monkeypatch, refusal):
    def refused(*limit):
        raise refusal

    monkeypatch.setattr(resource, "setrlimit", refused)
    assert process(lambda errand: ({"a": 1}, {}))[:2] == (0, [{"facts": {"a": 1}}])


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (KeyboardInterrupt(), 2, "cancelled before the first result"),
        (MemoryError("x"), 2, "there is not enough memory for this job. Use a shorter log"),
        (np._core._exceptions._ArrayMemoryError((9,), np.dtype(float)), 2, "there is not enough memory for this job. Use a shorter log"),
        (InputError("is wrong", path="log"), 2, "log: is wrong"),
        (ValueError("a bug"), None, "this is a fault of bristle, not yours: ValueError: a bug"),
    ],
)
def test_failing_work_gives_a_reason_and_leaves_no_data(process, tmp_path, error, code, words):
    def task(errand):
        raise error

    assert process(task)[:2] == (code, [{"refused": words}])
    assert not (tmp_path / "data.json").exists()


# --- interruption ---------------------------------------------------------------------------------------------------


@pytest.fixture
def orders(monkeypatch):
    """A function that gives a worker lines to listen to; how often the work was interrupted; and how the process ended."""

    def interruption(text):
        monkeypatch.setattr(worker.sys, "stdin", io.StringIO(text))
        return Interruption()

    interrupted, ended = [], []
    monkeypatch.setattr("_thread.interrupt_main", lambda: interrupted.append(True))
    monkeypatch.setattr(worker, "os", Some(_exit=ended.append))
    thread = Some(start=lambda: ended.append("begun"))
    monkeypatch.setattr(
        worker, "threading", Some(Thread=lambda target, daemon: thread, Lock=threading.Lock, main_thread=threading.main_thread)
    )
    return interruption, interrupted, ended


@pytest.mark.parametrize(("text", "count"), [("", 0), ("cancel\n", 1), ("  cancel \n", 1), ("cancelled\n", 0), ("cancel\ncancel\n", 1)])
def test_work_is_interrupted_once_for_a_cancellation(orders, text, count):
    interruption, interrupted, ended = orders
    item = interruption(text)
    with item.allowed():
        item._listen()
        assert len(interrupted) == count
    assert ended == ["begun", 1]  # with the server


def test_a_cancellation_before_the_work_interrupts_it_as_it_begins(orders):
    interruption, interrupted, _ = orders
    item = interruption("cancel\n")
    item._listen()
    assert interrupted == []
    with item.allowed():
        assert interrupted == [True]


def test_no_work_is_interrupted_after_its_end(orders):
    interruption, interrupted, _ = orders
    item = interruption("cancel\n")
    with pytest.raises(KeyError), item.allowed():
        raise KeyError
    item._listen()
    assert interrupted == []


@pytest.mark.parametrize(
    ("files", "imports"),
    [((), False), (("a.py", "b.py"), False), (("a.py", "<frozen importlib._bootstrap>", "b.py"), True), (("<frozen importlib>",), True)],
)
def test_an_import_is_detected_anywhere_in_the_stack(monkeypatch, files, imports):
    frame = None
    for file in reversed(files):
        frame = Some(f_code=Some(co_filename=file), f_back=frame)
    monkeypatch.setattr(worker.sys, "_current_frames", lambda: {threading.main_thread().ident: frame})
    assert worker._imports() is imports


def test_work_is_not_interrupted_in_an_import_but_after_it(orders, monkeypatch):
    interruption, interrupted, _ = orders
    item, states = interruption("cancel\n"), iter([True, True, False])
    monkeypatch.setattr(worker, "_imports", lambda: next(states))
    with item.allowed():
        item._listen()
    assert (interrupted, list(states)) == ([True], [])


def test_a_run_on_a_machine_outlives_its_server_until_the_machine_is_restored(monkeypatch):
    ended = []
    monkeypatch.setattr(worker.os, "_exit", ended.append)
    for restores, codes in ((True, []), (False, [1])):
        monkeypatch.setattr(worker.sys, "stdin", io.StringIO(""))
        interruption = Interruption(restores=restores)
        for thread in threading.enumerate():
            if thread is not threading.main_thread() and thread.daemon:
                thread.join(2.0)
        assert interruption.requested
        assert ended == codes
