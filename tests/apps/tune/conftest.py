"""A finished run on the bench, once a session, and its beginning as the start of other runs."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from markupsafe import Markup
from tests.apps.tune.bench import Bench, drawn
from tests.apps.tune.machine import BenchMachine, Faults, written
from tests.apps.tune.plc import WIDE

from bristle.apps.tune import Options, tune
from bristle.apps.tune.journal import NAME, Journal
from bristle.report import page

SEED, CYCLES = 4, 6
OPTIONS = Options(models="dahl", duration=20.0, draws=0)


@pytest.fixture
def armed(kind):
    """A machine on a new controller, with wide limits."""
    machine = kind.example()
    machine.arm(WIDE)
    return machine


@pytest.fixture(scope="session", autouse=True)
def own_locks(tmp_path_factory):
    """Keep the locks of machines in a folder of the session."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BRISTLE_STATE_DIR", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session")
def finished(tmp_path_factory, own_locks):
    """Return machine, folder and result of a run that was kept."""
    folder = tmp_path_factory.mktemp("tuned")
    file, bench, _ = written(folder, SEED, CYCLES)
    machine = BenchMachine(bench, memory=folder / "memory.json")
    machine.shares = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            page,
            "picture",
            lambda name, draw, alternative, caption, **_: page.Picture(
                f"figure-{name}", Markup(), caption
            ),
        )
        result = tune(
            file,
            folder / "out",
            move=True,
            machine=machine,
            options=OPTIONS,
            progress=lambda share, _: machine.shares.append(share),
        )
    return machine, folder, result


@pytest.fixture(autouse=True)
def without_figures(undrawn):
    """No figure is drawn on the reports."""


@pytest.fixture
def identified(finished, tmp_path):
    """Return a function that makes a machine with faults, and the files of a run that was interrupted behind its identification."""
    return begun(finished[1], tmp_path)


def killed(entry: int | tuple[str, int], act: Callable[[], object]) -> bool:
    """Do something in another process, which is killed behind an entry of its journal; return whether it was.

    The entry is a number, or a step and the number of an entry that this process writes in this step.
    """
    child = os.fork()
    if child == 0:
        write, steps = Journal.write, []

        def fatal(journal, *names, **facts):
            written_entry = write(journal, *names, **facts)
            place = (written_entry["step"], steps.count(written_entry["step"]))
            steps.append(written_entry["step"])
            if entry in (written_entry["n"], place):
                os.kill(os.getpid(), 9)
            return written_entry

        Journal.write = fatal
        try:
            act()
        finally:
            os._exit(1)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status) and os.WTERMSIG(status) == 9


def begun(folder: Path, target: Path, step: str = "identification"):
    """Copy a finished run up to a step."""
    for name in ("axis.toml", "machine.toml", "motion.csv"):
        shutil.copy(folder / name, target / name)
    shutil.copytree(folder / "out", target / "out")
    for name in ("report.html", "summary.json"):
        (target / "out" / name).unlink(missing_ok=True)
    lines = (folder / "out" / NAME).read_text().splitlines(keepends=True)
    entries = [json.loads(line) for line in lines]
    end = next(
        place
        for place, entry in enumerate(entries)
        if entry["step"] == step and entry["event"] == "done"
    )
    begin = json.dumps(str(folder / "machine.toml")), json.dumps(str(target / "machine.toml"))
    text = "".join(lines[: end + 1])
    assert begin[0] in text
    (target / "out" / NAME).write_text(text)

    def make(faults: Faults | None = None) -> BenchMachine:
        return BenchMachine(Bench(drawn(SEED)[0], SEED), faults, target / "memory.json")

    return make, target
