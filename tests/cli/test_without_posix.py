"""Without what only POSIX systems have everything works: no fork, no locks of files, no opened folders."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.cli.conftest import written_in
from tests.files.test_results import mark_of, write_results

from bristle.cli.options import command_text
from bristle.core.content import content_of
from bristle.files.owned import NOTE
from bristle.files.results import results_folder

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(os.name != "posix", reason="this is the other half")
PRELUDE = f"import sys; sys.path.insert(0, {str(ROOT)!r}); from tests.cli.without_posix import take_away; take_away()\n"
MAIN = PRELUDE + "from bristle.cli.main import main; sys.exit(main(sys.argv[1:]))"


def elsewhere(code: str, *arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        check=False,
        timeout=120,
        **options,
    )


@pytest.mark.slow
def test_the_main_job_gives_the_same_numbers_and_results_are_replaced(bristle, place):
    arguments = ("identify", "log.csv", "--axis", "axis.toml", "--draws", "20", "--json")
    here = bristle(*arguments).data
    for force in ((), ("--force",)):
        ended = elsewhere(MAIN, *arguments, "--out", "run", *force)
        assert ended.returncode == 0, ended.stderr
        present = json.loads(ended.stdout)
        assert present["parameters"] == here["parameters"]
    assert {"model.toml", "report.html", "summary.json"} <= written_in("run")
    refused = elsewhere(MAIN, *arguments, "--out", "run")
    assert (refused.returncode, refused.stdout) == (2, b"")
    assert not list(place.glob("bristle-*"))


REPLACE = """
from bristle.files.results import results_folder
with results_folder("run", force=True) as folder:
    for name in ("model.toml", "report.html", "summary.json"):
        folder.write(name, 3 * ("new" + chr(10)))
    {meanwhile}
"""
KILLED = """
from bristle.files import results
renamed = results.rename_new
def once(old, new):
    renamed(old, new)
    import os
    os._exit(9)
results.rename_new = once
"""


def test_results_are_replaced_whole_and_restored_after_a_kill(tmp_path):
    out = tmp_path / "run"
    write_results(out, "old")
    assert (
        elsewhere(PRELUDE + KILLED + REPLACE.format(meanwhile="pass"), cwd=tmp_path).returncode == 9
    )
    # Killed between two renames: no system without an exchange of names can do better.
    assert not out.exists()
    refused = elsewhere(
        PRELUDE + REPLACE.format(meanwhile="pass").replace(", force=True", ""), cwd=tmp_path
    )
    assert b"exists already" in refused.stderr
    assert mark_of(out) == "old"
    ended = elsewhere(PRELUDE + REPLACE.format(meanwhile="pass"), cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert mark_of(out) == "new"
    assert [item.name for item in tmp_path.iterdir()] == ["run"]


def test_the_later_of_two_simultaneous_commands_is_refused(tmp_path):
    with results_folder(tmp_path / "run") as folder:
        folder.write("summary.json", "{}")
        ended = elsewhere(PRELUDE + REPLACE.format(meanwhile="pass"), cwd=tmp_path)
        assert b"another process" in ended.stderr


def test_a_link_is_not_followed_even_without_nofollow(tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "model.toml").write_text("mine")
    meanwhile = f"folder.path.rename('elsewhere'); folder.path.symlink_to({str(mine)!r})"
    ended = elsewhere(PRELUDE + REPLACE.format(meanwhile=meanwhile), cwd=tmp_path)
    assert ended.returncode == 1
    assert (mine / "model.toml").read_text() == "mine"
    assert not (mine / NOTE).exists()


def test_a_pipe_is_read_without_poll(tmp_path):
    code = PRELUDE + (
        "from bristle.core.content import content_of\nassert content_of('-').data == b'a log', content_of('-').data\n"
    )
    assert elsewhere(code, input=b"a log").returncode == 0
    assert content_of(b"a log").data == b"a log"


@pytest.mark.parametrize(
    ("argument", "told"),
    [
        (r"C:\Users\anna\axis 1.csv", "axis 1.csv"),
        (r"\\host\share\log.h5::a", "log.h5::a"),
        ("../x/axis.toml", "axis.toml"),
        (r"--axis=D:\x\axis.toml", "--axis=axis.toml"),
        (r"coulomb,C:\x\own.py", "coulomb,own.py"),
    ],
)
def test_a_windows_command_line_is_stored_without_folders(argument, told):
    assert command_text([argument], separators="\\/") in (f"bristle {told}", f"bristle '{told}'")
