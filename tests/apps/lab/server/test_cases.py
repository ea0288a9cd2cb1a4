"""What an analysis holds and says, without a server around it."""

import asyncio
import io
import json
import signal
import threading
import time
from types import SimpleNamespace as Some

import numpy as np
import pytest
from starlette.requests import ClientDisconnect

from bristle.apps.lab.server import Limits, tasks, worker
from bristle.apps.lab.server.cases import (
    Case,
    Cases,
    Job,
    Part,
    StoredFile,
    _last_of,
    announced_by,
    json_of,
    label_of,
    stored,
)
from bristle.apps.lab.server.limits import RefusedRequestError
from bristle.core.errors import InputError


@pytest.fixture
def case(tmp_path):
    return Case("a", tmp_path)


def dropped(case, role="fit", size=10, label="log.csv"):
    """Put a file into an analysis, without any bytes."""
    number = case.number()
    case.files[number] = StoredFile(number, label, role, size, case.folder / f"file-{number}")
    return case.files[number]


def left(case, name, folder="job"):
    """Leave a part as a job does."""
    place = case.folder / folder
    place.mkdir()
    case.keep(name, Part(case.number(), place, {"word": name}, case.inputs_of(name)))
    return place


def test_numbers_are_never_given_twice(case):
    numbers = [dropped(case).number for _ in range(2)]
    del case.files[2]
    assert (numbers, dropped(case).number) == ([1, 2], 3)


@pytest.mark.parametrize(
    ("role", "old"),
    [
        ("fit", {"looked", "checked", "identified", "predicted", "exported"}),
        ("axis", {"looked", "checked", "identified", "predicted", "exported"}),
        ("held_out", {"checked", "predicted"}),
    ],
)
def test_a_result_is_old_after_a_change_of_its_file(case, role, old):
    names = ("looked", "checked", "identified", "predicted", "exported", "excited")
    for name in names:
        left(case, name, name)
    assert not any(case.is_old(name) for name in (*names, "missing"))
    case.changed(role)
    assert (
        {name for name, part in case.as_data()["parts"].items() if part["old"]}
        == {name for name in names if case.is_old(name)}
        == old
    )


def test_a_new_part_removes_the_files_of_the_previous_part(case):
    first, second = left(case, "looked", "first"), left(case, "looked", "second")
    assert (first.exists(), second.exists(), case.parts["looked"].folder) == (False, True, second)


def test_logs_come_in_their_order_by_role(case):
    first, second, third = (dropped(case, role) for role in ("fit", "held_out", "fit"))
    asked = [case.logs(*roles) for roles in (("fit",), ("held_out", "fit"), ())]
    assert asked == [[first, third], [first, second, third], []]


def test_the_page_gets_the_complete_state_of_an_analysis(case):
    dropped(case, "held_out", 7, "later.csv")
    case.axis, case.axis_label = "schema = 1\n", "stage.toml"
    left(case, "looked")
    assert case.as_data() == {
        "id": "a",
        "files": [{"number": 1, "label": "later.csv", "role": "held_out", "size": 7}],
        "axis": {"label": "stage.toml", "text": "schema = 1\n"},
        "parts": {"looked": {"revision": 2, "old": False, "word": "looked"}},
        "machine": None,
        "job": None,
    }


# --- all analyses ---------------------------------------------------------------------------------------------------


LIMITS = Limits(file_size=100, total_size=250, files=3, cases=2)


@pytest.fixture
def cases(tmp_path):
    return Cases(tmp_path, LIMITS)


def test_an_analysis_is_found_by_its_name_until_it_is_closed(cases):
    first, second = cases.new(), cases.new()
    assert (cases[first.identifier], cases[second.identifier]) == (first, second)
    assert first.folder.stat().st_mode & 0o777 == 0o700
    cases.close(first)
    assert (first.folder.exists(), list(cases)) == (False, [second])
    with pytest.raises(RefusedRequestError, match="no longer open") as refused:
        cases[first.identifier]
    assert refused.value.status == 404


@pytest.mark.parametrize(
    ("first", "second", "removed"),
    [(700.0, 800.0, 1), (610.0, 0.0, 0), (590.0, 590.0, None), (900.0, 0.0, 0), (0.0, 900.0, 1)],
)
def test_the_longest_unused_analysis_makes_room_after_ten_minutes(cases, first, second, removed):
    both = [cases.new(), cases.new()]
    for case, ago in zip(both, (first, second), strict=True):
        case.seen_at -= ago
    if removed is None:
        with pytest.raises(RefusedRequestError, match=r"2 analyses are open.*up to 2") as refused:
            cases.new()
        assert refused.value.status == 429
    else:
        third = cases.new()
        assert list(cases) == [both[1 - removed], third]
        assert not both[removed].folder.exists()


def test_looking_at_an_analysis_keeps_it(cases):
    first = cases.new()
    first.seen_at -= 50.0
    assert time.monotonic() - cases[first.identifier].seen_at < 10.0


def test_an_analysis_whose_job_runs_makes_no_room(cases):
    first, second = cases.new(), cases.new()
    first.seen_at -= 1000.0
    first.job = Job("look", LIMITS)
    with pytest.raises(RefusedRequestError, match="analyses are open"):
        cases.new()
    first.job.state = "done"
    third = cases.new()
    assert list(cases) == [second, third]


def with_files(cases, sizes, receiving):
    """Two analyses with a file of each of these sizes, and the second of them."""
    for size in sizes:
        dropped(cases.new(), size=size)
    cases.receiving = receiving
    return list(cases)[-1]


@pytest.mark.parametrize(
    ("sizes", "receiving", "announced", "room"),
    [
        ((0, 0), 0, 0, 100),
        ((100, 80), 0, 0, 70),
        ((100, 80), 0, 70, 70),
        ((100, 80), 60, 0, 10),
        ((0, 0), 0, 101, 100),
        ((100, 80), 0, 101, 70),
    ],
)
def test_a_file_has_the_room_that_all_others_leave(cases, sizes, receiving, announced, room):
    assert cases.room_for(with_files(cases, sizes, receiving), announced) == room


@pytest.mark.parametrize(("receiving", "announced"), [(70, 0), (0, 71), (0, 100)])
def test_a_file_beyond_the_total_size_is_refused_for_the_total(cases, receiving, announced):
    case = with_files(cases, (100, 80), receiving)
    with pytest.raises(
        RefusedRequestError, match=r"all files together are too large.*Remove some"
    ) as refused:
        cases.room_for(case, announced)
    assert refused.value.status == 413


def test_the_number_of_files_is_limited(cases):
    case = cases.new()
    for _ in range(3):
        cases.room_for(case, 1)
        dropped(case, size=1)
    with pytest.raises(RefusedRequestError, match=r"the analysis has 3 files already.*up to 3"):
        cases.room_for(case, 1)


# --- jobs -----------------------------------------------------------------------------------------------------------


def test_a_waiting_job_has_a_state():
    job = Job("look", LIMITS)
    assert job.runs
    assert job.as_data() == {
        "task": "look",
        "state": "runs",
        "share": 0.0,
        "text": "starting",
        "message": "",
        "seconds": 0.0,
        "cancelled": False,
    }
    job._begun, job._ended = 10.0, 12.34
    assert job.as_data()["seconds"] == 2.3


SIGNAL = (
    "signal 9 ended the process of this job, perhaps because memory ran out. "
    "The other results remain. Run the job again, or use a shorter log"
)


@pytest.mark.parametrize(
    ("facts", "code", "complaint", "words"),
    [
        ({}, -9, "", SIGNAL),
        ({}, 3, "the end", "the process of this job ended with code 3. the end"),
        ({}, 3, "", "the process of this job ended with code 3."),
        ({"_late": True}, -9, "", "stopped after 90 s. Use fewer models, or a shorter log"),
        ({"_late": True, "_killed": True}, -9, "", "stopped"),
    ],
)
def test_a_job_reports_its_end(facts, code, complaint, words):
    job = Job("look", Limits(job_seconds=90.0))
    vars(job).update(facts)
    assert job._ending(code, complaint) == words


@pytest.mark.parametrize(
    ("facts", "code", "state"),
    [
        ({"_answered": True}, 0, "done"),
        ({"_answered": True}, 1, "failed"),
        ({}, 0, "failed"),
        ({"_killed": True}, -9, "cancelled"),
        ({"_cancelled": True}, 2, "cancelled"),
        ({"_cancelled": True, "_late": True}, -9, "failed"),
        ({"_cancelled": True, "_answered": True}, 0, "done"),
    ],
)
def test_the_end_of_a_job_decides_its_state(monkeypatch, facts, code, state):
    job = Job("look", LIMITS)
    vars(job).update(facts)

    async def ended(request):
        return code, "why"

    monkeypatch.setattr(job, "_ended_with", ended)
    assert asyncio.run(job.run({})) is (state == "done")
    assert (job.state, job.runs) == (state, False)
    assert job._ended >= job._begun


def test_a_job_that_cannot_run_gives_a_reason(monkeypatch):
    job = Job("look", LIMITS)

    async def breaks(request):
        raise OSError("no more processes")

    monkeypatch.setattr(job, "_ended_with", breaks)
    assert not asyncio.run(job.run({}))
    assert (job.state, job.message) == (
        "failed",
        "bristle could not run the job: no more processes",
    )


def test_a_job_that_has_not_started_or_has_ended_is_not_cancelled():
    job = Job("look", LIMITS)
    job.cancel()
    assert not job.as_data()["cancelled"]
    job.kill()
    assert job._killed


@pytest.mark.parametrize(
    ("complained", "last"),
    [
        (b"", ""),
        (b"first\nlast\n", "last"),
        (b"x" * 5000 + b"\nthe end\n\n", "the end"),
        (b"caf\xe9", "caf\ufffd"),
        (b"y" * 1000, "y" * 297 + "..."),
    ],
)
def test_the_last_line_of_a_complaint_is_kept_and_shortened(complained, last):
    async def read():
        stream = asyncio.StreamReader()
        stream.feed_data(complained)
        stream.feed_eof()
        return await _last_of(stream)

    assert asyncio.run(read()) == last
    assert asyncio.run(_last_of(None)) == ""


def test_a_refusal_has_a_status_and_the_words_of_an_input_error():
    refused = RefusedRequestError(413, "is too large", path="file", allowed="up to 1 kB")
    assert isinstance(refused, InputError)
    assert (refused.status, str(refused)) == (413, "file: is too large; allowed up to 1 kB")


# --- bodies of requests ---------------------------------------------------------------------------------------------


class Request:
    """A request whose body comes in pieces; a piece may be an error, or seconds to wait."""

    def __init__(self, *pieces, size=None):
        self.pieces, self.headers = pieces, {} if size is None else {"content-length": str(size)}

    async def stream(self):
        for piece in self.pieces:
            if isinstance(piece, Exception):
                raise piece
            if isinstance(piece, float):
                await asyncio.sleep(piece)
            else:
                yield piece


@pytest.mark.parametrize("size", [None, 5])
def test_a_body_is_stored_whole_and_its_size_is_returned(tmp_path, size):
    assert (
        asyncio.run(stored(Request(b"ab", b"", b"cde", size=size), tmp_path / "log", 5, 1.0)) == 5
    )
    assert (tmp_path / "log").read_bytes() == b"abcde"
    assert asyncio.run(stored(Request(), tmp_path / "empty", 5, 1.0)) == 0


@pytest.mark.parametrize(
    ("request_", "status", "words"),
    [
        (Request(b"abc", b"def"), 413, "is larger than allowed.*up to 5 B"),
        (Request(b"ab", size=6), 413, "is larger than allowed"),
        (Request(b"ab", 5.0, b"c"), 408, "has sent no data for 0.02 s"),
        (Request(b"ab", ClientDisconnect()), 400, "ended before all data arrived"),
    ],
)
def test_a_body_that_is_refused_leaves_no_file(tmp_path, request_, status, words):
    with pytest.raises(RefusedRequestError, match=words) as refused:
        asyncio.run(stored(request_, tmp_path / "log", 5, 0.02))
    assert refused.value.status == status
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_is_not_written_over(tmp_path):
    (tmp_path / "log").write_bytes(b"mine")
    with pytest.raises(FileExistsError):
        asyncio.run(stored(Request(b"ab"), tmp_path / "log", 5, 1.0))


@pytest.mark.parametrize(
    "text",
    [b"[1]", b"{", b"\xff", b"null", b"[" * 99_999],
    ids=["list", "open", "bytes", "null", "deep"],
)
def test_a_message_is_a_json_object(text):
    assert asyncio.run(json_of(Request(b'{"task":', b' "look"}'), 100, 1.0)) == {"task": "look"}
    with pytest.raises(RefusedRequestError, match="must be a JSON object") as refused:
        asyncio.run(json_of(Request(text), 100_000, 1.0))
    assert refused.value.status == 400


@pytest.mark.parametrize(
    ("told", "given", "result"),
    [
        # A label is short and keeps its ending.
        (label_of, "x" * 300 + ".csv", "x" * 97 + "....csv"),
        (label_of, "log." + "y" * 30, "log." + "y" * 10),
        (label_of, "a%20b.csv", "a b.csv"),
        # A head that is silent on the size states none.
        (announced_by, Request(), 0),
        (announced_by, Request(size=7), 7),
    ],
)
def test_a_request_announces_its_label_and_its_size(told, given, result):
    assert told(given) == result


# --- What the process of a job says and does, run here with a standard input, an output and limits of its own


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

    def run(work, **request):
        known = {
            "folder": str(tmp_path),
            "logs": [],
            "axis_text": "",
            "axis_label": "a.toml",
            "options": {},
            "size_limit": 9,
        }
        request = known | {"results": None, "memory": 2**30, "task": "look"} | request
        monkeypatch.setattr(worker.sys, "stdin", io.StringIO(json.dumps(request) + "\ncancel\n"))
        monkeypatch.setattr(tasks, "TASKS", {"look": work, "tune": work})
        with pytest.raises((SystemExit, ValueError)) as ended:
            worker.main()
        return (
            getattr(ended.value, "code", None),
            [json.loads(line) for line in output.seen.splitlines()],
            done,
        )

    done, output = [], Output()
    copied = {1: output}  # of the standard output alone
    calls = {"dup2": noted("dup2"), "chdir": noted("chdir"), "_exit": worker.sys.exit}
    monkeypatch.setattr(
        worker,
        "os",
        Some(dup=copied.__getitem__, fdopen=lambda stream, mode, encoding: stream, **calls),
    )
    monkeypatch.setattr(
        worker, "Interruption", lambda restores: Some(allowed=f"allowed, restores {restores}")
    )
    monkeypatch.setattr(signal, "signal", noted("signal"))
    monkeypatch.setattr(resource, "setrlimit", noted("limit"))
    return run


@pytest.mark.parametrize(("name", "restores"), [("look", False), ("tune", True)])
def test_an_answer_is_facts_for_the_page_and_data_in_the_folder(process, tmp_path, name, restores):
    def task(errand):
        errand.report(0.5, "half of the work")
        return {"ready": True}, {
            "numbers": np.arange(3),
            "size": errand.size_limit,
            "may": errand.interruptible,
        }

    code, events, _ = process(task, size_limit=7, task=name)
    assert (code, events) == (
        0,
        [{"share": 0.5, "text": "half of the work"}, {"facts": {"ready": True}}],
    )
    assert json.loads((tmp_path / "data.json").read_text()) == {
        "numbers": [0, 1, 2],
        "size": 7,
        "may": f"allowed, restores {restores}",
    }


def test_a_worker_has_limits_and_a_folder_and_prints_to_the_complaints(process, tmp_path):
    *_, done = process(lambda errand: ({}, {}), memory=5_000)
    limits = [
        ("limit", resource.RLIMIT_AS, (5_000, 5_000)),
        ("limit", resource.RLIMIT_CORE, (0, 0)),
    ]
    assert done == [
        ("signal", signal.SIGINT, signal.default_int_handler),
        ("dup2", 2, 1),
        *limits,
        ("chdir", str(tmp_path)),
    ]


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
        (
            np._core._exceptions._ArrayMemoryError((9,), np.dtype(float)),
            2,
            "there is not enough memory for this job. Use a shorter log",
        ),
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
        return worker.Interruption()

    interrupted, ended = [], []
    monkeypatch.setattr("_thread.interrupt_main", lambda: interrupted.append(True))
    monkeypatch.setattr(worker, "os", Some(_exit=ended.append))
    thread = Some(start=lambda: ended.append("begun"))
    monkeypatch.setattr(
        worker,
        "threading",
        Some(
            Thread=lambda target, daemon: thread,
            Lock=threading.Lock,
            main_thread=threading.main_thread,
        ),
    )
    return interruption, interrupted, ended


@pytest.mark.parametrize(
    ("text", "count"),
    [("", 0), ("cancel\n", 1), ("  cancel \n", 1), ("cancelled\n", 0), ("cancel\ncancel\n", 1)],
)
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
    [
        ((), False),
        (("a.py", "b.py"), False),
        (("a.py", "<frozen importlib._bootstrap>", "b.py"), True),
        (("<frozen importlib>",), True),
    ],
)
def test_an_import_is_detected_anywhere_in_the_stack(monkeypatch, files, imports):
    frame = None
    for file in reversed(files):
        frame = Some(f_code=Some(co_filename=file), f_back=frame)
    monkeypatch.setattr(
        worker.sys, "_current_frames", lambda: {threading.main_thread().ident: frame}
    )
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
        interruption = worker.Interruption(restores=restores)
        for thread in threading.enumerate():
            if thread is not threading.main_thread() and thread.daemon:
                thread.join(2.0)
        assert interruption.requested
        assert ended == codes
