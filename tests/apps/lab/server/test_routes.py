"""What the page may ask for, of parts that lie there already and jobs that only stand there."""

import json
import threading
import time
from pathlib import Path

import pytest
from tests.apps.lab.server.yard import TOKEN, begun, put, served

from bristle.apps.lab.server import Limits, cases, routes

LIMITS = Limits(file_size=1000, total_size=2500, body_size=500, files=4, cases=3, jobs=2)


@pytest.fixture
def case(client):
    return begun(client)


@pytest.fixture
def opened(app, case):
    """The analysis behind the address."""
    return app.state.cases[case.rpartition("/")[2]]


def left(opened, name, facts=None, **files):
    """Leave a part with these files."""
    folder = opened.folder / f"job-{opened.number()}"
    folder.mkdir()
    for file, text in files.items():
        place = folder / file.replace("__", "/").replace("_", ".")
        place.parent.mkdir(exist_ok=True)
        place.write_text(text)
    opened.keep(name, cases.Part(opened.number(), folder, facts or {}, opened.inputs_of(name)))


def running(state="runs"):
    job = cases.Job("identify", LIMITS)
    job.state = state
    return job


def test_a_result_is_served_once_it_exists(client, case, opened):
    assert client.get(f"{case}/parts/looked").status_code == 404
    left(opened, "looked", data_json='{"a": 1}')
    answer = client.get(f"{case}/parts/looked")
    assert (answer.json(), answer.headers["content-type"]) == ({"a": 1}, "application/json")


@pytest.mark.parametrize(
    ("name", "file", "label"),
    [
        ("identified", "results_zip", "results.zip"),
        ("exported", "export_zip", "export.zip"),
        ("excited", "motion_zip", "motion.zip"),
    ],
)
def test_an_archive_is_named_after_its_contents(client, case, opened, name, file, label):
    left(opened, name, **{file: "zip"})
    answer = client.get(f"{case}/parts/{name}/archive")
    assert (answer.content, answer.headers["content-type"]) == (b"zip", "application/zip")
    assert f'filename="{label}"' in answer.headers["content-disposition"]


def test_an_export_has_the_name_from_its_job(client, case, opened):
    left(opened, "exported", {"file": "axis_table.zip"}, export_zip="zip")
    assert (
        'filename="axis_table.zip"'
        in client.get(f"{case}/parts/exported/archive").headers["content-disposition"]
    )


def test_a_part_without_archive_or_report_has_none(client, case, opened):
    left(opened, "looked", data_json="{}")
    for answer, kind in (
        (client.get(f"{case}/parts/looked/archive"), "archive"),
        (client.post(f"{case}/parts/looked/ticket"), "report"),
    ):
        assert (answer.status_code, answer.json()["message"]) == (404, f"looked: has no {kind}")


@pytest.mark.parametrize(
    ("name", "file"), [("identified", "results__report_html"), ("excited", "motion__report_html")]
)
def test_a_report_is_shown_once(client, case, opened, name, file):
    left(opened, name, **{file: "<p>report</p>"})
    answer = client.post(f"{case}/parts/{name}/ticket")
    assert answer.status_code == 201
    address = answer.json()["address"]
    shown = client.get(address)
    assert (shown.status_code, shown.text) == (200, "<p>report</p>")
    policy = shown.headers["content-security-policy"]
    assert policy.startswith("sandbox allow-scripts allow-downloads; default-src 'none'")
    assert "allow-same-origin" not in policy
    again = client.get(address)
    assert (again.status_code, "is no longer available" in again.json()["message"]) == (404, True)


@pytest.mark.parametrize(("ago", "status"), [(59.0, 200), (61.0, 404)])
def test_a_ticket_holds_for_a_minute(client, case, opened, monkeypatch, ago, status):
    left(opened, "identified", results__report_html="x")
    address = client.post(f"{case}/parts/identified/ticket").json()["address"]
    now = time.monotonic()

    class Clock:
        @staticmethod
        def monotonic():
            return now + ago

    monkeypatch.setattr(routes, "time", Clock)
    assert client.get(address).status_code == status


def test_a_new_ticket_removes_expired_tickets(client, case, opened, app):
    left(opened, "identified", results__report_html="x")
    addresses = [client.post(f"{case}/parts/identified/ticket").json()["address"] for _ in range(3)]
    assert len(set(addresses)) == 3
    assert [client.get(address).status_code for address in addresses] == [200, 200, 200]


def test_the_report_of_a_closed_analysis_is_unavailable(client, case, opened):
    left(opened, "identified", results__report_html="x")
    address = client.post(f"{case}/parts/identified/ticket").json()["address"]
    client.delete(case)
    assert [client.get(path).status_code for path in (address, case)] == [404, 404]
    assert not opened.folder.exists()


def test_an_axis_file_is_the_axis_and_no_log(client, case, opened):
    state = put(client, case, b"\xef\xbb\xbfschema = 1\n", "stage.toml", "axis").json()
    assert (state["axis"], state["files"]) == ({"label": "stage.toml", "text": "schema = 1\n"}, [])
    refused = put(client, case, b"\xff\xfe", "bad.toml", "axis")
    assert (refused.status_code, refused.json()["message"]) == (
        400,
        "bad.toml: is not a text file in UTF-8",
    )
    assert list(opened.folder.iterdir()) == []
    assert client.get(case).json()["axis"]["label"] == "stage.toml"


def test_an_unknown_role_is_refused(client, case):
    answer = put(client, case, b"x", role="other")
    assert (answer.status_code, "allowed fit, held_out, axis" in answer.json()["message"]) == (
        400,
        True,
    )


def test_files_change_their_role_and_are_removed(client, case, opened):
    put(client, case, b"1")
    put(client, case, b"2", "later.csv", "held_out")
    for name in ("looked", "predicted"):
        left(opened, name)
    state = client.post(f"{case}/files/1/role", json={"role": "held_out"}).json()
    assert [file["role"] for file in state["files"]] == ["held_out", "held_out"]
    assert {name: part["old"] for name, part in state["parts"].items()} == {
        "looked": True,
        "predicted": True,
    }
    for number, role, status in ((1, "axis", 400), (9, "fit", 404)):
        assert client.post(f"{case}/files/{number}/role", json={"role": role}).status_code == status
    place = opened.files[2].place
    assert [file["number"] for file in client.delete(f"{case}/files/2").json()["files"]] == [1]
    assert not place.exists()
    assert client.delete(f"{case}/files/2").status_code == 404


@pytest.mark.parametrize("size", [900, 1001])
def test_a_file_in_transfer_counts_towards_the_limit_no_longer_than_that(client, case, app, size):
    put(client, case, b"x" * size)
    assert app.state.cases.receiving == 0


def test_a_second_job_of_an_analysis_is_refused(client, case, opened, app):
    opened.job = running()
    answer = client.post(f"{case}/jobs", json={"task": "look"})
    assert (answer.status_code, "this analysis has a running job" in answer.json()["message"]) == (
        409,
        True,
    )
    others = [begun(client), begun(client)]
    app.state.cases[others[0].rpartition("/")[2]].job = running()
    answer = client.post(f"{others[1]}/jobs", json={"task": "look"})
    assert (answer.status_code, "2 jobs are running" in answer.json()["message"]) == (429, True)
    assert client.post(f"{others[1]}/jobs", json={"task": "remove"}).status_code == 400


def test_only_a_job_that_runs_is_cancelled(client, case, opened):
    assert client.post(f"{case}/cancel", json={}).json()["job"] is None
    called = []
    for state, requested, expected in (
        ("done", {}, []),
        ("runs", {}, ["cancel"]),
        ("runs", {"at_once": True}, ["kill"]),
    ):
        called.clear()
        opened.job = running(state)
        opened.job.cancel, opened.job.kill = (
            (lambda: called.append("cancel")),
            (lambda: called.append("kill")),
        )
        client.post(f"{case}/cancel", json=requested)
        assert called == expected
    opened.job = None


def jobs_that_end(monkeypatch, state="done", **facts):
    """Let jobs end in this state with these facts, and return what they are asked for."""
    requested = []

    async def run(job, request):
        requested.append((job.task, request))
        job.facts, job.state = facts or {"word": job.task}, state
        return state == "done"

    monkeypatch.setattr(cases.Job, "run", run)
    return requested


def test_a_job_gets_its_inputs_and_stores_its_result(client, case, opened, monkeypatch):
    put(client, case, b"1", "a.csv")
    put(client, case, b"2", "b.csv", "held_out")
    put(client, case, b"schema = 1\n", "stage.toml", "axis")
    requested = jobs_that_end(monkeypatch)
    assert (
        client.post(f"{case}/jobs", json={"task": "identify", "options": {"draws": 3}}).status_code
        == 202
    )
    parts = client.get(case).json()["parts"]
    assert {name: part["word"] for name, part in parts.items()} == {
        "identified": "identify",
        "predicted": "predict",
    }
    (first, request), (second, following) = requested
    assert (first, second) == ("identify", "predict")
    assert [(label, role) for _, label, role in request["logs"]] == [
        ("a.csv", "fit"),
        ("b.csv", "held_out"),
    ]
    expected = {
        "axis_text": "schema = 1\n",
        "axis_label": "stage.toml",
        "options": {"draws": 3},
        "size_limit": 1000,
        "results": None,
    }
    assert request.items() >= (expected | {"memory": LIMITS.job_memory}).items()
    assert (following["results"], following["options"]) == (
        str(opened.parts["identified"].folder / "results"),
        {},
    )
    json.dumps(request)
    client.post(f"{case}/jobs", json={"task": "check"})
    assert len(requested) == 3


def test_a_failing_job_stores_no_result(client, case, opened, monkeypatch):
    jobs_that_end(monkeypatch, "failed")
    client.post(f"{case}/jobs", json={"task": "look"})
    assert client.get(case).json()["parts"] == {}
    assert list(opened.folder.iterdir()) == []


def test_an_axis_that_a_job_changes_makes_other_parts_old(client, case, opened, monkeypatch):
    left(opened, "identified")
    jobs_that_end(monkeypatch, axis_text="schema = 1\nname = 'x'\n", ready=True)
    client.post(f"{case}/jobs", json={"task": "look"})
    state = client.get(case).json()
    assert (state["axis"]["text"], state["parts"]["looked"]["ready"]) == (
        "schema = 1\nname = 'x'\n",
        True,
    )
    assert {name: part["old"] for name, part in state["parts"].items()} == {
        "identified": True,
        "looked": False,
    }
    left(opened, "identified")
    client.post(f"{case}/jobs", json={"task": "look"})  # the same axis again
    assert not client.get(case).json()["parts"]["identified"]["old"]


# --- What is dropped: bytes under a label, up to limits, in folders whose names no browser chooses


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("../../../etc/passwd", "passwd"),
        ("/etc/cron.d/job", "job"),
        ("C:\\Windows\\win.ini", "win.ini"),
        ("..", "log"),
        ("", "log"),
        ("a\0b\n.csv", "a b .csv"),
        ("x::table", "x::table"),
        ("é" * 300 + ".mat", ".mat"),
    ],
)
def test_a_path_in_a_file_name_is_only_a_label(app, client, tmp_path, name, label):
    case = begun(client)
    (file,) = put(client, case, b"abc", name).json()["files"]
    assert file["label"].endswith(label)
    assert len(file["label"]) < 120
    assert not set(file["label"]) & set("/\\\0\n")
    (stored,) = next(iter(app.state.cases)).files.values()
    assert stored.place.name == "file-1"
    assert stored.place.read_bytes() == b"abc"
    assert stored.place.parent.stat().st_mode & 0o077 == 0


def test_a_file_beyond_the_limit_is_refused_without_a_trace(app, client):
    case = begun(client)
    for data in (b"0" * 1001, iter([b"0" * 100] * 11)):  # the second one does not announce its size
        answer = put(client, case, data)
        assert answer.status_code == 413
        assert "up to 1 kB" in answer.json()["message"]
    assert client.get(case).json()["files"] == []
    assert list(next(iter(app.state.cases)).folder.iterdir()) == []


def test_files_together_and_their_number_are_limited(client):
    case = begun(client)
    assert [put(client, case, b"0" * 1000).status_code for _ in range(3)] == [201, 201, 413]
    assert [put(client, case, b"0" * 10).status_code for _ in range(3)] == [201, 201, 413]
    assert put(client, case, b"0" * 501, "axis.toml", "axis").status_code == 413


def test_the_number_of_analyses_is_limited(client):
    assert [client.post("/api/cases").status_code for _ in range(4)] == [201, 201, 201, 429]


def test_an_invalid_message_is_refused(client):
    jobs = f"{begun(client)}/jobs"
    bodies = (
        b"x" * 501,
        b"[1]",
        b"{",
        b'{"task": "rm"}',
        b'{"task": "look", "options": []}',
        b"[" * 400,
    )
    assert [client.post(jobs, content=body).status_code for body in bodies] == [
        413,
        400,
        400,
        400,
        400,
        400,
    ]


def test_files_do_not_leave_by_another_name(client):
    case = begun(client)
    put(client, case, b"abc")
    for path in (
        "parts/../file-1",
        "parts/looked",
        "parts/%2e%2e",
        "parts/looked/archive",
        "parts/..%2f..%2ffile-1",
    ):
        assert client.get(f"{case}/{path}").status_code == 404
    assert client.get("/shown/..%2f..%2fetc%2fpasswd").status_code == 404


def memory():
    """Return what this process has in memory [byte]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads /proc")
@pytest.mark.parametrize("announced", [True, False])
def test_two_gigabytes_are_refused_without_memory(announced):
    two_gigabytes, piece = 2 * 10**9, b"0" * 2**20
    with served(Limits(file_size=32 * 2**20)) as server, server.client() as client:
        case = begun(client)
        head = (
            f"PUT {case}/files HTTP/1.1\r\nhost: 127.0.0.1:{server.port}\r\nx-bristle-token: {TOKEN}\r\n"
            + (f"content-length: {two_gigabytes}" if announced else "transfer-encoding: chunked")
            + "\r\n\r\n"
        )
        before, most, answer, done = memory(), 0, b"", threading.Event()
        with server.raw(head.encode()) as connection:

            def listen():
                nonlocal answer
                while piece := _received(connection):
                    answer += piece
                done.set()

            thread = threading.Thread(target=listen)
            thread.start()
            sent = 0
            try:
                while sent < two_gigabytes and not done.is_set():
                    connection.sendall(piece if announced else b"100000\r\n" + piece + b"\r\n")
                    sent += len(piece)
                    most = max(most, memory() - before)
            except OSError:
                done.wait(10)
            thread.join(10)
        assert answer.startswith(b"HTTP/1.1 413"), answer[:200]
        assert sent < 64 * 2**20
        assert most < 24 * 2**20
        assert client.get(case).json()["files"] == []


def _received(connection):
    try:
        return connection.recv(65536)
    except OSError:
        return b""
