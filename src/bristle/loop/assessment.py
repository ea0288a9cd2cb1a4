r"""The loop of an experiment judged before it is simulated: poles decide what is refused, margins what is warned of.

A law may answer small motions otherwise than large ones (inside and outside a boundary layer), and friction is a spring
where the axis is stuck and a damper where it slides. Each combination is one linear loop, a `WorkingPoint`.

Where the axis is stuck, friction of stiffness :math:`s` holds it beside the stiffness :math:`K` of the law. A
compensator of `c` times this friction that follows the measured motion takes :math:`c\,s` away again: what is left
holds the axis only if :math:`K > (c - 1)\,s`. Along the desired motion nothing is taken away.
"""

import itertools
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.experiment import Experiment, Feedforward, Variant
from bristle.core.lazy import cached_property
from bristle.core.variable import Kind
from bristle.loop import linear_system as linear
from bristle.loop.linear_system import GAIN_ENOUGH, PHASE_ENOUGH, Margins, SampledLoop, margins_of

FINER, GAINS = 0.98, 400  # from one gain that is tried to the next, and how many are


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


class Stiffness(NamedTuple):
    """What holds a stuck axis [N/m or N*m/rad]: the law, friction that has not broken away, less what is fed forward."""

    law: float
    friction: float
    compensation: float

    @property
    def left(self) -> float:
        """What holds the axis after all."""
        return self.law + self.friction - self.compensation


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
    def is_stable(self) -> bool:
        """Whether all poles lie inside the unit circle."""
        return self.verdict is Verdict.STABLE

    @property
    def bare(self) -> tuple[WorkingPoint, ...]:
        """The working points without friction: what the law, the inertia and the delays do by themselves."""
        return tuple(point for point in self.points if point.friction is Friction.NONE)

    @property
    def worst(self) -> WorkingPoint:
        """The working point with the largest pole: one without friction where that is unstable, else any."""
        among = self.bare if any(point.loop.is_unstable for point in self.bare) else self.points
        return max(among, key=lambda point: point.loop.spectral_radius)

    @property
    def least_phase(self) -> float | None:
        """Smallest phase margin without friction [°]; None where there is no crossover."""
        return min((point.margins.phase for point in self.bare if point.margins.phase is not None), default=None)

    @property
    def finding(self) -> Diagnostic:
        """The verdict on the loop; of an unstable one with the cause of its largest pole, and the limits of delay and gain."""
        worst = self.worst
        numbers: dict[str, Number] = {"radius": worst.loop.spectral_radius}
        if self.is_stable:
            return Diagnostic("loop_stable", severity="note", numbers=numbers, kind=self.kind)
        numbers |= {"motions": worst.motions.value, "delay": worst.loop.delay, **_cause_of(self)}
        code = "loop_diverges" if self.verdict is Verdict.DIVERGES else "loop_oscillates"
        return Diagnostic(code, severity="error", numbers=numbers, kind=self.kind)

    @property
    def doubts(self) -> tuple[Diagnostic, ...]:
        """Doubts about a stable loop: stiffness that compensation takes away, small margins, a law that switches."""
        diagnostics = [Diagnostic("switching_law")] if self.switches else []
        held = self.stiffness
        if held is not None and held.left < 0.5 * (held.law + held.friction):
            taken = {"taken": held.compensation, "whole": held.law + held.friction, "law": held.law}
            diagnostics.append(Diagnostic("stiffness_taken", numbers=taken, kind=self.kind))
        bare = [point for point in self.bare if not point.loop.is_unstable]
        margins = [(point.margins.phase, point.margins.gain, point.motions.value) for point in bare if point.margins.phase is not None]
        phase, gain, motions = min(margins, key=lambda margin: margin[0], default=(PHASE_ENOUGH, None, ""))
        if phase < PHASE_ENOUGH or (gain is not None and gain < GAIN_ENOUGH):
            numbers: dict[str, Number] = {"motions": motions, "phase": phase, "enough": PHASE_ENOUGH}
            diagnostics.append(Diagnostic("small_margin", numbers=numbers if gain is None else {**numbers, "gain": gain}))
        return tuple(diagnostics)


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
    feedback = _feedback_of(variant.feedforward, run.sample_time)
    points, stiffness = [], None
    for motions, law in laws.items():
        amplitude = linear.SMALL if motions is Motions.SMALL else linear.LARGE
        for name, frictions in _frictions(variant, motions).items():
            plant = linear.linear_plant(variant, amplitude, *frictions)
            combined = law
            if name is Friction.STUCK and feedback is not None:
                fed, compensation = feedback
                stiffness = Stiffness(min(map(law_stiffness, laws.values())), frictions[0].k, compensation)
                combined = law.beside(fed)
            points.append(WorkingPoint(motions, name, SampledLoop(plant, combined, run.delay, run.sample_time)))
    return Assessment(variant.name, variant.plant.kind, tuple(points), switches, stiffness)


def _laws(variant: Variant) -> tuple[dict[Motions, linear.LinearSystem], bool]:
    """Return the law for each size of motion, and whether it switches."""
    amplitudes = (0.1 * linear.SMALL, linear.SMALL, linear.LARGE, 10.0 * linear.LARGE)
    smallest, small, large, larger = (linear.linear_law(variant.controller, variant.run.sample_time, size) for size in amplitudes)
    # A number that is less than half as large at ten times the amplitude fades.
    A, B, C, D = (np.where(np.abs(b) < 0.5 * np.abs(a), 0.0, a) for a, b in zip(large, larger, strict=True))
    large = linear.LinearSystem(A, B, C, float(D))
    if _alike(small, large, linear.SAME):
        return {Motions.ALL: large}, False
    if not _alike(small, smallest, linear.ALIKE):
        return {Motions.LARGE: large}, True
    return {Motions.SMALL: small, Motions.LARGE: large}, False


def _alike(first: linear.LinearSystem, second: linear.LinearSystem, tolerance: float) -> bool:
    return all(np.allclose(a, b, rtol=tolerance, atol=0.0) for a, b in zip(first, second, strict=True))


def _frictions(variant: Variant, motions: Motions) -> dict[Friction, tuple[linear.LinearFriction, linear.LinearFriction]]:
    """Return what acts on the port of the plant and on its table at each working point."""
    frictions = {Friction.NONE: (linear.NO_FRICTION, linear.NO_FRICTION)}
    dt, screw = variant.run.sample_time, variant.plant.component.screw
    stuck = linear.stiffness_at_rest(variant.friction, dt)
    behind = linear.NO_FRICTION if variant.table is None else linear.stiffness_at_rest(variant.table, dt)
    if motions is not Motions.LARGE and stuck is not None and behind is not None and max(stuck.k, behind.k) > 0.0:
        frictions[Friction.STUCK] = (stuck, behind)
    speed = top_speed(variant)
    if speed > 0.0:
        sliding, behind = linear.slope_in_sliding(variant.friction, speed), linear.NO_FRICTION
        if variant.table is not None and screw is not None:
            behind = linear.slope_in_sliding(variant.table, speed * screw(variant.plant.parameters).arm)
        frictions[Friction.SLIDING] = (sliding, behind)
    return frictions


def motion_of(variant: Variant) -> tuple[np.ndarray, np.ndarray]:
    """Return position [m or rad] and velocity that the reference asks for, at each sample and at the end."""
    run = variant.run
    t = run.sample_time * np.arange(round(run.duration / run.sample_time) + 1)
    return variant.reference.component.sample(t, variant.reference.parameters)[:2]


def top_speed(variant: Variant) -> float:
    """Return the largest velocity that the reference asks for [m/s or rad/s]."""
    return float(np.max(np.abs(motion_of(variant)[1][:-1]), initial=0.0))


def law_stiffness(law: linear.LinearSystem) -> float:
    """Return the effort of a law over a deviation that lasts [N/m or N*m/rad], without end with an integral."""
    slow = np.abs(law.response(np.exp(1j * np.array([1e-7, 1e-6]))))  # a law without an integral answers alike there
    return float("inf") if slow[0] > 2.0 * slow[1] else float(slow[0])


def _feedback_of(feedforward: Feedforward, dt: float) -> tuple[linear.LinearSystem, float] | None:
    """Return what friction fed forward along the measured motion feeds back, and its stiffness; None where it has none."""
    friction = feedforward.friction if feedforward.along == "measured" else None
    stuck = None if friction is None else linear.stiffness_at_rest(friction, dt)
    if stuck is None:
        return None
    # The mean force over the last sample, from the position before it to the present one.
    spring, damper = 0.5 * feedforward.gain * stuck.k, feedforward.gain * stuck.c / dt
    return linear.LinearSystem(np.zeros((1, 1)), np.ones(1), np.array([spring - damper]), spring + damper), 2.0 * spring


def runnable(experiment: Experiment) -> tuple[Experiment, dict[str, Assessment]]:
    """Return the experiment without the variants whose loop diverges, and what the loop of each variant says.

    An open loop says nothing.
    """
    judged = {variant.name: assess(variant) for variant in experiment.variants if variant.effort is None}
    diverging = {name for name, assessment in judged.items() if assessment.verdict is Verdict.DIVERGES}
    return replace(experiment, variants=tuple(variant for variant in experiment.variants if variant.name not in diverging)), judged


def _cause_of(assessment: Assessment) -> dict[str, Number]:
    """Return what puts the largest pole where it is, and up to which delay and gain the loop would be stable."""
    worst, held = assessment.worst, assessment.stiffness
    if worst.friction is Friction.SLIDING:
        return {"why": "falling_friction", "mend": "raise_gains"}
    no_time_left = held is not None and held.left <= 0.0
    if no_time_left and worst.friction is Friction.STUCK:
        return {"why": "stiffness_taken", "mend": "feed_desired"}
    numbers: dict[str, Number] = {"mend": "feed_desired"} if no_time_left else {}
    loops = [point.loop for point in assessment.points if point.friction in (Friction.NONE, worst.friction)]
    # From the shortest delay on: each sample of delay is one more state, and the poles of many take long.
    delay = max(itertools.takewhile(lambda delay: _are_stable(loops, delay=delay), range(worst.loop.delay)), default=None)
    gain = next((FINER**power for power in range(1, GAINS) if _are_stable(loops, gain=FINER**power)), None)
    numbers |= {"longest_delay": delay} if delay is not None else {}
    numbers |= {"largest_gain_percent": 100.0 * gain} if gain is not None else {}
    if worst.friction is Friction.STUCK:
        return {"why": "stuck", **numbers}
    return {"why": "delay" if delay is not None else "gains" if gain is not None else "none", **numbers}


def _are_stable(loops: list[SampledLoop], *, delay: int | None = None, gain: float = 1.0) -> bool:
    """Return whether loops are stable with another delay [samples], or a law that answers `gain` times as strongly."""
    changed = (replace(loop, delay=loop.delay if delay is None else delay) for loop in loops)
    return not any(loop.with_gain(gain).is_unstable for loop in changed)
