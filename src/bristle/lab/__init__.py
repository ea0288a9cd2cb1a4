"""The lab: an interactive page that simulates friction models; also in notebooks and reports."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.lab.page import lab_page
    from bristle.lab.widget import Widget

__getattr__ = loaded_from(__name__)

__all__ = ["Widget", "lab_page"]
