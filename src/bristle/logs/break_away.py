r"""Measured break-away: force and distance of the transition to sliding, as functions of the speed of the pull.

A leg is a motion in one direction. It counts if it begins at rest after a motion in the other direction, and if its
break-away takes enough samples after the filter. Each such leg gives a force and a distance. Least squares of their
logarithms separate the scatter between legs, the difference between directions, and the dependence on the rate,

.. math:: \ln F_i = \beta_0 + \beta_1 \ln v_i + \beta_2 \operatorname{sgn} v_i + \epsilon_i

with intervals of Student's t distribution. The step of the encoder widens the interval of a distance: repetitions do not reduce this error.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core import NORMAL_95, unbounded
from bristle.logs.passages import Stretch
from bristle.logs.turns import Leg

TURNED = 0.9  # of the change of force: at which the friction counts as saturated


class Recording(NamedTuple):
    """Time [s], position [m or rad] and friction force [N or N*m] without its constant part, shape (sample,) each."""

    time: np.ndarray
    position: np.ndarray
    force: np.ndarray


class BreakAway(NamedTuple):
    """Break-away at one rate, mean of both directions; 95 % intervals, or None if there are too few legs.

    Parameters
    ----------
    speed : float
        Speed of the pull [m/s or rad/s].
    legs : int
        Number of legs.
    force : float
        Largest friction force before sliding [N or N*m].
    force_interval : tuple of float or None
        Interval of the force [N or N*m].
    distance : float
        Distance from rest at which 90 % of the change of force is reached [m or rad].
    distance_interval : tuple of float or None
        Interval of the distance [m or rad].
    """

    speed: float
    legs: int
    force: float
    force_interval: tuple[float, float] | None
    distance: float
    distance_interval: tuple[float, float] | None


class _Leg(NamedTuple):
    speed: float
    side: float
    force: float
    distance: float


def break_aways(
    recordings: Sequence[Recording],
    *,
    cutoff: float,
    sample_time: float,
    resolution: float,
    noise: float,
) -> tuple[BreakAway, ...]:
    """Return the break-aways of a log, by rate."""
    # Of the encoder and of the position noise: smaller motions are ignored.
    grain = max(2.5 * resolution, 10.0 * noise)
    legs: list[_Leg] = []
    for recording in recordings:
        stretch = Stretch(*recording, grain, None, 0)
        for leg in stretch.of_kind("break_away"):
            rest = max(
                (rest for rest in stretch.rests if rest.start <= leg.first),
                key=lambda rest: rest.start,
            )
            # A faster leg would show the distance of the filter: it must last at least 1.0 of the filter.
            measured = _measured(leg, rest, recording, 1.0 / (sample_time * cutoff))
            legs += [measured] if measured is not None else []
    groups: list[list[int]] = []  # legs of one rate, the slowest group first
    for k in sorted(range(len(legs)), key=lambda place: legs[place].speed):
        # Largest ratio of rates in one group.
        if not groups or legs[k].speed > 1.3 * legs[groups[-1][0]].speed:
            groups.append([])
        groups[-1].append(k)
    speeds = [math.exp(float(np.mean(np.log([legs[k].speed for k in group])))) for group in groups]
    forces = _estimates(legs, groups, speeds, [leg.force for leg in legs], 0.0)
    distances = _estimates(
        legs, groups, speeds, [leg.distance for leg in legs], resolution / math.sqrt(6.0)
    )
    return tuple(
        BreakAway(speed, len(group), *force, *distance)
        for speed, group, force, distance in zip(speeds, groups, forces, distances, strict=True)
    )


def _measured(leg: Leg, rest: slice, recording: Recording, shortest: float) -> _Leg | None:
    """Return the break-away of one leg after its rest; None if it takes fewer samples than the `shortest`."""
    position, force = recording.position, recording.force
    side = math.copysign(1.0, leg.distance)
    # Friction begins to turn before the leg has moved by a detectable grain.
    pulled = side * force[rest.start : leg.last + 1]
    moved = side * (position[rest.start : leg.last + 1] - np.median(position[rest]))
    sliding = side * force[(leg.cruise.start + leg.cruise.stop) // 2 : leg.cruise.stop]
    level = float(np.mean(sliding))
    peak = float(np.max(pulled[: leg.cruise.stop - rest.start]))
    # A peak exceeds the sliding force by at least 3.0 standard deviations.
    most = peak if peak - level > 3.0 * float(np.std(sliding)) else level
    before = float(np.median(pulled[: rest.stop - rest.start]))
    # Of the break-away force: a motion in the other direction leaves the contact loaded.
    if most <= 0.0 or before > -0.5 * most:
        return None
    share = (pulled - before) / (most - before)
    turned = int(np.argmax(share >= TURNED))
    still = np.flatnonzero(share[:turned] <= 1.0 - TURNED)
    if not still.size or moved[turned] <= 0.0:
        return None
    if turned - int(still[-1]) < shortest:
        return None
    return _Leg(leg.speed, side, most, float(moved[turned]))


def _estimates(
    legs: Sequence[_Leg],
    groups: Sequence[Sequence[int]],
    speeds: Sequence[float],
    values: Sequence[float],
    common: float,
) -> list[tuple[float, tuple[float, float] | None]]:
    """Return the mean of both directions at each rate with its interval; `common` is an error shared by all legs."""
    from scipy.stats import t

    if not groups:
        return []
    columns = [np.ones(len(legs))]
    if len(groups) > 1:
        columns.append(np.log([leg.speed for leg in legs]))
    if len({leg.side for leg in legs}) > 1:
        columns.append(np.array([leg.side for leg in legs]))
    regressor, target = np.stack(columns, axis=1), np.log(values)
    weights = unbounded(regressor, target)
    spare = len(legs) - len(columns)
    estimates: list[tuple[float, tuple[float, float] | None]] = []
    for speed in speeds:
        known = [1.0, math.log(speed)] if len(groups) > 1 else [1.0]
        row = np.pad(known, (0, len(columns) - len(known)))
        middle = float(row @ weights)
        interval = None
        if spare > 0:
            variance = float(np.sum((target - regressor @ weights) ** 2)) / spare
            half = float(t.ppf(0.975, spare)) * math.sqrt(
                variance * float(row @ np.linalg.pinv(regressor.T @ regressor) @ row)
            )
            half = math.hypot(half, NORMAL_95 * common / math.exp(middle))
            interval = math.exp(middle - half), math.exp(middle + half)
        estimates.append((math.exp(middle), interval))
    return estimates
