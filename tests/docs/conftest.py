"""The pages of the documentation, and a folder as their reader has it: a log, an axis file, results."""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import EXPERIMENT

from bristle import friction, plants
from bristle.cli.demonstration import axis_simulated
from bristle.cli.main import main
from bristle.files import write_model

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("examples/**/*.md"),
    ]
)
_BLOCK = re.compile(r"^```(?P<info>[^\n`]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page; `info` is what stands behind the fence, such as ``toml axis``."""

    page: Path
    line: int
    info: str
    text: str

    @property
    def name(self) -> str:
        """Where it stands."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(*infos: str) -> list[Block]:
    """Every block of these kinds, in all pages."""
    result = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for item in _BLOCK.finditer(text):
            line = text.count("\n", 0, item.start()) + 1
            result.append(Block(page, line, item["info"].strip(), item["text"]))
    return [item for item in result if item.info in infos]


def write_followed(folder):
    """Write followed.csv: log.csv with half of its following error."""
    head = (folder / "log.csv").read_text().splitlines()[1]
    rows = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=2)
    rows[:, 1] = rows[:, 2] - 0.5 * (rows[:, 2] - rows[:, 1])
    np.savetxt(folder / "followed.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")


STUDY = """
schema = 1
experiment = "experiment.toml"
runs = 8
seed = 7
[vary]
"friction.F_C" = { normal = ["8 N", "0.5 N"] }
[grid]
"reference.frequency" = ["0.5 Hz", "1 Hz"]
"""


@pytest.fixture(scope="session")
def readers_folder(tmp_path_factory):
    """A folder with log.csv, unseen.csv, axis.toml, and models."""
    folder = tmp_path_factory.mktemp("reader")
    axis_simulated.write_log(folder / "log.csv", seed=1)
    axis_simulated.write_log(folder / "unseen.csv", seed=2)
    write_followed(folder)
    shutil.copyfile(axis_simulated.AXIS_FILE, folder / "axis.toml")
    for name in ("quadratic_drag.py", "humidity.py"):
        shutil.copyfile(ROOT / "examples" / name, folder / name)
    (folder / "experiment.toml").write_text(EXPERIMENT)
    (folder / "study.toml").write_text(STUDY)
    write_model(
        folder / "model.toml", plants.inertia(M=28.0), friction.coulomb_viscous(F_C=20.0, F_v=200.0)
    )
    return folder


@pytest.fixture(scope="session")
def results(readers_folder):
    """The results of an identification in the folder of the reader."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(readers_folder)
        assert (
            main(
                [
                    "identify",
                    "log.csv",
                    "--axis",
                    "axis.toml",
                    "--model",
                    "coulomb_viscous+asymmetry",
                    "--out",
                    "results",
                ]
            )
            == 0
        )
    return readers_folder / "results"


@pytest.fixture
def at_the_reader(readers_folder, monkeypatch):
    """Be in the folder of the reader."""
    monkeypatch.chdir(readers_folder)
    return readers_folder
