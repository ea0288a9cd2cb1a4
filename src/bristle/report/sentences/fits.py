"""Sentences about a fit as a whole, its assumptions, and a prediction."""

from collections.abc import Mapping
from typing import Any

from bristle.report.sentences.sentence import Sentence, says, where

_INTERVALS = (
    "the 95 % intervals come from {{draws}} fits to simulated logs. These logs contain {causes} and friction that scatters by "
    "{{scatter_percent:2 digits}} % over {{half_cycles}} half-cycles. bristle added the rest of the residual, {left} (root mean "
    "square), in blocks with random sign"
)


def _lead(numbers: Mapping[str, Any]) -> int:
    """Return 0 if the effort lags, 1 if it leads, 2 if it leads by half a sample."""
    if numbers["delay"] >= 0.0:
        return 0
    return 2 if -0.6 <= numbers["samples"] <= -0.4 else 1


def _filtered(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text about a filter: fewer rows, a slower filter, a fit, or a prediction."""
    if "percent" in numbers or "wanted" in numbers:
        return texts[0 if "percent" in numbers else 1]
    place = 2 if "dropped" in numbers else 4
    return texts[place if numbers["decimation"] == 1 else place + 1]


_FILTERED = (
    "bristle filtered position, effort and friction at {cutoff:g} Hz without phase shift. It dropped {dropped} samples at each edge, and "
    "kept "
)
_REMOVED = (
    ". bristle removed this delay, but its uncertainty also makes inertia, damping and pre-sliding stiffness uncertain. Record "
    "accelerations that change fast, or write its known value as `delay` under [timing] of the axis file"
)


def _lines(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text about the lines that bristle took into the axis."""
    *names, taken = texts
    pairs = zip(names, ("gravity", "harmonics", "spring"), strict=True)
    named = " and ".join(name for name, key in pairs if key in numbers)
    return taken.replace("LINES", named)


_BESIDE = (
    "beside friction, the effort holds {terms:list}. This model has no such force. bristle took it out of the effort before "
    "the fit, so parameters of friction are means over the log"
)
FITS: dict[str, Sentence] = {
    "second_pass": Sentence(
        (
            "the gravity of a link",
            "cogging (turn {travel:length}, harmonics {harmonics:whole numbers})",
            "a spring",
            "bristle took LINES into the axis. The held-out error is {percent:3 digits} % instead of {before:3 digits} %. For the next "
            "log, write {lines:list} into the axis file",
        ),
        "bristle found forces beside friction in the log, and took lines for them into the axis",
        "write the lines into the axis file",
        choose=_lines,
        also=("turner", "taken"),
    ),
    "terms_beside": Sentence(
        (_BESIDE + ". Next: try `{model}`", _BESIDE),
        "the effort holds forces that the model does not have; bristle took them out of the effort before the fit",
        "try the suggested model, if any. `bristle log LOG --explain` draws each force",
        choose=where("model"),
    ),
    # Pairs of parameters, noise, residual.
    "correlated": says(
        "{other} and {parameter} are confounded in this log (correlation {correlation:.3f})",
        "two parameters are confounded",
        "give a value for one of the two parameters, or record a motion that excites them separately",
    ),
    "weight_guessed": says(
        "{levels:list} are valid only with an offset of {weight:force}, which bristle guessed. A weight and friction that differs by "
        "direction are confounded. Write the weight as `offset` under [plant] of the axis file",
        "friction by direction depends on a guessed weight",
        "write `offset` under [plant] of the axis file",
    ),
    "level_as_seen": says(
        "{names:and} is the friction at the speeds of this log, up to {speed:length/time}. The log does not show friction at higher speeds",
        "a level of friction is known at slow speeds only",
        "slide at several speeds, up to the working speed",
    ),
    "noisy_acceleration": says(
        "{parameter} is too small by about {percent:.2g} %, the share of noise in the mean square acceleration. Lower the cut-off to "
        "{cutoff:.0f} Hz",
        "noise of the position biases the inertia to a smaller value",
        "lower the cut-off to the suggested frequency",
    ),
    "unexplained": says(
        "the model does not explain {percent:.0f} % of the effort. Check units, signs, the delay between the channels and the mass in the "
        "axis file. Look also for gravity of a link, cogging or a spring, and describe them under `[plant]` and `[[cogging]]`",
        "the model explains little of the effort",
        "check units, signs, delay and mass. Check for further forces on the axis",
    ),
    "rising_friction": Sentence(
        (
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}. The log shows no Stribeck effect",
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}, moving {direction}. The log shows no "
            "Stribeck effect",
        ),
        "friction rises with speed before it levels off",
        "use the measured curve of friction over speed",
        choose=lambda texts, numbers: texts[bool(numbers["direction"])],
    ),
    "widened": says(
        "bristle widened the intervals of {names:list} by a factor of {times:.2g}. The delay or filter of the log is uncertain. "
        "Near reversals this uncertainty matters more than noise",
        "the intervals also include the uncertainty of the delay or filter, which the replicates do not show",
        "state the delay under [timing] of the axis file, or switch off filters in the drive and record again",
    ),
    # The held-out stretches.
    "motion_repeats": says(
        "the log repeats one motion every {every:time}, so the held-out error shows only how well this motion repeats. Test the model on a "
        "different motion with several amplitudes",
        "the held-out stretches have the same motion as the fitted stretches",
        "also record another motion of several amplitudes, and predict its log",
    ),
    "log_differs": says(
        "friction in {log} differs by {percent:+.0f} % of its level from friction in the other logs. The held-out error does not include "
        "differences between logs. To see them, identify without this log, and predict it",
        "friction differs between the logs",
        "identify without this log, and predict it",
    ),
    "too_short": says(
        "the log is too short for held-out stretches. All errors are those of the fitted stretches",
        "the log has no held-out stretches",
        "record a longer log",
    ),
    "unfinished": says(
        "unfinished: the search was interrupted, and this is its best result so far. Run the command again to its end",
        "the search was interrupted",
        "run the command again to its end",
    ),
    # The assumptions of a fit.
    "output_error_open": says(
        "bristle fitted the simulated position to the measured position, unfiltered. Diagnostics of the effort come from an earlier fit "
        "along the measured motion. The earlier fit only gave the start of the search",
        "bristle fitted the simulated position to the measured position",
    ),
    "output_error_closed": says(
        "bristle fitted the controller effort of the simulated loop to the measured effort, unfiltered. The recorded reference and the "
        "known inputs drive this loop. Diagnostics of the effort come from an earlier fit along the measured motion. The earlier fit "
        "only gave the start of the search",
        "bristle fitted the effort of the simulated loop to the measured effort",
    ),
    "prediction_error": Sentence(
        (
            "the model does not explain all of the motion, so the parameters are those of inverse dynamics. An observer of {bandwidth:.3g} "
            "Hz predicts the next position {times:.2g} times worse than in simulated logs of the identified axis",
            "the contact parameters are the mean of several observers, weighted by precision. Each observer has a different bandwidth and "
            "predicts the next position. The most precise observer, of {bandwidth:.3g} Hz, has an error of {error:length} rms",
            "the parameters are those of inverse dynamics, because no observer was usable: {why}",
        ),
        "bristle fitted the model to the prediction errors of the position",
        "compare other models",
        choose=where("unexplained", "bandwidth"),
    ),
    "filtered": Sentence(
        (
            "bristle kept one row for {decimation} samples, to suppress noise of the position. With the usual number of rows, that noise "
            "would have appeared as an inertia force of {percent:.0f} % of friction",
            "the log is sampled too slowly for the usual filter of {wanted:g} Hz. bristle filtered it at {cutoff:.3g} Hz",
            _FILTERED + "one row for each sample",
            _FILTERED + "one row for {decimation} samples",
            "bristle filtered effort and motion at {cutoff:g} Hz",
            "bristle filtered effort and motion at {cutoff:g} Hz, and kept one row for {decimation} samples",
        ),
        "bristle filtered the log, or kept only a part of the rows",
        "nothing",
        choose=_filtered,
    ),
    "delay_found": Sentence(
        (
            "the effort lags the position by {delay:time} ({samples:.2f} samples; 95 % interval ±{half_width:time}). "
            "bristle estimated this delay together with the inertia, and removed it",
            "the effort leads the position by {delay!m:time} ({samples!m:.2f} samples; 95 % interval "
            "±{half_width:time}). bristle estimated this lead together with the inertia, and removed it",
            "the effort leads the position by {delay!m:time} ({samples!m:.2f} samples, typical of the zero-order hold of a controller; 95 "
            "% interval ±{half_width:time}). bristle estimated this lead together with the inertia, and removed it",
        ),
        "bristle removed a delay between the channels",
        "nothing",
        choose=lambda texts, numbers: texts[_lead(numbers)],
    ),
    "delay_unknown": says(
        "this log hardly determines the delay of the effort. An uncorrected delay biases the inertia, and damping "
        "and pre-sliding stiffness even more. Record accelerations that change fast, or write its known value as `delay` under [timing] of "
        "the axis file",
        "the delay between the channels is unknown",
        "record accelerations that change fast, or write the known value as `delay` under [timing]",
    ),
    "delay_rough": Sentence(
        (
            "the effort lags the position by roughly {delay:time} ({samples:.1f} samples; 95 % interval ±{half_width:time})"
            + _REMOVED,
            "the effort leads the position by roughly {delay!m:time} ({samples!m:.1f} samples; 95 % interval ±{half_width:time})"
            + _REMOVED,
        ),
        "the delay between the channels is only roughly known, and bristle removed it",
        "record accelerations that change fast, or write the known value as `delay` under [timing]",
        choose=lambda texts, numbers: texts[numbers["delay"] < 0.0],
    ),
    "delay_or_filter": Sentence(
        (
            "the lag of {delay:time} between effort and position may be a delay or a filter in a channel. bristle removed it as a delay",
            ". {names:and} depend on this choice. Record accelerations that change fast, or switch off filters in the drive",
        ),
        "a delay may be a filter",
        "record accelerations that change fast, or switch off filters in the drive",
        choose=lambda texts, numbers: texts[0] + (texts[1] if numbers["names"] else ""),
    ),
    "filter_suspect": Sentence(
        (
            "the effort passed a filter with {lag:time} more lag than the position. bristle removed this lag. Switch off the filter in "
            "the drive, and record again",
            "the position passed a filter with {lag:time} more lag than the effort. bristle removed this lag. An elastically coupled mass "
            "has the same effect. Switch off the filter in the drive and record again, or look for a resonance",
            "the recorded effort is probably a command, and the drive follows it with a lag of {lag:time}. A filter of the position or an "
            "elastically coupled mass has the same effect. bristle used the lagged effort for friction. Record the acting effort, or look "
            "for a resonance",
        ),
        "a channel was filtered, a command was recorded, or part of the mass is coupled elastically",
        "switch off the filter in the drive and record again, record the acting effort, or look for a resonance",
        choose=lambda texts, numbers: texts[
            ("effort", "position", "command").index(numbers["channel"])
        ],
        also=("channel", "half_width"),
    ),
    "stages_differ": says(
        "two estimates of {parameter} disagree: {value:mass} from all rows, {first:mass} from fast motion with slow accelerations. "
        "Neither delay nor noise explains the difference",
        "two estimates of the inertia disagree",
        "look for other causes: gear, load, friction over position",
    ),
    "rests": Sentence(
        (
            "bristle left out {percent:.3g} % of the samples, because the axis was at rest. At rest, friction balances any effort",
            "the axis moves too slowly to distinguish motion from rest with encoder steps of {resolution:length}. bristle fitted all "
            "samples, including rests",
        ),
        "bristle left out samples at rest, or cannot distinguish rest from motion",
        'write `rests = "keep"` under [identification] if rests contain information on friction. Record faster motion, or use a finer '
        "encoder",
        choose=where("percent"),
    ),
    "standard_errors": says(
        "standard errors assume independent residuals. The intervals also allow for residuals that are "
        "correlated over time, if this makes them wider",
        "standard errors assume independent residuals",
    ),
    "element_shape": says(
        "standard errors and intervals assume the given shape of the elements: the share of each element is fixed",
        "the shape of the elements is assumed known",
    ),
    "intervals": Sentence(
        (
            _INTERVALS.format(
                causes="noise of {noise:force}, encoder steps of {resolution:length},",
                left="{unexplained:force}",
            ),
            _INTERVALS.format(
                causes="encoder steps of {resolution:length} in the loop",
                left="{unexplained:force}",
            ),
        ),
        "the 95 % intervals come from simulated logs",
        "nothing",
        choose=lambda texts, numbers: texts[int("loop" in numbers)],
    ),
    "intervals_motion": says(
        _INTERVALS.format(
            causes="encoder steps of {resolution:length} after the motion",
            left="{unexplained:length}",
        ),
        "the 95 % intervals of a fit to the position come from simulated logs",
    ),
}


PREDICTIONS: dict[str, Sentence] = {
    "worse_than_none": Sentence(
        (
            "the prediction is worse than a constant position of zero: its error is {percent:2 digits} % of the measured position. An open "
            "loop runs away, because no controller keeps the axis in place. Predict in inverse or closed-loop mode",
            "the prediction is worse than a constant effort of zero: its error is {percent:2 digits} % of the measured effort. Check that "
            "the model belongs to this axis. Check units and signs in the axis file",
        ),
        "the prediction is worse than a constant zero",
        "predict in another mode, or check model, units and signs",
        choose=lambda texts, numbers: texts[("position", "effort").index(numbers["signal"])],
        also=("signal",),
    ),
    "beyond_speed": says(
        "above {fitted_speed:length/time} the friction of the model is an extrapolation. This log reaches {speed:length/time}, beyond the "
        "fitted log",
        "the predicted log is much faster than the fitted log",
        "fit the model to faster motion",
    ),
    "presliding_distance": says(
        "bristle simulated the static friction with the pre-sliding distance of the axis file, {distance:length}",
        "bristle simulated a static model with the pre-sliding distance of the axis file",
    ),
    "short_stretch": says(
        "bristle left out a stretch of {samples} samples, too short for a prediction",
        "bristle left out a stretch too short for a prediction",
    ),
    "start_of_contact": Sentence(
        (
            "at the start the contact was deflected by {percents:percents} of the distance at which it slips (negative: backward). bristle "
            "estimated this from the first samples",
            "the log is one period of a periodic motion: bristle simulates this period again from rest until the result repeats",
            "the log is {periods:g} equal periods of a periodic motion: bristle simulates a period again from rest until the result "
            "repeats",
            "the motion begins at rest",
        ),
        "the simulation starts from a deflected contact, from rest, or from a periodic motion",
        "nothing",
        choose=lambda texts, numbers: texts[
            1
            if numbers.get("periods") == 1
            else 2
            if "periods" in numbers
            else 0
            if "percents" in numbers
            else 3
        ],
    ),
}
