"""One look for all figures: settings of matplotlib that a figure is made, drawn and saved with, whatever its user has set.

They are settings of the process. One thread at a time has them; whoever else draws at that moment would see them.
"""

import io
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from bristle.figures.lettering import LETTERS, Lettering

WIDTH = 7.2  # inches: the text width of an A4 page
AT_TICKS = 8.0  # points: numbers and names at axes
INK, GREY = "#1b2430", "#8d97a3"

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
    # Widest first: where a reader lacks one, the next takes less room, so that nothing begins to overlap.
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial", "sans-serif"],
    "font.size": LETTERS,
    "grid.color": "#dfe3e8",
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

# The backend is what windows are opened with, which these figures never do; to ask for it would look one up.
BACKEND = ("backend", "backend_fallback")
OWN: Any = {key: value for key, value in dict(matplotlib.rcParamsDefault.copy()).items() if key not in BACKEND} | LOOK


class _Turn:
    """Whose turn it is to draw, and how often that thread has begun to."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.depth = 0


_turn = _Turn()
if hasattr(os, "register_at_fork"):
    # A child that is forked while another thread draws would find its settings changed and nobody to put them back.
    os.register_at_fork(before=_turn.lock.acquire, after_in_parent=_turn.lock.release, after_in_child=_turn.lock.release)


@contextmanager
def own_settings() -> Iterator[None]:
    """Draw with these settings; the ones before are put back. Inside of itself it changes nothing."""
    with _turn.lock:
        _turn.depth += 1
        try:
            if _turn.depth > 1:
                yield
            else:
                with matplotlib.rc_context(OWN):
                    yield
        finally:
            _turn.depth -= 1


class Drawing(Figure):
    """A figure drawn with the settings and the fonts that it was made with: much is decided as late as that."""

    has_room_above = False  # whether there is room for a legend above all panels

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
