"""The figures of the source paper, reproduced once for all tests of this folder."""

from dataclasses import replace
from functools import cache

import pytest

from bristle.engine import compilation
from bristle.files.experiment import read_experiment
from bristle.paper import EXPERIMENTS, FIGURES, reproduce, tracking
from bristle.paper.setting import read_setting
from bristle.simulation import simulate

# By experiment: how many runs are enough for the fast tests, and the variants of which they read the last place.
FEWER = {"set_a.toml": (2, ("none", "printed")), "set_c.toml": (2, ()), "set_a_break_away.toml": (1, ("F_S_40", "F_S_75"))}


@pytest.fixture(scope="session")
def entries():
    """The compiled entries that the figures run, whatever other tests have used before."""
    return {}


@pytest.fixture(scope="session")
def simulated(request, entries):
    """A function that returns the loops of an experiment of the package, simulated once for all tests of this folder.

    Of loops whose last place only slow tests read, the fast ones see fewer runs.
    """
    is_whole = any(item.get_closest_marker("slow") and "paper" in item.fixturenames for item in request.session.items)

    @cache
    def of(name):
        experiment = read_experiment(EXPERIMENTS / name)
        if name in FEWER and not is_whole:
            seeds, whole = FEWER[name]
            variants = (item if item.name in whole else replace(item, run=replace(item.run, seeds=seeds)) for item in experiment.variants)
            experiment = replace(experiment, variants=tuple(variants))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compilation, "_entries", entries)
            return simulate(experiment)

    return of


@pytest.fixture(scope="session")
def paper(entries, simulated):
    """Every figure by its number."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilation, "_entries", entries)
        patch.setattr(tracking, "simulate", lambda experiment, report: simulated(experiment.origins["experiment"][0].name))
        return {item.number: item for item in reproduce(FIGURES)}


@pytest.fixture(scope="session")
def setting():
    """A function that returns the experiment of a figure."""
    return lambda number: read_setting(EXPERIMENTS / f"fig_{number:02d}.toml")


@pytest.fixture(scope="session")
def faster(simulated):
    """The motion of set C at 1, 2 and 4 Hz, by variant."""
    return simulated("set_c_faster.toml").variants
