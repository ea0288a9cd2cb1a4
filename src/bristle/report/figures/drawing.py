"""Settings of matplotlib to make, draw and save a figure, independent of those of its user, and its texts.

The settings are global to the process. One thread at a time has them; other threads that draw at that moment would see them. Text is
cleaned for a page, measured and shortened. A reader's fonts may differ; the room for a text is measured with these fonts.
"""

import os
import re
import threading
import unicodedata
import warnings
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.font_manager import FontProperties, get_font
from matplotlib.textpath import TextToPath

from bristle.core import escaped
from bristle.core.palette import LIGHT

REGULAR = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
WIDE = "W"  # about as wide as high, like most letters that these fonts lack: ideographs, emoji
LETTERS = 8.5  # points
LONGEST_READ = 400  # letters: more than any figure has room for
CUT = "…"

# Forbidden in XML and HTML: control characters except tab and line break, halves of pairs, codes that are not characters; and
# marks that reverse the text after them.
_UNFIT = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\u202a-\u202e\u2066-\u2069"
    + "".join(
        f"{chr(plane + 0xFFFE)}{chr(plane + 0xFFFF)}" for plane in range(0, 0x110000, 0x10000)
    )
    + "]"
)
# Hebrew, Arabic and similar scripts: text after their last letter would be read to the left of them.
_RIGHT_TO_LEFT = "\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc"
FROM_LEFT_ON = "\u200e"
_LAST_OF_THEM = re.compile(f"([{_RIGHT_TO_LEFT}])(?!{FROM_LEFT_ON})(?=[^{_RIGHT_TO_LEFT}]*$)")


def printable(text: str) -> str:
    r"""Return a text with a mark in place of each character forbidden in a page.

    Examples
    --------
    >>> printable("a\x00b\ud800c")
    'a�b�c'
    """
    return _UNFIT.sub("\ufffd", escaped(text))


def one_line(text: str) -> str:
    r"""Return a name as one line; a dash for a name without letters.

    Examples
    --------
    >>> one_line("left\n  arm\x07"), one_line(" ")
    ('left arm�', '–')
    """
    return _LAST_OF_THEM.sub(rf"\1{FROM_LEFT_ON}", printable(" ".join(text.split()))) or "–"


def width(text: str, size: float) -> float:
    """Return the width of a line of text [inch], with letters of `size` points."""
    font = FontProperties(fname=REGULAR, size=size)
    # Points in an inch.
    return TextToPath().get_text_width_height_descent(_drawable(text), font, False)[0] / 72.0


def _drawable(text: str) -> str:
    """Return a text of the same width in letters of the font: it is only measured, without warnings."""
    has = _letters()
    if text.isascii() or has.issuperset(text):
        return text
    return "".join(
        letter if letter in has else WIDE
        for letter in text
        if letter in has or unicodedata.category(letter) not in {"Mn", "Me", "Cf"}
    )


@cache
def _letters() -> frozenset[str]:
    return frozenset(map(chr, get_font(REGULAR).get_charmap()))


def shortened(name: str, available: float, size: float = LETTERS) -> str:
    """Return a name as one line; a long name loses its middle, because names differ at their beginnings and ends."""
    text = one_line(
        name[:LONGEST_READ] + name[-LONGEST_READ:] if len(name) > 2 * LONGEST_READ else name
    )
    if width(text, size) <= available:
        return text
    wider = bisect_right(
        range(2, len(text)), available, key=lambda count: width(_without_middle(text, count), size)
    )
    return _without_middle(text, 1 + wider)


def _without_middle(text: str, count: int) -> str:
    """Return the first and the last letters of a text, `count` in all."""
    tail = count // 2
    return f"{text[: count - tail].rstrip()}{CUT}{text[len(text) - tail :].lstrip()}"


def shortened_apart(names: Sequence[str], available: float, size: float = LETTERS) -> list[str]:
    """Return names shortened, with a number after a name that would otherwise equal an earlier name."""
    labels: dict[str, str] = {}
    for name in dict.fromkeys(names):
        text, number = shortened(name, available, size), 1
        while text in labels.values():
            number += 1
            behind = f" ({number})"
            text = shortened(name, available - width(behind, size), size) + behind
        labels[name] = text
    return [labels[name] for name in names]


def label(name: str) -> str:
    """Return a name for a legend, which hides names that begin with an underscore."""
    text = one_line(name)
    return f"‘{text}’" if text.startswith("_") else text


WIDTH = 7.2  # inches: the text width of an A4 page
AT_TICKS = 8.0  # points: numbers and names at axes
INK, GREY = LIGHT["ink"], LIGHT["ghost"]

LOOK: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": LETTERS,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "right",
    "axes.titlesize": LETTERS,
    "axes.unicode_minus": True,
    "axes.xmargin": 0.01,
    "figure.facecolor": "none",
    "font.family": "sans-serif",
    # Widest first: if a reader lacks a font, the next takes less room, so texts do not overlap.
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial", "sans-serif"],
    "font.size": LETTERS,
    "grid.color": LIGHT["rule"],
    "grid.linewidth": 0.6,
    "legend.fontsize": LETTERS,
    "lines.linewidth": 1.1,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "bristle",
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "xtick.labelsize": AT_TICKS,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
    "ytick.labelsize": AT_TICKS,
}

# The backend opens windows, which these figures never do; reading the setting would look up a backend.
BACKEND = ("backend", "backend_fallback")
OWN: Any = {
    key: value
    for key, value in dict(matplotlib.rcParamsDefault.copy()).items()
    if key not in BACKEND
} | LOOK


class _Turn:
    """The thread that draws, and the depth of its nested calls."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.depth = 0


_turn = _Turn()
if hasattr(os, "register_at_fork"):
    # A child forked while another thread draws would keep these settings for ever.
    os.register_at_fork(
        before=_turn.lock.acquire,
        after_in_parent=_turn.lock.release,
        after_in_child=_turn.lock.release,
    )


@contextmanager
def own_settings() -> Iterator[None]:
    """Draw with these settings, then restore the previous ones. Nested use has no effect."""
    with _turn.lock:
        _turn.depth += 1
        try:
            if _turn.depth > 1:
                yield
            else:
                with matplotlib.rc_context(OWN), warnings.catch_warnings():
                    # A page is read with the fonts of its reader.
                    warnings.filterwarnings("ignore", "Glyph .* missing from")
                    yield
        finally:
            _turn.depth -= 1
