"""The mechanics of a ball screw with a torque sensor, drawn from the side: what sits where, with its numbers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle

from bristle.core.typography import with_unit
from bristle.figures import style

__all__ = ["LAYOUT_HEIGHT", "LAYOUT_WIDTH", "Mechanics", "draw_layout"]

LAYOUT_WIDTH, LAYOUT_HEIGHT = 100.0, 45.0
AXIS, BASE, RAIL = 23.0, 13.0, 14.6  # heights of the shaft, of the base and of the rail
LINE = 8.0  # points
METAL, DARK, LIGHT = "#c9d2dc", "#9aa8b7", "#eef1f5"


class Mechanics(NamedTuple):
    """What the drawing tells in numbers.

    Parameters
    ----------
    lead : float
        Travel of the table for one turn of the screw [m].
    J, J_m : float
        Inertia of everything, and that of the motor before the torque sensor [kg*m^2].
    cutoff : float
        Of the torque sensor [Hz]; infinite where it has no filter.
    resolution : float
        One count of the encoder as a travel of the table [m]; 0 for a perfect one.
    """

    lead: float
    J: float
    J_m: float
    cutoff: float
    resolution: float


def draw_layout(axes: Axes, mechanics: Mechanics) -> None:
    """Draw motor with encoder, couplings, torque sensor, screw with its nut, and table on its guide."""
    axes.set_xlim(0.0, LAYOUT_WIDTH)
    axes.set_ylim(0.0, LAYOUT_HEIGHT)
    axes.set_axis_off()
    _draw_base(axes)
    _draw_drive(axes)
    _draw_sensor(axes)
    _draw_screw(axes)
    _draw_table(axes)
    _draw_arrows(axes)
    _tell(axes, mechanics)


def _box(axes: Axes, x: float, y: float, width: float, height: float, color: str = METAL, zorder: float = 2.0) -> None:
    axes.add_patch(Rectangle((x, y), width, height, facecolor=color, edgecolor=style.INK, linewidth=0.9, zorder=zorder))


def _around(axes: Axes, x: float, width: float, height: float, color: str = METAL, zorder: float = 2.0) -> None:
    """Draw a box around the shaft."""
    _box(axes, x, AXIS - 0.5 * height, width, height, color, zorder)


def _draw_base(axes: Axes) -> None:
    axes.add_patch(Rectangle((2.0, BASE - 1.8), 96.0, 1.8, facecolor=LIGHT, edgecolor=style.GREY, hatch="////", linewidth=0.8))


def _draw_drive(axes: Axes) -> None:
    """Draw encoder and motor with its foot, and the shaft as far as the screw."""
    _around(axes, 26.0, 32.0, 1.2, DARK, 1.0)
    _box(axes, 11.0, BASE, 12.0, 5.0, LIGHT, 1.5)
    _around(axes, 9.0, 17.0, 11.0)
    for x in np.arange(11.0, 25.0, 2.0):
        axes.plot([x, x], [AXIS - 5.5, AXIS + 5.5], color=DARK, linewidth=0.7, zorder=2.1)
    _around(axes, 4.0, 5.0, 8.0, LIGHT)
    _around(axes, 6.0, 0.8, 7.0, style.INK)


def _draw_sensor(axes: Axes) -> None:
    """Draw the torque sensor between two couplings."""
    for x in (31.0, 50.0):
        for half in (x, x + 2.6):
            _around(axes, half, 2.2, 5.6, DARK)
    _box(axes, 40.0, BASE, 6.0, 6.0, LIGHT, 1.5)
    _around(axes, 38.0, 10.0, 8.4, "#f1d9a5")
    axes.text(43.0, AXIS, "T", fontsize=LINE + 1.5, style="italic", ha="center", va="center", zorder=3.0)


def _draw_screw(axes: Axes) -> None:
    """Draw the screw with its thread between two bearings."""
    for x in (57.0, 93.5):
        _box(axes, x, BASE, 3.0, AXIS - BASE + 3.6, LIGHT)
    _around(axes, 60.0, 33.5, 2.6, METAL, 1.6)
    for x in np.arange(61.0, 93.0, 1.5):
        axes.plot([x, x + 0.9], [AXIS - 1.3, AXIS + 1.3], color=style.INK, linewidth=0.7, zorder=1.7)


def _draw_table(axes: Axes) -> None:
    """Draw the rail, the carriages on it, the nut, and the table that they carry."""
    _box(axes, 60.5, BASE, 32.5, RAIL - BASE, DARK)
    for x in (67.0, 82.0):
        _box(axes, x, RAIL - 0.7, 4.5, 2.6, METAL, 2.5)
        _box(axes, x + 1.2, RAIL + 1.9, 2.1, 12.0, LIGHT, 1.2)
    _around(axes, 73.0, 7.0, 6.4, DARK, 2.4)
    _box(axes, 75.0, AXIS + 3.2, 3.0, 2.2, DARK, 2.4)
    _box(axes, 65.0, AXIS + 5.4, 23.5, 2.8, METAL, 2.6)


def _draw_arrows(axes: Axes) -> None:
    """Draw what turns, what moves, and what holds it back."""
    axes.add_patch(
        FancyArrowPatch(
            (27.6, AXIS - 4.2),
            (27.6, AXIS + 4.2),
            connectionstyle="arc3,rad=0.4",
            arrowstyle="-|>",
            mutation_scale=9.0,
            shrinkA=0.0,
            shrinkB=0.0,
            color=style.INK,
            linewidth=1.0,
            zorder=3.0,
        )
    )
    axes.text(28.6, AXIS + 5.0, "u, θ", fontsize=LINE, style="italic", ha="center", va="bottom")
    _arrow(axes, (89.0, AXIS + 6.8), (95.5, AXIS + 6.8))
    axes.text(92.2, AXIS + 7.4, "x", fontsize=LINE, style="italic", ha="center", va="bottom")
    _arrow(axes, (72.5, AXIS - 4.4), (65.0, AXIS - 4.4))
    axes.text(73.3, AXIS - 4.5, "F_p", fontsize=LINE, style="italic", ha="left", va="center", zorder=3.0)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.add_patch(
        FancyArrowPatch(
            start, end, arrowstyle="-|>", mutation_scale=9.0, shrinkA=0.0, shrinkB=0.0, color=style.INK, linewidth=1.0, zorder=3.0
        )
    )


def _tell(axes: Axes, mechanics: Mechanics) -> None:
    """Write beside each part what it is, and its numbers."""
    encoder = ["perfect"]
    if mechanics.resolution > 0.0:
        counts = f"{mechanics.lead / mechanics.resolution:,.0f} counts a turn".replace(",", " ")
        encoder = [counts, f"{with_unit(mechanics.resolution, 'm')} of travel each"]
    _label(axes, 3.0, True, 6.5, AXIS + 4.0, "encoder", encoder, "left")
    filtered = [f"filter {with_unit(mechanics.cutoff, 'Hz')}"] if math.isfinite(mechanics.cutoff) else []
    _label(axes, 43.0, True, 43.0, AXIS + 4.2, "torque sensor", ["T = F_p + (J − J_m) dω/dt", *filtered])
    behind = f"J − J_m = {_inertia(mechanics.J - mechanics.J_m)}"
    moved = f"J = {_inertia(mechanics.J)}, as {with_unit(mechanics.J * (2.0 * math.pi / mechanics.lead) ** 2, 'kg')} there"
    _label(axes, 77.0, True, 77.0, AXIS + 8.2, "table", [f"with coupling and screw {behind}", moved])
    _label(axes, 17.5, False, 17.5, BASE + 4.0, "DC motor", [f"J_m = {_inertia(mechanics.J_m)}"])
    _label(axes, 43.0, False, 33.3, AXIS - 2.8, "couplings", [], also=(52.4, AXIS - 2.8))
    _label(axes, 64.0, False, 64.0, AXIS - 1.3, "ball screw", [f"lead {with_unit(mechanics.lead, 'm')}", "rigid"])
    _label(axes, 86.0, False, 86.0, BASE + 0.8, "linear guide", [])


def _inertia(value: float) -> str:
    return with_unit(value, "kg*m^2")


def _label(
    axes: Axes,
    x: float,
    above: bool,
    at: float,
    height: float,
    title: str,
    lines: list[str],
    align: str = "center",
    also: tuple[float, float] | None = None,
) -> None:
    """Write above or below the drawing, with a line to the part that is meant."""
    step, edge = 3.0, LAYOUT_HEIGHT - 1.5 if above else 8.5
    for index, text in enumerate([title, *lines]):
        axes.text(
            x,
            edge - step * index,
            text,
            fontsize=LINE if index == 0 else LINE - 1.0,
            ha=align,
            va="center",
            fontweight="bold" if index == 0 else "normal",
        )
    near = edge - step * len(lines) - 1.6 if above else edge + 1.5
    for end in ((at, height), *([also] if also else [])):
        start = at if align == "left" else x
        axes.plot([start, end[0]], [near, end[1]], color=style.GREY, linewidth=0.8, zorder=4.0)
        axes.plot(*end, "o", color=style.INK, markersize=2.2, zorder=4.0)
