"""Break-away by rate, from pulls with known truth: forces and distances lie in their intervals."""

from dataclasses import replace

import numpy as np
import pytest
from tests.excitation.axes import STAGE
from tests.identification.known_logs import Motion, log_of

from bristle.engine import force_along
from bristle.excitation import excite
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.preprocessing import treat
from bristle.plants import inertia

AXIS = replace(STAGE, resolution=2e-8, sample_time=5e-4, jerk_limit=None)
LIMITS, REACH, OFFSET = np.array([18.0, 24.0, 18.0]), np.array([2e-6, 4e-6, 7e-6]), 5.0
TRUTH = find("maxwell_slip")(F_C=60.0, nu_i=LIMITS / 60.0, k_i=LIMITS / REACH, offset=OFFSET)
MASS, CUTOFF = 28.0, 60.0
SCATTER = 0.05


@pytest.fixture(scope="module")
def motion():
    return excite(AXIS, duration="24 s", purposes="break-away", model=TRUTH, rehearsed=False).motion


def pulled(motion, seed=0, scatter=SCATTER):
    """A log of the motion: the level of friction is drawn anew for each leg."""
    v, dt, rng = motion.velocity, motion.sample_time, np.random.default_rng(seed)
    sides = np.sign(v)
    moving = np.flatnonzero(sides)
    turns = moving[1:][sides[moving[1:]] != sides[moving[:-1]]]
    leg = np.searchsorted(turns, np.arange(v.size), side="right")
    levels = 1.0 + scatter * rng.standard_normal(turns.size + 1)
    friction = (force_along(TRUTH, v, dt, motion.position + 0.5 * dt * v) - OFFSET) * levels[leg] + OFFSET
    effort = MASS * motion.acceleration + friction + 0.3 * rng.standard_normal(v.size)
    return log_of(motion, effort, step=AXIS.resolution)


def distance():
    """How far a contact moves from one side until 90 % of the change of force are there, from its elements."""
    x = np.linspace(0.0, 30e-6, 300_001)
    change = np.minimum(np.outer(x, LIMITS / REACH), 2.0 * LIMITS).sum(axis=1)
    return float(x[np.argmax(change >= 0.9 * 2.0 * np.sum(LIMITS))])


def test_without_scatter_force_and_distance_are_those_of_the_elements_at_every_rate(motion):
    result = treat(pulled(motion, scatter=0.0), AXIS, CUTOFF).break_aways(inertia(M=MASS), OFFSET)
    speeds = sorted({round(piece.speed, 12) for piece in motion.pieces if piece.name == "break-away ramp"})
    assert len(result) == len(speeds) == 3
    for piece, speed in zip(result, speeds, strict=True):
        assert piece.speed == pytest.approx(speed, rel=0.1)
        assert piece.legs >= 2
        assert piece.force == pytest.approx(60.0, rel=0.02)
        assert piece.distance == pytest.approx(distance(), rel=0.08)


def test_intervals_hold_the_truth_where_friction_scatters(motion):
    inside = []
    for seed in range(15):
        for break_away in treat(pulled(motion, seed), AXIS, CUTOFF).break_aways(inertia(M=MASS), OFFSET):
            inside.append(break_away.force_interval[0] < 60.0 < break_away.force_interval[1])
            assert break_away.force_interval[1] / break_away.force_interval[0] < 1.6
    assert len(inside) >= 30
    assert np.mean(inside) > 0.85


def test_intervals_of_the_distance_hold_it_wherever_the_steps_of_the_encoder_lie(motion):
    v, dt, step, inside = motion.velocity, motion.sample_time, 1e-7, []
    friction = force_along(TRUTH, v, dt, motion.position + 0.5 * dt * v)
    axis = replace(AXIS, resolution=step)
    for seed in range(8):
        rng = np.random.default_rng(seed)
        moved = Motion(motion.time, motion.position + rng.uniform(0.0, step), v, motion.acceleration)
        effort = MASS * motion.acceleration + friction + 0.05 * rng.standard_normal(v.size)
        for break_away in treat(log_of(moved, effort, step=step), axis, CUTOFF).break_aways(inertia(M=MASS), TRUTH.values["offset"]):
            low, high = break_away.distance_interval
            inside.append(low < distance() < high)
            assert high / low < 1.05
    # All legs of a log err alike: they agree within a fifth of that.
    assert len(inside) == 24
    assert np.mean(inside) > 0.85


def test_an_identification_tells_them_and_too_fast_a_pull_is_left_out(motion):
    log = pulled(motion)
    requested = {"mass": MASS, "axis": AXIS, "blocks": 0, "draws": 0}
    identification = identify(log, "maxwell_slip", cutoff=CUTOFF, **requested)
    assert len(identification.break_aways) == 3
    assert identification.break_aways[0].force == pytest.approx(60.0, rel=0.12)
    smeared = identify(log, "maxwell_slip", cutoff=2.0, decimation=50, **requested)
    assert len(smeared.break_aways) < 3


def test_a_log_without_pulls_from_rest_has_none(motion):
    triangles = excite(AXIS, duration="10 s", purposes="presliding", model=TRUTH, rehearsed=False).motion
    assert treat(pulled(triangles), AXIS, CUTOFF).break_aways(inertia(M=MASS), OFFSET) == ()
