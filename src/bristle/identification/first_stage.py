r"""The delay between effort and position, a filter in one of the channels, and the inertia: found before any model.

Noise of the position makes the inertia too small, and a delay makes it wrong to either side. Both are taken care of by
instrumental variables [1]_: the equations of the wide rows, in which friction turns where it does, are weighed with
the same motion behind a narrow low-pass filter `H`, in which noise is nothing,

.. math:: X^T W H W \left[u(t + \tau) - X \theta + \tau' \tfrac{d}{dt} X \theta - c\, \tfrac{d^2}{dt^2} X \theta\right]
   = 0 .

`X` has the acceleration, friction that may bend with speed, by direction, a spring, and the waves over the position
that the residual shows. `W` leaves out what is slow: friction before sliding turns after the motion, as if the effort
were late. A first-order filter of time constant `T` is a delay of `T` and a :math:`c = T^2 / 2`, positive where the
effort passed it. A `c` that is not seen clearly is drawn to zero, as one of some milliseconds is.

The cut-off of `H` is the widest at which neither noise of the encoder nor an estimate from narrower ones speaks against
it [2]_. Errors are those of a jackknife over blocks of time.

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
.. [2] O. V. Lepskii, "On a problem of adaptive estimation in Gaussian white noise", Theory of Probability & Its
   Applications 35(3), 1991. doi:10.1137/1135065
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.delay import Alignment
from bristle.identification.settings import Settings
from bristle.identification.wide_rows import FILTER, STEPS, InstrumentFit, WideRows, wide_rows
from bristle.logs.log import Log

__all__ = ["alignment_of"]

RUNGS, LOWEST = 8, 0.04  # cut-offs of the instruments: how many, the lowest as a share of the widest rows
NARROWEST, HIGHEST = 3.0, 110.0  # Hz: of the instruments
CHANGE = 0.4  # of the change to another cut-off that is put to the error
SPARE_MASS, SPARE_DELAY = 5e-4, 0.05  # of the inertia, samples: what no log says better
STUDENT = 2.093  # the 97.5 % quantile of Student's t of one degree of freedom less than the jackknife has blocks
BIAS_OVER_ERROR, BIAS_UNSURE = 0.3, 50.0  # noise is not white and may bias so many times more than computed
FEWEST_ALIKE = 2  # cut-offs, or nothing is known
AGREE, ALIKE, POOR, SHARPER = 2.0, 0.7, 6.0, 1.3  # of rungs: see `_agreeing`
GROWS, FADES = 0.3, 0.8  # of a filter: by how much more a wider cut-off may see of it (noise), or less (its tail)


class _Rung(NamedTuple):
    """The fit at one cut-off without a filter, and with one that is free."""

    plain: InstrumentFit
    free: InstrumentFit


def alignment_of(
    logs: Sequence[Log], axes: Sequence[Axis | None], settings: Settings, *, sought: bool = True
) -> Alignment:  # fmt: skip
    """Return how the channels of some logs of one axis stand in time; the delay is zero where it is not `sought`."""
    rows = wide_rows(logs, axes)
    if rows is None:
        return Alignment(sought=sought)
    start = rows.scanned() if sought else 0.0
    rows.find_waves(start)
    highest, rungs = min(0.8 * rows.width, HIGHEST), list[_Rung]()
    lowest = min(max(LOWEST * rows.width, NARROWEST), 0.5 * highest)
    for cutoff in np.geomspace(lowest, highest, RUNGS).tolist():
        plain = rows.fit(cutoff, start, free=(sought, False))
        rungs.append(_Rung(plain, rows.fit(cutoff, plain.delay, free=(sought, True), steps=1)))
    agreeing = _agreeing(rungs, rows.dt, sought=sought)
    return _alignment_from(rows, agreeing, settings, sought=sought) if agreeing else Alignment(sought=sought)


def _agreeing(rungs: Sequence[_Rung], dt: float, *, sought: bool) -> list[_Rung]:
    """Return the most rungs in a row that do not contradict each other, the narrowest first."""
    usable = [rung for rung in rungs if rung.plain.converged and rung.plain.theta[0] > 2.0 * rung.plain.std(0)]
    worst = POOR * min((rung.free.std(0) for rung in usable), default=0.0)
    usable, most = [rung for rung in usable if rung.free.std(0) <= worst], list[_Rung]()
    for first in range(len(usable)):
        run = usable[first : first + 1]
        for rung in usable[first + 1 :]:
            if any(_contradicts(rung.free, narrow.free, dt, sought=sought) for narrow in run):
                break
            run.append(rung)
        most = run if len(run) > len(most) else most
    return most if len(most) >= FEWEST_ALIKE else []


def _contradicts(wide: InstrumentFit, narrow: InstrumentFit, dt: float, *, sought: bool) -> bool:
    """Return whether a wider cut-off says something else: noise makes the inertia smaller, and looks like a filter."""

    def apart(place: int, change: float, spare: float) -> bool:
        before, after = narrow.std(place), wide.std(place)
        joint = math.hypot(max(before**2 - after**2, 0.0) ** 0.5, ALIKE * before)
        return abs(change) > AGREE * joint + spare

    return (
        apart(0, float(wide.theta[0] - narrow.theta[0]), 0.0)
        or apart(-1, wide.c - narrow.c, (GROWS if abs(wide.c) > abs(narrow.c) else FADES) * abs(narrow.c))
        or (sought and apart(wide.theta.size, wide.delay - narrow.delay, 0.05 * dt))
    )


def _alignment_from(rows: WideRows, rungs: list[_Rung], settings: Settings, *, sought: bool) -> Alignment:
    """Return what the sharpest of the rungs says, noise being nothing in it, and how sure that is."""
    clean = [rung for rung in rungs if BIAS_UNSURE * rung.plain.bias <= BIAS_OVER_ERROR * rung.plain.std(0)] or rungs[
        :1
    ]
    sharp = SHARPER * min(rung.plain.std(0) for rung in clean)
    chosen = [rung for rung in clean if rung.plain.std(0) <= sharp][-1]
    narrower = rungs[max(rungs.index(chosen) - 2, 0)].plain
    places, dt = [0, chosen.plain.theta.size] if sought else [0], rows.dt
    clear = settings.filter_seen
    lag, std, values, errors, changes = _filtered(rows, chosen, narrower, places, clear, sought=sought)
    widths = [STUDENT * error + CHANGE * abs(change) for error, change in zip(errors, changes, strict=True)]
    mass, mass_width = values[0], widths[0] + SPARE_MASS * values[0]
    delay, width = (values[1], widths[1] + SPARE_DELAY * dt) if sought else (0.0, math.inf)
    # What does not show the inertia does not show the jerk either.
    delay_known = width <= settings.delay_unsure * dt and mass_width <= settings.delay_inertia * mass
    lag = lag if delay_known or not sought else None
    well = mass_width <= settings.inertia_unsure * mass
    return Alignment(
        *((delay, width) if delay_known else (None, None)),
        *(None, None) if lag is None else (lag, STUDENT * std / abs(lag)),
        *((mass, mass_width) if well else (None, None)),
        chosen.plain.cutoff, sought,
    )  # fmt: skip


def _filtered(
    rows: WideRows,
    rung: _Rung,
    narrower: InstrumentFit,
    places: Sequence[int],
    clear: float,
    *,
    sought: bool,
) -> tuple[float | None, float, list[float], list[float], list[float]]:
    """Return what a filter in a channel does to the inertia and the delay.

    The time constant of one that is seen [s], the error of its square; values, errors, and changes to another cut-off.
    `clear` is from how many standard errors on it is seen.
    """
    free, plain = rung.free, rung.plain
    std = free.std(-1)
    least = 0.5 * rows.dt**2  # of a filter of one sample: what is faster is no matter
    if abs(free.c) > max(clear * std, least):
        bent = rows.fit(plain.cutoff, plain.delay, free=(sought, True), steps=2 * STEPS)
        if (
            bent.converged
            and abs(bent.c) > max(clear * bent.std(-1), least)
            and abs(bent.c - free.c) <= FADES * abs(bent.c)
        ):
            again = rows.fit(narrower.cutoff, bent.delay, bent.c, free=(sought, False))
            changes = [float(again.theta[0] - bent.theta[0]), again.delay - bent.delay]
            lag = math.copysign((2.0 * abs(bent.c)) ** 0.5, bent.c)
            values, errors = [float(bent.theta[0]), bent.delay], [bent.std(place) for place in places]
            return lag, bent.std(-1), values, errors, changes[: len(places)]
    # A filter that is not seen clearly: what is known of it beforehand and what the rows say, together.
    share = FILTER**2 / (FILTER**2 + std**2)
    values, errors = [], []
    for place, value, start in zip(places, (free.theta[0], free.delay), (plain.theta[0], plain.delay), strict=False):
        slope, left = float(value - start) / free.c if free.c else 0.0, 1.0 - share
        values.append(float(value) - slope * left * free.c)
        of_rows = free.covariance[place, place] - 2.0 * slope * left * free.covariance[place, -1]
        variance = float(of_rows) + (slope * left * std) ** 2 + (slope * left * FILTER) ** 2
        errors.append(max(variance, 0.5 * plain.std(place) ** 2) ** 0.5)
    changes = [float(narrower.theta[0] - plain.theta[0]), narrower.delay - plain.delay]
    return None, std, values, errors, changes[: len(places)]
