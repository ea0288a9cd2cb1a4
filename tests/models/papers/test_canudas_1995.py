"""C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction".

IEEE Transactions on Automatic Control 40(3), 1995, doi:10.1109/9.376053; and how later papers print it.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.models.papers.rippled import drift_of, steps_per_cycle
from tests.simulation.certificates.ballscrew import (
    F_S,
    RIPPLE,
    STIFFNESS,
    UM,
    composite,
    lugre,
    maxwell_slip,
)

from bristle import friction
from bristle.core.contracts import Motion
from bristle.engine import force_along, run_open_loop, settled
from bristle.models.plants import inertia

# The parameters of the paper's Table I.
PAPER = friction.lugre(
    F_C="1 N",
    F_S="1.5 N",
    v_S="0.001 m/s",
    sigma_0="1e5 N/m",
    sigma_1="316.2277660168 N*s/m",
    sigma_2="0.4 N*s/m",
)


def steady(model, v):
    state, memory = settled(model, v)
    return force_along(model, np.array([v]), 1e-3, state=state, memory=memory)[0]


def test_steady_sliding_gives_the_stribeck_curve_between_its_limits():
    # Break-away force at creep, Coulomb force far beyond the Stribeck velocity, viscous on top.
    assert steady(PAPER, 1e-8) == pytest.approx(1.5, rel=1e-4)
    assert steady(PAPER, 0.1) == pytest.approx(1.0 + 0.04, rel=1e-9)
    at_stribeck_velocity = steady(PAPER, 1e-3) - 0.4 * 1e-3
    assert (at_stribeck_velocity - 1.0) / 0.5 == pytest.approx(1.0 / np.e, rel=1e-9)


def test_a_bristle_equation_with_the_stiffness_counted_twice_misses_its_own_steady_state():
    # Printed with sigma_0 z / g(v) *and* sigma_0 g(v) = G(v), the deflection settles at G / sigma_0^2 and the force at
    # G / sigma_0: a factor 1e5 below the steady state that the same papers state.
    p = PAPER.parameters
    v = 2e-3
    G = steady(PAPER, v) - p.sigma_2 * v

    def printed(_, z):
        g = G / p.sigma_0
        return [v * (1.0 - p.sigma_0 * z[0] / g)]

    z = solve_ivp(printed, (0.0, 1e-5), [0.0], method="Radau", rtol=1e-9, atol=1e-20).y[0, -1]
    assert p.sigma_0 * z == pytest.approx(G / p.sigma_0, rel=1e-6)
    ours, _ = settled(PAPER, v)
    assert p.sigma_0 * ours.z == pytest.approx(G, rel=1e-9)


def test_micro_damping_is_not_viscous_friction():
    # It damps the bristles while they stretch, and vanishes in steady sliding.
    stiff = PAPER.with_values(sigma_1=10.0 * PAPER.values["sigma_1"])
    assert steady(stiff, 5e-3) == pytest.approx(steady(PAPER, 5e-3), rel=1e-9)
    first, _ = PAPER.component.trial(
        PAPER.component.State(), (), Motion(1e-3, 0.0), 1e-9, PAPER.parameters
    )
    again, _ = PAPER.component.trial(
        PAPER.component.State(), (), Motion(1e-3, 0.0), 1e-9, stiff.parameters
    )
    assert again > 5.0 * first


def test_presliding_is_a_spring_of_stiffness_sigma_0():
    # Section III: a small step of force displaces the mass by force over stiffness.
    trace = run_open_loop(inertia(M=1.0), PAPER, np.full(4000, 0.05), 1e-4, steps=2)
    assert trace.position[-1] == pytest.approx(0.05 / 1e5, rel=0.05)


def test_break_away_force_falls_as_the_force_rises_faster():
    # Figure 4 of the paper: varying break-away force.
    peaks = []
    for rate in (1.0, 5.0, 25.0):
        dt = 2e-5
        effort = rate * dt * np.arange(round(2.0 / rate / dt))
        trace = run_open_loop(inertia(M=1.0), PAPER, effort, dt, hold="linear")
        sliding = np.flatnonzero(trace.velocity > 1e-3)
        peaks.append(effort[sliding[0]])
    assert peaks[0] > peaks[1] > peaks[2] > 1.0


# --- bristles that always slip, and so drift --------------------------------------------------------------------------


def test_the_drift_is_the_same_by_the_integrator_and_by_the_slow_path():
    dynamic = steps_per_cycle(lugre(), *RIPPLE, top=RIPPLE[1])[-1]
    assert dynamic / UM == pytest.approx(0.38980, rel=2e-3)
    assert drift_of(lugre()).value == pytest.approx(dynamic, rel=2e-3)


@pytest.mark.slow
def test_lugre_drifts_after_break_away_and_the_gate_comes_to_rest():
    walks, rests = (
        steps_per_cycle(model, *RIPPLE, top=1.02 * F_S, cycles=16)
        for model in (lugre(), composite(sigma_2=0.03))
    )
    assert walks[-1] > 0.3 * UM
    assert abs(rests[-1]) < 1e-8 * UM


def test_spring_slider_elements_rest():
    assert drift_of(maxwell_slip()).passed


@pytest.mark.slow
@pytest.mark.parametrize("top", [0.08, 0.99 * F_S])
def test_spring_slider_elements_rest_with_a_mass_on_them(top):
    assert abs(steps_per_cycle(maxwell_slip(), *RIPPLE, top=top)[-1]) < 1e-8 * UM


@pytest.mark.parametrize("amplitude", [0.005, 0.01, 0.02])
def test_a_small_ripple_drifts_by_the_difference_of_both_compliances(amplitude):
    # 1/(1 - r) and 1/(1 + r) differ at any bias: the smaller the ripple, the more nearly is the drift their difference
    # times its width.
    bias = 0.06
    moved = drift_of(lugre(), (bias - amplitude, bias + amplitude)).value
    width, r = 2.0 * amplitude / STIFFNESS, bias / F_S
    assert moved == pytest.approx(width * (1.0 / (1.0 - r) - 1.0 / (1.0 + r)), rel=0.05)
    assert np.sign(moved) == 1.0
