r"""Comparison of models of different size: by held-out error, and by information criteria.

.. math:: \mathrm{AIC} = n \ln\frac{\|r\|^2}{N} + 2 k, \qquad \mathrm{BIC} = n \ln\frac{\|r\|^2}{N} + k \ln n

over `N` rows and `k` free parameters [1]_. Correlated residuals are not `N` independent measurements but

.. math:: n = N\,\frac{1 - \rho}{1 + \rho}

with the correlation :math:`\rho` of neighbouring rows for the model with the smallest residual; with `N` the largest
model would always win. Both criteria treat the residual as noise. If all models lack a force, the held-out error is
the better criterion.

References
----------
.. [1] K. P. Burnham, D. R. Anderson, "Multimodel inference: understanding AIC and BIC in model selection",
   Sociological Methods & Research 33(2), 2004. doi:10.1177/0049124104268644
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from bristle.core.diagnostic import Diagnostic, HeldOut
from bristle.identification.estimation import Estimation
from bristle.identification.half_cycles import independent_rows
from bristle.identification.result import Fit, Information
from bristle.identification.settings import DEFAULT, Settings
from bristle.models.friction.slots import variations_of
from bristle.simulation.statistics import relative_error_percent

TOO_SHORT = Diagnostic("too_short")
PLACES = frozenset({"position", "periodic"})  # slots that depend on the position


def held_out_error(
    estimation: Estimation,
    blocks: int,
    settings: Settings,
    report: Callable[[float], None] = lambda share: None,
) -> HeldOut:
    """Return the error on each of several parts of a log, or on each log, fitted to all others."""
    name, folds = estimation.problem.folds(blocks, settings)
    measured, errors = estimation.problem.measured, []
    for number, fold in enumerate(folds):
        report(number / len(folds))
        errors.append(
            relative_error_percent(
                measured[fold.held_out],
                (measured - estimation.residual_without(fold.fitted))[fold.held_out],
            )
        )
    return HeldOut(tuple(errors), float(np.mean(errors)), float(np.std(errors, ddof=1)), name)


def in_order(fits: Sequence[Fit], settings: Settings = DEFAULT, spread: float = 0.0) -> list[Fit]:
    """Return fits to the same log, best first; `spread` is that between repetitions of one motion [%], else 0."""
    interrupted = [fit for fit in fits if fit.unfinished]
    finished = ranked([fit for fit in fits if not fit.unfinished], settings, spread)
    if not interrupted:
        return finished
    most = 0.7 * _error(finished[0]) if finished else 0.0
    ahead = [fit for fit in interrupted if fit.error_percent < most]
    return [*ahead, *finished, *(fit for fit in interrupted if fit.error_percent >= most)]


def ranked(fits: Sequence[Fit], settings: Settings = DEFAULT, spread: float = 0.0) -> list[Fit]:
    """Return the chosen fit, then all others by their held-out error; all fits have the same held-out blocks or no blocks."""
    # The smallest error leads. A leader gives way to a simpler model, within the spread of its error over the blocks, if the
    # log does not identify half or more of its parameters. If a log repeats one motion, a model that varies along the axis
    # follows every repeating force: it gives way to one with fewer slots of the position, within the `spread` between
    # repeats. The choice is the simplest model whose error exceeds that of the leader by no more than the standard error of
    # their difference.
    if not fits:
        return []
    leader = min(fits, key=_error)
    if _doubtful(leader, settings):
        scatter = leader.held_out.std_percent if leader.held_out else 0.0
        sound = (
            fit
            for fit in fits
            if not _doubtful(fit, settings)
            and _size(fit) < _size(leader)
            and _error(fit) <= _error(leader) + scatter
        )
        leader = min(sound, key=_error, default=leader)
    if spread > 0.0:
        plainer = (
            fit
            for fit in fits
            if _by_place(fit) < _by_place(leader)
            and _doubtful(fit, settings) <= _doubtful(leader, settings)
            and _error(fit) <= _error(leader) + spread
        )
        leader = min(plainer, key=_error, default=leader)
    no_worse = list[Fit]()
    for fit in fits:
        difference, margin = _error(fit) - _error(leader), settings.same_error * _error(leader)
        if fit.held_out is not None and leader.held_out is not None:
            difference, error = fit.held_out.above(leader.held_out)
            margin = max(margin, error)
        if _doubtful(fit, settings) <= _doubtful(leader, settings) and difference <= margin:
            no_worse.append(fit)
    chosen = min(no_worse, key=lambda fit: (_size(fit), _error(fit)))
    return [chosen, *sorted((fit for fit in fits if fit is not chosen), key=_error)]


def _by_place(fit: Fit) -> frozenset[str]:
    """Return the slots with a dependence on the position."""
    return PLACES.intersection(variations_of(fit.friction.component))


def _error(fit: Fit) -> float:
    return fit.held_out.mean_percent if fit.held_out is not None else fit.error_percent


def _size(fit: Fit) -> int:
    return len(fit.correlation_names) + fit.further


def _doubtful(fit: Fit, settings: Settings) -> bool:
    """Return whether too many of the free parameters are not identified."""
    unsure = [
        estimate.status != "identified" for estimate in fit.estimates if estimate.status != "held"
    ]
    return bool(unsure) and sum(unsure) >= settings.doubtful_share * len(unsure)


def with_information(fits: Sequence[Fit]) -> list[Fit]:
    """Return fits to the same rows with their information criteria, as differences from the smallest values."""
    sums = list[float]()
    for fit in fits:
        # The minimised error, as if each row had the mean square of the samples.
        simulated, residual = (
            fit.position_rmse if fit.loop_rmse is None else fit.loop_rmse,
            fit.traces.residual,
        )
        sums.append(
            float(residual @ residual) if simulated is None else residual.size * simulated**2
        )
    squares = np.array(sums)
    if not np.all(squares > 0.0) or not fits:
        return list(fits)
    best = fits[int(np.argmin(squares))].traces.residual
    count = max(independent_rows(best), 10.0)  # measurements
    plain, sizes = count * np.log(squares / best.size), np.array(list(map(_size, fits)))
    criteria = np.stack([plain + 2.0 * sizes, plain + sizes * np.log(count)])
    differences = criteria - criteria.min(axis=1, keepdims=True)
    return [
        replace(fit, information=Information(aic, bic, count))
        for fit, (aic, bic) in zip(fits, differences.T.tolist(), strict=True)
    ]
