"""The score board of friction before sliding: fixed tasks, competitors in one file each, scores with intervals."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.bench.record import Record, log_of

__getattr__ = loaded_from(__name__)

__all__ = ["Record", "log_of"]
