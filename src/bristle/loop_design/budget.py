"""The error budget of a loop: each cause switched on alone, and off alone, by simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.loop_design.causes import Cause, causes_of
from bristle.simulation import Statistics, simulate, statistics_of
from bristle.simulation.result import SimulationResult

__all__ = ["Budget", "Entry", "error_budget"]

ALL_CAUSES, NO_CAUSE = "everything", "nothing"
RUNS_MAX = 2


@dataclass(frozen=True)
class Entry:
    """One cause of error.

    Parameters
    ----------
    cause, description : str
        What it is.
    alone, without : Statistics
        Following error [m or rad] with this cause only, and with all but this one.
    """

    cause: str
    description: str
    alone: Statistics
    without: Statistics


@dataclass(frozen=True)
class Budget:
    """What a loop errs by.

    Parameters
    ----------
    variant : str
        Name of the loop.
    all_causes, no_cause : Statistics
        Following error [m or rad] as the loop is, and without any of the causes.
    entries : tuple of Entry
        Each cause, the one without which the error falls most first.
    runs : int
        Simulations, each with other noise, that each number is the mean of.
    """

    variant: str
    all_causes: Statistics
    no_cause: Statistics
    entries: tuple[Entry, ...]
    runs: int


def error_budget(variant: Variant, progress: Callable[[float, str], None] | None = None) -> Budget:
    """Return what a loop errs by.

    Parameters
    ----------
    variant : Variant
        The loop, with its compensator.
    progress : callable, optional
        Called with the share done and the name of what comes next.
    """
    causes = causes_of(variant)
    loops = {ALL_CAUSES: variant, NO_CAUSE: _without(variant, causes)}
    for cause in causes:
        loops[f"{cause.name} alone"] = _without(variant, [further for further in causes if further is not cause])
        loops[f"without {cause.name}"] = _without(variant, [cause])
    runs = min(variant.run.seeds, RUNS_MAX)
    named = tuple(replace(loop, name=name, run=replace(loop.run, seeds=runs)) for name, loop in loops.items())
    result = simulate(Experiment(variant.name, variant.plant.kind, named), progress)
    errors = {name: _error(result, name) for name in loops}
    entries = [Entry(cause.name, cause.description, errors[f"{cause.name} alone"], errors[f"without {cause.name}"]) for cause in causes]
    entries.sort(key=lambda entry: entry.without.peak_to_peak)
    return Budget(variant.name, errors[ALL_CAUSES], errors[NO_CAUSE], tuple(entries), runs)


def _without(variant: Variant, causes: Iterable[Cause]) -> Variant:
    for cause in causes:
        variant = cause.without(variant)
    return variant


def _error(result: SimulationResult, name: str) -> Statistics:
    outcome = result.variants[name]
    return statistics_of(outcome.time[:0]) if outcome.status is Status.NOT_FINITE else outcome.following_error
