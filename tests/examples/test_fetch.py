"""The download of a measured log: only the right file is taken, and whatever fails is told."""

import functools
import http.server
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import pytest
from tests.examples.data import measured

pytestmark = pytest.mark.slow

SCRIPT = Path(__file__).parents[2] / "examples" / "emps" / "fetch.py"
FILE = "DATA_EMPS.mat"


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture
def site(tmp_path):
    """A folder that is served, and its address."""
    folder = tmp_path / "site"
    folder.mkdir()
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder))
    )
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield folder, f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.fixture
def fetch(tmp_path):
    target = tmp_path / "target"
    target.mkdir()

    def run(url):
        done = subprocess.run(
            [sys.executable, SCRIPT, "--url", url, "--to", target],
            capture_output=True,
            text=True,
            check=False,
        )
        return done, sorted(item.name for item in target.iterdir())

    return run


@pytest.mark.parametrize("content", [{}, {FILE: b"something else"}, {"other.mat": b"other"}])
def test_an_archive_without_the_right_file_is_refused(site, fetch, content):
    folder, url = site
    with zipfile.ZipFile(folder / "EMPS.zip", "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    done, present = fetch(f"{url}/EMPS.zip")
    assert (done.returncode, present) == (2, [])
    assert "checksum differs" in done.stderr
    assert "nonlinearbenchmark.org" in done.stderr


def test_an_address_without_an_answer_is_reported(site, fetch):
    done, present = fetch(f"{site[1]}/moved.zip")
    assert (done.returncode, present) == (2, [])
    assert "the download failed" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.measured
@pytest.mark.parametrize("archived", [True, False])
def test_the_right_file_is_taken(site, fetch, archived):
    folder, url = site
    record = measured("emps", FILE).read_bytes()
    if archived:
        with zipfile.ZipFile(folder / "log", "w") as archive:
            archive.writestr(f"EMPS/{FILE}", record)
    else:
        (folder / "log").write_bytes(record)
    done, present = fetch(f"{url}/log")
    assert (done.returncode, present) == (0, [FILE]), done.stderr
