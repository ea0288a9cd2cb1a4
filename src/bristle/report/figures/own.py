"""A user-defined figure: one Python file, without changes to the package."""

import copy
import os
import re
import sys
from collections.abc import Sequence

from matplotlib.figure import Figure

from bristle.core import InputError, Readable
from bristle.files import code_at, declared_in
from bristle.report.figures import style
from bristle.report.figures.on_reports import names_on_reports
from bristle.report.figures.report_figure import FACTS, Facts, ReportFigure

NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")
MEND = (
    'End the file with FIGURE = ReportFigure(name="my_figure", title="...", caption="...", alternative="...", '
    'takes="identification", draw=draw)'
)
RESULTS = tuple(dict.fromkeys(name for names in FACTS.values() for name in names))


def load_figure_file(path: Readable) -> ReportFigure:
    """Return the figure that a Python file defines as ``FIGURE``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file with ``FIGURE = ReportFigure(...)``, from `bristle.report.figures`. It is executed.

    Returns
    -------
    ReportFigure
        The figure.

    Raises
    ------
    InputError
        If the file cannot be read or run, defines no figure, or its figure lacks a name, inputs or texts.
    """
    content = code_at(path)
    figure, source = (
        declared_in(content, "FIGURE", ReportFigure, title="figure", mend=MEND),
        str(content.source),
    )
    if (
        not isinstance(figure.name, str)
        or not NAME.fullmatch(figure.name)
        or figure.name in names_on_reports()
    ):
        raise InputError(
            "has a figure with an invalid name",
            path=source,
            value=figure.name,
            allowed="lower-case letters, digits and _, a letter first, not the name of a figure of bristle",
        )
    for part in ("title", "caption", "alternative"):
        text = getattr(figure, part)
        if not isinstance(text, str) or not text.strip():
            raise InputError(f"its figure has no {part}", path=source, mend=f'Write {part}="..."')
    if not callable(figure.draw):
        raise InputError(
            "its figure has no function `draw`", path=source, value=figure.draw, mend=MEND
        )
    unknown = [str(name) for name in figure.needs if name not in RESULTS]
    if unknown or not figure.needs:
        raise InputError(
            "its figure takes results that no report has",
            path=source,
            value=", ".join(unknown),
            allowed=", ".join(RESULTS),
            mend='Write takes="identification", for example',
        )
    return figure


def refuse_unfit(
    figure: ReportFigure, command: str, figures: Sequence[ReportFigure], path: str
) -> None:
    """Refuse a figure that a report can never have."""
    strange = [name for name in figure.needs if name not in FACTS[command]]
    if strange:
        able = [
            f"bristle {name}" for name, facts in FACTS.items() if set(figure.needs) <= set(facts)
        ]
        raise InputError(
            f"its figure takes results that the report of {command} lacks",
            path=path,
            value=", ".join(strange),
            allowed=", ".join(FACTS[command]),
            mend=f"Use the figure with {' or '.join(able)}" if able else "",
        )
    if [candidate.name for candidate in figures].count(figure.name) > 1:
        raise InputError(
            "another figure has the same name",
            path=path,
            value=figure.name,
            mend="Write another name",
        )


def figures_named(
    figures: Sequence[ReportFigure | str | os.PathLike[str]], command: str
) -> tuple[ReportFigure, ...]:
    """Return figures for the report of a command; for files, the figures that they define."""
    loaded = [
        figure if isinstance(figure, ReportFigure) else load_figure_file(figure)
        for figure in figures
    ]
    for figure in loaded:
        refuse_unfit(figure, command, loaded, figure.name)
    return tuple(loaded)


@style.styled
def draw_own(figure: ReportFigure, facts: Facts) -> Figure:
    """Return a user-defined figure, drawn from copies of the results in the style of the others."""
    drawing = figure.draw(*copy.deepcopy(figure.arguments(facts)))
    if not isinstance(drawing, Figure):
        raise InputError(
            f"returned a {type(drawing).__name__}, not a Figure",
            path=figure.name,
            mend="Return the figure that bristle.report.figures.style.panels made",
        )
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close(drawing)  # otherwise it would keep the figure for ever
    return drawing
