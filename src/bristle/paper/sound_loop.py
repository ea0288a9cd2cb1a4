"""Beyond figure 12: the same motion at sound margins, and the printed equations over the break-away torque."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.lazy import cached_property
from bristle.core.typography import number
from bristle.paper.tracking import BEFORE, PRINTED, WITH_CONSTANT, Tracked, spread_of, with_spread
from bristle.report.table import Table
from bristle.simulation import VariantResult
from bristle.stability import assess

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Sound", "break_away_extra", "sound_extra", "sound_table"]

PART = {
    BEFORE: "no compensator",
    PRINTED: "(5)–(7) as printed",
    WITH_CONSTANT: "(5)–(7) and a constant",
    "paper": "operator × 0.64, calibrated",
    "identified": "model identified on the rig",
    "observer": "observer, no model",
    "observer_feedforward": "observer and identified model",
}
IN_PAPER = 0.69e-6


@dataclass(frozen=True)
class Sound:
    """Two experiments beside that of figures 11 to 14."""

    loop: Tracked
    levels: Tracked

    @cached_property
    def margins(self) -> dict[str, tuple[float, float]]:
        """Smallest phase margin [degrees] and gain margin of each variant, whatever its friction does."""
        least = {}
        for variant in self.loop.experiment.variants:
            points = [point.margins for point in assess(variant).points]
            phases, gains = [point.phase for point in points], [point.gain for point in points]
            least[variant.name] = _least(phases), _least(gains)
        return least

    @property
    def at_levels(self) -> list[tuple[float, VariantResult]]:
        """Break-away torque at the screw [N*m] and the loop with it."""
        return [
            (self.levels.arm * variant.feedforward.friction.values["F_S"], self.levels.result.variants[variant.name])
            for variant in self.levels.experiment.variants
            if variant.feedforward.friction is not None
        ]

    @property
    def numbers(self) -> dict[str, Any]:
        """What was found, for the summary."""
        return {
            "at_sound_margins": {name: loop.as_dict() for name, loop in self.loop.result.variants.items()},
            "margins": {name: {"phase_deg": phase, "gain": gain} for name, (phase, gain) in self.margins.items()},
            "over_break_away": [
                {"break_away": level, "peak_to_peak": loop.following_error.peak_to_peak, "mean": loop.following_error.mean}
                for level, loop in self.at_levels
            ],
        }


def sound_table(sound: Sound) -> Table:
    """Return what each part brings at sound margins."""
    rows = []
    for name, loop in sound.loop.result.variants.items():
        phase, gain = sound.margins[name]
        cells = [
            with_spread(1e6 * value, 1e6 * spread_of(loop, key, "peak_to_peak"), 0.01)
            for key, value in (("following_error", loop.following_error.peak_to_peak), ("true_error", loop.true_error.peak_to_peak))
        ]
        rows.append((name, PART.get(name, ""), *cells, number(phase, digits=3), number(gain, digits=3)))
    heads = ("Variant", "Against friction works", "Peak to peak [µm]", "True error [µm]", "Phase margin [°]", "Gain margin")
    return Table("The same motion in a loop of sound margins", heads, rows)


def sound_extra(sound: Sound) -> tuple[Callable[[], Figure], str, str]:
    """Return the following error at sound margins: how to draw it, what it is, what to see in it."""

    def draw() -> Figure:
        from bristle.figures import tracking_error

        loops = {PART[name]: loop for name, loop in sound.loop.result.variants.items() if name in PART}
        return tracking_error(loops, sound.loop.settle)

    least = min(phase for phase, _ in sound.margins.values())
    return (
        draw,
        "Following error over time in a loop of sound margins, by what works against friction",
        f"The same motion with gains that a person would run, at phase margins of {number(least, digits=2)}° and more: "
        "what each part brings.",
    )


def break_away_extra(sound: Sound) -> tuple[Callable[[], Figure], str, str]:
    """Return the error over the break-away torque: how to draw it, what it is, what to see in it."""

    def draw() -> Figure:
        from bristle.figures import error_over

        errors = [loop.following_error.peak_to_peak for _, loop in sound.at_levels]
        spreads = [spread_of(loop, "following_error", "peak_to_peak") for _, loop in sound.at_levels]
        ends = [(error, error - spread, error + spread) for error, spread in zip(errors, np.nan_to_num(spreads), strict=True)]
        return error_over(
            [1e3 * level for level, _ in sound.at_levels],
            {"found": 1e6 * np.array(ends)},
            {"the paper reports": 1e6 * IN_PAPER},
            "Break-away torque of (7) [mN·m]",
            "Error, peak to peak [µm]",
        )

    return (
        draw,
        "Following error with the printed equations over the break-away torque that is assumed in them",
        "Equations (5) to (7) with gain 1, by the break-away torque that they assume; the paper tells none. Bars: "
        "standard deviation over the runs.",
    )


def _least(margins: list[float | None]) -> float:
    """Return the smallest margin; infinite where the open loop does not cross over."""
    return min((margin for margin in margins if margin is not None), default=math.inf)
