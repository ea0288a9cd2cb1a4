"""Waves over the position are found between whole turns over the range, and in a reversing force."""

import numpy as np
import pytest

from bristle.logs.waves import frequency_in, refined, waves

TURNS = 7.38  # over the range


@pytest.fixture(scope="module")
def passes():
    """Position and direction of some strokes, slower near their ends."""
    time = np.linspace(0.0, 12.0 * np.pi, 6000)
    x = 0.1 * np.cos(time)
    return x, np.where(np.gradient(x) < 0.0, -1.0, 1.0)


@pytest.mark.parametrize("odd", [False, True])
def test_a_wave_between_whole_turns_is_found_with_and_without_direction(passes, odd):
    x, side = passes
    frequency = TURNS / np.ptp(x)
    wave = (side if odd else 1.0) * np.sin(2.0 * np.pi * frequency * x + 0.4)
    noise = 0.3 * np.random.default_rng(3).standard_normal(x.size)
    assert frequency_in(x, side, wave + noise, 100.0) == pytest.approx(frequency, rel=0.006)


def test_the_frequency_of_a_wave_is_refined(passes):
    x, side = passes
    frequency = TURNS / np.ptp(x)
    wave = np.sin(2.0 * np.pi * frequency * x + 0.4) + 0.05 * np.random.default_rng(3).standard_normal(x.size)
    coarse = frequency_in(x, side, wave, 100.0)
    fine = refined(x, side, wave, coarse)
    assert abs(fine - frequency) < 0.25 * abs(coarse - frequency)
    assert fine == pytest.approx(frequency, rel=5e-4)


def test_a_wave_is_sought_between_the_fewest_and_the_most_turns(passes):
    x, side = passes
    wave = np.sin(2.0 * np.pi * TURNS / np.ptp(x) * x)
    noise = 0.1 * np.random.default_rng(4).standard_normal(x.size)
    for most, least in ((TURNS - 2.0, 1.5), (100.0, TURNS + 2.0)):
        result = frequency_in(x, side, wave + noise, most, least) * np.ptp(x)
        assert least - 1.0 < result < most + 1.0
        assert abs(result - TURNS) > 1.0
    assert frequency_in(x, side, wave, 1.0) is None
    assert frequency_in(0.0 * x, side, wave, 100.0) is None


def test_the_stronger_of_two_waves_in_the_range_is_found(passes):
    x, side = passes
    turns = 2.0 * np.pi / np.ptp(x) * x
    noise = 0.05 * np.random.default_rng(5).standard_normal(x.size)
    strong, weak = np.sin(30.3 * turns), 0.7 * np.sin(6.2 * turns)
    assert frequency_in(x, side, strong + weak + noise, 60.0) * np.ptp(x) == pytest.approx(30.3, abs=0.1)
    assert frequency_in(x, side, strong + weak + noise, 20.0) * np.ptp(x) == pytest.approx(6.2, abs=0.1)
    # Whatever the unit of the effort is.
    small = 1e-9 * (strong + weak + noise)
    assert frequency_in(x, side, small, 20.0) * np.ptp(x) == pytest.approx(6.2, abs=0.1)
    assert frequency_in(x, side, small, 60.0, 12.0) * np.ptp(x) == pytest.approx(30.3, abs=0.1)


def test_waves_are_cosine_and_sine_alone_and_with_the_direction():
    x, side = np.array([0.0, 0.25, 0.5]), np.array([1.0, -1.0, -1.0])
    expected = [[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, -1.0], [-1.0, 0.0, 1.0, 0.0]]
    np.testing.assert_allclose(waves(x, side, 1.0), expected, atol=1e-12)
