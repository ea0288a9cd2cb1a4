"""EFIM on the composite against an independent, event-located solution.

Lengths in micrometres, forces in mN*m: a ball screw of 5 mm lead, 1e-4 kg m^2, 100 N*m/rad.
"""

import math

import numpy as np
import pytest
from tests.engine.composite_reference import Composite

from bristle import friction, plants
from bristle.engine import run_open_loop

UM = 2.0 * math.pi / 5000.0
J = 0.1 * UM
CONTACT = {
    "s": 1e5 * UM,
    "f_p": 156.0,
    "F_C": 100.0,
    "F_S": 130.0,
    "v_S": 0.3 / UM,
    "sigma_2": 2.0 * UM,
}
CONTACT["sigma_1"] = math.sqrt(CONTACT["s"] * J)
OMEGA_0 = math.sqrt(CONTACT["s"] / J)

CASES = {
    "presliding": (
        lambda t, x: 70.0 * np.sin(20.0 * np.pi * t) + 40.0 * np.sin(54.0 * np.pi * t),
        0.3,
    ),
    "break-away": (lambda t, x: 160.0 * np.sin(20.0 * np.pi * t), 0.3),
    "stick-slip": (lambda t, x: 20.0 * (200.0 * t - x), 0.25),
}
LONGEST = "stick-slip"
TRANSITIONS = {"elastoplastic": 0.9, "paper": None}


def model(transition, **values):
    return friction.preisach_lugre(**(CONTACT | values), transition=transition)


def positions(case, transition, h, times):
    effort, end = CASES[case]
    count = round(end / h)
    if case == "stick-slip":
        plant, u = plants.pulled_inertia(M=J, k=20.0, v_e=200.0), np.zeros(count + 1)
    else:
        plant, u = plants.inertia(M=J), effort(h * (np.arange(count + 1) + 0.5), 0.0)
    trace = run_open_loop(plant, model(transition), u, h)
    assert trace.status.name == "OK"
    return np.interp(times, trace.time, trace.position)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("transition", "case"),
    [
        pytest.param(transition, case, marks=pytest.mark.slow if case == LONGEST else ())
        for transition in TRANSITIONS
        for case in CASES
    ],
)
def test_the_scheme_has_second_order_and_an_error_below_one_in_a_million(case, transition):
    effort, end = CASES[case]
    times = np.linspace(0.0, end, round(end / 1e-4) + 1)
    exact = Composite(J=J, **CONTACT, rho=TRANSITIONS[transition], effort=effort).solve(times)
    scale = np.max(np.abs(exact))
    errors = [
        np.max(np.abs(positions(case, transition, h, times) - exact)) / scale
        for h in (5e-5, 2.5e-5, 1.25e-5)
    ]
    assert np.log2(errors[0] / errors[-1]) / 2 > 1.7, errors
    fine = 1e-4 / 13.0
    assert OMEGA_0 * fine < 0.008
    assert np.max(np.abs(positions(case, transition, fine, times) - exact)) / scale <= 1e-6


# --- high-speed sliding -----------------------------------------------------------------------------------------

SPEED, SETTLED = 2e5, 199_990.8
EFFORT = CONTACT["F_C"] + CONTACT["sigma_2"] * SPEED


@pytest.mark.parametrize(
    "kernel", ["dahl_masing", "tip_masing", "reformed_dahl_exact", "exp_masing"]
)
@pytest.mark.parametrize("transition", ["paper", "leuven", "elastoplastic"])
def test_sliding_at_high_speed_neither_oscillates_nor_fills_the_memory(kernel, transition):
    body, contact = plants.inertia(M=J), model(transition, kernel=kernel)
    runs = [
        run_open_loop(body, contact, np.full(count, EFFORT), 1e-3)
        for count in (1, 2, 3, 5, 10, 20, 50, 100, 200, 501)
    ]
    assert runs[-1].velocity[-1] == pytest.approx(SETTLED, rel=1e-4)
    assert max(run.state.depth for run in runs) <= 1
