"""The figures of the source paper, reproduced once for all tests of this folder."""

import pytest

from bristle.engine import compilation
from bristle.files.experiment import read_experiment
from bristle.paper import EXPERIMENTS, FIGURES, reproduce
from bristle.paper.setting import read_setting
from bristle.simulation import simulate


@pytest.fixture(scope="session")
def entries():
    """The compiled entries that the figures run, whatever other tests have used before."""
    return {}


@pytest.fixture(scope="session")
def paper(entries):
    """Every figure by its number."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilation, "_entries", entries)
        return {item.number: item for item in reproduce(FIGURES)}


@pytest.fixture(scope="session")
def setting():
    """A function that returns the experiment of a figure."""
    return lambda number: read_setting(EXPERIMENTS / f"fig_{number:02d}.toml")


@pytest.fixture(scope="session")
def faster():
    """The motion of set C at 1, 2 and 4 Hz, by variant."""
    return simulate(read_experiment(EXPERIMENTS / "set_c_faster.toml")).variants
