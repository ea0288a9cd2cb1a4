"""A figure as a file for publication, and as SVG inside a page: text stays text, no date, the same bytes each time."""

import hashlib
import io
import json
import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.text import Text

from bristle.core import InputError, InputWarning
from bristle.core.palette import LIGHT, notebook_style
from bristle.report.figures.drawing import own_settings, printable

DPI = 300
MOST_PIXELS = 40e6  # of a png: larger images exhaust the memory of viewers and printers
TEXT: Any = {"svg.fonttype": "none", "pdf.fonttype": 42}
DATELESS: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": "bristle"},
    "pdf": {"CreationDate": None, "Creator": "bristle"},
    "png": {"Software": "bristle"},
}
IN_NOTEBOOK = "figure-in-a-notebook"  # prefix of identifiers, replaced with one from the content
VARIABLES = {colour: f"var(--{name})" for name, colour in LIGHT.items()}
# User text is between the tags; inside a tag matplotlib writes an entity for each ">".
_TAG = re.compile(r"<[^>]*>")


def figure_file(figure: Figure, form: str, title: str) -> bytes:
    """Return a figure as the content of a file.

    Parameters
    ----------
    figure : Figure
        The figure: 183 mm wide, two columns of most journals.
    form : {"svg", "pdf", "png"}
        ``svg`` with text as text; ``pdf`` with its fonts, whole letters and no outlines; ``png`` with 300 dots
        an inch, fewer where that is more than 40 million pixels.
    title : str
        Title in the metadata of the file.

    Returns
    -------
    bytes
        The same bytes for the same figure.
    """
    if not isinstance(figure, Figure):
        raise InputError("must be a figure of matplotlib", path="figure", value=figure)
    if not isinstance(title, str):
        raise InputError("must be text", path="title", value=title)
    if form not in DATELESS:
        raise InputError(
            "is not a valid choice", path="form", value=form, allowed=", ".join(DATELESS)
        )
    out = io.BytesIO()
    metadata = DATELESS[form] | (
        {} if form == "png" else {"Title": printable(" ".join(title.split()))}
    )
    with own_settings(), matplotlib.rc_context(TEXT), _one_remark_on_letters():
        dpi = min(DPI, math.sqrt(MOST_PIXELS / math.prod(figure.get_size_inches())))
        figure.savefig(out, format=form, dpi=dpi, facecolor="white", metadata=metadata)
    return printable(out.getvalue().decode()).encode() if form == "svg" else out.getvalue()


@contextmanager
def _one_remark_on_letters() -> Iterator[None]:
    """Warn once of letters missing from the embedded fonts; pass other warnings on."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    distinct = {str(warning.message): warning for warning in caught}
    lacking = [text for text in distinct if "missing from" in text]
    for text, warning in distinct.items():
        if text not in lacking:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    if lacking:
        warnings.warn(
            "letters of a name are not in the fonts of the figures and appear as boxes in pdf and png; use svg",
            InputWarning,
            stacklevel=4,  # the caller
        )


def inline_svg(figure: Figure, name: str, description: str) -> str:
    """Return a figure as an ``<svg>`` element, in the colours of its page, with the panels that a script reads and enlarges.

    Parameters
    ----------
    figure : Figure
        The figure.
    name : str
        Prefix of each identifier: letters, digits and hyphens, unique for each figure of a page.
    description : str
        Description for people who cannot see the figure.

    Returns
    -------
    str
        The element; the same bytes for the same figure.
    """
    out = io.StringIO()
    # Text stays text: searchable, copyable and readable by a screen reader.
    with own_settings(), matplotlib.rc_context({"svg.fonttype": "none"}), _named(figure):
        figure.savefig(
            out,
            format="svg",
            metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
        )
    text = re.search(r"<svg\b.*</svg>", printable(out.getvalue()), flags=re.DOTALL)[0]  # type: ignore[index]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, count=1, flags=re.DOTALL)
    # Before 3.10 matplotlib names the clip of a panel that is not a rectangle by its address in memory.
    for number, identifier in enumerate(re.findall(r'<clipPath id="([^"]*)">\s*<path', text), 1):
        text = text.replace(identifier, f"clip-{number}")
    used = {
        reference
        for tag in _TAG.findall(text)
        for reference in re.findall(r'(?:xlink:href="#|url\(#)([^")]+)', tag)
    }
    text = _TAG.sub(lambda tag: _with_own_ids(_rounded(tag[0]), name, used), text)
    box = re.search(r'viewBox="([^"]*)"', text)[1]  # type: ignore[index]
    label = escape(printable(" ".join(description.split())))
    panels = escape(json.dumps(_panels(figure), ensure_ascii=False, separators=(",", ":")))
    opening = f'<svg viewBox="{box}" role="img" aria-label="{label}" data-panels="{panels}">'
    return re.sub(r"<svg\b[^>]*>", lambda _: opening, text, count=1)


def notebook_svg(figure: Figure, description: str) -> str:
    """Return a figure as an element for a notebook, in the colours of its theme; light ones where a page removes styles."""
    svg = inline_svg(figure, IN_NOTEBOOK, description)
    svg = svg.replace(IN_NOTEBOOK, f"b{hashlib.sha256(svg.encode()).hexdigest()[:8]}")
    return re.sub(r"var\(--(\w+)\)", lambda match: f"var(--{match[1]},{LIGHT[match[1]]})", svg)


@contextmanager
def _named(figure: Figure) -> Iterator[None]:
    """Give panels and their lines identifiers for a script."""
    named = [(axes, f"panel-{place}") for place, axes in enumerate(figure.axes)]
    named += [
        (line, f"curve-{number}")
        for axes in figure.axes
        for number, line in enumerate(axes.get_lines())
    ]
    before = [artist.get_gid() for artist, _ in named]
    for artist, name in named:
        artist.set_gid(name)
    try:
        yield
    finally:
        for (artist, _), name in zip(named, before, strict=True):
            artist.set_gid(name)


def _panels(figure: Figure) -> list[dict[str, Any]]:
    """Return box [points from the upper left], axes and names of the lines of each panel."""
    wide, high = (72.0 * size for size in figure.get_size_inches())
    panels = []
    for axes in figure.axes:
        box = axes.get_position()
        corners = (box.x0 * wide, (1.0 - box.y1) * high, box.x1 * wide, (1.0 - box.y0) * high)
        sides = {name: _side(axis) for name, axis in (("x", axes.xaxis), ("y", axes.yaxis))}
        names = [printable(str(line.get_label())) for line in axes.get_lines()]
        panels.append({"box": [round(corner, 2) for corner in corners], **sides, "names": names})
    return panels


def _side(axis: Any) -> dict[str, Any]:
    """Return ends, scale and word of an axis of a panel."""
    ends, scale = [float(end) for end in axis.get_view_interval()], axis.get_scale()
    linear = {"linear": axis.get_transform().linthresh} if scale == "symlog" else {}
    return {"ends": ends, "scale": scale, "word": printable(axis.get_label_text()), **linear}


def _rounded(tag: str) -> str:
    """Return a tag in the colours of its page, and with the corners of its path to a hundredth of a point, finer than any printer."""
    tag = re.sub(r"#[0-9a-f]{6}\b", lambda colour: VARIABLES.get(colour[0], colour[0]), tag)
    return re.sub(r'(?<= )d="[^"]*"', lambda d: re.sub(r"(\.\d\d)\d+", r"\1", d[0]), tag)


def _with_own_ids(tag: str, name: str, used: set[str]) -> str:
    """Return a tag with `name` before its identifiers, and without the identifier of an unused group."""
    tag = re.sub(r'<g id="(panel|curve)-(\d+)"', r'<g data-\1="\2"', tag)
    tag = re.sub(r'<g id="[xy]tick_\d+"', '<g data-tick=""', tag)
    tag = re.sub(r'<g id="([^"]*)"', lambda match: match[0] if match[1] in used else "<g", tag)
    tag = re.sub(r'\bid="', f'id="{name}-', tag)
    return tag.replace('xlink:href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")


class Drawing(Figure):
    """A figure that is drawn with the settings of its creation: matplotlib reads many of them late."""

    has_room_above = False  # whether there is room for a legend above all panels

    def draw(self, renderer: Any) -> None:
        """Draw the figure, without the characters forbidden in a page."""
        with own_settings():
            for text in self.findobj(Text):
                text.set_text(printable(text.get_text()))  # type: ignore[attr-defined]
            super().draw(renderer)

    def savefig(self, fname: Any, **kwargs: Any) -> None:
        """Save the figure; see `matplotlib.figure.Figure.savefig`."""
        with own_settings():
            super().savefig(fname, **kwargs)

    def _repr_html_(self) -> str:
        """Return the figure for notebooks, light or dark as the notebook."""
        labels = ", ".join(filter(None, (axes.get_ylabel() for axes in self.axes)))
        style = f"{notebook_style()}.bristle>svg{{display:block;width:100%;max-width:{self.get_figwidth():g}in;height:auto;}}"
        return f'<div class="bristle"><style>{style}</style>{notebook_svg(self, f"Figure: {labels}")}</div>'

    def _repr_svg_(self) -> str:
        """Return the figure for notebooks."""
        file = io.StringIO()
        self.savefig(file, format="svg", bbox_inches="tight")
        return file.getvalue()
