"""What poles and margins mean, in words, with what to change."""

from __future__ import annotations

from dataclasses import replace

from bristle.core.experiment import Experiment
from bristle.core.typography import number
from bristle.core.variable import Kind
from bristle.stability.assessment import Assessment, Friction, Motions, Verdict, WorkingPoint, assess
from bristle.stability.measured_feedforward import Stiffness

__all__ = ["remarks", "runnable", "sentence", "stiffness_text"]

PHASE_ENOUGH, GAIN_ENOUGH = 30.0, 2.0  # [deg], and a factor: what is usual as the least of both
MOSTLY = 0.5  # share of the stiffness below which what is left is little
FINER = 0.98  # from one gain that is tried to the next
GAINS = 400
WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
MOTION_WORDS = {Motions.ALL: "", Motions.SMALL: "for small motions ", Motions.LARGE: "for large motions "}


def runnable(experiment: Experiment) -> tuple[Experiment, dict[str, Assessment]]:
    """Return the experiment without the variants whose loop diverges, and what the loop of each variant says."""
    judged = {variant.name: assess(variant) for variant in experiment.variants}
    bounded = tuple(variant for variant in experiment.variants if judged[variant.name].verdict is not Verdict.DIVERGES)
    return replace(experiment, variants=bounded), judged


def sentence(assessment: Assessment) -> str:
    """Return the verdict on a loop in words.

    One that is unstable is named with its pole, what puts the pole there, and what to change.
    """
    if assessment.verdict is Verdict.STABLE:
        return "the sampled loop is stable: " + _largest(assessment.worst)
    if assessment.verdict is Verdict.DIVERGES:
        return f"unstable, not simulated: the sampled loop has a pole at {_pole(assessment)}. {_mend(assessment)}"
    motions = MOTION_WORDS[assessment.worst.motions]
    end = (
        "What is a small motion grows until it is a large one, and never settles"
        if assessment.worst.motions is Motions.SMALL
        else "It does not settle there"
    )
    return f"oscillates: {motions}the sampled loop has a pole at {_pole(assessment)}. {end}. {_mend(assessment)}"


def remarks(assessment: Assessment) -> list[str]:
    """Return what to know of a loop that is stable: margins that are small, a law that switches."""
    lines = []
    if assessment.switches:
        lines.append(
            "the law has no slope at rest: it answers however small a motion with a jump of the effort, and chatters "
            "around rest. A boundary layer ends that"
        )
    stiffness = assessment.stiffness
    if stiffness is not None and stiffness.left < MOSTLY * (stiffness.law + stiffness.friction):
        lines.append(_compensation_text(stiffness, assessment.kind))
    bare = [point for point in assessment.bare if not point.loop.is_unstable and point.margins.phase is not None]
    least = min(bare, key=lambda point: point.margins.phase or 0.0, default=None)
    if least is None or least.margins.phase is None:
        return lines
    phase, gain = least.margins.phase, least.margins.gain
    if phase < PHASE_ENOUGH or (gain is not None and gain < GAIN_ENOUGH):
        limit = "" if gain is None else f", {number(gain, digits=3)} times the gain makes it unstable"
        lines.append(
            f"{MOTION_WORDS[least.motions]}the phase margin is {number(phase, digits=2)}° (at least {PHASE_ENOUGH:g}° "
            f"is usual){limit}: what excites the loop near its crossover rings"
        )
    return lines


def stiffness_text(stiffness: float, kind: Kind) -> str:
    """Return a stiffness [N/m or N*m/rad] as it is told of an axis: in N/µm or N·m/rad.

    Examples
    --------
    >>> stiffness_text(23.08e6, "translational"), stiffness_text(36.0, "rotational")
    ('23.1 N/µm', '36.0 N·m/rad')
    """
    factor, unit = (1e-6, "N/µm") if kind == "translational" else (1.0, "N·m/rad")
    return f"{number(factor * stiffness, digits=3)} {unit}"


def _compensation_text(stiffness: Stiffness, kind: Kind) -> str:
    values = (stiffness.compensation, stiffness.law + stiffness.friction, stiffness.law)
    compensation, total, law = (stiffness_text(value, kind) for value in values)
    return (
        f"friction is fed forward along the measured motion, and takes {compensation} of the {total} that hold the "
        f"axis, of which the law itself has no more than {law}: at gains this low it raises the error. Feed it "
        "forward along the desired motion"
    )


def _largest(point: WorkingPoint) -> str:
    return f"its largest pole is at {number(point.loop.spectral_radius)}"


def _pole(assessment: Assessment) -> str:
    """Return the size of the largest pole, and what puts it there."""
    worst = assessment.worst
    return f"{number(worst.loop.spectral_radius)}: {_cause(assessment)}"


def _cause(assessment: Assessment) -> str:
    worst = assessment.worst
    if worst.friction is Friction.SLIDING:
        return "friction falls with velocity at the speed of the reference, and the axis sticks and slips"
    stiffness = assessment.stiffness
    if worst.friction is Friction.STUCK and stiffness is not None and stiffness.left <= 0.0:
        return "friction fed forward along the measured motion takes away more stiffness than the axis has"
    if worst.friction is Friction.STUCK:
        return "stuck, the axis is held by the friction as well, and the gain of both is too high for the delay"
    if _longest_delay(assessment) is not None:
        delay = worst.loop.delay
        return f"{_count(delay)} of delay"
    return "gains too high for the sample time" if _largest_gain(assessment) else "no gain below this one stabilises it"


def _mend(assessment: Assessment) -> str:
    if assessment.worst.friction is Friction.SLIDING:
        return "Raise the gains or feed the friction forward"
    stiffness = assessment.stiffness
    if stiffness is not None and stiffness.left <= 0.0:
        return "Feed it forward along the desired motion"
    delay, gain = _longest_delay(assessment), _largest_gain(assessment)
    ways = []
    if delay is not None:
        ways.append(f"with {_count(delay)} of delay{' at most' if delay else ''}")
    if gain is not None:
        ways.append(f"with its gains at {number(100.0 * gain, digits=2)} % at most")
    if not ways:
        return "Look at the signs of its gains"
    return f"It is stable {' or '.join(ways)}"


def _count(samples: int) -> str:
    word = WORDS[samples] if samples < len(WORDS) else str(samples)
    return f"{word} sample{'' if samples == 1 else 's'}"


def _loops(assessment: Assessment) -> list[WorkingPoint]:
    worst = assessment.worst
    return [point for point in assessment.points if point.friction in (Friction.NONE, worst.friction)]


def _longest_delay(assessment: Assessment) -> int | None:
    """Return the longest delay, below the present one, up to which the loop is stable."""
    loops = [point.loop for point in _loops(assessment)]
    # From the shortest one on: each sample of delay is one more state, and the poles of many take long.
    unstable = (delay for delay in range(loops[0].delay)
                if any(replace(loop, delay=delay).is_unstable for loop in loops))  # fmt: skip
    longest = next(unstable, loops[0].delay) - 1
    return longest if longest >= 0 else None


def _largest_gain(assessment: Assessment) -> float | None:
    """Return the largest factor below 1 on the gains with which the loop is stable."""
    loops = [point.loop for point in _loops(assessment)]
    gains = (FINER**power for power in range(1, GAINS))
    return next((gain for gain in gains if not any(loop.with_gain(gain).is_unstable for loop in loops)), None)
