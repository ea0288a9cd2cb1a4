"""Named bars with their numbers: variants of an experiment, causes of an error; and correlations with their intervals."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bristle.core import Kind, number, scale_of, unit_of
from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.drawing import label
from bristle.report.figures.first_screen import SIDE
from bristle.report.figures.report_figure import shown

MOST = 8  # bars of a small picture


def draw_bars(
    axes: style.Axes, values: Sequence[float], unit: str, word: str, colours: Sequence[str]
) -> None:
    """Draw a bar for each value with its number and unit behind it; a missing value has no bar."""
    finite = np.array([value for value in values if np.isfinite(value)])
    scale = scale_of(unit, style.largest(finite)) if unit else scale_of("1", 1.0)
    top = style.largest(finite) * scale.factor or 1.0
    for place, (value, colour) in enumerate(zip(values, colours, strict=True)):
        if np.isfinite(value):
            own = scale_of(unit, value) if unit else scale
            axes.barh(place, value * scale.factor, 0.55, color=colour)
            text = f" {number(value * own.factor, digits=3)} {own.unit if unit else ''}".rstrip()
            axes.text(
                max(value, 0.0) * scale.factor,
                place,
                text,
                color=style.INK,
                verticalalignment="center",
            )
    axes.set(xlim=(0.0, 1.45 * top), xlabel=scale.label(word) if unit else word)


@shown(
    "variants",
    "loops",
    "Error of each variant, peak to peak",
    "Blue: with friction feedforward.",
    draw=lambda draw, loops: draw(
        [variant.name for variant in loops.experiment.variants],
        [
            loops.variants[variant.name].compared_error.peak_to_peak
            for variant in loops.experiment.variants
        ],
        loops.experiment.kind,
        [variant.feedforward.friction is not None for variant in loops.experiment.variants],
        next(iter(loops.variants.values())).error_word,
    ),
    applies=lambda loops: len(loops.experiment.variants) > 1,
)
@shown(
    "causes",
    ("causes", "kind"),
    "Following error with all causes, and without each cause",
    "Error without each cause.",
    draw=lambda draw, causes, kind: draw(
        list(causes), list(causes.values()), kind, [False] * len(causes)
    ),
)
def named_bars(
    names: Sequence[str],
    values: Sequence[float],
    kind: Kind,
    alike: Sequence[bool],
    word: str = "Following error",
) -> Figure:
    """Return a bar of an error for each name, grey or, if marked, blue."""
    texts = [label(name) for name in names[:MOST]]
    figure, (axes,) = style.named_rows(
        texts, max(style.NAME, min(0.6, 2.4 / len(texts))), across=SIDE
    )
    colours = [LIGHT["with" if marked else "without"] for marked in alike[:MOST]]
    draw_bars(axes, values[:MOST], unit_of("length", kind), f"{word}, peak to peak", colours)
    axes.set_ylabel("Loop")
    return figure


@shown(
    "influence",
    "influence",
    "Rank correlation of each cause with the first number, with its 95 % interval",
    "Influence of each cause.",
)
def correlations(entries: Sequence[Mapping[str, Any]]) -> Figure:
    """Return rank correlations with their 95 % intervals; a filled point means that the interval excludes zero."""
    entries = sorted(entries, key=lambda entry: -abs(entry["value"]))[:MOST]
    figure, (axes,) = style.named_rows(
        [entry["cause"] for entry in entries],
        max(style.NAME, min(0.6, 2.4 / len(entries))),
        across=SIDE,
    )
    for place, entry in enumerate(entries):
        low, high = entry["interval"]
        axes.plot(
            [low, high],
            [place, place],
            color=LIGHT["with"],
            linewidth=style.WIDE,
            label="_95 % interval",
        )
        face = LIGHT["ground"] if low <= 0.0 <= high else LIGHT["with"]
        axes.plot(
            entry["value"],
            place,
            "o",
            color=LIGHT["with"],
            markerfacecolor=face,
            markersize=style.SMALL,
            label="_correlation",
        )
    axes.axvline(0.0, zorder=0, **style.AID)
    axes.set(xlim=(-1.05, 1.05), xlabel="Rank correlation [–]", ylabel="Cause")
    return figure
