"""A figure as a file to be published: lettering that stays text, on white, as wide as the columns of a journal."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from bristle.core.errors import InputWarning
from bristle.figures.plain import printable
from bristle.figures.settings import own_settings

__all__ = ["figure_file", "fits_as_png"]

DPI = 300
LARGEST_PNG = 40e6  # pixels: beyond, programs that show or print it run out of memory
TEXT: Any = {"svg.fonttype": "none", "pdf.fonttype": 42}
DATELESS: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": "bristle"},
    "pdf": {"CreationDate": None, "Creator": "bristle"},
    "png": {"Software": "bristle"},
}


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
