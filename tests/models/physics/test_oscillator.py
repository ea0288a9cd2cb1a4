"""A mass on a spring and a damper: against the closed form, and its inverse against itself."""

import numpy as np
import pytest
from scipy.signal import lti

from bristle import friction, plants
from bristle.engine import run_open_loop

pytestmark = pytest.mark.usefixtures("in_plain_python")

NONE = friction.coulomb(F_C=0.0)
BODY = plants.oscillator(M=2.0, c=10.0, k=5e4)


def test_free_vibration_converges_to_the_closed_form_with_order_two():
    t = 1e-3 * np.arange(200)
    effort = 30.0 * np.sin(2.0 * np.pi * 20.0 * t) + 5.0
    exact = lti([1.0], [2.0, 10.0, 5e4]).output(effort, t)[1]
    errors = []
    for steps in (4, 8):
        trace = run_open_loop(BODY, NONE, effort, 1e-3, steps=steps, hold="linear")
        errors.append(np.max(np.abs(trace.position - exact)) / np.max(np.abs(exact)))
    assert errors[-1] < 1e-2
    assert np.log2(errors[0] / errors[-1]) == pytest.approx(2.0, abs=0.1)


def test_energy_is_conserved_without_dissipation():
    free = plants.oscillator(M=2.0, c=0.0, k=5e4)
    trace = run_open_loop(free, NONE, np.zeros(500), 1e-3, steps=1, x=1e-3)
    energy = 0.5 * 5e4 * trace.position**2 + 0.5 * 2.0 * trace.velocity**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


def test_the_inverse_returns_the_effort():
    t = 1e-4 * np.arange(2000)
    effort = 20.0 * np.sin(2.0 * np.pi * 7.0 * t)
    trace = run_open_loop(BODY, NONE, effort, 1e-4, steps=1, hold="linear")
    acceleration = np.gradient(trace.velocity, 1e-4)
    back = BODY.component.inverse(trace.position, trace.velocity, acceleration, BODY.parameters)
    assert np.max(np.abs(back - effort)[2:-2]) < 1e-3 * np.max(effort)
