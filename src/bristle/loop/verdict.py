"""What poles and margins mean, with what to change, as codes and numbers."""

from __future__ import annotations

import itertools
from dataclasses import replace

from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.experiment import Experiment
from bristle.loop.assessment import Assessment, Friction, Verdict, assess
from bristle.loop.sampled_loop import GAIN_ENOUGH, PHASE_ENOUGH, SampledLoop

__all__ = ["PHASE_ENOUGH", "doubts_of", "runnable", "verdict_of"]

FINER, GAINS = 0.98, 400  # from one gain that is tried to the next, and how many are


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
    numbers |= {"motions": worst.motions.value, "delay": worst.loop.delay, **_cause_of(assessment)}
    code = "loop_diverges" if assessment.verdict is Verdict.DIVERGES else "loop_oscillates"
    return Diagnostic(code, severity="error", numbers=numbers, kind=assessment.kind)


def doubts_of(assessment: Assessment) -> tuple[Diagnostic, ...]:
    """Return what to know of a loop that is stable: margins that are small, a law that switches."""
    diagnostics = [Diagnostic("switching_law")] if assessment.switches else []
    held = assessment.stiffness
    if held is not None and held.left < 0.5 * (held.law + held.friction):
        taken = {"taken": held.compensation, "whole": held.law + held.friction, "law": held.law}
        diagnostics.append(Diagnostic("stiffness_taken", numbers=taken, kind=assessment.kind))
    bare = [point for point in assessment.bare if not point.loop.is_unstable]
    margins = [(point.margins.phase, point.margins.gain, point.motions.value) for point in bare if point.margins.phase is not None]
    phase, gain, motions = min(margins, key=lambda margin: margin[0], default=(PHASE_ENOUGH, None, ""))
    if phase < PHASE_ENOUGH or (gain is not None and gain < GAIN_ENOUGH):
        numbers: dict[str, Number] = {"motions": motions, "phase": phase, "enough": PHASE_ENOUGH}
        diagnostics.append(Diagnostic("small_margin", numbers=numbers if gain is None else {**numbers, "gain": gain}))
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
    loops = [point.loop for point in assessment.points if point.friction in (Friction.NONE, worst.friction)]
    # From the shortest delay on: each sample of delay is one more state, and the poles of many take long.
    delays = itertools.takewhile(lambda delay: _are_stable(loops, delay=delay), range(worst.loop.delay))
    delay = max(delays, default=None)
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
