"""The score board of friction before sliding: fixed tasks, competitors in one file each, scores with intervals."""

from benchmarks.board.record import Record, log_of

__all__ = ["Record", "log_of"]
