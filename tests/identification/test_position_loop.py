"""The stiffness of a position loop, from its control law and from a log of that loop."""

from dataclasses import replace

import numpy as np
import pytest
from tests.examples.data import measured
from tests.golden.logs import emps
from tests.identification.rigid import IDENTIFYING
from tests.models.controllers.test_own_law import PID

import bristle as br
from bristle.cli.demonstration import axis_simulated
from bristle.identification.position_loop import Stiffness, stiffness_in, stiffness_of
from bristle.prediction.claims import reach_of

GAINS = {"k_p": 60.0, "k_v": 5000.0, "k_i": 2e5}
LAYERED = br.controllers.sliding_mode(J=20.0, lambda_=50.0, K_1=900.0, K_2=0.5, phi=0.01)


@pytest.mark.parametrize(
    ("controller", "expected"),
    [
        # The integral is frozen, and a velocity that is fed forward is no stiffness.
        (br.controllers.cascade(**GAINS), 3e5),
        (br.controllers.cascade(**GAINS, k_ff=1.0), 3e5),
        (LAYERED, 20.0 * 50.0 * (900.0 + 0.5 / 0.01)),
        (PID(K_P=4e4, K_I=1e5, K_D=300.0), 4e4),
        (br.controllers.open_loop(), 0.0),
    ],
)
def test_the_stiffness_of_a_law_is_the_slope_of_its_effort(controller, expected):
    stiffness = stiffness_of(controller)
    assert (stiffness.value if stiffness else 0.0) == pytest.approx(expected, rel=1e-5)


def log_of_a_loop(**law):
    """Return a log of a mass with Coulomb friction in a cascade, by a loop of its own."""
    dt, mass, level = 1e-3, 20.0, 30.0
    k_p, k_v, k_i, k_ff = (
        law.get(name, usual)
        for name, usual in (("k_p", 60.0), ("k_v", 5000.0), ("k_i", 0.0), ("k_ff", 0.0))
    )
    t = dt * np.arange(12_000)
    reference = 0.02 * np.sin(3.0 * t) + 0.004 * np.sin(17.0 * t)
    x = v = integral = before = desired = 0.0
    positions, efforts = [], []
    for r in reference.tolist():
        error = k_p * (r - x) + k_ff * (r - desired) / dt - (x - before) / dt
        integral += k_i * error * dt
        effort = k_v * error + integral
        positions.append(x)
        efforts.append(effort)
        before, desired = x, r
        for _ in range(10):
            free = v + 1e-4 * effort / mass
            v = np.sign(free) * max(abs(free) - 1e-4 * level / mass, 0.0)
            x += 1e-4 * v
    return br.Log.from_columns(
        {
            "time": t,
            "position": np.array(positions),
            "reference": reference,
            "effort": np.array(efforts),
        }
    )


@pytest.mark.parametrize(
    ("law", "low", "high"),
    [({}, 2.9e5, 3.1e5), ({"k_ff": 1.0}, 2.9e5, 3.1e5), ({"k_i": 2e5}, 2.9e5, 5.2e5)],
)
def test_the_stiffness_of_a_log_is_the_coefficient_of_the_error(law, low, high):
    stiffness = stiffness_in(log_of_a_loop(**law))
    assert low < stiffness.value < high
    assert stiffness.half_width < 0.5 * stiffness.value


def test_a_treatment_states_the_stiffness_of_its_loop():
    log = log_of_a_loop()
    assert (
        br.identify(log, "coulomb_viscous", draws=0, blocks=0).treatment["stiffness"]
        == stiffness_in(log).value
    )


def test_the_stiffness_of_several_logs_is_that_of_the_log_that_shows_it_best(monkeypatch):
    monkeypatch.setattr(IDENTIFYING, "stiffness_in", lambda log: log)
    logs = [Stiffness(2e5, 2e4), None, Stiffness(4e5, 1e4), Stiffness(3e5, 1.5e4)]
    assert IDENTIFYING._stiffness_of(logs) == {"stiffness": 4e5, "stiffness_half_width": 1e4}


def test_a_friction_that_grows_without_bound_has_no_reach():
    friction = br.friction.bouc_wen_classic(alpha=5e4, gamma=1e3, delta=-2e3, beta=1e3, nu=1.0)
    assert reach_of(friction, None, {"stiffness": 1e6}) is None


def test_a_log_without_reference_or_of_another_effort_has_no_stiffness():
    log = log_of_a_loop()
    assert stiffness_in(replace(log, reference=None)) is None
    assert stiffness_in(replace(log, effort=None)) is None
    assert (
        stiffness_in(
            replace(
                log,
                effort=replace(
                    log.effort, values=np.random.default_rng(1).normal(0.0, 100.0, len(log))
                ),
            )
        )
        is None
    )


def test_the_stiffness_of_the_demonstration(tmp_path):
    axis_simulated.write_log(tmp_path / "log.csv", 1)
    axis = axis_simulated.axis()
    assert stiffness_of(axis.controller).value == pytest.approx(4.04e5, rel=1e-3)
    assert stiffness_in(br.read_log(tmp_path / "log.csv", axis)).value == pytest.approx(
        4.04e5, rel=0.2
    )


def test_the_stiffness_of_the_measured_positioning_system():
    measured("emps", "DATA_EMPS.mat")
    log, axis = emps()
    assert stiffness_in(log).value == pytest.approx(stiffness_of(axis.controller).value, rel=0.1)
