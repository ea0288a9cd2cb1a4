"""Why a log does not determine a parameter, why one lies at an edge, and why one is held."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.core.typography import with_unit
from bristle.report.sentences.sentence import Sentence, cause, held, plural

__all__ = ["PARAMETERS"]

_WEIGH = "accelerate harder, or give the mass or inertia in the axis file"
_SPEEDS = "move at several steady speeds between a tenth and all of the working speed"
_REVERSE = "reverse gently and often, at amplitudes of the break-away distance and below"
FEW = 20  # reversals
_FINER = "record the position more finely, or leave the stiffness of the contact out of the model"


def _in_words(speed: float) -> str:
    """Return a speed as it is told, but for the kind of axis."""
    return with_unit(speed, "m/s")


def _crossed(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return what is said of reversals: by whether a period of the filter is over before the zone is."""
    single, few, many, filtered = texts
    if numbers["samples"] >= numbers["filter_samples"]:
        return filtered
    return single if numbers["reversals"] == 1 else few if numbers["reversals"] <= FEW else many


PARAMETERS: dict[str, Sentence] = {
    # A parameter that the log does not determine.
    "low_acceleration": cause(
        "the motion hardly accelerates",
        _WEIGH,
        "the acceleration never exceeds {acceleration:length/time^2}; give the mass or inertia in the axis file",
    ),
    "few_speeds": cause("there is one speed only", _SPEEDS, "the log moves at one speed only, {speed:length/time}"),
    "low_speed": cause("the speeds are too low", _SPEEDS, "the log never exceeds {speed:length/time}"),
    "no_fall": cause(
        "the fall of friction with speed does not show",
        "move slowly and steadily, at least at five speeds below the one at which friction is least",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and it slides steadily at {slowest:length/time} to {fastest:length/time})",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and it slides steadily at {slowest:length/time})",
        choose=lambda texts, numbers: texts[_in_words(numbers["slowest"]) == _in_words(numbers["fastest"])],
    ),
    "no_steady_slide": cause(
        "the fall of friction with speed does not show, and nothing slides steadily",
        "move slowly and steadily, at least at five speeds below the one at which friction is least",
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and none of its motion is a slide at constant velocity)",
    ),
    "no_reversal": cause("the motion does not reverse", _REVERSE, "the log has no reversal"),
    "few_reversals": cause(
        "there are few reversals",
        _REVERSE,
        "the log has only {reversals} reversal",
        "the log has only {reversals} reversals",
        choose=plural("reversals"),
    ),
    "fast_reversals": cause(
        "reversals are through the pre-sliding zone before the filter sees it",
        _REVERSE,
        "the log has only {reversals} reversal, each crosses the pre-sliding zone of {zone:length} in {samples:.0f} "
        "samples, where a period of the filter takes {filter_samples:.0f}",
        "the log has only {reversals} reversals, each crosses the pre-sliding zone of {zone:length} in {samples:.0f} "
        "samples, where a period of the filter takes {filter_samples:.0f}",
        "each of {reversals} reversals crosses the pre-sliding zone of {zone:length} in {samples:.0f} samples, where a "
        "period of the filter takes {filter_samples:.0f}",
        "its reversals ({reversals}) cross the pre-sliding zone of {zone:length} in {samples:.0f} samples, which the "
        "filter lets pass ({filter_samples:.0f} a period), and yet show less there than the model misses",
        choose=_crossed,
    ),
    "coarse_position": cause(
        "the pre-sliding zone is a few steps of the encoder",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {counts:.0f} steps of the recorded position ({resolution:length} each)",
    ),
    "coarse_elements": cause(
        "elements that slip within a few steps of the encoder make up part of the stiffness",
        _FINER,
        "{percent:.0f} % of it are elements that slip within {counts:.0f} steps of the recorded position "
        "({resolution:length} each), where they stand for what the encoder leaves out: stiffness and virgin curve up "
        "to there may be that much too large",
    ),
    "noisy_position": cause(
        "the noise of the position is as large as the pre-sliding zone",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {deviations:.0f} times the noise of the position "
        "({noise:length} standard deviation), which turns friction alike",
    ),
    "no_bend": cause(
        "the force stays straight over the stroke",
        "move at several amplitudes, up to the largest that matters",
        "over a stroke of {stroke:length} the log does not show the force bend",
    ),
    "few_strokes": cause(
        "there is too little sliding in both directions",
        "move in both directions, at least ten reversals",
        "the log holds {reversals} reversals over a stroke of {stroke:length}",
    ),
    "small_effect": cause(
        "the parameter hardly changes the effort",
        "leave it out, or excite it more",
        "its effect on the effort is smaller than what the model misses",
    ),
    "beyond_effort": cause(
        "the best force is one that the log never reached",
        "let the axis stick, break away and slide, or leave it out",
        "the best value is far beyond the most that friction took of the effort in this log, {effort:force}",
    ),
    "unseen": cause(
        "moved away, the others fitted again, it leaves the held-out error as it was",
        "excite it, or hold it",
        "changed by {percent:.0f} %, with all others fitted again, the error on held-out blocks does not rise noticeably",
    ),
    "seen_together": cause(
        "the same, and other parameters move with it",
        "give one of them, or excite them apart",
        "the log sees it only together with {instead:list}: changed by {percent:.0f} %, it is made up for by them, and "
        "the error on held-out blocks does not rise noticeably",
    ),
    "as_soft": cause(
        "a log of an axis that is far stiffer may give the same value",
        "take a finer encoder, or let the axis reverse more slowly",
        "an axis {times:.2g} times as stiff gives this value, too, in {alike} of {fits} logs drawn of the same motion",
    ),
    "without_stiffness": cause(
        "a damping before sliding is told beside its stiffness only",
        "let the axis reverse slowly, so that its stiffness shows",
        "it acts beside {stiffness}, which the log does not show",
    ),
    "redundant": held(
        "only {products:and} show in the force, whatever {parameter} is",
        "no log can tell it: the force depends on products with it only",
        "read the products, under `combinations`",
    ),
    # A parameter at the end of its range.
    "edge_no_fall": Sentence(
        ("the best value is the smallest that is allowed, {value:unit}: in this log friction does not fall with speed",),
        "a break-away force is no larger than sliding friction",
        "take a model without the Stribeck effect",
        "edge",
    ),
    "no_friction": Sentence(
        (
            "no force opposes the motion: the best value is {value:unit}. Likely causes, the commonest first: gravity "
            'or a bias that is held (offset = "identify" under [plant] identifies it), a reversed sign of the effort, '
            "a mass that is stated too large",
        ),
        "the log shows no friction that opposes the motion",
        "identify the offset, else mend the sign of the effort or the mass in the axis file",
        "edge",
    ),
    "edge_of_model": Sentence(
        ("the best value is the {edge} that is allowed, {value:unit}; {cause}",),
        "the best value is the smallest or largest that the model allows",
        "see `cause`, a code of this table",
        "edge",
    ),
    "edge_of_search": Sentence(
        ("the search ran to the {edge} value that this log could show, {value:unit}: {cause}",),
        "the best value lies where the log shows nothing any more",
        "see `cause`, a code of this table",
        "edge",
    ),
    # A parameter that is held.
    "held_known": held("given as known", "given by a person"),
    "held_default": held("a shape that is kept at its default", "a shape that nobody asked for", "identify it with --free"),
    "held_plant_damping": held("it cannot be told from the damping c of the plant", "viscous friction is that of the plant"),
    "held_levels": held(
        "it cannot be told from the difference between {levels[0]} and {levels[1]}",
        "the offset is the difference of friction by direction",
        "write `offset` under [plant] of the axis file where it is known",
    ),
    "held_constant": held(
        "half of what the effort of both directions differs by, as of a weight: {levels:list} cannot be told from it, "
        "and without it one of them would be negative",
        "a constant force is larger than friction",
        "write `offset` under [plant] of the axis file where it is known",
    ),
    "held_one_direction": held(
        "it cannot be told from {level}: the log moves {direction} only",
        "in one direction, offset and friction are one",
        "move in both directions",
    ),
    "held_one_speed": held(
        "the log moves at one speed only: it cannot be told from elements that slip at once",
        "at one speed, viscous friction is a constant that turns with the motion",
        _SPEEDS,
    ),
    "held_middle": held("the middle of the range of the log", "where the position of a slot is counted from"),
    "held_half_range": held("half of the range of the log", "the length that the position of a slot is counted in"),
    "held_pitch": held("the lead of the axis file, or else the period of what simple friction leaves", "the pitch of the screw"),
}
