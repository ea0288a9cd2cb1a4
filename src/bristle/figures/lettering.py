"""The text of figures, set in the fonts that come with matplotlib, whatever others there are and whatever it says.

A page is read with the fonts of its reader; the room for a text is measured with these, the same everywhere.
"""

from __future__ import annotations

import unicodedata
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.font_manager import FontProperties, get_font
from matplotlib.textpath import TextToPath

from bristle.figures.plain import printable

__all__ = ["Lettering", "width"]

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
WITHOUT_WIDTH = {"Mn", "Me", "Cf"}
POINTS = 72.0  # in an inch


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
    return TextToPath().get_text_width_height_descent(_drawable(text, REGULAR), font, False)[0] / POINTS


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
    return "".join(character if character in has else _as_wide(character) for character in text)


def _as_wide(letter: str) -> str:
    return "" if unicodedata.category(letter) in WITHOUT_WIDTH else WIDE


@cache
def _letters(font: Path) -> frozenset[str]:
    return frozenset(map(chr, get_font(font).get_charmap()))
