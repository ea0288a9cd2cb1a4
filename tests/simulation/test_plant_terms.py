"""Gravity and cogging in simulated motion, in what is fed forward, and in files."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.simulation import transmitted_truth as truth

from bristle import friction, plants
from bristle.core import InputError
from bristle.core.experiment import Feedforward
from bristle.engine import run_open_loop
from bristle.files.model import read_model, write_model
from bristle.simulation.compensation import feedforward_effort

pytestmark = pytest.mark.usefixtures("in_plain_python")

ARM = {"M": 0.02, "g_sin": 0.9, "g_cos": 0.2}
CABLE = {"M": 0.02, "spring_1": 0.8, "spring_2": 0.3, "spring_3": -0.2}
TOOTHED = {"M": 0.02, "motor_turn": 1.0, "motor_6_cos": 0.3, "motor_6_sin": -0.1}


def free_fall(effort_at, seconds, x):
    """The motion of a body of 0.02 kg*m^2 that begins at rest, by a method that shares nothing with the engine."""
    solution = solve_ivp(
        lambda t, y: [y[1], -effort_at(y[0]) / 0.02],
        (0.0, seconds),
        [x, 0.0],
        "DOP853",
        rtol=1e-11,
        atol=1e-12,
        t_eval=[seconds],
    )
    return solution.y[0, -1]


@pytest.mark.parametrize(
    ("name", "values", "effort_at"),
    [
        ("gravity", ARM, lambda x: 0.9 * math.sin(x) + 0.2 * math.cos(x)),
        ("spring", CABLE, lambda x: 0.8 * x + 0.3 * x**2 - 0.2 * x**3),
        (
            "cogging",
            TOOTHED,
            lambda x: 0.3 * math.cos(12 * math.pi * x) - 0.1 * math.sin(12 * math.pi * x),
        ),
    ],
)
def test_a_pendulum_follows_its_equation(name, values, effort_at):
    plant = plants.find(f"inertia+{name}", values)(kind="rotational", **values)
    frictionless = friction.viscous(kind="rotational", F_v=0.0)
    errors = []
    for dt in (1e-3, 5e-4):
        count = round(0.4 / dt)
        trace = run_open_loop(plant, frictionless, np.zeros(count + 1), dt, steps=1, x=0.02)
        errors.append(abs(trace.position[count] - free_fall(effort_at, 0.4, 0.02)))
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)  # second order


@pytest.mark.parametrize(("x", "rests"), [(0.3, True), (1.2, False)])
def test_an_arm_rests_where_friction_holds_it(x, rests):
    plant = plants.find("inertia+gravity", ARM)(kind="rotational", **ARM)
    trace = run_open_loop(
        plant, friction.coulomb(kind="rotational", F_C=0.5), np.zeros(300), 1e-3, steps=1, x=x
    )
    assert bool(np.ptp(trace.position) == 0.0) is rests
    assert rests or trace.position[-1] < 1.1


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        ("inertia+spring", {"M": 0.02, "spring_1": 0.8}, 0.4),
        ("inertia+gravity", ARM, 0.9 * math.sin(0.5) + 0.2 * math.cos(0.5)),
    ],
)
def test_terms_are_fed_forward_along_the_desired_motion(name, values, expected):
    plant = plants.find(name, values)(kind="rotational", **values)
    assert list(plant.component.variables) == list(values)
    assert feedforward_effort(
        Feedforward(plant=plant), np.full(10, 0.5), np.zeros(10), 1e-3
    ) == pytest.approx(expected)


def test_a_plant_with_terms_survives_the_round_trip_through_a_model_file(tmp_path):
    values = {**TOOTHED, **CABLE, "g_sin": 0.9, "g_cos": 0.0, "known_belt": 2.5}
    plant = plants.find("inertia+gravity+cogging+spring+known", values)(kind="rotational", **values)
    write_model(tmp_path / "model.toml", plant, friction.coulomb(kind="rotational", F_C=1.0))
    assert read_model(tmp_path / "model.toml").plant == plant


@pytest.mark.parametrize(
    ("name", "keys", "words"),
    [
        ("inertia+gravty", (), r"\+gravity"),
        ("inertia+cogging", ["M"], "no coefficient"),
        ("inertia+spring", ["M"], r"spring_1 = 0\.1"),
    ],
)
def test_a_term_that_is_not_there_is_refused_by_name(name, keys, words):
    with pytest.raises(InputError, match=words):
        plants.find(name, keys)


GEARED = {"F_C": truth.F_C, "F_v": truth.F_V, "c_T": truth.SHARE}


@pytest.mark.parametrize(("x", "applied"), [(1.2, 0.0), (0.2, 1.5), (0.05, 0.0), (1.0, 1.0)])
def test_an_arm_behind_a_gear_moves_as_its_friction_lets_it(x, applied):
    plant = plants.find("inertia+gravity", ["g_sin"])(
        kind="rotational", M=truth.J, g_sin=truth.GRAVITY
    )
    geared = friction.find("coulomb_viscous+transmitted")(kind="rotational", **GEARED)
    trace = run_open_loop(plant, geared, np.full(501, applied), 1e-3, steps=2, x=x)
    assert trace.position[500] == pytest.approx(truth.fall(0.5, x, applied), abs=2e-4)
