"""A figure as SVG to be put inside a page: no reference to the outside, no date, no identifier twice."""

from __future__ import annotations

import io
import re
from html import escape

import matplotlib
from matplotlib.figure import Figure

from bristle.figures.style import RC

__all__ = ["inline_svg"]

_BODY = re.compile(r"<svg\b.*</svg>", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_OPENING = re.compile(r"<svg\b[^>]*>")
_VIEW_BOX = re.compile(r'viewBox="([^"]*)"')
_REFERENCE = re.compile(r'(?:xlink:href="#|url\(#)([^")]+)')
_GROUP_ID = re.compile(r'<g id="([^"]*)"')
_PATH = re.compile(r'(?<= )d="[^"]*"')
_DECIMALS = re.compile(r"(\.\d\d)\d+")
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


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
    with matplotlib.rc_context(RC):
        figure.savefig(out, format="svg", metadata=_NO_METADATA)
    text = _BODY.search(out.getvalue())[0]  # type: ignore[index]
    text = _METADATA.sub("", text, count=1)
    # A hundredth of a point is finer than any printer; text between the tags is left alone.
    text = _PATH.sub(lambda d: _DECIMALS.sub(r"\1", d[0]), text)
    text = _with_own_ids(text, name)
    box = _VIEW_BOX.search(text)[1]  # type: ignore[index]
    opening = f'<svg viewBox="{box}" role="img" aria-label="{escape(description)}">'
    return _OPENING.sub(lambda _: opening, text, count=1)


def _with_own_ids(text: str, name: str) -> str:
    """Return the text with `name` before each identifier that is used, and without those that are not."""
    used = set(_REFERENCE.findall(text))
    text = _GROUP_ID.sub(lambda found: found[0] if found[1] in used else "<g", text)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = text.replace('xlink:href="#', f'href="#{name}-')
    return text.replace("url(#", f"url(#{name}-")
