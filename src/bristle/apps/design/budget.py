"""Error budget of a loop, from simulations with each cause alone, and without each cause."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Experiment, Model, Status, Variant, guarded
from bristle.models.sensors import encoder
from bristle.simulation import (
    ALIKE,
    RUNS_MAX,
    Statistics,
    friction_along,
    motion_of,
    simulate,
    statistics_of,
    with_known_motion,
)


@dataclass(frozen=True)
class Entry:
    """One cause, and the following error [m or rad] with only this cause, and with all other causes."""

    cause: str
    description: str
    alone: Statistics
    without: Statistics


@dataclass(frozen=True)
class Budget:
    """Error budget of a loop.

    Parameters
    ----------
    variant : str
        Name of the loop.
    all_causes : Statistics
        Following error of the loop with all causes [m or rad].
    no_cause : Statistics
        Following error of the loop without any cause [m or rad].
    entries : tuple of Entry
        Causes, sorted by the reduction of the error when the cause is removed.
    runs : int
        Number of simulations with different noise for each mean.
    """

    variant: str
    all_causes: Statistics
    no_cause: Statistics
    entries: tuple[Entry, ...]
    runs: int


@guarded()
def error_budget(variant: Variant, progress: Callable[[float, str], None] | None = None) -> Budget:
    """Return the error budget of a loop.

    Parameters
    ----------
    variant : Variant
        The loop, with its compensator.
    progress : callable, optional
        Called with the share done and the name of the next step.
    """
    causes = causes_of(variant)
    loops = {
        "everything": variant,
        "nothing": reduce(lambda loop, cause: cause.without(loop), causes, variant),
    }
    for cause in causes:
        further = [entry for entry in causes if entry is not cause]
        loops[f"{cause.name} alone"] = reduce(
            lambda loop, cause: cause.without(loop), further, variant
        )
        loops[f"without {cause.name}"] = cause.without(variant)
    runs = min(variant.run.seeds, RUNS_MAX)
    named = tuple(
        replace(loop, name=name, run=replace(loop.run, seeds=runs)) for name, loop in loops.items()
    )
    outcomes = simulate(Experiment(variant.name, variant.plant.kind, named), progress).variants
    errors = {name: outcome.following_error for name, outcome in outcomes.items()}
    for name, outcome in outcomes.items():
        if outcome.status is Status.NOT_FINITE:
            errors[name] = statistics_of(outcome.time[:0])
    entries = [
        Entry(
            cause.name,
            cause.description,
            errors[f"{cause.name} alone"],
            errors[f"without {cause.name}"],
        )
        for cause in causes
    ]
    entries.sort(key=lambda entry: entry.without.peak_to_peak)
    return Budget(variant.name, errors["everything"], errors["nothing"], tuple(entries), runs)


class Cause(NamedTuple):
    """A removable cause of error; the order of removal does not matter."""

    name: str
    description: str
    without: Callable[[Variant], Variant]


def causes_of(variant: Variant) -> tuple[Cause, ...]:
    """Return the causes of the error of a loop: its friction, compensator, encoder, computer and drive."""
    return (*_of_feedforward(variant), *_of_the_rest(variant))


def nominal(friction: Model) -> Model:
    """Return a friction model with equal values in both directions and at each reversal, without an offset."""
    return _alike(friction, offset=0.0, scatter=0.0)


def best_gain(variant: Variant) -> float:
    """Return the gain at which the compensator matches the nominal friction along the reference, in the mean square."""
    compensator = variant.feedforward.friction
    if compensator is None:
        return 1.0
    dt = variant.run.sample_time
    velocity = np.diff(motion_of(variant)[0]) / dt
    friction, compensation = (
        friction_along(nominal(model), velocity, dt) for model in (variant.friction, compensator)
    )
    square = float(compensation @ compensation)
    if square > 0.0:
        return float(compensation @ friction) / square
    return 1.0


def _alike(friction: Model, **changed: float) -> Model:
    """Return a friction model with the mean of both directions, and with the given values changed if it has them."""
    values = friction.values
    for name in values:
        stem = name.removesuffix("_pos")
        if stem != name and f"{stem}_neg" in values:
            changed[name] = changed[f"{stem}_neg"] = 0.5 * (values[name] + values[f"{stem}_neg"])
    return _with_known(friction, **changed)


def _with_known(friction: Model, **changed: float) -> Model:
    """Return a friction model with the given values changed if it has them."""
    own = {name: value for name, value in changed.items() if name in friction.values}
    if not own:
        return friction
    return friction.with_values(**own)


def _with_fed(loop: Variant, **changed: Any) -> Variant:
    """Return a loop with changed values of its feedforward."""
    return replace(loop, feedforward=replace(loop.feedforward, **changed))


def _of_feedforward(variant: Variant) -> Iterator[Cause]:
    """Yield causes in the desired motion and the compensator."""
    informed = with_known_motion(variant)
    feedforward = variant.feedforward
    true = nominal(variant.friction)
    if (informed.controller, informed.feedforward) != (variant.controller, feedforward):
        text = "the feedforward lacks the desired velocity or the inertia, or has a wrong value of them"
        mass = informed.feedforward.mass
        law = informed.controller
        yield Cause("lag", text, lambda loop: _with_fed(replace(loop, controller=law), mass=mass))
    if variant.table is not None:
        return  # friction on both sides of a screw has no single model to feed forward
    if feedforward.friction is None or feedforward.gain == 0.0:
        yield Cause(
            "no compensation",
            "the friction is not fed forward",
            lambda loop: _with_fed(loop, friction=true, gain=1.0),
        )
        return
    best = best_gain(variant)
    if not math.isclose(feedforward.gain, best, rel_tol=ALIKE):
        text = f"the compensator is {feedforward.gain / best:.3g} times the nominal friction"
        yield Cause(
            "amplitude",
            text,
            lambda loop: _with_fed(loop, gain=loop.feedforward.gain * best / feedforward.gain),
        )
    if feedforward.friction != true:
        text = "the force of the compensator has another shape than the friction"
        yield Cause(
            "shape",
            text,
            lambda loop: _with_fed(loop, friction=true, gain=loop.feedforward.gain / best),
        )


def _of_the_rest(variant: Variant) -> Iterator[Cause]:
    """Yield causes in friction, sensor, computer, drive and plant."""
    fed = variant.feedforward
    run = variant.run
    sensor = variant.sensor
    sides = [model for model in (variant.friction, variant.table) if model is not None]
    if fed.offset or fed.asymmetry or any(_alike(model, offset=0.0) != model for model in sides):
        yield Cause(
            "asymmetry",
            "difference of friction between directions, and offset, as far as they are not fed forward",
            _symmetric,
        )
    scatter = max(model.values.get("scatter", 0.0) for model in sides)
    if scatter > 0.0:
        text = f"friction scatter of {100.0 * scatter:.2g} % between reversals"
        yield Cause(
            "irregularity",
            text,
            lambda loop: _with_frictions(loop, lambda model: _with_known(model, scatter=0.0)),
        )
    if sensor.component is not encoder:
        text = f"sensor: {sensor.component.description}"
        yield Cause(sensor.name, text, lambda loop: replace(loop, sensor=encoder(kind=sensor.kind)))
    else:
        exact = {name: 0.0 for name in ("resolution", "noise") if sensor.values[name] > 0.0}
        text = " and ".join(exact) + " of the encoder"
        if exact:
            yield Cause(
                "encoder", text, lambda loop: replace(loop, sensor=loop.sensor.with_values(**exact))
            )
    if run.delay or run.current_lag:
        text = "delay of computation and current control"
        yield Cause(
            "delay",
            text,
            lambda loop: replace(loop, run=replace(loop.run, delay=0, current_lag=0.0)),
        )
    if variant.plant.values.get("backlash", 0.0) > 0.0:
        yield Cause(
            "backlash",
            "lost travel at a reversal",
            lambda loop: replace(loop, plant=loop.plant.with_values(backlash=0.0)),
        )
    if variant.disturbance is not None:
        yield Cause(
            "unexplained",
            "force outside the friction model",
            lambda loop: replace(loop, disturbance=None),
        )


def _symmetric(loop: Variant) -> Variant:
    fed = loop.feedforward.friction
    if fed is not None:
        fed = _alike(fed, offset=0.0)
    even = _with_frictions(loop, lambda model: _alike(model, offset=0.0))
    return _with_fed(even, friction=fed, offset=0.0, asymmetry=0.0)


def _with_frictions(loop: Variant, changed: Callable[[Model], Model]) -> Variant:
    """Return a loop with changed friction on both sides of its screw."""
    return replace(
        loop,
        friction=changed(loop.friction),
        table=None if loop.table is None else changed(loop.table),
    )
