"""Recovery of the unfiltered motion where it exceeds the encoder noise, and only there."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion, log_of, sines, strokes

from bristle.identification.half_cycles import FINER, between_samples, noise_density, recovered
from bristle.identification.preprocessing import treat

DT, NOISE = 1e-3, 2e-7


def rows_of(position, step=1e-9):
    velocity = np.gradient(position, DT)
    motion = Motion(DT * np.arange(position.size), position, velocity, np.gradient(velocity, DT))
    return treat(log_of(motion, velocity, step=step), STATED)


def noisy(position, seed=0):
    return position + np.random.default_rng(seed).normal(0.0, NOISE, position.size)


def triangle():
    """A motion that turns at once, every quarter of a second, and where it does."""
    time, turn = DT * np.arange(6000), 0.25
    beyond = np.abs(np.mod(time + 0.5 * turn, turn) - 0.5 * turn)
    return 0.01 * np.abs(np.mod(time / turn, 2.0) - 1.0), beyond


@pytest.fixture(scope="module")
def corners():
    position, beyond = triangle()
    rows = rows_of(noisy(position))
    (segment,) = rows.segments
    return position, beyond, segment, recovered(segment, rows)


def off(position, truth, where):
    return float(np.sqrt(np.mean((position - truth)[where] ** 2)))


def test_visible_corners_are_recovered(corners):
    truth, beyond, segment, motion = corners
    near = (beyond < 5e-3) & (segment.time > 0.1) & (segment.time < 5.9)
    assert off(segment.position, truth, near) > 20.0 * NOISE
    assert off(motion.segment.position, truth, near) < 0.5 * off(segment.position, truth, near)
    assert np.min(motion.visible[near]) == 1.0


def test_elsewhere_a_motion_is_as_smooth_as_filtered(corners):
    truth, beyond, segment, motion = corners
    far = (beyond > 0.06) & (segment.time > 0.2) & (segment.time < 5.8)
    assert np.max(motion.visible[far]) == 0.0
    assert off(motion.segment.position, truth, far) < 1.3 * off(segment.position, truth, far)
    assert np.std(np.diff(motion.segment.velocity)[far[1:]]) < 1.5 * np.std(np.diff(segment.velocity)[far[1:]])


def test_the_velocity_is_that_of_the_position_and_zero_at_rest():
    rows = rows_of(noisy(strokes().position))
    segment = replace(rows.segments[0], velocity=np.where(strokes().velocity == 0.0, 0.0, rows.segments[0].velocity))
    motion = recovered(segment, rows).segment
    moves = segment.velocity != 0.0
    assert 0.3 < np.mean(moves) < 0.7
    assert np.all(motion.velocity[~moves] == 0.0)
    inner = moves & (np.arange(moves.size) > 5) & (np.arange(moves.size) < moves.size - 5)
    assert np.corrcoef(motion.velocity[inner], np.gradient(motion.position, DT)[inner])[0, 1] > 0.999


def test_hidden_corners_are_as_sharp_as_in_the_filtered_motion():
    triangles, beyond = triangle()
    truth = 0.01 * triangles
    rows = rows_of(noisy(truth))
    (segment,) = rows.segments
    motion = recovered(segment, rows)
    hidden = (beyond < 1e-9) & (motion.visible < 0.1)
    hidden[:200] = hidden[-200:] = False
    outwards = np.sign(truth - np.mean(truth))
    taken, left = (np.mean((outwards * (truth - item.position))[hidden]) for item in (segment, motion.segment))
    assert taken > 1e-7
    assert 0.75 * taken < left < 0.9 * taken


def test_noise_alone_is_not_a_corner():
    shown = []
    for seed in range(5):
        rows = rows_of(noisy(sines(6.0, DT).position, seed))
        shown.append(np.mean(recovered(rows.segments[0], rows).visible))
    assert np.mean(shown) < 0.02


def test_a_corner_of_a_few_times_the_noise_is_visible():
    # What the filter takes of one is 1.5 and 15 standard deviations of the noise.
    position, beyond = triangle()
    seen = []
    for size in (0.01, 0.1):
        rows = rows_of(noisy(size * position))
        seen.append(np.mean(recovered(rows.segments[0], rows).visible[beyond < 2e-3]))
    assert seen[0] < 0.3
    assert seen[1] > 0.9


@pytest.mark.parametrize("size", [2e-7, 5e-6])
def test_the_noise_of_an_encoder_is_separated_from_the_motion(size):
    position = sines(6.0, DT).position + np.random.default_rng(2).normal(0.0, size, 6000)
    assert noise_density(position, 0.0, DT) == pytest.approx(2.0 * DT * size**2, rel=0.15)


def test_noise_is_at_least_that_of_rounding():
    step = 1e-5
    rounding = np.random.default_rng(3).uniform(-0.5 * step, 0.5 * step, 6000)
    assert noise_density(rounding, 0.0, DT) == pytest.approx(noise_density(np.zeros(6000), step, DT), rel=0.15)


def test_a_motion_between_samples_is_interpolated():
    rows = rows_of(sines(6.0, DT).position)
    (segment,) = rows.segments
    fine = between_samples(segment, DT)
    exact = sines(6.0, DT / FINER)
    inner = slice(100 * FINER, 5900 * FINER)
    np.testing.assert_allclose(fine.time[inner], exact.time[inner], atol=1e-9)
    np.testing.assert_allclose(fine.position[inner], exact.position[inner], atol=2e-8)  # means over a step
    np.testing.assert_allclose(fine.velocity[inner], exact.velocity[inner], atol=2e-4)
    np.testing.assert_array_equal(fine.effort[::FINER], segment.effort)
