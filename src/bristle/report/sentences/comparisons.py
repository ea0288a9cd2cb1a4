"""What there is to know of two logs that are held against each other."""

from __future__ import annotations

from bristle.report.sentences.sentence import Sentence, says

__all__ = ["COMPARISONS"]

COMPARISONS: dict[str, Sentence] = {
    "no_reference": says(
        "no reference {sides:and}: nothing is said of the following error, and motions are told alike by the measured position",
        "a log has no reference, so that nothing tells its following error",
        "record the reference, and name its column in the axis file",
    ),
    "no_effort": says(
        "no effort {sides:and}: nothing is said of effort and friction",
        "a log has no effort",
        "record the effort, and name its column in the axis file",
    ),
    "motions_differ": says(
        "the motions differ: {before_percent:3 digits} % of that before and {after_percent:3 digits} % of that after "
        "are in both, and only these are compared",
        "two logs share only a part of their motion",
        "record both with the same reference",
    ),
    "pieces_for_cycles": says(
        "there are not two whole cycles of each side: pieces of the motion stand for them, and intervals tell how the "
        "change differs along the motion",
        "the motion does not go to and fro often enough for cycles",
        "record ten cycles or more, to and fro",
    ),
    "few_cycles": says(
        "one side has only {cycles} cycles: intervals are wide, and rest on these showing how cycles scatter",
        "few cycles tell how much they scatter",
        "record ten cycles or more",
    ),
    "cycles_identical": says(
        "the cycles of a quantity are the same to the last digits, as in a simulation without noise: its interval "
        "tells nothing of a machine",
        "cycles do not scatter, so that an interval has no width",
        "record the machine itself",
    ),
    "no_interval": says(
        "one cycle tells no scatter, so that no change has an interval", "a log is too short for intervals", "record ten cycles or more"
    ),
    "cycles_alike": says(
        "neighbouring cycles are alike, as while an axis warms up: {cycles:2 digits} of them count as one",
        "cycles are not independent of their neighbours, and intervals are wider for it",
        "record after the axis has warmed up",
    ),
    "friction_not_told": Sentence(
        ("friction is not told: no speed is reached often enough in both directions of both logs", "{why}"),
        "a log tells no friction",
        "record a motion to and fro, over more than ten samples for each period of the cut-off",
        choose=lambda texts, numbers: f"friction is not told: {texts[1]}" if numbers["why"] else texts[0],
    ),
    "sample_times_differ": says(
        "the logs were sampled differently: of each, a sample about every {longest:time} is taken",
        "logs of different sample times are compared at the longest",
    ),
    "one_recording": says(
        "a side has one log: what differs from one recording to the next without any change, as temperature does, is in no interval",
        "intervals tell scatter from cycle to cycle, not from recording to recording",
        "record each side several times, and give all of its logs",
    ),
}
