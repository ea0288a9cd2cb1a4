"""The text of figures: what a person wrote, made fit for a page, measured, shortened, and set in fonts of matplotlib's own.

A page is read with the fonts of its reader; the room for a text is measured with these, the same everywhere.
"""

import re
import unicodedata
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.font_manager import FontProperties, get_font
from matplotlib.textpath import TextToPath

from bristle.core.typography import escaped

FOLDER = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
REGULAR = FOLDER / "DejaVuSans.ttf"
FILES = {
    (False, False): REGULAR,
    (True, False): FOLDER / "DejaVuSans-Bold.ttf",
    (False, True): FOLDER / "DejaVuSans-Oblique.ttf",
    (True, True): FOLDER / "DejaVuSans-BoldOblique.ttf",
}
BOLD = {"semibold", "demibold", "demi", "bold", "heavy", "extra bold", "black"}
WIDE = "W"  # about as wide as high, like most letters that these fonts lack: ideographs, emoji
LETTERS = 8.5  # points
LONGEST_READ = 400  # letters: more than fit anywhere
CUT = "…"

# What XML and HTML forbid: control characters but tab and line break, halves of pairs, what is no character; and what
# turns around the text behind it.
_UNFIT = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\u202a-\u202e\u2066-\u2069"
    + "".join(f"{chr(plane + 0xFFFE)}{chr(plane + 0xFFFF)}" for plane in range(0, 0x110000, 0x10000))
    + "]"
)
# Hebrew, Arabic and their like: what stands behind their last letter would be read to the left of them.
_RIGHT_TO_LEFT = "\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc"
FROM_LEFT_ON = "\u200e"
_LAST_OF_THEM = re.compile(f"([{_RIGHT_TO_LEFT}])(?!{FROM_LEFT_ON})(?=[^{_RIGHT_TO_LEFT}]*$)")


def printable(text: str) -> str:
    r"""Return a text with a mark in place of each character that a page must not hold.

    Examples
    --------
    >>> printable("a\x00b\ud800c")
    'a�b�c'
    """
    return _UNFIT.sub("\ufffd", escaped(text))


def one_line(text: str) -> str:
    r"""Return a name as one line; a dash for one without letters.

    Examples
    --------
    >>> one_line("left\n  arm\x07"), one_line(" ")
    ('left arm�', '–')
    """
    return _LAST_OF_THEM.sub(rf"\1{FROM_LEFT_ON}", printable(" ".join(text.split()))) or "–"


class Lettering:
    """A renderer whose text is measured and drawn in these fonts; in all else the one that it is made from."""

    def __init__(self, renderer: Any) -> None:
        vars(self)["renderer"] = renderer

    def __getattr__(self, name: str) -> Any:
        return getattr(vars(self)["renderer"], name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self.renderer, name, value)

    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> Any:
        """Return the size of a text."""
        own, font = _own(prop)
        return self.renderer.get_text_width_height_descent(_drawable(printable(s), font), own, ismath)

    def draw_text(
        self, gc: Any, x: float, y: float, s: str, prop: FontProperties, angle: float, ismath: Any = False, mtext: Any = None
    ) -> None:
        """Draw a text, without the characters that a page must not hold."""
        self.renderer.draw_text(gc, x, y, printable(s), _own(prop)[0], angle, ismath=ismath, mtext=mtext)

    def _get_font_height_metrics(self, prop: FontProperties) -> tuple[float, float, float]:
        """Return ascent, descent and gap of lines: newer releases of matplotlib ask, and look for a font otherwise."""
        font = get_font(_own(prop)[1])
        table: Any = font.get_sfnt_table("OS/2")
        scale = self.points_to_pixels(prop.get_size_in_points()) / font.units_per_EM
        return table["sTypoAscender"] * scale, -table["sTypoDescender"] * scale, table["sTypoLineGap"] * scale


def width(text: str, size: float) -> float:
    """Return how wide a line of text is [inch], its letters `size` points high."""
    font = FontProperties(fname=REGULAR, size=size)
    return TextToPath().get_text_width_height_descent(_drawable(text, REGULAR), font, False)[0] / 72.0  # points in an inch


def _own(prop: FontProperties) -> tuple[FontProperties, Path]:
    """Return the same lettering in one of these fonts, and the font; what a page is told of it stays."""
    weight, own = prop.get_weight(), prop.copy()
    bold = weight >= 600 if isinstance(weight, int) else weight in BOLD
    font = FILES[bold, prop.get_style() != "normal"]
    own.set_file(font)
    return own, font


def _drawable(text: str, font: Path) -> str:
    """Return what is as wide as a text in letters that a font has: it is only measured, and nobody is warned of it."""
    has = _letters(font)
    if text.isascii() or has.issuperset(text):
        return text
    return "".join(
        letter if letter in has else WIDE for letter in text if letter in has or unicodedata.category(letter) not in {"Mn", "Me", "Cf"}
    )


@cache
def _letters(font: Path) -> frozenset[str]:
    return frozenset(map(chr, get_font(font).get_charmap()))


def shortened(name: str, available: float, size: float = LETTERS) -> str:
    """Return a name as one line, without its middle where it is too long: names differ at their beginnings and ends."""
    text = one_line(name[:LONGEST_READ] + name[-LONGEST_READ:] if len(name) > 2 * LONGEST_READ else name)
    if width(text, size) <= available:
        return text
    fits, too_many = 1, len(text)
    while too_many - fits > 1:
        count = (fits + too_many) // 2
        if width(_without_middle(text, count), size) <= available:
            fits = count
        else:
            too_many = count
    return _without_middle(text, fits)


def _without_middle(text: str, count: int) -> str:
    """Return the first and the last letters of a text, `count` in all."""
    tail = count // 2
    return f"{text[: count - tail].rstrip()}{CUT}{text[len(text) - tail :].lstrip()}"


def shortened_apart(names: Sequence[str], available: float, size: float = LETTERS) -> list[str]:
    """Return names shortened, with a number behind those that would read like one before them."""
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
    """Return a name for a legend, which hides those that begin with an underscore."""
    text = one_line(name)
    return f"‘{text}’" if text.startswith("_") else text
