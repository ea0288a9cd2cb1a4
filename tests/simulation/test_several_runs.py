"""Several runs of a variant as one, with means and standard deviations; where the loop of a log begins."""

from dataclasses import asdict

import numpy as np
import pytest

from bristle.core.status import Status
from bristle.simulation.result import VariantResult, mean_result
from bristle.simulation.statistics import statistics_of

NAMES = ("time", "reference", "measured", "position", "velocity", "command", "effort", "feedforward", "friction")


def run(scale, status=Status.OK):
    """Return a run whose errors, efforts and trials are in proportion to a scale."""
    error = statistics_of(scale * np.array([1.0, -2.0, 0.5]))
    numbers = {"following_error": error, "true_error": error, "by_direction": {"forward": error, "backward": error}}
    signals = dict.fromkeys(NAMES, np.zeros(3))
    return VariantResult(
        "base", **numbers, effort_rms=scale, effort_peak=2.0 * scale, **signals, status=status, trials=(3.0 * scale, scale), motion=error
    )


def test_numbers_are_means_over_the_runs_with_their_standard_deviation():
    scales = np.array([1.0, 2.0, 6.0])
    result = mean_result([run(scale) for scale in scales])
    assert result.runs == 3
    assert result.trials == pytest.approx((9.0, 3.0))
    assert (result.effort_rms, result.effort_peak) == pytest.approx((3.0, 6.0))
    assert asdict(result.following_error) == pytest.approx(asdict(run(3.0).following_error))
    deviation, error = float(np.std(scales, ddof=1)), asdict(run(1.0).following_error)
    assert result.spread["effort"] == pytest.approx({"rms": deviation, "peak": 2.0 * deviation})
    assert result.spread["by_direction"]["forward"] == pytest.approx({name: abs(value) * deviation for name, value in error.items()})
    assert result.as_dict()["effort"]["rms_spread"] == pytest.approx(deviation)


def test_a_diverged_run_represents_all_runs():
    diverged = run(2.0, Status.NOT_FINITE)
    result = mean_result([run(1.0), diverged, run(3.0)])
    assert (result.status, result.runs, result.effort_rms) == (Status.NOT_FINITE, 3, 2.0)
