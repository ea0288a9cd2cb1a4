"""Pre-sliding around static maps, with parameters by direction and an offset."""

import math

import numpy as np
import pytest

from bristle import friction
from bristle.engine import force_along, run_open_loop
from bristle.models.friction import with_presliding
from bristle.models.plants import inertia

pytestmark = pytest.mark.usefixtures("in_plain_python")

DISTANCE = 2e-6
# Sliding forward takes 9 + 1 N, backward -6 + 1 N.
LEVELS = friction.find("coulomb_viscous+asymmetry")(
    F_C_pos=9.0, F_C_neg=6.0, F_v_pos=0.0, F_v_neg=0.0, offset=1.0
)
SLIDING = friction.find("stribeck+asymmetry")(
    F_C_pos=9.0,
    F_C_neg=6.0,
    F_S_pos=12.0,
    F_S_neg=7.0,
    v_S=4e-3,
    F_v_pos=30.0,
    F_v_neg=50.0,
    offset=1.0,
)


def steps(distance: float, count: int, dt: float = 1e-3) -> np.ndarray:
    return np.full(count, distance / count / dt)


def test_the_force_reverses_over_the_distance():
    model = with_presliding(LEVELS, DISTANCE)
    present, back = steps(40.0 * DISTANCE, 400), steps(-4.0 * DISTANCE, 400)
    force = force_along(model, np.concatenate([present, back]), 1e-3)
    assert force[399] == pytest.approx(10.0, rel=1e-12)
    # Of the 15 N between both levels, what is left falls by e with every distance.
    after = force[400:].reshape(4, 100)
    left = (after - (-5.0)) / 15.0
    assert np.allclose(left[1:] / left[:-1], math.exp(-1.0), rtol=1e-9)
    assert force[400] == pytest.approx(10.0, abs=0.1)


@pytest.mark.parametrize("v", [-0.3, -2e-3, 1e-3, 0.2])
def test_sliding_is_that_of_the_map(v):
    moved = np.full(200, v)
    dt = 0.5 * DISTANCE / abs(v)
    turned = force_along(with_presliding(SLIDING, DISTANCE), moved, dt)
    assert turned[-1] == pytest.approx(force_along(SLIDING, moved, dt)[-1], rel=1e-12)


@pytest.mark.parametrize(
    ("load", "rests"), [(9.0, True), (-4.0, True), (11.0, False), (-6.0, False)]
)
def test_friction_balances_a_load_within_the_levels_but_not_beyond(load, rests):
    effort = load * np.minimum(1e-3 * np.arange(600) / 0.1, 1.0)
    trace = run_open_loop(
        inertia(M=2.0), with_presliding(LEVELS, DISTANCE), effort, 1e-3, steps=2, hold="linear"
    )
    moved = abs(trace.position[-1] - trace.position[300])
    # The contact has no damping of its own, and creeps while the body rings.
    assert moved < 10.0 * DISTANCE if rests else moved > 0.02
    assert np.mean(trace.friction[300:]) == pytest.approx(load, rel=0.01) or not rests


def test_its_parameters_are_those_of_the_map_and_the_distance():
    model = with_presliding(SLIDING, DISTANCE)
    assert model.values == SLIDING.values | {"presliding": DISTANCE}
    assert (
        with_presliding(friction.lugre(**friction.MODELS["lugre"].example), DISTANCE).name
        == "lugre"
    )
    assert with_presliding(model, 5.0 * DISTANCE).values["presliding"] == DISTANCE
