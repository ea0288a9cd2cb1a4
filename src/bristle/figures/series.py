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


def series_names(drawn: Sequence[Drawn], everything: Sequence[Drawn], y: str) -> list[str]:
    """Return what each thing of a panel is called: by its label, else by what looks like it, else by what it is.

    Parameters
    ----------
    drawn : sequence of Drawn
        What is drawn in the panel.
    everything : sequence of Drawn
        What is drawn in the figure.
    y : str
        What stands at the axis of the panel.
    """
    found = [_label(one) or _called_alike(one, drawn, everything) for one in drawn]
    _name_by_colour(found, drawn, everything)
    words = [name or _word(one, drawn, y) for one, name in zip(drawn, found, strict=True)]
    unnamed = [word for word, name in zip(words, found, strict=True) if not name]
    counts: dict[str, int] = {}
    for place, word in enumerate(words):
        if not found[place] and unnamed.count(word) > 1:
            counts[word] = counts.get(word, 0) + 1
            words[place] = f"{word} {counts[word]}"
    return words


def _label(one: Drawn) -> str:
    """Return what a legend calls it; nothing where it does not."""
    label = str(one.artist.get_label())
    return "" if label.startswith("_") else label


def _hint(one: Drawn) -> str:
    """Return the label that legends leave out."""
    label = str(one.artist.get_label())
    return "" if _UNNAMED.fullmatch(label) else label[1:]


def _called_alike(one: Drawn, panel: Sequence[Drawn], everything: Sequence[Drawn]) -> str:
    """Return the label of what looks the same, in the panel to the mark, elsewhere but for marks and aids."""
    for other in panel:
        if _label(other) and other.mark == one.mark and _look(other) == _look(one):
            return _label(other)
    for other in everything:
        if _label(other) and _colour(one.artist) not in AIDS and _look(other)[:-1] == _look(one)[:-1]:
            return _label(other)
    return ""


def _name_by_colour(found: list[str], drawn: Sequence[Drawn], everything: Sequence[Drawn]) -> None:
    """Name what has the colour of something named in the panel; or, where several have, in the figure."""
    here = {_colour(one.artist): name for one, name in zip(drawn, found, strict=True) if name}
    figure = {_colour(one.artist): _label(one) for one in everything if _label(one)}
    rest = {_colour(one.artist) for one, name in zip(drawn, found, strict=True) if not name} - here.keys() - AIDS
    # A colour alone, of a panel with one thing in it, is a colour and no name.
    here |= {one: figure[one] for one in rest} if len(rest) > 1 and rest <= figure.keys() else {}
    for place, one in enumerate(drawn):
        if not found[place]:
            name = "" if _colour(one.artist) in AIDS else here.get(_colour(one.artist), "")
            found[place] = ", ".join(filter(None, (name, _hint(one))))


def _word(one: Drawn, panel: Sequence[Drawn], y: str) -> str:
    """Return what it is: what the axis says of the only line or points of a panel, else how it is drawn."""
    alike = [other for other in panel if other.mark == one.mark and _colour(other.artist) != GREY]
    return y.partition(" [")[0] if one.mark in ("line", "points") and alike == [one] else one.mark


def _look(one: Drawn) -> tuple[Any, ...]:
    parts = (getattr(one.artist, f"get_{name}", None) for name in ("linestyle", "linewidth", "marker"))
    return _colour(one.artist), *(str(part()) if part else "" for part in parts)


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
