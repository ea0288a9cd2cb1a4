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

ARM = {"M": 0.02, "g_sin": 0.9, "g_cos": 0.2}
CABLE = {"M": 0.02, "spring_1": 0.8, "spring_2": 0.3, "spring_3": -0.2}
TOOTHED = {"M": 0.02, "motor_turn": 1.0, "motor_6_cos": 0.3, "motor_6_sin": -0.1}


def free_fall(effort_at, seconds, x):
    """The motion of a body of 0.02 kg*m^2 that begins at rest, by a method that shares nothing with the engine."""
    solution = solve_ivp(
        lambda t, y: [y[1], -effort_at(y[0]) / 0.02], (0.0, seconds), [x, 0.0], "DOP853", rtol=1e-11, atol=1e-12, t_eval=[seconds]
    )
    return solution.y[0, -1]


@pytest.mark.parametrize(
    ("values", "effort_at"),
    [
        (ARM, lambda x: 0.9 * math.sin(x) + 0.2 * math.cos(x)),
        (CABLE, lambda x: 0.8 * x + 0.3 * x**2 - 0.2 * x**3),
        (TOOTHED, lambda x: 0.3 * math.cos(12 * math.pi * x) - 0.1 * math.sin(12 * math.pi * x)),
    ],
)
def test_a_pendulum_follows_its_equation(values, effort_at):
    name = "inertia+gravity" if "g_sin" in values else "inertia+spring" if "spring_1" in values else "inertia+cogging"
    plant = plants.find(name, values)(kind="rotational", **values)
    frictionless = friction.viscous(kind="rotational", F_v=0.0)
    errors = []
    for dt in (1e-3, 5e-4):
        count = round(0.8 / dt)
        trace = run_open_loop(plant, frictionless, np.zeros(count + 1), dt, steps=1, x=0.02)
        errors.append(abs(trace.position[count] - free_fall(effort_at, 0.8, 0.02)))
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)  # second order


def test_an_arm_rests_where_friction_holds_it():
    plant = plants.find("inertia+gravity", ARM)(kind="rotational", **ARM)
    fixed = friction.coulomb(kind="rotational", F_C=0.5)
    trace = run_open_loop(plant, fixed, np.zeros(500), 1e-3, steps=1, x=0.3)
    assert np.ptp(trace.position) == 0.0
    falls = run_open_loop(plant, fixed, np.zeros(500), 1e-3, steps=1, x=1.2)
    assert falls.position[-1] < 1.0


def test_gravity_is_fed_forward_along_the_desired_motion():
    plant = plants.find("inertia+gravity", ARM)(kind="rotational", **ARM)
    position, still = np.full(10, 0.5), np.zeros(10)
    effort = feedforward_effort(Feedforward(plant=plant), position, still, 1e-3)
    assert effort == pytest.approx(0.9 * math.sin(0.5) + 0.2 * math.cos(0.5))


def test_a_spring_is_fed_forward_and_keeps_the_energy_of_a_free_motion():
    plant = plants.find("inertia+spring", ["spring_1"])(kind="rotational", M=0.02, spring_1=0.8)
    effort = feedforward_effort(Feedforward(plant=plant), np.full(10, 0.5), np.zeros(10), 1e-3)
    assert effort == pytest.approx(0.4)
    trace = run_open_loop(plant, friction.viscous(kind="rotational", F_v=0.0), np.zeros(20_000), 1e-3, steps=1, x=0.5)
    energy = 0.4 * trace.position**2 + 0.01 * trace.velocity**2
    assert np.ptp(energy[10_000:]) < 0.02 * 0.1
    assert energy[10_000:].mean() == pytest.approx(0.1, rel=0.01)


def test_the_degree_of_a_spring_follows_from_the_names_of_its_parameters():
    assert list(plants.find("inertia+spring", ["spring_1"]).variables) == ["M", "spring_1"]
    assert list(plants.find("inertia+spring", ["spring_3"]).variables) == ["M", "spring_1", "spring_2", "spring_3"]


def test_a_plant_with_terms_survives_the_round_trip_through_a_model_file(tmp_path):
    values = {**TOOTHED, **CABLE, "g_sin": 0.9, "g_cos": 0.0, "known_belt": 2.5}
    plant = plants.find("inertia+gravity+cogging+spring+known", values)(kind="rotational", **values)
    write_model(tmp_path / "model.toml", plant, friction.coulomb(kind="rotational", F_C=1.0))
    assert read_model(tmp_path / "model.toml").plant == plant


def test_a_term_that_is_not_there_is_refused_by_name():
    with pytest.raises(InputError, match=r"\+gravity"):
        plants.find("inertia+gravty")
    with pytest.raises(InputError, match="no coefficient"):
        plants.find("inertia+cogging", ["M"])
    with pytest.raises(InputError, match=r"spring_1 = 0\.1"):
        plants.find("inertia+spring", ["M"])


GEARED = {"F_C": truth.F_C, "F_v": truth.F_V, "c_T": truth.SHARE}


@pytest.mark.parametrize(("x", "applied"), [(1.2, 0.0), (0.2, 1.5), (0.05, 0.0), (1.0, 1.0)])
def test_an_arm_behind_a_gear_moves_as_its_friction_lets_it(x, applied):
    plant = plants.find("inertia+gravity", ["g_sin"])(kind="rotational", M=truth.J, g_sin=truth.GRAVITY)
    geared = friction.find("coulomb_viscous+transmitted")(kind="rotational", **GEARED)
    trace = run_open_loop(plant, geared, np.full(501, applied), 1e-3, steps=2, x=x)
    assert trace.position[500] == pytest.approx(truth.fall(0.5, x, applied), abs=2e-4)


def test_friction_feedforward_of_a_gear_includes_its_transmitted_effort():
    plant = plants.find("inertia+gravity", ["g_sin"])(kind="rotational", M=truth.J, g_sin=truth.GRAVITY)
    geared = friction.find("coulomb_viscous+transmitted")(kind="rotational", **GEARED)
    _, q, v, a = truth.swing(2.0, 1)
    fed = feedforward_effort(Feedforward(mass=truth.J, plant=plant, friction=geared), q, a, 1e-3)
    expected = truth.effort(q, v, a)
    moving = np.abs(v) > 0.05
    assert np.max(np.abs(fed - expected)[moving]) < 0.01 * np.max(np.abs(expected))
