"""What a model has no place for, told from what its fit leaves over, and the model to try next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bristle.report.sentences.sentence import Sentence, says

__all__ = ["STRUCTURE"]

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
        (f"{text}. Next: {by_model}", f"{text}; {without}", f"{text}. {_COMPARED}"),
        means,
        "try the model that is named",
        choose=lambda texts, numbers: texts[0 if numbers["model"] else 2 if numbers["compared"] else 1],
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
    "missing_play": _missing(
        "the force around reversals builds up over another way than in the model, as with play in the drive: "
        "{force:force}, {percent:.2g} % of friction",
        "`{model}`",
        "no model of bristle has play: record the position behind it too, and look for it in coupling and screw",
        "the force around reversals builds up in another way, as with play",
    ),
    "missing_flanks": Sentence(
        (
            "what the model leaves over is {ratio:.2g} times as large where the force on the load changes its side as "
            "elsewhere amid motion: {force:force}, {percent:.2g} % of friction. So knocks a drive with play from one "
            "flank to the other; no model of bristle has play: record the position behind it too, and look for it in "
            "coupling and screw",
        ),
        "the drive knocks where the force on the load changes its side, as with play",
        "look for play in coupling and screw, and record the position behind it too",
        also=("share_percent",),
    ),
    "missing_presliding": _missing(
        "the force builds up over a distance after each reversal, which this model does not have: {force:force}, "
        "{percent:.2g} % of friction",
        "`{model}`",
        "no model of bristle has another way of building up",
        "the force builds up over a distance",
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
    "missing_gravity": says(
        "the effort goes with the sine and cosine of the angle, as the gravity of a link does: up to "
        "{amplitude:force}, of which the model misses {force:force} (root mean square), {percent:.2g} % of friction. "
        'Next: write `gravity = "link"` under `[plant]` of the axis file',
        "gravity turns with the angle, and the plant has none",
        'write `gravity = "link"` under `[plant]` of the axis file',
    ),
    "missing_load": _missing(
        "friction changes with the recorded load: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model changes with the load already",
        "friction changes with the load",
    ),
    "missing_temperature": _missing(
        "friction changes with the recorded temperature: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model changes with the temperature already",
        "friction changes with the temperature",
    ),
    "missing_channel": _missing(
        "friction changes with the recorded {channel}: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model either changes with it already, or has nothing that could",
        "friction changes with a further channel of the log that a slot of bristle depends on",
    ),
    "missing_transmitted": _missing(
        "friction rises with the effort that passes on to the load, as in a gear: {force:force}, {percent:.2g} % of it",
        "`{model}`",
        "this model either rises with it already, or has no level of its own that could",
        "friction rises with the effort that passes on to the load",
    ),
}
