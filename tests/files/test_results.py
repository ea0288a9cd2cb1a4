"""A folder of results appears whole or not at all, and nothing of a person's is ever touched."""

import errno
import json
import os
import re
import shutil
import stat
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import pytest

from bristle.core import InputError
from bristle.core.content import content_of
from bristle.core.errors import InputWarning
from bristle.files import folder as folders, owned, results
from bristle.files.growing import growing_folder
from bristle.files.owned import NOTE, Folder, line_of, note_in
from bristle.files.results import SUMMARY, results_folder

resource = pytest.importorskip("resource", reason="signals and limits of POSIX")

NAMES = ("model.toml", "report.html", SUMMARY)
UNFINISHED = f"bristle-{'0' * 32}.partial"
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
STEPS = ("mkdir", "write", "fsync", "unlink", "rmdir")


def fill(folder, mark: str, size: int = 3) -> None:
    for name in NAMES:
        (folder / name).write_text((mark + "\n") * size)


def write_results(
    out: Path, mark: str = "new", force: bool = True, during=lambda folder: None
) -> None:
    """Write the results, and let something happen while they are written."""
    with results_folder(out, force=force) as folder:
        fill(folder, mark)
        during(folder)


def mark_of(out: Path, size: int = 3) -> str:
    """Return what the three files agree on; fails where they do not, or where one is cut short."""
    texts = {(out / name).read_text() for name in NAMES}
    assert len(texts) == 1
    lines = texts.pop().splitlines()
    assert (len(lines), len(set(lines))) == (size, 1)
    return lines[0]


def left_in(place: Path) -> tuple[str, list[str]]:
    """Return what the results say, and all that lies beside them."""
    return mark_of(place / "run"), [item.name for item in place.iterdir()]


def state_of(place: Path) -> dict[str, object]:
    """Return all that lies in a folder: what it is, since when, and what it holds."""
    result = {}
    for item in sorted(place.rglob("*")):
        info = item.lstat()
        fixed = (
            item.read_bytes()
            if stat.S_ISREG(info.st_mode)
            else os.readlink(item)
            if item.is_symlink()
            else None
        )
        result[str(item.relative_to(place))] = (stat.S_IFMT(info.st_mode), info.st_ino, fixed)
    return result


def refused(out: Path | str, words: str = ".", force: bool = True) -> InputError:
    """Ask for a folder that must be refused before any work, and change nothing."""
    with pytest.raises(InputError, match=words) as caught, results_folder(out, force=force):
        pytest.fail("the work must not begin")
    assert caught.value.mend
    return caught.value


@pytest.fixture
def out(tmp_path):
    write_results(tmp_path / "run", "old")
    return tmp_path / "run"


def test_results_appear_only_when_complete(tmp_path):
    write_results(
        tmp_path / "run",
        during=lambda _: pytest.fail("too early") if (tmp_path / "run").exists() else None,
    )
    assert left_in(tmp_path) == ("new", ["run"])
    assert sorted(item.name for item in (tmp_path / "run").iterdir()) == sorted((*NAMES, NOTE))


@pytest.mark.parametrize("removed", [(), ("report.html",)])
def test_existing_results_need_force_and_are_replaced_whole(out, removed):
    refused(out, "--force", force=False)
    assert mark_of(out) == "old"
    for name in removed:
        (out / name).unlink()
    write_results(out)
    assert left_in(out.parent) == ("new", ["run"])


def test_results_are_known_by_their_note_however_they_are_called(out):
    moved, copied = out.with_name("kept"), out.with_name("copy")
    shutil.copytree(out, copied)
    out.rename(moved)
    for place in (moved, copied):
        write_results(place)
        assert mark_of(place) == "new"
        assert stat.S_ISREG((place / NOTE).lstat().st_mode)


def test_the_note_has_no_data_of_the_machine(out):
    text = (out / NOTE).read_text()
    assert [word for word in (str(out.parent), os.uname().nodename) if word in text] == []
    assert {json.loads(line).get("file") for line in text.splitlines()[1:]} == set(NAMES)


def of_many_runs(out: Path) -> None:
    """Let the folder be one of a study."""
    shutil.rmtree(out)
    with growing_folder(out, "study") as (grown, _):
        grown.write("summary.json", "{}")


def stranger(name: str, make):
    return pytest.param(make, id=name)


@pytest.mark.parametrize(
    "make",
    [
        stranger("a backup that looks like ours", lambda p: (p / "run.old-20261120").mkdir()),
        stranger("a folder of that name in use before", lambda p: (p / "run.partial").mkdir()),
        stranger("a file", lambda p: (p / "run.partial").write_text("mine")),
        stranger("a link to a folder", lambda p: (p / "run.partial").symlink_to(p / "thesis")),
        stranger("a folder named as ours are", lambda p: (p / UNFINISHED).mkdir()),
        stranger("a link named as ours are", lambda p: (p / UNFINISHED).symlink_to(p / "thesis")),
        stranger("a file named as ours are", lambda p: (p / UNFINISHED).write_text("mine")),
    ],
)
def test_user_files_next_to_the_results_are_unchanged(tmp_path, make):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "years.tex").write_text("years")
    make(tmp_path)
    for item in tmp_path.iterdir():
        if item.is_dir() and not item.is_symlink() and item.name != "thesis":
            (item / "mine.txt").write_text("mine")
    before = state_of(tmp_path)
    write_results(tmp_path / "run", "old")
    write_results(tmp_path / "run", "new")
    refused(tmp_path / "run", force=False)
    assert mark_of(tmp_path / "run") == "new"
    assert {
        name: item for name, item in state_of(tmp_path).items() if name.partition("/")[0] != "run"
    } == before


NEW = '{"bristle": "0.1.0", "folder": "00", "target": "run", "began": "1"}\n'


def with_note(text: str | bytes):
    """Return what turns a folder of a person's own into one with a note, as an attacker would write it."""

    def make(place: Path) -> None:
        (place / NOTE).write_bytes(text if isinstance(text, bytes) else text.encode())

    return make


@pytest.mark.fast_cases(15)
@pytest.mark.parametrize(
    "make",
    [
        stranger("no note", lambda place: None),
        stranger("an empty note", with_note("")),
        stranger("a note of anything", with_note("bristle was here\n")),
        stranger("a note that names nothing", with_note(NEW)),
        stranger(
            "a note that names files elsewhere",
            with_note(NEW + '{"file": "../thesis/years.tex"}\n'),
        ),
        stranger("a note with a full path", with_note(NEW + '{"file": "/etc/passwd"}\n')),
        stranger("a note of lists", with_note("[" * 9000 + "\n")),
        stranger("a note of other types", with_note(NEW + '{"file": 3}\n')),
        stranger("a note without end", with_note(NEW.encode() + b"\n" * 20_000)),
        stranger("a note of no text", with_note(bytes(range(256)))),
        stranger("a note of a broken number", with_note(NEW.replace('"1"', '"-1e9"'))),
        stranger(
            "a note that claims all as half written", with_note(NEW + '{"file": "mine.txt"}\n')
        ),
        stranger(
            "a note that is a link", lambda place: (place / NOTE).symlink_to(place.parent / "note")
        ),
        stranger("a note that is a pipe", lambda place: os.mkfifo(place / NOTE)),
        stranger("a note that is a folder", lambda place: (place / NOTE).mkdir()),
    ],
)
def test_a_folder_of_a_persons_own_is_never_replaced(tmp_path, make):
    place = tmp_path / "run"
    place.mkdir()
    (place / "mine.txt").write_text("mine")
    (tmp_path / "note").write_text(NEW)
    make(place)
    unfinished = tmp_path / UNFINISHED
    shutil.copytree(place, unfinished, symlinks=True, copy_function=copied)
    before = state_of(tmp_path)
    refused(place)
    assert state_of(tmp_path) == before
    write_results(tmp_path / "other")
    left = {
        name: item for name, item in state_of(tmp_path).items() if name.partition("/")[0] != "other"
    }
    if not ((place / NOTE).is_file() and b'"mine.txt"' in (place / NOTE).read_bytes()):
        # What such a note claims as half written, in a folder named as ours, nobody can tell.
        assert left == before
    assert (place / "mine.txt").read_text() == "mine"


def copied(source: str, target: str) -> str:
    """Copy a file, or make such a pipe again."""
    if stat.S_ISFIFO(os.stat(source).st_mode):
        os.mkfifo(target)
        return target
    return shutil.copyfile(source, target)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda out: (out / "notes.txt").write_text("mine"),
            r"besides the results: notes\.txt\. Name another folder. Or move these files to another place",
        ),
        (lambda out: (out / "plots").mkdir(), "besides the results: plots"),
        (
            lambda out: (out / "model.toml").write_text("mended by hand"),
            r"were changed: model\.toml",
        ),
        (
            lambda out: (out / "model.toml").write_text((out / "model.toml").read_text() + " "),
            "were changed",
        ),
        (
            lambda out: (
                (out / "report.html").unlink(),
                (out / "report.html").symlink_to(out.parent / "mine"),
            ),
            r"were changed: report\.html",
        ),
        (lambda out: ((out / SUMMARY).unlink(), (out / SUMMARY).mkdir()), "were changed: summary"),
        (lambda out: (out / NOTE).unlink(), r"without the file.*0\.1.*by hand"),
        (
            lambda out: (out / NOTE).write_text((out / NOTE).read_text() + "# my remark\n"),
            f"contains files that were changed: {NOTE}",
        ),
        (of_many_runs, "contains a study of many runs"),
        (lambda out: out.chmod(0o555), "write-protected"),
    ],
)
def test_added_changed_and_other_files_are_never_replaced(out, change, words):
    (out.parent / "mine").write_text("mine")
    change(out)
    before = state_of(out.parent)
    refused(out, words)
    out.chmod(0o755)
    assert state_of(out.parent) == before


@pytest.mark.parametrize("exchanged", [True, False])
@pytest.mark.parametrize(
    "change", [lambda p: (p / "notes.txt").write_text("mine"), lambda p: p.chmod(0o500)]
)
def test_changes_during_the_run_are_kept(out, monkeypatch, exchanged, change):
    if not exchanged:
        monkeypatch.setattr(results, "exchange", lambda *_: False)
    with pytest.raises(InputError):
        write_results(out, during=lambda _: change(out))
    assert left_in(out.parent) == ("old", ["run"])


@pytest.mark.parametrize("exchanged", [True, False])
def test_files_added_at_the_last_moment_are_kept_and_reported(out, monkeypatch, exchanged):
    renamed = results._replace

    def late(new, wanted):
        (wanted / "notes.txt").write_text("mine")
        (wanted / "model.toml").write_text("mine too")
        return renamed(new, wanted)

    monkeypatch.setattr(results, "_replace", late)
    if not exchanged:
        monkeypatch.setattr(results, "exchange", lambda *_: False)
    with pytest.warns(InputWarning, match="could not be removed") as message:
        write_results(out)
    place = Path(str(message[0].message).partition(":")[0])
    assert mark_of(out) == "new"
    assert [(place / name).read_text() for name in ("notes.txt", "model.toml")] == [
        "mine",
        "mine too",
    ]


@pytest.mark.parametrize(
    "appear",
    [
        lambda out: out.write_text("mine"),
        lambda out: (out.mkdir(), (out / "mine").write_text("mine")),
        lambda out: out.symlink_to(out.parent),
        lambda out: out.symlink_to("nowhere"),
        os.mkfifo,
    ],
)
def test_a_folder_that_appears_during_the_run_is_kept(tmp_path, appear):
    before = {}

    def during(_):
        appear(tmp_path / "run")
        before.update(
            {name: item for name, item in state_of(tmp_path).items() if name.startswith("run")}
        )

    with pytest.raises(InputError):
        write_results(tmp_path / "run", during=during)
    assert state_of(tmp_path) == before


def test_a_folder_that_replaces_the_temporary_folder_is_kept(tmp_path):
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "model.toml").write_text("mine")

    def exchanged(folder):
        folder.path.rename(tmp_path / "elsewhere")
        folder.path.symlink_to(mine)

    with pytest.raises(InputError), pytest.warns(InputWarning, match="bristle keeps"):
        write_results(tmp_path / "run", during=exchanged)
    assert ((mine / "model.toml").read_text(), (tmp_path / "run").exists()) == ("mine", False)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("/", "root of a file system"),
        (".", "other files"),
        ("..", "other files|besides|permission"),
        ("./run/..", "other files"),
        ("/dev/null", "is a file"),
        ("/proc", "other files|mount|permission"),
        ("a\0b", "NUL"),
        ("no/run", "does not exist"),
        ("thesis.tex/run", "does not exist"),
        ("x" * 300, "too long"),
        ("/dev/full/x", "does not exist"),
    ],
)
def test_a_place_that_cannot_be_is_refused(tmp_path, monkeypatch, place, words):
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "thesis.tex").write_text("years")
    (tmp_path / "inside" / "run").mkdir()
    monkeypatch.chdir(tmp_path / "inside")
    before = state_of(tmp_path)
    refused(place, words)
    assert state_of(tmp_path) == before


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda place: (place / "run").write_text(""), "is a file"),
        (lambda place: (place / "run").mkdir(), "did not make it"),
        (lambda place: (place / "run").symlink_to(place), "contains other files than results"),
        # By Python
        (
            lambda place: (place / "run").symlink_to("run"),
            "cannot be written|loop|is a link to run",
        ),
        (lambda place: os.mkfifo(place / "run"), "is a file"),
    ],
)
def test_obstacles_are_named(tmp_path, make, words):
    make(tmp_path)
    before = state_of(tmp_path)
    refused(tmp_path / "run", words)
    assert state_of(tmp_path) == before


@pytest.mark.parametrize(("named", "place"), [("link", "disk"), ("link/run", "disk/run")])
def test_a_link_to_the_results_or_above_them_is_followed(tmp_path, named, place):
    (tmp_path / place).parent.mkdir(exist_ok=True)
    (tmp_path / "link").symlink_to(tmp_path / "disk")
    for mark in ("new", "again"):
        write_results(tmp_path / named, mark)
        assert mark_of(tmp_path / place) == mark
    assert (tmp_path / "link").is_symlink()


@pytest.mark.parametrize(
    ("name", "patched", "answer", "words"),
    [
        # The tests may run as root, who may everything.
        ("other", (os, "access"), lambda *_: False, "permission"),
        # Mounting takes rights that tests do not have.
        ("run", (Path, "is_mount"), lambda _: True, "mount point"),
        ("other", (os, "write"), lambda *_: full(), "no space left"),
    ],
)
def test_a_place_without_permission_or_room_is_refused_before_any_work(
    out, monkeypatch, name, patched, answer, words
):
    before = state_of(out.parent)
    monkeypatch.setattr(*patched, answer)
    refused(out.with_name(name), words)
    assert state_of(out.parent) == before


def failing(error):
    """Return what ends the work by an error."""

    def during(_):
        raise error

    return during


@pytest.mark.parametrize(
    "error", [RuntimeError("a bug"), KeyboardInterrupt(), InputError("bad"), SystemExit(1)]
)
def test_an_error_in_the_work_keeps_the_old_results(out, error):
    with pytest.raises(type(error)):
        write_results(out, during=failing(error))
    assert left_in(out.parent) == ("old", ["run"])


def test_a_process_that_will_be_killed_removes_its_unfinished_results(out):
    def during(_):
        results.remove_unfinished()
        assert left_in(out.parent) == ("old", ["run"])
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_results(out, during=during)


def test_whoever_ends_a_process_waits_until_the_other_thread_has_removed(out, monkeypatch):
    removing, remove = threading.Event(), results.owned.remove_own

    def slow(*arguments, **options):
        removing.set()
        time.sleep(0.3)
        return remove(*arguments, **options)

    monkeypatch.setattr(results.owned, "remove_own", slow)

    def work():
        with pytest.raises(KeyboardInterrupt):
            write_results(out, during=failing(KeyboardInterrupt()))

    worker = threading.Thread(target=work)
    worker.start()
    assert removing.wait(5.0)
    results.remove_unfinished()
    assert [item.name for item in out.parent.iterdir()] == ["run"]
    worker.join()


def counted(monkeypatch, at: int, act, exchanged: bool = True) -> list[str]:
    """Let something happen at call number `at` to the operating system; return the names of the calls made."""
    made: list[str] = []

    def watched(name, call):
        def wrapper(*args, **kwargs):
            made.append(name)
            if len(made) == at:
                act()
            return call(*args, **kwargs)

        return wrapper

    for name in STEPS:
        monkeypatch.setattr(os, name, watched(name, getattr(os, name)))
    monkeypatch.setattr(folders, "_rename", watched("rename", folders._rename))
    if not exchanged:
        monkeypatch.setattr(results, "exchange", lambda *_: False)
    return made


def long_ago(place: Path) -> None:
    for item in place.iterdir():
        os.utime(item, (1e9, 1e9))


def full() -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def how_it_ended(out: Path) -> str:
    try:
        write_results(out)
    except InputError as error:
        return str(error)
    return "whole"


@pytest.mark.parametrize("exchanged", [True, False])
def test_a_full_disk_at_any_step_leaves_old_or_new(tmp_path, exchanged):
    at, steps = 0, 100
    while at < steps:
        at += 1
        place = tmp_path / str(at)
        place.mkdir()
        write_results(place / "run", "old")
        with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings(record=True) as message:
            warnings.simplefilter("always")
            made = counted(patch, at, full, exchanged)
            ended = how_it_ended(place / "run")
        steps = len(made) if ended == "whole" and at > 20 else steps
        assert ended == "whole" or "no space left" in ended
        assert mark_of(place / "run") in (("new",) if ended == "whole" else ("old", "new"))
        left = [item.name for item in place.iterdir()]
        assert left == ["run"] or message or ended != "whole", made[at - 1]
        # What could not be removed then is removed by the next that can.
        long_ago(place)
        write_results(place / "run", "last")
        assert left_in(place) == ("last", ["run"]), made[at - 1]
    assert {"mkdir", "write", "fsync", "rename", "unlink", "rmdir"} <= set(made)


KILLED = """
import os, sys
from pathlib import Path
import pytest
sys.path.insert(0, {tests!r})
from tests.files.test_results import counted, write_results
with pytest.MonkeyPatch.context() as patch:
    counted(patch, int(sys.argv[2]), lambda: os._exit(9), sys.argv[3] == "exchanged")
    write_results(Path(sys.argv[1]), "new")
"""


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("way", ["exchanged", "renamed"])
@pytest.mark.parametrize("step", range(1, 26))
def test_killed_at_each_step(out, step, way):
    code = KILLED.format(tests=str(Path(__file__).parents[2]))
    ended = subprocess.run(
        [sys.executable, "-c", code, str(out), str(step), way], check=False
    ).returncode
    assert ended in (0, 9)
    if way == "exchanged":
        assert mark_of(out) in ("old", "new")
    # In the other way, this gives the old results their name back.
    refused(out, "exists already", force=False)
    assert mark_of(out) in ("old", "new")
    long_ago(out.parent)
    write_results(out, "last")
    assert left_in(out.parent) == ("last", ["run"])


def writer(out: Path, mark: str, size: int, **options) -> subprocess.Popen:
    command = [sys.executable, "-c", WRITER.format(names=NAMES), str(out), mark, str(size)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options
    )


def test_a_limit_on_the_size_of_files(out):
    process = writer(
        out,
        "new",
        100_000,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000)),
    )
    _, errors = process.communicate()
    assert process.returncode != 0
    assert re.search("InputError.*file too large", errors)
    assert left_in(out.parent) == ("old", ["run"])


def test_the_later_of_two_simultaneous_writers_is_refused(out):
    def during(_):
        process = writer(out, "second", 3)
        _, errors = process.communicate()
        assert process.returncode != 0
        assert "another process" in errors
        # Clears what dead processes left, not what a living one writes.
        write_results(out.with_name("another"))

    write_results(out, "first", during=during)
    assert mark_of(out) == "first"


def test_the_next_success_removes_the_remains_of_a_killed_process(out):
    process = writer(out, "half", 3_000_000)
    assert process.stdout is not None
    process.stdout.readline()
    process.kill()
    process.communicate()
    (left,) = (item for item in out.parent.iterdir() if item.suffix == ".partial")
    (left / "notes.txt").write_text("mine")
    before = state_of(out.parent)
    refused(out, force=False)
    with pytest.raises(InputError, match="bad"):
        write_results(out, during=failing(InputError("bad")))
    assert state_of(out.parent) == before
    write_results(out.with_name("another"))
    assert [item.name for item in left.iterdir() if item.name != NOTE] == ["notes.txt"]
    (left / "notes.txt").unlink()
    write_results(out)
    assert sorted(item.name for item in out.parent.iterdir()) == ["another", "run"]


@pytest.mark.filterwarnings("error")
def test_results_are_removed_even_at_the_limit_of_open_files(tmp_path, monkeypatch):
    def removed(path, **options):
        # The note of these results is the file too many.
        return not any(item._note is not None for item in opened) and remove(path, **options)

    opened, remove = [], owned.remove_own
    monkeypatch.setattr(results.owned, "remove_own", removed)

    def during(folder):
        opened.append(folder)
        raise InputError("no more files")

    with pytest.raises(InputError, match="no more files"):
        write_results(tmp_path / "run", during=during)
    assert not list(tmp_path.iterdir())


def test_results_do_not_replace_their_own_inputs(out):
    for named in (
        out / "model.toml",
        f"{out / 'model.toml'}::table",
        content_of(out / "model.toml"),
    ):
        with pytest.raises(
            InputError, match=r"contains input files of this command: model\.toml\. Name another"
        ):
            results_folder(out, force=True, reads=[None, "a\0b", named]).__enter__()

    with pytest.raises(InputError, match=r"contains input files of this command: summary\.json"):
        write_results(out, during=lambda _: content_of(out / SUMMARY))  # named by another file, say
    assert mark_of(out) == "old"
    write_results(out)
    assert mark_of(out) == "new"


def test_a_folder_that_another_has_just_made_is_left_to_it_until_long_after(out):
    begun = out.with_name(UNFINISHED)
    begun.mkdir()
    write_results(out)
    assert begun.is_dir()
    long_ago(out.parent)
    write_results(out)
    assert not begun.exists()


@pytest.mark.parametrize(
    ("suffix", "target", "own", "restored"),
    [
        (".replaced", "run", True, True),
        (".partial", "run", True, False),
        (".replaced", "other", True, False),
        (".replaced", "run", False, False),
    ],
)
def test_only_complete_results_of_the_same_user_are_restored(
    tmp_path, monkeypatch, suffix, target, own, restored
):
    out = tmp_path / "run"
    left = results._begin(tmp_path / target)
    fill(left, "old")
    left.sync()
    aside = left.path.with_suffix(suffix)
    left.path.rename(aside)
    left.close()
    if not own:
        monkeypatch.setattr(results.os, "getuid", lambda: os.stat(aside).st_uid + 1)
    if restored:
        refused(out, "exists already", force=False)
    else:
        write_results(out, force=False, during=lambda _: mark_of(aside))
    assert mark_of(out) == ("old" if restored else "new")
    results._open.discard(left)


def test_remains_of_another_user_are_not_removed(out, monkeypatch):
    with Folder(out) as folder:
        left = out.with_name(f"bristle-{note_in(folder).token}.partial")
    shutil.copytree(out, left)
    monkeypatch.setattr(results.os, "getuid", lambda: 12345)
    write_results(out)
    assert left.exists()
    monkeypatch.undo()
    write_results(out)
    assert not left.exists()


@pytest.mark.parametrize("suffix", [".partial", ".replaced"])
def test_a_folder_that_a_person_named_as_ours_are_is_left_alone(out, suffix):
    left = out.with_name(UNFINISHED).with_suffix(suffix)
    shutil.copytree(out, left)  # a copy: its note has the token of another folder
    before = {path.name: path.read_bytes() for path in left.iterdir()}
    long_ago(out.parent)
    write_results(out)
    shutil.rmtree(out)
    write_results(out, "again")
    assert mark_of(out) == "again"
    assert {path.name: path.read_bytes() for path in left.iterdir()} == before


def test_results_that_were_put_aside_by_a_killed_process_are_known_by_their_note(out, monkeypatch):
    put = []
    monkeypatch.setattr(results, "exchange", lambda first, second: False)
    monkeypatch.setattr(
        results, "rename_new", lambda old, new: put.append((old, new)) or os.rename(old, new)
    )
    write_results(out)
    # The old results aside, the new ones in their place.
    assert [new.suffix for _, new in put] == [".replaced", ""]
    with (out / NOTE).open("a") as note:
        note.write(line_of({"aside": "a" * 32}))
    # And a process that ended between both names.
    out.rename(out.with_name(f"bristle-{'a' * 32}.replaced"))
    refused(out, "exists already", force=False)
    assert mark_of(out) == "new"


def test_many_at_once_never_mix(tmp_path):
    out, ended, refused = tmp_path / "run", [], []

    def attempt(mark: str) -> None:
        try:
            write_results(out, mark)
            ended.append(mark)
        except InputError as error:
            refused.append(str(error))

    for round_ in range(8):
        threads = [
            threading.Thread(target=attempt, args=(f"{round_}-{item}",)) for item in range(6)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        mark, names = left_in(tmp_path)
        assert mark in ended
        assert names == ["run"]
    assert all(
        re.search("another process|cannot be written|were changed|exists", words)
        for words in refused
    )


def test_the_concurrent_removal_of_old_results_is_awaited(out, monkeypatch):
    both = []

    def beside(path):
        def end():
            time.sleep(0.01)
            path.rmdir()

        if both:
            return results_removed(path)
        for item in sorted(path.rglob("*"), reverse=True):
            item.rmdir() if item.is_dir() else item.unlink()
        both.append(threading.Thread(target=end))
        both[0].start()
        return results_removed(path)

    results_removed = results.owned.remove_own
    monkeypatch.setattr(results.owned, "remove_own", beside)
    write_results(out, "new")
    both[0].join()
    assert left_in(out.parent) == ("new", ["run"])


def test_results_without_a_file_are_a_bug(tmp_path):
    with pytest.raises(RuntimeError, match="without a file"), results_folder(tmp_path / "run"):
        pass
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name",
    [
        "../x",
        "/x",
        "a/../b",
        "a/b/c",
        "a//b",
        "a/",
        "./a",
        f"a/{NOTE}",
        "a\\b",
        "..",
        ".",
        "",
        NOTE,
        "a\0b",
    ],
)
def test_a_name_that_leads_elsewhere_is_a_bug(tmp_path, name):
    with (
        pytest.raises(ValueError, match="is not the name"),
        results_folder(tmp_path / "run") as folder,
    ):
        folder / name
    assert not any(tmp_path.iterdir())
    assert not owned.is_own_name(name)


def test_unencodable_characters_are_escaped_and_line_ends_kept(tmp_path):
    with results_folder(tmp_path / "run") as folder:
        folder.write("a.txt", "\udcff\nµ\n")
    assert (tmp_path / "run" / "a.txt").read_bytes() == b"\\udcff\n\xc2\xb5\n"


def test_long_paths_get_the_prefix_of_windows():
    long, short = "x" * 197, "x" * 190
    paths = (rf"C:\{short}", rf"C:\{long}", rf"\\host\share\{long}", rf"\\?\C:\{long}")
    assert [folders.extended(path) for path in paths] == [
        rf"C:\{short}",
        rf"\\?\C:\{long}",
        rf"\\?\UNC\host\share\{long}",
        rf"\\?\C:\{long}",
    ]
