"""Rows of derivatives: what the filters of a single signal make of each of them."""

from contextlib import nullcontext
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import resample_poly

from bristle.core.tangent import DIRECTIONS
from bristle.engine import interpreted
from bristle.engine.filtered_rows import filtered_rows
from bristle.identification.dataset import _taps
from bristle.logs.filters import butterworth, low_passed

DT, CUTOFF, DROPPED = 1e-3, 100.0, 37


def rows_of(signals, step):
    """The rows of signals, shape (sample, direction), each by the filters of scipy."""
    passed = low_passed(signals.T, CUTOFF, DT)[:, DROPPED : len(signals) - DROPPED]
    return (
        passed.T
        if step == 1
        else resample_poly(passed, 1, step, axis=1, window=_taps(step), padtype="edge").T
    )


def blocks_of(signals, bounds):
    """A signal in parts, each of which is written where it is asked for."""
    for first, last in pairwise(bounds):
        yield last - first, partial(np.copyto, src=signals[first:last])


def filtered(signals, step, bounds):
    taps = _taps(step) if step > 1 else np.ones(1)
    return filtered_rows(
        blocks_of(signals, bounds), len(signals), *butterworth(CUTOFF, DT), DROPPED, step, taps
    )


@pytest.mark.parametrize(("step", "compiled"), [(10, True), (7, True), (1, True), (10, False)])
def test_every_derivative_passes_the_filters_of_the_signal(step, compiled):
    signals = np.cumsum(np.random.default_rng(1).standard_normal((901, DIRECTIONS)), axis=0)
    with nullcontext() if compiled else interpreted():
        rows = filtered(signals, step, (0, 901))
    expected = rows_of(signals, step)
    assert rows.shape == expected.shape
    assert np.max(np.abs(rows - expected)) < 1e-13 * np.max(np.abs(expected))


@pytest.mark.parametrize(
    "bounds",
    [(0, 1000, 2000, 3000), (0, 40, 2960, 3000), (0, 1500, 1560, 3000), (0, *range(50, 3001, 50))],
)
@pytest.mark.parametrize("step", [1, 10])
def test_the_rows_of_a_log_in_blocks_are_those_of_the_log(step, bounds):
    signals = np.cumsum(np.random.default_rng(2).standard_normal((3000, DIRECTIONS)), axis=0)
    at_once, in_blocks = (filtered(signals, step, parts) for parts in ((0, 3000), bounds))
    assert in_blocks.shape == at_once.shape
    assert np.max(np.abs(in_blocks - at_once)) < 1e-13 * np.max(np.abs(at_once))
