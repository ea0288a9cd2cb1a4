"""The sentences of all diagnostics, by their codes, with what each means and what to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from bristle.core.typography import with_unit

__all__ = ["SENTENCES", "Sentence"]

_UNSURE = "; standard error {std_percent:.0f} %, with residuals correlated over time"
_NO_TEST = (
    "what was held out is the motion that was fitted, so that its error tells how well the axis repeats itself, not "
    "how the model does on another motion. Predict a log of another motion with it"
)
_INTERVALS = (
    "95 % intervals from {{draws}} fits to logs simulated with the model: {causes}, friction that scatters by "
    "{{scatter_percent:2 digits}} % over {{half_cycles}} half-cycles; {left} of the residual (root mean square) is "
    "none of these, and comes back block by block with a sign drawn by chance"
)


class Sentence(NamedTuple):
    """What there is to say of a code.

    Parameters
    ----------
    texts : tuple of str
        The sentence, with its numbers in braces; several where the numbers choose.
    means : str
        What the code is for, for a table of all of them.
    advice : str
        What to do.
    about : {"", "parameter", "edge"}
        Whether the parameter stands before it, and what became of it.
    choose : callable
        Returns the text, from the texts and the numbers.
    """

    texts: tuple[str, ...]
    means: str
    advice: str
    about: str = ""
    choose: Callable[[tuple[str, ...], Mapping[str, Any]], str] = lambda texts, numbers: texts[0]

    def template(self, numbers: Mapping[str, Any]) -> str:
        """Return the text for these numbers, braces still in it."""
        return self.choose(self.texts, numbers)


def _plural(name: str) -> Callable[[tuple[str, ...], Mapping[str, Any]], str]:
    """Return the choice of the first text for one, else the second."""
    return lambda texts, numbers: texts[0 if numbers[name] == 1 else 1]


def _unsure(choose: Callable[[tuple[str, ...], Mapping[str, Any]], str]) -> Any:
    """Return a choice with the standard error behind it, where there is one."""
    return lambda texts, numbers: choose(texts[:-1], numbers) + (texts[-1] if "std_percent" in numbers else "")


def _cause(
    means: str, advice: str, *texts: str,
    choose: Callable[[tuple[str, ...], Mapping[str, Any]], str] = lambda texts, numbers: texts[0],
) -> Sentence:  # fmt: skip
    """Return a reason why a log does not determine a parameter."""
    return Sentence((*texts, _UNSURE), means, advice, "parameter", _unsure(choose))


def _told(speed: float) -> str:
    """Return a speed as it is told, but for the kind of axis."""
    return with_unit(speed, "m/s")


def _held(text: str, means: str, advice: str = "nothing") -> Sentence:
    """Return a reason why a parameter is held."""
    return Sentence((text,), means, advice, "parameter")


def _says(text: str, means: str, advice: str = "nothing") -> Sentence:
    return Sentence((text,), means, advice)


_WEIGH = "accelerate harder, or give the mass or inertia in the axis file"
_SPEEDS = "move at several steady speeds between a tenth and all of the working speed"
_REVERSE = "reverse gently and often, at amplitudes of the break-away distance and below"
_FINER = "record the position more finely, or leave the stiffness of the contact out of the model"

SENTENCES: dict[str, Sentence] = {
    # A parameter that the log does not determine.
    "low-acceleration": _cause(
        "the motion hardly accelerates",
        _WEIGH,
        "the acceleration never exceeds {acceleration:length/time^2}; give the mass or inertia in the axis file",
    ),
    "one-speed": _cause("there is one speed only", _SPEEDS, "the log moves at one speed only, {speed:length/time}"),
    "low-speed": _cause("the speeds are too low", _SPEEDS, "the log never exceeds {speed:length/time}"),
    "no-fall": _cause(
        "the fall of friction with speed does not show",
        "move slowly and steadily, at least at five speeds below the one at which friction is least",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and it slides steadily at {slowest:length/time} to {fastest:length/time})",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and it slides steadily at {slowest:length/time})",
        choose=lambda texts, numbers: texts[_told(numbers["slowest"]) == _told(numbers["fastest"])],
    ),
    "no-steady-slide": _cause(
        "the fall of friction with speed does not show, and nothing slides steadily",
        "move slowly and steadily, at least at five speeds below the one at which friction is least",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and none of its motion is a slide at constant velocity)",
    ),
    "no-reversal": _cause("the motion does not reverse", _REVERSE, "the log has no reversal"),
    "few-reversals": _cause(
        "there are few reversals",
        _REVERSE,
        "the log has only {reversals} reversal",
        "the log has only {reversals} reversals",
        choose=_plural("reversals"),
    ),
    "fast-reversals": _cause(
        "reversals are through the pre-sliding zone before the filter sees it",
        _REVERSE,
        "the log has only {reversals} reversal, each crosses the pre-sliding zone of {zone:length} in {samples:.0f} "
        "samples, where a period of the filter takes {filter_samples:.0f}",
        "the log has only {reversals} reversals, each crosses the pre-sliding zone of {zone:length} in {samples:.0f} "
        "samples, where a period of the filter takes {filter_samples:.0f}",
        choose=_plural("reversals"),
    ),
    "coarse-position": _cause(
        "the pre-sliding zone is a few steps of the encoder",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {counts:.0f} steps of the recorded position "
        "({resolution:length} each)",
    ),
    "noisy-position": _cause(
        "the noise of the position is as large as the pre-sliding zone",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {deviations:.0f} times the noise of the position "
        "({noise:length} standard deviation), which turns friction alike",
    ),
    "no-bend": _cause(
        "the force stays straight over the stroke",
        "move at several amplitudes, up to the largest that matters",
        "over a stroke of {stroke:length} the log does not show the force bend",
    ),
    "few-strokes": _cause(
        "there is too little sliding in both directions",
        "move in both directions, at least ten reversals",
        "the log holds {reversals} reversals over a stroke of {stroke:length}",
    ),
    "small-effect": _cause(
        "the parameter hardly changes the effort",
        "leave it out, or excite it more",
        "its effect on the effort is smaller than what the model misses",
    ),
    "beyond-effort": _cause(
        "the best force is one that the log never reached",
        "let the axis stick and break away, or leave it out",
        "the best value is far beyond the largest effort of the log, {effort:force}",
    ),
    "unseen": _cause(
        "moved away, the others fitted again, it leaves the held-out error as it was",
        "excite it, or hold it",
        "changed by {percent:.0f} %, with all others fitted again, the error on held-out blocks does not rise "
        "noticeably",
    ),
    "seen-together": _cause(
        "the same, and other parameters move with it",
        "give one of them, or excite them apart",
        "the log sees it only together with {instead:list}: changed by {percent:.0f} %, it is made up for by them, and "
        "the error on held-out blocks does not rise noticeably",
    ),
    "redundant": _held(
        "only {products:and} show in the force, whatever {parameter} is",
        "no log can tell it: the force depends on products with it only",
        "read the products, under `combinations`",
    ),
    # A parameter at the end of its range.
    "edge-no-fall": Sentence(
        (
            "the best value is the smallest that is allowed, {value:unit}: in this log friction does not fall with "
            "speed",
        ),
        "a break-away force is no larger than sliding friction",
        "take a model without the Stribeck effect",
        "edge",
    ),
    "edge-of-model": Sentence(
        ("the best value is the {edge} that is allowed, {value:unit}; {cause}",),
        "the best value is the smallest or largest that the model allows",
        "see `cause`, a code of this table",
        "edge",
    ),
    "edge-of-search": Sentence(
        ("the search ran to the {edge} value that this log could show, {value:unit}: {cause}",),
        "the best value lies where the log shows nothing any more",
        "see `cause`, a code of this table",
        "edge",
    ),
    # A parameter that is held.
    "held-known": _held("given as known", "given by a person"),
    "held-default": _held(
        "a shape that is kept at its default", "a shape that nobody asked for", "identify it with --free"
    ),
    "held-plant-damping": _held(
        "it cannot be told from the damping c of the plant", "viscous friction is that of the plant"
    ),
    "held-levels": _held(
        "it cannot be told from the difference between {levels[0]} and {levels[1]}",
        "the offset is the difference of friction by direction",
    ),
    "held-one-direction": _held(
        "it cannot be told from {level}: the log moves {direction} only",
        "in one direction, offset and friction are one",
        "move in both directions",
    ),
    "held-one-speed": _held(
        "the log moves at one speed only: it cannot be told from elements that slip at once",
        "at one speed, viscous friction is a constant that turns with the motion",
        _SPEEDS,
    ),
    "held-middle": _held("the middle of the range of the log", "where the position of a slot is counted from"),
    "held-half-range": _held("half of the range of the log", "the length that the position of a slot is counted in"),
    "held-pitch": _held(
        "the lead of the axis file, or else the period of what simple friction leaves", "the pitch of the screw"
    ),
    # Pairs of parameters, noise, residual.
    "correlated": _says(
        "{other} and {parameter} can hardly be told apart in this log (correlation {correlation:.3f})",
        "two parameters trade places",
        "give one of them, or excite them apart",
    ),
    "half-sample": _says(
        "{names:list} may be too large by {shift:force*time/length} and more: an effort that the controller holds "
        "until "
        "its next sample leads the position by half a sample. Write `held = true` under [effort] of the axis file if "
        "it "
        "does so, `held = false` if not",
        "half a sample between effort and position decides on a damping",
        "write `held` under [effort]",
    ),
    "noisy-acceleration": _says(
        "{parameter} is too small by about {percent:.2g} %: so much of the acceleration is noise of the position; "
        "lower "
        "the cut-off to {cutoff:.0f} Hz",
        "noise of the position makes the inertia too small",
        "lower the cut-off to the one told",
    ),
    "no-presliding": _says(
        "the model leaves {percent:.0f} % of the effort unexplained, much of it around reversals, where friction "
        "builds up over a distance that this model does not have: its parameters may be biased beyond "
        "their intervals. Add `lugre` or `dahl` to the comparison, or leave slow and short reversals out",
        "a static model errs around reversals",
        "add `lugre` or `dahl`",
    ),
    "unexplained": _says(
        "the model leaves {percent:.0f} % of the effort unexplained: check units, signs, the delay between the "
        "channels and the mass in the axis file",
        "the model explains little",
        "check units, signs, delay and mass",
    ),
    "coloured-residual": _says(
        "the model leaves {percent:.0f} % of the effort unexplained, and that is no noise but lasts from row to "
        "row: compare it with models that know more, and take the intervals for too narrow",
        "what the model leaves over is no noise",
        "compare with models that know more",
    ),
    "rising-friction": Sentence(
        (
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}: no Stribeck "
            "effect, "
            "whose force falls",
            "friction rises from {first:force} to {level:force} over the first {speed:length/time}, moving "
            "{direction}: "
            "no Stribeck effect, whose force falls",
        ),
        "friction rises with speed before it levels off",
        "take the curve for what it is",
        choose=lambda texts, numbers: texts[bool(numbers["direction"])],
    ),
    "half-cycles-differ": _says(
        "leaving out half-cycles changes {names:list} by more than noise, encoder and scatter do: the model "
        "lacks something that differs between the half-cycles, and these intervals are too narrow",
        "parameters change from half-cycle to half-cycle",
        "look for what differs: position, load, temperature",
    ),
    # What the motion cannot tell, and what was held out.
    "one-amplitude": _says(
        "all {half_cycles} half-cycles go the same way of {amplitude:length}: a log of one amplitude holds no "
        "loop inside another one, so that it cannot tell a contact that remembers one force (dahl, lugre) from one "
        "that remembers its turning points (maxwell_slip), however their errors differ. Record a motion to and fro "
        "over {advised:length}: elements close the loops inside the large one, the others creep",
        "the log turns at one amplitude only",
        "record a motion over the amplitudes told",
    ),
    "motion-repeats": _says(
        "the motion repeats itself every {period:time}: " + _NO_TEST,
        "what was held out is no other motion",
        "predict a log of another motion",
    ),
    "logs-repeat": Sentence(
        (
            "each log repeats the motion of another one: " + _NO_TEST,
            "{repeated} of {logs} logs repeat the motion of another one: " + _NO_TEST,
        ),
        "logs that were held out repeat the motion of others",
        "predict a log of another motion",
        choose=lambda texts, numbers: texts[numbers["repeated"] < numbers["logs"]],
    ),
    "too-short": _says(
        "the log is too short for a part of it to be held out: all errors are those of what was fitted",
        "nothing was held out",
        "record a longer log",
    ),
    "unfinished": _says(
        "unfinished: the search was interrupted, and this is the best that it had found; run it again to the end",
        "a person interrupted the search",
        "run it again",
    ),
    # What a fit rests on.
    "output-error-open": _says(
        "the parameters make the position that the effort causes the measured one, unfiltered; what is said of the "
        "effort holds along the measured motion, differentiated twice, and serves as the start only",
        "the position was fitted",
    ),
    "output-error-closed": _says(
        "the parameters make the effort that the controller asks for in the simulated loop the measured one, "
        "unfiltered, from the reference and the known inputs; what is said of rows of the effort holds along the "
        "measured motion and serves as the start only",
        "the effort of the simulated loop was fitted",
    ),
    "filtered": Sentence(
        (
            "position, effort and friction filtered at {cutoff:g} Hz without phase, {dropped} samples dropped at each "
            "edge, a row for each sample",
            "position, effort and friction filtered at {cutoff:g} Hz without phase, {dropped} samples dropped at each "
            "edge, one row for {decimation} samples",
        ),
        "how the log was filtered",
        "nothing",
        choose=_plural("decimation"),
    ),
    "delay-found": _says(
        "the effort lags the position by {delay:time} ({samples:.2f} samples), found where simple friction explains it "
        "best",
        "a delay between the channels was found and taken out",
    ),
    "rests-left-out": _says(
        "{percent:.3g} % of the samples are at rest and left out: there friction balances whatever effort there is",
        "samples at rest were not fitted",
        'write `rests = "keep"` under [identification] where they tell friction',
    ),
    "standard-errors": _says(
        "standard errors take the residuals for independent; intervals rest on those that hold for residuals "
        "correlated over time, where these are larger",
        "which standard errors are told",
    ),
    "element-shape": _says(
        "errors and intervals are those for elements of this shape: their shares do not vary in them",
        "the shape of the elements is taken for known",
    ),
    "intervals": _says(
        _INTERVALS.format(
            causes="noise of {noise:force}, encoder steps of {resolution:length}", left="{unexplained:force}"
        ),
        "how the 95 % intervals were found",
    ),
    "intervals-loop": _says(
        _INTERVALS.format(causes="encoder steps of {resolution:length} in the loop", left="{unexplained:force}"),
        "the same, of a fit to a closed loop",
    ),
    "intervals-motion": _says(
        _INTERVALS.format(causes="encoder steps of {resolution:length} behind the motion", left="{unexplained:length}"),
        "the same, of a fit to the position",
    ),
    # A prediction.
    "position-worse-than-none": _says(
        "a position of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): an "
        "open "
        "loop runs away where nothing holds the axis; predict in inverse or closed-loop mode",
        "the predicted position is worse than none",
        "predict in another mode",
    ),
    "effort-worse-than-none": _says(
        "an effort of zero would be nearer to the log than what the model predicts ({percent:2 digits} % off): check "
        "that the model is of this axis, and units and signs in the axis file",
        "the predicted effort is worse than none",
        "check model, units and signs",
    ),
    "beyond-speed": _says(
        "the log moves at up to {speed:length/time}, the model was fitted to no more than {fitted_speed:length/time}: "
        "beyond, its friction is an extrapolation",
        "the log is much faster than the one that was fitted",
        "fit the model to faster motion",
    ),
    "presliding-distance": _says(
        "friction turns over a pre-sliding distance of {distance:length} (axis file)",
        "a static model was simulated with the pre-sliding distance of the axis file",
    ),
    "short-stretch": _says(
        "a stretch of {samples} samples is too short to be predicted, and was left out", "a stretch was left out"
    ),
    "start-of-contact": _says(
        "the contact began at {percents:percents} of the way from its middle to slip (below 0: backward), found from "
        "the first samples",
        "where the contact stood before each stretch",
    ),
    "slow-sampling": _says(
        "the log is sampled too slowly for the filter of the identification, {wanted:g} Hz: {cutoff:.3g} Hz in its "
        "place",
        "the cut-off is lower than that of the identification",
        "sample faster",
    ),
    "filtered-rows": Sentence(
        (
            "effort and motion are filtered at {cutoff:g} Hz",
            "effort and motion are filtered at {cutoff:g} Hz, and one row is kept for {decimation} samples",
        ),
        "how the log was filtered for the prediction",
        "nothing",
        choose=_plural("decimation"),
    ),
    "begins-at-rest": _says("the motion begins at rest", "how the motion begins"),
    "run-in": Sentence(
        (
            "the log is one period of a motion that has run in: it is run from rest until it repeats itself",
            "the log is {periods:g} equal periods of a motion that has run in: it is run from rest until it repeats "
            "itself",
        ),
        "the motion was run until it repeats itself",
        "nothing",
        choose=_plural("periods"),
    ),
}
"""The sentence of each code."""
