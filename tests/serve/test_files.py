"""What is dropped: bytes under a label, up to limits, in folders whose names no browser chooses."""

import threading
from pathlib import Path

import pytest
from tests.serve.yard import TOKEN, begun, put, served

from bristle.server.limits import Limits

LIMITS = Limits(file_size=1000, total_size=2500, body_size=500, files=4, cases=3)


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
    bodies = (b"x" * 501, b"[1]", b"{", b'{"task": "rm"}', b'{"task": "look", "options": []}', b"[" * 400)
    assert [client.post(jobs, content=body).status_code for body in bodies] == [413, 400, 400, 400, 400, 400]


def test_files_do_not_leave_by_another_name(client):
    case = begun(client)
    put(client, case, b"abc")
    for path in ("parts/../file-1", "parts/looked", "parts/%2e%2e", "parts/looked/archive", "parts/..%2f..%2ffile-1"):
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
