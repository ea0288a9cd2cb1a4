"""A loop designed: what limits it, what it errs by, which gains it allows, and the circle that it runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from bristle.core.edge import PROGRESS, TEXT, Amount, amount, guarded, optional
from bristle.core.errors import InputError, did_you_mean
from bristle.core.experiment import Experiment, Variant
from bristle.core.units import compatible, convert, split
from bristle.core.variable import Kind, Variable
from bristle.files.arguments import EXPERIMENT
from bristle.loop.assessment import Assessment, Verdict, assess, top_speed
from bristle.loop.budget import Budget, error_budget
from bristle.loop.circle import Circle, circle_of, is_sampled, run_circles
from bristle.loop.linear_system import sliding_force
from bristle.loop.proposals import Proposal, proposals_for
from bristle.loop.tuning import UNSTATED, Delays, delays_of, lagging

__all__ = ["Design", "design"]

Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Design:
    """What there is to know of a loop before it is built.

    Parameters
    ----------
    experiment : Experiment
        The loops.
    variant : Variant
        The one that was designed.
    assessments : tuple of Assessment
        Poles and margins of each loop of the experiment.
    delays : Delays
        Where the delay of the loop comes from.
    friction : float
        At the largest speed of the reference, the mean of both directions [N or N*m].
    budget : Budget or None
        What it errs by; None for a loop that is not stable enough to be simulated.
    proposals : tuple of Proposal
        The loop as it is, and other gains and laws for it.
    circles : tuple of Circle
        A circle, by the loop without friction compensation, as it is, and as proposed.
    """

    experiment: Experiment
    variant: Variant
    assessments: tuple[Assessment, ...]
    delays: Delays
    friction: float
    budget: Budget | None
    proposals: tuple[Proposal, ...]
    circles: tuple[Circle, ...]

    @property
    def assessment(self) -> Assessment:
        """Poles and margins of the loop that was designed."""
        return next(assessment for assessment in self.assessments if assessment.name == self.variant.name)

    @property
    def late(self) -> Assessment | None:
        """The loop as it is with the largest lag of a current loop that nobody stated; None where a lag is stated."""
        return None if self.variant.run.current_lag else assess(lagging(self.variant, UNSTATED[1]))

    @property
    def is_stable(self) -> bool:
        """Whether all poles of the loop that was designed lie inside the unit circle."""
        return self.assessment.verdict is Verdict.STABLE


def _bandwidth(raw: Any, path: str, kind: Kind | None) -> float:
    """Return a bandwidth as an angular frequency [rad/s]; text says it in Hz or rad/s."""
    if not isinstance(raw, str):
        return amount(Variable("1", "bandwidth [rad/s]", min=0.0), exclusive=True)(raw, path, kind)
    angular = compatible(split(raw, path)[1] or "1", "rad/s", path=path)
    bandwidth = convert(raw, "rad/s") if angular else 2.0 * math.pi * convert(raw, "Hz", path=path)
    if not 0.0 < bandwidth < math.inf:
        raise InputError("must be positive", path=path, value=raw, allowed="> 0 Hz")
    return bandwidth


@guarded(experiment=EXPERIMENT, variant=optional(TEXT), bandwidth=optional(_bandwidth), progress=PROGRESS)
def design(experiment: Any, *, variant: str | None = None, bandwidth: Amount | None = None, progress: Progress | None = None) -> Design:
    """Design the loop of an experiment.

    Parameters
    ----------
    experiment : Experiment, path-like, bytes, file object or dict
        The loop, or the file that describes it.
    variant : str, optional
        Name of the variant to be designed; by default the first one that feeds friction forward, else the first one.
    bandwidth : float or str, optional
        Bandwidth wanted of what is proposed [rad/s], or text such as ``"30 Hz"``; by default as much as the margins
        allow.
    progress : callable, optional
        Called with the share done and the name of what comes next.

    Returns
    -------
    Design
        Poles and margins of each variant; of one of them the error budget, suggested gains, and a circle.

    Raises
    ------
    InputError
        If there is no such variant, one is an open loop, or the bandwidth is not positive.
    """
    chosen = _chosen(experiment.variants, variant)
    if any(entry.effort is not None for entry in experiment.variants):
        raise InputError("drives an open loop, which has no gains", path="effort", mend="Write [controller] and [reference] instead")
    assessments = tuple(assess(variant) for variant in experiment.variants)
    runs = next(assessment.verdict for assessment in assessments if assessment.name == chosen.name) is not Verdict.DIVERGES
    budget = error_budget(chosen, _part(progress, 0.0, 0.6)) if runs else None
    proposals = proposals_for(chosen, bandwidth=bandwidth, simulated=runs, progress=_part(progress, 0.6, 0.85))
    circles = _circles(chosen, proposals, _part(progress, 0.85, 1.0))
    return Design(experiment, chosen, assessments, delays_of(chosen), _friction_at(chosen, top_speed(chosen)), budget, proposals, circles)


def _chosen(variants: Sequence[Variant], name: str | None) -> Variant:
    if not variants:
        raise InputError("has no variants", path="experiment")
    if name is None:
        return next((variant for variant in variants if variant.feedforward.friction is not None), variants[0])
    by_name = {variant.name: variant for variant in variants}
    if name not in by_name:
        raise InputError(
            "there is no such variant", path="variant", value=name, allowed=", ".join(by_name), mend=did_you_mean(name, by_name)
        )
    return by_name[name]


def _circles(chosen: Variant, proposals: Sequence[Proposal], progress: Progress | None) -> tuple[Circle, ...]:
    radius, feed = circle_of(chosen)
    if radius <= 0.0 or feed <= 0.0 or not is_sampled(chosen, radius, feed):
        return ()
    plain = replace(chosen, name="without compensation", feedforward=replace(chosen.feedforward, friction=None))
    loops = {loop.name: loop for loop in (plain, *(proposal.variant for proposal in proposals))}
    stable = tuple(loop for loop in loops.values() if assess(loop).verdict is not Verdict.DIVERGES)
    return run_circles(stable, radius, feed, progress) if stable else ()


def _friction_at(variant: Variant, speed: float) -> float:
    """Return the friction at a steady speed [m/s or rad/s], the mean of both directions [N or N*m]."""
    if speed <= 0.0:
        return 0.0
    friction, screw = sliding_force(variant.friction, speed), variant.plant.component.screw
    if variant.table is None or screw is None:
        return friction
    arm = screw(variant.plant.parameters).arm
    return friction + arm * sliding_force(variant.table, speed * arm)


def _part(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """Return what reports the progress of a part of the work."""
    if progress is None:
        return None
    return lambda share, text: progress(begin + (end - begin) * share, text)
