"""A small axis, its log and its files, and the command line run in this process."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from tests.examples.data import measured

from bristle.cli.main import main
from bristle.files.owned import NOTE

IDENTIFY = [
    "identify",
    "log.csv",
    "--axis",
    "axis.toml",
    "--model",
    "viscous,coulomb_viscous",
    "--draws",
    "0",
]
WITH_DRAWS = [*IDENTIFY, "--draws", "20"]
AXIS = """
schema = 1
name = "bench"
kind = "translational"

[columns]
time = { column = "t", unit = "s" }
position = { column = "q", unit = "m" }
reference = { column = "r", unit = "m" }
effort = { column = "u", unit = "N" }

[effort]
limit = "300 N"

[encoder]
resolution = "0.1 um"

[identification]
cutoff = "100 Hz"
decimation = 5

[controller]
model = "cascade"
k_p = "80 1/s"
k_v = "4 N*s/mm"
"""

EXPERIMENT = """
schema = 1
name = "bench"

[plant]
M = "20 kg"

[friction]
model = "coulomb_viscous"
F_C = "8 N"
F_v = "40 N*s/m"

[controller]
model = "cascade"
k_p = "80 1/s"
k_v = "4 N*s/mm"
limit = "300 N"

[controller.feedforward]
friction = { model = "coulomb_viscous", F_C = "8 N", F_v = "40 N*s/m" }

[sensor]
resolution = "0.1 um"

[reference]
model = "sine"
amplitude = "50 mm"
frequency = "0.5 Hz"
ramp = "1 s"

[run]
duration = "6 s"
sample_time = "1 ms"
settle = "2 s"

[compare.none.controller.feedforward]
friction = "none"
"""

MODEL = """
schema = 1
kind = "translational"

[plant]
model = "inertia"
M = 20.0

[friction]
model = "coulomb_viscous"
F_C = 8.0
F_v = 40.0
"""

USER_MODEL = '''
from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction


class Parameters(NamedTuple):
    F_0: Annotated[float, Variable("force", "force against the motion", min=0.0, directional=True)]


class State(NamedTuple):
    """None."""


class Move(NamedTuple):
    """None."""


@kernel
def trial(state, memory, motion, dt, p):
    return p.F_0 * direction(motion.v), Move()


@kernel
def commit(state, memory, move, p):
    return state


MODEL = FrictionModel(
    name="own", description="a model of my own", Parameters=Parameters, State=State, trial=trial, commit=commit
)
'''


@dataclass
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def data(self) -> dict:
        """The one JSON object on the standard output."""
        return json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def written_in(folder: str | Path) -> set[str]:
    """Return the names of the results in a folder, which must carry the note of what is bristle's own."""
    names = {item.name for item in Path(folder).iterdir()}
    assert NOTE in names
    return names - {NOTE}


@contextmanager
def progress_in_range(text, quiet=False):
    """Refuse a share of the time that is not between 0 and 1; it falls where work takes longer than expected."""

    def report(share, words):
        assert 0.0 <= share <= 1.0, (share, words)

    assert text
    yield report


@pytest.fixture
def bristle(capsys, monkeypatch):
    """Run the command line in this process."""
    monkeypatch.setattr("bristle.cli.options.progress", progress_in_range)

    def run(
        *arguments: object,
        code: int | None = None,
        said: str | tuple[str, ...] = (),
        shown: str | tuple[str, ...] = (),
    ) -> Ended:
        """Return how it ended: with a code, if one is named, and with words that it said on the error stream and showed on the output."""
        capsys.readouterr()
        ended = Ended(main([str(argument) for argument in arguments]), *capsys.readouterr())
        assert code in (None, ended.code), ended
        for stream, words in ((ended.err, said), (ended.out, shown)):
            for each in (words,) if isinstance(words, str) else words:
                assert each in " ".join(stream.split()), ended
        return ended

    return run


@pytest.fixture(scope="session")
def simulated(tmp_path_factory) -> Path:
    """A log of the axis, simulated: reference, position and effort."""
    from bristle.files import read_experiment
    from bristle.simulation import simulate

    folder = tmp_path_factory.mktemp("simulated")
    (folder / "experiment.toml").write_text(EXPERIMENT)
    variant = simulate(read_experiment(folder / "experiment.toml")).variants["none"]
    columns = np.column_stack((variant.time, variant.measured, variant.reference, variant.effort))
    np.savetxt(
        folder / "log.csv", columns, delimiter=",", header="t,q,r,u", comments="", fmt="%.9g"
    )
    return folder / "log.csv"


@pytest.fixture
def place(tmp_path, simulated, monkeypatch) -> Path:
    """A folder with an axis file, a log, an experiment, a model file and a model of a user's own."""
    for name, text in (
        ("axis.toml", AXIS),
        ("experiment.toml", EXPERIMENT),
        ("model.toml", MODEL),
        ("own.py", USER_MODEL),
    ):
        (tmp_path / name).write_text(text)
    (tmp_path / "log.csv").write_bytes(simulated.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def here(tmp_path, monkeypatch) -> Path:
    """An empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def fits(simulated) -> dict:
    """What was identified so far, at first two models of the log of the axis, without draws and with some."""
    identified = {}
    (simulated.parent / "axis.toml").write_text(AXIS)
    with pytest.MonkeyPatch.context() as patch:
        _identify_once(patch, identified)
        patch.chdir(simulated.parent)
        assert main(IDENTIFY) == main(WITH_DRAWS) == 0
    return identified


@pytest.fixture
def remembered(monkeypatch, fits) -> None:
    """Identify the same logs with the same options only once, and let reports of it have no movable parameters."""
    _identify_once(monkeypatch, fits)
    monkeypatch.setattr("bristle.apps.lab.living.living_part", lambda *_: None)


def _identify_once(monkeypatch, fits):
    from bristle.report import identified

    identify = identified.identify

    def once(logs, *, axis, progress, answer=None, **options):
        key = repr(([(log.origin, log.segments) for log in logs], axis, options))
        if key not in fits:
            fits[key] = identify(logs, axis=axis, progress=progress, **options)
        return fits[key]

    monkeypatch.setattr(identified, "identify", once)


@pytest.fixture
def emps() -> Path:
    """The measured log of the electro-mechanical positioning system."""
    return measured("emps", "DATA_EMPS.mat")
