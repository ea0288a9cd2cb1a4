"""Figures of two logs of an axis: following error over a cycle and at reversals, friction, and the changes with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle.core.palette import LIGHT
from bristle.report.figures import style
from bristle.report.figures.first_screen import LOW, SIDE, WITH, WITHOUT, as_strip, over_a_strip
from bristle.report.figures.report_figure import shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bristle.prediction.comparison import Change, Comparison

BEFORE, AFTER = WITHOUT, WITH
TURNS = {"forward_to_backward": "forward to backward", "backward_to_forward": "backward to forward"}
WORDS = {
    "following_error.rms": "error, rms",
    "following_error.peak": "error, peak",
    "reversals.forward_to_backward": "forward to back",
    "reversals.backward_to_forward": "back to forward",
    "effort.rms": "effort, rms",
    "effort.peak": "effort, peak",
    "friction.level": "friction",
}
POINTS: style.Look = {
    "color": AFTER["color"],
    "linestyle": "none",
    "marker": "o",
    "markersize": style.SMALL,
}


def _signal(compared: Comparison) -> str:
    return "following error" if "following_error.rms" in compared.changes else "effort"


def _changes_with_interval(compared: Comparison) -> list[Change]:
    return [change for change in compared.changes.values() if change.interval_percent is not None]


@shown(
    "comparison",
    "comparison",
    lambda compared: (
        f"{_signal(compared).capitalize()} and friction before and after, and each change with its interval"
    ),
    lambda compared: (
        f"Above, the mean over cycles of the {_signal(compared)}: grey before, blue after. "
        + "Next, the mean around reversals. The peak is that in the shaded window. "
        * bool(compared.turns)
        + "Friction at the same speeds is half the difference of the effort between the directions. "
        * bool(compared.friction_curve)
        + "Below, each change in percent of the value before. The interval of a filled point excludes zero."
    ),
)
def comparison(compared: Comparison) -> Figure:
    """Return the differences of two logs: the mean cycle, the mean reversals, friction over speed, and the changes."""
    small = len(compared.turns) + bool(compared.friction_curve)
    changed = _changes_with_interval(compared)
    heights = [0.55, 1.2, *([1.1] * bool(small)), *([0.25 + 0.17 * len(changed)] * bool(changed))]
    rows = len(heights)
    figure, grid = style.panels(
        0.5 + 0.66 * (rows - 1) + 1.25 * sum(heights),
        rows=rows,
        columns=max(small, 1),
        heights=heights,
        undivided=[row for row in range(rows) if not small or row != 2],
        left=1.2,
    )
    motion, kind = compared.course.motion, compared.kind
    drawn = motion, {"color": style.INK, "linewidth": 1.0}, ""
    style.over_time(
        grid[0][0],
        compared.course.time,
        drawn,
        scale=style.scale_for("length", kind, motion),
        word=style.position_word(kind),
    )
    grid[0][0].set_title("reference" if "following_error.rms" in compared.changes else "position")
    _draw_pair(
        grid[1][0], compared.course.time, compared.course.before, compared.course.after, compared
    )
    length = style.scale_for(
        "length", kind, *(signal for turn in compared.turns for signal in (turn.before, turn.after))
    )
    below = grid[2] if small else []
    for axes, turn in zip(below, compared.turns, strict=False):
        pair = (turn.before, BEFORE, "before"), (turn.after, AFTER, "after")
        style.over_time(axes, turn.time, *pair, scale=length, word="Following error")
        axes.axhline(0.0, zorder=0, **style.AID)
        style.mark_window(
            axes, np.array([0.0, compared.window or 0.0]) * style.time_scale(turn.time).factor
        )
        axes.set_title(TURNS[turn.name])
    style.one_height(below[: len(compared.turns)])
    if compared.friction_curve:
        _draw_friction(below[-1], compared)
        below[-1].set_title("friction")
    if changed:
        _draw_changes(grid[-1][0], changed)
    style.legend(grid[1][0])
    return figure


@shown(
    "worst",
    "comparison",
    lambda compared: (
        f"Mean {_signal(compared)} {'at the worst reversal' if compared.turns else 'around its largest value'}, before and after; below, "
        "the whole cycle"
    ),
)
def change_at_reversal(compared: Comparison) -> Figure:
    """Return the mean at the worst reversal, or around the largest value of the motion, before and after; below, the mean cycle."""
    figure, near, strip = over_a_strip(("before", "after"))
    course, turns = compared.course, compared.turns
    if turns:
        worst = max(turns, key=lambda turn: float(np.ptp(turn.before)))
        _draw_pair(near, worst.time, worst.before, worst.after, compared)
    else:
        part = style.window(course.time, course.before, 0.1)
        _draw_pair(near, course.time[part], course.before[part], course.after[part], compared)
    _draw_pair(strip, course.time, course.before, course.after, compared)
    as_strip(strip)
    near.axhline(0.0, zorder=0, **style.AID)
    style.label_lines(near)
    return figure


@shown(
    "changes",
    "comparison",
    "Each change in percent, with its 95 % interval",
    "Filled: a clear change.",
    applies=lambda compared: bool(_changes_with_interval(compared)),
)
def changes(compared: Comparison) -> Figure:
    """Return each change with its interval; a filled point means that the interval excludes zero."""
    changed = _changes_with_interval(compared)
    figure, (axes,) = style.named_rows(
        [WORDS[change.name] for change in changed], 0.22, across=SIDE
    )
    _draw_changes(axes, changed)
    axes.set_title("")
    return figure


@shown(
    "friction",
    "comparison",
    "Friction over speed, before and after",
    "Friction over speed.",
    applies=lambda compared: bool(compared.friction_curve),
)
def friction_over_speed(compared: Comparison) -> Figure:
    """Return friction over speed, before and after."""
    figure, ((axes,),) = style.panels(
        LOW, across=SIDE, right=style.room_for(("before", "after")), top=0.12
    )
    _draw_friction(axes, compared)
    style.label_lines(axes)
    return figure


def _draw_pair(
    axes: style.Axes, time: np.ndarray, before: np.ndarray, after: np.ndarray, compared: Comparison
) -> None:
    scale, word = style.scale_for("length", compared.kind, before, after), "Following error"
    if "following_error.rms" not in compared.changes:
        scale, word = style.effort_scale(compared.kind, before, after)
    style.over_time(
        axes, time, (before, BEFORE, "before"), (after, AFTER, "after"), scale=scale, word=word
    )


def _draw_friction(axes: style.Axes, compared: Comparison) -> None:
    speeds = np.array([speed for speed, _ in compared.friction_curve])
    sides = [
        np.array([getattr(change, side) for _, change in compared.friction_curve])
        for side in ("before", "after")
    ]
    speed, (force, word) = (
        style.scale_for("length/time", compared.kind, speeds),
        style.effort_scale(compared.kind, *sides),
    )
    for values, look, name, marker in zip(
        sides, (BEFORE, AFTER), ("before", "after"), ("o", "s"), strict=True
    ):
        axes.plot(speeds * speed.factor, values * force.factor, label=name, marker=marker, **look)
    axes.margins(0.08)
    axes.set(xlabel=speed.label("Speed"), ylabel=force.label(f"Friction {word.lower()}"))


def _draw_changes(axes: style.Axes, changed: Sequence[Change]) -> None:
    """Draw each change with its interval; a filled point means that the interval excludes zero."""
    places = np.arange(len(changed), dtype=float)
    ends = np.array([change.interval_percent for change in changed], dtype=float)
    x = np.column_stack([ends, np.full(len(changed), np.nan)]).ravel()
    axes.plot(
        x, np.repeat(places, 3), label="_95 % interval", color=AFTER["color"], linewidth=style.WIDE
    )
    percents = np.array([change.change_percent for change in changed])
    sure = np.array([change.verdict in ("lower", "higher") for change in changed])
    for part, face, name in (
        (sure, POINTS["color"], "_change"),
        (~sure, LIGHT["ground"], "_no change detected"),
    ):
        if part.any():
            axes.plot(percents[part], places[part], label=name, markerfacecolor=face, **POINTS)
    axes.axvline(0.0, zorder=0, **style.AID)
    axes.set_yticks(places, [WORDS[change.name] for change in changed])
    axes.set(
        ylim=(len(changed) - 0.4, -0.6),
        ylabel="Quantity",
        xlabel="Change [%]",
        title="change, with its 95 % interval",
    )
