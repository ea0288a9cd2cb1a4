"""What a series of a figure is called, though only one panel has a legend: readers go by looks and colours, too."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer
from matplotlib.contour import ContourSet

from bristle.figures.drawn import Drawn
from bristle.figures.settings import GREY, INK

__all__ = ["series_names"]

AIDS = {GREY, INK}  # colours of axes and aids, which tell no series
_UNNAMED = re.compile(r"_?(child\d+|nolegend_|)")


def series_names(drawn: Sequence[Drawn], figure_wide: Sequence[Drawn], y: str) -> list[str]:
    """Return what each thing of a panel is called: by its label, else by what looks like it, else by what it is."""
    names = [_label(graphic) or _called_alike(graphic, drawn, figure_wide) for graphic in drawn]
    _name_by_colour(names, drawn, figure_wide)
    words = [name or _word(graphic, drawn, y) for graphic, name in zip(drawn, names, strict=True)]
    unnamed = [word for word, name in zip(words, names, strict=True) if not name]
    counts: dict[str, int] = {}
    for index, word in enumerate(words):
        if not names[index] and unnamed.count(word) > 1:
            counts[word] = counts.get(word, 0) + 1
            words[index] = f"{word} {counts[word]}"
    return words


def _label(graphic: Drawn) -> str:
    """Return what a legend calls it; nothing where it does not."""
    label = str(graphic.artist.get_label())
    return "" if label.startswith("_") else label


def _hint(graphic: Drawn) -> str:
    """Return the label that legends leave out."""
    label = str(graphic.artist.get_label())
    return "" if _UNNAMED.fullmatch(label) else label[1:]


def _called_alike(graphic: Drawn, panel: Sequence[Drawn], figure_wide: Sequence[Drawn]) -> str:
    """Return the label of what looks the same, in the panel to the mark, elsewhere but for marks and aids."""
    for candidate in panel:
        if _label(candidate) and candidate.mark == graphic.mark and _look(candidate) == _look(graphic):
            return _label(candidate)
    for candidate in figure_wide:
        if _label(candidate) and _colour(graphic.artist) not in AIDS and _look(candidate)[:-1] == _look(graphic)[:-1]:
            return _label(candidate)
    return ""


def _name_by_colour(names: list[str], drawn: Sequence[Drawn], figure_wide: Sequence[Drawn]) -> None:
    """Name what has the colour of something named in the panel; or, where several have, in the figure."""
    by_colour = {_colour(graphic.artist): name for graphic, name in zip(drawn, names, strict=True) if name}
    figure = {_colour(graphic.artist): _label(graphic) for graphic in figure_wide if _label(graphic)}
    rest = {_colour(graphic.artist) for graphic, name in zip(drawn, names, strict=True) if not name} - by_colour.keys() - AIDS
    # A colour alone, of a panel with one thing in it, is a colour and no name.
    by_colour |= {colour: figure[colour] for colour in rest} if len(rest) > 1 and rest <= figure.keys() else {}
    for index, graphic in enumerate(drawn):
        if not names[index]:
            name = "" if _colour(graphic.artist) in AIDS else by_colour.get(_colour(graphic.artist), "")
            names[index] = ", ".join(filter(None, (name, _hint(graphic))))


def _word(graphic: Drawn, panel: Sequence[Drawn], y: str) -> str:
    """Return what it is: what the axis says of the only line or points of a panel, else how it is drawn."""
    alike = [candidate for candidate in panel if candidate.mark == graphic.mark and _colour(candidate.artist) != GREY]
    return y.partition(" [")[0] if graphic.mark in ("line", "points") and alike == [graphic] else graphic.mark


def _look(graphic: Drawn) -> tuple[Any, ...]:
    parts = (getattr(graphic.artist, f"get_{name}", None) for name in ("linestyle", "linewidth", "marker"))
    return _colour(graphic.artist), *(str(part()) if part else "" for part in parts)


def _colour(artist: Any) -> str:
    """Return the colour that tells what it is."""
    if isinstance(artist, BarContainer):
        return _colour(artist[0]) if len(artist) else ""
    if hasattr(artist, "get_color") and not isinstance(artist, ContourSet):
        colour = artist.get_color()
    elif getattr(artist, "fill", False) or not hasattr(artist, "get_edgecolor"):
        colour = getattr(artist, "get_facecolor", lambda: "none")()
    else:
        colour = artist.get_edgecolor()
    rows = np.atleast_2d(np.asarray(colour, dtype=object))
    if not rows.size:
        return ""
    return to_hex(colour if isinstance(colour, str) else rows[0].tolist() if rows.shape[1] > 1 else rows[0][0])
