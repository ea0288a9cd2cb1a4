"""Random numbers from a seed and a count: distributed as they should be, and the same however they are computed."""

import numpy as np
import pytest
from scipy import stats

from bristle import controllers, friction, sensors
from bristle.contract import example_of
from bristle.core.random_numbers import SEED_MAX, normal, uniform
from bristle.engine import interpreted, run_closed_loop
from bristle.models.plants import inertia

COUNT = 10_000


@pytest.mark.parametrize("seed", [0, 1, 12345, SEED_MAX])
def test_uniform_numbers_are_uniform_and_uncorrelated(seed):
    result = np.array([uniform(seed, k) for k in range(COUNT)])
    assert stats.kstest(result, "uniform").pvalue > 1e-3
    for lag in (1, 2, 7):
        assert abs(np.corrcoef(result[lag:], result[:-lag])[0, 1]) < 4.0 / np.sqrt(COUNT)
    cells = np.histogram2d(result[::2], result[1::2], bins=16)[0]
    assert stats.chisquare(cells.ravel()).pvalue > 1e-3


def test_normal_numbers_are_normal_and_neighbouring_seeds_are_independent():
    first, second = (np.array([normal(seed, k) for k in range(COUNT)]) for seed in (41, 42))
    assert stats.kstest(first, "norm").pvalue > 1e-3
    assert abs(np.corrcoef(first, second)[0, 1]) < 4.0 / np.sqrt(COUNT)
    assert abs(np.corrcoef(first[1:], second[:-1])[0, 1]) < 4.0 / np.sqrt(COUNT)


def test_counts_beyond_32_bits_continue():
    assert len({uniform(3, count) for count in (5, 5 + 2**32, 5 + 2**33)}) == 3


def record_of(seed):
    law = controllers.sliding_mode(J=2.0, lambda_=30.0, K_1=30.0, cutoff=100.0)
    encoder = sensors.encoder(resolution=1e-6, noise=3e-6, seed=seed)
    return run_closed_loop(
        inertia(M=2.0), example_of(friction.lugre), law, encoder, np.zeros((4, 150)), 1e-3
    ).measured


def test_a_seed_gives_the_same_record_compiled_or_not():
    compiled = record_of(7)
    with interpreted():
        plain, other = record_of(7), record_of(8)
    assert np.array_equal(compiled, plain)
    assert not np.array_equal(compiled, other)


def test_the_noise_of_an_encoder_has_the_given_size():
    encoder = sensors.encoder(noise=2e-6, seed=5)
    step, state = encoder.component.step, encoder.component.State
    read = [step(state(number), 1e-3, 1e-3, encoder.parameters)[0] for number in range(4000)]
    assert np.mean(read) == pytest.approx(1e-3, abs=4 * 2e-6 / np.sqrt(4000))
    assert np.std(read) == pytest.approx(2e-6, rel=0.05)
