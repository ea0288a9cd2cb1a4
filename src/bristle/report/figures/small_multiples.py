"""Force over position: models at the same scale, closure and drift; families of loops; and torque over a ripple."""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle.core import InputError, Kind, Model, Scale, number, unit_of, with_unit
from bristle.engine import response
from bristle.report.figures import style
from bristle.report.figures.drawing import LETTERS, label, width

Traces = Mapping[str, tuple[np.ndarray, np.ndarray]]
MARGIN = 0.05  # of the height, above and below
NESTED = [0.0, 1.0, -1.0, 0.3, -0.6, 1.0]  # turns of a path
LETTER = 0.09  # height of a letter; points closer than a third of it share a letter


class LoopUnits(NamedTuple):
    """The units of force and position, and the labels of the axes."""

    length: Scale
    force: Scale
    x: str
    y: str

    def plot(
        self, axes: Axes, x: np.ndarray | float, force: np.ndarray | float, *mark: str, **look: Any
    ) -> None:
        """Draw force over position, given in SI, in these units."""
        axes.plot(
            np.multiply(x, self.length.factor), np.multiply(force, self.force.factor), *mark, **look
        )

    def height(
        self, curves: Collection[tuple[np.ndarray, np.ndarray]], margin: float = MARGIN
    ) -> tuple[float, float]:
        """Return the range of forces of the curves, with a margin, in these units."""
        low, high = (
            edge(float(edge(force)) for _, force in curves) * self.force.factor
            for edge in (min, max)
        )
        return low - margin * (high - low), high + margin * (high - low)


def loop_units(
    curves: Collection[tuple[np.ndarray, np.ndarray]], kind: Kind, effort: Kind | None = None
) -> LoopUnits:
    """Return the units for curves of (x, force); `effort` selects forces of another kind of axis."""
    length = style.scale_for("length", kind, *(x for x, _ in curves))
    force, word = style.effort_scale(effort or kind, *(force for _, force in curves))
    return LoopUnits(
        length,
        force,
        length.label(style.position_word(kind)),
        force.label(f"Friction {word.lower()}"),
    )


def plot_parts(
    axes: Axes,
    units: LoopUnits,
    trace: tuple[np.ndarray, np.ndarray],
    turn: int,
    names: tuple[str, str],
) -> None:
    """Draw the part before a sample wide and light, and the part after it narrow and dark."""
    x, force = trace
    units.plot(axes, x[: turn + 1], force[: turn + 1], label=names[0], **style.MEASURED)
    units.plot(axes, x[turn:], force[turn:], label=names[1], **style.PREDICTED)


def _refuse_unlike(traces: Traces, name: str, numbers: Mapping[str, float]) -> None:
    """Refuse traces that are no curves, and numbers that are not those of the traces."""
    if not traces:
        raise InputError(
            "is empty", path="traces", mend="Give a pair of positions and forces for each model"
        )
    for model, (x, force) in traces.items():
        if len(x) != len(force):
            raise InputError(
                "needs a force for each position",
                path=f"traces.{model}",
                value=f"{len(x)} positions, {len(force)} forces",
            )
    if numbers.keys() != traces.keys():
        raise InputError(
            "has other names than traces",
            path=name,
            value=", ".join(numbers),
            allowed=", ".join(traces),
        )


def _panels(
    traces: Traces,
    titles: Mapping[str, str],
    kind: Kind,
    effort: Kind | None = None,
    beneath: Traces | None = None,
    **layout: Any,
) -> tuple[Figure, dict[str, Axes], LoopUnits]:
    """Return a figure with a titled panel for each trace, the panels by name, and the units."""
    curves = [*traces.values(), *(beneath or {}).values()]
    units, columns = loop_units(curves, kind, effort), layout.setdefault("columns", 3)
    figure, axes = style.grid_of(len(traces), between=0.2, gap=0.72, **layout)
    for panel, name in zip(axes, traces, strict=True):
        style.title(panel, titles[name], name)
        panel.set(ylim=units.height(curves), xlabel=units.x)
    for start in range(0, len(axes), columns):
        style.share_y(axes[start : start + columns], units.y)
    return figure, dict(zip(traces, axes, strict=True)), units


def loops_of(friction: Model, distance: float) -> Figure:
    """Return force over position along nested reversals within a pre-sliding distance [m or rad], and along long slides."""
    speed = next((value for name, value in friction.values.items() if name.startswith("v_S")), None)
    paths: dict[str, tuple[list[float], float, float]] = (
        {"pre-sliding": (NESTED, distance, distance)} if distance > 0.0 else {}
    )
    if speed is not None or not paths:
        paths["sliding"] = ([0.0, 1.0, -1.0, 1.0], 50.0 * distance or 0.01, 3.0 * (speed or 0.03))
    traces, ease = {}, 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 400))
    for name, (turns, amplitude, fastest) in paths.items():
        x = amplitude * np.concatenate(
            [start + (end - start) * ease for start, end in pairwise(turns)]
        )
        traces[name] = x, response(friction, x, dt=float(np.max(np.abs(np.diff(x)))) / fastest)
    return minor_loops(traces, friction.kind)


@style.styled
def minor_loops(traces: Traces, kind: Kind = "translational") -> Figure:
    """Return force over position, a panel for each model.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    figure, panels, units = _panels(traces, {name: name for name in traces}, kind)
    for name, axes in panels.items():
        units.plot(axes, *traces[name], label=name, **style.PREDICTED)
    return figure


@style.styled
def drift(traces: Traces, per_cycle: Mapping[str, float], kind: Kind = "translational") -> Figure:
    """Return force over position while the force rises and falls: the first loading wide and light, then the cycles.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    per_cycle : mapping of str to float
        Drift in a settled cycle [m or rad].
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    _refuse_unlike(traces, "per_cycle", per_cycle)
    widest = max(float(np.ptp(x)) for x, _ in traces.values())
    unit = unit_of("length", kind)
    titles = {
        name: f"{name}: {with_unit(step, unit) if abs(step) > 1e-6 * widest else 'no drift'}"
        for name, step in per_cycle.items()
    }
    figure, panels, units = _panels(traces, titles, kind)
    for name, axes in panels.items():
        force = traces[name][1]
        plot_parts(
            axes,
            units,
            traces[name],
            int(np.argmax(force >= (1.0 - 1e-9) * np.max(force))),
            ("first loading", "cycles"),
        )
        axes.set_xlim(*(share * widest * units.length.factor for share in (-0.03, 1.03)))
    return figure


@style.styled
def closure(traces: Traces, missing: Mapping[str, float], kind: Kind = "translational") -> Figure:
    """Return force over position along ``0 -> x1 -> x2 -> x1``, with the force at x1 before and after.

    Parameters
    ----------
    traces : mapping of str to (x, force)
        Positions [m or rad] and forces [N or N*m], by the name of the model.
    missing : mapping of str to float
        The missing force at the return, as a fraction of break-away.
    kind : {"translational", "rotational"}
        The kind of axis.
    """
    _refuse_unlike(traces, "missing", missing)
    percents = {
        name: f"{number(100.0 * share, resolution=1.0)} %" if abs(share) >= 5e-5 else "closes"
        for name, share in missing.items()
    }
    figure, panels, units = _panels(
        traces, {name: f"{name}: {percent}" for name, percent in percents.items()}, kind
    )
    for name, axes in panels.items():
        x, force = traces[name]
        turn = int(np.argmax(np.abs(x)))
        plot_parts(axes, units, traces[name], turn, ("loading", "back and again"))
        for at, marker, word in ((turn, "o", "left"), (-1, "x", "returned")):
            units.plot(
                axes,
                x[at],
                force[at],
                marker,
                label=word,
                markersize=style.SMALL,
                color=style.INK,
                fillstyle="none",
            )
    return figure


@style.styled
def marked_path(
    traces: Traces,
    turns: Mapping[str, Sequence[int]],
    letters: str,
    titles: Mapping[str, str],
    kind: Kind = "translational",
    effort: Kind | None = None,
    beneath: Traces | None = None,
    names: tuple[str, str] = ("there", "back and on"),
) -> Figure:
    """Return force over position with the turning points marked, a panel for each model."""
    figure, panels, units = _panels(
        traces, titles, kind, effort, beneath, columns=min(2, len(traces)), top=0.56
    )
    for name, axes in panels.items():
        x, force = traces[name]
        if beneath:
            units.plot(axes, *beneath[name], label=names[0], **style.MEASURED)
            units.plot(axes, x, force, label=names[1], **style.PREDICTED)
        else:
            plot_parts(axes, units, traces[name], int(turns[name][1]), names)
        samples = np.asarray(turns[name])
        marked = x[samples] * units.length.factor, force[samples] * units.force.factor
        axes.plot(
            *marked, "o", color=style.INK, fillstyle="none", markersize=style.SMALL, label="_turns"
        )
        axes.margins(x=0.08)
        axes.set_ylim(*units.height([*traces.values(), *(beneath or {}).values()], 2.0 * MARGIN))
        _write_letters(axes, *marked, letters)
    style.legend_in_corner(figure, figure.axes[0])
    return figure


def _write_letters(axes: Axes, x: np.ndarray, force: np.ndarray, letters: str) -> None:
    """Write a letter at each point, away from the middle; the same letter twice only if the points are apart."""
    middle = 0.5 * (float(x.min()) + float(x.max()))
    low, high = axes.get_ylim()
    written: list[tuple[str, float]] = []
    for position, height, letter in zip(x, force, letters, strict=True):
        apart = min(
            (abs(at - height) / (high - low) for earlier, at in written if earlier == letter),
            default=1.0,
        )
        if letter.strip() and apart > LETTER / 3.0:
            left = position < middle
            shift = (-5 if left else 5, -9 if left or apart < LETTER else 2)
            align = "right" if left else "left"
            axes.annotate(
                letter,
                (position, height),
                xytext=shift,
                textcoords="offset points",
                ha=align,
                color=style.INK,
            )
            written.append((letter, height))


Loops = Sequence[tuple[np.ndarray, np.ndarray]]


@style.styled
def loop_family(
    panels: Mapping[str, Mapping[str, Loops]],
    kind: Kind = "translational",
    effort: Kind | None = None,
) -> Figure:
    """Return force over position with several loops in each panel."""
    curves = [
        curve for families in panels.values() for loops in families.values() for curve in loops
    ]
    names = max(panels.values(), key=len)
    units, named = loop_units(curves, kind, effort), len(names) > 1
    figure, (row,) = style.panels(
        3.5, columns=len(panels), between=0.45, names=names if named else (), over_titles=named
    )
    for axes, (title, families) in zip(row, panels.items(), strict=True):
        looks = (style.MEASURED, style.PREDICTED)[-len(families) :]
        for look, (name, loops) in zip(looks, families.items(), strict=False):
            for index, loop in enumerate(loops):
                units.plot(axes, *loop, label=f"_{name}" if index else label(name), **look)
        axes.set(ylim=units.height(curves), xlabel=units.x)
        style.title(axes, title)
    style.share_y(row, units.y)
    if named:
        style.legend(row[0])
    return figure


@style.styled
def break_away(
    traces: Traces,
    reached: Mapping[str, float],
    published: float,
    kind: Kind = "translational",
    effort: Kind | None = None,
) -> Figure:
    """Return force over position, marked where each contact has nearly reached its largest force."""
    units = loop_units(traces.values(), kind, effort)
    figure, ((axes,),) = style.panels(3.4, names=["the paper", *traces])
    axes.axvline(published * units.length.factor, label="the paper", **style.DOTTED)
    for (name, (x, force)), look in zip(traces.items(), style.SERIES, strict=False):
        units.plot(axes, x, force, label=label(name), **look | {"marker": ""})
        if np.isfinite(at := reached[name]):
            mark = {"marker": look["marker"], "color": look["color"], "markersize": style.SMALL}
            units.plot(
                axes, at, float(np.interp(at, x, force)), label=f"_{label(name)}, reached", **mark
            )
    axes.set(ylim=(0.0, None), xlabel=units.x, ylabel=units.y)
    style.legend(axes)
    return figure


@style.styled
def ripple(
    time: np.ndarray,
    driving: np.ndarray,
    traces: Traces,
    cycle: int,
    titles: Mapping[str, str],
    kind: Kind = "translational",
    effort: Kind | None = None,
    close_up: tuple[str, Traces] | None = None,
) -> Figure:
    """Return the driving force over time, and below it friction over position for each contact, from the first cycle of the ripple on."""
    curves = list(traces.values())
    units, word = (
        loop_units([(x, driving) for x, _ in curves], kind, effort),
        style.effort_word(effort or kind),
    )
    count = len(traces) + (close_up is not None)
    columns, rows = min(count, 2), -(-count // 2)
    figure, ((above,), *grid) = style.panels(
        style.ROW + style.PANEL * rows + 0.4,
        rows=1 + rows,
        columns=columns,
        heights=(0.75, *([1.0] * rows)),
        undivided=(0,),
        between=0.75 if close_up else 0.45,
        top=0.4,
    )
    below = [axes for row in grid for axes in row]
    for unused in below[count:]:
        unused.remove()
    del below[count:]
    span = style.time_scale(time)
    above.plot(time * span.factor, driving * units.force.factor, color=style.INK)
    above.set(xlabel=span.label("Time"), ylabel=units.force.label(f"Driving {word.lower()}"))
    under = units.x.replace(" [", ", from the first cycle on [")
    under = (
        under if width(under, LETTERS) <= style.WIDTH * below[0].get_position().width else units.x
    )
    if close_up is not None:
        # On top of each other, minus one straight line, with their names in room above them.
        beside, (heading, compared) = below.pop(1), close_up
        line = np.polynomial.Polynomial.fit(*next(iter(compared.values())), 1)
        for look, (name, (x, force)) in zip(
            (style.MEASURED, style.PREDICTED), compared.items(), strict=False
        ):
            units.plot(beside, x, force - line(x), label=label(name), **look)
        low, high = beside.get_ylim()
        beside.set_ylim(low, high + 0.45 * (high - low))
        beside.legend(loc="upper left", frameon=False)
        beside.set(xlabel=under, ylabel=units.force.label(f"{word} minus a line"))
        style.title(beside, heading)
    for axes, (name, trace) in zip(below, traces.items(), strict=True):
        plot_parts(axes, units, trace, cycle, ("first cycle", "later cycles"))
        style.title(axes, titles[name], name)
        axes.set(ylim=units.height(curves), xlabel=under)
        if axes.get_position().x0 > above.get_position().x0 + 0.1:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(units.y)
    style.legend_in_corner(figure, below[0])
    return figure
