"""The intervals of the best model; a model whose intervals fail gives way to the next."""

from collections.abc import Callable, Container
from time import perf_counter
from typing import NamedTuple

from bristle.core.cores import core_count
from bristle.core.errors import InputError
from bristle.identification.axis_lines import Pairs
from bristle.identification.estimation import Context, Estimation
from bristle.identification.observed_fit import foreseen
from bristle.identification.observer import MOST, observable
from bristle.identification.result import Fit
from bristle.identification.settings import Settings
from bristle.identification.simulated_bands import with_loops, within_the_log
from bristle.identification.uncertainty import with_uncertainty
from bristle.identification.work import Work

WITHOUT_DRAWS = "interrupted: intervals from simulated logs are missing"
WITHOUT_OBSERVER = "interrupted: the parameters are those of inverse dynamics"
# Of the residual: a fit to a draw, fits beside the draws, and the observers.
EVALUATIONS, REFITS, CLIMBING = (8.5, 104, 3000.0)
NUMERIC = (ArithmeticError, ValueError)
"""Errors of a computation with numbers, such as those of a model that diverges or of a singular matrix."""


class Passed(NamedTuple):
    """The fits of all models to logs with their axes, the best first, without intervals."""

    fits: list[Fit]
    estimations: dict[str, Estimation]
    left_out: dict[str, str]
    unfinished: str
    interrupted: bool
    context: Context
    pairs: Pairs
    judged: Callable[[Container[str]], list[Fit]]  # the same fits, without some models


def durations_of(passed: Passed, draws: int, pairs: Pairs) -> tuple[float, float]:
    """Return the durations of the fits to draws and of the observers, if they follow, from the duration of one residual [s]."""
    estimation = passed.estimations[passed.fits[0].name]
    (problem, solution), begun = estimation.resampled, perf_counter()
    problem.residual(solution.values)
    once, samples = (
        perf_counter() - begun,
        sum(segment.time.size for segment in problem.dataset.segments),
    )
    climbs = CLIMBING * (
        is_observed(passed, pairs) and observable(estimation.inverse, estimation.solution.values)
    )
    return EVALUATIONS * (draws + REFITS) * once / core_count(), climbs * min(
        MOST / samples, 1.0
    ) * once


def is_observed(passed: Passed, pairs: Pairs) -> bool:
    """Return whether observers follow the fits."""
    # An observer moves one mass: of an elastic axis, the fit in the low band remains.
    return passed.context.coupling is None and all(
        axis is None or axis.method == "prediction_error" for _, axis in pairs
    )


def with_intervals(
    passed: Passed, draws: int, settings: Settings, pairs: Pairs, work: Work
) -> tuple[Passed, str]:
    """Return a pass whose best fit has intervals, and a remark about interrupted work; InputError if the last model fails."""
    while True:
        (best, *rest), remark = passed.fits, ""
        estimation = passed.estimations[best.name]
        drawing, work.ahead = durations_of(passed, draws, pairs)
        try:
            best = with_uncertainty(
                best,
                estimation,
                draws,
                settings,
                work.task(f"fitting {best.name} to simulated logs", drawing),
            )
            if is_observed(passed, pairs):
                report = work.task(f"predicting the log with {best.name}", work.ahead)
                work.ahead = 0.0
                component = estimation.inverse.parameters.component
                logs = [log for log, _ in passed.pairs]
                if passed.context.beside is not None:
                    logs = passed.context.beside.logs_for(component)
                best = foreseen(best, estimation, passed.context.of(component), logs, report)
            best = with_loops(within_the_log(best, passed.context.dataset), passed.pairs)
        except KeyboardInterrupt:
            remark = WITHOUT_DRAWS if best.resampling is None else WITHOUT_OBSERVER
        except NUMERIC as error:
            if not rest:
                raise
            passed = _without_best(passed, error)
            continue
        return passed._replace(fits=[best, *rest]), remark


def _without_best(passed: Passed, error: Exception) -> Passed:
    """Return a pass without its best fit, whose intervals failed with this error."""
    failed = passed.fits[0]
    left_out = passed.left_out | {
        failed.name: f"its intervals from simulated logs failed: {message_of(error)}"
    }
    best, *rest = passed.judged(left_out)
    return passed._replace(fits=[best, *rest], left_out=left_out)


def message_of(error: Exception) -> str:
    """Return the message of an error, as the reason for an omitted model."""
    return error.message if isinstance(error, InputError) else str(error)
