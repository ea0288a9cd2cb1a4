"""Half-cycles are where the body turns, not where noise or a step of the encoder does."""

import numpy as np
import pytest
from tests.identification.known_logs import Motion, log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.identification.half_cycles import HalfCycles, scatter_seen, within_cycles
from bristle.identification.preprocessing import treat

DT = 1e-3


def cycles_of(motion, step=0.0, noise=0.0):
    shaken = motion._replace(position=motion.position + noise * np.random.default_rng(2).normal(size=motion.time.size))
    log = log_of(shaken, sliding_effort(motion), step=step)
    return HalfCycles(treat(log, Axis(resolution=step or None), 50.0, 5))


@pytest.mark.parametrize(("step", "noise"), [(0.0, 0.0), (1e-5, 0.0), (0.0, 2e-6)])
def test_every_turn_of_a_sine_is_one(step, noise):
    cycles = cycles_of(sines(10.0, DT, (0.01,), (0.5,), (0.0,)), step, noise)
    # Ten turns in ten seconds, the first quarter of a second before the first one.
    assert len(cycles.starts[0]) == 11
    turns = DT * np.array(cycles.starts[0][1:])
    np.testing.assert_allclose(turns, 0.5 + np.arange(10), atol=0.02)


def test_a_rest_in_noise_is_no_turn():
    t = DT * np.arange(6000)
    there = np.clip(t - 1.0, 0.0, 1.0) - np.clip(t - 4.0, 0.0, 1.0)
    motion = Motion(t, 0.01 * there, np.gradient(0.01 * there, DT), np.zeros(t.size))
    assert len(cycles_of(motion, step=1e-6, noise=1e-6).starts[0]) == 2


def test_sums_over_half_cycles_are_sums_of_their_rows():
    cycles = cycles_of(sines())
    rows = np.random.default_rng(0).normal(size=(cycles.dataset.effort.size, 2))
    sums = cycles.groups.summed(rows)
    assert sums.shape == (cycles.groups.count, 2)
    for number, index in enumerate(np.unique(cycles.groups.of_rows)):
        np.testing.assert_allclose(sums[number], rows[cycles.groups.of_rows == index].sum(axis=0))


def test_a_known_scatter_is_seen_with_the_spread_of_chi_square_though_one_stroke_is_long():
    t = DT * np.arange(12_000)
    # One long stroke, then many short ones.
    x = np.where(t < 4.0, 0.01 * (1.0 - t / 4.0), 0.01 * 0.02 * np.abs((t - 4.0) / 0.4 % 1.0 * 2.0 - 1.0))
    cycles = cycles_of(Motion(t, x, np.gradient(x, DT), np.zeros(t.size)))
    rng, slope = np.random.default_rng(8), np.sign(cycles.dataset.velocity)
    rows = np.bincount(cycles.groups.index)
    assert rows.max() > 5.0 * np.median(rows)
    assert rows.size > 20
    noise = 0.01 * rng.standard_normal((400, slope.size))
    levels = 0.05 * rng.standard_normal((400, rows.size))
    seen = np.array([scatter_seen(cycles.groups, slope, level[cycles.groups.index] * slope + one)
                     for level, one in zip(levels, noise, strict=True)])  # fmt: skip
    assert np.sqrt(np.mean(seen**2)) == pytest.approx(0.05, rel=0.03)
    assert np.std(seen) / np.mean(seen) == pytest.approx((2.0 * rows.size) ** -0.5, rel=0.15)


def test_what_is_left_within_half_cycles_has_no_level():
    cycles = cycles_of(sines())
    residual = np.random.default_rng(1).normal(size=(2, cycles.dataset.effort.size))
    left = within_cycles(cycles.groups, residual[0], residual[1])
    np.testing.assert_allclose(cycles.groups.summed(left * residual[0]), 0.0, atol=1e-9)
