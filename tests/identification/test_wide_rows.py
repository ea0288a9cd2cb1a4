"""Equations after wide and narrow filters: inertia, delay and filter of a channel, with their errors."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.core.axis import Axis, Cogging
from bristle.identification.wide_rows import InstrumentFit, wide_rows
from bristle.logs.filters import through_filter

DT = 2e-3
FAST = {"amplitudes": (0.02, 0.008, 0.004), "frequencies": (0.9, 2.7, 7.1)}
MOTION = sines(12.0, DT, **FAST)
EFFORT = sliding_effort(MOTION, noise=0.0)


def rows_of(effort=EFFORT, motion=MOTION, axis=None, step=0.0):
    return wide_rows([log_of(motion, effort, step=step)], [axis])


@pytest.fixture(scope="module")
def rows():
    return rows_of()


def test_rows_are_as_wide_as_noise_of_the_speed_permits(rows):
    assert rows.width == pytest.approx(100.0)  # a fifth of the sampling frequency
    assert rows.step == pytest.approx(DT)
    assert rows_of(step=2e-6).width == pytest.approx(100.0)
    coarse = rows_of(step=2e-4)
    assert (coarse.width, coarse.step) == (pytest.approx(50.0), pytest.approx(2.0 * DT))
    slow = sines(12.0, 2e-4, **FAST)
    assert rows_of(sliding_effort(slow, noise=0.0), slow).width == pytest.approx(250.0)
    short = sines(1.9, DT, **FAST)
    assert rows_of(sliding_effort(short, noise=0.0), short) is None


def test_rows_are_no_narrower_than_a_fortieth_of_the_sampling_frequency():
    long = sines(40.0, DT, **FAST)
    coarsest = rows_of(sliding_effort(long, noise=0.0), long, step=2e-3)
    assert (coarsest.width, coarsest.step) == (pytest.approx(12.5), pytest.approx(10.0 * DT))
    quick = sines(2.5, 5e-5, **FAST)  # where that is beyond 250 Hz, it is the width
    assert rows_of(sliding_effort(quick, noise=0.0), quick).width == pytest.approx(500.0)


def test_the_inertia_is_that_of_the_axis_at_every_cutoff(rows):
    for cutoff in (10.0, 20.0, 40.0):
        fit = rows.fit(cutoff, 0.0, free=(True, False))
        assert fit.theta[0] == pytest.approx(12.0, rel=2e-3)
        assert abs(fit.delay) < 5e-5
        assert fit.converged
        assert fit.cutoff == cutoff
    assert rows.fit(20.0, 0.0, free=(False, False)).delay == 0.0


@pytest.mark.parametrize("delay", [0.005, -0.003])
def test_a_delay_of_the_effort_is_found_from_a_rough_scan(delay):
    late = np.interp(MOTION.time - delay, MOTION.time, EFFORT)
    result = rows_of(late)
    rough = result.scanned()
    assert rough == pytest.approx(delay, abs=1.1e-3)
    fit = result.fit(20.0, rough, free=(True, False))
    assert fit.delay == pytest.approx(delay, abs=1e-4)
    assert fit.theta[0] == pytest.approx(12.0, rel=5e-3)


@pytest.mark.parametrize("lag", [0.004, -0.004])
def test_a_filter_of_the_effort_bends_it_by_half_of_its_square(lag):
    filtered = through_filter(EFFORT, lag, DT)
    fit = rows_of(filtered).fit(20.0, 0.0, free=(True, True))
    assert fit.c == pytest.approx(np.sign(lag) * 0.5 * lag**2, rel=0.25)
    plain = rows_of(EFFORT).fit(20.0, 0.0, free=(True, True))
    assert abs(plain.c) < 0.1 * abs(fit.c)


def test_a_real_filter_lowers_the_residual():
    filtered = rows_of(through_filter(EFFORT, 0.006, DT))
    bent = filtered.fit(20.0, 0.0, free=(True, True))
    lowered = filtered.lowered(bent, filtered.fit(20.0, 0.0, free=(True, False)).delay)
    assert lowered.shape == (20,)
    assert np.mean(lowered > 0.0) > 0.9
    plain = rows_of(EFFORT + 0.05 * np.random.default_rng(1).standard_normal(EFFORT.size))
    pretended = plain.fit(20.0, 0.0, free=(True, False))._replace(c=2e-5)
    assert np.sum(plain.lowered(pretended, 0.0)) < 0.0


def test_errors_are_those_of_a_jackknife():
    noises = [0.5 * np.random.default_rng(seed).standard_normal(EFFORT.size) for seed in range(12)]
    fits = [rows_of(EFFORT + noise).fit(20.0, 0.0, free=(False, False)) for noise in noises]
    scatter = float(np.std([fit.theta[0] for fit in fits]))
    assert np.mean([fit.std(0) for fit in fits]) == pytest.approx(scatter, rel=0.6)
    doubted = fits[0].doubted(3.0)
    assert doubted.std(0) == pytest.approx(3.0 * fits[0].std(0))
    assert isinstance(doubted, InstrumentFit)


def test_noise_of_the_position_biases_by_the_fifth_power_of_the_cutoff(rows):
    noisy = replace(rows, noise=1e-6, narrow={}, passed=None)
    low, high = (noisy.fit(cutoff, 0.0, free=(False, False)) for cutoff in (10.0, 20.0))
    assert high.bias / low.bias == pytest.approx(32.0, rel=0.35)
    quiet = replace(rows, noise=0.5e-6, narrow={}, passed=None).fit(20.0, 0.0, free=(False, False))
    assert high.bias == pytest.approx(4.0 * quiet.bias, rel=1e-6)


def test_a_single_sine_is_fully_springy_about_any_position(rows):
    sine = sines(12.0, DT, amplitudes=(0.02,), frequencies=(1.3,), phases=(0.3,))
    springy = rows_of(sliding_effort(sine, noise=0.0), sine)
    assert springy.springiness(20.0) > 0.98
    moved = sine._replace(position=sine.position + 5.0)
    assert rows_of(sliding_effort(sine, noise=0.0), moved).springiness(20.0) == pytest.approx(
        springy.springiness(20.0), abs=0.01
    )
    assert rows.springiness(20.0) < 0.8


def test_known_harmonics_and_gravity_of_an_axis_are_columns(rows):
    count = rows.stretches[0].columns.shape[0]
    cogging = Axis(cogging=(Cogging("motor", 0.01, (6, 12)),))
    assert rows_of(axis=cogging).stretches[0].columns.shape[0] == count + 4
    turning = log_of(MOTION, EFFORT, kind="rotational")
    arm = wide_rows([turning], [Axis(kind="rotational", gravity=True)])
    assert arm.stretches[0].columns.shape[0] == count + 2
    ahead = MOTION._replace(
        position=MOTION.position + 0.6 * MOTION.time, velocity=MOTION.velocity + 0.6
    )
    one_way = rows_of(12.0 * ahead.acceleration + 8.0, ahead)
    assert one_way.stretches[0].columns.shape[0] < count


@pytest.mark.parametrize("share", [0.03, 0.1, 0.3])
def test_friction_may_fall_over_three_shares_of_the_top_speed(share):
    top = np.quantile(np.abs(MOTION.velocity), 0.995)
    falling = rows_of(np.sign(MOTION.velocity) * np.exp(-np.abs(MOTION.velocity) / (share * top)))
    (stretch,) = falling.stretches
    effort, columns = stretch.weight * stretch.effort_at(0.0), (stretch.weight * stretch.columns).T
    left = effort - columns @ np.linalg.lstsq(columns, effort, rcond=None)[0]
    assert np.linalg.norm(left) < 1e-4 * np.linalg.norm(effort)


def test_rows_have_weight_from_a_twentieth_of_the_top_speed_and_full_from_three(rows):
    (stretch,) = rows.stretches
    share = np.abs(MOTION.velocity) / np.quantile(np.abs(MOTION.velocity), 0.995)
    assert np.all(stretch.weight[share < 0.045] == 0.0)
    # Half way
    assert np.max(stretch.weight[(share > 0.095) & (share < 0.105)]) == pytest.approx(0.5, abs=0.1)
    # Of a smooth rise.
    assert np.max(stretch.weight[(share > 0.12) & (share < 0.13)]) == pytest.approx(0.844, abs=0.08)
    assert np.median(stretch.weight[share > 0.16]) == pytest.approx(1.0)
    assert np.max(stretch.weight) == pytest.approx(1.0)
    assert np.all(stretch.weight[(MOTION.time < 0.49) | (MOTION.time > 12.0 - 0.49)] == 0.0)


def test_bias_of_the_inertia_by_noise_is_as_predicted(rows):
    noise = 1e-5 * np.random.default_rng(1).standard_normal(MOTION.time.size)
    noisy = rows_of(motion=MOTION._replace(position=MOTION.position + noise)).fit(
        60.0, 0.0, free=(False, False)
    )
    assert noisy.bias == pytest.approx(
        rows.fit(60.0, 0.0, free=(False, False)).theta[0] - noisy.theta[0], rel=0.3
    )


@pytest.mark.parametrize("side", [1.0, np.sign(MOTION.velocity)])
def test_waves_of_force_and_friction_in_the_residual_are_columns_and_noise_is_not(side):
    noise = 0.2 * np.random.default_rng(2).standard_normal(EFFORT.size)
    for size, shown in ((0.0, False), (3.0, True)):
        found = rows_of(
            EFFORT + noise + size * side * np.sin(2.0 * np.pi * MOTION.position / 0.004)
        )
        before = found.stretches[0].columns.shape[0]
        found.find_waves(0.0)
        assert (found.stretches[0].columns.shape[0] > before) is shown
