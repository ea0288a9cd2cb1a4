"""A figure as SVG to be put inside a page: no reference to the outside, no date, no identifier twice."""

from __future__ import annotations

import io
import re
from html import escape

import matplotlib
from matplotlib.figure import Figure

from bristle.figures.plain import printable
from bristle.figures.settings import own_settings

__all__ = ["inline_svg"]

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
