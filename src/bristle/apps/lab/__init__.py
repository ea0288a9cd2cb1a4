"""The lab: an interactive page that simulates friction models; also in notebooks and reports."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.apps.lab.page import lab_page
    from bristle.apps.lab.widget import Widget

__getattr__ = loaded_from(__name__)

__all__ = ["Widget", "lab_page"]
