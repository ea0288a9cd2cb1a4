r"""Assessment of a loop before its simulation: poles decide on refusal, margins on warnings.

A law can respond differently to small and large motions (inside and outside a boundary layer). Friction is a spring
while the axis sticks and a damper while the axis slides. Each combination is a linear loop, a `WorkingPoint`.

While the axis sticks, friction of stiffness :math:`s` acts in parallel to the stiffness :math:`K` of the law. A
compensator of `c` times this friction along the measured motion subtracts :math:`c\,s`. The remaining stiffness
stabilises the axis only if :math:`K > (c - 1)\,s`. A compensator along the desired motion subtracts no stiffness.
"""

import itertools
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from bristle.core import Experiment, Feedforward, Variant, cached_property, guarded
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.variable import Kind
from bristle.simulation import linear_system as linear
from bristle.simulation.linear_system import (
    GAIN_ENOUGH,
    PHASE_ENOUGH,
    Margins,
    SampledLoop,
    margins_of,
)

FINER = 0.98  # ratio of successive trial gains
GAINS = 400  # trial gains at most


class Motions(StrEnum):
    """Size of the motions for which a law was linearised."""

    ALL = "all"
    SMALL = "small"
    LARGE = "large"


class Friction(StrEnum):
    """Action of friction at a working point."""

    NONE = "none"
    STUCK = "stuck"
    SLIDING = "sliding"


class Verdict(StrEnum):
    """Verdict of the poles: all inside the unit circle; outside for small motions only; outside for all motions."""

    STABLE = "stable"
    OSCILLATES = "oscillates"
    DIVERGES = "diverges"


class Stiffness(NamedTuple):
    """Stiffness of a stuck axis [N/m or N*m/rad]: of the law, of friction before break-away, and of the compensator (subtracted)."""

    law: float
    friction: float
    compensation: float

    @property
    def left(self) -> float:
        """Stiffness of law and friction minus that of the compensator [N/m or N*m/rad]."""
        return self.law + self.friction - self.compensation


@dataclass(frozen=True)
class WorkingPoint:
    """A loop linearised for one size of motion and one friction: none, stuck or sliding."""

    motions: Motions
    friction: Friction
    loop: SampledLoop

    @cached_property
    def margins(self) -> Margins:
        """Phase and gain margin of the loop."""
        return margins_of(self.loop)


@dataclass(frozen=True)
class Assessment:
    """Results of the linear loops of a variant.

    Parameters
    ----------
    name : str
        Name of the variant.
    kind : {"translational", "rotational"}
        The kind of axis.
    points : tuple of WorkingPoint
        The linear loops.
    switches : bool
        Whether the law switches at rest. Such a law has no slope there, and no linear loop for small motions.
    stiffness : Stiffness or None
        Stiffness of a stuck axis, if the loop feeds friction forward along the measured motion.
    """

    name: str
    kind: Kind
    points: tuple[WorkingPoint, ...]
    switches: bool = False
    stiffness: Stiffness | None = None

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the loop is stable, oscillates within bounds, or diverges."""
        # A growing oscillation becomes a large motion: if the loop for large motions is stable, the growth ends.
        # A loop that only friction destabilises (by falling with velocity) sticks and slips; friction can also stabilise a loop.
        large = [
            point.loop.is_unstable for point in self.points if point.motions is not Motions.SMALL
        ]
        if large and all(large):
            return Verdict.DIVERGES
        if any(point.loop.is_unstable for point in self.points):
            return Verdict.OSCILLATES
        return Verdict.STABLE

    @property
    def is_stable(self) -> bool:
        """Whether all poles lie inside the unit circle."""
        return self.verdict is Verdict.STABLE

    @property
    def bare(self) -> tuple[WorkingPoint, ...]:
        """Working points without friction: law, inertia and delays only."""
        return tuple(point for point in self.points if point.friction is Friction.NONE)

    @property
    def worst(self) -> WorkingPoint:
        """Working point with the largest pole: among those without friction if one of them is unstable, else among all."""
        among = self.points
        if any(point.loop.is_unstable for point in self.bare):
            among = self.bare
        return max(among, key=lambda point: point.loop.spectral_radius)

    @property
    def least_phase(self) -> float | None:
        """Smallest phase margin of the working points without friction [°]; None without a crossover."""
        return min(
            (point.margins.phase for point in self.bare if point.margins.phase is not None),
            default=None,
        )

    @property
    def finding(self) -> Diagnostic:
        """Verdict on the loop; for an unstable loop also the cause of its largest pole, and the limits of delay and gain."""
        worst = self.worst
        numbers: dict[str, Number] = {"radius": worst.loop.spectral_radius}
        if self.is_stable:
            return Diagnostic("loop_stable", severity="note", numbers=numbers, kind=self.kind)
        numbers |= {"motions": worst.motions.value, "delay": worst.loop.delay, **_cause_of(self)}
        code = "loop_oscillates"
        if self.verdict is Verdict.DIVERGES:
            code = "loop_diverges"
        return Diagnostic(code, severity="error", numbers=numbers, kind=self.kind)

    @property
    def doubts(self) -> tuple[Diagnostic, ...]:
        """Warnings about a stable loop: stiffness lost by compensation, small margins, a switching law."""
        diagnostics = []
        if self.switches:
            diagnostics.append(Diagnostic("switching_law"))
        held = self.stiffness
        if held is not None and held.left < 0.5 * (held.law + held.friction):
            taken = {"taken": held.compensation, "whole": held.law + held.friction, "law": held.law}
            diagnostics.append(Diagnostic("stiffness_taken", numbers=taken, kind=self.kind))
        bare = [point for point in self.bare if not point.loop.is_unstable]
        margins = [
            (point.margins.phase, point.margins.gain, point.motions.value)
            for point in bare
            if point.margins.phase is not None
        ]
        phase, gain, motions = min(
            margins, key=lambda margin: margin[0], default=(PHASE_ENOUGH, None, "")
        )
        if phase < PHASE_ENOUGH or (gain is not None and gain < GAIN_ENOUGH):
            numbers: dict[str, Number] = {
                "motions": motions,
                "phase": phase,
                "enough": PHASE_ENOUGH,
            }
            if gain is not None:
                numbers["gain"] = gain
            diagnostics.append(Diagnostic("small_margin", numbers=numbers))
        return tuple(diagnostics)


@guarded()
def assess(variant: Variant) -> Assessment:
    """Return the assessment of the linear loops of a variant.

    Parameters
    ----------
    variant : Variant
        The loop. The assessment treats its sensor as exact, because encoder counts and noise have no slope, and its
        backlash as closed.

    Returns
    -------
    Assessment
        Poles and margins at each working point, and a verdict.
    """
    run = variant.run
    laws, switches = _laws(variant)
    feedback = _feedback_of(variant.feedforward, run.sample_time)
    points = []
    stiffness = None
    for motions, law in laws.items():
        amplitude = linear.SMALL if motions is Motions.SMALL else linear.LARGE
        for name, frictions in _frictions(variant, motions).items():
            plant = linear.linear_plant(variant, amplitude, *frictions)
            combined = law
            if name is Friction.STUCK and feedback is not None:
                fed, compensation = feedback
                stiffness = Stiffness(
                    min(map(law_stiffness, laws.values())), frictions[0].k, compensation
                )
                combined = law.beside(fed)
            points.append(
                WorkingPoint(
                    motions, name, SampledLoop(plant, combined, run.delay, run.sample_time)
                )
            )
    return Assessment(variant.name, variant.plant.kind, tuple(points), switches, stiffness)


def _laws(variant: Variant) -> tuple[dict[Motions, linear.LinearSystem], bool]:
    """Return the law for each size of motion, and whether it switches."""
    amplitudes = (0.1 * linear.SMALL, linear.SMALL, linear.LARGE, 10.0 * linear.LARGE)
    smallest, small, large, larger = (
        linear.linear_law(variant.controller, variant.run.sample_time, size) for size in amplitudes
    )
    # A slope that falls below half its value at ten times the amplitude vanishes for large motions.
    A, B, C, D = (
        np.where(np.abs(b) < 0.5 * np.abs(a), 0.0, a) for a, b in zip(large, larger, strict=True)
    )
    large = linear.LinearSystem(A, B, C, float(D))
    if _alike(small, large, linear.SAME):
        return {Motions.ALL: large}, False
    if not _alike(small, smallest, linear.ALIKE):
        return {Motions.LARGE: large}, True
    return {Motions.SMALL: small, Motions.LARGE: large}, False


def _alike(first: linear.LinearSystem, second: linear.LinearSystem, tolerance: float) -> bool:
    return all(
        np.allclose(a, b, rtol=tolerance, atol=0.0) for a, b in zip(first, second, strict=True)
    )


def _frictions(
    variant: Variant, motions: Motions
) -> dict[Friction, tuple[linear.LinearFriction, linear.LinearFriction]]:
    """Return the friction at the port of the plant and at its table, for each working point."""
    frictions = {Friction.NONE: (linear.NO_FRICTION, linear.NO_FRICTION)}
    dt = variant.run.sample_time
    screw = variant.plant.component.screw
    stuck = linear.stiffness_at_rest(variant.friction, dt)
    behind = (
        linear.NO_FRICTION if variant.table is None else linear.stiffness_at_rest(variant.table, dt)
    )
    if (
        motions is not Motions.LARGE
        and stuck is not None
        and behind is not None
        and max(stuck.k, behind.k) > 0.0
    ):
        frictions[Friction.STUCK] = (stuck, behind)
    speed = top_speed(variant)
    if speed > 0.0:
        sliding = linear.slope_in_sliding(variant.friction, speed)
        behind = linear.NO_FRICTION
        if variant.table is not None and screw is not None:
            behind = linear.slope_in_sliding(
                variant.table, speed * screw(variant.plant.parameters).arm
            )
        frictions[Friction.SLIDING] = (sliding, behind)
    return frictions


def motion_of(variant: Variant) -> tuple[np.ndarray, np.ndarray]:
    """Return position [m or rad] and velocity of the reference, at each sample and at the end."""
    run = variant.run
    t = run.sample_time * np.arange(round(run.duration / run.sample_time) + 1)
    return variant.reference.component.sample(t, variant.reference.parameters)[:2]


def top_speed(variant: Variant) -> float:
    """Return the largest velocity of the reference [m/s or rad/s]."""
    return float(np.max(np.abs(motion_of(variant)[1][:-1]), initial=0.0))


def law_stiffness(law: linear.LinearSystem) -> float:
    """Return the effort of a law for a constant deviation [N/m or N*m/rad], infinite with an integral."""
    # A law without an integral has equal responses there.
    slow = np.abs(law.response(np.exp(1j * np.array([1e-7, 1e-6]))))
    if slow[0] > 2.0 * slow[1]:
        return float("inf")
    return float(slow[0])


def _feedback_of(feedforward: Feedforward, dt: float) -> tuple[linear.LinearSystem, float] | None:
    """Return the feedback by friction compensation along the measured motion, and its stiffness; None without it."""
    if feedforward.friction is None or feedforward.along != "measured":
        return None
    stuck = linear.stiffness_at_rest(feedforward.friction, dt)
    if stuck is None:
        return None
    # Mean force over the last sample, from the previous position to the present one.
    spring = 0.5 * feedforward.gain * stuck.k
    damper = feedforward.gain * stuck.c / dt
    return linear.LinearSystem(
        np.zeros((1, 1)), np.ones(1), np.array([spring - damper]), spring + damper
    ), 2.0 * spring


@guarded()
def runnable(experiment: Experiment) -> tuple[Experiment, dict[str, Assessment]]:
    """Return the experiment without the variants whose loop diverges, and the assessment of each closed loop."""
    judged = {
        variant.name: assess(variant) for variant in experiment.variants if variant.effort is None
    }
    diverging = {
        name for name, assessment in judged.items() if assessment.verdict is Verdict.DIVERGES
    }
    return replace(
        experiment,
        variants=tuple(variant for variant in experiment.variants if variant.name not in diverging),
    ), judged


def _cause_of(assessment: Assessment) -> dict[str, Number]:
    """Return the cause of the largest pole, and the largest delay and gain of a stable loop."""
    worst = assessment.worst
    held = assessment.stiffness
    if worst.friction is Friction.SLIDING:
        return {"why": "falling_friction", "mend": "raise_gains"}
    no_time_left = held is not None and held.left <= 0.0
    if no_time_left and worst.friction is Friction.STUCK:
        return {"why": "stiffness_taken", "mend": "feed_desired"}
    numbers: dict[str, Number] = {}
    if no_time_left:
        numbers["mend"] = "feed_desired"
    loops = [
        point.loop
        for point in assessment.points
        if point.friction in (Friction.NONE, worst.friction)
    ]
    # From the shortest delay up: each sample of delay adds a state, and poles of many states take long.
    delay = max(
        itertools.takewhile(lambda delay: _are_stable(loops, delay=delay), range(worst.loop.delay)),
        default=None,
    )
    gain = next(
        (FINER**power for power in range(1, GAINS) if _are_stable(loops, gain=FINER**power)), None
    )
    if delay is not None:
        numbers["longest_delay"] = delay
    if gain is not None:
        numbers["largest_gain_percent"] = 100.0 * gain
    if worst.friction is Friction.STUCK:
        return {"why": "stuck", **numbers}
    if delay is not None:
        return {"why": "delay", **numbers}
    if gain is not None:
        return {"why": "gains", **numbers}
    return {"why": "none", **numbers}


def _are_stable(loops: list[SampledLoop], *, delay: int | None = None, gain: float = 1.0) -> bool:
    """Return whether loops are stable with another delay [samples], or a law multiplied by `gain`."""
    if delay is not None:
        loops = [replace(loop, delay=delay) for loop in loops]
    return not any(loop.with_gain(gain).is_unstable for loop in loops)
