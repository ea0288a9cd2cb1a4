"""The lab: one page on which friction is touched, with the physics in it; the same in a notebook and in a report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.lab.page import lab_page

if TYPE_CHECKING:
    from bristle.lab.widget import Widget

__all__ = ["Widget", "lab_page"]


def __getattr__(name: str) -> Any:
    if name != "Widget":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # Notebooks alone have what it needs.
    from bristle.lab.widget import Widget

    return Widget
