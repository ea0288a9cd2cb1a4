"""The cards of an identification: mass, friction, build-up distance and model error, each with its interval; and the next step."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bristle.core import DEVIATION_OVER_MEDIAN, NORMAL_95, Axis, number, scale_of, typeset, unit_of
from bristle.prediction import drive_units, level_values, reversal_distance
from bristle.report.table import capital, percent_text

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit
    from bristle.prediction import Following
    from bristle.report.compensation import Gain
    from bristle.simulation import SimulationResult

LARGEST = 100.0  # half-width of an interval that says something [%]
WIDEST = 30.0  # half-width that fills an interval bar [%]
DRAWS = 16  # for the interval of a distance


class Card(NamedTuple):
    """One number of the first screen: its label, its value as text, remarks, and the half-width of its 95 % interval [% of the value].

    A number without an interval is `open`; `sliders` are the names of the parameters that move it.
    """

    label: str
    value: str
    remark: str = ""
    half: float | None = None
    open: bool = False
    sliders: tuple[str, ...] = ()

    @property
    def reach(self) -> float:
        """Half the length of the interval bar [% of the room]."""
        return 0.0 if self.half is None else max(1.0, 50.0 * min(self.half / WIDEST, 1.0))

    @property
    def half_text(self) -> str:
        """The half-width as text."""
        return "" if self.half is None else f"± {number(self.half, digits=2)} %"


class Line(NamedTuple):
    """One fact of a terminal with its label; `level` is that of a verdict, and a `command` to copy is never wrapped."""

    label: str
    text: str
    level: str = ""
    command: str = ""


def labelled(label: str, texts: Sequence[str]) -> list[Line]:
    """Return lines with the label in front of the first."""
    return [Line("" if place else label, text) for place, text in enumerate(texts)]


COMPARE = "`bristle compare before.csv after.csv --axis axis.toml`"


class Step(NamedTuple):
    """The next step: a sentence, and a command to copy."""

    text: str
    command: str = ""

    @classmethod
    def of(cls, line: str) -> Step:
        """Return the step of a line with its command in backticks."""
        command = re.search(r"`([^`]+)`", line)
        return cls(
            capital(re.sub(r"[,:]? *(with|and measure the gain with)? *`[^`]+`", "", line)),
            command[1] if command else "",
        )

    def in_full(self, command: str) -> Step:
        """Return the step with options for the given command as the whole command, which writes into another folder."""
        try:
            words = shlex.split(command)
        except ValueError:  # a caller's own text, with an open quotation mark
            return self
        if not self.command.startswith("--") or words[:2] != ["bristle", "identify"]:
            return self
        replaced = {self.command.split()[0], "--out"}
        pairs = list(zip(["", *words], words, strict=False))
        folder = [f"{word}_2" for before, word in pairs if before == "--out"]
        rest = [
            word for before, word in pairs if word != "--force" and not {before, word} & replaced
        ]
        return self._replace(
            command=shlex.join(
                [*rest, *self.command.split(), *(["--out", *folder] if folder else [])]
            )
        )


def cards_of(fit: Fit, axis: Axis | None, *, usable: bool) -> list[Card]:
    """Return the cards of a fit; without numbers to type in if the log is not usable."""
    kind = fit.plant.kind
    mass, friction = "Inertia" if kind == "rotational" else "Mass", "Lowest sliding friction"
    if not usable:
        return [
            Card(mass, "–", "measure again", open=True),
            Card(friction, "–", "measure again", open=True),
        ]
    cards = (
        _mass(mass, fit, axis),
        friction_card(friction, fit, axis),
        distance_card(fit, axis),
        error_card(fit),
    )
    return [card for card in cards if card is not None]


def error_card(fit: Fit) -> Card:
    """Return the card of the model error."""
    held_out = (
        "no held-out test"
        if fit.held_out is None
        else f"{percent_text(fit.held_out.mean_percent)} held out"
    )
    return Card("Model error", percent_text(fit.error_percent), held_out)


def gain_card(gain: Gain) -> Card:
    """Return the card of the gain of friction feedforward."""
    label, _, change = gain.headline.partition(": ")
    change, _, factor = change.rpartition(", ")
    return Card("Gain, simulated", factor, f"{label.lower()} of one mass: {change}")


def no_gain(
    simulation: SimulationResult | None,
    following: Following | None,
    axis: Axis | None,
    *,
    usable: bool,
) -> Card:
    """Return the card of a gain that is unknown, with the reason."""
    reason = "a simulated loop is unstable"
    if not usable:
        reason = "measure again"
    elif simulation is None:
        without_loop = (
            "the log has no reference of a loop"
            if following is None
            else "the command was interrupted"
        )
        reason = (
            "the axis file has no controller"
            if axis is None or axis.controller is None
            else without_loop
        )
    elif following is not None and following.contradiction is not None:
        reason = "the simulated loop does not match the log"
    return Card("Gain", "–", reason, open=True)


def quantity_text(value: float, half: float | None, unit: str) -> str:
    """Return a number with its unit; its last digit is that of its half-width [% of the value], with 2 to 4 digits."""
    digits = 3 if not half else min(max(2 + math.floor(math.log10(100.0 / half)), 2), 4)
    scale = scale_of(unit, value)
    return f"{number(float(f'{value * scale.factor:.{digits}g}'), digits=digits)}\u00a0{scale.unit}"


def _mass(label: str, fit: Fit, axis: Axis | None) -> Card | None:
    inertia, levels, kind = fit.inertia, level_values(fit), fit.plant.kind
    if inertia is None or inertia.status == "held" or not inertia.value:
        return None
    if inertia.status != "identified":
        return Card(label, "–", "not identified", open=True)
    half = inertia.interval_percent
    value = inertia.value if levels is None else levels.inertia
    text = quantity_text(value, half, unit_of("mass", kind))
    at_motor = [
        quantity_text(of_motor.of(value), half, "kg*m^2")
        for of_motor in drive_units(axis, kind).inertias
    ]
    if at_motor:
        return Card(label, at_motor[0], f"at the motor ({text})", half, sliders=(inertia.name,))
    return Card(label, text, half=half, sliders=(inertia.name,))


def friction_card(label: str, fit: Fit, axis: Axis | None) -> Card:
    """Return the card of the lowest friction while sliding, in both directions."""
    levels, kind = level_values(fit), fit.plant.kind
    identified: list[Estimate] = [
        estimate
        for estimate in fit.estimates
        if estimate.name in fit.levels and estimate.status == "identified"
    ]
    if levels is None or levels.forward is None or levels.backward is None:
        return Card(label, "–", "not identified", open=True)
    half = max(
        (
            estimate.interval_percent
            for estimate in identified
            if estimate.interval_percent is not None
        ),
        default=None,
    )
    unit = unit_of("force", kind)
    sides = (levels.forward, levels.backward)
    scale = scale_of(unit, max(sides))
    in_si = f"{_pair([side * scale.factor for side in sides])}\u00a0{scale.unit}"
    names = tuple(name for name in fit.friction.values if not name.startswith("sigma"))
    # A multiple of the SI unit is no unit of a drive.
    efforts = [
        effort for effort in drive_units(axis, kind).efforts if not effort.name.endswith(unit)
    ]
    efforts.sort(key=lambda effort: "at the motor" in effort.name)  # the unit of the log first
    remark, first = "forward / backward", in_si
    if efforts:
        first = f"{_pair([efforts[0].of(side) for side in sides])}\u00a0{typeset(efforts[0].name)}"
        remark = f"forward / backward ({in_si})"
    is_known = all(
        estimate.status in ("identified", "held")
        for estimate in fit.estimates
        if estimate.name == "offset"
    )
    if levels.constant and is_known:
        constant = efforts[0].of(levels.constant) if efforts else levels.constant * scale.factor
        remark += f", constant {number(float(f'{constant:.3g}'), digits=3)}"
    return Card(label, first, remark, half, open=half is None, sliders=names)


def _pair(sides: list[float]) -> str:
    return " / ".join(number(float(f"{side:.3g}"), digits=3) for side in sides)


def distance_card(fit: Fit, axis: Axis | None) -> Card | None:
    """Return the card of the distance after a reversal over which friction makes 95 % of its change."""
    kind, fastest = fit.plant.kind, float(np.max(np.abs(fit.traces.velocity)))
    distance = reversal_distance(fit.friction, fastest)
    if not distance:
        return None
    drawn = () if fit.resampling is None else fit.resampling.bands.models(fit.friction, DRAWS)
    distances = np.array([reversal_distance(model, fastest) for model in drawn])
    # A draw that never builds up its friction has no finite distance.
    spread = (
        DEVIATION_OVER_MEDIAN * float(np.median(np.abs(distances - distance)))
        if distances.size > 1
        else None
    )
    half = None if spread is None else 100.0 * NORMAL_95 * spread / distance
    half = half if half is None or half <= LARGEST else None
    motor = [unit for unit in drive_units(axis, kind).lengths if "motor" in unit.name]
    at_motor = "".join(f" ({number(unit.of(distance), digits=2)} {unit.name})" for unit in motor)
    names = tuple(name for name in fit.friction.values if name.startswith("sigma"))
    text = quantity_text(distance, half, unit_of("length", kind))
    return Card(
        "Builds up over",
        text,
        f"after a reversal{at_motor}",
        half,
        open=half is None,
        sliders=names,
    )
