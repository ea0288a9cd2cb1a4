"""The error budget of a loop: each cause switched on alone, and off alone, by simulation."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.loop.assessment import motion_of
from bristle.loop.linear_system import ALIKE
from bristle.loop.tuning import RUNS_MAX, told_the_motion
from bristle.sensors import encoder
from bristle.simulation import Statistics, friction_along, simulate, statistics_of


@dataclass(frozen=True)
class Entry:
    """One cause, and the following error [m or rad] with this cause only, and with all but this one."""

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
    loops = {"everything": variant, "nothing": reduce(lambda loop, cause: cause.without(loop), causes, variant)}
    for cause in causes:
        further = [entry for entry in causes if entry is not cause]
        loops[f"{cause.name} alone"] = reduce(lambda loop, cause: cause.without(loop), further, variant)
        loops[f"without {cause.name}"] = cause.without(variant)
    runs = min(variant.run.seeds, RUNS_MAX)
    named = tuple(replace(loop, name=name, run=replace(loop.run, seeds=runs)) for name, loop in loops.items())
    outcomes = simulate(Experiment(variant.name, variant.plant.kind, named), progress).variants
    errors = {
        name: statistics_of(outcome.time[:0]) if outcome.status is Status.NOT_FINITE else outcome.following_error
        for name, outcome in outcomes.items()
    }
    entries = [Entry(cause.name, cause.description, errors[f"{cause.name} alone"], errors[f"without {cause.name}"]) for cause in causes]
    entries.sort(key=lambda entry: entry.without.peak_to_peak)
    return Budget(variant.name, errors["everything"], errors["nothing"], tuple(entries), runs)


class Cause(NamedTuple):
    """Something that a loop would err less without; removing several in any order gives the same loop."""

    name: str
    description: str
    without: Callable[[Variant], Variant]


def causes_of(variant: Variant) -> tuple[Cause, ...]:
    """Return what a loop errs by: what its friction, compensator, encoder, computer and drive have of it."""
    return (*_of_feedforward(variant), *_of_the_rest(variant))


def nominal(friction: Model) -> Model:
    """Return a friction model that is the same in both directions and at every reversal, without an offset."""
    return _alike(friction, offset=0.0, scatter=0.0)


def best_gain(variant: Variant) -> float:
    """Return the factor on the compensator that makes it the nominal friction along the reference, in the mean square."""
    compensator = variant.feedforward.friction
    if compensator is None:
        return 1.0
    dt = variant.run.sample_time
    velocity = np.diff(motion_of(variant)[0]) / dt
    friction, compensation = (friction_along(nominal(model), velocity, dt) for model in (variant.friction, compensator))
    square = float(compensation @ compensation)
    return float(compensation @ friction) / square if square > 0.0 else 1.0


def _alike(friction: Model, **changed: float) -> Model:
    """Return a friction model with the mean of both directions in either, and some values changed that it has."""
    values = friction.values
    for name in values:
        stem = name.removesuffix("_pos")
        if stem != name and f"{stem}_neg" in values:
            changed[name] = changed[f"{stem}_neg"] = 0.5 * (values[name] + values[f"{stem}_neg"])
    return _with_known(friction, **changed)


def _with_known(friction: Model, **changed: float) -> Model:
    """Return a friction model with those of some values changed that it has."""
    own = {name: value for name, value in changed.items() if name in friction.values}
    return friction.with_values(**own) if own else friction


def _with_fed(loop: Variant, **changed: Any) -> Variant:
    """Return a loop with other values of its feedforward."""
    return replace(loop, feedforward=replace(loop.feedforward, **changed))


def _of_feedforward(variant: Variant) -> Iterator[Cause]:
    """Yield what the desired motion and the compensator have of it."""
    informed, feedforward, true = told_the_motion(variant), variant.feedforward, nominal(variant.friction)
    if (informed.controller, informed.feedforward) != (variant.controller, feedforward):
        text = "velocity or inertia of the desired motion is not fed forward as it is"
        mass, law = informed.feedforward.mass, informed.controller
        yield Cause("lag", text, lambda loop: _with_fed(replace(loop, controller=law), mass=mass))
    if variant.table is not None:
        return  # what acts on both sides of a screw is no model that could be fed forward instead
    if feedforward.friction is None or feedforward.gain == 0.0:
        text = "the friction is not fed forward"
        yield Cause("no compensation", text, lambda loop: _with_fed(loop, friction=true, gain=1.0))
        return
    best = best_gain(variant)
    if not math.isclose(feedforward.gain, best, rel_tol=ALIKE):
        text = f"the compensator is {feedforward.gain / best:.3g} times the nominal friction"
        yield Cause("amplitude", text, lambda loop: _with_fed(loop, gain=loop.feedforward.gain * best / feedforward.gain))
    if feedforward.friction != true:
        text = "the compensator turns otherwise than the friction, at the same size"
        yield Cause("shape", text, lambda loop: _with_fed(loop, friction=true, gain=loop.feedforward.gain / best))


def _of_the_rest(variant: Variant) -> Iterator[Cause]:
    """Yield what friction, sensor, computer, drive and plant have of it."""
    fed, run, sensor = variant.feedforward, variant.run, variant.sensor
    sides = [model for model in (variant.friction, variant.table) if model is not None]
    if fed.offset or fed.asymmetry or any(_alike(model, offset=0.0) != model for model in sides):
        yield Cause("asymmetry", "friction by direction and offset, less what of both is fed forward", _symmetric)
    scatter = max(model.values.get("scatter", 0.0) for model in sides)
    if scatter > 0.0:
        text = f"friction that differs by {100.0 * scatter:.2g} % from reversal to reversal"
        yield Cause("irregularity", text, lambda loop: _with_frictions(loop, lambda model: _with_known(model, scatter=0.0)))
    if sensor.component is not encoder:
        text = f"what the sensor reads: {sensor.component.description}"
        yield Cause(sensor.name, text, lambda loop: replace(loop, sensor=encoder(kind=sensor.kind)))
    else:
        exact = {name: 0.0 for name in ("resolution", "noise") if sensor.values[name] > 0.0}
        text = " and ".join(exact) + " of the encoder"
        if exact:
            yield Cause("encoder", text, lambda loop: replace(loop, sensor=loop.sensor.with_values(**exact)))
    if run.delay or run.current_lag:
        text = "computation and current control"
        yield Cause("delay", text, lambda loop: replace(loop, run=replace(loop.run, delay=0, current_lag=0.0)))
    if variant.plant.values.get("backlash", 0.0) > 0.0:
        text = "travel lost at a reversal"
        yield Cause("backlash", text, lambda loop: replace(loop, plant=loop.plant.with_values(backlash=0.0)))
    if variant.disturbance is not None:
        yield Cause("unexplained", "force that no model explains", lambda loop: replace(loop, disturbance=None))


def _symmetric(loop: Variant) -> Variant:
    fed = loop.feedforward.friction
    even = _with_frictions(loop, lambda model: _alike(model, offset=0.0))
    return _with_fed(even, friction=None if fed is None else _alike(fed, offset=0.0), offset=0.0, asymmetry=0.0)


def _with_frictions(loop: Variant, changed: Callable[[Model], Model]) -> Variant:
    """Return a loop with the friction on both sides of its screw changed."""
    return replace(loop, friction=changed(loop.friction), table=None if loop.table is None else changed(loop.table))
