"""What there is to know of a fit as a whole and what it rests on, and of a prediction."""

from collections.abc import Mapping
from typing import Any

from bristle.report.sentences.sentence import Sentence, says, where

_INTERVALS = (
    "95 % intervals from {{draws}} fits to logs simulated with the model: {causes}, friction that scatters by "
    "{{scatter_percent:2 digits}} % over {{half_cycles}} half-cycles; {left} of the residual (root mean square) is "
    "none of these, and comes back block by block with a sign drawn by chance"
)


def _lead(numbers: Mapping[str, Any]) -> int:
    """Return 0 where the effort lags, 1 where it leads, 2 where it leads by half a sample."""
    if numbers["delay"] >= 0.0:
        return 0
    return 2 if -0.6 <= numbers["samples"] <= -0.4 else 1


def _filtered(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return what is said of a filter: of rows that are fewer for it, of one that is slower, of a fit, of a prediction."""
    if "percent" in numbers or "wanted" in numbers:
        return texts[0 if "percent" in numbers else 1]
    place = 2 if "dropped" in numbers else 4
    return texts[place if numbers["decimation"] == 1 else place + 1]


_FILTERED = "position, effort and friction filtered at {cutoff:g} Hz without phase, {dropped} samples dropped at each edge, "
_TAKEN_OUT = (
    ". That was taken out; inertia, damping and stiffness before sliding are as unsure. Record accelerations that "
    "change fast, or write `delay` under [timing] of the axis file"
)

FITS: dict[str, Sentence] = {
    # Pairs of parameters, noise, residual.
    "correlated": says(
        "{other} and {parameter} can hardly be told apart in this log (correlation {correlation:.3f})",
        "two parameters trade places",
        "give one of them, or excite them apart",
    ),
    "weight_guessed": says(
        "{levels:list} hold beside an offset of {weight:force}, which is a guess: friction that differs by direction "
        "and a weight look alike. Write the weight as `offset` under [plant] of the axis file",
        "friction by direction holds beside a guessed weight only",
        "write `offset` under [plant] of the axis file",
    ),
    "level_as_seen": says(
        "{names:and} is what friction comes to at the speeds of this log, up to {speed:length/time}: whether it falls "
        "or rises beyond them, the log does not show",
        "a level of friction is told at slow speeds only",
        "slide at several speeds, as fast as the axis works",
    ),
    "noisy_acceleration": says(
        "{parameter} is too small by about {percent:.2g} %: so much of the acceleration is noise of the position; lower the cut-off to "
        "{cutoff:.0f} Hz",
        "noise of the position makes the inertia too small",
        "lower the cut-off to the one told",
    ),
    "unexplained": says(
        "the model leaves {percent:.0f} % of the effort unexplained: check units, signs, the delay between the channels and the mass in "
        "the axis file, and whether gravity of a link, cogging or a spring acts on the axis (`[plant]` and `[[cogging]]`)",
        "the model explains little",
        "check units, signs, delay, mass, and what else acts on the axis",
    ),
    "rising_friction": Sentence(
        (
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}: no Stribeck effect, whose force falls",
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}, moving {direction}: no Stribeck "
            "effect, whose force falls",
        ),
        "friction rises with speed before it levels off",
        "take the curve for what it is",
        choose=lambda texts, numbers: texts[bool(numbers["direction"])],
    ),
    "widened": says(
        "intervals of {names:list} are made {times:.2g} times as wide: which delay or filter the log passed is in "
        "doubt, and where friction turns that matters more than noise does",
        "a doubt about the treatment of a log, which replicates do not know of, is in its intervals",
        "state the delay under [timing] of the axis file, or mend what is named",
    ),
    # What was held out.
    "motion_repeats": says(
        "the motion repeats itself every {every:time}: what is held out of it is the motion that was fitted, so that its error tells how "
        "well the axis repeats itself. Predict a log of another motion, of several amplitudes, to see what a model is worth",
        "the motion repeats itself, and what is held out of it is no other motion",
        "record another motion of several amplitudes too, and predict its log",
    ),
    "too_short": says(
        "the log is too short for a part of it to be held out: all errors are those of what was fitted",
        "nothing was held out",
        "record a longer log",
    ),
    "unfinished": says(
        "unfinished: the search was interrupted, and this is the best that it had found; run it again to the end",
        "a person interrupted the search",
        "run it again",
    ),
    # What a fit rests on.
    "output_error_open": says(
        "the parameters make the position that the effort causes the measured one, unfiltered; what is said of the "
        "effort holds along the measured motion, differentiated twice, and serves as the start only",
        "the position was fitted",
    ),
    "output_error_closed": says(
        "the parameters make the effort that the controller asks for in the simulated loop the measured one, unfiltered, from the "
        "reference and the known inputs; what is said of rows of the effort holds along the measured motion and serves as the start only",
        "the effort of the simulated loop was fitted",
    ),
    "prediction_error": Sentence(
        (
            "an observer of {bandwidth:.3g} Hz predicts the next position {times:.2g} times as badly as in logs that the identified axis "
            "made: the model does not explain all of the motion, and the parameters are those of inverse dynamics",
            "the contact parameters are the mean of observers of several bandwidths that predict the next position, weighted by "
            "precision; the most precise observer, of {bandwidth:.3g} Hz, predicts it to {error:length} rms",
            "the parameters are those of inverse dynamics, for no observer predicted the position: {why}",
        ),
        "prediction errors of the position were fitted",
        "compare other models",
        choose=where("unexplained", "bandwidth"),
    ),
    "filtered": Sentence(
        (
            "in as many rows as usual, noise of the position would have made the inertia take {percent:.0f} % of what "
            "friction takes; one row for {decimation} samples has hardly any of it",
            "the log is sampled too slowly for the filter of the identification, {wanted:g} Hz: {cutoff:.3g} Hz in its place",
            _FILTERED + "a row for each sample",
            _FILTERED + "one row for {decimation} samples",
            "effort and motion are filtered at {cutoff:g} Hz",
            "effort and motion are filtered at {cutoff:g} Hz, and one row is kept for {decimation} samples",
        ),
        "how the log was filtered, and how many rows of it were kept",
        "nothing",
        choose=_filtered,
    ),
    "delay_found": Sentence(
        (
            "the effort lags the position by {delay:time} ({samples:.2f} samples; 95 % interval ±{half_width:time}), "
            "found in this log together with the inertia, and taken out",
            "the effort runs ahead of the position by {delay!m:time} ({samples!m:.2f} samples; 95 % interval "
            "±{half_width:time}), found in this log together with the inertia, and taken out",
            "the effort runs ahead of the position by {delay!m:time} ({samples!m:.2f} samples, as where a controller holds its output; 95 "
            "% interval ±{half_width:time}), found in this log together with the inertia, and taken out",
        ),
        "a delay between the channels was found and taken out",
        "nothing",
        choose=lambda texts, numbers: texts[_lead(numbers)],
    ),
    "delay_unknown": says(
        "this log hardly shows by how much the effort lags the position. A delay that is not taken out biases the inertia, and damping "
        "and stiffness before sliding more. Record accelerations that change fast, or write `delay` under [timing] of the axis file",
        "the delay between the channels is not known",
        "record accelerations that change fast, or write `delay` under [timing]",
    ),
    "delay_rough": Sentence(
        (
            "this log shows only roughly that the effort lags the position by {delay:time} ({samples:.1f} samples; "
            "95 % interval ±{half_width:time})" + _TAKEN_OUT,
            "this log shows only roughly that the effort runs ahead of the position by {delay!m:time} ({samples!m:.1f} "
            "samples; 95 % interval ±{half_width:time})" + _TAKEN_OUT,
        ),
        "the delay between the channels is known roughly, and taken out",
        "record accelerations that change fast, or write `delay` under [timing]",
        choose=lambda texts, numbers: texts[numbers["delay"] < 0.0],
    ),
    "delay_or_filter": Sentence(
        (
            "whether the {delay:time} between effort and position are a delay or a filter in one of the channels, this "
            "log does not tell; they were taken out as a delay",
            ". {names:and} depend on it. Record accelerations that change fast, or switch filters off in the drive",
        ),
        "a delay may be a filter",
        "record accelerations that change fast, or switch filters off in the drive",
        choose=lambda texts, numbers: texts[0] + (texts[1] if numbers["names"] else ""),
    ),
    "filter_suspect": Sentence(
        (
            "effort passed a filter of {lag:time} more than position did; it was taken out. Better switch it off in "
            "the drive, and record again",
            "position passed a filter of {lag:time} more than effort did, and it was taken out; a mass that hangs on something elastic "
            "looks alike. Switch the filter off in the drive and record again, or look for a resonance",
            "the recorded effort is a command, which the drive follows with a lag of {lag:time}, or position passed a "
            "filter like that, and friction is told from the effort as it acted; a mass that hangs on something "
            "elastic looks alike. Record what acted, or look for a resonance",
        ),
        "a channel was filtered, a command was recorded, or part of the mass is elastic",
        "switch the filter off in the drive and record again, record what acted, or look for a resonance",
        choose=lambda texts, numbers: texts[("effort", "position", "command").index(numbers["channel"])],
        also=("channel", "half_width"),
    ),
    "stages_differ": says(
        "{parameter} is {value:mass} in the fit of all rows and {first:mass} where only slow accelerations and fast "
        "motion count: the log has something that neither delay nor noise explains",
        "two estimates of the inertia disagree",
        "look for what else differs: gear, load, friction over position",
    ),
    "rests": Sentence(
        (
            "{percent:.3g} % of the samples are at rest and left out: there friction balances whatever effort there is",
            "the axis moves so slowly that motion cannot be told from rest in encoder steps of {resolution:length}; all "
            "samples are fitted, those at rest too",
        ),
        "samples at rest were not fitted, or could not be told from motion",
        'write `rests = "keep"` under [identification] where they tell friction; record faster motion, or with a finer encoder',
        choose=where("percent"),
    ),
    "standard_errors": says(
        "standard errors take the residuals for independent; intervals rest on those that hold for residuals "
        "correlated over time, where these are larger",
        "which standard errors are told",
    ),
    "element_shape": says(
        "errors and intervals are those for elements of this shape: their shares do not vary in them",
        "the shape of the elements is taken for known",
    ),
    "intervals": Sentence(
        (
            _INTERVALS.format(causes="noise of {noise:force}, encoder steps of {resolution:length}", left="{unexplained:force}"),
            _INTERVALS.format(causes="encoder steps of {resolution:length} in the loop", left="{unexplained:force}"),
        ),
        "how the 95 % intervals were found",
        "nothing",
        choose=lambda texts, numbers: texts[int("loop" in numbers)],
    ),
    "intervals_motion": says(
        _INTERVALS.format(causes="encoder steps of {resolution:length} behind the motion", left="{unexplained:length}"),
        "the same, of a fit to the position",
    ),
}


PREDICTIONS: dict[str, Sentence] = {
    "worse_than_none": Sentence(
        (
            "a position of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): an open loop "
            "runs away where nothing holds the axis; predict in inverse or closed-loop mode",
            "an effort of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): check "
            "that the model is of this axis, and units and signs in the axis file",
        ),
        "what is predicted is worse than nothing",
        "predict in another mode, or check model, units and signs",
        choose=lambda texts, numbers: texts[("position", "effort").index(numbers["signal"])],
        also=("signal",),
    ),
    "beyond_speed": says(
        "the log moves at up to {speed:length/time}, the model was fitted to no more than {fitted_speed:length/time}: "
        "beyond, its friction is an extrapolation",
        "the log is much faster than the one that was fitted",
        "fit the model to faster motion",
    ),
    "presliding_distance": says(
        "friction turns over a pre-sliding distance of {distance:length} (axis file)",
        "a static model was simulated with the pre-sliding distance of the axis file",
    ),
    "short_stretch": says("a stretch of {samples} samples is too short to be predicted, and was left out", "a stretch was left out"),
    "start_of_contact": Sentence(
        (
            "the contact began at {percents:percents} of the way from its middle to slip (below 0: backward), found from the first samples",
            "the log is one period of a motion that has run in: it is run from rest until it repeats itself",
            "the log is {periods:g} equal periods of a motion that has run in: it is run from rest until it repeats itself",
            "the motion begins at rest",
        ),
        "how the motion begins: where the contact stood, at rest, or run in until it repeats itself",
        "nothing",
        choose=lambda texts, numbers: texts[
            1 if numbers.get("periods") == 1 else 2 if "periods" in numbers else 0 if "percents" in numbers else 3
        ],
    ),
}
