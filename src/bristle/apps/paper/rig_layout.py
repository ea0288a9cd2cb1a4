"""A rig as two rows of boxes on a grid: its mechanics on the shaft, and its loop as a block diagram."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle

from bristle.core import Model, Variant, number, unit_of, with_unit
from bristle.report.figures import style
from bristle.report.figures.drawing import AT_TICKS, LETTERS, shortened

COLUMNS = 4  # of the grid
ROWS = 4
ROW = 1.4  # height [inch]
SHARE = 0.78  # of a cell for its box
LINES = 7  # in a box
# From box to box: the signal, and for a line with a corner, its first direction.
ARROWS = (
    ("motor", "torque sensor", "u, θ", ""),
    ("torque sensor", "ball screw", "", ""),
    ("ball screw", "table", "x", ""),
    ("reference", "controller", "r", ""),
    ("controller", "drive", "u", ""),
    ("drive", "rig", "F", ""),
    ("friction", "rig", "F_p", ""),
    ("rig", "sensor", "x", ""),
    ("sensor", "controller", "q", "angle,angleA=180,angleB=90,rad=0"),
)
FED = (
    ("reference", "compensator", "", "angle,angleA=90,angleB=180,rad=0"),
    ("compensator", "controller", "F̂", ""),
)


class Mechanics(NamedTuple):
    """Numbers of the drawing."""

    lead: float
    J: float
    J_m: float
    cutoff: float
    resolution: float


@style.styled
def rig_layout(mechanics: Mechanics, variant: Variant) -> Figure:
    """Return the mechanics of a rig, and below them the block diagram of its loop."""
    figure, ((axes,),) = style.panels(ROW * ROWS, left=0.0, right=0.0, top=0.0, bottom=0.0)
    axes.set(xlim=(0.0, COLUMNS), ylim=(ROWS, 0.0))
    axes.set_axis_off()
    blocks = _mechanics(mechanics) | _loop(variant)
    boxes = {name: _draw_block(axes, *block) for name, block in blocks.items()}
    arrows = ARROWS
    if variant.feedforward.friction:
        arrows += FED
    for begin, end, text, corner in arrows:
        first = boxes[begin]
        last = boxes[end]
        x, y = first.get_center()
        to_x, to_y = last.get_center()
        line = {
            "patchA": first,
            "patchB": last,
            "connectionstyle": corner or "arc3",
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        }
        axes.add_patch(
            FancyArrowPatch(
                (x, y),
                (to_x, to_y),
                arrowstyle="-|>",
                mutation_scale=LETTERS,
                color=style.INK,
                **line,
            )
        )
        at = 0.5 * (y + to_y)
        if corner or x == to_x:  # to the right of an upright arrow
            place = {"xy": (to_x, at), "xytext": (4, 0), "ha": "left", "va": "center"}
        else:  # above a level arrow
            middle = (0.5 * (x + to_x), at)
            place = {"xy": middle, "xytext": (0, 2), "ha": "center", "va": "bottom"}
        axes.annotate(text, **place, textcoords="offset points", style="italic")
    return figure


Block = tuple[int, int, str, Sequence[str]]  # column, row, first line, the others


def _mechanics(mechanics: Mechanics) -> dict[str, Block]:
    """Return the parts on the shaft, in order, each with its numbers."""
    lead, J, J_m, cutoff, resolution = mechanics
    behind, total, motor = (
        f"{name} = {with_unit(inertia, 'kg*m^2')}"
        for name, inertia in (("J − J_m", J - J_m), ("J", J), ("J_m", J_m))
    )
    counts = "perfect encoder"
    if resolution > 0.0:
        counts = f"{lead / resolution:,.0f} counts a turn".replace(",", " ")
    filtered = ""
    if math.isfinite(cutoff):
        filtered = f"filter {with_unit(cutoff, 'Hz')}"
    at_table = f"as a mass {with_unit(J * (2.0 * math.pi / lead) ** 2, 'kg')}"
    return {
        "motor": (0, 0, "DC motor, encoder", [motor, counts]),
        "torque sensor": (
            1,
            0,
            "torque sensor",
            ["between couplings", "T = F_p +", "(J − J_m) dω/dt", filtered],
        ),
        "ball screw": (2, 0, "ball screw", [f"lead {with_unit(lead, 'm')}", "rigid"]),
        "table": (3, 0, "table", ["on a linear guide", behind, f"{total},", at_table]),
    }


def _loop(variant: Variant) -> dict[str, Block]:
    """Return the parts of a loop, each with its numbers."""
    run = variant.run
    late = []
    if run.delay:
        late.append(f"delay {run.delay} T")
    if run.current_lag:
        late.append(f"lag {with_unit(run.current_lag, 's')}")
    elements = []
    if "nu_i" in variant.friction.values:
        elements = [f"{len(variant.friction.values['nu_i'])} elements"]
    return {
        "compensator": (1, 1, *_compensator(variant)),
        "friction": (
            3,
            1,
            "friction",
            [
                *variant.friction.name.replace("+", " +").split(),
                *elements,
                *_value_lines(variant.friction),
            ],
        ),
        "reference": (0, 2, "reference", _value_lines(variant.reference)),
        "controller": (
            1,
            2,
            variant.controller.name.replace("_", " "),
            [f"every {with_unit(run.sample_time, 's')}", *_value_lines(variant.controller)],
        ),
        "drive": (2, 2, "drive", late or ["ideal"]),
        "rig": (3, 2, variant.plant.name, _value_lines(variant.plant)),
        "sensor": (3, 3, variant.sensor.name, _value_lines(variant.sensor)),
    }


def _compensator(variant: Variant) -> tuple[str, list[str]]:
    """Return the first line of the compensator, and the lines of its numbers."""
    fed = variant.feedforward
    name = "no compensator"
    lines = []
    if fed.friction:
        name = "compensator"
        lines = [fed.friction.name, *_value_lines(fed.friction)[:2]]
    if fed.gain != 1.0:
        lines.append(f"gain {fed.gain:g}")
    if fed.asymmetry:
        lines.append(f"asymmetry {fed.asymmetry:g}")
    if fed.offset:
        lines.append(f"offset {with_unit(fed.offset, unit_of('force', variant.plant.kind))}")
    return name, lines


def _value_lines(model: Model) -> list[str]:
    """Return the parameters of a model, a line each; arrays by their range."""
    lines = []
    for name, value in model.values.items():
        if name == "seed" or isinstance(value, str):
            continue
        unit = model.component.variables[name].unit(model.kind)
        symbol = {"lambda": "λ", "phi": "φ"}.get(name.rstrip("_"), name)
        if hasattr(value, "__len__"):
            lines += [
                f"{len(value)} {symbol}",
                f"up to {_amount(float(max(map(abs, value))), unit)}",
            ]
        elif value not in (0.0, float("inf")):
            lines.append(f"{symbol} = {_amount(float(value), unit)}")
    return lines


def _amount(value: float, unit: str) -> str:
    """Return a number with its unit; a stiffness per micrometre, as usual."""
    if unit == "N/m":
        return f"{number(1e-6 * value, digits=3)} N/µm"
    return with_unit(value, unit)


def _draw_block(axes: Axes, column: int, row: int, title: str, lines: Sequence[str]) -> Rectangle:
    """Draw a box in its cell, its first line bold."""
    middle = (column + 0.5, row + 0.5)
    width = SHARE * style.WIDTH / COLUMNS - 0.1  # of a text [inch]
    corner = middle[0] - 0.5 * SHARE, middle[1] - 0.5 * SHARE
    box = Rectangle(
        corner, SHARE, SHARE, facecolor="white", edgecolor=style.PREDICTED["color"], zorder=2
    )
    axes.add_patch(box)
    texts = [shortened(line, width, AT_TICKS) for line in lines if line][:LINES]
    heading = shortened(title, 0.9 * width, LETTERS)  # bold letters are wider
    step = SHARE / (LINES + 2.0)
    top = middle[1] - 0.5 * step * len(texts)
    axes.text(middle[0], top, heading, ha="center", va="center", fontweight="bold", zorder=3)
    for index, text in enumerate(texts, 1):
        axes.text(
            middle[0],
            top + step * index,
            text,
            ha="center",
            va="center",
            fontsize=AT_TICKS,
            zorder=3,
        )
    return box
