"""The settings that figures are drawn with: those that matplotlib comes with and this look, whatever its user has set.

They are settings of the process. One thread at a time has them; whoever else draws at that moment would see them.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib

__all__ = ["GREY", "INK", "own_settings"]

INK, GREY = "#1b2430", "#8d97a3"

LOOK: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.7,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "right",
    "axes.titlesize": 8.5,
    "axes.unicode_minus": True,
    "axes.xmargin": 0.01,
    "figure.facecolor": "none",
    "font.family": "sans-serif",
    # Widest first: where a reader lacks one, the next takes less room, so that nothing begins to overlap.
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial", "sans-serif"],
    "font.size": 8.5,
    "grid.color": "#dfe3e8",
    "grid.linewidth": 0.6,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.1,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "bristle",
    "text.color": INK,
    "text.parse_math": False,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
    "ytick.labelsize": 8,
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
