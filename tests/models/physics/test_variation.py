"""Slots that let friction vary: what they do to a model is what their equation says, and no more."""

import numpy as np
import pytest

from bristle import friction, response
from bristle.core.errors import InputError
from bristle.engine import force_along, run_open_loop
from bristle.engine.contact import steady_force
from bristle.models.friction import base_of, find, unvaried
from bristle.models.friction.variation import is_factor
from bristle.models.plants import inertia

pytestmark = pytest.mark.usefixtures("in_plain_python")

LUGRE = {"F_C": 20.0, "F_S": 26.0, "v_S": 2e-3, "sigma_0": 4e6, "sigma_1": 1e3, "sigma_2": 300.0}
PLACE = {"x_0": 0.1, "x_L": 0.1, "p_1": 0.2, "p_2": -0.1, "a_1": 2.0, "a_2": 1.0}


def moved(count=500, dt=4e-3):
    t = dt * np.arange(1, count + 1)
    x = 0.1 + 0.08 * np.sin(2.0 * t)
    return np.diff(x, prepend=0.1) / dt, x, dt


@pytest.mark.parametrize(
    ("x", "factor", "beside"),
    [(0.1, 1.0, 0.0), (0.2, 1.1, 3.0), (0.0, 0.7, -1.0), (5.0, 1.1, 3.0), (-5.0, 0.7, -1.0)],
)
def test_variation_is_zero_in_the_middle_and_full_at_the_end(x, factor, beside):
    v, values = np.array([0.3, -0.3]), {"F_C": 20.0, "F_v": 100.0}
    placed = force_along(
        find("coulomb_viscous+position")(**values, **PLACE), v, 1e-9, x + 0.5e-9 * v
    )
    assert placed == pytest.approx(
        factor * force_along(find("coulomb_viscous")(**values), v, 1e-9) + beside
    )


def test_the_force_of_a_screw_comes_once_a_turn():
    model = find("viscous+periodic")(F_v=1.0, pitch=5e-3, c_1=3.0, s_1=4.0)
    x = 0.01 + 1e-5 * np.arange(2000)
    force = response(model, x, 1e-3)[1:]
    assert np.ptp(force) == pytest.approx(10.0, rel=1e-3)
    assert force[500:] == pytest.approx(force[:-500], abs=1e-9)


def test_the_ripple_of_a_step_is_that_of_its_middle():
    force = force_along(find("coulomb+ripple")(F_C=10.0, pitch=0.2, h_s1=4.0), np.array([1.0]), 0.1)
    # The step ends at half a turn, and has its middle at a quarter.
    assert force == pytest.approx([14.0])


@pytest.mark.parametrize(
    ("around", "factor"),
    [
        ({}, 1.0),
        ({"load": 1.5}, 1.45),
        ({"load": 1.5, "temperature": 303.15}, 1.25),
        ({"temperature": 500.0}, 0.0),
    ],
)
def test_load_and_temperature_are_first_order_factors_and_nothing_makes_friction_push(
    around, factor
):
    model = find("lugre+load+temperature")(**LUGRE, k_L=0.9, k_T=-0.02)
    v, x, dt = moved()
    force, plain = (
        force_along(model, v, dt, x, **around),
        force_along(find("lugre")(**LUGRE), v, dt, x),
    )
    assert force == pytest.approx(factor * plain) if factor else np.all(force * plain >= 0.0)


def test_a_body_still_sticks_where_friction_varies():
    model = find("coulomb+position")(F_C=20.0, **PLACE)
    trace = run_open_loop(inertia(M=5.0), model, np.full(300, 10.0), 2e-3, x=0.15, v=0.2)
    assert np.ptp(trace.position[-100:]) == 0.0


def test_multiplying_and_adding_coefficients_are_distinguished():
    model = find("coulomb+position+periodic+load+temperature")
    assert [name for name, variable in model.variables.items() if is_factor(variable)] == [
        "p_1",
        "p_2",
        "k_L",
        "k_T",
    ]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        *(
            ("coulomb+position", {"F_C": 20.0, "x_0": 0.1, "x_L": 0.1} | p)
            for p in ({"p_1": 0.98}, {"p_2": -0.98}, {"p_1": 1.9, "p_2": 0.95})
        ),
        ("viscous+periodic", {"F_v": 1.0, "pitch": 1e-12, "c_1": 0.1, "s_1": 0.0}),
    ],
)
def test_friction_keeps_its_sign_on_the_axis_and_turns_have_a_length(name, values):
    model = find(name)(**values)
    assert {key: model.values[key] for key in values} == values


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        # The parabola is least at xi = -p_1 / (2 p_2) where that is inside, else at an end.
        *(
            ("coulomb+position", PLACE | {"F_C": 20.0, "p_1": p_1, "p_2": p_2}, r"1 \+ p_1 xi")
            for p_1, p_2 in ((0.0, -1.2), (-1.0, 0.0), (1.99, 0.99))
        ),
        ("coulomb+position", {"F_C": 20.0}, "needs"),
        *(
            ("viscous+periodic", {"F_v": 1.0, "pitch": pitch, "c_1": 0.1, "s_1": 0.0}, "pitch")
            for pitch in (0.9e-12, 0.0)
        ),
        ("lugre+wear", {}, "no such slot"),
        ("lugre+load+load", {}, "a slot twice"),
    ],
)
def test_impossible_slots_are_refused_by_name(name, values, words):
    with pytest.raises(InputError, match=words):
        find(name)(**values)


def test_slots_combine_in_any_order_and_the_base_is_known():
    item = find("lugre+asymmetry+position+load")
    assert item is find("lugre+load+position+asymmetry")
    assert (item.name, base_of(item)) == ("lugre+position+load+asymmetry", friction.lugre)


def test_steady_friction_is_that_in_the_middle():
    model, plain = (
        find("lugre+position+periodic")(**LUGRE, **PLACE, pitch=5e-3, c_1=3.0, s_1=1.0),
        find("lugre")(**LUGRE),
    )
    assert steady_force(model, 0.02) == pytest.approx(steady_force(plain, 0.02))
    assert unvaried(plain) is plain


@pytest.mark.parametrize("slot", ["position", "periodic", "load", "temperature"])
def test_friction_varies_only_with_the_causes_of_its_slots(slot):
    v, x = np.array([1.0, -1.0]), np.array([0.13, 0.17])
    model = find(f"coulomb+{slot}")
    neutral = {name: 0.0 for name in model.variables if name not in ("F_C", "x_L", "pitch")}
    made = model(
        **neutral | {name: 1.0 for name in ("F_C", "x_L", "pitch") if name in model.variables}
    )
    around = {
        name: value
        for name, value in (("load", 3.0), ("temperature", 350.0), ("transmitted", 9.0))
        if name != slot
    }
    assert force_along(made, v, 1e-9, x, **around).tolist() == [1.0, -1.0]
