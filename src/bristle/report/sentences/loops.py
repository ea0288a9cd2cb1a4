"""Sentences about a loop before its simulation."""

from collections.abc import Mapping
from typing import Any

from bristle.report.sentences.sentence import Sentence, says

WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
CAUSES = {
    "falling_friction": "friction falls with velocity at the speed of the reference, so the axis sticks and slips",
    "stiffness_taken": "friction feedforward along the measured motion removes more stiffness than the axis has",
    "stuck": "at rest, friction adds its stiffness to the loop, and the total gain is too high for the delay",
    "delay": "{delay:samples} of delay",
    "gains": "gains too high for the sample time",
    "none": "unknown, because no smaller gain stabilises the loop",
}
MENDS = {
    "raise_gains": "Raise the gains, or add friction feedforward",
    "feed_desired": "Base the feedforward on the desired motion",
}
SUSPECTS = {
    "k_p": "a position gain of {factor:3 digits} times the value in the axis file",
    "k_ff": "k_ff = {factor:3 digits}, the share of the reference velocity that the drive feeds forward",
    "position": "a scale of position (gear, lead, counts) of {factor:3 digits} times the value in the axis file",
    "effort": "a scale of effort (torque or force constant) of {factor:3 digits} times the value in the axis file",
    "delay": "a delay of {factor:samples} in the loop",
    "reference_later": "a reference that acts {factor:time} later than recorded",
    "reference_earlier": "a reference that acts {factor:time} earlier than recorded",
}
SIZES = {"all": "", "small": "for small motions ", "large": "for large motions "}
ENDS = {"small": "Small motions grow until they are large, and never settle"}
REASONS = ("motions", "why", "mend", "delay", "longest_delay", "largest_gain_percent")
SETTLES_NOT = "The loop never settles"


def counted(samples: int) -> str:
    """Return a number of samples in words.

    Examples
    --------
    >>> counted(1), counted(3), counted(12)
    ('one sample', 'three samples', '12 samples')
    """
    word = WORDS[samples] if samples < len(WORDS) else str(samples)
    return f"{word} sample{'' if samples == 1 else 's'}"


def _mend(numbers: Mapping[str, Any]) -> str:
    if "mend" in numbers:
        return MENDS[numbers["mend"]]
    ways = []
    if "longest_delay" in numbers:
        ways.append(
            f"with {'at most ' if numbers['longest_delay'] else ''}{{longest_delay:samples}} of delay"
        )
    if "largest_gain_percent" in numbers:
        ways.append("with its gains lowered to {largest_gain_percent:2 digits} % or less")
    return f"The loop is stable {' or '.join(ways)}" if ways else "Check the signs of the gains"


def _contradicts(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    errors = texts[0] if "simulated" in numbers else texts[1]
    ways = [
        SUSPECTS[name].replace("{factor", f"{{factors[{place}]")
        for place, name in enumerate(numbers["suspects"])
    ]
    return errors + (texts[2] + " or ".join(ways) if ways else texts[3])


LOOPS: dict[str, Sentence] = {
    "loop_stable": says(
        "the sampled loop is stable: its largest pole is at {radius:4 digits}", "the loop is stable"
    ),
    "loop_diverges": Sentence(
        ("unstable, not simulated: the sampled loop has a pole at {radius:4 digits}",),
        "the loop is unstable, so bristle does not simulate it. `why` states the cause",
        "lower the delay or the gains as suggested",
        choose=lambda texts, numbers: (
            f"{texts[0]}. Cause: {CAUSES[numbers['why']]}. {_mend(numbers)}"
        ),
        also=REASONS,
    ),
    "loop_oscillates": Sentence(
        ("the sampled loop has a pole at {radius:4 digits}",),
        "the loop never settles. `why` states the cause",
        "lower the delay or the gains as suggested",
        choose=lambda texts, numbers: (
            f"oscillates: {SIZES[numbers['motions']]}{texts[0]}. Cause: {CAUSES[numbers['why']]}. "
            f"{ENDS.get(numbers['motions'], SETTLES_NOT)}. {_mend(numbers)}"
        ),
        also=REASONS,
    ),
    "switching_law": says(
        "the control law chatters around rest: its effort jumps at every change of direction, however small. Add a boundary layer",
        "the effort of the control law jumps at rest",
        "add a boundary layer",
    ),
    "stiffness_taken": says(
        "friction feedforward along the measured motion raises the error at these low gains. It removes {taken:stiffness of an axis} of "
        "the total stiffness of {whole:stiffness of an axis}, and the control law adds only {law:stiffness of an axis}. Base the "
        "feedforward on the desired motion",
        "friction feedforward along the measured motion removes stiffness",
        "base the feedforward on the desired motion",
    ),
    "loop_contradicts": Sentence(
        (
            "the simulated loop does not match the log. Its following error is {simulated:length} peak to peak and {simulated_rms:length} "
            "root mean square, but {measured:length} and {measured_rms:length} in the log",
            "the simulated loop runs away, and the recorded loop does not. The recorded following error is {measured:length} peak to peak "
            "and {measured_rms:length} root mean square",
            ". The loop would match with ",
            ". No single wrong gain, velocity feedforward, scale, delay or shift of the reference explains the mismatch. Check the drive "
            "for filters, feedforward of inertia or friction, or another control law",
        ),
        "the simulated loop does not match the log, so bristle predicts no gain. Each of `suspects` alone would explain the mismatch, with "
        "the value in `factors` (a delay in samples, a shift of the reference in seconds)",
        "correct the suspected value in the axis file",
        choose=_contradicts,
        also=("suspects", "factors"),
    ),
    "small_margin": Sentence(
        (
            "the phase margin is only {phase:2 digits}° (usual: {enough:g}° or more)",
            ", and {gain:3 digits} times the gain makes the loop unstable",
        ),
        "the loop has small margins",
        "lower the gains",
        choose=lambda texts, numbers: (
            f"{SIZES[numbers['motions']]}{texts[0]}{texts[1] if 'gain' in numbers else ''}. The loop rings near its crossover frequency"
        ),
        also=("motions",),
    ),
    "another_rig": says(
        "the friction model of its compensator was identified on a different friction. A model identified on the friction of this loop "
        "would give another error",
        "the compensator was identified on a friction other than that of the loop",
        "identify the compensator on the friction of this loop",
    ),
}
