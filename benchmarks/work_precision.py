"""Draw error against wall time on stick-slip, and print the table: ``python -m benchmarks.work_precision``."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from benchmarks.stick_slip import LEVELS, Point, claims, least_wall, measure

PICTURE = Path(__file__).parent.parent / "docs" / "images" / "stick-slip.svg"
COLOURS = (
    "#0b6e99",
    "#d1495b",
    "#66a182",
    "#edae49",
    "#7a5195",
    "#8d97a3",
    "#5c4033",
    "#1b2430",
    "#00798c",
    "#b5179e",
)


def curves(points: list[Point]) -> dict[str, list[Point]]:
    """Return the points of each method, in order of their settings."""
    found: dict[str, list[Point]] = {}
    for point in points:
        found.setdefault(point.method.name, []).append(point)
    return found


def picture(points: list[Point]) -> Figure:
    """Return wall time over error, a line for each method; bristle in thick lines."""
    with matplotlib.rc_context(
        {"font.size": 8.5, "svg.fonttype": "none", "svg.hashsalt": "bristle"}
    ):
        figure = Figure(figsize=(7.2, 4.4), layout="constrained")
        axes = figure.add_subplot()
        for (name, line), colour in zip(curves(points).items(), COLOURS, strict=False):
            is_ours = line[0].method.role == "bristle"
            axes.loglog(
                [one.error for one in line],
                [1e3 * one.wall for one in line],
                color=colour,
                label=name,
                linewidth=2.2 if is_ours else 1.0,
                marker="o",
                markersize=4.0 if is_ours else 3.0,
            )
        axes.set_xlim(3e-3, 2e-10)
        axes.set_xlabel("largest error of the position [m]")
        axes.set_ylabel("wall time [ms]")
        axes.grid(color="#dfe3e8", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside right upper", frameon=False)
    return figure


def table(points: list[Point]) -> str:
    """Return the least wall time to each error, a row for each method, in Markdown."""
    lines = [
        "| | " + " | ".join(f"{level:.0e} m" for level in LEVELS) + " |",
        "| --- |" + " ---: |" * len(LEVELS),
    ]
    for name, line in curves(points).items():
        best = [least_wall(line, level) for level in LEVELS]
        cells = ["–" if one is None else f"{1e3 * one.wall:.3g}" for one in best]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    measured = measure()
    picture(measured).savefig(PICTURE, metadata={"Date": None})
    print(table(measured))
    for claim in claims(measured):
        print(claim.row())
