"""Design of a loop: its limits, its error budget, possible gains, and a simulated circle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bristle.apps.design.budget import Budget, error_budget
from bristle.core import (
    Amount,
    Experiment,
    InputError,
    Kind,
    Progress,
    Status,
    Variable,
    Variant,
    amount,
    compatible,
    convert,
    did_you_mean,
    guarded,
    instance,
    many,
    optional,
    split,
)
from bristle.files import EXPERIMENT
from bristle.models.references import circle
from bristle.simulation import (
    PHASE_ENOUGH,
    UNSTATED,
    Assessment,
    Delays,
    Proposal,
    Verdict,
    antiresonance_of,
    assess,
    delays_of,
    lagging,
    motion_of,
    proposals_for,
    seeded,
    simulate,
    sliding_force,
    top_speed,
    with_two_masses,
)

SAMPLES_LEAST = 400  # in a revolution


@dataclass(frozen=True)
class Design:
    """Analysis of a loop before it is built.

    Parameters
    ----------
    experiment : Experiment
        The loops.
    variant : Variant
        The designed loop.
    assessments : tuple of Assessment
        Poles and margins of each loop of the experiment.
    delays : Delays
        Parts of the delay of the loop.
    friction : float
        Mean friction of both directions at the largest speed of the reference [N or N*m].
    budget : Budget or None
        Error budget; None for a loop that is too unstable to simulate.
    proposals : tuple of Proposal
        The present loop, and alternatives with other gains and laws.
    circles : tuple of Circle
        Simulated circles of the loop without friction compensation, of the present loop, and of the proposal.
    """

    experiment: Experiment
    variant: Variant
    assessments: tuple[Assessment, ...]
    delays: Delays
    friction: float
    budget: Budget | None
    proposals: tuple[Proposal, ...]
    circles: tuple[Circle, ...]

    usual_phase = PHASE_ENOUGH  # smallest usual phase margin [deg]
    unstated_lags = (
        UNSTATED  # assumed lags of an unspecified current loop: smallest and largest [s]
    )

    @property
    def assessment(self) -> Assessment:
        """Poles and margins of the designed loop."""
        return next(
            assessment for assessment in self.assessments if assessment.name == self.variant.name
        )

    @property
    def late(self) -> Assessment | None:
        """Assessment with the largest usual lag of a current loop; None if the experiment states the lag."""
        if self.variant.run.current_lag:
            return None
        return assess(lagging(self.variant, UNSTATED[1]))

    @property
    def antiresonance(self) -> float | None:
        """Antiresonance of the load on its elastic coupling [Hz], which limits the proposed gains; None for one mass."""
        omega = antiresonance_of(with_two_masses(self.variant))
        if math.isinf(omega):
            return None
        return omega / (2.0 * math.pi)

    @property
    def is_stable(self) -> bool:
        """Whether all poles of the designed loop lie inside the unit circle."""
        return self.assessment.is_stable

    @property
    def best(self) -> Proposal | None:
        """Proposal with the smallest error; None without a simulation."""
        simulated = [
            proposal for proposal in self.proposals[1:] if proposal.following_error is not None
        ]
        return min(simulated, key=lambda proposal: proposal.peak_to_peak, default=None)

    @property
    def chosen(self) -> Proposal:
        """Loop to run: the present loop, unless it is unstable or a proposal has a clearly smaller error."""
        present = self.proposals[0]
        best = self.best
        # A smaller gain in error is not worth the lower margins.
        if best is not None and (
            not self.is_stable or best.peak_to_peak < 0.8 * present.peak_to_peak
        ):
            return best
        return present


def _bandwidth(raw: Any, path: str, kind: Kind | None) -> float:
    """Return a bandwidth as an angular frequency [rad/s]; text has the unit Hz or rad/s."""
    if not isinstance(raw, str):
        return amount(Variable("1", "bandwidth [rad/s]", min=0.0), exclusive=True)(raw, path, kind)
    unit = split(raw, path)[1] or "1"
    if compatible(unit, "rad/s", path=path):
        bandwidth = convert(raw, "rad/s")
    else:
        bandwidth = 2.0 * math.pi * convert(raw, "Hz", path=path)
    if not 0.0 < bandwidth < math.inf:
        raise InputError("must be positive", path=path, value=raw, allowed="> 0 Hz")
    return bandwidth


@guarded(experiment=EXPERIMENT, bandwidth=optional(_bandwidth))
def design(
    experiment: Any,
    *,
    variant: str | None = None,
    bandwidth: Amount | None = None,
    progress: Progress | None = None,
) -> Design:
    """Design the loop of an experiment.

    Parameters
    ----------
    experiment : Experiment, path-like, bytes, file object or dict
        The loop, or the file that describes it.
    variant : str, optional
        Name of the variant to design; by default the first with friction feedforward, else the first.
    bandwidth : float or str, optional
        Desired bandwidth of the proposals [rad/s], or text such as ``"30 Hz"``; by default the largest bandwidth that the
        margins allow.
    progress : callable, optional
        Called with the share done and the name of the next step.

    Returns
    -------
    Design
        Poles and margins of each variant; error budget, suggested gains and a circle of the designed variant.

    Raises
    ------
    InputError
        If the variant does not exist, a variant is an open loop, or the bandwidth is not positive.
    """
    chosen = _chosen_variant(experiment, variant)
    if any(entry.effort is not None for entry in experiment.variants):
        raise InputError(
            "drives an open loop, which has no gains",
            path="effort",
            mend="Write [controller] and [reference] into the experiment instead of [effort]",
        )
    assessments = tuple(assess(entry) for entry in experiment.variants)
    runs = (
        next(assessment.verdict for assessment in assessments if assessment.name == chosen.name)
        is not Verdict.DIVERGES
    )
    budget = None
    if runs:
        budget = error_budget(chosen, _part(progress, 0.0, 0.6))
    proposals = proposals_for(
        chosen, bandwidth=bandwidth, simulated=runs, progress=_part(progress, 0.6, 0.85)
    )
    circles = _circles(chosen, proposals, _part(progress, 0.85, 1.0))
    return Design(
        experiment,
        chosen,
        assessments,
        delays_of(chosen),
        _friction_at(chosen, top_speed(chosen)),
        budget,
        proposals,
        circles,
    )


def _chosen_variant(experiment: Experiment, name: str | None) -> Variant:
    """Return the variant of this name; without a name the first with friction feedforward, else the first."""
    by_name = {entry.name: entry for entry in experiment.variants}
    if not by_name:
        raise InputError("has no variants", path="experiment")
    if name is None:
        return next(
            (entry for entry in experiment.variants if entry.feedforward.friction is not None),
            experiment.variants[0],
        )
    if name not in by_name:
        raise InputError(
            "there is no such variant",
            path="variant",
            value=name,
            allowed=", ".join(by_name),
            mend=did_you_mean(name, by_name),
        )
    return by_name[name]


def _circles(
    chosen: Variant, proposals: Sequence[Proposal], progress: Progress | None
) -> tuple[Circle, ...]:
    radius, feed = circle_of(chosen)
    # Skip a circle that is too fast for its samples.
    if (
        radius <= 0.0
        or feed <= 0.0
        or 2.0 * math.pi * radius / feed < SAMPLES_LEAST * chosen.run.sample_time
    ):
        return ()
    plain = replace(
        chosen, name="without compensation", feedforward=replace(chosen.feedforward, friction=None)
    )
    loops = {loop.name: loop for loop in (plain, *(proposal.variant for proposal in proposals))}
    stable = tuple(loop for loop in loops.values() if assess(loop).verdict is not Verdict.DIVERGES)
    if not stable:
        return ()
    return run_circles(stable, radius, feed, progress)


def _friction_at(variant: Variant, speed: float) -> float:
    """Return the mean friction of both directions at a steady speed [m/s or rad/s], in [N or N*m]."""
    if speed <= 0.0:
        return 0.0
    friction = sliding_force(variant.friction, speed)
    screw = variant.plant.component.screw
    if variant.table is None or screw is None:
        return friction
    arm = screw(variant.plant.parameters).arm
    return friction + arm * sliding_force(variant.table, speed * arm)


def _part(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """Return a callback for the progress of a part of the work."""
    if progress is None:
        return None
    return lambda share, text: progress(begin + (end - begin) * share, text)


@dataclass(frozen=True)
class Circle:
    """One revolution of a circle by two axes; arrays of shape (sample,).

    Parameters
    ----------
    variant : str
        Name of the loop.
    radius : float
        Radius of the circle [m or rad].
    feed : float
        Velocity along the circle [m/s or rad/s].
    angle : ndarray
        Angle along the circle, ascending from 0 to 2 pi [rad].
    deviation : ndarray
        Distance of the axes from the centre minus the radius [m or rad].
    """

    variant: str
    radius: float
    feed: float
    angle: np.ndarray
    deviation: np.ndarray

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest deviation [m or rad]."""
        return float(np.ptp(self.deviation))

    @property
    def glitches(self) -> tuple[float, ...]:
        """Peak-to-peak deviation within 30° of each reversal, at 0°, 90°, 180° and 270° [m or rad]."""
        apart = (
            np.abs((self.angle - turn + np.pi) % (2.0 * np.pi) - np.pi)
            for turn in 0.5 * np.pi * np.arange(4)
        )
        return tuple(
            float(np.ptp(self.deviation[distance <= math.radians(30.0)])) for distance in apart
        )


def circle_of(variant: Variant) -> tuple[float, float]:
    """Return radius [m or rad] and feed [m/s or rad/s] of the test circle: those of a circle, or half the travel and the top speed."""
    reference = variant.reference
    if reference.name == "circle":
        return reference.values["radius"], reference.values["feed"]
    return 0.5 * float(np.ptp(motion_of(variant)[0][:-1])), top_speed(variant)


@guarded(
    variants=many(instance(Variant, "an object of class Variant"), least=1),
    radius=amount(Variable("length", "radius of a circle", min=0.0), exclusive=True),
    feed=amount(Variable("length/time", "velocity along a circle", min=0.0), exclusive=True),
)
def run_circles(
    variants: tuple[Variant, ...],
    radius: float,
    feed: float,
    progress: Callable[[float, str], None] | None = None,
) -> tuple[Circle, ...]:
    """Return the simulated circle of each loop, run on two axes.

    The two axes are equal, with independent noise and irregularities.

    Parameters
    ----------
    variants : tuple of Variant
        The loops.
    radius, feed : float
        Radius of the circle [m or rad], and velocity along it [m/s or rad/s].
    progress : callable, optional
        Called with the share done and the name of the next step.
    """
    runs = [_axis(variant, radius, feed, axis) for variant in variants for axis in ("x", "y")]
    result = simulate(Experiment("circle", variants[0].plant.kind, tuple(runs)), progress)
    circles = []
    for variant in variants:
        x, y = (result.variants[f"{variant.name}, {axis}"] for axis in ("x", "y"))
        if Status.NOT_FINITE in (x.status, y.status):
            continue
        count = min(round(2.0 * math.pi * radius / feed / variant.run.sample_time), x.time.size)
        angle = np.arctan2(y.reference[-count:], x.reference[-count:]) % (2.0 * np.pi)
        deviation = np.hypot(x.position[-count:], y.position[-count:]) - radius
        order = np.argsort(angle, kind="stable")
        circles.append(Circle(variant.name, radius, feed, angle[order], deviation[order]))
    return tuple(circles)


def _axis(variant: Variant, radius: float, feed: float, axis: str) -> Variant:
    revolution = 2.0 * math.pi * radius / feed
    run = int(axis == "y")  # the second axis has independent noise
    table = variant.table
    if table is not None:
        table = seeded(table, run)
    return replace(
        variant,
        name=f"{variant.name}, {axis}",
        reference=circle(kind=variant.plant.kind, radius=radius, feed=feed, axis=axis),
        friction=seeded(variant.friction, run),
        table=table,
        sensor=seeded(variant.sensor, run),
        disturbance=None,
        injected=None,
        learning=None,
        run=replace(variant.run, duration=2.0 * revolution, settle=revolution, seeds=1),
    )
