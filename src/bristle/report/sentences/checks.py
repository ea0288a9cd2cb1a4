"""Sentences of the checks of a log before it is fitted, and of the comparison of two logs, with their remedies."""

from collections.abc import Mapping
from typing import Any

from bristle.core import with_unit
from bristle.report.sentences.sentence import Sentence, says, where

_SPEEDS = (
    "move at several constant speeds, from a tenth of the working speed up to the working speed"
)


def _named(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text, followed by the affected parameters if a fit names them."""
    return texts[0] + (texts[1] if "names" in numbers else "")


def _same_speed(numbers: Mapping[str, Any]) -> bool:
    """Return whether the slowest and the fastest speed have the same text."""
    return with_unit(numbers["slowest"], "m/s") == with_unit(numbers["fastest"], "m/s")


def _resampled(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    own, even, effort, behind, period = texts
    if "column" in numbers:
        return own
    return (
        even
        + effort * ("effort_error" in numbers)
        + behind
        + period * ("sample_time_stated" not in numbers)
    )


def _with_names(first: str, names: str, means: str, advice: str) -> Sentence:
    return Sentence((first, names), means, advice, choose=_named)


CHECKS: dict[str, Sentence] = {
    "rows_lost": says(
        "the position jumps by up to {step:length} within one sample, first after t = {time:.6g} s (number of jumps: {places}). The "
        "velocity around the jumps is too small for them: rows are missing, or a counter wrapped. Correct the time stamps, unwrap the "
        "counter, or cut the log at the jumps",
        "rows are missing although the time stamps continue, or a counter wrapped",
        "correct the time stamps, unwrap the counter, or cut the log at the jumps",
    ),
    "resampled": Sentence(
        (
            "column {column} was recorded every {own_sample_time:time}, but the position every {sample_time:time}. bristle interpolated "
            "{percent:.0f} % of its samples. The interpolation error is at most {error_percent:.2g} % of the standard "
            "deviation of the column",
            "the time stamps are uneven. 19 of 20 stamps deviate by at most {percent:.2g} % of the sample time, the worst by "
            "{largest:.0f} %. bristle resampled all channels to steps of {sample_time:time}. The interpolation error is about "
            "{position_error:length} in the position",
            " and {effort_error:force} in the effort",
            " (root mean square). If only the stamps are uneven, remove time from [columns] of the axis file",
            " and write sample_time under [timing]",
        ),
        "uneven time stamps, or channels with different sample times: bristle resampled the log",
        "record all channels at one fixed rate. If only the stamps are uneven, write sample_time in the axis file instead of the time "
        "column",
        choose=_resampled,
        also=("sample_time_stated",),
    ),
    "unit_contradicts": says(
        "the name of column {column} suggests {called}, but its declared unit is {declared}. Correct the unit in the axis file",
        "the name of a column contradicts the unit in the header or the axis file",
        "correct the unit in the axis file",
    ),
    "sign_reversed": says(
        "the sign of the effort seems reversed. Over motion that returns to its start the effort does negative work, {percent:.0f} % of "
        "the work that friction would take. Reverse the sign of the effort in the axis file: write sign = -1 if sign is missing or 1, "
        "otherwise sign = 1",
        "over motion that returns to its start the effort does negative work",
        "reverse the sign of the effort in the axis file",
    ),
    "effort_unsigned": says(
        "the effort, up to {largest:force}, returns to zero repeatedly but never crosses it. It is a magnitude, like the current that "
        "many drives show. Record the effort with its sign",
        "the effort has lost its sign",
        "record the effort with its sign",
    ),
    "unit_suspect": Sentence(
        (
            "the name of column {column} suggests {called}, but its declared unit is {declared}. Correct the unit in the axis file",
            "with these units the axis moves at {speed:length/time}. Correct the unit of the position, the gear or the lead in the axis "
            "file. If the axis is that fast, raise the threshold `fastest` or `fastest_turning`",
            "with this unit of time the samples are {sample_time:time} apart, which no servo axis has. Correct the unit of time in the "
            "axis file",
        ),
        "the position or the time stamps have another unit than declared",
        "correct the unit of position or time, the gear or the lead",
        choose=where("called", "speed"),
        also=("speed", "sample_time"),
    ),
    "velocity_contradicts": Sentence(
        (
            "the recorded velocity lags the derivative of the position by {delay:time}, because of an undeclared filter. Leave the "
            "velocity out of [columns] in the axis file, or remove this delay from the velocity",
            "the recorded velocity is {ratio:.3g} times the derivative of the position (correlation {correlation:.2g}). Correct the unit "
            "or sign of position or velocity, or leave the velocity out of [columns] in the axis file",
        ),
        "the recorded velocity is not the derivative of the position",
        "correct the unit or sign of position or velocity",
        choose=lambda texts, numbers: texts[0 if numbers["delay"] else 1],
    ),
    "mass_contradicts": says(
        "the known mass or inertia, {known:mass}, is {ratio:.3g} times the {found:mass} that the log shows. Correct the mass, the gear, "
        "the lead or the constant of the effort in the axis file",
        "the known mass contradicts the log",
        "correct the mass, the gear or the constant of the effort in the axis file",
    ),
    "gear_suspect": says(
        "the {of} contradicts the log by a factor of {ratio:.4g}, close to {gear}. A gear, a lead or a unit is probably missing, inverted "
        "or applied twice. Correct it in the axis file",
        "a quantity is wrong by a factor typical of a wrong gear or unit",
        "correct the gear, the lead or the unit",
    ),
    "clipped": _with_names(
        "the effort is clipped at {level:force}: {samples} samples in a row from t = {time:.6g} s, {all} samples in all. The "
        "true effort was larger there. Lower the acceleration, or widen the range of the channel",
        ". The missing effort biases {names:list}",
        "the effort is clipped",
        "lower the acceleration, or widen the range of the channel",
    ),
    "beyond_limit": Sentence(
        (
            "the effort reaches {value:force}, but {key} of the axis file is {limit:force}. The limit, the unit or constant of the effort, "
            "or the gain of a known input is wrong. The limit of the controller applies to its output, before known inputs are "
            "added; that of the sum belongs under [effort]",
            "the position travels {value:length}, but the stroke of the axis file is {limit:length}. The unit of the position or the "
            "stroke is wrong",
        ),
        "the effort exceeds a limit of the axis file, or the position exceeds the stroke",
        "correct the limit, the unit or constant of the effort, or the gain of a known input. For the stroke, correct the unit of the "
        "position",
        choose=where("key"),
    ),
    "resolution_contradicts": Sentence(
        (
            "the position changes in steps of {step:length}, {times:.3g} times the resolution of {resolution:length} in the axis file. "
            "The unit of the position or the resolution is wrong",
            ". One radian has 57.3 degrees: the position is probably in the other unit of angle",
        ),
        "the steps of the position contradict the encoder resolution in the axis file",
        "correct the unit of the position, or the resolution under [encoder]",
        choose=lambda texts, numbers: texts[0] + (texts[1] if numbers["degrees"] else ""),
    ),
    "saturates": Sentence(
        (
            "the channel of the effort saturates: its largest values read {percent:.0f} % too low for the measured motion. "
            "Widen the range of the sensor, or lower the acceleration",
            ". The missing effort biases {names:list}",
            "the drive saturates: the largest acting efforts are {percent!m:.0f} % smaller than recorded. The log probably has a command "
            "that the motor torque no longer follows. Record the acting torque or current, or lower the acceleration",
        ),
        "the channel of the effort saturates, or the drive saturates and the log contains the commanded effort",
        "widen the range of the sensor, record the acting effort, or lower the acceleration",
        choose=lambda texts, numbers: _named(
            (texts[0 if numbers["percent"] > 0.0 else 2], texts[1]), numbers
        ),
    ),
    "scale_steps": _with_names(
        "at t = {time:.4g} s the scale of the effort changes by {percent:+.2g} %: inertia and friction change alike. The torque constant, "
        "a gain or a unit changed. Identify the two parts of the log separately (`span` in the axis file), or rescale the effort of one "
        "part",
        ". {names:list} are averages over both parts",
        "the scale of the effort changes during the log",
        "identify the two parts of the log separately, or rescale the effort of one part",
    ),
    "high_passed": _with_names(
        "the effort has no content below {cutoff:.2g} Hz, as behind an AC-coupled input. Switch this input to DC coupling, and record "
        "again",
        ". The values of {names:list} are wrong",
        "the effort passed a high-pass filter",
        "switch the input of the effort to DC coupling",
    ),
    "reference_recorded": says(
        "position and reference agree to the last digit: the position is a copy of the reference. Record the position of the encoder",
        "the reference was recorded in place of the position",
        "record the position of the encoder",
    ),
    "never_slides": _with_names(
        "the contact hardly slides within {reach:length}, or an external force pulls the axis back. The effort follows the position like "
        "a spring (correlation {correlation:.2f}), and only {percent:.0f} % of its work is lost. Also record motion beyond the "
        "break-away distance",
        ". {names:list} are not valid for sliding",
        "the log contains only pre-sliding",
        "also record motion beyond the break-away distance",
    ),
    "level_drifts": _with_names(
        "friction changes by {percent:+.0f} % of its level ({level:force}) over the log, as on an axis that warms up. "
        "Warm up the axis first, or identify parts of the log (`span` in the axis file)",
        ". {names:list} are averages over the log",
        "the level of friction changes over time",
        "warm up the axis first, or identify parts of the log",
    ),
    "level_over_position": says(
        "friction changes by {percent:+.0f} % of its level ({level:force}) from one end of the range to the other. Add "
        "the slot `+position` to the model, or record only the working range",
        "the level of friction changes along the axis",
        "add the slot `+position` to the model",
    ),
    "below_resolution": says(
        "the axis moves only {way:length} between reversals, and the position has steps of {resolution:length}. Record "
        "the position more finely, or move further",
        "the motion covers only a few steps of the encoder",
        "record the position more finely, or move further",
    ),
    "one_direction": Sentence(
        (
            "the axis moves {direction} for all but {percent:.1f} % of its travel, so a constant force and friction are confounded. "
            "Move in both directions",
            ". Do not trust the intervals of {names:list}: these parameters are confounded",
            "the axis moves {direction} only, so a constant force and friction are confounded. Move in both directions",
        ),
        "the axis moves in one direction only",
        "move in both directions",
        choose=lambda texts, numbers: _named(
            (texts[0 if numbers["percent"] >= 0.05 else 2], texts[1]), numbers
        ),
    ),
    "one_speed": Sentence(
        (
            "all constant-velocity motion is at one speed, {slowest:length/time} to {fastest:length/time}. M"
            + _SPEEDS[1:],
            ". Do not trust the intervals of {names:list}: these parameters are confounded",
            "all constant-velocity motion is at one speed, {slowest:length/time}. M" + _SPEEDS[1:],
        ),
        "all constant-velocity motion is at one speed",
        _SPEEDS,
        choose=lambda texts, numbers: _named(
            (texts[2 if _same_speed(numbers) else 0], texts[1]), numbers
        ),
    ),
}


COMPARISONS: dict[str, Sentence] = {
    "no_reference": says(
        "the reference is missing {sides:and} the change. bristle does not compare the following error, and matches the motions by the "
        "measured position",
        "a log has no reference, so its following error is unknown",
        "record the reference, and name its column in the axis file",
    ),
    "no_effort": says(
        "the effort is missing {sides:and} the change, so bristle does not compare effort and friction",
        "a log has no effort",
        "record the effort, and name its column in the axis file",
    ),
    "motions_differ": says(
        "the motions differ: {before_percent:3 digits} % of the motion before and {after_percent:3 digits} % of the motion after "
        "are common to both. bristle compares only this common motion",
        "two logs share only a part of their motion",
        "record both logs with the same reference",
    ),
    "pieces_for_cycles": says(
        "one side has fewer than two whole cycles. bristle compares pieces of the motion instead, so the intervals show how "
        "the change varies along the motion",
        "the motion has too few whole cycles",
        "record ten cycles or more, to and fro",
    ),
    "few_cycles": Sentence(
        (
            "one side has only {cycles} cycles. The intervals are wide, because these cycles alone show the scatter",
            "a single cycle shows no scatter, so no change has an interval",
        ),
        "the cycles are too few to estimate their scatter",
        "record ten cycles or more",
        choose=where("cycles"),
    ),
    "cycles_identical": says(
        "the cycles of a quantity agree to the last digit, as in a simulation without noise. Its interval does not describe a machine",
        "the cycles of a quantity are identical, so its interval has zero width",
        "record the real machine",
    ),
    "cycles_alike": says(
        "neighbouring cycles are correlated, as while an axis warms up: {cycles:2 digits} cycles count as one independent cycle",
        "neighbouring cycles are correlated, which widens the intervals",
        "record after the axis has warmed up",
    ),
    "friction_not_told": Sentence(
        (
            "bristle does not compare friction: no speed occurs often enough in both directions of both logs",
            "{why}",
        ),
        "a log does not show its friction, so bristle does not compare friction",
        "record a longer motion to and fro, with more than ten samples for each period of the cut-off frequency",
        choose=lambda texts, numbers: (
            f"bristle does not compare friction: {texts[1]}" if numbers["why"] else texts[0]
        ),
    ),
    "sample_times_differ": says(
        "the logs have different sample times: bristle compares them at the longest, one sample about every {longest:time}",
        "the logs have different sample times, and bristle compares them at the longest",
    ),
    "one_recording": says(
        "one side has a single log. The intervals lack the scatter between recordings, for example from temperature",
        "the intervals show the scatter between cycles, but not between recordings",
        "record several logs before and several after the change, and give all of them",
    ),
    "few_recordings": says(
        "a side has {logs} logs. The scatter between so few recordings is uncertain, which widens the intervals",
        "few recordings show little of the scatter between recordings, which widens the intervals",
        "record four or more logs of each side, alternately: before, after, after, before, after, before, before, after",
    ),
}
