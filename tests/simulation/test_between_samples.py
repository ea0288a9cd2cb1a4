"""An effort between its samples, and records that repeat themselves."""

import numpy as np
import pytest

from bristle.simulation.recorded.open_loop import closes, finer, period_of

RATE, SIZE = 750.0, 1500


def multisine(t: np.ndarray, seed: int = 0) -> np.ndarray:
    """Whole periods of 2 s, from 5 to 150 Hz."""
    lines = np.arange(10, 300)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, lines.size)
    return np.cos(np.pi * np.outer(t, lines) + phases).sum(axis=1)


def sweep(t: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * (20.0 * t + 5.0 * t * t))


SAMPLES = np.arange(SIZE) / RATE
BETWEEN = np.arange(4 * SIZE) / (4.0 * RATE)


def test_whole_periods_without_high_content_are_known_between_their_samples():
    np.testing.assert_allclose(finer(multisine(SAMPLES), 4, periodic=True), multisine(BETWEEN), atol=1e-9)


def test_a_record_that_does_not_repeat_is_known_but_for_its_ends():
    error = np.abs(finer(sweep(SAMPLES), 4, periodic=False) - sweep(BETWEEN))[:-3]
    assert np.max(error[400:-400]) < 1e-5
    assert np.max(error) < 5e-3
    # What rings where the ends are taken for neighbours.
    ringing = np.abs(finer(sweep(SAMPLES), 4, periodic=True) - sweep(BETWEEN))[:-3]
    assert np.max(ringing) > 3.0 * np.max(error)
    assert np.max(ringing[400:-400]) > 10.0 * np.max(error[400:-400])


@pytest.mark.parametrize("count", [2, 3, 5])
def test_equal_periods_are_found(count):
    t = np.arange(count * SIZE) / RATE
    assert period_of(np.tile(multisine(SAMPLES), count)) == SIZE
    assert period_of(multisine(t) + 1e-3 * np.random.default_rng(1).normal(size=t.size)) is None
    assert period_of(sweep(t)) is None


def test_a_constant_has_no_period():
    assert period_of(np.full(100, 3.0)) is None


@pytest.mark.fast_cases(15)
@pytest.mark.parametrize("seed", range(20))
def test_one_period_closes_and_a_part_of_one_does_not(seed):
    period = multisine(SAMPLES, seed)
    start = 37 * seed
    assert closes(np.roll(period, start))
    assert not closes(np.roll(period, start)[: SIZE - 211])
    assert not closes(sweep(SAMPLES[: SIZE - seed]))
