"""Drift under a force that never reaches break-away."""

import numpy as np
import pytest
from tests.simulation.certificates.ballscrew import (
    F_S,
    RIPPLE,
    STIFFNESS,
    UM,
    composite,
    gms,
    lugre,
    maxwell_slip,
)

from bristle import plants
from bristle.engine import run_open_loop
from bristle.simulation.certificates.certify import drift
from bristle.simulation.certificates.quasi_static import holding_of


def drift_of(model, ripple=RIPPLE):
    return drift(model, holding_of(model), ripple, False)


@pytest.mark.parametrize(
    ("model", "micrometres"),
    [
        (lugre(), 0.38947),
        (composite("paper"), 0.45492),
        (composite("leuven", n=2), 0.1762),
        (composite("leuven", n=4), 0.0412),
        (composite("leuven", n=8), 3.34e-3),
    ],
)
def test_bristles_that_slip_at_every_force_drift(model, micrometres):
    result = drift_of(model)
    assert result.value / UM == pytest.approx(micrometres, rel=5e-3)
    assert not result.passed


@pytest.mark.parametrize(("low", "high"), [(0.04, 0.08), (-0.05, 0.08), (0.08, 0.12)])
def test_the_drift_of_lugre_has_a_closed_form(low, high):
    # Loading: dx = dz/(1 - r), unloading: dx = dz/(1 + r), r = f/F_S.
    up = np.log((1.0 - low / F_S) / (1.0 - high / F_S))
    down = np.log((1.0 + high / F_S) / (1.0 + low / F_S))
    assert drift_of(lugre(), (low, high)).value == pytest.approx(
        F_S / STIFFNESS * (up - down), rel=1e-6
    )


@pytest.mark.parametrize(
    "model", [composite(), composite(kernel="reformed_dahl_exact"), maxwell_slip(), gms()]
)
def test_a_memory_in_the_position_does_not_drift(model):
    result = drift_of(model)
    assert abs(result.value) <= 1e-8 * UM
    assert result.passed


def test_an_opening_gate_drifts_before_break_away():
    result = drift_of(composite(), (0.06, 0.97 * F_S))
    assert result.value > result.threshold
    assert not result.passed


@pytest.mark.parametrize(
    "model", [lugre(), pytest.param(composite("paper"), marks=pytest.mark.slow)]
)
def test_a_mass_on_the_contact_drifts_as_far(model):
    # A slow triangle of the force on a body, by the integrator: nothing quasi-static in it.
    dt, period, cycles = 2e-4, 0.5, 6
    t = dt * np.arange(int(cycles * period / dt) + 1)
    low, high = RIPPLE
    wave = low + (high - low) * np.abs(2.0 * ((t / period) % 1.0) - 1.0)
    effort = np.concatenate((np.linspace(0.0, high, 2000, endpoint=False), wave))
    body = plants.inertia(kind="rotational", M=1e-4)
    trace = run_open_loop(body, model, effort, dt, steps=4, hold="linear")
    marks = 2000 + np.arange(2, cycles + 1) * int(period / dt)
    steps = np.diff(trace.position[marks])
    assert drift_of(model).value == pytest.approx(steps[-1], rel=5e-3)
