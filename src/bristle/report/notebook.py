"""A friction model and an identification in a notebook: HTML with equations, numbers and a picture, and a widget where Python runs."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from markupsafe import Markup

from bristle.core import InputError, Model, number, scale_of, symbolic, unit_of, with_unit
from bristle.prediction import level_values, reversal_distance
from bristle.report.brief import Line, brief
from bristle.report.judgement import LEVELS, judged
from bristle.report.messages import message, warnings_of
from bristle.report.page import Ruling
from bristle.report.table import capital, fixed, interval_text, length_text, percent_text

if TYPE_CHECKING:
    from bristle.identification import Estimate, Fit
    from bristle.report.model_in_hand import ModelInHand

THEMES = '[data-jp-theme-light="true"] .bristle,.vscode-light .bristle', '[data-jp-theme-light="false"] .bristle,.vscode-dark .bristle'
BAR = 0.25  # either side of a value, as a share of it
SPEED = 0.1  # [m/s or rad/s] of a model without a log


def as_html(shown: Model | ModelInHand) -> str:
    """Return a model or an identification as HTML with its own style."""
    parts = _of_model(shown) if isinstance(shown, Model) else _of_identification(shown)
    try:
        from bristle.figures.palette import colour_variables
        from bristle.lab.page import joined
    except (ImportError, InputError):  # of matplotlib
        style = ""
    else:
        style = f"<style>{colour_variables('.bristle', THEMES)}{joined(('card.css',))}</style>"
    return f'<div class="bristle">{style}{"".join(parts)}</div>'


def bundle(shown: Model | ModelInHand) -> dict[str, Any]:
    """Return what a notebook stores: text, HTML, and in a kernel with anywidget also the widget; a terminal needs text only."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None and not hasattr(shell, "kernel"):
        return {"text/plain": repr(shown)}
    return ({} if shell is None else _widget(shown)) | {"text/plain": repr(shown), "text/html": as_html(shown)}


def _widget(shown: Model | ModelInHand) -> dict[str, Any]:
    """Return the view of a widget; empty without anywidget, or if a page cannot compute the model."""
    try:
        from bristle.lab import Widget

        widget = Widget(shown) if isinstance(shown, Model) else shown.widget()
    except (ImportError, InputError):
        return {}
    widget._card = "".join(_head(shown) if isinstance(shown, Model) else _of_identification(shown)[:-1])
    return (widget._repr_mimebundle_() or ({}, {}))[0]


def _head(model: Model) -> list[str]:
    """Return name, description and equations of a model; equations as text where latex2mathml cannot typeset them."""
    component = model.component
    try:
        from latex2mathml.converter import convert

        equations = [Markup(convert(equation)) for equation in component.latex]
    except Exception:  # noqa: BLE001  (it is not installed, or the docstring of a user has another LaTeX)
        equations = [Markup("<div>{}</div>").format(line) for line in component.equations]
    title = Markup('<h4>{}</h4><span class="soft">{}, {}</span><p>{}.</p><div class="equations">{}</div>')
    return [title.format(model.name, component.family, model.kind, capital(component.description), Markup("").join(equations))]


def _of_model(model: Model) -> list[str]:
    """Return a model: its head, its parameters and, for friction, a picture of its loops."""

    def draw() -> Any:
        from bristle.figures.notebook import loop

        return loop(model, reversal_distance(model, SPEED))

    variables = model.component.variables
    cell = Markup("<tr><td>{}</td><td>{}</td><td>{}</td></tr>")
    rows = [
        cell.format(symbolic(name), variables[name].description, _value(value, variables[name].unit(model.kind)))
        for name, value in model.values.items()
    ]
    picture = _picture(draw, f"Force over position of {model.name}", repr(model)) if model.component.family == "friction" else ""
    table = Markup('<div class="panes"><table>{}</table>{}</div>')
    return [*_head(model), table.format(Markup("").join(rows), picture)]


def _value(value: Any, unit: str) -> str:
    """Return a parameter in a readable unit; a list in the unit of its largest number."""
    if isinstance(value, str):
        return value
    scale = scale_of(unit, float(np.max(np.abs(np.atleast_1d(value)), initial=0.0)))
    texts = [number(each * scale.factor) for each in np.atleast_1d(value).tolist()]
    return f"{', '.join(texts)} {scale.unit}".rstrip() if np.ndim(value) else with_unit(value, unit, 4)


def _picture(draw: Callable[[], Any], description: str, seed: str) -> Markup:
    """Return a figure as SVG in the colours of the notebook; empty without matplotlib. The seed names its parts."""
    try:
        from bristle.figures import inline_svg
        from bristle.figures.palette import LIGHT

        svg = inline_svg(draw(), f"b{hashlib.sha256(seed.encode()).hexdigest()[:8]}", description)
    except (ImportError, InputError):
        return Markup("")
    names = {colour: name for name, colour in LIGHT.items()}
    themed = re.sub(r"#[0-9a-f]{6}\b", lambda found: f"var(--{names[found[0]]},{found[0]})" if found[0] in names else found[0], svg)
    return Markup(f"<div>{themed}</div>")


def _of_identification(found: ModelInHand) -> list[str]:
    """Return an identification: verdict, four numbers, gain, picture, warnings and, last, its table."""
    fit, outcome = found.best, getattr(found, "outcome", None)
    following = None if outcome is None else outcome.following
    warned = list(warnings_of(fit))
    if outcome is None:  # loaded
        ruling, gain = _ruling(found), []
    else:
        ruling = judged(fit, outcome.identification.settings, following)
        gain = _gain(brief(outcome.identification, outcome.simulation, following, found.axis))
        warned += [message(following.contradiction)] if following is not None and following.contradiction is not None else []

    def draw() -> Any:
        from bristle.figures.following_error import has_completed
        from bristle.figures.notebook import worst_reversal

        if outcome is None or outcome.simulation is None or not has_completed(outcome.simulation):
            return found.plot()
        return worst_reversal(outcome.simulation, None if following is None else following.error)

    verdict = Markup('<p><span class="pill {}">{}</span><strong>{}</strong> <span class="soft">{}</span></p>')
    listed = Markup("<ul>{}</ul>").format(Markup("").join(Markup("<li>{}</li>").format(text) for text in warned)) if warned else ""
    heads = Markup('<p class="warned">Warnings</p>{}').format(listed) if warned else ""
    table = Markup('<details><summary>All parameters</summary>{}</details><p class="soft">{}: <code>.report("report.html")</code></p>')
    return [
        verdict.format(ruling.level, ruling.words, fit.name, "; ".join(ruling.reasons)),
        Markup('<div class="numbers">{}</div>').format(Markup("").join(map(_card_of, numbers_of(fit)))),
        *(Markup('<p class="{}">{}</p>').format(line.level or "soft", capital(line.text)) for line in gain),
        _picture(draw, f"Following error or effort of {fit.name}", repr(found)),
        heads,
        table.format(Markup(found._card().html()), "Report"),
    ]


class Number(NamedTuple):
    """A number of an identification with its interval; `spans` are values with their ends, for bars."""

    label: str
    text: str
    interval: str
    spans: tuple[tuple[float, tuple[float, float] | None], ...] = ()


def numbers_of(fit: Fit) -> list[Number]:
    """Return mass, friction level, pre-sliding distance and held-out error, each with its interval."""
    kind, levels = fit.plant.kind, level_values(fit)
    cards = [] if fit.inertia is None else [_of_estimates("Inertia" if kind == "rotational" else "Mass", "", [fit.inertia])]
    if levels is not None:
        sides = [None if level is None else fixed(level, unit_of("force", kind)) for level in (levels.forward, levels.backward)]
        text = " / ".join(side or "unknown" for side in sides)
        cards.append(_of_estimates("Friction, forward / backward", text, [one for one in fit.estimates if one.name in fit.levels]))
    cards.append(_presliding(fit))
    if fit.held_out is not None:
        errors = fit.held_out.block_errors_percent
        span = interval_text(percent_text(min(errors)), percent_text(max(errors)))
        cards.append(Number("Model error, held out", percent_text(fit.held_out.mean_percent), f"{span}, {fit.held_out.of}"))
    return cards


def _of_estimates(label: str, text: str, estimates: Sequence[Estimate]) -> Number:
    """Return the card of estimates: the value of the first unless there is a text, and the interval of each."""
    intervals, values = [], []
    for one in estimates:
        scale, known = scale_of(one.unit, one.value), one.status == "identified" and one.ends is not None
        half = 0.5 * scale.factor * (one.ends[1] - one.ends[0]) if known and one.ends is not None else None
        low, high = (number(end * scale.factor, half) for end in one.ends or (np.nan, np.nan))
        values.append(f"{number(one.value * scale.factor, half)} {scale.unit}")
        span = f"{interval_text(low, high)} {scale.unit}" if known else "given" if one.status == "held" else "not identified"
        intervals.append(f"{one.name}: {span}" if text else span)
    spans = tuple((one.value, one.ends if one.status == "identified" else None) for one in estimates if one.status != "held")
    return Number(label, text or values[0], "; ".join(intervals), spans)


def _presliding(fit: Fit) -> Number:
    """Return the distance over which friction builds up after a reversal, with its interval from the replicates."""
    fastest, kind, label = float(np.max(np.abs(fit.traces.velocity))), fit.friction.kind, "Pre-sliding distance"
    distance = reversal_distance(fit.friction, fastest)
    if not distance:
        return Number(label, "–", "the model has no pre-sliding")
    drawn = {} if fit.resampling is None else {n: v for n, v in fit.resampling.bands.draws.items() if n in fit.friction.values}
    several = []
    for values in zip(*drawn.values(), strict=True):
        try:
            several.append(reversal_distance(fit.friction.with_values(**dict(zip(drawn, values, strict=True))), fastest))
        except InputError:  # outside of its range
            continue
    if not several:
        return Number(label, length_text(distance, kind), "no interval without replicates", ((distance, None),))
    low, high = np.percentile(several, [2.5, 97.5]).tolist()
    interval = interval_text(length_text(low, kind), length_text(high, kind))
    return Number(label, length_text(distance, kind), interval, ((distance, (low, high)),))


def _card_of(card: Number) -> Markup:
    bars = Markup("")
    for value, ends in card.spans:
        bar = Markup("")
        if ends is not None and value:
            places = np.clip(50.0 + 50.0 / BAR * (np.array(ends) / value - 1.0), 0.0, 100.0)
            bar = Markup('<i style="left:{:.1f}%;width:{:.1f}%"></i>').format(places.min(), np.ptp(places))
        bars += Markup('<span class="bar{}">{}</span>').format("" if bar else " open", bar)
    return Markup("<div><small>{}</small><strong>{}</strong>{}<small>{}</small></div>").format(card.label, card.text, bars, card.interval)


def _ruling(found: Any) -> Ruling:
    """Return the saved verdict."""
    verdict = found.summary["verdict"]
    return Ruling(verdict["level"], LEVELS[verdict["level"]], tuple(verdict["reasons"]))


def _gain(lines: Iterable[Line]) -> list[Line]:
    """Return the lines on the gain."""
    label, chosen = "", []
    for line in lines:
        label = line.label or label
        chosen += [line] if label == "Gain" else []
    return chosen
