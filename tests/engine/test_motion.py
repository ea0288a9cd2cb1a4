"""Friction along a motion: what surrounds a contact, what was before it, and how far it deflects."""

import math

import numpy as np
import pytest

from bristle import friction, hysteresis
from bristle.core.errors import InputError
from bristle.core.packing import pack
from bristle.engine import force_along, response, settled
from bristle.engine.motion import (
    along,
    compensation_along,
    conditioned,
    in_turns,
    presliding_distance,
)
from bristle.models.controllers.feedforward import Shape

pytestmark = pytest.mark.usefixtures("in_plain_python")

PLAIN = Shape(1.0, 0.0, 0.0, math.inf, math.inf)


def lugre(**changes):
    return friction.lugre(
        **{"F_C": 20.0, "F_S": 20.0, "v_S": 1.0, "sigma_0": 1e6, "sigma_1": 0.0, "sigma_2": 0.0}
        | changes
    )


PLACED = friction.find("viscous+position")(
    F_v=10.0, x_0=0.0, x_L=1.0, p_1=0.0, p_2=0.0, a_1=3.0, a_2=0.0
)
WARM = friction.find("coulomb+load+temperature")(F_C=20.0, k_L=0.5, k_T=-0.01)
GEARED = friction.find("coulomb_viscous+transmitted")(F_C=20.0, F_v=100.0, c_T=0.1)
FILM = friction.find("viscous+transmitted")(F_v=100.0, c_T=0.1)
RIPPLED = friction.find("coulomb+ripple")(
    F_C=20.0, pitch=0.4, h_c1=0.0, h_s1=5.0, h_c2=0.0, h_s2=0.0
)
LUGRE = friction.lugre(F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=1e6)


@pytest.mark.parametrize(
    ("model", "v", "around", "force"),
    [
        # By default the position is the integral of the velocity: in the middles of the steps 0.1, 0.2 and 0.1.
        (PLACED, [2.0, 0.0, -2.0], {}, [20.3, 0.6, -19.7]),
        (PLACED, [2.0, 0.0, -2.0], {"x": [0.5, 0.5, 0.5]}, [21.2, 1.5, -18.2]),
        # Surroundings are a number, or any sequence of one for each step.
        (WARM, [1.0, 1.0], {"load": 3.0}, [40.0, 40.0]),
        (WARM, [1.0, 1.0], {"load": [1.0, 2.0], "temperature": 303.15}, [18.0, 28.0]),
        (WARM, [1.0, 1.0], {"load": (1, 3)}, [20.0, 40.0]),
        (LUGRE, [0.0], {"state": LUGRE.component.State(5e-6)}, [5.0]),
        # An effort of either sign raises dry friction, and no viscous part.
        (GEARED, [0.1, -0.1], {}, [30.0, -30.0]),
        (GEARED, [0.1, -0.1], {"transmitted": 50.0}, [35.0, -35.0]),
        (FILM, [0.1], {"transmitted": 50.0}, [10.0]),
        # A step from 0 to 0.2, and one back from 0.4 to 0.2: their middles are a quarter and three quarters of a turn.
        (RIPPLED, [2.0, -2.0], {"x": [0.2, 0.2]}, [25.0, -15.0]),
    ],
)
def test_the_force_of_a_step_depends_on_its_middle_its_start_and_what_surrounds_it(
    model, v, around, force
):
    assert force_along(model, v, 0.1, **around) == pytest.approx(force)


def test_a_memory_sets_the_start_and_is_not_changed():
    memory = np.array([2.0, 3.0])
    assert (
        force_along(
            friction.maxwell_slip(F_C=20.0, k_i=[6e6, 3e6], nu_i=[0.5, 0.5]),
            [0.0],
            1.0,
            memory=memory,
        )[0]
        != 0.0
    )
    assert memory.tolist() == [2.0, 3.0]


def test_turns_have_separate_parameters_and_surroundings():
    model = friction.find("coulomb+load")(F_C=20.0, k_L=1.0)
    rows = np.array([pack(model.with_values(F_C=level).parameters) for level in (20.0, 30.0, 40.0)])
    v = np.ones(6)
    result = in_turns(
        model,
        rows,
        v,
        0.1,
        0.1 * np.cumsum(v),
        [0, 2, 5],
        load=np.array([1.0, 2.0, 1.0, 2.0, 1.0, 2.0]),
    )
    assert result == pytest.approx([20.0, 40.0, 30.0, 60.0, 30.0, 80.0])


@pytest.mark.parametrize(
    ("around", "force"),
    [
        ({}, [20.0, 20.0]),
        ({"transmitted": 50.0}, [25.0, 25.0]),
        ({"transmitted": np.array([0.0, 50.0])}, [20.0, 25.0]),
    ],
)
def test_a_compensator_along_a_motion_receives_position_and_transmitted_effort(around, force):
    model = friction.find("coulomb+transmitted")(F_C=20.0, c_T=0.1)
    assert compensation_along(
        model, PLAIN, np.ones(2), 0.1, np.array([0.1, 0.2]), **around
    ) == pytest.approx(force)


@pytest.mark.parametrize("v", [1e-3, -0.2])
def test_a_contact_after_sliding_has_its_full_deflection(v):
    state, memory = settled(lugre(), v)
    assert state.z == pytest.approx(math.copysign(20.0 / 1e6, v))
    assert memory.size == 0
    assert settled(lugre(), 0.0)[0].z == 0.0


@pytest.mark.parametrize("sigma_0", [1e2, 1e10])
def test_a_contact_of_any_stiffness_settles(sigma_0):
    assert settled(lugre(sigma_0=sigma_0), 1.0)[0].z == pytest.approx(20.0 / sigma_0)


def test_a_sweep_ends_at_its_start():
    _, memory = conditioned(friction.maxwell_slip(F_C=1.0, k_i=[1e-6], nu_i=[1.0]), 1e-5)
    assert memory[0] == pytest.approx(0.0, abs=1e-15)
    assert conditioned(friction.maxwell_slip(F_C=1.0, k_i=[1e6], nu_i=[1.0]), 0.0)[1].tolist() == [
        0.0
    ]


@pytest.mark.parametrize("length", [1e-9, 2e-5, 1e-2])
def test_a_contact_reaches_half_of_its_force_over_seven_tenths_of_its_bristles(length):
    # 1 - exp(-x / z) = 1 / 2 at x = z ln 2; the places that are tried lie a quarter apart.
    distance = presliding_distance(lugre(sigma_0=20.0 / length))
    assert length * math.log(2.0) * 0.8 <= distance <= length * math.log(2.0) * 1.3


def test_a_static_map_and_a_contact_without_force_have_no_presliding_distance():
    assert presliding_distance(friction.coulomb(F_C=20.0)) == math.inf
    assert (
        presliding_distance(friction.lugre(F_C=1.0, F_S=1.0, v_S=1.0, sigma_0=0.0, validate=False))
        == math.inf
    )


def test_a_response_begins_at_the_first_sample_without_a_force():
    model = friction.viscous(F_v=10.0)
    assert response(model, [1.0, 1.5, 1.0], 0.1).tolist() == pytest.approx([0.0, 50.0, -50.0])


def test_overflow_is_allowed_in_a_search():
    model = friction.viscous(F_v=1e100)
    with np.errstate(over="ignore"):
        assert along(model, [1e300], 1.0)[0] == math.inf


@pytest.mark.parametrize(("amplitude", "largest"), [(1e-5, 1e-5), (3e-6, 3e-6)])
def test_a_sweep_has_twelve_turns_that_decay_evenly(amplitude, largest):
    _, memory = conditioned(friction.preisach_contact(s=1e7, f_p=28.0, capacity=64), amplitude)
    turned = np.sort(np.abs(memory[:64][memory[:64] != 0.0]))[::-1]
    # Each of the quarters between is a turning point: the largest a quarter of the first turn in.
    assert turned[0] == pytest.approx(largest * (1.0 - 0.25 / 12.0), rel=1e-3)
    assert np.diff(turned)[:20] == pytest.approx(-amplitude * 0.5 / 12.0, rel=1e-2)
    assert turned.size >= 22


def test_operators_take_a_history():
    assert response(hysteresis.stop(r=1.0), [0.5], history=[3.0]).tolist() == [-1.0]
    assert response(hysteresis.stop(r=1.0), [0.5]).tolist() == [0.5]


LOADED, COULOMB = friction.find("coulomb+load")(F_C=20.0, k_L=0.5), friction.coulomb(F_C=1.0)


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: force_along(LOADED, [1.0, 1.0], 0.1, load=[1.0]), "load: has the wrong length"),
        (
            lambda: force_along(LOADED, [1.0, 1.0], 0.1, laod=2.0),
            r"laod: is not a channel of coulomb.*load, temperature, transmitted.*Did you mean 'load'",
        ),
        (lambda: along(LOADED, [1.0, 1.0], 0.1, load=["1", "3"]), None),
        (
            lambda: along(
                LOADED, [1.0, 1.0], 0.1, load=np.ma.array([1.0, 3.0], mask=[True, False])
            ),
            None,
        ),
        (
            lambda: force_along(lugre(), [0.0], 1.0, state=(1.0, 2.0)),
            "state: belongs to a different model",
        ),
        (
            lambda: compensation_along(COULOMB, PLAIN, np.ones(2), 0.1, np.ones(1)),
            "x: has the wrong length",
        ),
        (
            lambda: compensation_along(
                COULOMB, PLAIN, np.ones(2), 0.1, np.ones(2), transmitted=np.zeros(3)
            ),
            "transmitted",
        ),
        (
            lambda: response(hysteresis.stop(r=1.0), [0.5], 0.1),
            r"dt: does not apply to a hysteresis operator; found 0.1.*Omit dt",
        ),
        (
            lambda: response(COULOMB, [0.0, 1.0], 0.1, history=[1.0]),
            r"history: applies only to hysteresis operators.*Prepend the earlier motion to x",
        ),
        (lambda: response(COULOMB, [0.0, 1.0]), "dt: is needed for a friction model"),
        (
            lambda: force_along(friction.viscous(F_v=1e100), [0.0, 1e300], 1.0),
            "the output of viscous is not finite at sample 1 of a finite motion",
        ),
        (lambda: conditioned(lugre(), -1e-9), "amplitude"),
    ],
)
def test_invalid_motions_are_refused_by_name(call, words):
    with pytest.raises(InputError, match=words):
        call()
