"""The figures of the source paper, reproduced once for all tests of this folder."""

from dataclasses import replace
from functools import cache

import pytest

from bristle.apps.paper import EXPERIMENTS, FIGURES, reproduce, tracking
from bristle.apps.paper.setting import read_setting
from bristle.engine import compilation
from bristle.files.experiment import read_experiment
from bristle.simulation import simulate

# What the fast tests read of Set A, where two runs are enough.
READ = ("none", "paper", "identified", "observer", "observer_feedforward")


@pytest.fixture(scope="session")
def entries():
    """The compiled entries that the figures run, whatever other tests have used before."""
    return {}


@pytest.fixture(scope="session")
def simulated(request, entries):
    """A function that returns the loops of an experiment of the package, simulated once for all tests of this folder.

    The fast tests see fewer runs of fewer loops.
    """
    is_whole = any(
        item.get_closest_marker("slow") and "paper" in item.fixturenames
        for item in request.session.items
    )

    @cache
    def of(name):
        experiment = read_experiment(EXPERIMENTS / name)
        if name == "set_a.toml" and not is_whole:
            read = (item for item in experiment.variants if item.name in READ)
            experiment = replace(
                experiment,
                variants=tuple(replace(item, run=replace(item.run, seeds=2)) for item in read),
            )
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compilation, "_entries", entries)
            return simulate(experiment)

    return of


@pytest.fixture(scope="session")
def paper(entries, simulated):
    """Every figure by its number."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilation, "_entries", entries)
        patch.setattr(
            tracking,
            "simulate",
            lambda experiment, report: simulated(experiment.origins["experiment"][0].name),
        )
        return {item.number: item for item in reproduce(FIGURES)}


@pytest.fixture(scope="session")
def setting():
    """A function that returns the experiment of a figure."""
    return lambda number: read_setting(EXPERIMENTS / f"fig_{number:02d}.toml")


@pytest.fixture(scope="session")
def faster(simulated):
    """The motion of set C at 1, 2 and 4 Hz, by variant."""
    return simulated("set_c_faster.toml").variants
