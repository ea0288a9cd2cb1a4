"""Play between motor and load, by what a motor does while it does not carry its load.

Behind play a load rests against one flank of the drive, until the force that it takes changes its sign: then it flies
to the other flank, and knocks. Amid motion, where an axis begins to brake, a rigid one has no reason to: there the
residual is compared with that of rows of the same speed and the same jerk. At a reversal each model errs by its sampling.
"""

from __future__ import annotations

import math

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.missing_force import TINY, Missing
from bristle.identification.missing_rows import FEWEST_ROWS, SMALLEST, Rows
from bristle.identification.settings import Settings

MOST_OF_ONE = 0.5  # of what changes of sides leave over
LARGER = 1.8  # times the residual elsewhere: what is left over where the load changes flanks
BEFORE, AFTER, LASTS = 2, 4, 0.03  # rows ahead of a change of sides; after it that many at least, and so long [s]
FEWEST_CHANGES, FEWEST_ALIKE, ENOUGH = 4, 10, 20  # changes of sides, rows of a kind to compare with, rows around them
SPEEDS = (0.003, 0.01, 0.03, 0.1, 0.3, 0.6)  # of the largest
JERKS = (0.5, 0.75, 0.9)  # quantiles


def play_at_flanks(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return play, none or once, and what rows of the same speed and jerk leave over elsewhere [N or N*m]."""
    far = rows.far
    if not rows.enough or np.count_nonzero(far) < FEWEST_ROWS:
        return (), 0.0
    # Which change of sides each row is around, from 0; -1 around none.
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
    kind, away = fast * (len(JERKS) + 1) + np.digitize(jerk, np.quantile(jerk[far], JERKS)), far & (near < 0)
    square = (rows.residual - rows.explained @ unbounded(rows.explained, rows.residual, rcond=TINY)) ** 2
    count = np.bincount(kind[away], minlength=kind.max() + 1)
    usual = np.bincount(kind[away], square[away], minlength=count.size) / np.maximum(count, 1)
    around = far & (near >= 0) & (count[kind] >= FEWEST_ALIKE)
    numbers, changes = np.unique(near[around], return_inverse=True)
    if changes.size < ENOUGH or numbers.size < FEWEST_CHANGES:
        return (), 0.0
    # One knock may be a jolt, or the end of a filter: where it is most of what is left over, it counts for none.
    excesses = np.bincount(changes, square[around] - usual[kind[around]])
    if np.max(excesses) > MOST_OF_ONE * np.sum(excesses):
        around[np.flatnonzero(around)[changes == int(np.argmax(excesses))]] = False
    square_around, elsewhere = float(np.sum(square[around])), float(np.sum(usual[kind[around]]))
    ratio, excess = math.sqrt(square_around / max(elsewhere, SMALLEST)), max(square_around - elsewhere, 0.0)
    force = math.sqrt(excess / square.size)
    play = Missing("play", excess / float(np.sum(square)), force, ratio=ratio)
    if ratio < LARGER or play.evidence < settings.missing_evidence * float(np.sqrt(np.mean(rows.friction**2))):
        return (), 0.0
    return (play,), math.sqrt(elsewhere / np.count_nonzero(around))
