"""What one leg from rest tells of break-away, and what several tell by their rate: cases worked out by hand."""

import math

import numpy as np
import pytest

from bristle.logs import break_away
from bristle.logs.break_away import Recording
from bristle.logs.turns import Leg

REST, RISE, SLIDE = 100, 200, 300


def pull(side=1.0, before=-8.0, peak=10.0, level=8.0, noise=0.0, still=0):
    """A contact at rest with a force that a motion the other way left, which turns over in even steps and slides."""
    turning = np.concatenate([np.full(still, before), np.linspace(before, peak, RISE - still)])
    sliding = level + noise * np.resize([1.0, -1.0], SLIDE)
    force = np.concatenate([np.full(REST, before), turning, sliding])
    position = np.concatenate(
        [np.full(REST, 3.0), 3.0 + side * 1e-3 * np.arange(1.0, RISE + SLIDE + 1.0)]
    )
    time = 0.01 * np.arange(force.size)
    distance = float(position[-1] - position[REST])
    leg = Leg(
        REST,
        force.size - 1,
        distance,
        5.0,
        slice(REST + 20, force.size - 10),
        0.9,
        0.1,
        from_rest=True,
    )
    return leg, slice(0, REST), Recording(time, position, side * force)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_break_away_is_the_peak_force_and_the_distance_to_nine_tenths(side):
    result = break_away._measured(*pull(side), 1.0)
    assert (result.speed, result.side) == (0.1, side)
    assert result.force == pytest.approx(10.0)
    # Of even steps of a millimetre.
    assert result.distance == pytest.approx(0.9 * RISE * 1e-3, abs=2e-3)


def test_a_peak_within_three_deviations_of_the_sliding_force_is_noise():
    for peak, force in ((8.8, 8.0), (9.0, 9.0)):  # 0.9 is three times what the force scatters by
        assert break_away._measured(
            *pull(peak=peak, level=8.0, noise=0.3), 1.0
        ).force == pytest.approx(force, abs=0.01)


TURNED = round(0.8 * RISE)  # samples from a tenth of the change to nine tenths


@pytest.mark.parametrize(
    ("pulled", "filter_samples", "tells"),
    [
        # Half of the force from the opposite motion at least.
        *(
            ({"before": before}, 1.0, tells)
            for before, tells in (
                (-8.0, True),
                (-5.1, True),
                (-4.9, False),
                (0.0, False),
                (5.0, False),
            )
        ),
        # The contact turns more slowly than the filter.
        ({}, TURNED - 3.0, True),
        ({}, TURNED + 3.0, False),
        ({"still": 100}, TURNED - 3.0, False),
        # The force never pulls.
        ({"before": -8.0, "peak": -1.0, "level": -2.0}, 1.0, False),
    ],
)
def test_break_away_needs_a_slow_change_from_the_force_of_the_opposite_motion(
    pulled, filter_samples, tells
):
    assert (break_away._measured(*pull(**pulled), filter_samples) is not None) is tells


def legs(*facts):
    """Legs by speed and side."""
    return [break_away._Leg(speed, side, 1.0, 1.0) for speed, side in facts]


# Student's t of 2 degrees of freedom, of a deviation of 1
STUDENT = 2.0 ** (4.302653 / math.sqrt(3.0))


@pytest.mark.parametrize(
    ("sides", "values", "common", "estimate"),
    [
        # In logarithms to the base 2: 1, 3, 2.
        ([1.0, 1.0, 1.0], [2.0, 8.0, 4.0], 0.0, (4.0, 4.0 / STUDENT, 4.0 * STUDENT)),
        # The difference of both directions is no scatter.
        ([1.0, -1.0, 1.0, -1.0], [2.0, 8.0, 2.0, 8.0], 0.0, (4.0, 4.0, 4.0)),
        # An error that all legs share stays in the interval.
        (
            [1.0, 1.0, 1.0, 1.0],
            4 * [5.0],
            0.05,
            (5.0, 5.0 * math.exp(-0.0196), 5.0 * math.exp(0.0196)),
        ),
    ],
)
def test_a_mean_of_logarithms_has_the_interval_of_student(sides, values, common, estimate):
    of_speed = legs(*((0.1, side) for side in sides))
    ((mean, interval),) = break_away._estimates(
        of_speed, [list(range(len(sides)))], [0.1], values, common
    )
    assert (mean, *interval) == pytest.approx(estimate, rel=1e-4)


def test_a_force_follows_its_power_of_the_rate():
    speeds = [0.1, 0.1, 1.0, 1.0]
    values = [3.0 * speed**0.25 for speed in speeds]
    estimates = break_away._estimates(
        legs(*((speed, 1.0) for speed in speeds)), [[0, 1], [2, 3]], [0.1, 1.0], values, 0.0
    )
    assert [mean for mean, _ in estimates] == pytest.approx([3.0 * 0.1**0.25, 3.0])


def test_a_leg_alone_has_no_interval_and_no_leg_has_no_estimate():
    assert break_away._estimates(legs((0.1, 1.0)), [[0]], [0.1], [7.0], 0.0) == [
        (pytest.approx(7.0), None)
    ]
    assert break_away._estimates([], [], [], [], 0.0) == []
