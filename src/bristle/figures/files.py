"""A figure as a file to be published, and as SVG inside a page: text stays text, no date, the same bytes each time."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from bristle.core.errors import InputWarning
from bristle.figures.drawing import own_settings
from bristle.figures.lettering import printable

DPI = 300
LARGEST_PNG = 40e6  # pixels: beyond, programs that show or print it run out of memory
TEXT: Any = {"svg.fonttype": "none", "pdf.fonttype": 42}
DATELESS: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": "bristle"},
    "pdf": {"CreationDate": None, "Creator": "bristle"},
    "png": {"Software": "bristle"},
}
_BODY = re.compile(r"<svg\b.*</svg>", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_OPENING = re.compile(r"<svg\b[^>]*>")
# What a person wrote stands between the tags; inside of them matplotlib writes an entity for each ">".
_TAG = re.compile(r"<[^>]*>")
# Before 3.10 matplotlib calls the clip of a panel that is no rectangle by its place in memory.
_CURVED_CLIP = re.compile(r'<clipPath id="([^"]*)">\s*<path')
_VIEW_BOX = re.compile(r'viewBox="([^"]*)"')
_REFERENCE = re.compile(r'(?:xlink:href="#|url\(#)([^")]+)')
_GROUP_ID = re.compile(r'<g id="([^"]*)"')
_PATH = re.compile(r'(?<= )d="[^"]*"')
_DECIMALS = re.compile(r"(\.\d\d)\d+")
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def figure_file(figure: Figure, form: str, title: str) -> bytes:
    """Return a figure as the content of a file.

    Parameters
    ----------
    figure : Figure
        What to draw: 183 mm wide, two columns of most journals.
    form : {"svg", "pdf", "png"}
        ``svg`` with text as text; ``pdf`` with its fonts, whole letters and no outlines; ``png`` with 300 dots an inch.
    title : str
        What the file says that it shows.

    Returns
    -------
    bytes
        The same ones for the same figure.
    """
    out = io.BytesIO()
    metadata = DATELESS[form] | ({} if form == "png" else {"Title": printable(" ".join(title.split()))})
    with own_settings(), matplotlib.rc_context(TEXT), _one_remark_on_letters():
        figure.savefig(out, format=form, dpi=DPI, facecolor="white", metadata=metadata)
    return out.getvalue()


def fits_as_png(figure: Figure) -> bool:
    """Return whether a figure has few enough pixels: one of very many variants would have more than can be shown."""
    wide, high = figure.get_size_inches()
    return float(wide * high) * DPI**2 <= LARGEST_PNG


@contextmanager
def _one_remark_on_letters() -> Iterator[None]:
    """Warn once of letters that the embedded fonts lack, whatever else is warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield
    distinct = {str(warning.message): warning for warning in caught}
    lacking = [text for text in distinct if "missing from" in text]
    for text, warning in distinct.items():
        if text not in lacking:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if lacking:
        warnings.warn(
            "letters of a name are not in the fonts of the figures and stand as boxes in pdf and png; svg has them",
            InputWarning,
            stacklevel=2,
        )


def inline_svg(figure: Figure, name: str, description: str) -> str:
    """Return a figure as an ``<svg>`` element.

    Parameters
    ----------
    figure : Figure
        What to draw.
    name : str
        Goes before each identifier: letters, digits and hyphens, another one for each figure of a page.
    description : str
        What a person who cannot see the figure is told.

    Returns
    -------
    str
        The element; the same bytes for the same figure.
    """
    out = io.StringIO()
    # Text stays text, to be searched, copied and read aloud.
    with own_settings(), matplotlib.rc_context({"svg.fonttype": "none"}):
        figure.savefig(out, format="svg", metadata=_NO_METADATA)
    text = _BODY.search(out.getvalue())[0]  # type: ignore[index]
    text = _METADATA.sub("", text, count=1)
    for number, identifier in enumerate(_CURVED_CLIP.findall(text), 1):
        text = text.replace(identifier, f"clip-{number}")
    used = {reference for tag in _TAG.findall(text) for reference in _REFERENCE.findall(tag)}
    text = _TAG.sub(lambda tag: _with_own_ids(_rounded(tag[0]), name, used), text)
    box = _VIEW_BOX.search(text)[1]  # type: ignore[index]
    label = escape(printable(" ".join(description.split())))
    opening = f'<svg viewBox="{box}" role="img" aria-label="{label}">'
    return _OPENING.sub(lambda _: opening, text, count=1)


def _rounded(tag: str) -> str:
    """Return a tag with the corners of its path to a hundredth of a point, which is finer than any printer."""
    return _PATH.sub(lambda d: _DECIMALS.sub(r"\1", d[0]), tag)


def _with_own_ids(tag: str, name: str, used: set[str]) -> str:
    """Return a tag with `name` before its identifiers, and without that of a group that nothing refers to."""
    tag = _GROUP_ID.sub(lambda match: match[0] if match[1] in used else "<g", tag)
    tag = re.sub(r'\bid="', f'id="{name}-', tag)
    return tag.replace('xlink:href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")
