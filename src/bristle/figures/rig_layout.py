"""A rig: its mechanics, what sits where with its numbers, and below them its loop as a block diagram."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from bristle.core.contracts import Model
from bristle.core.experiment import Variant
from bristle.core.typography import number, typeset, with_unit
from bristle.core.variable import unit_of
from bristle.figures import style
from bristle.figures.drawing import Drawing, shortened

WIDTH, LAYOUT, SCHEME = 100.0, 24.0, 62.0  # units of the drawing: its width, and the heights of both parts
LETTERS, SMALLER = 8.0, 7.0  # points
HEAD: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 9.0, "shrinkA": 0.0, "shrinkB": 0.0, "color": style.INK, "linewidth": 1.0}


class Mechanics(NamedTuple):
    """What the drawing tells in numbers."""

    lead: float
    J: float
    J_m: float
    cutoff: float
    resolution: float


class Block(NamedTuple):
    """A box: its left lower corner, its size, its first line and the others."""

    x: float
    y: float
    width: float
    height: float
    title: str
    lines: Sequence[str] = ()

    def side(self, x: float, y: float) -> tuple[float, float]:
        """Return a point of it, in shares of its width and height."""
        return self.x + x * self.width, self.y + y * self.height


LEFT, RIGHT, ABOVE = (0.0, 0.5), (1.0, 0.5), (0.5, 1.0)  # the middles of its sides


@style.styled
def rig_layout(mechanics: Mechanics, variant: Variant) -> Figure:
    """Return the mechanics of a rig, and below them the block diagram of its loop."""
    total = SCHEME + LAYOUT
    figure = Drawing(figsize=(style.WIDTH, style.WIDTH * total / WIDTH))
    parts: Any = ((_draw_mechanics, SCHEME, LAYOUT, mechanics), (_draw_loop, 0.0, SCHEME, variant))
    for draw, bottom, height, content in parts:
        axes = figure.add_axes((0.0, bottom / total, 1.0, height / total))
        axes.set(xlim=(0.0, WIDTH), ylim=(0.0, height))
        axes.set_axis_off()
        draw(axes, content)
    return figure


def _write(axes: Axes, x: float, y: float, text: str, ha: str = "center", va: str = "center", size: float = LETTERS, **look: Any) -> None:
    axes.text(x, y, text, ha=ha, va=va, fontsize=size, zorder=3.0, **look)


def _draw_mechanics(axes: Axes, mechanics: Mechanics) -> None:
    """Draw what sits on the shaft one after the other, each with its numbers, and what turns, moves and holds back."""
    lead, J, J_m, cutoff, resolution = mechanics
    behind, total, motor = (f"{name} = {with_unit(inertia, 'kg*m^2')}" for name, inertia in (("J − J_m", J - J_m), ("J", J), ("J_m", J_m)))
    encoder = ["perfect"]
    if resolution > 0.0:
        encoder = [f"{lead / resolution:,.0f} counts a turn".replace(",", " "), f"{with_unit(resolution, 'm')} of travel each"]
    filtered = f"filter {with_unit(cutoff, 'Hz')}" if math.isfinite(cutoff) else ""
    at_table = f"as {with_unit(J * (2.0 * math.pi / lead) ** 2, 'kg')} there"
    parts = (
        (16.0, "encoder", encoder),
        (13.0, "DC motor", [motor]),
        (9.0, "coupling", []),
        (19.0, "torque sensor", ["T = F_p + (J − J_m) dω/dt", filtered]),
        (9.0, "coupling", []),
        (10.0, "ball screw", [f"lead {with_unit(lead, 'm')}", "rigid"]),
        (17.0, "table", ["on a linear guide", "with coupling, screw", behind, f"{total},", at_table]),
    )
    x, low, height = 0.5, 3.0, 16.0
    axes.plot([x, WIDTH - x], [low + 0.5 * height] * 2, color=style.GREY, linewidth=3.0 * style.WIDE, zorder=0.5)
    for width, title, lines in parts:
        _draw_block(axes, Block(x, low, width, height, title, lines))
        x += width + 1.0
    _arrow(axes, [(33.0, low + height + 1.0), (38.0, low + height + 1.0)], "u, θ")
    _arrow(axes, [(83.0, low + height + 1.0), (88.0, low + height + 1.0)], "x")
    _arrow(axes, [(96.0, low + height + 1.0), (91.0, low + height + 1.0)], "F_p")


def _draw_loop(axes: Axes, variant: Variant) -> None:
    """Draw the block diagram of a loop."""
    kind, run, fed = variant.plant.kind, variant.run, variant.feedforward
    for x, width, title in ((1.0, 57.0, f"controller, every {with_unit(run.sample_time, 's')}"), (61.0, 38.0, "rig, simulated")):
        _box(axes, x, 4.0, width, 55.0, "#f4f6f8", {"edgecolor": style.GREY, "linewidth": 0.8, "linestyle": "--", "zorder": 0})
        _write(axes, x + 1.0, 59.7, title, "left", "baseline", color=style.INK)
    reference = Block(2.5, 21.0, 16.5, 17.0, "reference", _value_lines(variant.reference))
    law = Block(28.0, 19.0, 19.0, 21.0, variant.controller.name.replace("_", " "), _value_lines(variant.controller))
    compensator = Block(15.5, 43.5, 32.5, 12.5, "compensator" if fed.friction else "no compensator", _fed(variant))
    late = ([f"delay {run.delay} T"] if run.delay else []) + ([f"lag {with_unit(run.current_lag, 's')}"] if run.current_lag else [])
    drive = Block(63.0, 23.5, 13.0, 12.0, "drive", late or ["ideal"])
    table = Block(81.0, 23.5, 16.0, 12.0, variant.plant.name, _value_lines(variant.plant))
    friction = Block(68.0, 43.5, 29.0, 12.5, "friction", _friction(variant.friction))
    sensor = Block(77.0, 6.5, 20.0, 9.5, variant.sensor.name, _value_lines(variant.sensor, skip=("seed",)))
    for block in (reference, law, compensator, drive, table, friction, sensor):
        _draw_block(axes, block)
    for joint in (23.0, 53.0):
        axes.add_patch(Circle((joint, 29.5), 1.5, facecolor="white", edgecolor=style.INK, linewidth=0.9))
    _arrow(axes, [reference.side(*RIGHT), (21.5, 29.5)])
    _arrow(axes, [(24.5, 29.5), law.side(*LEFT)], "e")
    _arrow(axes, [law.side(*RIGHT), (51.5, 29.5)])
    _arrow(axes, [(54.5, 29.5), drive.side(*LEFT)], "u")
    _arrow(axes, [drive.side(*RIGHT), table.side(*LEFT)])
    _arrow(axes, [(89.0, 43.5), table.side(*ABOVE)])
    _arrow(axes, [(89.0, 23.5), (89.0, 16.0)], "x" if kind == "translational" else "θ")
    _arrow(axes, [sensor.side(*LEFT), (23.0, 11.25), (23.0, 28.0)], "q")
    _write(axes, 24.3, 26.2, "−", "left", "baseline")
    if fed.friction is not None:
        _arrow(axes, [(10.75, 38.0), (10.75, 49.75), compensator.side(*LEFT)])
        _arrow(axes, [compensator.side(*RIGHT), (53.0, 49.75), (53.0, 31.0)])
        _write(axes, 54.0, 32.2, "+", "left", "baseline")


def _value_lines(model: Model, skip: tuple[str, ...] = ()) -> list[str]:
    """Return the first parameters of a model, one a line; lists by their range."""
    lines = []
    for name, value in model.values.items():
        if name in skip or isinstance(value, str):
            continue
        unit, symbol = model.component.variables[name].unit(model.kind), {"lambda": "λ", "phi": "φ"}.get(name.rstrip("_"), name)
        if hasattr(value, "__len__"):
            lines += [f"{len(value)} {symbol}", f"up to {_amount(float(max(map(abs, value))), unit)}"]
        elif value not in (0.0, float("inf")):
            lines.append(f"{symbol} = {_amount(float(value), unit)}")
    return lines[:6]  # lines in a block


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


def _friction(model: Model) -> list[str]:
    values, variables = model.values, model.component.variables
    elements = f"{len(values['nu_i'])} elements" if "nu_i" in values else ""
    if elements and values.get("scatter"):
        elements += f", scatter {100.0 * values['scatter']:g} %"
    lines, strong = [model.name, elements], [name for name in values if name.startswith("F_S")]
    if strong:
        forces = " and ".join(number(values[name], digits=3) for name in strong)
        lines.append(f"break-away {forces} {typeset(variables[strong[0]].unit(model.kind))}")
    return lines


def _box(axes: Axes, x: float, y: float, width: float, height: float, color: str, look: dict[str, Any]) -> None:
    axes.add_patch(FancyBboxPatch((x, y), width, height, boxstyle="round,pad=0,rounding_size=1.2", facecolor=color, **look))


def _draw_block(axes: Axes, block: Block) -> None:
    _box(axes, block.x, block.y, block.width, block.height, "white", {"edgecolor": style.PREDICTED["color"], "linewidth": 1.2})
    lines = [line for line in block.lines if line]
    step = min(2.7, (block.height - 1.5) / (len(lines) + 1.0))
    middle, centre = block.side(0.5, 0.5)
    top = centre + 0.5 * step * len(lines)
    available = (block.width - 1.0) * style.WIDTH / WIDTH
    _write(axes, middle, top, shortened(block.title, available / 1.12, LETTERS), fontweight="bold")  # bold letters are wider
    for index, line in enumerate(lines, 1):
        _write(axes, middle, top - step * index, shortened(line, available, SMALLER), size=SMALLER)


def _arrow(axes: Axes, path: list[tuple[float, float]], text: str = "") -> None:
    """Draw a line of straight parts with a head at its end, and a letter over its first part."""
    axes.plot(*zip(*path[:-1], strict=True), color=style.INK, linewidth=1.0, zorder=0.5)
    axes.add_patch(FancyArrowPatch(path[-2], path[-1], zorder=0.5, **HEAD))
    if text:
        (x, y), (to_x, to_y) = path[:2]
        upright = x == to_x
        beside, align = ((1.5, 0.0), "center") if upright else ((0.0, 0.9), "bottom")
        _write(axes, 0.5 * (x + to_x) + beside[0], 0.5 * (y + to_y) + beside[1], text, va=align, style="italic")
