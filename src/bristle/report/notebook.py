"""A model and an identification in a notebook: HTML with equations, numbers and a picture, and a widget where Python runs."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from markupsafe import Markup

from bristle.core import Card, InputError, Model, scale_of
from bristle.core.palette import notebook_style
from bristle.prediction import reversal_distance
from bristle.report.apps import part
from bristle.report.assets import joined
from bristle.report.table import capital


def as_html(result: Any) -> str:
    """Return a model or an identification as HTML with its own style."""
    return f'<div class="bristle"><style>{notebook_style()}{joined(("card.css",), "bristle.report")}</style>{"".join(_parts(result))}</div>'


def bundle(result: Any, include: Any = None, exclude: Any = None) -> dict[str, Any]:
    """Return what a notebook stores: text, HTML and, where Python runs, the widget; only text in a terminal."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None and not hasattr(shell, "kernel"):
        return {"text/plain": repr(result)}
    return {"text/plain": repr(result), "text/html": as_html(result)} | (
        {} if shell is None else _live(result)
    )


def _live(result: Any) -> dict[str, Any]:
    """Return the view of a widget with sliders in place of the table; empty if it cannot be made."""
    try:
        widget = part("widget")(result) if isinstance(result, Model) else result.widget()
    except (ImportError, InputError):  # without anywidget, or no page can compute the model
        return {}
    widget._card = "".join(_parts(result)[:-1])
    view = "application/vnd.jupyter.widget-view+json"
    return {view: (widget._repr_mimebundle_() or [{}])[0].get(view, {})}


def _parts(result: Any) -> list[str]:
    """Return the HTML of its parts, last the parameters."""
    return _of_model(result) if isinstance(result, Model) else _of_identification(result)


def _of_model(model: Model) -> list[str]:
    """Return name, description, equations, and parameters beside a picture of the loops of friction."""
    component, unit = (
        model.component,
        {name: variable.unit(model.kind) for name, variable in model.component.variables.items()},
    )
    try:
        from latex2mathml.converter import convert

        equations = [Markup(convert(equation)) for equation in component.latex]
    except Exception:  # noqa: BLE001  (not installed, or other LaTeX in the docstring of a user)
        equations = [Markup("<div>{}</div>").format(line) for line in component.equations]
    head = Markup(
        '<p><strong>{}</strong> <span class="soft">{}, {}</span></p><p>{}.</p><div class="equations">{}</div>'
    )
    rows = [
        (name, _value(value, unit[name]), component.variables[name].description)
        for name, value in model.values.items()
    ]

    def draw() -> Any:
        from bristle.report.figures.small_multiples import loops_of

        return loops_of(model, reversal_distance(model, 0.1))

    picture = (
        _picture(draw, f"Force over position of {model.name}")
        if component.family == "friction"
        else ""
    )
    return [
        head.format(
            model.name,
            component.family,
            model.kind,
            capital(component.description),
            Markup("").join(equations),
        ),
        picture + Card("", ("Parameter", "Value", "Meaning"), tuple(rows)).html(),
    ]


def _value(value: Any, unit: str) -> str:
    """Return a parameter in a readable unit."""
    if isinstance(value, str):
        return value
    scale = scale_of(unit, float(np.max(np.abs(value), initial=0.0)))
    return f"{', '.join(f'{item:.6g}' for item in np.atleast_1d(value) * scale.factor)} {scale.unit}".replace(
        "inf", "∞"
    ).rstrip()


def _picture(draw: Callable[[], Any], description: str) -> str:
    """Return a figure in the colours of the notebook; empty without matplotlib."""
    try:
        from bristle.report.figures.files import notebook_svg

        return f'<div class="picture">{notebook_svg(draw(), description)}</div>'
    except (ImportError, InputError):
        return ""


def _of_identification(identified: Any) -> list[str]:
    """Return verdict, numbers, gain, picture, warnings, and the table of all parameters."""
    from bristle.report.brief import brief  # with matplotlib, which a model does without
    from bristle.report.cards import cards_of
    from bristle.report.compensation import gain_of
    from bristle.report.judgement import LEVELS, feedforward_of, ruling_of
    from bristle.report.messages import terms_in, warnings_of
    from bristle.report.page import Ruling, macro, worded

    fit, outcome, lines = identified.best, getattr(identified, "outcome", None), []
    if outcome is None:  # loaded
        level = identified.summary["verdict"]["level"]
        ruling = Ruling(level, LEVELS[level], tuple(identified.summary["verdict"]["reasons"]))
    else:
        ruling = ruling_of(identified, outcome.following)
        lines = brief(identified, outcome.simulation, outcome.following, identified.axis)[:-2]
    gain = lines[
        next((place for place, line in enumerate(lines) if line.label == "Gain"), len(lines)) :
    ]

    cards = cards_of(fit, identified.axis, usable=ruling.level != "measure_again")

    def draw() -> Any:
        from bristle.report.figures import gain_at_reversal

        simulation = None if outcome is None else outcome.simulation
        gained = None if simulation is None else gain_of(simulation)
        if simulation is None or gained is None or not gained.steps:
            return identified.plot()
        return gain_at_reversal(simulation, [step.name for step in gained.steps[-2:]])

    verdict = Markup(
        '<p><span class="pill {}">{}</span> <strong>{}</strong> <span class="soft">{}</span></p>'
    )
    facts = (f"Feedforward: {feedforward_of(identified)}", terms_in(fit))
    warned = [Markup("<li>{}</li>").format(warning) for warning in warnings_of(fit)]
    return [
        verdict.format(ruling.level, ruling.words, fit.name, "; ".join(ruling.reasons)),
        *(Markup("<p>{}</p>").format(worded(fact)) for fact in facts if fact),
        f'<div class="cards">{"".join(macro("card")(card, None) for card in cards)}</div>',
        *(
            Markup('<p class="{}">{}</p>').format(line.level or "soft", capital(line.text))
            for line in gain
        ),
        _picture(draw, f"Following error or effort of {fit.name}"),
        f'<strong class="warned">Warnings</strong><ul>{"".join(warned)}</ul>' if warned else "",
        '<p class="soft">Report: <code>.report("report.html")</code></p>',
        f"<details><summary>All parameters</summary>{identified._card().html()}</details>",
    ]
