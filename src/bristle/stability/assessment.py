"""The loop of an experiment judged before it is simulated: poles decide what is refused, margins what is warned of.

A law may answer small motions otherwise than large ones (inside and outside a boundary layer), and friction is a spring
where the axis is stuck and a damper where it slides. Each combination is one linear loop, a `WorkingPoint`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from bristle.core.experiment import Variant
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind
from bristle.stability.linear_friction import NO_FRICTION, LinearFriction, slope_in_sliding, stiffness_at_rest
from bristle.stability.linear_plant import linear_plant
from bristle.stability.linear_system import LARGE, SMALL, LinearSystem, linear_law
from bristle.stability.margins import Margins, margins_of
from bristle.stability.measured_feedforward import Stiffness, feedback_of
from bristle.stability.sampled_loop import SampledLoop

__all__ = ["Assessment", "Friction", "Motions", "Verdict", "WorkingPoint", "assess", "top_speed"]

LAW_TOLERANCE = 1e-6  # relative difference of laws that are one law
SWITCHING = 1e-3  # relative change, over a decade of amplitude, of a law that has no slope at rest


class Motions(StrEnum):
    """Which motions a law was linearised for."""

    ALL = "all"
    SMALL = "small"
    LARGE = "large"


class Friction(StrEnum):
    """What friction does at a working point."""

    NONE = "none"
    STUCK = "stuck"
    SLIDING = "sliding"


class Verdict(StrEnum):
    """What the poles say: all inside the unit circle; outside it for small motions only; outside however large."""

    STABLE = "stable"
    OSCILLATES = "oscillates"
    DIVERGES = "diverges"


@dataclass(frozen=True)
class WorkingPoint:
    """A loop linearised for these motions, under this friction."""

    motions: Motions
    friction: Friction
    loop: SampledLoop

    @cached_property
    def margins(self) -> Margins:
        """How far it is from instability."""
        return margins_of(self.loop)


@dataclass(frozen=True)
class Assessment:
    """What the linear loops of one variant say.

    Parameters
    ----------
    name : str
        Of the variant.
    kind : {"translational", "rotational"}
        The kind of axis.
    points : tuple of WorkingPoint
        The linear loops.
    switches : bool
        Whether the law has no slope at rest: it switches, and for small motions there is no linear loop.
    stiffness : Stiffness or None
        What holds a stuck axis, where friction is fed forward along the measured motion.
    """

    name: str
    kind: Kind
    points: tuple[WorkingPoint, ...]
    switches: bool = False
    stiffness: Stiffness | None = None

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the loop is stable, oscillates within bounds, or diverges."""
        # As an oscillation grows, the loop becomes that of large motions: where this one is stable, the growth ends.
        # One that friction alone upsets (by falling with velocity) sticks and slips; one that it settles is settled.
        large = [point.loop.is_unstable for point in self.points if point.motions is not Motions.SMALL]
        if large and all(large):
            return Verdict.DIVERGES
        return Verdict.OSCILLATES if any(point.loop.is_unstable for point in self.points) else Verdict.STABLE

    @property
    def bare(self) -> tuple[WorkingPoint, ...]:
        """The working points without friction: what the law, the inertia and the delays do by themselves."""
        return tuple(point for point in self.points if point.friction is Friction.NONE)

    @property
    def worst(self) -> WorkingPoint:
        """The working point with the largest pole: one without friction where that is unstable, else any."""
        among = self.bare if any(point.loop.is_unstable for point in self.bare) else self.points
        return max(among, key=lambda point: point.loop.spectral_radius)


def assess(variant: Variant) -> Assessment:
    """Return what the linear loops of a variant say.

    Parameters
    ----------
    variant : Variant
        The loop. Its sensor is taken for exact, because counts and noise have no slope, and a backlash for closed.

    Returns
    -------
    Assessment
        Poles and margins at each working point, and a verdict.
    """
    run = variant.run
    laws, switches = _laws(variant)
    feedback = feedback_of(variant.feedforward, run.sample_time)
    points, stiffness = [], None
    for motions, law in laws.items():
        amplitude = SMALL if motions is Motions.SMALL else LARGE
        for name, frictions in _frictions(variant, motions).items():
            plant = linear_plant(variant, amplitude, *frictions)
            combined = law
            if name is Friction.STUCK and feedback is not None:
                fed, compensation = feedback
                stiffness = Stiffness.of(min(laws.values(), key=_stiffness), frictions[0].k, compensation)
                combined = law.beside(fed)
            points.append(WorkingPoint(motions, name, SampledLoop(plant, combined, run.delay, run.sample_time)))
    return Assessment(variant.name, variant.plant.kind, tuple(points), switches, stiffness)


def _stiffness(law: LinearSystem) -> float:
    return Stiffness.of(law, 0.0, 0.0).law


def _laws(variant: Variant) -> tuple[dict[Motions, LinearSystem], bool]:
    dt = variant.run.sample_time
    smallest, small = (linear_law(variant.controller, dt, amplitude) for amplitude in (0.1 * SMALL, SMALL))
    large, larger = (linear_law(variant.controller, dt, amplitude) for amplitude in (LARGE, 10.0 * LARGE))
    large = large.without_what_fades(larger)
    if small.is_like(large, LAW_TOLERANCE):
        return {Motions.ALL: large}, False
    if not small.is_like(smallest, SWITCHING):
        return {Motions.LARGE: large}, True
    return {Motions.SMALL: small, Motions.LARGE: large}, False


def _frictions(variant: Variant, motions: Motions) -> dict[Friction, tuple[LinearFriction, LinearFriction]]:
    """Return what acts on the port of the plant and on its table at each working point."""
    frictions = {Friction.NONE: (NO_FRICTION, NO_FRICTION)}
    dt, screw = variant.run.sample_time, variant.plant.component.screw
    stuck = stiffness_at_rest(variant.friction, dt)
    behind = NO_FRICTION if variant.table is None else stiffness_at_rest(variant.table, dt)
    if motions is not Motions.LARGE and stuck is not None and behind is not None and max(stuck.k, behind.k) > 0.0:
        frictions[Friction.STUCK] = (stuck, behind)
    speed = top_speed(variant)
    if speed > 0.0:
        sliding, behind = slope_in_sliding(variant.friction, speed), NO_FRICTION
        if variant.table is not None and screw is not None:
            behind = slope_in_sliding(variant.table, speed * screw(variant.plant.parameters).arm)
        frictions[Friction.SLIDING] = (sliding, behind)
    return frictions


def top_speed(variant: Variant) -> float:
    """Return the largest velocity that the reference asks for [m/s or rad/s]."""
    run = variant.run
    t = run.sample_time * np.arange(round(run.duration / run.sample_time))
    _, velocity, _ = variant.reference.component.sample(t, variant.reference.parameters)
    return float(np.max(np.abs(velocity), initial=0.0))
