"""A contact led by hand: what it holds, and where a force is reached."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.simulation.certificates.ballscrew import (
    F_S,
    STIFFNESS,
    UM,
    composite,
    lugre,
    maxwell_slip,
)

from bristle import friction, hysteresis
from bristle.simulation.certificates.certificate import as_friction
from bristle.simulation.certificates.quasi_static import Path, holding_of


@pytest.mark.parametrize("model", [lugre(), composite(), composite("paper"), maxwell_slip()])
def test_a_contact_has_its_static_friction_in_both_directions(model):
    result = holding_of(model)
    assert result.forward == pytest.approx(F_S, rel=1e-9)
    assert result.backward == pytest.approx(-F_S, rel=1e-9)
    assert result.has_presliding


def test_an_offset_shifts_the_range_at_rest():
    result = holding_of(friction.find("coulomb+asymmetry")(F_C_pos=3.0, F_C_neg=2.0, offset=0.25))
    assert (result.backward, result.forward, result.half) == (-1.75, 3.25, 2.5)
    assert not result.has_presliding


@pytest.mark.parametrize("spring", [2e-5, 1e-2])
def test_a_force_that_grows_without_limit_is_never_passed(spring):
    # 1 N of a stop, and from the spring 0.02 N or 10 N over the longest slide, a kilometre.
    fixed = holding_of(
        as_friction(hysteresis.prandtl_ishlinskii(thresholds=[1e-6], weights=[1e6], spring=spring))
    )
    assert (fixed.backward, fixed.forward) == (-math.inf, math.inf)
    assert not fixed.has_presliding
    alone = holding_of(as_friction(hysteresis.prandtl_ishlinskii(thresholds=[1e-6], weights=[1e6])))
    assert (alone.backward, alone.forward) == pytest.approx((-1.0, 1.0), rel=1e-6)


def test_a_force_is_reached_at_the_place_of_the_equations():
    model = composite("paper")
    path = Path(model, holding_of(model))
    assert path.to_force(0.08)
    assert path.force == pytest.approx(0.08, rel=1e-12)
    f_p = 0.156
    # Loading from virgin: f = s f_p z/(f_p + s z) and dz/dx = 1 - f/F_S.
    until = solve_ivp(
        lambda x, z: 1.0 - STIFFNESS * f_p * z / (f_p + STIFFNESS * z) / F_S,
        (0.0, 20 * UM),
        [0.0],
        rtol=1e-10,
        atol=1e-14,
        events=lambda x, z: STIFFNESS * f_p * z[0] / (f_p + STIFFNESS * z[0]) - 0.08,
    )
    assert path.x == pytest.approx(until.t_events[0][0], rel=1e-5)


def test_a_force_at_rest_above_the_previous_means_is_reached():
    # A kernel that holds more than its surface does: after steps whose mean is below the target, it rests above it.
    model = friction.find("leuven")(
        s=1e7,
        f_p=23.52,
        F_C=8.4,
        F_S=8.4,
        v_S=0.008,
        sigma_1=1000.0,
        sigma_2=240.0,
        kernel="dahl_masing",
        n=4.0,
    )
    path = Path(model, holding_of(model))
    for target in (5.04, 2.52, 5.04, 2.52, 5.04):
        assert path.to_force(target)
        assert path.force == pytest.approx(target, abs=1e-9)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_path_contains_its_curve_for_forces_of_any_size(scale):
    # Two elements: 20 N/m and 80 N/m up to their limits, 0.5 N and 0.5 N, and then the same from there on back.
    k, limit = np.array([20.0, 80.0]), np.array([0.5, 0.5])
    model = friction.maxwell_slip(F_C=scale, k_i=(scale * k).tolist(), nu_i=limit.tolist())
    path = Path(model, holding_of(model))
    assert path.to_force(0.7 * scale)
    assert path.x == pytest.approx(0.01, rel=1e-9)
    assert path.to_force(-0.2 * scale)
    assert path.x == pytest.approx(0.01 - 0.9 / 100.0, rel=1e-9)
    path.to_position(0.02)
    x, force = path.trace
    assert x.shape == force.shape
    assert (x[0], force[0], x[-1]) == (0.0, 0.0, 0.02)
    out, back = int(np.argmax(x >= 0.0099999)), int(np.argmin(np.abs(force + 0.2 * scale)))
    assert np.all(np.diff(x[: out + 1]) > 0.0)
    # In the middle of steps that hold no knee.
    curve = np.minimum(np.outer(x[:out], k), limit).sum(axis=1)
    assert np.max(np.abs(force[:out] / scale - curve)) < 5e-3
    assert np.max(np.abs(np.diff(force[out:back] / scale) - 100.0 * np.diff(x[out:back]))) < 1e-9


def test_a_force_within_the_range_at_rest_causes_no_motion_and_one_beyond_break_away_is_not_reached():
    model = friction.coulomb(F_C=2.0)
    path = Path(model, holding_of(model))
    assert [path.to_force(force) for force in (1.0, -1.5)] == [True, True]
    assert path.x == 0.0
    assert not Path(lugre(), holding_of(lugre())).to_force(1.01 * F_S)
