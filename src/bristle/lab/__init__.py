"""The lab: one page on which friction is touched, with the physics in it; the same in a notebook and in a report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

if TYPE_CHECKING:
    from bristle.lab.page import lab_page
    from bristle.lab.widget import Widget

__all__ = ["Widget", "lab_page"]

# Notebooks alone have what a widget needs.
__getattr__ = loaded_from(__name__, {"lab_page": "page", "Widget": "widget"})
