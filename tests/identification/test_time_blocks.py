"""Held-out parts: a stretch of the log, or short stretches if each part is a separate experiment."""

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort, sliding_log

from bristle.identification import identify
from bristle.identification.half_cycles import SHORT, TIME, beside, time_blocks
from bristle.identification.preprocessing import treat

pytestmark = pytest.mark.usefixtures("of_one_mass")


def designed_log():
    """Slow motion first, fast motion at the end, as in a log of several experiments."""
    slow = sines(16.0, amplitudes=(2e-3, 1e-3), frequencies=(0.4, 1.1), phases=(0, 1))
    fast = sines(4.0, amplitudes=(0.05, 0.01), frequencies=(1.0, 3.0), phases=(0, 1))
    parts = [np.concatenate([a, b]) for a, b in zip(slow, fast, strict=True)]
    parts[1][slow.time.size :] += slow.position[-1] - fast.position[0]
    motion = type(slow)(1e-3 * np.arange(parts[0].size), *parts[1:])
    return log_of(motion, sliding_effort(motion))


@pytest.mark.parametrize(("log", "what"), [(sliding_log(), TIME), (designed_log(), SHORT)])
@pytest.mark.parametrize("count", [3, 5])
def test_each_row_is_in_one_part_and_all_parts_have_equal_length(log, what, count):
    regression = treat(log, None)
    of, parts = time_blocks(regression, count)
    assert of == what
    assert np.all(np.sum(parts, axis=0) == 1)
    assert max(map(np.sum, parts)) < 1.3 * min(map(np.sum, parts))
    pieces = [int(np.sum(np.diff(part.astype(int), prepend=0) == 1)) for part in parts]
    assert min(pieces) == max(pieces) == 1 if what == TIME else min(pieces) > 3


def test_other_parts_reach_the_speeds_of_each_short_part():
    regression = treat(designed_log(), None)
    speed = np.abs(regression.velocity)
    for part in time_blocks(regression, 5)[1]:
        assert np.max(speed[~part]) > 0.9 * np.max(speed[part])
    assert np.max(speed[:1500]) < 0.1 * np.max(speed[1700:]), "in contiguous blocks it would be another matter"


def test_rows_that_share_samples_with_a_part_are_not_fitted():
    part = np.zeros(12, dtype=bool)
    part[[4, 5, 11]] = True
    assert np.flatnonzero(beside(part, 2)).tolist() == [0, 1, 8]
    assert np.flatnonzero(beside(part, 0)).tolist() == [0, 1, 2, 3, 6, 7, 8, 9, 10]
    assert not beside(part, 20).any()


@pytest.mark.slow
def test_speeds_of_a_single_part_are_spread_over_all_parts():
    identification = identify(designed_log(), "coulomb_viscous,coulomb", draws=20)
    assert identification.best.name == "coulomb_viscous"
    assert identification.best.held_out.of == SHORT
    assert identification.best.held_out.mean_percent < 1.5 * identification.best.force_error_percent
    assert identification.best.resampling.bands.inflation < 1.5
