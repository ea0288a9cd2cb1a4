"""Describing functions against closed forms, and limit cycles that they predict against the simulated loop."""

import control as ct
import numpy as np
import pytest

import bristle as br
from bristle.apps.targets import DescribingFunction, to_control
from bristle.core.contracts import example_of
from bristle.core.errors import InputError

AMPLITUDES = np.geomspace(2e-7, 1e-4, 9)


def described(friction, frequency=3.0, amplitudes=AMPLITUDES):
    return ct.describing_function(DescribingFunction(friction, frequency), amplitudes)


def test_coulomb_friction_is_a_relay_with_a_quarter_cycle_lead():
    np.testing.assert_allclose(
        described(br.friction.coulomb(F_C=7.0)), 4j * 7.0 / (np.pi * AMPLITUDES), rtol=1e-9
    )


def test_viscous_friction_grows_with_the_frequency():
    for frequency in (0.5, 40.0):
        result = described(br.friction.viscous(F_v=3.0), frequency)
        np.testing.assert_allclose(result, 2j * np.pi * frequency * 3.0, rtol=1e-5)


def test_a_slipping_element_agrees_with_caugheys_bilinear_hysteresis():
    # T. K. Caughey, "Sinusoidal excitation of a system with bilinear hysteresis", J. Appl. Mech. 27, 1960.
    stiffness, limit = 5e6, 10.0
    element = br.friction.maxwell_slip(F_C=limit, k_i=[stiffness], nu_i=[1.0])
    reach = limit / stiffness
    angle = np.arccos(1.0 - 2.0 * reach / np.maximum(AMPLITUDES, reach))
    elastic = stiffness / np.pi * (angle - 0.5 * np.sin(2.0 * angle))
    lost = 4.0 * limit / (np.pi * AMPLITUDES) * np.maximum(1.0 - reach / AMPLITUDES, 0.0)
    result = described(element)
    np.testing.assert_allclose(result, elastic + 1j * lost, rtol=2e-5, atol=1e-5 * stiffness)
    assert np.count_nonzero(reach > AMPLITUDES) >= 3


@pytest.mark.parametrize("name", ["maxwell_slip", "preisach_lugre", "lugre"])
def test_the_harmonic_computed_by_python_control_agrees(name):
    friction = example_of(br.friction.MODELS[name])
    for amplitude in (5e-7, 2e-5):
        custom = ct.describing_function(
            DescribingFunction(friction, 2.0), amplitude, num_points=2000, try_method=False
        )
        assert custom[0] == pytest.approx(described(friction, 2.0, amplitude), rel=1e-2)


def test_an_amplitude_in_micrometres_gives_the_same_function():
    dahl = example_of(br.friction.dahl)
    fine = DescribingFunction(dahl, "3 Hz", "um").describing_function(2.5)
    assert fine == pytest.approx(1e-6 * described(dahl, amplitudes=2.5e-6), rel=1e-12)


# --- limit cycles -------------------------------------------------------------------------------------------------

MASS = 10.0
PLANT = br.plants.inertia(M=MASS)
s = ct.tf("s")


def closed(law):
    """From the friction force to the position that gives way to it, in um/N."""
    plant = 1.0 / (MASS * s**2)
    return ct.minreal(1e6 * plant / (1.0 + plant * law), verbose=False)


def late_law():
    """A position loop whose effort comes 2 ms late: sound while the axis rolls, not where the contact holds it."""
    return ct.minreal((6e5 + 4e3 * s) / (1.0 + 2e-4 * s) * ct.tf(*ct.pade(2e-3, 4)), verbose=False)


def hum_of(friction, law):
    """Amplitude [um] and frequency [Hz] at which the loop ends up oscillating, from a small push."""
    law = ct.ss(law)
    law = ct.ss(law.A, law.B, -law.C, -law.D, inputs=["position"], outputs=["effort"], name="law")
    loop = ct.interconnect(
        [to_control(friction, PLANT, name="axis"), law],
        outputs=["position", "velocity", "friction"],
    )
    t = 1e-4 * np.arange(5000)
    options = {"solve_ivp_method": "RK45", "solve_ivp_kwargs": {"rtol": 1e-6, "atol": 1e-10}}
    x = ct.input_output_response(
        loop, t, 0.0, [0.0, 1e-4, *np.zeros(loop.nstates - 2)], **options
    ).outputs[0][t > 0.3]
    up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    crossings = up - x[up] / (x[up + 1] - x[up])
    return 1e6 * 0.5 * np.ptp(x), 1.0 / (1e-4 * np.mean(np.diff(crossings)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "friction",
    [
        br.friction.lugre(F_C=20.0, F_S=26.0, v_S=5e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=200.0),
        br.friction.dahl(F_C=20.0, sigma_0=1e7),
    ],
)
def test_a_limit_cycle_at_rest_agrees_with_the_prediction(friction):
    law, frequency = late_law(), 150.0
    assert closed(law).poles().real.max() < 0.0
    for _ in range(3):
        balance = ct.describing_function_response(
            closed(law),
            DescribingFunction(friction, frequency, "um"),
            np.geomspace(0.3, 6.0, 16),
            np.geomspace(200.0, 3000.0, 300),
        )
        ((amplitude, omega),) = balance.intersections
        frequency = omega / (2.0 * np.pi)
    seen_amplitude, seen_frequency = hum_of(friction, law)
    # The force holds harmonics that the describing function leaves out: that makes 0.7 % and 0.2 %.
    assert amplitude == pytest.approx(seen_amplitude, rel=0.015)
    assert frequency == pytest.approx(seen_frequency, rel=0.004)
    assert 100.0 < frequency < 200.0


@pytest.mark.slow
def test_the_describing_function_does_not_predict_hunting():
    friction = br.friction.lugre(
        F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e3, sigma_2=200.0
    )
    omega, dt = 2.0 * np.pi * 5.0, 5e-4
    law = MASS * (2.0 * omega**2 + omega**3 / s + 2.5 * omega * s / (1.0 + 1e-3 * s))
    sampled = ct.c2d(ct.ss(law), dt, "tustin")
    sampled = ct.ss(
        sampled.A,
        sampled.B,
        sampled.C,
        sampled.D,
        dt,
        inputs=["error"],
        outputs=["effort"],
        name="law",
    )
    difference = ct.summing_junction(inputs=["reference", "-position"], output="error")
    axis = to_control(friction, PLANT, dt=dt, steps=4, name="axis")
    loop = ct.interconnect(
        [axis, sampled, difference],
        inputs=["reference"],
        outputs=["position", "velocity", "friction"],
    )
    x = ct.input_output_response(loop, dt * np.arange(5000), np.full(5000, 1e-3)).outputs[0]
    assert np.ptp(x[2000:]) > 300e-6
    assert np.mean(np.abs(np.diff(x[2000:])) < 0.02 * np.abs(np.diff(x[2000:])).max()) > 0.7
    missed = min(
        abs(1.0 + closed(law)(2j * np.pi * frequency) * harmonics.describing_function(amplitude))
        for frequency in np.geomspace(0.05, 30.0, 8)
        for harmonics in (DescribingFunction(friction, frequency, "um"),)
        for amplitude in np.geomspace(0.1, 1000.0, 9)
    )
    assert missed > 0.1


# --- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("frequency", "unit", "words"),
    [
        (1.0, "um", r"A: must be positive; found 0\.0, allowed > 0 um"),
        (0.0, "m", "frequency: must be positive"),
        (1.0, "ms", "unit: "),
    ],
)
def test_what_has_no_describing_function_is_refused(frequency, unit, words):
    with pytest.raises(InputError, match=words):
        DescribingFunction(example_of(br.friction.dahl), frequency, unit).describing_function(0.0)
