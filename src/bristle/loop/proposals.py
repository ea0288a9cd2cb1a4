"""Other gains for a loop, and another law: each with its margins, its stiffness and its simulated error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.loop.assessment import Assessment, Verdict, assess
from bristle.loop.budget import RUNS_MAX
from bristle.loop.tuning import UNSTATED, count_response, lagging, stiffness_of, told_the_motion, tuned
from bristle.simulation import Statistics, simulate

__all__ = ["Proposal", "proposals_for"]

AS_IT_IS, TUNED, OBSERVER = "as it is", "tuned", "with an observer"
ALONG_DESIRED = "along the desired motion"


@dataclass(frozen=True)
class Proposal:
    """A loop that is proposed.

    Parameters
    ----------
    variant : Variant
        The loop, under the name of the proposal.
    assessment : Assessment
        Its poles and margins; with the largest lag of a current loop where none is stated and gains are proposed.
    bandwidth : float or None
        What its gains follow from [rad/s]; None for the loop as it is.
    stiffness : float
        Effort over a deviation that lasts [N/m or N*m/rad].
    count_effort : float
        Effort that one count of the encoder calls up, at its peak [N or N*m].
    following_error : Statistics or None
        Simulated [m or rad]; None where it was not, or diverged.
    effort_rms : float or None
        Of the effort [N or N*m].
    """

    variant: Variant
    assessment: Assessment
    bandwidth: float | None
    stiffness: float
    count_effort: float
    following_error: Statistics | None
    effort_rms: float | None

    @property
    def name(self) -> str:
        """What the proposal is called."""
        return self.variant.name


def proposals_for(
    variant: Variant, *, bandwidth: float | None = None, simulated: bool = True, progress: Callable[[float, str], None] | None = None
) -> tuple[Proposal, ...]:
    """Return the loop as it is and others in its place, the ones that would not diverge simulated.

    Parameters
    ----------
    variant : Variant
        The loop.
    bandwidth : float, optional
        Bandwidth wanted of what is proposed [rad/s]; by default as much as the margins allow.
    simulated : bool
        Whether the loop as it is can be simulated.
    progress : callable, optional
        Called with the share done and the name of what comes next.
    """
    loops, bandwidths = _loops(variant, bandwidth)
    # Gains are proposed for the largest lag of a current loop that nobody stated.
    judged = {
        name: assess(loop if loop.run.current_lag or name not in bandwidths else lagging(loop, UNSTATED[1])) for name, loop in loops.items()
    }
    runs = min(variant.run.seeds, RUNS_MAX)
    able = tuple(
        replace(loop, run=replace(loop.run, seeds=runs))
        for name, loop in loops.items()
        if judged[name].verdict is not Verdict.DIVERGES and (simulated or name != AS_IT_IS)
    )
    outcomes = simulate(Experiment(variant.name, variant.plant.kind, able), progress).variants
    proposals = []
    for name, loop in loops.items():
        outcome = outcomes.get(name)
        completed = None if outcome is None or outcome.status is Status.NOT_FINITE else outcome
        proposal = Proposal(
            loop,
            judged[name],
            bandwidths.get(name),
            stiffness_of(loop.controller, loop.run.sample_time),
            count_response(loop),
            completed and completed.following_error,
            completed and completed.effort_rms,
        )
        proposals.append(proposal)
    return tuple(proposals)


def _loops(variant: Variant, bandwidth: float | None) -> tuple[dict[str, Variant], dict[str, float]]:
    """Return the loop as it is and those proposed by name, and the bandwidths of these."""
    desired = replace(variant, feedforward=replace(variant.feedforward, along="desired"), learning=None)
    loops, bandwidths = {AS_IT_IS: variant}, {}
    if variant.feedforward.along != "desired":
        loops[ALONG_DESIRED] = desired
    laws = {TUNED: variant.controller.name, OBSERVER: "disturbance_observer"}
    for name, law in laws.items():
        tuning = None if name == OBSERVER and law == laws[TUNED] else tuned(variant, law, bandwidth)
        if tuning is not None and tuning.law != variant.controller:
            loops[name], bandwidths[name] = told_the_motion(replace(desired, controller=tuning.law)), tuning.bandwidth
    return {name: replace(loop, name=name) for name, loop in loops.items()}, bandwidths
