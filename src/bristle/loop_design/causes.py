"""What makes a compensated loop err: each cause by itself, and how a loop would be without it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.core.experiment import Variant
from bristle.loop_design.following import told_the_motion
from bristle.sensors import encoder
from bristle.simulation import friction_along

__all__ = ["Cause", "best_gain", "causes_of", "nominal"]

ENCODER = ("resolution", "noise")


class Cause(NamedTuple):
    """Something that a loop would err less without.

    `without` returns the same loop without it; removing several in any order gives the same loop.
    """

    name: str
    description: str
    without: Callable[[Variant], Variant]


def causes_of(variant: Variant) -> tuple[Cause, ...]:
    """Return what a loop errs by: what its friction, compensator, encoder, computer and drive have of it."""
    return (
        *_of_following(variant),
        *_of_compensator(variant),
        *_of_friction(variant),
        *_of_sensor(variant),
        *_of_delay(variant),
        *_of_the_rest(variant),
    )


def nominal(friction: Model) -> Model:
    """Return a friction model that is the same in both directions and at every reversal, without an offset."""
    return _alike(friction, {"offset": 0.0, "scatter": 0.0})


def best_gain(variant: Variant) -> float:
    """Return the factor on the compensator with which it comes closest to the nominal friction along the reference.

    Closest in the mean square; 1 where there is no compensator or it stays zero.
    """
    compensator = variant.feedforward.friction
    if compensator is None:
        return 1.0
    dt = variant.run.sample_time
    velocity = _steps(variant) / dt
    friction, compensation = (friction_along(nominal(model), velocity, dt) for model in (variant.friction, compensator))
    square = float(compensation @ compensation)
    return float(compensation @ friction) / square if square > 0.0 else 1.0


def _steps(variant: Variant) -> np.ndarray:
    run = variant.run
    t = run.sample_time * np.arange(round(run.duration / run.sample_time) + 1)
    position, _, _ = variant.reference.component.sample(t, variant.reference.parameters)
    return np.diff(position)


def _alike(friction: Model, changed: dict[str, float]) -> Model:
    """Return a friction model with the mean of both directions in either, and some values changed that it has."""
    values = friction.values
    new = {name: value for name, value in changed.items() if name in values}
    for name in values:
        stem = name.removesuffix("_pos")
        if stem != name and f"{stem}_neg" in values:
            mean = 0.5 * (values[name] + values[f"{stem}_neg"])
            new |= {name: mean, f"{stem}_neg": mean}
    return friction.with_values(**new) if new else friction


def _of_following(variant: Variant) -> list[Cause]:
    informed = told_the_motion(variant)
    if informed.controller == variant.controller and informed.feedforward == variant.feedforward:
        return []

    def follows(loop: Variant) -> Variant:
        mass = informed.feedforward.mass
        return replace(loop, controller=informed.controller, feedforward=replace(loop.feedforward, mass=mass))

    return [Cause("lag", "velocity or inertia of the desired motion is not fed forward as it is", follows)]


def _of_compensator(variant: Variant) -> list[Cause]:
    if variant.table is not None:
        return []  # what acts on both sides of a screw is no model that could be fed forward instead
    feedforward, true = variant.feedforward, nominal(variant.friction)
    if feedforward.friction is None or feedforward.gain == 0.0:

        def compensated(loop: Variant) -> Variant:
            return replace(loop, feedforward=replace(loop.feedforward, friction=true, gain=1.0))

        return [Cause("no compensation", "the friction is not fed forward", compensated)]
    best = best_gain(variant)

    def right_size(loop: Variant) -> Variant:
        gain = loop.feedforward.gain * best / feedforward.gain
        return replace(loop, feedforward=replace(loop.feedforward, gain=gain))

    def right_shape(loop: Variant) -> Variant:
        return replace(loop, feedforward=replace(loop.feedforward, friction=true, gain=loop.feedforward.gain / best))

    size = f"the compensator is {feedforward.gain / best:.3g} times the nominal friction"
    causes = [Cause("amplitude", size, right_size)] if not math.isclose(feedforward.gain, best, rel_tol=1e-3) else []
    if feedforward.friction != true:
        causes.append(Cause("shape", "the compensator turns otherwise than the friction, at the same size", right_shape))
    return causes


def _of_friction(variant: Variant) -> list[Cause]:
    feedforward, causes = variant.feedforward, []
    sides = [model for model in (variant.friction, variant.table) if model is not None]
    shift = (feedforward.offset, feedforward.asymmetry)
    if shift != (0.0, 0.0) or any(_even(model) != model for model in sides):

        def symmetric(loop: Variant) -> Variant:
            fed = loop.feedforward
            even = replace(fed, friction=_even(fed.friction), offset=0.0, asymmetry=0.0)
            return replace(loop, friction=_even(loop.friction), table=_even(loop.table), feedforward=even)

        text = "friction by direction and offset, less what of both is fed forward"
        causes.append(Cause("asymmetry", text, symmetric))
    scatter = max(model.values.get("scatter", 0.0) for model in sides)
    if scatter > 0.0:

        def regular(loop: Variant) -> Variant:
            return replace(loop, friction=_regular(loop.friction), table=_regular(loop.table))

        text = f"friction that differs by {100.0 * scatter:.2g} % from reversal to reversal"
        causes.append(Cause("irregularity", text, regular))
    return causes


def _even(friction: Any) -> Any:
    return None if friction is None else _alike(friction, {"offset": 0.0})


def _regular(friction: Any) -> Any:
    return friction.with_values(scatter=0.0) if friction is not None and "scatter" in friction.values else friction


def _of_sensor(variant: Variant) -> list[Cause]:
    sensor = variant.sensor
    if sensor.component is not encoder:

        def read_truly(loop: Variant) -> Variant:
            return replace(loop, sensor=encoder(kind=sensor.kind))

        return [Cause(sensor.name, f"what the sensor reads: {sensor.component.description}", read_truly)]
    exact = {name: 0.0 for name in ENCODER if sensor.values[name] > 0.0}
    if not exact:
        return []

    def read_exactly(loop: Variant) -> Variant:
        return replace(loop, sensor=loop.sensor.with_values(**exact))

    return [Cause("encoder", " and ".join(exact) + " of the encoder", read_exactly)]


def _of_delay(variant: Variant) -> list[Cause]:
    if variant.run.delay == 0 and variant.run.current_lag == 0.0:
        return []

    def at_once(loop: Variant) -> Variant:
        return replace(loop, run=replace(loop.run, delay=0, current_lag=0.0))

    return [Cause("delay", "computation and current control", at_once)]


def _of_the_rest(variant: Variant) -> list[Cause]:
    causes = []
    if variant.plant.values.get("backlash", 0.0) > 0.0:

        def tight(loop: Variant) -> Variant:
            return replace(loop, plant=loop.plant.with_values(backlash=0.0))

        causes.append(Cause("backlash", "travel lost at a reversal", tight))
    if variant.disturbance is not None:
        text = "force that no model explains"
        causes.append(Cause("unexplained", text, lambda loop: replace(loop, disturbance=None)))
    return causes
