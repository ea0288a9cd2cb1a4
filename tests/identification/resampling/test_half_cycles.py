"""Half-cycles start at reversals of the body, not of noise or encoder steps."""

import numpy as np
import pytest
from tests.identification.known_logs import Motion, log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.identification.half_cycles import Groups, half_cycle_starts, half_cycles, scatter_in
from bristle.identification.preprocessing import treat

DT = 1e-3


def treated(motion, step=0.0, noise=0.0):
    shaken = motion._replace(position=motion.position + noise * np.random.default_rng(2).normal(size=motion.time.size))
    return treat(log_of(shaken, sliding_effort(motion), step=step), Axis(resolution=step or None), 50.0, 5)


@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.0), (1e-5, 0.0), (0.0, 2e-6)])
def test_each_reversal_of_a_sine_begins_a_half_cycle(step, noise):
    dataset = treated(sines(10.0, DT, (0.01,), (0.5,), (0.0,)), step, noise)
    (starts,) = half_cycle_starts(dataset)
    # Ten turns in ten seconds, the first half of a second before the first one.
    assert len(starts) == half_cycles(dataset).count == 11
    np.testing.assert_allclose(DT * np.array(starts[1:]), 0.5 + np.arange(10), atol=0.02)
    # No row belongs to a half-cycle with another one that goes the other way.
    for velocity in np.split(dataset.velocity, half_cycles(dataset).first[1:]):
        assert abs(np.sum(np.sign(velocity))) >= velocity.size - 2


def test_a_rest_in_noise_is_not_a_reversal():
    t = DT * np.arange(6000)
    present = np.clip(t - 1.0, 0.0, 1.0) - np.clip(t - 4.0, 0.0, 1.0)
    motion = Motion(t, 0.01 * present, np.gradient(0.01 * present, DT), np.zeros(t.size))
    assert len(half_cycle_starts(treated(motion, step=1e-6, noise=1e-6))[0]) == 2


def test_a_known_scatter_is_recovered_despite_one_long_stroke():
    t = DT * np.arange(12_000)
    # One long stroke, then many short ones.
    x = np.where(t < 4.0, 0.01 * (1.0 - t / 4.0), 0.01 * 0.02 * np.abs((t - 4.0) / 0.4 % 1.0 * 2.0 - 1.0))
    dataset = treated(Motion(t, x, np.gradient(x, DT), np.zeros(t.size)))
    rng, slope, cycles = np.random.default_rng(8), np.sign(dataset.velocity), half_cycles(dataset)
    rows = np.bincount(cycles.index)
    assert rows.max() > 5.0 * np.median(rows)
    assert rows.size > 20
    noise = 0.01 * rng.standard_normal((400, slope.size))
    levels = 0.05 * rng.standard_normal((400, rows.size))
    seen = np.array([scatter_in(cycles, slope, level[cycles.index] * slope + item) for level, item in zip(levels, noise, strict=True)])
    assert np.sqrt(np.mean(seen**2)) == pytest.approx(0.05, rel=0.03)
    assert np.std(seen) / np.mean(seen) == pytest.approx((2.0 * rows.size) ** -0.5, rel=0.15)


@pytest.mark.parametrize("scatter", [0.0, 0.1])
def test_a_motion_that_reverses_at_once_shows_no_level(scatter):
    # An axis that rings where it stops: after each stroke of 60 rows, three turns of 2 rows, wrong by their filter.
    rng, sizes = np.random.default_rng(1), np.tile([60, 2, 2, 2], 24)
    groups = Groups(np.repeat(np.arange(sizes.size), sizes))
    slope = np.where(groups.of_rows % 2, -9.0, 9.0)
    short = np.repeat(sizes == 2, sizes)
    level = np.where(sizes == 60, scatter * rng.standard_normal(sizes.size), 0.0)[groups.of_rows]
    residual = level * slope + 0.02 * rng.standard_normal(slope.size)
    wrong = residual + short * 8.0 * rng.standard_normal(slope.size)
    assert scatter_in(groups, slope, wrong) == pytest.approx(scatter, rel=0.3, abs=0.03)
    # Where all turn back as soon, they are all that there is.
    assert scatter_in(Groups(np.arange(slope.size) // 2), slope, wrong) > 0.15
