"""What poles and margins mean, with what to change, as codes and numbers."""

from __future__ import annotations

from dataclasses import replace

from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.experiment import Experiment
from bristle.stability.assessment import Assessment, Friction, Motions, Verdict, WorkingPoint, assess

__all__ = ["doubts_of", "runnable", "verdict_of"]

PHASE_ENOUGH, GAIN_ENOUGH = 30.0, 2.0  # [deg], and a factor: what is usual as the least of both
MOSTLY = 0.5  # share of the stiffness below which what is left is little
FINER = 0.98  # from one gain that is tried to the next
GAINS = 400
MOTIONS_IN_WORDS = {Motions.ALL: "all", Motions.SMALL: "small", Motions.LARGE: "large"}


def runnable(experiment: Experiment) -> tuple[Experiment, dict[str, Assessment]]:
    """Return the experiment without the variants whose loop diverges, and what the loop of each variant says.

    An open loop says nothing.
    """
    judged = {variant.name: assess(variant) for variant in experiment.variants if variant.effort is None}
    diverging = {name for name, assessment in judged.items() if assessment.verdict is Verdict.DIVERGES}
    bounded = tuple(variant for variant in experiment.variants if variant.name not in diverging)
    return replace(experiment, variants=bounded), judged


def verdict_of(assessment: Assessment) -> Diagnostic:
    """Return the verdict on a loop; of one that is unstable with what puts its pole there, and what would help."""
    worst = assessment.worst
    numbers: dict[str, Number] = {"radius": worst.loop.spectral_radius}
    if assessment.verdict is Verdict.STABLE:
        return Diagnostic("loop_stable", severity="note", numbers=numbers, kind=assessment.kind)
    diverges = assessment.verdict is Verdict.DIVERGES
    numbers |= {"motions": MOTIONS_IN_WORDS[worst.motions], "delay": worst.loop.delay, **_cause_of(assessment)}
    if diverges:
        return Diagnostic("loop_diverges", severity="error", numbers=numbers, kind=assessment.kind)
    return Diagnostic("loop_oscillates", severity="error", numbers=numbers, kind=assessment.kind)


def doubts_of(assessment: Assessment) -> tuple[Diagnostic, ...]:
    """Return what to know of a loop that is stable: margins that are small, a law that switches."""
    diagnostics = [Diagnostic("switching_law")] if assessment.switches else []
    held = assessment.stiffness
    if held is not None and held.left < MOSTLY * (held.law + held.friction):
        numbers = {"taken": held.compensation, "whole": held.law + held.friction, "law": held.law}
        diagnostics.append(Diagnostic("stiffness_taken", numbers=numbers, kind=assessment.kind))
    bare = [assessed for assessed in assessment.bare if not assessed.loop.is_unstable and assessed.margins.phase is not None]
    least = min(bare, key=lambda assessed: assessed.margins.phase or 0.0, default=None)
    if least is None or least.margins.phase is None:
        return tuple(diagnostics)
    phase, gain = least.margins.phase, least.margins.gain
    if phase < PHASE_ENOUGH or (gain is not None and gain < GAIN_ENOUGH):
        margins: dict[str, Number] = {"motions": MOTIONS_IN_WORDS[least.motions], "phase": phase, "enough": PHASE_ENOUGH}
        diagnostics.append(Diagnostic("small_margin", numbers=margins if gain is None else {**margins, "gain": gain}))
    return tuple(diagnostics)


def _cause_of(assessment: Assessment) -> dict[str, Number]:
    """Return what puts the largest pole where it is, and up to which delay and gain the loop would be stable."""
    worst, held = assessment.worst, assessment.stiffness
    if worst.friction is Friction.SLIDING:
        return {"why": "falling_friction", "mend": "raise_gains"}
    no_time_left = held is not None and held.left <= 0.0
    if no_time_left and worst.friction is Friction.STUCK:
        return {"why": "stiffness_taken", "mend": "feed_desired"}
    numbers: dict[str, Number] = {"mend": "feed_desired"} if no_time_left else {}
    delay, gain = _longest_delay(assessment), _largest_gain(assessment)
    numbers |= {"longest_delay": delay} if delay is not None else {}
    numbers |= {"largest_gain_percent": 100.0 * gain} if gain is not None else {}
    if worst.friction is Friction.STUCK:
        return {"why": "stuck", **numbers}
    return {"why": "delay" if delay is not None else "gains" if gain is not None else "none", **numbers}


def _loops(assessment: Assessment) -> list[WorkingPoint]:
    worst = assessment.worst
    return [point for point in assessment.points if point.friction in (Friction.NONE, worst.friction)]


def _longest_delay(assessment: Assessment) -> int | None:
    """Return the longest delay, below the present one, up to which the loop is stable."""
    loops = [point.loop for point in _loops(assessment)]
    # From the shortest one on: each sample of delay is one more state, and the poles of many take long.
    unstable = (delay for delay in range(loops[0].delay) if any(replace(loop, delay=delay).is_unstable for loop in loops))
    longest = next(unstable, loops[0].delay) - 1
    return longest if longest >= 0 else None


def _largest_gain(assessment: Assessment) -> float | None:
    """Return the largest factor below 1 on the gains with which the loop is stable."""
    loops = [point.loop for point in _loops(assessment)]
    gains = (FINER**power for power in range(1, GAINS))
    return next((gain for gain in gains if not any(loop.with_gain(gain).is_unstable for loop in loops)), None)
