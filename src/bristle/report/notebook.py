"""A model and an identification in a notebook: HTML with equations, numbers and a picture, and a widget where Python runs."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from markupsafe import Markup

from bristle.core import Card, InputError, Model, number, scale_of, unit_of
from bristle.prediction import level_values, reversal_distance
from bristle.report.table import capital, fixed, interval_text, length_text, percent_text

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit

BAR = 25.0  # half-width of a bar [% of the value]


def as_html(result: Any) -> str:
    """Return a model or an identification as HTML with its own style."""
    try:
        from bristle.figures.palette import DARK, LIGHT
        from bristle.lab.page import joined
    except (ImportError, InputError):  # of matplotlib
        style = ""
    else:
        colours = "".join(f"--{name}:light-dark({colour},{DARK[name]});" for name, colour in LIGHT.items())
        style = f"<style>.bristle{{{colours}}}{joined(('card.css',))}</style>"
    return f'<div class="bristle">{style}{"".join(_parts(result))}</div>'


def bundle(result: Any, include: Any = None, exclude: Any = None) -> dict[str, Any]:
    """Return what a notebook stores: text, HTML and, where Python runs, the widget; only text in a terminal."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None and not hasattr(shell, "kernel"):
        return {"text/plain": repr(result)}
    return {"text/plain": repr(result), "text/html": as_html(result)} | ({} if shell is None else _live(result))


def _live(result: Any) -> dict[str, Any]:
    """Return the view of a widget with sliders in place of the table; empty if it cannot be made."""
    try:
        from bristle.lab import Widget

        widget = Widget(result) if isinstance(result, Model) else result.widget()
    except (ImportError, InputError):  # without anywidget, or no page can compute the model
        return {}
    widget._card = "".join(_parts(result)[:-1])
    view = "application/vnd.jupyter.widget-view+json"
    return {view: (widget._repr_mimebundle_() or [{}])[0].get(view, {})}


def _parts(result: Any) -> list[str]:
    """Return the HTML of item part, last the parameters."""
    return _of_model(result) if isinstance(result, Model) else _of_identification(result)


def _of_model(model: Model) -> list[str]:
    """Return name, description, equations, and parameters beside a picture of the loops of friction."""
    component, unit = model.component, {name: variable.unit(model.kind) for name, variable in model.component.variables.items()}
    try:
        from latex2mathml.converter import convert

        equations = [Markup(convert(equation)) for equation in component.latex]
    except Exception:  # noqa: BLE001  (not installed, or other LaTeX in the docstring of a user)
        equations = [Markup("<div>{}</div>").format(line) for line in component.equations]
    head = Markup('<p><strong>{}</strong> <span class="soft">{}, {}</span></p><p>{}.</p><div class="equations">{}</div>')
    rows = [(name, _value(value, unit[name]), component.variables[name].description) for name, value in model.values.items()]

    def draw() -> Any:
        from bristle.figures.small_multiples import loops_of

        return loops_of(model, reversal_distance(model, 0.1))

    picture = _picture(draw, f"Force over position of {model.name}", model) if component.family == "friction" else ""
    return [
        head.format(model.name, component.family, model.kind, capital(component.description), Markup("").join(equations)),
        picture + Card("", ("Parameter", "Value", "Meaning"), tuple(rows)).html(),
    ]


def _value(value: Any, unit: str) -> str:
    """Return a parameter in a readable unit."""
    if isinstance(value, str):
        return value
    scale = scale_of(unit, float(np.max(np.abs(value), initial=0.0)))
    return f"{', '.join(f'{item:.6g}' for item in np.atleast_1d(value) * scale.factor)} {scale.unit}".replace("inf", "∞").rstrip()


def _picture(draw: Callable[[], Any], description: str, result: Any) -> str:
    """Return a figure in the colours of the notebook; empty without matplotlib."""
    try:
        from bristle.figures import inline_svg
        from bristle.figures.palette import LIGHT

        svg = inline_svg(draw(), f"b{hashlib.sha256(repr(result).encode()).hexdigest()[:8]}", description)
    except (ImportError, InputError):
        return ""
    names = {colour: f"var(--{name},{colour})" for name, colour in LIGHT.items()}
    themed = re.sub('#[0-9a-f]{6}(?=[;"])', lambda match: names.get(match[0], match[0]), svg)
    return f'<div class="picture">{themed}</div>'


def _of_identification(identified: Any) -> list[str]:
    """Return verdict, numbers, gain, picture, warnings, and the table of all parameters."""
    from bristle.report.brief import brief  # with matplotlib, which a model does without
    from bristle.report.compensation import gain_of
    from bristle.report.judgement import LEVELS, judged
    from bristle.report.messages import warnings_of
    from bristle.report.page import Ruling

    fit, outcome, lines = identified.best, getattr(identified, "outcome", None), []
    if outcome is None:  # loaded
        level = identified.summary["verdict"]["level"]
        ruling = Ruling(level, LEVELS[level], tuple(identified.summary["verdict"]["reasons"]))
    else:
        ruling = judged(fit, identified.settings, outcome.following)
        lines = brief(identified, outcome.simulation, outcome.following, identified.axis)[:-1]
    gain = lines[next((place for place, line in enumerate(lines) if line.label == "Gain"), len(lines)) :]

    def draw() -> Any:
        from bristle.figures.following_error import loops_at_reversal

        simulation = None if outcome is None else outcome.simulation
        gained = None if simulation is None else gain_of(simulation)
        if simulation is None or gained is None or not gained.steps:
            return identified.plot()
        return loops_at_reversal(simulation, [step.name for step in gained.steps[-2:]])

    verdict = Markup('<p><span class="pill {}">{}</span> <strong>{}</strong> <span class="soft">{}</span></p>')
    warned = [Markup("<li>{}</li>").format(warning) for warning in warnings_of(fit)]
    return [
        verdict.format(ruling.level, ruling.words, fit.name, "; ".join(ruling.reasons)),
        f'<div class="numbers">{"".join(item.html() for item in numbers_of(fit))}</div>',
        *(Markup('<p class="{}">{}</p>').format(line.level or "soft", capital(line.text)) for line in gain),
        _picture(draw, f"Following error or effort of {fit.name}", identified),
        f'<strong class="warned">Warnings</strong><ul>{"".join(warned)}</ul>' if warned else "",
        '<p class="soft">Report: <code>.report("report.html")</code></p>',
        f"<details><summary>All parameters</summary>{identified._card().html()}</details>",
    ]


class Number(NamedTuple):
    """A number of an identification, its interval, and the half-width of its interval [%]; without it the bar is striped."""

    label: str
    text: str
    interval: str
    half: float | None = None

    def html(self) -> str:
        """Return the number with a bar for its interval."""
        half = None if self.half is None else 50.0 * min(self.half / BAR, 1.0)
        bar = "" if half is None else Markup('<i style="left:{:.1f}%;width:{:.1f}%"></i>').format(50.0 - half, 2.0 * half)
        text = '<div><small>{}</small><strong>{}</strong><span class="bar">{}</span><small>{}</small></div>'
        return Markup(text).format(self.label, self.text, bar, self.interval)


def numbers_of(fit: Fit) -> list[Number]:
    """Return mass, friction level, pre-sliding distance and held-out error, item with its interval."""
    from bristle.report.model_tables import parameter_table

    kind, levels, table = fit.plant.kind, level_values(fit), parameter_table(fit)
    rows = {row[0]: dict(zip(table.heads, row, strict=True)) for row in table.rows}
    numbers = [_presliding(fit)]
    of_level = [estimate for estimate in fit.estimates if estimate.name in fit.levels]
    if levels is not None:
        sides = (levels.forward, levels.backward)
        text = " / ".join("unknown" if level is None else fixed(level, unit_of("force", kind)) for level in sides)
        numbers.insert(0, _of_estimates("Friction, forward / backward", text, of_level, rows))
    if fit.inertia is not None and (row := rows.get(fit.inertia.name)):
        text = f"{row['Value']} {row['Unit']}"
        numbers.insert(0, _of_estimates("Inertia" if kind == "rotational" else "Mass", text, [fit.inertia], rows))
    if fit.held_out is not None:
        errors = fit.held_out.block_errors_percent
        span = f"{interval_text(*(number(end, digits=3) for end in (min(errors), max(errors))))} %, {fit.held_out.of}"
        numbers.append(Number("Model error, held out", percent_text(fit.held_out.mean_percent), span, fit.held_out.std_percent))
    return numbers


def _of_estimates(label: str, text: str, estimates: list[Estimate], rows: dict[str, dict[str, str]]) -> Number:
    """Return a number with the intervals of estimates, as their table has them."""
    intervals = []
    for row in (rows[estimate.name] for estimate in estimates if estimate.name in rows):
        interval = row.get("95 % interval", "–")
        width = f"{interval} {row['Unit']}" if interval != "–" else row.get("95 % interval [%]", "–") + " %"
        intervals.append(f"{row['Parameter']}: {width if '– ' not in width else row.get('Remark', '')}")
    halves = [item.interval_percent for item in estimates if item.status == "identified" and item.interval_percent is not None]
    return Number(label, text, "; ".join(intervals), max(halves, default=None))


def _presliding(fit: Fit) -> Number:
    """Return the distance over which friction builds up after a reversal, with its interval from the replicates."""
    fastest, kind, distances = float(np.max(np.abs(fit.traces.velocity))), fit.friction.kind, []
    distance, label = reversal_distance(fit.friction, fastest), "Pre-sliding distance"
    if not distance:
        return Number(label, "–", "the model has no pre-sliding")
    drawn = {} if fit.resampling is None else fit.resampling.bands.draws
    names = [name for name in drawn if name in fit.friction.values]
    for values in zip(*(drawn[name] for name in names), strict=True):
        try:
            distances.append(reversal_distance(fit.friction.with_values(**dict(zip(names, values, strict=True))), fastest))
        except InputError:  # out of range
            continue
    if not distances:
        return Number(label, length_text(distance, kind), "no interval without replicates")
    low, high = np.percentile(distances, [2.5, 97.5]).tolist()
    interval = interval_text(length_text(low, kind), length_text(high, kind))
    return Number(label, length_text(distance, kind), interval, 50.0 * (high - low) / distance)
