"""Other gains for a loop, and another law: each with its margins, its stiffness and its simulated error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from bristle.core.experiment import Experiment, Variant
from bristle.core.status import Status
from bristle.loop_design.following import told_the_motion
from bristle.loop_design.tuning import UNSTATED, count_response, lagging, stiffness_of, tuned
from bristle.simulation import Statistics, simulate
from bristle.stability import Assessment, Verdict, assess

__all__ = ["Proposal", "proposals_for"]

AS_IT_IS, TUNED, OBSERVER = "as it is", "tuned", "with an observer"
ALONG_DESIRED = "along the desired motion"
RUNS_MAX = 2


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
    judged = {loop.name: assess(_late(loop) if loop.name in bandwidths else loop) for loop in loops}
    runs = min(variant.run.seeds, RUNS_MAX)
    able = tuple(
        replace(loop, run=replace(loop.run, seeds=runs))
        for loop in loops
        if judged[loop.name].verdict is not Verdict.DIVERGES and (simulated or loop.name != AS_IT_IS)
    )
    result = simulate(Experiment(variant.name, variant.plant.kind, able), progress)
    completed = {name: result for name, result in result.variants.items() if result.status is not Status.NOT_FINITE}
    return tuple(
        Proposal(
            loop,
            judged[loop.name],
            bandwidths.get(loop.name),
            stiffness_of(loop.controller, loop.run.sample_time),
            count_response(loop),
            completed[loop.name].following_error if loop.name in completed else None,
            completed[loop.name].effort_rms if loop.name in completed else None,
        )
        for loop in loops
    )


def _late(loop: Variant) -> Variant:
    """Return a loop with the largest lag of a current loop that nobody stated."""
    return loop if loop.run.current_lag else lagging(loop, UNSTATED[1])


def _loops(variant: Variant, bandwidth: float | None) -> tuple[list[Variant], dict[str, float]]:
    """Return the loop as it is and those proposed, and the bandwidth of each of these by name."""
    loops, bandwidths = [replace(variant, name=AS_IT_IS)], {}
    desired = replace(variant, feedforward=replace(variant.feedforward, along="desired"), learning=None)
    if variant.feedforward.along != "desired":
        loops.append(replace(desired, name=ALONG_DESIRED))
    laws = {TUNED: variant.controller.name, OBSERVER: "disturbance_observer"}
    if laws[TUNED] == laws[OBSERVER]:
        del laws[OBSERVER]
    for name, law in laws.items():
        tuning = tuned(variant, law, bandwidth)
        if tuning is not None and tuning.law != variant.controller:
            loops.append(told_the_motion(replace(desired, name=name, controller=tuning.law)))
            bandwidths[name] = tuning.bandwidth
    return loops, bandwidths
