"""A folder that belongs to a person: a run refuses it, and neither it nor what its links lead to changes."""

import os
import stat

import pytest
from tests.apps.tune.faults import INITIAL, Faulty, Small, small_files, with_short_steps

from bristle.apps.tune.journal import NAME
from bristle.cli.main import main

PLACES = (
    NAME,
    "records",
    "records/rest.csv",
    "results",
    "results/model.toml",
    "refined",
    "report.html",
    "summary.json",
    "notes.txt",
)
PERSONAL = "of a person\n"


def made_file(place, outside):
    place.write_text(PERSONAL)


def made_link(place, outside):
    place.symlink_to(outside / "file")


def made_broken_link(place, outside):
    place.symlink_to(outside / "nowhere")


def made_link_to_folder(place, outside):
    place.symlink_to(outside)


def made_hard_link(place, outside):
    place.hardlink_to(outside / "file")


def made_folder(place, outside):
    place.mkdir()
    (place / "file").write_text(PERSONAL)


def made_pipe(place, outside):
    os.mkfifo(place)


MAKERS = (
    made_file,
    made_link,
    made_broken_link,
    made_link_to_folder,
    made_hard_link,
    made_folder,
    made_pipe,
)


def contents(folder):
    """Return kind and content of each path below a folder, of links their target."""
    found = {}
    for path in sorted(folder.rglob("*")):
        mode = path.lstat().st_mode
        name = str(path.relative_to(folder))
        if stat.S_ISREG(mode):
            found[name] = path.read_text()
        else:
            found[name] = os.readlink(path) if stat.S_ISLNK(mode) else stat.S_IFMT(mode)
    return found


@pytest.fixture
def axis(tmp_path, monkeypatch):
    """A machine, and a folder outside of that of its run."""
    monkeypatch.setenv("BRISTLE_STATE_DIR", str(tmp_path / "state"))
    monkeypatch.chdir(tmp_path)
    with_short_steps(monkeypatch)
    small_files(tmp_path)
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside/file").write_text(PERSONAL)
    return tmp_path


def run(axis, monkeypatch, machine=None):
    machine = machine or Small(axis / "memory.json")
    monkeypatch.setattr("bristle.apps.tune.tuning.connected", lambda link, allow_code: machine)
    return main(["tune", "machine.toml", "--out", "out", "--move", "--quiet"])


@pytest.mark.fast_cases(14)
@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("place", PLACES)
def test_a_folder_of_a_person_is_refused(axis, monkeypatch, capsys, place, make):
    place = axis / "out" / place
    place.parent.mkdir(parents=True)
    make(place, axis / "outside")
    before = contents(axis / "outside"), contents(axis / "out")
    assert run(axis, monkeypatch) == 2
    assert (contents(axis / "outside"), contents(axis / "out")) == before
    assert Small(axis / "memory.json").state() == INITIAL


@pytest.mark.slow
@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("place", PLACES)
def test_a_run_that_goes_on_changes_nothing_of_a_person(axis, monkeypatch, capsys, place, make):
    """A person puts something into the folder of a run that was stopped."""

    def broken(_):
        raise ValueError("stopped")

    assert run(axis, monkeypatch, Faulty(axis / "memory.json", broken, 100)) == 1
    place = axis / "out" / place
    if place.is_dir():
        place.rename(axis / "moved")
    else:
        place.unlink(missing_ok=True)
    place.parent.mkdir(exist_ok=True)
    make(place, axis / "outside")
    outside, own = contents(axis / "outside"), contents(axis / "out")
    name = str(place.relative_to(axis / "out"))
    assert run(axis, monkeypatch) in (0, 1, 2)
    assert contents(axis / "outside") == outside
    assert {
        key: value for key, value in contents(axis / "out").items() if key.startswith(name)
    } == {key: value for key, value in own.items() if key.startswith(name)}
    assert Small(axis / "memory.json").state()["gain"] in (0.0, 1.0)
