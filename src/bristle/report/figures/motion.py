"""Figures of a motion to run, and of the expected friction along it."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from bristle.report.figures import style
from bristle.report.figures.first_screen import LOW, SIDE
from bristle.report.figures.report_figure import shown

if TYPE_CHECKING:
    from bristle.prediction.excitation import ExcitationMotion


@shown(
    "motion",
    "motion",
    "Position over time, for each purpose",
    lambda planned: "Each panel has its own scale." * (len(_parts(planned)) > 1),
)
def motion(planned: ExcitationMotion) -> Figure:
    """Return position over time, a panel for each purpose."""
    parts = _parts(planned)
    figure, panels = style.grid_of(len(parts), gap=0.72)
    for axes, (purpose, part) in zip(panels, parts.items(), strict=True):
        position = planned.position[part] - planned.start
        scale, word = (
            style.scale_for("length", planned.kind, position),
            style.position_word(planned.kind),
        )
        style.over_time(
            axes, planned.time[part], (position, style.PREDICTED, ""), scale=scale, word=word
        )
        axes.set_title(purpose)
    return figure


@shown(
    "expected",
    ("motion", "expected"),
    "Expected friction over position and over speed",
    "Expected friction.",
)
def expected(planned: ExcitationMotion, friction: np.ndarray) -> Figure:
    """Return the loops of friction over position in pre-sliding, and friction over the speed of steady slides."""
    parts = _parts(planned)
    force, word = style.effort_scale(planned.kind, friction)
    effort = force.label(f"Friction {word.lower()}")
    slow = next(
        (
            parts[name]
            for name in ("presliding", "break-away", "damping", "stiffness", "resonance")
            if name in parts
        ),
        None,
    )
    fast = parts.get("stribeck")
    count = (slow is not None) + (fast is not None)
    figure, grid = style.panels(LOW * count - 0.3, rows=count, across=SIDE, top=0.12)
    row = [axes for (axes,) in grid]
    if slow is not None:
        axes, position = row.pop(0), planned.position[slow] - planned.start
        scale = style.scale_for("length", planned.kind, position)
        axes.plot(
            position[::4] * scale.factor, friction[slow][::4] * force.factor, **style.PREDICTED
        )
        axes.set(xlabel=scale.label(style.position_word(planned.kind)), ylabel=effort)
    if fast is not None:
        speed, level = np.abs(_steady(planned, friction, fast)).T
        scale = style.scale_for("length/time", planned.kind, speed)
        row[0].semilogx(
            speed * scale.factor,
            level * force.factor,
            ".",
            markersize=3.0,
            color=style.PREDICTED["color"],
        )
        # Plain numbers: matplotlib writes powers of ten as mathematics, which a page shows as source text.
        row[0].xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        row[0].xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        row[0].xaxis.set_minor_locator(NullLocator())
        row[0].set(xlabel=scale.label("Speed"), ylabel=effort)
    return figure


def _steady(planned: ExcitationMotion, friction: np.ndarray, part: slice) -> np.ndarray:
    """Return (velocity, friction) of the middle of each steady slide, shape (slide, 2)."""
    velocity = planned.velocity[part]
    cruise = np.isclose(velocity[1:], velocity[:-1], rtol=1e-9, atol=0.0)
    points = []
    for moving, group in groupby(
        range(cruise.size), key=lambda k: bool(cruise[k] and velocity[k] != 0.0)
    ):
        members = list(group)
        if moving and len(members) > 4:
            late = slice(part.start + members[len(members) // 2], part.start + members[-1])
            points.append((float(planned.velocity[late].mean()), float(friction[late].mean())))
    return np.array(points).reshape(-1, 2)


def _parts(planned: ExcitationMotion) -> dict[str, slice]:
    """Return the samples of each purpose, in the order of the motion."""
    slices = {}
    placed = zip(planned.begins, planned.pieces, strict=True)
    for purpose, group in groupby(placed, key=lambda entry: entry[1].purpose):
        members = list(group)
        first, last = members[0][0], members[-1][0] + members[-1][1].duration
        slices[purpose] = slice(*(int(k) for k in np.searchsorted(planned.time, (first, last))))
    return slices
