"""Play between motor and load, detected by the residual where the load changes flanks.

With play, the load rests against one flank of the drive until its force changes sign. Then it crosses to the other
flank and strikes it. A rigid axis has no such shock when it starts to brake during a motion. There the residual is
compared with that of rows of the same speed and jerk. Reversals are excluded because of sampling errors.
"""

import math

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.missing_force import Missing
from bristle.identification.missing_rows import FEWEST_ROWS, SMALLEST, TINY, Rows
from bristle.identification.settings import Settings

MOST_OF_ONE = 0.5  # of the residual around changes of flank
LARGER = 1.8  # times the residual elsewhere: residual where the load changes flanks
# Rows before a change of flank; rows after it, at least; time after it [s]
BEFORE, AFTER, LASTS = (2, 4, 0.03)
# Changes of flank, rows of a kind for comparison, rows around the changes.
FEWEST_CHANGES, FEWEST_ALIKE, ENOUGH = (4, 10, 20)
SPEEDS = (0.003, 0.01, 0.03, 0.1, 0.3, 0.6)  # of the largest
JERKS = (0.5, 0.75, 0.9)  # quantiles


def play_at_flanks(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return play, if present, and the residual of rows of the same speed and jerk elsewhere [N or N*m]."""
    far = rows.far
    if not rows.enough or np.count_nonzero(far) < FEWEST_ROWS:
        return (), 0.0
    # Number of the nearby change of flank of each row, from 0; else -1.
    flank = rows.predicted < 0.0
    turned = np.flatnonzero((flank[1:] != flank[:-1]) & (rows.stretch[1:] == rows.stretch[:-1])) + 1
    after = max(round(LASTS / float(np.median(np.diff(rows.time)))), AFTER)
    near, number, last = np.full(flank.size, -1), -1, -math.inf
    for change in turned.tolist():
        number += change - last > after
        near[max(change - BEFORE, 0) : change + after] = number
        last = change
    # A number for the speed and the jerk of each row.
    speed, jerk = np.abs(rows.velocity), np.abs(rows.rate(rows.acceleration))
    fast = np.digitize(speed / float(np.quantile(speed, 0.99)), SPEEDS)
    kind, away = (
        fast * (len(JERKS) + 1) + np.digitize(jerk, np.quantile(jerk[far], JERKS)),
        far & (near < 0),
    )
    square = (
        rows.residual - rows.explained @ unbounded(rows.explained, rows.residual, rcond=TINY)
    ) ** 2
    count = np.bincount(kind[away], minlength=kind.max() + 1)
    usual = np.bincount(kind[away], square[away], minlength=count.size) / np.maximum(count, 1)
    around = far & (near >= 0) & (count[kind] >= FEWEST_ALIKE)
    numbers, changes = np.unique(near[around], return_inverse=True)
    if changes.size < ENOUGH or numbers.size < FEWEST_CHANGES:
        return (), 0.0
    # A single shock may have another cause, or be the edge of a filter: if it dominates, omit it.
    excesses = np.bincount(changes, square[around] - usual[kind[around]])
    if np.max(excesses) > MOST_OF_ONE * np.sum(excesses):
        around[np.flatnonzero(around)[changes == int(np.argmax(excesses))]] = False
    square_around, elsewhere = float(np.sum(square[around])), float(np.sum(usual[kind[around]]))
    ratio, excess = (
        math.sqrt(square_around / max(elsewhere, SMALLEST)),
        max(square_around - elsewhere, 0.0),
    )
    force = math.sqrt(excess / square.size)
    play = Missing("play", excess / float(np.sum(square)), force, ratio=ratio)
    if ratio < LARGER or play.evidence < settings.missing_evidence * float(
        np.sqrt(np.mean(rows.friction**2))
    ):
        return (), 0.0
    return (play,), math.sqrt(elsewhere / np.count_nonzero(around))
