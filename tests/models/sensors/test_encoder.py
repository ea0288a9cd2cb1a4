"""An encoder: whole counts, what noise does before it counts, and where numbers hold no smaller count."""

import math

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.core.random_numbers import SEED_MAX, normal
from bristle.models.sensors import encoder, torque_seen


def read(x, number=0, **values):
    """Return what an encoder reads at a sample, and the number of the next one."""
    component, p = encoder, encoder(**values).parameters
    measured, state = component.step(component.State(number), x, 1e-3, p)
    return measured, state.samples


@pytest.mark.parametrize(
    ("x", "counts"),
    [
        (0.0, 0),
        (0.49, 0),
        (0.5, 1),
        (1.49, 1),
        (1.5, 2),
        (-0.5, 0),
        (-0.51, -1),
        (-1.5, -1),
        (-1.51, -2),
        (1e6 + 0.6, 1_000_001),
    ],
)
def test_a_position_is_rounded_to_the_nearest_count_and_half_a_count_upward(x, counts):
    assert read(0.25 * x, resolution=0.25) == (0.25 * counts, 1)


def test_an_encoder_with_defaults_reads_the_exact_position():
    assert dict(encoder.defaults) == {"resolution": 0.0, "noise": 0.0, "seed": 0}
    assert read(0.123456789, 4) == (0.123456789, 5)


def test_noise_is_added_before_counting_and_belongs_to_the_seed_and_the_sample():
    drawn = [normal(7, number) for number in range(3)]
    assert [read(1.0, number, noise=0.1, seed=7)[0] for number in range(3)] == [
        1.0 + 0.1 * part for part in drawn
    ]
    counted = [read(1.0, number, noise=10.0, seed=7, resolution=0.5)[0] for number in range(3)]
    assert counted == [0.5 * math.floor((1.0 + 10.0 * part) / 0.5 + 0.5) for part in drawn]


def test_positions_beyond_whole_counts_are_read_unchanged():
    # From 2^52 counts on; to an odd one of these half a count could not be added any more.
    for counts in (2.0**52, 2.0**52 + 1.0, -(2.0**52) - 1.0, 2.0**53 + 2.0, 2.0**62):
        assert read(0.25 * counts, resolution=0.25)[0] == 0.25 * counts
    assert read(0.25 * (2.0**51 + 0.5), resolution=0.25)[0] == 0.25 * (2.0**51 + 1.0)
    assert read(1e300, resolution=1e-9)[0] == 1e300


@pytest.mark.parametrize(
    ("name", "ends", "beyond"),
    [
        ("resolution", (0.0, 1.0), (-1e-9,)),
        ("noise", (0.0, 1.0), (-1e-9,)),
        ("seed", (0, SEED_MAX), (-1, SEED_MAX + 1)),
    ],
)
def test_counts_noise_and_seed_are_not_negative(name, ends, beyond):
    assert [encoder(**{name: value}).values[name] for value in ends] == list(ends)
    for value in beyond:
        with pytest.raises(InputError, match=name):
            encoder(**{name: value})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"velocity": np.ones(4)},
            r"velocity: must have as many samples as effort.*allowed 3 samples",
        ),
        ({"dt": 0.0}, "dt"),
        ({"J_m": -1e-9}, "J_m"),
    ],
)
def test_torque_needs_effort_and_velocity_of_equal_length(changes, words):
    supplied = {
        "effort": np.array([1.0, 2.0, 3.0]),
        "velocity": np.array([0.0, 0.5, 0.25]),
        "dt": 0.1,
        "J_m": 0.2,
    }
    assert torque_seen(**supplied).tolist() == pytest.approx([0.0, 2.5])
    assert torque_seen(**supplied | {"J_m": 0.0}).tolist() == [1.0, 2.0]
    with pytest.raises(InputError, match=words):
        torque_seen(**supplied | changes)
