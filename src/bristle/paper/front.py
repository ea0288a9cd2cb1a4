"""The first page of the paper's report: which of its claims hold here, with numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from bristle.core.typography import number
from bristle.paper.errata import ERRATA
from bristle.paper.following import COMPENSATED, IN_PAPER
from bristle.paper.reproduced import Reproduced, percent
from bristle.paper.tracking import BEFORE, CALIBRATED, NAMES, PRINTED, WITH_CONSTANT, with_spread
from bristle.report.page import Front, Picture, Ruling, about, answered, picture
from bristle.report.table import length_text

__all__ = ["paper_front", "paper_ruling"]

HEADING = "The source paper, rebuilt figure by figure"
HOLDS, UNTESTED = ("found",), ("shown",)
STANDS = {
    "found": "nothing chosen",
    "built in": "built into the rig",
    "calibrated": "calibrated",
    "found in part": "nothing chosen, holds in part",
    "built in in part": "nothing chosen for one half, the other built into the rig",
    "refuted": "does not hold",
}
"""How claims stand."""
SINGLE = {
    "found in part": "holds here in part",
    "built in in part": "holds here, one half of it built into the rig",
    "built in": "is built into the rig",
    "calibrated": "holds here by calibration",
    "refuted": "does not hold here",
}
"""How a single claim stands that does not hold with nothing chosen for it."""
CLAIMS = {
    1: "LuGre does not come back",
    2: "LuGre drifts",
    3: "the contact does not",
    4: "the sum below the staircase",
    5: "hysteresis before break-away",
    6: "two numbers replace a plane",
    8: "break-away near 7\u00a0µm",
    9: "wiping-out of the contact",
    10: "wiping-out of the model",
    11: "the table follows more closely",
    12: "53\u00a0% less error",
    13: "a narrower error",
    14: "no excessive effort",
}
"""The claims in short, by figure."""
BESIDE = {
    "lugre": "LuGre",
    "gate": "(5)–(7) with a gate",
    "identified": "a model, identified",
    "observer": "an observer, no model",
    "observer_feedforward": "both",
}
"""What else runs in the loop of the paper, and what it is."""
REPORTED = {BEFORE: "the paper, no compensator", COMPENSATED: "the paper, its compensator"}
FOLLOWING, EFFORT = 12, 14  # figures


def paper_ruling(figures: Sequence[Reproduced]) -> Ruling:
    """Return how many claims of the paper hold here, and which do not, or not as it says."""
    tested = [figure for figure in figures if figure.verdict not in UNTESTED]
    if not tested:
        return Ruling("with_care", "Nothing was claimed that could be tested")
    held = [figure for figure in tested if figure.verdict in HOLDS]
    groups = {words: [figure for figure in tested if figure.verdict == verdict] for verdict, words in STANDS.items()}
    reasons = [f"{words}: {len(group)}, {_named(group)}" for words, group in groups.items() if group]
    refuted = all(figure.verdict == "refuted" for figure in tested)
    level = "usable" if len(held) == len(tested) else "no" if refuted else "with_care"
    if len(tested) > 1:
        words = f"{len(held)} of {len(tested)} claims of the paper hold here with nothing chosen for them"
    else:
        words = f"Its claim {'holds here with nothing chosen for it' if held else SINGLE[tested[0].verdict]}"
    return Ruling(level, words, tuple(reasons))


def _named(figures: Sequence[Reproduced]) -> str:
    """Return claims in short, each with its figure."""
    return ", ".join(f"{CLAIMS[figure.number]} ({figure.number})" for figure in figures)


def paper_front(figures: Sequence[Reproduced]) -> Front:
    """Return the first page of the figures that were rebuilt."""
    ruling, by_number = paper_ruling(figures), {figure.number: figure for figure in figures}
    loop, effort = by_number.get(FOLLOWING), by_number.get(EFFORT)
    kinds = Counter(erratum.kind for erratum in ERRATA)
    wrong = ", ".join(f"{count} {kind}{'s' if count > 1 else ''}" for kind, count in kinds.items())
    answers = answered(
        _quality(loop) if loop else [figure.found[0].rstrip(".") for figure in figures[:3]],
        ["its experiments, to be changed: `bristle paper --write DIR`, then `bristle run DIR/set_a.toml`"],
        _cost(effort) if effort else ["its figure 14 tells: `bristle paper`"],
        [
            "the rig is of another structure than the compensators of the paper: thirty elements that scatter",
            f"{len(ERRATA)} remarks on what is printed, each with a test: {wrong}",
        ],
        ["what you have changed: `bristle paper --from DIR`", "your own axis: `bristle identify log.csv --axis axis.toml --model all`"],
    )
    facts = about("simulated rig", f"{len(figures)} {'figure' if len(figures) == 1 else 'figures'}")
    return Front(HEADING, facts, ruling, answers, "claims", ALL_HOLD, _picture(loop))


ALL_HOLD = "Each claim comes out with nothing chosen for it."


def _quality(loop: Reproduced) -> list[str]:
    """Return the following error here and in the paper, without and with its compensator, and at sound margins."""
    errors = {name: _error(loop.numbers, name) for name in (BEFORE, PRINTED, CALIBRATED)}
    variant = PRINTED if errors[PRINTED] else CALIBRATED
    paper = " to ".join(f"{1e6 * value:.2f}\u00a0µm" for value in IN_PAPER.values())
    lines = [
        f"following error, peak to peak: {errors[BEFORE]} without a compensator, {errors[variant]} with "
        f"{NAMES[variant]}; the paper: {paper}",
        f"that is {_less(loop.numbers['peak_to_peak'], variant)} less; the paper: {_less(IN_PAPER, COMPENSATED)}",
    ]
    sound = loop.numbers.get("at_sound_margins", {})
    if BEFORE in sound:
        peaks = {name: _peak_of(sound[name]) for name in (BEFORE, PRINTED, WITH_CONSTANT, *BESIDE) if name in sound}
        listed = "; ".join(f"{NAMES.get(name) or BESIDE[name]} {length_text(value, 'translational')}" for name, value in peaks.items())
        lines.append(f"in a loop of sound margins: {listed}")
    return lines


def _less(errors: Mapping[str, float], name: str) -> str:
    return percent(1.0 - errors[name] / errors[BEFORE], 1.0)


def _cost(effort: Reproduced) -> list[str]:
    """Return the effort of the loop, without and with what is fed forward."""
    rms = {name: value for name, value in effort.numbers["rms"].items() if name in NAMES}
    efforts = ", ".join(f"{number(1e3 * value, digits=3)}\u00a0mN·m {NAMES[name]}" for name, value in rms.items())
    return [f"effort, root mean square: {efforts}"]


def _error(numbers: Mapping[str, Any], name: str) -> str:
    if name not in numbers["peak_to_peak"]:
        return ""
    spread = numbers["peak_to_peak_spread"].get(name, 0.0)
    return f"{with_spread(1e6 * numbers['peak_to_peak'][name], 1e6 * spread, 0.01)}\u00a0µm"


def _peak_of(loop: Mapping[str, Any]) -> float:
    return float(loop["following_error"]["peak_to_peak"])


def _picture(loop: Reproduced | None) -> Picture | None:
    """Return the following error of each loop beside what the paper tells; None where the loop was not rebuilt."""
    if loop is None:
        return None
    from bristle.figures import errors_by_loop

    peaks, spreads = (loop.numbers[name] for name in ("peak_to_peak", "peak_to_peak_spread"))
    names = {name: NAMES.get(name, BESIDE.get(name, name)) for name in peaks}
    best = min(peaks, key=peaks.get)
    alternative = "Following error of each loop, peak to peak, beside what the paper tells"
    caption = f"{alternative}. The least: {number(1e6 * peaks[best], digits=2)} µm, {names[best]}."
    return picture(
        "paper-first",
        lambda: errors_by_loop(
            {names[name]: 1e6 * value for name, value in peaks.items()},
            {names[name]: 1e6 * value for name, value in spreads.items()},
            {REPORTED[name]: 1e6 * value for name, value in IN_PAPER.items()},
            "Following error [µm], peak to peak",
        ),
        alternative,
        caption,
        file="figure-00",
        published=f"{caption} The rig is simulated.",
    )
