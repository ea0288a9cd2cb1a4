"""A folder of results appears whole or not at all."""

import errno
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from bristle.core import InputError
from bristle.files import results
from bristle.files.results import SUMMARY, results_folder

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX")

NAMES = ("model.toml", "report.html", SUMMARY)
WRITER = """
import sys
from pathlib import Path
from bristle.files.results import results_folder

out, mark, size = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
with results_folder(out, force=True) as folder:
    print("writing", flush=True)
    for name in {names!r}:
        (folder / name).write_text((mark + chr(10)) * size)
print("done", flush=True)
"""


def fill(folder: Path, mark: str, size: int = 3) -> None:
    for name in NAMES:
        (folder / name).write_text((mark + "\n") * size)


def mark_of(out: Path, size: int = 3) -> str:
    """Return what the three files agree on; fails where they do not, or where one is cut short."""
    texts = {(out / name).read_text() for name in NAMES}
    assert len(texts) == 1
    lines = texts.pop().splitlines()
    assert len(lines) == size
    assert len(set(lines)) == 1
    return lines[0]


@pytest.fixture
def out(tmp_path):
    with results_folder(tmp_path / "run") as folder:
        fill(folder, "old")
    return tmp_path / "run"


def test_nothing_is_seen_before_the_end(tmp_path):
    out = tmp_path / "run"
    with results_folder(out) as folder:
        fill(folder, "new")
        assert not out.exists()
    assert mark_of(out) == "new"
    assert [one.name for one in tmp_path.iterdir()] == ["run"]


def test_existing_results_need_force_and_are_replaced_whole(out):
    with pytest.raises(InputError, match="--force"), results_folder(out):
        pytest.fail("the work must not begin")
    assert mark_of(out) == "old"
    with results_folder(out, force=True) as folder:
        fill(folder, "new")
    assert mark_of(out) == "new"


def test_files_of_a_person_are_never_removed(out):
    (out / "notes.txt").write_text("mine")
    with (
        pytest.raises(InputError, match=r"besides the results: notes\.txt.*Move them"),
        results_folder(out, force=True),
    ):
        pytest.fail("the work must not begin")
    assert (out / "notes.txt").read_text() == "mine"


def test_files_that_a_person_adds_meanwhile_are_kept(out):
    def replace():
        with results_folder(out, force=True) as folder:
            fill(folder, "new")
            (out / "notes.txt").write_text("mine, written meanwhile")

    with pytest.raises(InputError, match=r"notes\.txt"):
        replace()
    assert mark_of(out) == "old"
    assert (out / "notes.txt").read_text() == "mine, written meanwhile"
    assert [one.name for one in out.parent.iterdir()] == ["run"]


def test_what_belongs_to_the_results_is_replaced_with_them(out):
    (out / "model.toml").write_text('[friction]\nfile = "own.py"\n')
    (out / SUMMARY).write_text('{"simulated": true}')
    for name in ("own.py", "axis.toml", "log.csv"):
        (out / name).write_text("ours")
    with results_folder(out, force=True) as folder:
        fill(folder, "new")
    assert mark_of(out) == "new"
    assert sorted(one.name for one in out.iterdir()) == sorted(NAMES)


def test_force_never_replaces_a_folder_of_something_else(tmp_path):
    (tmp_path / "thesis.tex").write_text("years")
    with pytest.raises(InputError, match="something else"), results_folder(tmp_path, force=True):
        pytest.fail("the work must not begin")
    assert (tmp_path / "thesis.tex").read_text() == "years"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda place: (place / "run").write_text(""), "is a file"),
        (lambda place: (place / "run.partial").write_text(""), "cannot be written"),
    ],
)
def test_what_stands_in_the_way_is_named(tmp_path, make, words):
    make(tmp_path)
    with pytest.raises(InputError, match=words) as caught, results_folder(tmp_path / "run", force=True):
        pytest.fail("the work must not begin")
    assert caught.value.mend


def test_a_parent_that_is_missing_or_closed_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="does not exist"), results_folder(tmp_path / "no" / "run"):
        pytest.fail("the work must not begin")
    monkeypatch.setattr(results.os, "access", lambda *_: False)  # the tests may run as root, who may everything
    with pytest.raises(InputError, match="permission"), results_folder(tmp_path / "run"):
        pytest.fail("the work must not begin")


@pytest.mark.parametrize("error", [RuntimeError("a bug"), KeyboardInterrupt(), InputError("bad")])
def test_an_error_in_the_work_leaves_what_was(out, error):
    def work():
        with results_folder(out, force=True) as folder:
            (folder / "model.toml").write_text("half")
            raise error

    with pytest.raises(type(error)):
        work()
    assert mark_of(out) == "old"
    assert [one.name for one in out.parent.iterdir()] == ["run"]


def count_calls(monkeypatch, fail_at: int) -> list[str]:
    """Make call number `fail_at` to the operating system fail; return the names of the calls made."""
    made: list[str] = []

    def counted(name):
        call = getattr(os, name)

        def wrapper(*args, **kwargs):
            made.append(name)
            if len(made) == fail_at:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return call(*args, **kwargs)

        return wrapper

    for name in ("mkdir", "fsync", "rename"):
        monkeypatch.setattr(results.os, name, counted(name))
    return made


@pytest.mark.parametrize("fail_at", range(1, 9))
def test_a_full_disk_at_any_step_leaves_old_or_new(out, monkeypatch, fail_at):
    with monkeypatch.context() as patch:
        made = count_calls(patch, fail_at)
        try:
            with results_folder(out, force=True) as folder:
                fill(folder, "new")
            ended = "whole"
        except InputError as error:
            ended = str(error)
    assert (ended == "whole") == (len(made) < fail_at)
    assert ended == "whole" or "no space left" in ended
    assert mark_of(out) in (("new",) if ended == "whole" else ("old", "new"))
    assert [one.name for one in out.parent.iterdir()] == ["run"]


def test_the_steps_above_cover_every_call(out, monkeypatch):
    with monkeypatch.context() as patch:
        made = count_calls(patch, fail_at=10**6)
        with results_folder(out, force=True) as folder:
            fill(folder, "new")
    assert len(made) == 8
    assert made.count("fsync") == len(NAMES) + 2
    assert made.count("rename") == 2


def writer(out: Path, mark: str, size: int, **options) -> subprocess.Popen:
    command = [sys.executable, "-c", WRITER.format(names=NAMES), str(out), mark, str(size)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def run_writer(out: Path, mark: str, size: int) -> None:
    process = writer(out, mark, size)
    process.communicate()
    assert process.returncode == 0


def test_killed_at_random_moments(tmp_path):
    out, size, chance = tmp_path / "run", 200_000, random.Random(20)
    began = time.perf_counter()
    run_writer(out, "0", size)
    whole = time.perf_counter() - began
    previous = "0"
    for trial in range(1, 21):
        process = writer(out, str(trial), size)
        assert process.stdout is not None
        process.stdout.readline()  # from here on it writes; the start of the interpreter is not worth killing
        time.sleep(chance.uniform(0.0, whole))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        # A kill between the two renames leaves the old results aside; the next run brings them back.
        if not out.exists():
            with pytest.raises(InputError, match="exists already"), results_folder(out):
                pytest.fail("the work must not begin")
        found = mark_of(out, size)
        assert found in (previous, str(trial))
        previous = found
    run_writer(out, "last", size)
    assert mark_of(out, size) == "last"
    assert [one.name for one in tmp_path.iterdir()] == ["run"]


@pytest.mark.parametrize("step", range(1, 9))
def test_killed_at_each_step(out, step):
    code = f"""
import os, sys
from bristle.files import results
made = 0
def counted(call):
    def wrapper(*args, **kwargs):
        global made
        made += 1
        if made == {step}:
            os._exit(9)
        return call(*args, **kwargs)
    return wrapper
for name in ("mkdir", "fsync", "rename"):
    setattr(results.os, name, counted(getattr(os, name)))
with results.results_folder(sys.argv[1], force=True) as folder:
    for name in {NAMES!r}:
        with open(folder / name, "w") as file:
            file.write("new\\n" * 3)
"""
    ended = subprocess.run([sys.executable, "-c", code, str(out)], check=False).returncode
    assert ended in (0, 9)
    with pytest.raises(InputError, match="exists already"), results_folder(out):
        pytest.fail("the work must not begin")
    assert mark_of(out) in ("old", "new")


def test_a_limit_on_the_size_of_files(out):
    process = writer(
        out, "new", 100_000, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))
    )
    _, errors = process.communicate()
    assert process.returncode != 0
    assert "InputError" in errors
    assert "file too large" in errors
    assert mark_of(out) == "old"
    assert [one.name for one in out.parent.iterdir()] == ["run"]


def test_two_at_once_one_is_refused_and_a_dead_one_is_no_obstacle(out):
    with results_folder(out, force=True) as folder:
        fill(folder, "first")
        process = writer(out, "second", 3)
        _, errors = process.communicate()
        assert process.returncode != 0
        assert "another process" in errors
    assert mark_of(out) == "first"
    stale = out.with_name("run.partial")
    (stale / "deep").mkdir(parents=True)
    (stale / "deep" / "model.toml").write_text("half")
    with results_folder(out, force=True) as folder:
        assert not any(folder.iterdir())
        fill(folder, "third")
    assert mark_of(out) == "third"


def test_many_at_once_never_mix(tmp_path):
    out, ended, refused = tmp_path / "run", [], []

    def attempt(mark: str) -> None:
        try:
            with results_folder(out, force=True) as folder:
                fill(folder, mark)
            ended.append(mark)
        except InputError as error:
            refused.append(str(error))

    for round_ in range(20):
        threads = [threading.Thread(target=attempt, args=(f"{round_}-{one}",)) for one in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert mark_of(out) in ended
    assert all("another process" in words for words in refused)
    assert [one.name for one in tmp_path.iterdir()] == ["run"]


def test_a_folder_without_a_summary_is_a_bug(tmp_path):
    with pytest.raises(RuntimeError, match=SUMMARY), results_folder(tmp_path / "run"):
        pass
    assert not any(tmp_path.iterdir())
