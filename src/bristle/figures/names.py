"""Names that a person chose, where a figure has only so much room for them."""

from __future__ import annotations

from collections.abc import Sequence

from bristle.figures.lettering import width
from bristle.figures.plain import one_line

__all__ = ["LETTERS", "label", "shortened", "shortened_apart"]

LETTERS = 8.5  # points
LONGEST = 400  # letters: more than fit anywhere
CUT = "…"


def shortened(name: str, available: float, size: float = LETTERS) -> str:
    """Return a name as one line, without its middle where it is too long: names differ at their beginnings and ends."""
    text = one_line(name[:LONGEST] + name[-LONGEST:] if len(name) > 2 * LONGEST else name)
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
