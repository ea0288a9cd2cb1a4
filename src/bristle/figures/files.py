"""A figure as a file for publication, and as SVG inside a page: text stays text, no date, the same bytes each time."""

import io
import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from bristle.core import InputWarning
from bristle.figures.drawing import own_settings, printable

DPI = 300
MOST_PIXELS = 40e6  # of a png: larger images exhaust the memory of viewers and printers
TEXT: Any = {"svg.fonttype": "none", "pdf.fonttype": 42}
DATELESS: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": "bristle"},
    "pdf": {"CreationDate": None, "Creator": "bristle"},
    "png": {"Software": "bristle"},
}
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
    out = io.BytesIO()
    metadata = DATELESS[form] | ({} if form == "png" else {"Title": printable(" ".join(title.split()))})
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
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if lacking:
        warnings.warn(
            "letters of a name are not in the fonts of the figures and appear as boxes in pdf and png; use svg",
            InputWarning,
            stacklevel=4,  # the caller
        )


def inline_svg(figure: Figure, name: str, description: str) -> str:
    """Return a figure as an ``<svg>`` element.

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
    with own_settings(), matplotlib.rc_context({"svg.fonttype": "none"}):
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = re.search(r"<svg\b.*</svg>", printable(out.getvalue()), flags=re.DOTALL)[0]  # type: ignore[index]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, count=1, flags=re.DOTALL)
    # Before 3.10 matplotlib names the clip of a panel that is not a rectangle by its address in memory.
    for number, identifier in enumerate(re.findall(r'<clipPath id="([^"]*)">\s*<path', text), 1):
        text = text.replace(identifier, f"clip-{number}")
    used = {reference for tag in _TAG.findall(text) for reference in re.findall(r'(?:xlink:href="#|url\(#)([^")]+)', tag)}
    text = _TAG.sub(lambda tag: _with_own_ids(_rounded(tag[0]), name, used), text)
    box = re.search(r'viewBox="([^"]*)"', text)[1]  # type: ignore[index]
    label = escape(printable(" ".join(description.split())))
    opening = f'<svg viewBox="{box}" role="img" aria-label="{label}">'
    return re.sub(r"<svg\b[^>]*>", lambda _: opening, text, count=1)


def _rounded(tag: str) -> str:
    """Return a tag with the corners of its path to a hundredth of a point, finer than any printer."""
    return re.sub(r'(?<= )d="[^"]*"', lambda d: re.sub(r"(\.\d\d)\d+", r"\1", d[0]), tag)


def _with_own_ids(tag: str, name: str, used: set[str]) -> str:
    """Return a tag with `name` before its identifiers, and without the identifier of an unused group."""
    tag = re.sub(r'<g id="([^"]*)"', lambda match: match[0] if match[1] in used else "<g", tag)
    tag = re.sub(r'\bid="', f'id="{name}-', tag)
    return tag.replace('xlink:href="#', f'href="#{name}-').replace("url(#", f"url(#{name}-")
