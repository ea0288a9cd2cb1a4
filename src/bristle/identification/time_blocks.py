"""Which rows of a log are held out together: a segment of it, or short ones from all over.

A contiguous part of a log is the harder test: nothing next to its rows was fitted. It is an unfair one where that part
holds an experiment of its own, as in a log that was designed: without its only fast slides nobody knows the viscous
friction. Each part then consists of short segments from all over the log.
"""

from __future__ import annotations

import numpy as np

from bristle.identification.dataset import Dataset
from bristle.identification.settings import Settings

__all__ = ["BLOCKS", "SHORT", "TIME", "beside", "blocks_for", "room_for_blocks", "time_blocks"]

BLOCKS = 5  # that a log is divided into, where nobody asks for another number
TIME, SHORT = "time blocks", "short time blocks"
BINS = 4  # of a decade of speed
FEW = 0.25  # of the rows of a block: so few others at such a speed are none
ALONE = 0.1  # share of the rows of a block at speeds that no other has
PIECES = 8  # of each part, at most
LEAST = 4  # times the reach of the filters, at either end, that a short segment is long
SEED = 5


def blocks_for(dataset: Dataset, requested: int | None, settings: Settings) -> int:
    """Return how many blocks are held out: as requested, else five, fewer of a short log, 0 where none has room."""
    if requested is not None or dataset.log_of_row[0] != dataset.log_of_row[-1]:
        return BLOCKS if requested is None else requested
    most = room_for_blocks(dataset, settings)
    return min(most, BLOCKS) if most > 1 else 0


def room_for_blocks(dataset: Dataset, settings: Settings) -> int:
    """Return for how many time blocks a log has rows, their margins apart."""
    return dataset.effort.size // (int(settings.held_out_rows) + 2 * dataset.reach)


def time_blocks(dataset: Dataset, count: int) -> tuple[str, list[np.ndarray]]:
    """Return what the parts of a log are called, and the rows of each of so many, shape (row,) of bool."""
    rows = dataset.effort.size
    edges = np.linspace(0, rows, count + 1).astype(int)[1:-1]
    of, part = TIME, np.searchsorted(edges, np.arange(rows), side="right")
    pieces = min(PIECES, rows // (count * 2 * LEAST * max(dataset.reach, 1)))
    if pieces > 1 and _has_experiments_of_its_own(np.abs(dataset.velocity), part, count):
        # Each part has one piece of each neighbourhood, in no order that a periodic motion could keep in step with.
        rng = np.random.default_rng(SEED)
        owner = np.concatenate([rng.permutation(count) for _ in range(pieces)])
        of, part = SHORT, owner[np.arange(rows) * owner.size // rows]
    return of, [part == number for number in range(count)]


def beside(part: np.ndarray, reach: int) -> np.ndarray:
    """Return the rows that share no sample with those of a part through filters that reach so far, of bool."""
    return np.convolve(part, np.ones(2 * reach + 1))[reach : reach + part.size] < 0.5


def _has_experiments_of_its_own(speed: np.ndarray, part: np.ndarray, count: int) -> bool:
    """Return whether any of several parts goes at speeds that all others together hardly go at."""
    moving = speed > 0.0
    place = np.floor(BINS * np.log10(speed[moving])).astype(int)
    place -= place.min(initial=0)
    counts = np.zeros((count, place.max(initial=0) + 1))
    np.add.at(counts, (part[moving], place), 1.0)
    alone = np.where(counts.sum(axis=0) - counts < FEW * counts, counts, 0.0).sum(axis=1)
    return bool(np.any(alone > ALONE * np.bincount(part, minlength=count)))
