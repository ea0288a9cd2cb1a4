"""What friction or a plant does with each cause of a force that a model lacks, to first order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from bristle.core.variable import KINDS

if TYPE_CHECKING:
    from bristle.identification.missing_rows import Rows

__all__ = ["columns_by_cause", "lagging_columns"]

FALLS = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the largest speed, over which friction may fall
WAYS = tuple(np.geomspace(1e-4, 0.03, 6).tolist())  # of the range, over which a force may build up after a reversal
LAGS = (0.01, 0.04)  # [s]
LAG_FALLS = (0.003, 0.01, 0.03, 0.1)  # of the largest speed
LEAST_ANGLE = 1.0  # [rad], over which the sine of an angle is more than a straight line


def columns_by_cause(rows: Rows) -> Mapping[str, np.ndarray]:
    """Return what friction does by each cause but a ripple, to first order, shape (row, column) each."""
    x, side, speed = rows.position, rows.side[:, None], np.abs(rows.velocity)
    speed = speed / float(np.quantile(speed, 0.99))
    falls = np.exp(-speed[:, None] / np.array(FALLS))
    middle, reach = 0.5 * (x.max() + x.min()), 0.5 * float(np.ptp(x))
    place = ((x - middle) / reach)[:, None]
    turns = rows.kind == KINDS[1] and 2.0 * reach > LEAST_ANGLE
    behind, before = (way[:, None] / (2.0 * reach * np.array(WAYS)) for way in rows.from_ends(x))
    return {
        "speed": side * np.column_stack([falls, np.sqrt(speed), speed**2]),
        "direction": np.column_stack([np.ones_like(speed), speed, falls]),
        "lag": rows.acceleration[:, None] * falls,
        "play": side * np.exp(-np.column_stack([behind, before])),
        "position": np.column_stack([place, place**2, side * place, side * place**2]),
        "transmitted": side * np.abs(rows.predicted - rows.friction)[:, None],
        **({"gravity": np.column_stack([np.sin(x), np.cos(x)])} if turns else {}),
        **{
            name: (rows.friction * (signal - np.mean(signal)))[:, None] for name, signal in rows.surroundings.items()
        },
    }  # fmt: skip


def lagging_columns(rows: Rows) -> np.ndarray:
    """Return what friction that falls with the speed does where it lags behind it, shape (row, column).

    Rows that are left out are at rest: the speed that friction sees has died away over them.
    """
    speed, time = np.abs(rows.velocity), rows.time
    top, step = float(np.quantile(speed, 0.99)), np.diff(time, prepend=time[0])
    usual, falls = float(np.median(step)), np.array(LAG_FALLS)
    columns = []
    for lag in LAGS:
        keep, gain = np.exp(-step / lag), 1.0 - np.exp(-np.minimum(step, usual) / lag)
        lagged, late = np.empty_like(speed), float(speed[0])
        for row, (share, gained) in enumerate(zip(keep.tolist(), (gain * speed).tolist(), strict=True)):
            late = share * late + gained
            lagged[row] = late
        columns.append(np.exp(-lagged[:, None] / (falls * top)) - np.exp(-speed[:, None] / (falls * top)))
    return rows.side[:, None] * np.hstack(columns)
