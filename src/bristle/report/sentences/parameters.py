"""Why a log does not determine a parameter, why one lies at an edge or is held, and which force a model lacks."""

from collections.abc import Mapping
from typing import Any

from bristle.core import with_unit
from bristle.report.sentences.sentence import Sentence, cause, held, says, where

_SPEEDS = "move at several steady speeds between a tenth and all of the working speed"
_FINER = "record the position more finely, or leave the stiffness of the contact out of the model"


def _sliding(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return what is said of a fall that does not show: by the speeds at which the axis slides steadily, as they are told."""
    if "slowest" not in numbers:
        return texts[2]
    slowest, fastest = (with_unit(numbers[name], "m/s") for name in ("slowest", "fastest"))
    return texts[slowest == fastest]


def _crossed(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return what is said of reversals: by whether a period of the filter is over before the zone is."""
    none, lone, several, single, few, many, filtered = texts
    if "zone" not in numbers:
        return {0: none, 1: lone}.get(numbers.get("reversals", 0), several)
    if numbers["samples"] >= numbers["filter_samples"]:
        return filtered
    return single if numbers["reversals"] == 1 else few if numbers["reversals"] <= 20 else many


PARAMETERS: dict[str, Sentence] = {
    # A parameter that the log does not determine.
    "low_acceleration": cause(
        "the motion hardly accelerates",
        "accelerate harder, or give the mass or inertia in the axis file",
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
        "the log does not show the force fall with speed ({slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and none of its motion is a slide at constant velocity)",
        choose=_sliding,
    ),
    "few_reversals": cause(
        "there are few reversals, or they are through the pre-sliding zone before the filter sees it",
        "reverse gently and often, at amplitudes of the break-away distance and below",
        "the log has no reversal",
        "the log has only {reversals} reversal",
        "the log has only {reversals} reversals",
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
        "the pre-sliding zone is a few steps of the encoder, or no larger than the noise of the position",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {deviations:.0f} times the noise of the position "
        "({noise:length} standard deviation), which turns friction alike",
        "the pre-sliding zone of {zone:length} is less than {counts:.0f} steps of the recorded position ({resolution:length} each)",
        choose=where("noise"),
    ),
    "coarse_elements": cause(
        "elements that slip within a few steps of the encoder make up part of the stiffness",
        _FINER,
        "{percent:.0f} % of it are elements that slip within {counts:.0f} steps of the recorded position ({resolution:length} each), "
        "where they stand for what the encoder leaves out: stiffness and virgin curve up to there may be that much too large",
    ),
    "few_strokes": cause(
        "there is too little sliding in both directions, or the force stays straight over the stroke",
        "move in both directions, at least ten reversals, at several amplitudes up to the largest that matters",
        "the log holds {reversals} reversals over a stroke of {stroke:length}",
        "over a stroke of {stroke:length} the log does not show the force bend",
        choose=where("reversals"),
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
            "no force opposes the motion: the best value is {value:unit}. Likely causes, the commonest first: gravity or a bias that is "
            'held (offset = "identify" under [plant] identifies it), a reversed sign of the effort, a mass that is stated too large',
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


_CURVE = "friction over the speed has another curve than the model: {force:force}, {percent:.2g} % of friction"

_COMPARED = "`{compared}`, which was compared, is no better"

_RIPPLE = (
    "the force ripples over the position, with a period of {period:length} and an amplitude of {amplitude:force}, "
    "{percent:.2g} % of friction (root mean square)"
)


def _ripple(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return what is said of a ripple, by the directions that it pulls in."""
    plain, known, turning, alike, lead, beside, following, compared = texts
    after = compared if numbers["compared"] else ""
    if numbers.get("pulls") == "turning":
        return turning + (following if numbers["model"] else after)
    if numbers.get("harmonics"):
        own = alike + (lead if numbers["turner"] == "motor" else "")
        return own + (beside if numbers["model"] else after)
    return plain + (following if numbers["model"] else after or known)


def _missing(text: str, by_model: str, without: str, means: str) -> Sentence:
    """Return what is said of a force that a model lacks: which one has it, or that there is none."""
    return Sentence(
        (f"{text}. Next: {by_model}", f"{text}. {_COMPARED}", f"{text}; {without}"),
        means,
        "try the model that is named",
        choose=where("model", "compared"),
        also=("share_percent",),
    )


STRUCTURE: dict[str, Sentence] = {
    "structure": Sentence(
        (
            "the structure of the model does not hold: {missing:force} (root mean square, {percent:.2g} % of friction) "
            "of what it leaves over is no chance, but comes back on half-cycles that it was not fitted to, where noise "
            "and scatter leave {chance:force}. What it depends on is told next",
            ". Parameters are effective: {names:list} hold for this model along such a motion, and are not those of "
            "the axis; intervals are widened by what is missing",
            "the model leaves a small force: {missing:force} (root mean square, {percent:.2g} % of friction) comes "
            "back on half-cycles that it was not fitted to, where noise and scatter leave {chance:force}. That is too "
            "little to matter in use. What it depends on is told next",
        ),
        "forces are missing in the model, by cause",
        "try the model that is named, and take parameters and intervals for effective until then",
        choose=lambda texts, numbers: texts[2 if numbers["small"] else 0] + (texts[1] if numbers["names"] else ""),
        also=("causes", "small"),
    ),
    "missing_speed": Sentence(
        (
            _CURVE + "; no model of bristle has another one",
            _CURVE + ". Next: `{model}`",
            _CURVE + ". Next: `{model}`, of which the exponent may be identified as well (`--free delta_S`)",
            _CURVE + ". " + _COMPARED,
        ),
        "friction over the speed has another curve",
        "try the model that is named",
        choose=lambda texts, numbers: texts[3 if numbers["compared"] else ("", "lugre", "stribeck_free").index(numbers["model"])],
        also=("share_percent",),
    ),
    "missing_direction": _missing(
        "friction differs between the directions: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model has a set of parameters for each already: look at load and cables",
        "friction differs between the directions",
    ),
    "missing_lag": _missing(
        "friction lags behind the speed: {force:force} over the acceleration, {percent:.2g} % of friction",
        "`{model}`, whose sliding force follows the curve with a lag",
        "this model lags by itself: look for a filter of a channel",
        "friction lags behind the speed",
    ),
    "missing_play": Sentence(
        (
            "the drive has play: what the model leaves over is {ratio:.2g} times as large where the force on the load changes its side as "
            "elsewhere amid motion: {force:force}, {percent:.2g} % of friction. So knocks a drive from one flank to the other; no model of "
            "bristle has play: record the position behind it too, and look for it in coupling and screw",
        ),
        "the drive has play",
        "look for play in coupling and screw, and record the position behind it too",
        also=("share_percent",),
    ),
    "missing_presliding": _missing(
        "friction lags behind where the motion turns: it builds up over a distance after each reversal, which this model does not "
        "have: {force:force}, {percent:.2g} % of friction. An elastic drive looks alike, and is told once the model has such a distance",
        "`{model}`",
        "no model of bristle has another way of building up",
        "friction builds up over a distance after a reversal",
    ),
    "missing_position": _missing(
        "friction changes along the axis: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model changes along the axis already, up to the square of the position",
        "friction changes along the axis",
    ),
    "missing_ripple": Sentence(
        (
            _RIPPLE + ", as cogging or a screw does",
            "; this model has one period already: look for a second one in motor, screw and belt",
            _RIPPLE + ", and changes its sign with the motion, as friction does that changes with the turns of a screw",
            _RIPPLE + ", alike in both directions, as cogging does. Next: write `[[cogging]]` with "
            '`turn = "{turner}"` and `harmonics = [{harmonics:whole numbers}]` into the axis file',
            ', and `lead = "{travel:lead}"` under `[transmission]`',
            "; or `{model}`",
            ". Next: `{model}`",
            ". " + _COMPARED,
        ),
        "the force ripples over the position",
        "write the cogging that is named into the axis file, or try the model that is named",
        choose=_ripple,
        also=("share_percent", "pulls"),
    ),
    "elastic_load": Sentence(
        (
            "the load is coupled elastically: antiresonance near {antiresonance:.2g} Hz, {force:force}, {percent:.2g} % of friction. No "
            "model of bristle has two masses: keep the loop and the motion slower than that, or record the position of the load",
        ),
        "the load is coupled elastically",
        "keep loop and motion slower than the antiresonance, or record the position of the load",
        also=("share_percent",),
    ),
    "missing_gravity": says(
        "the effort goes with the sine and cosine of the angle, as the gravity of a link does: up to "
        "{amplitude:force}, of which the model misses {force:force} (root mean square), {percent:.2g} % of friction. "
        'Next: write `gravity = "link"` under `[plant]` of the axis file',
        "gravity turns with the angle, and the plant has none",
        'write `gravity = "link"` under `[plant]` of the axis file',
    ),
    "missing_channel": _missing(
        "friction changes with the recorded {channel}: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model either changes with it already, or has nothing that could",
        "friction changes with the load, the temperature or a further channel of the log",
    ),
    "missing_transmitted": _missing(
        "friction rises with the effort that passes on to the load, as in a gear: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model either rises with it already, or has no level of its own that could",
        "friction rises with the effort that passes on to the load",
    ),
}
