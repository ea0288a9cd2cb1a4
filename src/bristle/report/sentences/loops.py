"""What there is to know of a loop before it is simulated."""

from collections.abc import Mapping
from typing import Any

from bristle.report.sentences.sentence import Sentence, says

WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
CAUSES = {
    "falling_friction": "friction falls with velocity at the speed of the reference, and the axis sticks and slips",
    "stiffness_taken": "friction fed forward along the measured motion takes away more stiffness than the axis has",
    "stuck": "stuck, the axis is held by the friction as well, and the gain of both is too high for the delay",
    "delay": "{delay:samples} of delay",
    "gains": "gains too high for the sample time",
    "none": "no gain below this one stabilises it",
}
MENDS = {"raise_gains": "Raise the gains or feed the friction forward", "feed_desired": "Feed it forward along the desired motion"}
SUSPECTS = {
    "k_p": "the position gain {factor:3 digits} times as large as the axis file says",
    "k_ff": "k_ff = {factor:3 digits}, the share of the reference velocity that the drive feeds forward",
    "position": "a scale of position (gear, lead, counts) of {factor:3 digits} times what the axis file says",
    "effort": "a scale of effort (torque or force constant) of {factor:3 digits} times what the axis file says",
    "delay": "a delay of {factor:samples} in the loop",
    "reference_later": "a reference that acts {factor:time} later than it is recorded",
    "reference_earlier": "a reference that acts {factor:time} earlier than it is recorded",
}
SIZES = {"all": "", "small": "for small motions ", "large": "for large motions "}
ENDS = {"small": "What is a small motion grows until it is a large one, and never settles"}
REASONS = ("motions", "why", "mend", "delay", "longest_delay", "largest_gain_percent")
SETTLES_NOT = "It does not settle there"


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
        ways.append("with {longest_delay:samples} of delay" + (" at most" if numbers["longest_delay"] else ""))
    if "largest_gain_percent" in numbers:
        ways.append("with its gains at {largest_gain_percent:2 digits} % at most")
    return f"It is stable {' or '.join(ways)}" if ways else "Look at the signs of its gains"


def _contradicts(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    errors = texts[0] if "simulated" in numbers else texts[1]
    ways = [SUSPECTS[name].replace("{factor", f"{{factors[{place}]") for place, name in enumerate(numbers["suspects"])]
    return errors + (texts[2] + " or ".join(ways) if ways else texts[3])


LOOPS: dict[str, Sentence] = {
    "loop_stable": says("the sampled loop is stable: its largest pole is at {radius:4 digits}", "the loop is stable"),
    "loop_diverges": Sentence(
        ("unstable, not simulated: the sampled loop has a pole at {radius:4 digits}",),
        "the loop runs away, for the reason `why`",
        "lower the delay or the gains, as told",
        choose=lambda texts, numbers: f"{texts[0]}: {CAUSES[numbers['why']]}. {_mend(numbers)}",
        also=REASONS,
    ),
    "loop_oscillates": Sentence(
        ("the sampled loop has a pole at {radius:4 digits}",),
        "the loop does not settle, for the reason `why`",
        "lower the delay or the gains, as told",
        choose=lambda texts, numbers: (
            f"oscillates: {SIZES[numbers['motions']]}{texts[0]}: {CAUSES[numbers['why']]}. "
            f"{ENDS.get(numbers['motions'], SETTLES_NOT)}. {_mend(numbers)}"
        ),
        also=REASONS,
    ),
    "switching_law": says(
        "the law has no slope at rest: it answers however small a motion with a jump of the effort, and chatters "
        "around rest. A boundary layer ends that",
        "the control law switches",
        "give it a boundary layer",
    ),
    "stiffness_taken": says(
        "friction is fed forward along the measured motion, and takes {taken:stiffness of an axis} of the "
        "{whole:stiffness of an axis} that hold the axis, of which the law itself has no more than "
        "{law:stiffness of an axis}: at gains this low it raises the error. Feed it forward along the desired motion",
        "friction fed forward along the measured motion takes stiffness away",
        "feed it forward along the desired motion",
    ),
    "loop_contradicts": Sentence(
        (
            "the simulated loop does not follow as the axis did: its following error is {simulated:length} peak to "
            "peak and {simulated_rms:length} root mean square, the log has {measured:length} and {measured_rms:length}",
            "the simulated loop runs away, and the axis did not: its following error was {measured:length} peak to "
            "peak and {measured_rms:length} root mean square",
            ". It would follow as recorded with ",
            ". No one number explains it: neither the position gain, nor the velocity fed forward, nor a scale of "
            "position or effort, nor a delay, nor a reference recorded too early or late. Look at what else the drive "
            "does: filters, inertia or friction fed forward there, another law",
        ),
        "the loop follows otherwise in simulation than in the log, so that no gain is promised; `suspects` are what "
        "explains it with one number each, `factors` these numbers (a delay in samples, a reference in seconds)",
        "correct that number in the axis file",
        choose=_contradicts,
        also=("suspects", "factors"),
    ),
    "small_margin": Sentence(
        ("the phase margin is {phase:2 digits}° (at least {enough:g}° is usual)", ", {gain:3 digits} times the gain makes it unstable"),
        "the margins of the loop are small",
        "lower the gains",
        choose=lambda texts, numbers: (
            f"{SIZES[numbers['motions']]}{texts[0]}{texts[1] if 'gain' in numbers else ''}: what excites the loop near its crossover rings"
        ),
        also=("motions",),
    ),
    "another_rig": says(
        "its compensator was identified on another friction than the one here: what it reaches is not what a model "
        "identified on this one would",
        "a compensator was identified on another friction",
        "identify it on this one",
    ),
}
