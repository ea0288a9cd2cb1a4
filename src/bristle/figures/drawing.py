"""A figure that looks the same whoever draws or saves it, under whatever settings of matplotlib."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.figure import Figure

from bristle.figures.lettering import Lettering
from bristle.figures.settings import own_settings

__all__ = ["WIDTH", "Drawing"]

WIDTH = 7.2  # inches: the text width of an A4 page


class Drawing(Figure):
    """A figure drawn with the settings and the fonts that it was made with: much is decided as late as that."""

    def draw(self, renderer: Any) -> None:
        """Draw the figure."""
        lettered: Any = Lettering(renderer)
        with own_settings():
            super().draw(lettered)

    def savefig(self, fname: Any, **kwargs: Any) -> None:
        """Save the figure; see `matplotlib.figure.Figure.savefig`."""
        with own_settings():
            super().savefig(fname, **kwargs)

    def _repr_svg_(self) -> str:
        """Return the figure as notebooks show it."""
        file = io.StringIO()
        self.savefig(file, format="svg", bbox_inches="tight")
        return file.getvalue()

    def _get_renderer(self) -> Any:
        # What is measured before it is drawn: the gaps for the numbers in contour lines, the size of a text.
        with own_settings():
            return Lettering(super()._get_renderer())  # type: ignore[misc]
