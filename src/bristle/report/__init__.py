"""Reports, each a self-contained HTML file that works offline and prints on A4."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.report import figures

__getattr__ = loaded_from(__name__)
