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
it [2]_. Errors are those of a jackknife over blocks of time; where all cut-offs contradict each other, as many times as
large as lets some agree [3]_. Where noise lowers the inertia of wide cut-offs, on the same rows [5]_, narrow ones say it.

References
----------
.. [1] A. Janot, P.-O. Vandanjon, M. Gautier, "A generic instrumental variable approach for industrial robot
   identification", IEEE Transactions on Control Systems Technology 22(1), 2014. doi:10.1109/TCST.2013.2246163
.. [2] O. V. Lepskii, "On a problem of adaptive estimation in Gaussian white noise", Theory of Probability & Its
   Applications 35(3), 1991. doi:10.1137/1135065
.. [3] R. T. Birge, "The calculation of errors by the method of least squares", Physical Review 40(2), 1932.
   doi:10.1103/PhysRev.40.207
.. [4] F. Wilcoxon, "Individual comparisons by ranking methods", Biometrics Bulletin 1(6), 1945. doi:10.2307/3001968
.. [5] J. A. Hausman, "Specification tests in econometrics", Econometrica 46(6), 1978. doi:10.2307/1913827
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.identification.dataset import Alignment
from bristle.identification.settings import Settings
from bristle.identification.wide_rows import FILTER, STEPS, WIDTHS, InstrumentFit, WideRows, wide_rows
from bristle.logs.log import Log

RUNGS, LOWEST = 8, 0.04  # cut-offs of the instruments: how many, the lowest as a share of the widest rows
NARROWEST, HIGHEST = 3.0, 110.0  # Hz: of the instruments
SLOWEST = 1e-3  # s from sample to sample: rows of faster logs are as narrow
SPARE_MASS, SPARE_DELAY = 1e-3, 0.05  # of the inertia, samples: what no log says better
SUSPECTED = 3.0  # standard errors from which a filter in one channel is suspected
INERTIA_SHARE = 0.12  # of the inertia: a half-width beyond which the log does not show a delay
CLEARLY = 2.0  # half-widths from which a delay is one, whatever made the first stage err
MAY_BE_NONE = 0.25  # of the half-width of the inertia with which a delay is taken out, where there may be none
STUDENT = 2.093  # the 97.5 % quantile of Student's t of one degree of freedom less than the jackknife has blocks
BIAS_OVER_ERROR, BIAS_UNSURE = 0.3, 50.0  # noise is not white and may bias so many times more than computed
AGREE, ALIKE, POOR, SHARPER = 2.0, 0.7, 6.0, 1.3  # of rungs: see `agreeing`
SCALES = 1.0, 2.0, 4.0  # of errors: as little as lets two cut-offs agree
CHANGED = 0.4  # of the change to another cut-off, which is put to the error
SHORT = 0.5  # of a filter: by how much less a step from none may see
GROWS, FADES = 0.3, 0.8  # of a filter: by how much more a wider cut-off may see of it (noise), or less (its tail)


class Rung(NamedTuple):
    """The fit at one cut-off without a filter, and with one that is free."""

    plain: InstrumentFit
    free: InstrumentFit


class _Channels(NamedTuple):
    """Time constant of a filter and its standard error [s]; of inertia and delay value, error, change to a cut-off."""

    lag: float | None
    lag_error: float
    values: tuple[float, float]
    errors: list[float]
    changes: tuple[float, float]


def alignment_of(logs: Sequence[Log], axes: Sequence[Axis | None], settings: Settings, *, sought: bool = True) -> Alignment:
    """Return how the channels of some logs of one axis stand in time; the delay is zero where it is not `sought`."""
    rows = wide_rows(logs, axes)
    if rows is None:
        return Alignment(sought=sought)
    start = rows.scanned() if sought else 0.0
    rows.find_waves(start)
    rungs = list[Rung]()
    for cutoff in _cutoffs(rows):
        plain = rows.fit(cutoff, start, free=(sought, False))
        free = rows.fit(cutoff, plain.delay, free=(sought, True), steps=1)
        if abs(free.c) > max(AGREE * free.std(-1), FILTER):
            # A step from none to more than 2 ms goes too short.
            free = rows.fit(cutoff, free.delay, free.c, free=(sought, True), steps=3)  # to a filter that is not small
        rungs.append(Rung(plain, free))
    run, scale = believed(rungs, rows.dt, sought=sought)
    alignment = _alignment_from(rows, run, settings, scale, sought=sought) if run else Alignment(sought=sought)
    return _without_noise(alignment, logs, axes, settings)


def _cutoffs(rows: WideRows) -> list[float]:
    """Return the cut-offs of the instruments [Hz], the narrowest first."""
    highest = min(0.8 * rows.width, HIGHEST)
    return np.geomspace(min(max(LOWEST * rows.width, NARROWEST), 0.5 * highest), highest, RUNGS).tolist()


def _without_noise(alignment: Alignment, logs: Sequence[Log], axes: Sequence[Axis | None], settings: Settings) -> Alignment:
    """Return an alignment with the inertia of few columns where noise of the position lowers that of least squares.

    An encoder errs in a band as often as not, which wide rows contain. A delay that is not known is held at none, within
    what a log could hide; friction does not bend with speed, or little would be left of a few steps of the effort.
    """
    dt, delay, mass = logs[0].sample_time, alignment.delay or 0.0, alignment.mass
    too_small, sharpest = 0.0, list[tuple[WideRows, InstrumentFit, float]]()
    for share in WIDTHS[1:]:
        rows = wide_rows(logs, axes, (share * max(SLOWEST / dt, 1.0),), few=True)
        if rows is not None:
            fits = [rows.fit(cutoff, delay, free=(False, False), steps=1) for cutoff in _cutoffs(rows)]
            # The widest cut-off makes least squares of the rows; noise grows with it, what a model lacks of friction does not.
            too_small = max(too_small, fits[-1].below(fits[RUNGS // 2], STUDENT, settings.stages_apart))
            if run := agreeing([Rung(fit, fit) for fit in fits], dt, sought=False):
                sharpest.append((rows, _sharpest(run)[0].plain, float(np.ptp([rung.plain.theta[0] for rung in run]))))
    lowered = replace(alignment, too_small=too_small)
    if not too_small or not sharpest:
        return lowered
    # Narrow rows blur where friction turns, wide ones have noise: what scatters least has least of both.
    rows, chosen, spread = min(sharpest, key=lambda entry: entry[1].std(0) / entry[1].theta[0])
    inertia = float(chosen.theta[0])
    late = alignment.delay_half_width or settings.delay_unsure * dt * alignment.sought
    ends = [float(rows.fit(chosen.cutoff, delay + end, free=(False, False), steps=1).theta[0]) for end in (-late, late)]
    half_width = math.hypot(STUDENT * chosen.std(0), 0.5 * (ends[1] - ends[0])) + CHANGED * spread
    if mass is not None and (width := alignment.mass_half_width or 0.0) <= max(half_width, settings.inertia_unsure * mass):
        inertia, half_width = mass, width + abs(mass - inertia)
    if half_width > settings.unsure_std * inertia:
        return replace(lowered, mass=None, mass_half_width=None)
    return replace(lowered, mass=inertia, mass_half_width=half_width, slow=alignment.slow or chosen.cutoff)


def believed(rungs: Sequence[Rung], dt: float, *, sought: bool) -> tuple[list[Rung], float]:
    """Return rungs that do not contradict each other, and how many times as large their errors had to be for that.

    Parts of a log that share a fault of the model scatter less than it: their errors are too small (Birge's ratio).
    """
    for scale in SCALES:
        doubted = [Rung(rung.plain.doubted(scale), rung.free.doubted(scale)) for rung in rungs]
        run = agreeing(doubted, dt, sought=sought) or agreeing(doubted, dt, sought=sought, filters=False)
        if run:
            return run, scale
    return [], 1.0


def agreeing(rungs: Sequence[Rung], dt: float, *, sought: bool, filters: bool = True) -> list[Rung]:
    """Return the most rungs in a row that do not contradict each other, of `filters` neither, the narrowest first."""
    usable = [rung for rung in rungs if rung.plain.converged and rung.plain.theta[0] > 2.0 * rung.plain.std(0)]
    worst = POOR * min((rung.free.std(0) for rung in usable), default=0.0)
    usable, most = [rung for rung in usable if rung.free.std(0) <= worst], list[Rung]()
    for first in range(len(usable)):
        run = usable[first : first + 1]
        for rung in usable[first + 1 :]:
            if any(_contradicts(rung.free, narrow.free, dt, sought=sought, filters=filters) for narrow in run):
                break
            run.append(rung)
        most = run if len(run) > len(most) else most
    return most if len(most) >= 2 else []  # cut-offs, or nothing is known


def _contradicts(wide: InstrumentFit, narrow: InstrumentFit, dt: float, *, sought: bool, filters: bool) -> bool:
    """Return whether a wider cut-off says something else: noise makes the inertia smaller, and looks like a filter."""

    def apart(place: int, change: float, spare: float) -> bool:
        before, after = float(narrow.covariance[place, place]) ** 0.5, float(wide.covariance[place, place]) ** 0.5
        joint = math.hypot(max(before**2 - after**2, 0.0) ** 0.5, ALIKE * before)
        return abs(change) > AGREE * joint + spare

    tail = GROWS if abs(wide.c) > abs(narrow.c) else FADES
    return (
        apart(0, float(wide.theta[0] - narrow.theta[0]), 0.0)
        or (filters and apart(-1, wide.c - narrow.c, tail * abs(narrow.c)))
        or (sought and apart(wide.theta.size, wide.delay - narrow.delay, 0.05 * dt))
    )


def _sharpest(rungs: Sequence[Rung]) -> tuple[Rung, Rung]:
    """Return the widest of the sharp rungs in which noise is nothing, and the one that is narrower by two."""
    errors = [rung.plain.std(0) for rung in rungs]
    bounds = zip(rungs, errors, strict=True)
    clean = [n for n, (rung, error) in enumerate(bounds) if BIAS_UNSURE * rung.plain.bias <= BIAS_OVER_ERROR * error]
    sharp = SHARPER * min(map(errors.__getitem__, clean or [0]))
    sharpest = max(n for n in clean or [0] if errors[n] <= sharp)
    return rungs[sharpest], rungs[max(sharpest - 2, 0)]


def _alignment_from(rows: WideRows, rungs: list[Rung], settings: Settings, scale: float, *, sought: bool) -> Alignment:
    """Return what the sharpest of the rungs says, noise being nothing in it, and how sure that is."""
    (chosen, narrower), dt = _sharpest(rungs), rows.dt
    filtered = _with_filter(rows, chosen, narrower, scale, sought=sought)
    channels = filtered or _without_filter(chosen, narrower, sought=sought)
    pairs = zip(channels.errors, channels.changes, strict=False)
    widths = [STUDENT * error + CHANGED * abs(change) for error, change in pairs]
    (mass, delay), lag = channels.values, channels.lag
    mass_width, width = widths[0] + SPARE_MASS * mass, widths[1] + SPARE_DELAY * dt if sought else math.inf
    # What does not show the inertia does not show the jerk either; in one sine, it is told from a spring by nothing.
    # A delay that may be none is moved where the inertia is known well only.
    share = 1.0 - rows.springiness(chosen.plain.cutoff) ** 2 if abs(delay) > CLEARLY * width else MAY_BE_NONE
    delay_known = width <= settings.delay_unsure * dt and mass_width <= INERTIA_SHARE * share * mass
    lag = lag if delay_known or not sought else None
    mass_known = mass_width <= 0.2 * mass  # of the inertia: a half-width that tells nothing
    # A filter that makes all of a delay may be as good an explanation as none; half a sample is a hold.
    lag_alone, free = abs(delay) - 0.5 * dt, narrower.free
    as_good = lag_alone > dt and abs(free.c - math.copysign(0.5 * lag_alone**2, delay)) < AGREE * free.std(-1)
    may_be_filter = delay_known and lag is None and as_good
    return Alignment(
        delay=delay if delay_known else None,
        delay_half_width=width if delay_known else None,
        smoothing=lag,
        smoothing_half_width=None if lag is None else STUDENT * channels.lag_error,
        mass=mass if mass_known else None,
        mass_half_width=mass_width if mass_known else None,
        slow=chosen.plain.cutoff,
        sought=sought,
        filter_open=may_be_filter,
    )


def _with_filter(rows: WideRows, rung: Rung, narrower: Rung, scale: float, *, sought: bool) -> _Channels | None:
    """Return what the rows say with a filter in a channel; None where none is seen."""
    # A filter of less than a sample is no matter, one that the narrower cut-off does not see is noise, and one that tells
    # nothing of parts of the log by the others is none, however small its error: what is left of friction is no chance.
    least = 0.5 * rows.dt**2

    def seen(fit: InstrumentFit, errors: float) -> bool:
        return abs(fit.c) > max(errors * fit.std(-1), least)

    if not seen(rung.free, SUSPECTED) or not seen(narrower.free, AGREE) or rung.free.c * narrower.free.c < 0.0:
        return None
    bent = rows.fit(rung.plain.cutoff, rung.plain.delay, free=(sought, True), steps=2 * STEPS).doubted(scale)
    if not bent.converged or not seen(bent, SUSPECTED) or abs(bent.c - rung.free.c) > SHORT * abs(bent.c):
        return None
    # What a filter lowers lies above zero for certain by its signed ranks [4]_: a value that is huge is one vote.
    lowered = rows.lowered(bent, rung.plain.delay)
    ranks = 1.0 + np.argsort(np.argsort(np.abs(lowered)))
    if np.sum(lowered) <= 0.0 or np.sum(np.sign(lowered) * ranks) <= AGREE * np.sum(ranks**2) ** 0.5:
        return None
    again = rows.fit(narrower.plain.cutoff, bent.delay, bent.c, free=(sought, False))
    places = (0, bent.theta.size)[: 1 + sought]
    lag = math.copysign((2.0 * abs(bent.c)) ** 0.5, bent.c)
    values, changed = ((float(bent.theta[0]), bent.delay), (float(again.theta[0] - bent.theta[0]), again.delay - bent.delay))
    return _Channels(lag, bent.std(-1) / abs(lag), values, [bent.std(place) for place in places], changed)


def _without_filter(rung: Rung, narrower: Rung, *, sought: bool) -> _Channels:
    """Return what the rows say where no filter is seen: what is known of one beforehand and what they say, together."""
    # The narrower cut-off says it, for noise looks like a filter that grows with the cut-off.
    plain, free, other = rung.plain, rung.free, narrower.plain
    std = narrower.free.std(-1)
    share = FILTER**2 / (FILTER**2 + std**2)
    c, unknown = share * narrower.free.c, math.hypot(share * std, (1.0 - share) * FILTER)
    slopes = [float(free.theta[0] - plain.theta[0]), free.delay - plain.delay]
    slopes = [slope / free.c if free.c else 0.0 for slope in slopes]
    places = (0, plain.theta.size)[: 1 + sought]
    errors = [math.hypot(plain.std(place), slope * unknown) for place, slope in zip(places, slopes, strict=False)]
    values = (float(plain.theta[0]) + slopes[0] * c, plain.delay + slopes[1] * c)
    return _Channels(None, 0.0, values, errors, (float(other.theta[0] - plain.theta[0]), other.delay - plain.delay))
