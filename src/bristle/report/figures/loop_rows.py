"""Loops that follow a reference, with a row or a panel for each; errors of loops and of true frictions compared."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from bristle.core import with_unit
from bristle.report.figures import style
from bristle.report.figures.drawing import label
from bristle.simulation import VariantResult

Loops = Mapping[str, "VariantResult"]
RANGE = "range in the paper"
MEAN_OVER = 0.05  # [s]: without the chatter of the encoder
FORWARD: style.Look = style.MEASURED | {"linewidth": 1.5}


def _rows(
    results: Loops, columns: int, top: float, between: float = 0.55
) -> tuple[Figure, list[list[style.Axes]]]:
    height = top + style.PANEL * len(results)
    return style.panels(
        height,
        rows=len(results),
        columns=columns,
        widths=(2.0, 1.0)[:columns],
        between=between,
        top=top,
    )


def _entitle(figure: Figure, grid: list[list[style.Axes]], results: Loops) -> None:
    """Put the legend of all rows into the corner, and the name of each loop above its row."""
    reach = style.legend_in_corner(figure, grid[0][0])
    for (first, *_), name in zip(grid, results, strict=True):
        style.title(first, name, beside=reach if first is grid[0][0] else 0.0)


@style.styled
def tracking(results: Loops, settle: float, close: tuple[float, float]) -> Figure:
    """Return reference and encoder reading over time, a row for each loop."""
    figure, grid = _rows(results, 2, 0.4)
    for (full, near), result in zip(grid, results.values(), strict=True):
        for axes, part in (
            (full, result.time >= settle),
            (near, (result.time >= close[0]) & (result.time <= close[1])),
        ):
            command = (result.reference[part], style.MEASURED, "command")
            encoder = (result.measured[part], style.PREDICTED, "encoder")
            scale = style.scale_for("length", "translational", command[0])
            style.over_time(axes, result.time[part], command, encoder, scale=scale, word="Position")
        style.mark_window(full, np.array(close))
        near.set_title("close up")
    _entitle(figure, grid, results)
    return figure


@style.styled
def tracking_error(results: Loops, settle: float) -> Figure:
    """Return the following error over time, a row for each loop."""
    figure, grid = _rows(results, 1, 0.4)
    # In the unit of the motion, as a thousandth of it.
    length = style.scale_for(
        "length", "translational", *(result.reference for result in results.values())
    )
    for (axes,), result in zip(grid, results.values(), strict=True):
        judged, forward = result.time >= settle, np.gradient(result.reference) > 0.0
        sides = [
            (np.where(moving, result.reference - result.measured, np.nan)[judged], look, label)
            for moving, look, label in (
                (forward, FORWARD, "moving forward"),
                (~forward, style.PREDICTED, "moving backward"),
            )
        ]
        style.over_time(axes, result.time[judged], *sides, scale=length, word="Following error")
    style.one_height([axes for row in grid for axes in row])
    _entitle(figure, grid, results)
    return figure


@style.styled
def error_distribution(
    results: Loops,
    settle: float,
    resolution: float,
    published: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Return the distribution of the following error, a panel for each loop."""
    length = style.scale_for(
        "length", "translational", *(result.reference for result in results.values())
    )
    errors = {
        name: (result.reference - result.measured)[result.time >= settle]
        for name, result in results.items()
    }
    low, high = (edge(float(edge(error)) for error in errors.values()) for edge in (min, max))
    width = 0.5 * resolution if resolution > 0.0 else (high - low) / 60.0
    edges = np.arange(np.floor(low / width), np.ceil(high / width) + 1.0) * width * length.factor
    figure, (row,) = style.panels(3.0, columns=len(results), between=0.3, top=0.56)
    for axes, (name, error) in zip(row, errors.items(), strict=True):
        mean, std = float(error.mean()) * length.factor, float(error.std()) * length.factor
        share = style.shares(error * length.factor, edges)
        axes.axvspan(
            mean - std,
            mean + std,
            color=style.PALE,
            linewidth=0,
            zorder=0,
            label="mean ± standard deviation",
        )
        axes.stairs(share, edges, fill=True, color=style.BARS, label="_bars")
        axes.stairs(share, edges, color=style.PREDICTED["color"], linewidth=0.9, label="_outline")
        axes.axvline(mean, label="mean", **style.DASHED)
        for end, word in zip((published or {}).get(name, ()), (RANGE, "_same"), strict=False):
            axes.axvline(end * length.factor, label=word, **style.DOTTED)
        style.title(axes, name)
        axes.set_xlabel(length.label("Following error"))
    style.one_height(row)
    style.share_y(row, "Share of the samples [%]")
    style.legend_in_corner(figure, row[0])
    return figure


@style.styled
def control_effort(
    results: Loops, settle: float, close: tuple[float, float], arm: float = 1.0
) -> Figure:
    """Return the driving torque of each loop and friction: averaged over all the motion, and close up without averaging."""
    scale, word = style.effort_scale(
        "rotational", *(arm * result.effort for result in results.values())
    )
    driving = f"Driving {word.lower()}"
    figure, grid = _rows(results, 2, 0.56, 0.6)
    for (full, near), (name, result) in zip(grid, results.items(), strict=True):
        close_up = (result.time >= close[0]) & (result.time <= close[1])
        for axes, part, span in ((full, result.time >= settle, MEAN_OVER), (near, close_up, 0.0)):
            driven_by, lost = (
                _averaged(arm * signal, result.time, span)[part]
                for signal in (result.effort, result.friction)
            )
            beneath = {"zorder": 1.5} if span else {}  # the averaged effort, which it nearly equals
            signals = (
                (driven_by, style.PREDICTED, driving.lower()),
                (lost, style.MEASURED | beneath, "friction"),
            )
            style.over_time(axes, result.time[part], *signals, scale=scale, word=driving)
        style.mark_window(full, np.array(close))
        style.title(full, f"{name}, mean over {with_unit(MEAN_OVER, 's')}")
        near.set_title("close up, not averaged")
    for panels in zip(*grid, strict=True):
        top = 1.06 * max(float(np.max(np.abs(axes.dataLim.intervaly))) for axes in panels)
        for axes in panels:
            axes.set_ylim(-top, top)
    style.legend_in_corner(figure, grid[0][0])
    return figure


def _averaged(effort: np.ndarray, time: np.ndarray, duration: float) -> np.ndarray:
    """Return an effort averaged over a time around each sample; unchanged for a time of 0."""
    count = max(round(duration / float(time[1] - time[0])), 1)
    return np.convolve(effort, np.ones(count), "same") / np.convolve(
        np.ones(effort.size), np.ones(count), "same"
    )


MARKS = [share * decade for decade in (0.1, 1.0, 10.0) for share in (1.0, 2.0, 5.0)]
LOOKS = tuple(style.SERIES[place] for place in (4, 0, 2, 1))
OWN_ERROR, PUBLISHED = "here, mean ± standard deviation", "as published"


class Spread(NamedTuple):
    """An error, the ends of its interval, and its smallest and largest mean under all conditions."""

    error: float
    low: float
    high: float
    least: float
    most: float


@style.styled
def error_over(
    places: Sequence[float],
    errors: Mapping[str, np.ndarray],
    levels: Mapping[str, float],
    place_name: str,
    error_name: str,
    *,
    counted: bool = False,
) -> Figure:
    """Return errors over an assumed or counted number: a line for each name, with bars to low and high."""
    figure, ((axes,),) = style.panels(3.1, names=[*errors, *levels])
    looks = style.SERIES if len(errors) > 1 else style.SERIES[1:]
    for number, ((name, values), look) in enumerate(zip(errors.items(), looks, strict=False)):
        finite = np.isfinite(values).any(axis=1)
        aside = 1.0 + 0.04 * (number - 0.5 * (len(errors) - 1)) * counted
        at, (error, low, high) = aside * np.asarray(places)[finite], values[finite].T
        axes.plot(at, error, label=label(name), markersize=style.SMALL, **look)
        axes.vlines(at, low, high, color=look["color"], linewidth=1.0, label=f"_{label(name)}")
    for name, level in levels.items():
        axes.axhline(level, label=label(name), **style.DOTTED)
    if counted:
        axes.set_xscale("log")
        axes.set_xticks(list(places), [f"{place:g}" for place in places])
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.06, y=0.1)
    axes.set(ylim=(0.0, None), xlabel=place_name, ylabel=error_name)
    style.legend(axes)
    return figure


@style.styled
def errors_by_loop(
    errors: Mapping[str, float],
    spreads: Mapping[str, float],
    published: Mapping[str, float],
    error_name: str,
) -> Figure:
    """Return the error of each loop, and published errors, a row for each."""
    figure, (axes,) = style.named_rows([*errors, *published])
    color = style.PREDICTED["color"]
    for row, (name, error) in enumerate(errors.items()):
        spread = spreads.get(name, 0.0)
        axes.hlines(
            row, error - spread, error + spread, color=color, linewidth=style.WIDE, label="_spread"
        )
        axes.plot(error, row, "o", color=color, label=f"_{OWN_ERROR}" if row else OWN_ERROR)
    for row, value in enumerate(published.values(), len(errors)):
        axes.plot(
            value,
            row,
            "D",
            fillstyle="none",
            color=style.INK,
            label=f"_{PUBLISHED}" if row > len(errors) else PUBLISHED,
        )
    # Numbers are above the marks, for any size of the page.
    for row, value in enumerate([*errors.values(), *published.values()]):
        axes.annotate(
            f"{value:.2f}",
            (value, row),
            (0, 5),
            textcoords="offset points",
            ha="center",
            fontsize=7.5,
        )
    axes.set(
        xlim=(0.0, 1.1 * max(*errors.values(), *published.values())),
        xlabel=error_name,
        ylabel="Loop",
    )
    style.legend(axes)
    return figure


@style.styled
def errors_by_truth(
    errors: Mapping[str, Mapping[str, Mapping[str, Spread]]],
    limit: float,
    error_name: str,
    limit_name: str,
) -> Figure:
    """Return a panel for each set: a row for each truth, in it a mark for each loop."""
    truths = list(next(iter(errors.values())))
    figure, row = style.named_rows(
        truths, 2.0 * style.NAME, style.NARROW, len(errors), top=0.62, between=0.25
    )
    ends = [
        end
        for rows in errors.values()
        for loops in rows.values()
        for spread in loops.values()
        for end in spread
    ]
    finite = [limit, *(end for end in ends if isfinite(end) and end > 0.0)]
    for axes, (head, rows) in zip(row, errors.items(), strict=True):
        for place, loops in enumerate(rows.values()):
            # From left to right: mean, interval, and range under all conditions.
            for number, ((name, spread), look) in enumerate(
                zip(loops.items(), LOOKS, strict=False)
            ):
                at, color = place + style.BESIDE * (number - 0.5 * (len(loops) - 1)), look["color"]
                axes.hlines(
                    at,
                    spread.least,
                    spread.most,
                    color=color,
                    linewidth=1.0,
                    label=f"_{name}, conditions",
                )
                axes.hlines(
                    at,
                    spread.low,
                    spread.high,
                    color=color,
                    linewidth=2.0 * style.WIDE,
                    label=f"_{name}, interval",
                )
                axes.plot(
                    spread.error,
                    at,
                    look["marker"],
                    color=color,
                    markersize=style.SMALL,
                    label=f"_{name}" if place else name,
                )
        axes.set_xscale("log")
        axes.set_xticks(MARKS, [f"{mark:g}" for mark in MARKS])
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlim(0.8 * min(finite), 1.25 * max(finite))
        axes.axvline(limit, label=limit_name, **style.DOTTED)
        style.title(axes, head)
        axes.set_xlabel(error_name)
        # Column head of the numbers of each panel.
        axes.set_ylabel("Friction of the rig", visible=axes is row[0])
    style.legend_in_corner(figure, row[0])
    return figure
