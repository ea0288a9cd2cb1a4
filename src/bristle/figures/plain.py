"""Text that a person wrote, made fit for a page: names of columns, models, axes and files."""

from __future__ import annotations

import re

from bristle.core.typography import escaped

__all__ = ["one_line", "printable"]

# What XML and HTML forbid: control characters but tab and line break, halves of pairs, what is no character; and what
# turns around the text behind it.
_UNFIT = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\u202a-\u202e\u2066-\u2069"
    + "".join(f"{chr(plane + 0xFFFE)}{chr(plane + 0xFFFF)}" for plane in range(0, 0x110000, 0x10000))
    + "]"
)
MARK = "\ufffd"
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
    return _UNFIT.sub(MARK, escaped(text))


def one_line(text: str) -> str:
    r"""Return a name as one line; a dash for one without letters.

    Examples
    --------
    >>> one_line("left\n  arm\x07"), one_line(" ")
    ('left arm�', '–')
    """
    return _LAST_OF_THEM.sub(rf"\1{FROM_LEFT_ON}", printable(" ".join(text.split()))) or "–"
