r"""The delay between effort and position, a filter in one of the channels, and the inertia, estimated before any model.

Position noise biases the inertia towards zero, and a delay biases it to either side. Instrumental variables [1]_ remove
both: the equations of the wide rows, in which reversals of friction are sharp, are weighted with the same motion after a
narrow low-pass filter `H`, in which noise is negligible,

.. math:: X^T W H W \left[u(t + \tau) - X \theta + \tau' \tfrac{d}{dt} X \theta - c\, \tfrac{d^2}{dt^2} X \theta\right]
   = 0 .

`X` contains the acceleration, friction by direction, nonlinear in the speed, its linear change over the log, a spring, and
the waves of force and friction over the position that the residual shows. `W` removes slow parts: in pre-sliding,
friction turns after the motion, as if the effort were late. A first-order filter of time constant `T` is a delay of `T`
with :math:`c = T^2 / 2`, positive if the effort passed it. A `c` that is not significant is shrunk to zero.

`H` has the largest cut-off that neither encoder noise nor the estimates at lower cut-offs contradict [2]_. Errors come
from a jackknife over blocks of time. If all cut-offs contradict each other, the errors are scaled until some agree [3]_.
If noise lowers the inertia at high cut-offs on the same rows [5]_, low cut-offs determine it.

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
from bristle.identification.elasticity import Elastic, one_mass
from bristle.identification.settings import Settings
from bristle.identification.wide_rows import (
    FILTER,
    STEPS,
    WIDTHS,
    InstrumentFit,
    WideRows,
    wide_rows,
)
from bristle.logs.log import Log

# Cut-offs of the instruments: how many, the lowest as a share of the widest rows.
RUNGS, LOWEST = (8, 0.04)
NARROWEST, HIGHEST = 3.0, 110.0  # Hz: of the instruments
SLOWEST = 1e-3  # s: shortest sample time that rows follow
SPARE_MASS, SPARE_DELAY = 1e-3, 0.05  # of the inertia, in samples: the smallest half-widths
SUSPECTED = 3.0  # standard errors from which a filter in one channel is suspected
INERTIA_SHARE = (
    0.12  # half-width, as a share of the inertia, above which the log does not show a delay
)
CLEARLY = 2.0  # half-widths above which a delay is certain
MAY_BE_NONE = 0.25  # factor of that half-width for a delay that may be zero
STUDENT = 2.093  # the 97.5 % quantile of Student's t of one degree of freedom less than the jackknife has blocks
# Accepted bias over error; factor of the bias, because noise is not white.
BIAS_OVER_ERROR, BIAS_UNSURE = (0.3, 50.0)
AGREE, ALIKE, POOR, SHARPER = 2.0, 0.7, 6.0, 1.3  # of rungs: see `agreeing`
SCALES = 1.0, 2.0, 4.0  # of errors: the smallest with which two cut-offs agree
CHANGED = 0.4  # of the change to another cut-off, added to the error
SHORT = 0.5  # of a filter: allowed shortfall of a step from no filter
# Of a filter: allowed growth (noise) and decay (its tail) at a higher cut-off.
GROWS, FADES = (0.3, 0.8)


class Rung(NamedTuple):
    """The fits at one cut-off without a filter, and with a free filter."""

    plain: InstrumentFit
    free: InstrumentFit


class _Channels(NamedTuple):
    """Time constant of a filter and its standard error [s]; inertia and delay with their errors and changes to another cut-off."""

    lag: float | None
    lag_error: float
    values: tuple[float, float]
    errors: list[float]
    changes: tuple[float, float]


def alignment_of(
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    settings: Settings,
    *,
    sought: bool = True,
    coupling: Elastic | None = None,
) -> Alignment:
    """Return the alignment of the channels of logs of one axis; a delay that is not `sought` is zero, or that of an elastic `coupling`."""
    highest = coupling and coupling.one_mass
    sought, delay = (
        sought and coupling is None,
        coupling.delay if sought and coupling is not None else 0.0,
    )
    rows = wide_rows(logs, axes)
    if rows is None:
        return Alignment(sought=sought)
    start = rows.scanned() if sought else delay
    rows.find_waves(start)
    rungs = list[Rung]()
    for cutoff in _cutoffs(rows, highest):
        plain = rows.fit(cutoff, start, free=(sought, False))
        free = rows.fit(cutoff, plain.delay, free=(sought, True), steps=1)
        if abs(free.c) > max(AGREE * free.std(-1), FILTER):
            # A step from no filter to more than 2 ms is too short.
            # To a filter that is not small.
            free = rows.fit(cutoff, free.delay, free.c, free=(sought, True), steps=3)
        rungs.append(Rung(plain, free))
    run, scale = believed(rungs, rows.dt, sought=sought)
    alignment = (
        _alignment_from(rows, run, settings, scale, sought=sought)
        if run
        else Alignment(sought=sought)
    )
    alignment = _without_noise(
        replace(alignment, delay=delay) if delay else alignment, logs, axes, settings, highest
    )
    return one_mass(alignment, coupling)


def _cutoffs(rows: WideRows, highest: float | None) -> list[float]:
    """Return the cut-offs of the instruments [Hz], the narrowest first."""
    highest = min(0.8 * rows.width, HIGHEST, highest or HIGHEST)
    return np.geomspace(
        min(max(LOWEST * rows.width, NARROWEST), 0.5 * highest), highest, RUNGS
    ).tolist()


def _without_noise(
    alignment: Alignment,
    logs: Sequence[Log],
    axes: Sequence[Axis | None],
    settings: Settings,
    highest: float | None,
) -> Alignment:
    """Return an alignment with the inertia of few columns if position noise biases the inertia of least squares."""
    # Encoder errors are often in a frequency band that wide rows contain. An unknown delay is zero, with the uncertainty of
    # delays that a log could hide. Friction is linear in the speed: a nonlinear term would absorb a few steps of the effort.
    dt, delay, mass = logs[0].sample_time, alignment.delay or 0.0, alignment.mass
    too_small, sharpest = 0.0, list[tuple[WideRows, InstrumentFit, float]]()
    for share in WIDTHS[1:]:
        rows = wide_rows(logs, axes, (share * max(SLOWEST / dt, 1.0),), few=True)
        if rows is not None:
            fits = [
                rows.fit(cutoff, delay, free=(False, False), steps=1)
                for cutoff in _cutoffs(rows, highest)
            ]
            # The highest cut-off gives least squares of the rows; noise grows with the cut-off, unmodelled friction does not.
            too_small = max(
                too_small, fits[-1].below(fits[RUNGS // 2], STUDENT, settings.stages_apart)
            )
            if run := agreeing([Rung(fit, fit) for fit in fits], dt, sought=False):
                sharpest.append(
                    (
                        rows,
                        _sharpest(run)[0].plain,
                        float(np.ptp([rung.plain.theta[0] for rung in run])),
                    )
                )
    lowered = replace(alignment, too_small=too_small)
    if not too_small or not sharpest:
        return lowered
    # Narrow rows blur reversals of friction, wide rows have noise: the estimate with the least scatter has least of both.
    rows, chosen, spread = min(sharpest, key=lambda entry: entry[1].std(0) / entry[1].theta[0])
    inertia = float(chosen.theta[0])
    late = alignment.delay_half_width or settings.delay_unsure * dt * alignment.sought
    ends = [
        float(rows.fit(chosen.cutoff, delay + end, free=(False, False), steps=1).theta[0])
        for end in (-late, late)
    ]
    half_width = math.hypot(STUDENT * chosen.std(0), 0.5 * (ends[1] - ends[0])) + CHANGED * spread
    if mass is not None and (width := alignment.mass_half_width or 0.0) <= max(
        half_width, settings.inertia_unsure * mass
    ):
        inertia, half_width = mass, width + abs(mass - inertia)
    if half_width > settings.unsure_std * inertia:
        return replace(lowered, mass=None, mass_half_width=None)
    return replace(
        lowered, mass=inertia, mass_half_width=half_width, slow=alignment.slow or chosen.cutoff
    )


def believed(rungs: Sequence[Rung], dt: float, *, sought: bool) -> tuple[list[Rung], float]:
    """Return rungs without contradictions, and the factor of their errors at which they agree (Birge's ratio)."""
    # Parts of a log that share a model error scatter less than this error: their errors are too small.
    for scale in SCALES:
        doubted = [Rung(rung.plain.doubted(scale), rung.free.doubted(scale)) for rung in rungs]
        run = agreeing(doubted, dt, sought=sought) or agreeing(
            doubted, dt, sought=sought, filters=False
        )
        if run:
            return run, scale
    return [], 1.0


def agreeing(rungs: Sequence[Rung], dt: float, *, sought: bool, filters: bool = True) -> list[Rung]:
    """Return the longest run of rungs that agree, with `filters` also about the filter; the lowest cut-off first."""
    usable = [
        rung
        for rung in rungs
        if rung.plain.converged and rung.plain.theta[0] > 2.0 * rung.plain.std(0)
    ]
    worst = POOR * min((rung.free.std(0) for rung in usable), default=0.0)
    usable, most = [rung for rung in usable if rung.free.std(0) <= worst], list[Rung]()
    for first in range(len(usable)):
        run = usable[first : first + 1]
        for rung in usable[first + 1 :]:
            if any(
                _contradicts(rung.free, narrow.free, dt, sought=sought, filters=filters)
                for narrow in run
            ):
                break
            run.append(rung)
        most = run if len(run) > len(most) else most
    return most if len(most) >= 2 else []  # cut-offs, else the result is unknown


def _contradicts(
    wide: InstrumentFit, narrow: InstrumentFit, dt: float, *, sought: bool, filters: bool
) -> bool:
    """Return whether a higher cut-off contradicts a lower cut-off: noise lowers the inertia, and looks like a filter."""

    def apart(place: int, change: float, spare: float) -> bool:
        before, after = (
            float(narrow.covariance[place, place]) ** 0.5,
            float(wide.covariance[place, place]) ** 0.5,
        )
        joint = math.hypot(max(before**2 - after**2, 0.0) ** 0.5, ALIKE * before)
        return abs(change) > AGREE * joint + spare

    tail = GROWS if abs(wide.c) > abs(narrow.c) else FADES
    return (
        apart(0, float(wide.theta[0] - narrow.theta[0]), 0.0)
        or (filters and apart(-1, wide.c - narrow.c, tail * abs(narrow.c)))
        or (sought and apart(wide.theta.size, wide.delay - narrow.delay, 0.05 * dt))
    )


def _sharpest(rungs: Sequence[Rung]) -> tuple[Rung, Rung]:
    """Return the widest of the sharp rungs with negligible noise, and the rung two places narrower."""
    errors = [rung.plain.std(0) for rung in rungs]
    bounds = zip(rungs, errors, strict=True)
    clean = [
        n
        for n, (rung, error) in enumerate(bounds)
        if BIAS_UNSURE * rung.plain.bias <= BIAS_OVER_ERROR * error
    ]
    sharp = SHARPER * min(map(errors.__getitem__, clean or [0]))
    sharpest = max(n for n in clean or [0] if errors[n] <= sharp)
    return rungs[sharpest], rungs[max(sharpest - 2, 0)]


def _alignment_from(
    rows: WideRows, rungs: list[Rung], settings: Settings, scale: float, *, sought: bool
) -> Alignment:
    """Return the alignment of the sharpest rung with negligible noise, with its uncertainty."""
    (chosen, narrower), dt = _sharpest(rungs), rows.dt
    filtered = _with_filter(rows, chosen, narrower, scale, sought=sought)
    channels = filtered or _without_filter(chosen, narrower, sought=sought)
    pairs = zip(channels.errors, channels.changes, strict=False)
    widths = [STUDENT * error + CHANGED * abs(change) for error, change in pairs]
    (mass, delay), lag = channels.values, channels.lag
    mass_width, width = (
        widths[0] + SPARE_MASS * mass,
        widths[1] + SPARE_DELAY * dt if sought else math.inf,
    )
    # Rows that do not show the inertia do not show the jerk either; in a single sine, inertia and spring are confounded.
    # A delay that may be zero is removed only if the inertia is well known.
    share = (
        1.0 - rows.springiness(chosen.plain.cutoff) ** 2
        if abs(delay) > CLEARLY * width
        else MAY_BE_NONE
    )
    delay_known = width <= settings.delay_unsure * dt and mass_width <= INERTIA_SHARE * share * mass
    lag = lag if delay_known or not sought else None
    mass_known = mass_width <= 0.2 * mass  # of the inertia: largest useful half-width
    # A filter that causes all of the delay may explain it as well as a pure delay; half a sample is a hold.
    lag_alone, free = abs(delay) - 0.5 * dt, narrower.free
    as_good = lag_alone > dt and abs(
        free.c - math.copysign(0.5 * lag_alone**2, delay)
    ) < AGREE * free.std(-1)
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


def _with_filter(
    rows: WideRows, rung: Rung, narrower: Rung, scale: float, *, sought: bool
) -> _Channels | None:
    """Return the estimates with a filter in a channel; None if no filter is visible."""
    # A filter shorter than a sample does not matter. If the lower cut-off does not show it, it is noise. A filter must also
    # predict parts of the log from the others, however small its error: the residual of friction is not random.
    least = 0.5 * rows.dt**2

    def seen(fit: InstrumentFit, errors: float) -> bool:
        return abs(fit.c) > max(errors * fit.std(-1), least)

    if (
        not seen(rung.free, SUSPECTED)
        or not seen(narrower.free, AGREE)
        or rung.free.c * narrower.free.c < 0.0
    ):
        return None
    bent = rows.fit(
        rung.plain.cutoff, rung.plain.delay, free=(sought, True), steps=2 * STEPS
    ).doubted(scale)
    if (
        not bent.converged
        or not seen(bent, SUSPECTED)
        or abs(bent.c - rung.free.c) > SHORT * abs(bent.c)
    ):
        return None
    # The decrease by a filter must be significant in its signed ranks [4]_: one huge value then has one vote.
    lowered = rows.lowered(bent, rung.plain.delay)
    ranks = 1.0 + np.argsort(np.argsort(np.abs(lowered)))
    if (
        np.sum(lowered) <= 0.0
        or np.sum(np.sign(lowered) * ranks) <= AGREE * np.sum(ranks**2) ** 0.5
    ):
        return None
    again = rows.fit(narrower.plain.cutoff, bent.delay, bent.c, free=(sought, False))
    places = (0, bent.theta.size)[: 1 + sought]
    lag = math.copysign((2.0 * abs(bent.c)) ** 0.5, bent.c)
    values, changed = (
        (float(bent.theta[0]), bent.delay),
        (float(again.theta[0] - bent.theta[0]), again.delay - bent.delay),
    )
    return _Channels(
        lag, bent.std(-1) / abs(lag), values, [bent.std(place) for place in places], changed
    )


def _without_filter(rung: Rung, narrower: Rung, *, sought: bool) -> _Channels:
    """Return the estimates without a visible filter: the prior of a filter and the rows, combined."""
    # Use the lower cut-off, because noise looks like a filter that grows with the cut-off.
    plain, free, other = rung.plain, rung.free, narrower.plain
    std = narrower.free.std(-1)
    share = FILTER**2 / (FILTER**2 + std**2)
    c, unknown = share * narrower.free.c, math.hypot(share * std, (1.0 - share) * FILTER)
    slopes = [float(free.theta[0] - plain.theta[0]), free.delay - plain.delay]
    slopes = [slope / free.c if free.c else 0.0 for slope in slopes]
    places = (0, plain.theta.size)[: 1 + sought]
    errors = [
        math.hypot(plain.std(place), slope * unknown)
        for place, slope in zip(places, slopes, strict=False)
    ]
    values = (float(plain.theta[0]) + slopes[0] * c, plain.delay + slopes[1] * c)
    return _Channels(
        None,
        0.0,
        values,
        errors,
        (float(other.theta[0] - plain.theta[0]), other.delay - plain.delay),
    )
