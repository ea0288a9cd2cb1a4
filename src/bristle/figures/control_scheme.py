"""A loop as a block diagram below the mechanics that it moves, drawn from the experiment that runs it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from bristle.core.typography import number, typeset, with_unit
from bristle.core.variable import unit_of
from bristle.figures import style
from bristle.figures.drawing import Drawing
from bristle.figures.mechanical_layout import LAYOUT_HEIGHT, Mechanics, draw_layout
from bristle.figures.names import shortened

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant

__all__ = ["rig_layout"]

WIDTH, HEIGHT = 100.0, 62.0
LINE = 8.0  # points
LINES_SHOWN = 6  # lines in a block
BOLDER = 1.12  # times as wide
GREEK = {"lambda": "λ", "phi": "φ"}


class Block(NamedTuple):
    """A box: its left lower corner, its size, its first line and the others."""

    x: float
    y: float
    width: float
    height: float
    title: str
    lines: Sequence[str] = ()

    @property
    def left(self) -> tuple[float, float]:
        """The middle of its left side."""
        return self.x, self.y + 0.5 * self.height

    @property
    def right(self) -> tuple[float, float]:
        """The middle of its right side."""
        return self.x + self.width, self.y + 0.5 * self.height

    @property
    def top(self) -> tuple[float, float]:
        """The middle of its upper side."""
        return self.x + 0.5 * self.width, self.y + self.height


@style.styled
def rig_layout(mechanics: Mechanics, variant: Variant) -> Figure:
    """Return the mechanics of a rig, and below them the block diagram of its loop.

    Parameters
    ----------
    mechanics : Mechanics
        Its numbers.
    variant : Variant
        The loop.
    """
    total = HEIGHT + LAYOUT_HEIGHT
    figure = Drawing(figsize=(style.WIDTH, style.WIDTH * total / WIDTH))
    draw_layout(figure.add_axes((0.0, HEIGHT / total, 1.0, LAYOUT_HEIGHT / total)), mechanics)
    draw_scheme(figure.add_axes((0.0, 0.0, 1.0, HEIGHT / total)), variant)
    return figure


def draw_scheme(axes: Axes, variant: Variant) -> None:
    """Draw the block diagram of a loop."""
    axes.set_xlim(0.0, WIDTH)
    axes.set_ylim(0.0, HEIGHT)
    axes.set_axis_off()
    kind, run, fed = variant.plant.kind, variant.run, variant.feedforward
    _frame(axes, 1.0, 4.0, 57.0, 55.0, f"controller, every {with_unit(run.sample_time, 's')}")
    _frame(axes, 61.0, 4.0, 38.0, 55.0, "rig, simulated")
    reference = Block(2.5, 21.0, 16.5, 17.0, "reference", _value_lines(variant.reference))
    law = Block(28.0, 19.0, 19.0, 21.0, variant.controller.name.replace("_", " "), _value_lines(variant.controller))
    compensator = Block(15.5, 43.5, 32.5, 12.5, "compensator" if fed.friction else "no compensator", _fed(variant))
    drive = Block(63.0, 23.5, 13.0, 12.0, "drive", _drive(variant))
    table = Block(81.0, 23.5, 16.0, 12.0, variant.plant.name, _value_lines(variant.plant))
    friction = Block(68.0, 43.5, 29.0, 12.5, "friction", _friction(variant.friction))
    sensor = Block(77.0, 6.5, 20.0, 9.5, variant.sensor.name, _value_lines(variant.sensor, skip=("seed",)))
    for block in (reference, law, compensator, drive, table, friction, sensor):
        _draw(axes, block)
    minus, plus = (23.0, 29.5), (53.0, 29.5)
    for joint in (minus, plus):
        axes.add_patch(Circle(joint, 1.5, facecolor="white", edgecolor=style.INK, linewidth=0.9))
    _arrow(axes, [reference.right, (21.5, 29.5)])
    _arrow(axes, [(24.5, 29.5), law.left], "e")
    _arrow(axes, [law.right, (51.5, 29.5)])
    _arrow(axes, [(54.5, 29.5), drive.left], "u")
    _arrow(axes, [drive.right, table.left])
    _arrow(axes, [(89.0, 43.5), table.top])
    _arrow(axes, [(89.0, 23.5), (89.0, 16.0)], "x" if kind == "translational" else "θ")
    _arrow(axes, [sensor.left, (23.0, 11.25), (23.0, 28.0)], "q", first=True)
    axes.text(24.3, 26.2, "−", fontsize=LINE)
    if fed.friction is not None:
        _arrow(axes, [(10.75, 38.0), (10.75, 49.75), compensator.left])
        _arrow(axes, [compensator.right, (53.0, 49.75), (53.0, 31.0)])
        axes.text(54.0, 32.2, "+", fontsize=LINE)


def _value_lines(model: Model, skip: tuple[str, ...] = ()) -> list[str]:
    """Return the first parameters of a model, one a line; lists by their range."""
    variables, lines = model.component.variables, []
    for name, value in model.values.items():
        if name in skip or isinstance(value, str):
            continue
        unit = variables[name].unit(model.kind)
        symbol = GREEK.get(name.rstrip("_"), name)
        if hasattr(value, "__len__"):
            lines += [f"{len(value)} {symbol}", f"up to {_amount(float(max(map(abs, value))), unit)}"]
        elif value not in (0.0, float("inf")):
            lines.append(f"{symbol} = {_amount(float(value), unit)}")
    return lines[:LINES_SHOWN]


def _amount(value: float, unit: str) -> str:
    """Return a number with its unit; a stiffness of a table by the micrometre, as people tell it."""
    return f"{number(1e-6 * value, digits=3)} N/µm" if unit == "N/m" else with_unit(value, unit)


def _fed(variant: Variant) -> list[str]:
    fed, kind = variant.feedforward, variant.plant.kind
    if fed.friction is None:
        return []
    parts = [f"gain {fed.gain:g}"] if fed.gain != 1.0 else []
    parts += [f"offset {with_unit(fed.offset, unit_of('force', kind))}"] if fed.offset else []
    parts += [f"asymmetry {fed.asymmetry:g}"] if fed.asymmetry else []
    return [fed.friction.name, ", ".join(_value_lines(fed.friction)[:2]), ", ".join(parts)]


def _drive(variant: Variant) -> list[str]:
    run = variant.run
    lines = [f"delay {run.delay} T"] if run.delay else []
    lines += [f"lag {with_unit(run.current_lag, 's')}"] if run.current_lag else []
    return lines or ["ideal"]


def _friction(model: Model) -> list[str]:
    values, variables = model.values, model.component.variables
    lines = [model.name]
    if "nu_i" in values:
        lines.append(f"{len(values['nu_i'])} elements")
    strong = [name for name in values if name.startswith("F_S")]
    if strong:
        forces = " and ".join(number(values[name], digits=3) for name in strong)
        lines.append(f"break-away {forces} {typeset(variables[strong[0]].unit(model.kind))}")
    if values.get("scatter"):
        lines[1:2] = [f"{lines[1]}, scatter {100.0 * values['scatter']:g} %"] if len(lines) > 1 else []
    return lines


def _frame(axes: Axes, x: float, y: float, width: float, height: float, title: str) -> None:
    axes.add_patch(
        FancyBboxPatch(
            (x, y),
            width,
            height,
            boxstyle="round,pad=0,rounding_size=1.5",
            facecolor="#f4f6f8",
            edgecolor=style.GREY,
            linewidth=0.8,
            linestyle="--",
            zorder=0,
        )
    )
    axes.text(x + 1.0, y + height + 0.7, title, fontsize=LINE, color=style.INK)


def _draw(axes: Axes, block: Block) -> None:
    axes.add_patch(
        FancyBboxPatch(
            (block.x, block.y),
            block.width,
            block.height,
            boxstyle="round,pad=0,rounding_size=1.0",
            facecolor="white",
            edgecolor=style.PREDICTED["color"],
            linewidth=1.2,
        )
    )
    lines = [line for line in block.lines if line]
    step = min(2.7, (block.height - 1.5) / (len(lines) + 1.0))
    middle = block.x + 0.5 * block.width
    top = block.y + 0.5 * block.height + 0.5 * step * len(lines)
    available = (block.width - 1.0) * style.WIDTH / WIDTH
    title = shortened(block.title, available / BOLDER, LINE)
    axes.text(middle, top, title, fontsize=LINE, fontweight="bold", ha="center", va="center")
    for index, line in enumerate(lines):
        text = shortened(line, available, LINE - 1.0)
        axes.text(middle, top - step * (index + 1), text, fontsize=LINE - 1.0, ha="center", va="center")


def _arrow(axes: Axes, path: list[tuple[float, float]], label: str = "", *, first: bool = False) -> None:
    """Draw a line of straight parts with a head at its end, and a letter over its only or its first part."""
    *begin, last, end = path
    corners = [*begin, last]
    axes.plot(*zip(*corners, strict=True), color=style.INK, linewidth=1.0, zorder=0.5)
    axes.add_patch(
        FancyArrowPatch(
            last, end, arrowstyle="-|>", mutation_scale=9.0, shrinkA=0.0, shrinkB=0.0, color=style.INK, linewidth=1.0, zorder=0.5
        )
    )
    if label:
        a, b = (path[0], path[1]) if first else (last, end)
        beside = 1.5 if a[0] == b[0] else 0.0
        axes.text(
            0.5 * (a[0] + b[0]) + beside,
            0.5 * (a[1] + b[1]) + (0.9 if not beside else 0.0),
            label,
            fontsize=LINE,
            style="italic",
            ha="center",
            va="bottom" if not beside else "center",
        )
