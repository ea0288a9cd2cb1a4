"""Break-away by rate, from pulls with known truth: forces and distances lie in their intervals."""

from dataclasses import replace

import numpy as np
import pytest
from tests.golden.simulated import DISTANCES, LIMITS, PULLED, SLIPPING, pulled, pulling
from tests.identification.known_logs import Motion, log_of
from tests.identification.rigid import identify

from bristle.engine import force_along
from bristle.identification.preprocessing import treat
from bristle.logs.break_away import Recording, break_aways
from bristle.models.plants import inertia
from bristle.prediction.excitation import excite

MASS, CUTOFF, OFFSET = 28.0, 60.0, SLIPPING.values["offset"]


@pytest.fixture(scope="module")
def motion():
    return pulling()


def found(log, axis=PULLED):
    return treat(log, axis, CUTOFF).break_aways(inertia(M=MASS), OFFSET)


def distance():
    """How far a contact moves from one side until 90 % of the change of force are there, from its elements."""
    x = np.linspace(0.0, 30e-6, 300_001)
    change = np.minimum(np.outer(x, LIMITS / DISTANCES), 2.0 * LIMITS).sum(axis=1)
    return float(x[np.argmax(change >= 0.9 * 2.0 * np.sum(LIMITS))])


def test_without_scatter_force_and_distance_are_those_of_the_elements(motion):
    result = found(pulled(motion, scatter=0.0))
    speeds = sorted(
        {round(piece.speed, 12) for piece in motion.pieces if piece.name == "break-away ramp"}
    )
    assert len(result) == len(speeds) == 3
    for piece, speed in zip(result, speeds, strict=True):
        assert piece.speed == pytest.approx(speed, rel=0.1)
        assert piece.legs >= 2
        assert piece.force == pytest.approx(60.0, rel=0.02)
        assert piece.distance == pytest.approx(distance(), rel=0.08)


@pytest.mark.slow
def test_intervals_contain_the_truth_for_scattering_friction(motion):
    intervals = np.array(
        [item.force_interval for seed in range(12) for item in found(pulled(motion, seed))]
    )
    assert len(intervals) >= 24
    assert np.mean((intervals[:, 0] < 60.0) & (intervals[:, 1] > 60.0)) > 0.85
    assert np.max(intervals[:, 1] / intervals[:, 0]) < 1.6


def test_intervals_of_the_distance_contain_it_for_any_encoder_phase(motion):
    v, dt, step, intervals = motion.velocity, motion.sample_time, 1e-7, []
    effort = MASS * motion.acceleration + force_along(
        SLIPPING, v, dt, motion.position + 0.5 * dt * v
    )
    for rng in map(np.random.default_rng, range(6)):
        moved = Motion(
            motion.time, motion.position + rng.uniform(0.0, step), v, motion.acceleration
        )
        log = log_of(moved, effort + 0.05 * rng.standard_normal(v.size), step=step)
        intervals += [
            item.distance_interval for item in found(log, replace(PULLED, resolution=step))
        ]
    low, high = np.transpose(intervals)
    # All legs of a log err alike: they agree within a fifth of that.
    assert len(intervals) == 18
    assert np.mean((low < distance()) & (distance() < high)) > 0.85
    assert np.max(high / low) < 1.05


@pytest.mark.slow
def test_an_identification_has_break_aways_and_omits_too_fast_a_pull(motion):
    log = pulled(motion)
    identification = identify(
        log,
        "coulomb",
        axis=replace(PULLED, seeks_delay=False),
        mass=MASS,
        cutoff=CUTOFF,
        blocks=0,
        draws=0,
    )
    assert len(identification.break_aways) == 3
    assert identification.break_aways[0].force == pytest.approx(60.0, rel=0.12)
    assert len(treat(log, PULLED, 2.0, 50).break_aways(inertia(M=MASS), OFFSET)) < 3


def test_a_log_without_pulls_from_rest_has_no_break_away(motion):
    assert (
        found(
            pulled(
                excite(
                    PULLED, duration="10 s", purposes="presliding", model=SLIPPING, rehearsed=False
                ).motion
            )
        )
        == ()
    )


def ramps(*speeds, dt=1e-3, level=60.0, reach=2e-5, peak=0.0, still=400):
    """A recording of pulls to and fro, one each way at each speed, from rest; friction turns over a straight way."""
    position, force, x, f = [], [], 0.0, -level
    for speed in speeds:
        for side in (1.0, -1.0):
            position += [x] * still
            force += [f] * still
            way = speed * dt * np.arange(1, round(4.0 * reach / (speed * dt)))
            turned = np.minimum(way / reach, 1.0)
            own = side * level * (2.0 * turned - 1.0) + side * peak * np.exp(
                -(((way - reach) / (0.2 * reach)) ** 2)
            )
            position += (x + side * way).tolist()
            force += own.tolist()
            x, f = x + side * float(way[-1]), side * level
    position += [x] * still
    force += [f] * still
    time = dt * np.arange(len(position))
    return Recording(time, np.array(position), np.array(force))


def found_in(recording, cutoff=100.0, noise=0.0, resolution=1e-8):
    return break_aways(
        [recording], cutoff=cutoff, sample_time=1e-3, resolution=resolution, noise=noise
    )


@pytest.mark.parametrize(
    ("speeds", "merged"),
    [
        ((4e-4, 1e-4, 2e-4), (1e-4, 2e-4, 4e-4)),
        ((1e-4, 1.2e-4), (1.2**0.5 * 1e-4,)),
        ((1e-4, 1.5e-4), (1e-4, 1.5e-4)),
    ],
)
def test_rates_within_a_third_are_merged_and_the_slowest_is_first(speeds, merged):
    result = found_in(ramps(*speeds))
    assert [item.speed for item in result] == pytest.approx(merged, rel=0.05)
    assert [item.legs for item in result] == [2 * len(speeds) // len(merged)] * len(merged)


def test_a_contact_that_turns_evenly_has_turned_nine_tenths_at_nine_tenths():
    (result,) = found_in(ramps(1e-4, 1e-4, 1e-4))
    assert result.force == pytest.approx(60.0, rel=1e-6)
    assert result.distance == pytest.approx(0.9 * 2e-5, rel=0.01)
    low, high = result.distance_interval
    assert low < result.distance < high < 1.01 * low
    (higher,) = found_in(ramps(1e-4, 1e-4, 1e-4, peak=15.0))
    assert higher.force == pytest.approx(75.0, rel=0.02)  # the peak before the axis slides


def test_pulls_too_fast_for_the_filter_and_unloaded_rests_are_not_break_aways():
    pulls = ramps(1e-4, 1e-4)
    at_rest = np.concatenate([[True], np.diff(pulls.position) == 0.0])
    assert found_in(pulls._replace(force=np.where(at_rest, 0.0, pulls.force))) == ()
    assert found_in(pulls, cutoff=2.0) == found_in(pulls, noise=1e-3) == ()
    (few,) = found_in(ramps(1e-4))
    assert (few.legs, few.force_interval, few.distance_interval) == (2, None, None)
