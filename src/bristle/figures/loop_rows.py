"""Loops that follow a reference, a row or a panel for each: what they are told and do, what they err by, what they drive."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from bristle.core.typography import with_unit
from bristle.core.variable import Kind
from bristle.figures import style
from bristle.simulation.result import VariantResult

Loops = Mapping[str, "VariantResult"]
RANGE = "range in the paper"
FORWARD: style.Look = style.MEASURED | {"linewidth": 1.5}


def _rows(results: Loops, columns: int, top: float, between: float = 0.55) -> tuple[Figure, list[list[style.Axes]]]:
    height = top + style.PANEL * len(results)
    return style.panels(height, rows=len(results), columns=columns, widths=(2.0, 1.0)[:columns], between=between, top=top)


def _entitle(figure: Figure, grid: list[list[style.Axes]], results: Loops) -> None:
    """Put the legend of all rows into the corner, and above each row the name of its loop."""
    reach = style.legend_in_corner(figure, grid[0][0])
    for (first, *_), name in zip(grid, results, strict=True):
        style.title(first, name, beside=reach if first is grid[0][0] else 0.0)


@style.styled
def tracking(results: Loops, settle: float, close: tuple[float, float], kind: Kind = "translational") -> Figure:
    """Return reference and encoder reading over time, a row for each loop."""
    figure, grid = _rows(results, 2, 0.4)
    for (full, near), result in zip(grid, results.values(), strict=True):
        for axes, part in ((full, result.time >= settle), (near, (result.time >= close[0]) & (result.time <= close[1]))):
            command = (result.reference[part], style.MEASURED, "command")
            encoder = (result.measured[part], style.PREDICTED, "encoder")
            scale = style.scale_for("length", kind, command[0])
            style.over_time(axes, result.time[part], command, encoder, scale=scale, word=style.position_word(kind))
        style.mark_window(full, np.array(close))
        near.set_title("close up")
    _entitle(figure, grid, results)
    return figure


@style.styled
def tracking_error(results: Loops, settle: float, kind: Kind = "translational") -> Figure:
    """Return the following error over time, a row for each loop."""
    figure, grid = _rows(results, 1, 0.4)
    # In the unit of the motion: a thousandth of it is easily seen as such.
    length = style.scale_for("length", kind, *(result.reference for result in results.values()))
    for (axes,), result in zip(grid, results.values(), strict=True):
        judged, forward = result.time >= settle, np.gradient(result.reference) > 0.0
        sides = [
            (np.where(moving, result.reference - result.measured, np.nan)[judged], look, label)
            for moving, look, label in ((forward, FORWARD, "moving forward"), (~forward, style.PREDICTED, "moving backward"))
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
    kind: Kind = "translational",
) -> Figure:
    """Return the distribution of the following error, a panel for each loop."""
    length = style.scale_for("length", kind, *(result.reference for result in results.values()))
    errors = {name: (result.reference - result.measured)[result.time >= settle] for name, result in results.items()}
    low, high = (edge(float(edge(error)) for error in errors.values()) for edge in (min, max))
    width = 0.5 * resolution if resolution > 0.0 else (high - low) / 60.0
    edges = np.arange(np.floor(low / width), np.ceil(high / width) + 1.0) * width * length.factor
    figure, (row,) = style.panels(3.0, columns=len(results), between=0.3, top=0.56)
    for axes, (name, error) in zip(row, errors.items(), strict=True):
        mean, std = float(error.mean()) * length.factor, float(error.std()) * length.factor
        share = np.histogram(error * length.factor, edges)[0] * (100.0 / error.size)
        axes.axvspan(mean - std, mean + std, color=style.PALE, linewidth=0, zorder=0, label="mean ± standard deviation")
        axes.stairs(share, edges, fill=True, color=style.BARS, label="_bars")
        axes.stairs(share, edges, color=style.PREDICTED["color"], linewidth=0.9, label="_outline")
        axes.axvline(mean, label="mean", **style.DASHED)
        for end, label in zip((published or {}).get(name, ()), (RANGE, "_same"), strict=False):
            axes.axvline(end * length.factor, label=label, **style.DOTTED)
        style.title(axes, name)
        axes.set_xlabel(length.label("Following error"))
    style.one_height(row)
    style.share_y(row, "Share of the samples [%]")
    style.legend_in_corner(figure, row[0])
    return figure


@style.styled
def control_effort(
    results: Loops,
    settle: float,
    close: tuple[float, float],
    arm: float = 1.0,
    effort: Kind = "translational",
    *,
    friction: bool = False,
    mean_over: float = 0.0,
) -> Figure:
    """Return the effort of each loop, whole and close up."""
    scale, word = style.effort_scale(effort, *(arm * result.effort for result in results.values()))
    driving = f"Driving {word.lower()}"
    figure, grid = _rows(results, 2, 0.56 if friction else style.TOP, 0.6 if mean_over else 0.3)
    for (full, near), (name, result) in zip(grid, results.items(), strict=True):
        for axes, part, span in (
            (full, result.time >= settle, mean_over),
            (near, (result.time >= close[0]) & (result.time <= close[1]), 0.0),
        ):
            driven_by, lost = (_averaged(arm * signal, result.time, span)[part] for signal in (result.effort, result.friction))
            signals = [(driven_by, style.PREDICTED, driving.lower())]
            if friction:
                beneath = {"zorder": 1.5} if span else {}  # the averaged effort, which it nearly equals
                signals.append((lost, style.MEASURED | beneath, "friction"))
            style.over_time(axes, result.time[part], *signals, scale=scale, word=driving)
        style.mark_window(full, np.array(close))
        style.title(full, f"{name}, mean over {with_unit(mean_over, 's')}" if mean_over else name)
        near.set_title("close up, as it is" if mean_over else "close up")
    for column in range(2):
        axes_of_one_scale = [row[column] for row in grid] if mean_over else [axes for row in grid for axes in row]
        top = max(float(np.max(np.abs(axes.dataLim.intervaly))) for axes in axes_of_one_scale)
        for row in grid:
            row[column].set_ylim(-1.06 * top, 1.06 * top)
    if not mean_over:
        for row in grid:
            row[1].tick_params(labelleft=False)
            row[1].set_ylabel("")
    if friction:
        style.legend_in_corner(figure, grid[0][0])
    return figure


def _averaged(effort: np.ndarray, time: np.ndarray, duration: float) -> np.ndarray:
    """Return an effort averaged over a time around each sample; as it is for a time of 0."""
    count = round(duration / float(time[1] - time[0])) if duration else 1
    if count < 2:
        return effort
    return np.convolve(effort, np.ones(count), "same") / np.convolve(np.ones(effort.size), np.ones(count), "same")
