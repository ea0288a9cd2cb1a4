"""Figures of the runs of a study as distributions, and of the logs of a fleet with their intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle.core import scale_of
from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.drawing import AT_TICKS, shortened, shortened_apart
from bristle.report.figures.first_screen import LOW, SIDE, TALL
from bristle.report.figures.report_figure import shown

if TYPE_CHECKING:
    from bristle.apps.study.store import Runs

HOLLOW = "Hollow: outlier or measure again. Arrow: beyond the panel."
OF_FLEET = ("fleet", "names", "apart", "labels", "again")
REACH = 5.0  # spreads from the median to the edge of a panel
MOST_NAMES = 24  # at an axis
TURNED = 6  # names at an axis; more are turned


@shown(
    "spread",
    ("study", "spread"),
    lambda study, spread: f"Distribution of {', '.join(spread)} over the runs",
    lambda study, spread: (
        "Distribution of each number over the runs. "
        + (
            "A line for each point of the grid."
            if study.described["grid"]
            else "Shaded: the middle 90 % of the runs."
        )
    ),
    draw=lambda draw, study, spread: draw(
        {words: groups for words, _, groups in spread.values()},
        [unit for _, unit, _ in spread.values()],
    ),
    applies=lambda study, spread: len(spread) > 1,
)
@shown(
    "distribution",
    "first_spread",
    lambda spread: f"Distribution over the runs: {spread[0]}",
    draw=lambda draw, spread: draw({spread[0]: spread[2]}, [spread[1]]),
)
def study_spread(numbers: Mapping[str, Mapping[str, np.ndarray]], units: Sequence[str]) -> Figure:
    """Return the distribution of each number, with its median and its quantiles at 5 and 95 %; a single number as a large picture."""
    grouped = any(len(groups) > 1 for groups in numbers.values())
    alone = len(numbers) == 1
    if alone:
        figure, (panels,) = style.panels(TALL, top=style.TOP if grouped else 0.12)
    else:
        figure, panels = style.grid_of(len(numbers), top=0.5 if grouped else 0.25)
    for axes, (word, groups), unit in zip(panels, numbers.items(), units, strict=True):
        finite = {name: values[np.isfinite(values)] for name, values in groups.items()}
        pooled = np.concatenate(list(finite.values()))
        scale = scale_of(unit, style.largest(pooled))
        bars = int(np.clip(np.sqrt(pooled.size / len(finite)), 8, 60))
        for place, (name, values) in enumerate(finite.items()):
            edges = np.histogram_bin_edges(values * scale.factor, bars)
            share = style.shares(values * scale.factor, edges)
            look = style.LINES[place % len(style.LINES)]
            if not grouped:
                axes.stairs(share, edges, fill=True, color=style.BARS, label="_bars")
                look = style.PREDICTED
            axes.stairs(
                share,
                edges,
                color=look["color"],
                linestyle=look["linestyle"],
                linewidth=1.1,
                label=name,
            )
        if not grouped and pooled.size:
            low, median, high = np.quantile(pooled, (0.05, 0.5, 0.95)) * scale.factor
            axes.axvline(median, label="median", **style.DASHED)
            axes.axvspan(
                low, high, color=style.PALE, linewidth=0, zorder=0, label="90 % of the runs"
            )
            if alone:
                axes.text(
                    median,
                    0.97,
                    " median",
                    transform=axes.get_xaxis_transform(),
                    color=style.INK,
                    verticalalignment="top",
                )
        axes.set(
            ylim=(0.0, None),
            xlabel=scale.label(shortened(word, style.LONGEST, AT_TICKS)),
            ylabel="Share of the runs [%]",
        )
    if not alone:
        style.legend_in_corner(figure, panels[0])
    elif grouped:
        style.legend(panels[0])
    return figure


@shown(
    "fleet",
    OF_FLEET,
    lambda runs, names, apart, labels, again: f"{', '.join(names)} of each log with 95 % intervals",
    f"Each log with its 95 % interval. Dashed: the median. Tick at the bottom: no value. {HOLLOW}",
    applies=lambda runs, names, apart, labels, again: len(names) > 1,
)
def fleet_parameters(
    runs: Runs,
    names: Sequence[str],
    apart: Mapping[str, np.ndarray],
    labels: Sequence[str] = (),
    again: Sequence[int] = (),
) -> Figure:
    """Return the parameters of a fleet, log by log; outliers, by column in `apart`, and logs to measure `again` are hollow."""
    gap = 0.66  # [inch]
    if len(labels) > TURNED:
        gap = 1.15
    figure, panels = style.grid_of(len(names), between=0.8, gap=gap, bottom=_room_below(labels))
    for axes, name in zip(panels, names, strict=True):
        _draw(axes, runs, name, np.union1d(apart[name], again).astype(int), labels)
    richest = max(panels, key=lambda axes: len(axes.get_legend_handles_labels()[1]))
    style.legend_in_corner(figure, richest)
    return figure


def _room_below(labels: Sequence[str]) -> float:
    """Return the space below a panel [inch] for the names of its logs."""
    if len(labels) > TURNED:
        return 0.95
    return 0.46


def _nth_parameter(place: int) -> Callable[[Callable[..., Figure]], Callable[..., Figure]]:
    """Offer the figure of a parameter of a fleet by its place: the first is the large picture."""
    name = "parameter"
    caption = HOLLOW
    if place:
        name = f"parameter_{place + 1}"
        caption = ""
    return shown(
        name,
        OF_FLEET,
        lambda runs, names, *_: f"{names[place]} of each log with its 95 % interval",
        caption,
        draw=lambda draw, runs, names, apart, *rest: draw(
            runs, names[place], apart[names[place]], *rest, large=not place
        ),
        applies=lambda runs, names, *_: len(names) > place,
    )


@_nth_parameter(0)
@_nth_parameter(1)
@_nth_parameter(2)
def fleet_parameter(
    runs: Runs,
    name: str,
    apart: np.ndarray,
    labels: Sequence[str],
    again: Sequence[int] = (),
    *,
    large: bool = True,
) -> Figure:
    """Return one parameter of a fleet, log by log, for the first screen; arguments as of `fleet_parameters`."""
    size: dict[str, Any] = {"across": SIDE, "height": LOW}
    if large:
        size = {"across": style.WIDTH, "height": TALL}
    figure, ((axes,),) = style.panels(
        bottom=_room_below(labels), right=style.room_for(["median"]), top=0.12, **size
    )
    _draw(axes, runs, name, np.union1d(apart, again).astype(int), labels)
    style.label_lines(axes)
    return figure


def _draw(
    axes: Axes, runs: Runs, name: str, strange_runs: np.ndarray, labels: Sequence[str]
) -> None:
    columns = runs.columns
    number = columns["run"].astype(float)
    tells = np.isfinite(columns[name]) & (columns[f"{name}.status"] == "identified")
    scale = scale_of(
        runs.described["columns"][name]["unit"],
        style.largest(np.median(np.abs(columns[name][tells]))),
    )
    value, low, high = (
        columns[key] * scale.factor for key in (name, f"{name}.lower", f"{name}.upper")
    )
    low = np.fmin(low, value)
    high = np.fmax(high, value)
    strange = np.zeros(runs.count, dtype=bool)
    strange[strange_runs] = True
    # Whole intervals, as far as they lie within a few times the spread of the values.
    usual = tells & ~strange
    if not usual.any():
        usual = tells
    middle = float(np.median(value[tells]))
    ends = np.quantile(value[usual], (0.1, 0.9))
    spread = (
        max(float(np.ptp(ends)), float(np.median(high[usual] - low[usual])))
        or 0.1 * abs(middle)
        or 1.0
    )
    reach = np.array([middle - REACH * spread, middle + REACH * spread])
    bottom, top = (
        float(edge(np.clip(side[tells], *reach))) for edge, side in ((np.min, low), (np.max, high))
    )
    edge = 0.05 * (top - bottom) or spread
    axes.axhline(middle, color=style.GREY, linewidth=0.8, linestyle="--", label="median")
    inside = tells & (value >= reach[0]) & (value <= reach[1])
    size = 3.4
    if runs.count > 60:  # smaller markers for many logs
        size = 2.0
    blue = style.PREDICTED["color"]
    for chosen, color, face, word in (
        (~strange, blue, blue, "_log, 95 % interval"),
        (strange, style.DOUBTFUL, LIGHT["ground"], "_outlier, or measure again"),
    ):
        chosen = chosen & inside
        if chosen.any():
            look = {
                "fmt": "o",
                "markersize": size,
                "markerfacecolor": face,
                "linewidth": 0.8,
                "color": color,
            }
            axes.errorbar(
                number[chosen],
                value[chosen],
                np.abs([value - low, high - value])[:, chosen],
                label=word,
                **look,
            )
    beyond: style.Look = {
        "facecolors": "none",
        "edgecolors": style.DOUBTFUL,
        "s": 16,
        "label": "_beyond",
    }
    for chosen, marker, height, look in (
        (tells & (high > reach[1]), "^", 0.97, beyond),
        (tells & (low < reach[0]), "v", 0.03, beyond),
        (~tells, "|", 0.0, {"color": style.INK, "s": 49, "label": "_no value", "clip_on": False}),
    ):
        axes.scatter(
            number[chosen],
            np.full(chosen.sum(), height),
            marker=marker,
            transform=axes.get_xaxis_transform(),
            **look,
        )
    axes.set(
        ylim=(bottom - edge, top + edge),
        xlim=(float(number.min()) - 0.6, float(number.max()) + 0.6),
        xlabel="Log",
    )
    if labels:
        few = slice(None, None, -(-len(labels) // MOST_NAMES))
        room = 0.8  # [inch] for a name
        rotation = 0.0
        if len(labels) > TURNED:
            room = 0.5
            rotation = 90.0
        axes.set_xticks(
            number[few], shortened_apart(list(labels), room, AT_TICKS)[few], rotation=rotation
        )
    else:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(
        scale.label(
            shortened(name.removeprefix("plant.").removeprefix("friction."), style.NARROW, AT_TICKS)
        )
    )
