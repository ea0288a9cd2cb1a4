"""Force over position of one contact: families of loops, the way to break-away, and a torque up and down below it."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bristle.core.variable import Kind
from bristle.figures import style
from bristle.figures.lettering import LETTERS, label, width
from bristle.figures.small_multiples import Traces, loop_units, plot_parts

Loops = Sequence[tuple[np.ndarray, np.ndarray]]


@style.styled
def loop_family(panels: Mapping[str, Mapping[str, Loops]], kind: Kind = "translational", effort: Kind | None = None) -> Figure:
    """Return force over position, loops upon loops."""
    curves = [curve for families in panels.values() for loops in families.values() for curve in loops]
    names = max(panels.values(), key=len)
    units, named = loop_units(curves, kind, effort), len(names) > 1
    figure, (row,) = style.panels(3.5, columns=len(panels), between=0.45, names=names if named else (), over_titles=named)
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
    traces: Traces, reached: Mapping[str, float], published: float, kind: Kind = "translational", effort: Kind | None = None
) -> Figure:
    """Return force over position with the place marked where each contact has nearly reached its largest force."""
    units = loop_units(traces.values(), kind, effort)
    figure, ((axes,),) = style.panels(3.4, names=["the paper", *traces])
    axes.axvline(published * units.length.factor, label="the paper", **style.DOTTED)
    for (name, (x, force)), look in zip(traces.items(), style.SERIES, strict=False):
        units.plot(axes, x, force, label=label(name), **look | {"marker": ""})
        if np.isfinite(at := reached[name]):
            mark = {"marker": look["marker"], "color": look["color"], "markersize": style.SMALL}
            units.plot(axes, at, float(np.interp(at, x, force)), label="_reached", **mark)
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
    """Return the driving force over time, and below it friction over position for each contact, from the ripple on."""
    curves = list(traces.values())
    units, word = loop_units([(x, driving) for x, _ in curves], kind, effort), style.effort_word(effort or kind)
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
    under = under if width(under, LETTERS) <= style.WIDTH * below[0].get_position().width else units.x
    if close_up is not None:
        # Over one another, less one straight line, with their names in room above them.
        beside, (heading, compared) = below.pop(1), close_up
        line = np.polynomial.Polynomial.fit(*next(iter(compared.values())), 1)
        for look, (name, (x, force)) in zip((style.MEASURED, style.PREDICTED), compared.items(), strict=False):
            units.plot(beside, x, force - line(x), label=label(name), **look)
        low, high = beside.get_ylim()
        beside.set_ylim(low, high + 0.45 * (high - low))
        beside.legend(loc="upper left", frameon=False)
        beside.set(xlabel=under, ylabel=units.force.label(f"{word} less a line"))
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
