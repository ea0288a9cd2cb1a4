"""Reasons why a parameter is not identifiable, at an edge of its range or held constant, and forces that a model lacks."""

from collections.abc import Mapping
from typing import Any

from bristle.core import with_unit
from bristle.report.sentences.sentence import Sentence, cause, held, says, where

_SPEEDS = (
    "move at several constant speeds, from a tenth of the working speed up to the working speed"
)
_FINER = "record the position more finely, or leave the stiffness of the contact out of the model"


def _sliding(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text about a missing Stribeck fall, by the range of the constant speeds."""
    if "slowest" not in numbers:
        return texts[2]
    slowest, fastest = (with_unit(numbers[name], "m/s") for name in ("slowest", "fastest"))
    return texts[slowest == fastest]


def _crossed(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> str:
    """Return the text about reversals: by their number, and by the filter period against the pre-sliding zone."""
    missing, lone, several, single, few, many, filtered = texts
    if "zone" not in numbers:
        return {0: missing, 1: lone}.get(numbers.get("reversals", 0), several)
    if numbers["samples"] >= numbers["filter_samples"]:
        return filtered
    return single if numbers["reversals"] == 1 else few if numbers["reversals"] <= 20 else many


PARAMETERS: dict[str, Sentence] = {
    # A parameter that the log does not determine.
    "low_acceleration": cause(
        "the motion hardly accelerates",
        "accelerate harder, or give the mass or inertia in the axis file",
        "the acceleration never exceeds {acceleration:length/time^2}. Give the mass or inertia in the axis file",
    ),
    "few_speeds": cause(
        "the log has a single speed",
        _SPEEDS,
        "the axis moves at one speed only, {speed:length/time}",
    ),
    "low_speed": cause(
        "the speeds are too low to show friction that rises with speed",
        _SPEEDS,
        "the log never exceeds {speed:length/time}",
    ),
    "no_fall": cause(
        "the log does not show friction that falls with speed",
        "move at five or more slow constant speeds, below the speed of least friction",
        "the log does not show friction that falls with speed. Only {slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and the constant speeds are {slowest:length/time} to {fastest:length/time}",
        "the log does not show friction that falls with speed. Only {slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and the only constant speed is {slowest:length/time}",
        "the log does not show friction that falls with speed. Only {slow_samples} of {samples} samples are slower than "
        "{speed:length/time}, and the log has no constant-velocity segment",
        choose=_sliding,
    ),
    "few_reversals": cause(
        "the log has few reversals, or they cross the pre-sliding zone faster than the filter",
        "reverse gently and often, at amplitudes up to the break-away distance",
        "the log has no reversal",
        "the log has only {reversals} reversal",
        "the log has only {reversals} reversals",
        "the log has only {reversals} reversal. It crosses the pre-sliding zone of {zone:length} in {samples:.0f} "
        "samples, but a period of the filter takes {filter_samples:.0f} samples",
        "the log has only {reversals} reversals. Each reversal crosses the pre-sliding zone of {zone:length} in "
        "{samples:.0f} samples, but a period of the filter takes {filter_samples:.0f} samples",
        "each of {reversals} reversals crosses the pre-sliding zone of {zone:length} in {samples:.0f} samples, but a "
        "period of the filter takes {filter_samples:.0f} samples",
        "the effect on the {reversals} reversals of the log is smaller than the model error. These reversals are slow enough for the "
        "filter: they cross the pre-sliding zone of {zone:length} in {samples:.0f} samples, and a period of the filter takes "
        "{filter_samples:.0f} samples",
        choose=_crossed,
    ),
    "coarse_position": cause(
        "the pre-sliding zone is only a few encoder steps, or as small as the noise of the position",
        _FINER,
        "the pre-sliding zone of {zone:length} is less than {deviations:.0f} times the noise of the position "
        "({noise:length} standard deviation). Noise of this size also reverses friction",
        "the pre-sliding zone of {zone:length} is less than {counts:.0f} steps of the recorded position ({resolution:length} each)",
        choose=where("noise"),
    ),
    "coarse_elements": cause(
        "a part of the stiffness is in elements that slip within a few encoder steps",
        _FINER,
        "stiffness and virgin curve may be up to {percent:.0f} % too large for displacements below {counts:.0f} steps of the recorded "
        "position ({resolution:length} each). Elements that slip within these steps make up this share of the stiffness, and the encoder "
        "does not resolve them",
    ),
    "few_strokes": cause(
        "the log has too little sliding in both directions, or a force that is a straight line over the stroke",
        "move in both directions, with at least ten reversals, at several amplitudes up to the working stroke",
        "the log does not separate this force from other forces. It has {reversals} reversals over a stroke of {stroke:length}",
        "the force is a straight line over the stroke of the log, {stroke:length}",
        choose=where("reversals"),
    ),
    "small_effect": cause(
        "the parameter hardly changes the effort",
        "leave the parameter out, or excite it more strongly",
        "the effect of {parameter} on the effort is smaller than the model error",
    ),
    "beyond_effort": cause(
        "the best value is a force that the log never reached",
        "let the axis stick, break away and slide, or leave the parameter out",
        "the best value is far beyond the largest friction in this log, {effort:force}",
    ),
    "redundant": held(
        "the force depends only on {products:and}, so any value of {parameter} fits",
        "no log can identify the parameter, because the force depends only on its products with other parameters",
        "use the products, which the results list under `combinations`",
    ),
    # A parameter at the end of its range.
    "edge_no_fall": Sentence(
        (
            "in this log friction does not fall with speed. The best value is the smallest allowed value, {value:unit}",
        ),
        "the break-away force is no larger than sliding friction",
        "use a model without the Stribeck effect",
        "edge",
    ),
    "no_friction": Sentence(
        (
            "no force opposes the motion: the best value is {value:unit}. Likely causes, most common first: a wrong offset for gravity "
            '(write offset = "identify" under [plant]), a reversed sign of the effort, too large a mass in the axis file',
            "no force opposes the motion: the best value is {value:unit}. Likely causes, most common first: a reversed sign of the effort, "
            "too large a mass in the axis file",
        ),
        "the log shows no friction that opposes the motion",
        "identify the offset. If that does not help, correct the sign of the effort or the mass in the axis file",
        "edge",
        choose=lambda texts, numbers: texts["offset_identified" in numbers],
        also=("offset_identified",),
    ),
    "edge_of_model": Sentence(
        ("the best value is the {edge} allowed value, {value:unit}, because {cause}",),
        "the best value is the smallest or largest allowed value of the model",
        "see `cause`, a code of this table",
        "edge",
    ),
    "edge_of_search": Sentence(
        (
            "the search ended at the {edge} value that this log could show, {value:unit}, because {cause}",
        ),
        "the best value is outside the range that the log can show",
        "see `cause`, a code of this table",
        "edge",
    ),
    # A parameter that is held constant.
    "held_known": held("given as known", "the user gave the value, so bristle did not fit it"),
    "held_default": held(
        "the default value of a shape parameter",
        "bristle fits a shape parameter only on request",
        "identify the parameter with --free",
    ),
    "held_plant_damping": held(
        "a force that the plant already has, by its damping or its spring",
        "the damping or the spring of the plant already includes this force",
    ),
    "held_levels": held(
        "confounded with the difference between {levels[0]} and {levels[1]}",
        "the offset is confounded with friction that differs by direction",
        "write `offset` under [plant] of the axis file if you know it",
    ),
    "held_constant": held(
        "half of the difference in effort between the directions, probably a weight. {levels:list} are confounded with this "
        "offset. With an offset of zero, one of these levels would be negative",
        "a constant force is larger than friction",
        "write `offset` under [plant] of the axis file if you know it",
    ),
    "held_one_direction": held(
        "confounded with {level}, because the log moves {direction} only",
        "in one direction, offset and friction are confounded",
        "move in both directions",
    ),
    "held_one_speed": held(
        "confounded with elements that slip immediately, because the log has a single speed",
        "at a single speed, viscous friction is confounded with Coulomb friction",
        _SPEEDS,
    ),
    "held_middle": held(
        "the middle of the position range of the log",
        "bristle chose the origin of the position in a slot",
    ),
    "held_half_range": held(
        "half of the position range of the log",
        "bristle chose the length by which a slot divides the position",
    ),
    "held_pitch": held(
        "the lead of the axis file, or the period in the residual of a simple friction model",
        "bristle took the pitch of the screw from the axis file or from the residual",
    ),
}


_CURVE = "the measured curve of friction over speed differs from that of the model by {force:force} rms, {percent:.2g} % of friction"

_COMPARED = "bristle also compared `{compared}`, but its error is no smaller"


def _missing(text: str, by_model: str, without: str, means: str) -> Sentence:
    """Return the sentence about a force that a model lacks, with the next model to try or without."""
    return Sentence(
        (f"{text}. Next: try {by_model}", f"{text}. {_COMPARED}", f"{text}. {without}"),
        means,
        "try the suggested model",
        choose=where("model", "compared"),
        also=("share_percent",),
    )


STRUCTURE: dict[str, Sentence] = {
    "structure": Sentence(
        (
            "the model lacks a force. {missing:force} of the residual (root mean square, {percent:.2g} % of friction) repeats on held-out "
            "half-cycles. It is physics, not noise: noise and scatter explain only {chance:force}. The likely causes follow",
            ". {names:list} are effective: valid for this model and similar motions, but biased for the axis. Their intervals are wider "
            "because of this force",
            "the model lacks a force, too small to matter in use. {missing:force} of the residual (root mean square, {percent:.2g} % "
            "of friction) repeats on held-out half-cycles. Noise and scatter explain only {chance:force}. The likely causes follow",
        ),
        "the model lacks forces",
        "try the suggested model. Until then, treat parameters and intervals as effective",
        choose=lambda texts, numbers: (
            texts[2 if numbers["small"] else 0] + (texts[1] if numbers["names"] else "")
        ),
        also=("causes", "small"),
    ),
    "missing_speed": Sentence(
        (
            _CURVE + ". No model of bristle has a better curve",
            _CURVE + ". Next: try `{model}`",
            _CURVE + ". Next: try `{model}`, also with its exponent identified (`--free delta_S`)",
            _CURVE + ". " + _COMPARED,
        ),
        "the curve of friction over speed differs from that of the model",
        "try the suggested model",
        choose=lambda texts, numbers: texts[
            3 if numbers["compared"] else ("", "lugre", "stribeck_free").index(numbers["model"])
        ],
        also=("share_percent",),
    ),
    "missing_direction": _missing(
        "friction differs between the directions. The missing part is {force:force} rms, {percent:.2g} % of friction",
        "`{model}`",
        "This model already has separate parameters for each direction: check load and cables",
        "friction differs between the directions",
    ),
    "missing_lag": _missing(
        "friction lags the speed. The missing part is {force:force} rms, {percent:.2g} % of friction",
        "`{model}`, in which the sliding force lags",
        "This model already has such a lag: look for a filter in a channel of the log",
        "friction lags the speed",
    ),
    "missing_play": Sentence(
        (
            "the drive has play. The missing part is {force:force} rms, {percent:.2g} % of friction. Where the force on the load changes "
            "its sign, the residual is {ratio:.2g} times larger than in the rest of the motion. No model of bristle has play. Check "
            "coupling and screw, and also record the position of the load",
        ),
        "the drive has play",
        "check coupling and screw, and also record the position of the load",
        also=("share_percent",),
    ),
    "missing_presliding": _missing(
        "friction builds up over a distance after each reversal, which this model lacks. The missing part is {force:force} rms, "
        "{percent:.2g} % of friction. An elastic drive has the same effect. A model with pre-sliding distinguishes the two causes",
        "`{model}`",
        "No other model of bristle describes this build-up differently",
        "friction builds up over a distance after a reversal",
    ),
    "elastic_load": Sentence(
        (
            "the load is coupled elastically. Motor effort to motor speed has an antiresonance at {antiresonance:.3g} Hz (95 % interval "
            "±{antiresonance_half_width:.2g} Hz) and a resonance at {resonance:.3g} Hz (±{resonance_half_width:.2g} Hz). The inertia of "
            "the load is {inertia_ratio:.2g} times that of the motor (±{inertia_ratio_half_width:.2g}). Keep loop and motion slower than "
            "the antiresonance, or record the position of the load",
            ". bristle fitted frequencies up to {cutoff:.3g} Hz, at which the axis is one mass: the inertia is that of motor and load",
            ". The stated cut-off of {cutoff:.3g} Hz is not far below the antiresonance, so a model of one mass is biased",
        ),
        "the load is coupled elastically",
        "keep loop and motion slower than the antiresonance, or record the position of the load",
        choose=lambda texts, numbers: texts[0] + texts[1 if numbers["one_mass"] else 2],
    ),
    "bodies_differ": says(
        "gravity of the bodies of the arm is not that of this joint: the effort also varies with the sine and cosine of the angle, up to "
        "{amplitude:force}. The model does not explain {force:force} of it (root mean square), {percent:.2g} % of friction. Next: record "
        "more poses and identify the arm again",
        "the bodies of the arm do not explain all gravity of this joint",
        "record more poses and identify the arm again. Check units and signs of all joints, and the direction of gravity in the robot file",
    ),
}
