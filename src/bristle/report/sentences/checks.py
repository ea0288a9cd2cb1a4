"""What a log says against itself before anything is fitted, and of two logs that are held against each other; how to mend it."""

from collections.abc import Mapping
from typing import Any

from bristle.core import with_unit
from bristle.report.sentences.sentence import Sentence, says, where

_SPEEDS = "move at several steady speeds between a tenth and all of the working speed"


def _named(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text, with the parameters that it concerns behind it where a fit names them."""
    return texts[0] + (texts[1] if "names" in numbers else "")


def _alike(numbers: Mapping[str, Any]) -> bool:
    """Return whether the slowest and the fastest speed are told alike."""
    return with_unit(numbers["slowest"], "m/s") == with_unit(numbers["fastest"], "m/s")


def _resampled(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    own, even, effort, behind = texts
    return own if "column" in numbers else even + (effort if "effort_error" in numbers else "") + behind


def _with_names(first: str, names: str, means: str, advice: str) -> Sentence:
    return Sentence((first, names), means, advice, choose=_named)


CHECKS: dict[str, Sentence] = {
    "rows_lost": says(
        "the position jumps by up to {step:length} within a sample, first after t = {time:.6g} s, {places} such "
        "places in all, which the velocity around does not explain: rows were lost and the rest stamped again, or a "
        "counter began anew. Mend the stamps or cut the log there",
        "rows are missing though the stamps go on, or a counter wrapped",
        "mend the stamps, unwrap the counter, or cut the log there",
    ),
    "resampled": Sentence(
        (
            "column {column} was recorded every {own_sample_time:time} and the position every {sample_time:time}: {percent:.0f} % of its "
            "samples were interpolated, with an error of at most {error_percent:.2g} % of its standard deviation",
            "the time stamps are off even ones by {percent:.2g} % of the sample time (19 of 20) and up to {largest:.0f} %: all channels "
            "were resampled on their stamps onto steps of {sample_time:time}, which errs by about {position_error:length} in the position",
            " and {effort_error:force} in the effort",
            " (root mean square). If the stamps are off and the samples are not, leave the column of time out of "
            "the axis file and write sample_time under [timing]",
        ),
        "stamps are not even, or channels have sample times of their own: what was recorded was resampled",
        "record all channels at one fixed rate; if only the stamps are off, write sample_time instead of the column of time",
        choose=_resampled,
    ),
    "unit_contradicts": says(
        "column {column} is called as if it were in {called}, and is taken to be in {declared}: one of both is wrong. "
        "Mend its unit in the axis file",
        "the name of a column speaks of another unit than the header or the axis file",
        "mend the unit",
    ),
    "sign_reversed": says(
        "the sign of effort seems reversed: over closed motion it takes {percent:.0f} % of the work out of the axis "
        "that friction would take, where friction only puts heat into it. Turn the sign of the effort in the axis "
        "file: sign = -1 where it has none or 1, else 1",
        "over closed motion the effort does negative work",
        "turn the sign of the effort in the axis file",
    ),
    "effort_unsigned": says(
        "the effort, up to {largest:force}, goes to zero again and again and never crosses it: it is a magnitude, as "
        "many drives show the current. Record the signal that has a sign",
        "the effort has lost its sign",
        "record the signal that has a sign",
    ),
    "unit_suspect": Sentence(
        (
            "column {column} is called as if it were in {called}, and is taken to be in {declared}: one of both is "
            "wrong. Mend its unit in the axis file",
            "the axis would move at {speed:length/time}: mend the unit of the position, the gear or the lead in the "
            "axis file, or raise the threshold if it does",
            "the samples would be {sample_time:time} apart, which no servo axis is sampled at: mend the unit of time in the axis file",
        ),
        "the position or the stamps are in another unit than declared",
        "mend the unit of position or time, the gear or the lead",
        choose=where("called", "speed"),
        also=("speed", "sample_time"),
    ),
    "velocity_contradicts": Sentence(
        (
            "the recorded velocity is {delay:time} later than that of the position: its filter is told nowhere. Leave "
            "it out of [columns], or take the delay out",
            "the recorded velocity is {ratio:.3g} times that of the position (correlation {correlation:.2g}). Mend "
            "unit or sign of one of both, or leave the velocity out of [columns]",
        ),
        "a recorded velocity is another one than the position has",
        "mend unit or sign of one of both",
        choose=lambda texts, numbers: texts[0 if numbers["delay"] else 1],
    ),
    "mass_contradicts": says(
        "the mass or inertia that is told, {known:mass}, is {ratio:.3g} times the {found:mass} that the log shows: "
        "mend the mass, the gear, the lead or the constant of the effort in the axis file",
        "the known mass is not that of the log",
        "mend the mass, the gear or the constant of the effort",
    ),
    "gear_suspect": says(
        "that factor of the {of}, {ratio:.4g}, is close to {gear}: a gear, a lead or a unit seems to be counted twice, "
        "left out or turned around. Mend it in the axis file",
        "a factor is one that gears and units have",
        "mend the gear, the lead or the unit",
    ),
    "clipped": _with_names(
        "the effort is cut off at {level:force}: {samples} samples in a row from t = {time:.6g} s, {all} in all. The "
        "true effort was larger there. Lower the acceleration, or widen the range of the channel",
        "; {names:list} make up for what is missing",
        "the effort is cut off at an extreme",
        "lower the acceleration, or widen the range of the channel",
    ),
    "beyond_limit": Sentence(
        (
            "the effort reaches {value:force}, and {key} of the axis file says {limit:force}: the limit, the unit or the "
            "constant of the effort, or the gain of a known input is wrong. The limit of the controller is compared "
            "without known inputs, which are added behind it; a limit on their sum stands under [effort]",
            "the position travels {value:length}, and the stroke of the axis file is {limit:length}: the unit of the "
            "position or the stroke is wrong",
        ),
        "the effort exceeds a limit of the axis file, or the position its stroke",
        "mend the limit, the unit or the constant of the effort, or the gain of a known input; or the unit of the position",
        choose=where("key"),
    ),
    "resolution_contradicts": Sentence(
        (
            "the position steps by {step:length}, {times:.3g} times the resolution of {resolution:length} that the "
            "axis file states: its unit or the resolution is wrong",
            ". 57.3 is degrees in a radian: is the position in the other unit?",
        ),
        "the steps of the position are not those of the encoder that the axis file describes",
        "mend the unit of the position, or the resolution under [encoder]",
        choose=lambda texts, numbers: texts[0] + (texts[1] if numbers["degrees"] else ""),
    ),
    "saturates": Sentence(
        (
            "the effort bends over: its largest values read {percent:.0f} % too little for the motion that they make. "
            "Widen the range of the sensor, or lower the acceleration",
            "; {names:list} make up for what is missing",
            "the drive saturates: the largest efforts act by {percent!m:.0f} % less than they read, as where a command is recorded and "
            "the torque of the motor no longer follows it. Record the torque or current that acts, or lower the acceleration",
        ),
        "the channel of the effort bends over before its end, or the drive does behind a recorded command",
        "widen the range of the sensor, record the effort that acts, or lower the acceleration",
        choose=lambda texts, numbers: _named((texts[0 if numbers["percent"] > 0.0 else 2], texts[1]), numbers),
    ),
    "scale_steps": _with_names(
        "from t = {time:.4g} s on the effort reads {percent:+.2g} % for inertia and friction alike: the torque constant, a gain or a unit "
        "changed. Identify the parts of the log apart (`span` in the axis file), or scale the effort of one of them",
        "; {names:list} are means over both",
        "the scale of the effort changes during the log",
        "identify the parts of the log apart, or scale the effort of one of them",
    ),
    "high_passed": _with_names(
        "the effort has no slow part: what is slower than {cutoff:.2g} Hz is cut off, as by an AC-coupled input. Switch the channel to DC, "
        "and record again",
        "; {names:list} are not those of the axis",
        "the effort passed a high-pass",
        "switch the channel of the effort to DC",
    ),
    "reference_recorded": says(
        "position and reference are the same to the last digits: the position is a copy of the reference, not what the encoder read. "
        "Record the position of the encoder",
        "the reference was recorded in place of the position",
        "record the position of the encoder",
    ),
    "never_slides": _with_names(
        "the effort follows the position as that of a spring (correlation {correlation:.2f}) and gives back all but "
        "{percent:.0f} % of its work: within {reach:length} the contact hardly slides, or something pulls the axis "
        "back. Record motion beyond the break-away distance too",
        "; {names:list} are not those of sliding",
        "the log is of pre-sliding alone",
        "record motion beyond the break-away distance too",
    ),
    "level_drifts": _with_names(
        "friction changes by {percent:+.0f} % of its level, {level:force}, over the log, as on an axis that warms up: "
        "warm it up first, or identify parts of the log (`span` in the axis file)",
        "; {names:list} are means over that change",
        "the level of friction changes over time",
        "warm up first, or identify parts of the log",
    ),
    "level_over_position": says(
        "friction changes by {percent:+.0f} % of its level, {level:force}, from one end of the range to the other: add "
        "the slot `+position` to the model, or record where the axis works",
        "the level of friction changes over the range",
        "add `+position`",
    ),
    "below_resolution": says(
        "the axis moves by {way:length} between reversals, and the position has steps of {resolution:length}: record "
        "it more finely, or move further",
        "the motion is a few steps of the encoder",
        "record the position more finely, or move further",
    ),
    "one_direction": Sentence(
        (
            "the axis moves {direction}, and the other way for no more than {percent:.1f} % of its way: a constant "
            "force and friction are one. Move in both directions",
            "; {names:list} cannot be told apart, whatever their intervals say",
            "the axis moves {direction} only: a constant force and friction are one. Move in both directions",
        ),
        "the motion goes in one direction",
        "move in both directions",
        choose=lambda texts, numbers: _named((texts[0 if numbers["percent"] >= 0.05 else 2], texts[1]), numbers),
    ),
    "one_speed": Sentence(
        (
            "all steady motion is at one speed, {slowest:length/time} to {fastest:length/time}: " + _SPEEDS,
            "; {names:list} cannot be told apart, whatever their intervals say",
            "all steady motion is at one speed, {slowest:length/time}: " + _SPEEDS,
        ),
        "all steady motion is at one speed",
        _SPEEDS,
        choose=lambda texts, numbers: _named((texts[2 if _alike(numbers) else 0], texts[1]), numbers),
    ),
}


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
    "few_cycles": Sentence(
        (
            "one side has only {cycles} cycles: intervals are wide, and rest on these showing how cycles scatter",
            "one cycle tells no scatter, so that no change has an interval",
        ),
        "few cycles tell how much they scatter",
        "record ten cycles or more",
        choose=where("cycles"),
    ),
    "cycles_identical": says(
        "the cycles of a quantity are the same to the last digits, as in a simulation without noise: its interval "
        "tells nothing of a machine",
        "cycles do not scatter, so that an interval has no width",
        "record the machine itself",
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
