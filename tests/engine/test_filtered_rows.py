"""Rows of derivatives: what the filters of a single signal make of each of them."""

import numpy as np
import pytest
from scipy.signal import resample_poly

from bristle.engine import interpreted
from bristle.engine.filtered_rows import filtered_rows
from bristle.identification.dataset import _taps
from bristle.logs.filters import butterworth, low_passed

DT, CUTOFF, DROPPED = 1e-3, 100.0, 37


def rows_of(signals, step):
    """The rows of signals, shape (sample, direction), each by the filters of scipy."""
    passed = low_passed(signals.T, CUTOFF, DT)[:, DROPPED : len(signals) - DROPPED]
    return passed.T if step == 1 else resample_poly(passed, 1, step, axis=1, window=_taps(step), padtype="edge").T


@pytest.mark.parametrize(("step", "directions", "compiled"), [(10, 8, True), (7, 3, True), (1, 11, True), (10, 9, False)])
def test_every_derivative_passes_the_filters_of_the_signal(step, directions, compiled):
    signals = np.cumsum(np.random.default_rng(1).standard_normal((901, directions)), axis=0)
    arguments = signals, *butterworth(CUTOFF, DT), DROPPED, step, _taps(step) if step > 1 else np.ones(1)
    if compiled:
        rows = filtered_rows(*arguments)
    else:
        with interpreted():
            rows = filtered_rows(*arguments)
    expected = rows_of(signals, step)
    assert rows.shape == expected.shape
    assert np.max(np.abs(rows - expected)) < 1e-13 * np.max(np.abs(expected))
