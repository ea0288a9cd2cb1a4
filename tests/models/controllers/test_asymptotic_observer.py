"""The observer of friction: its force is that of an axis that shares no code with it, and its poles are as designed."""

import math

import numpy as np
import pytest
from benchmarks.independent import DT, GAINS, M, dahl, follow, harmonic, lugre, sliders

from bristle import controllers
from bristle.core import InputError
from bristle.core.contracts import Reference

pytestmark = pytest.mark.usefixtures("compiled_axis")

OBSERVER = {"g_1": 60.0, "g_2": 600.0, "F_C": 42.7, "sigma_0": 18e6, "band": 2e-7}
LAW = controllers.asymptotic_observer(**GAINS, **OBSERVER)
MOTION = harmonic([(4.0e-6, 0.5, 0.0), (2.5e-6, 1.22, 1.0)], 1.5)


def force_error(law, axis):
    run = follow(law, axis, MOTION, seed=7)
    force = np.array([state.f_hat for state in run.states])
    return float(np.std((force - run.friction)[1200:]) / np.std(run.friction[1200:])), run


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "axis", [sliders(7), lugre(), dahl(F_C=36.0)], ids=["sliders", "lugre", "dahl"]
)
def test_the_observed_force_is_that_of_an_independent_axis(axis):
    off, run = force_error(LAW, axis)
    assert off < 0.08
    without, _ = force_error(LAW.with_values(sigma_0=0.0), axis)
    assert off < 0.75 * without  # the stiffness of pre-sliding is worth its two parameters
    disturbance = follow(controllers.disturbance_observer(**GAINS, g=60.0), axis, MOTION, seed=7)
    assert run.peak() < disturbance.peak()


def test_an_observer_makes_a_pid_follow_more_accurately():
    # With an endless Coulomb force, no stiffness and a pole near zero, nothing is observed.
    bare = controllers.asymptotic_observer(
        **GAINS, g_1=1e-9, g_2=1e9, F_C=1e9, sigma_0=0.0, K_I=20.0
    )
    assert (
        follow(LAW.with_values(K_I=20.0), sliders(7), MOTION, 7).peak()
        < 0.5 * follow(bare, sliders(7), MOTION, 7).peak()
    )


@pytest.mark.parametrize(
    ("changes", "bound"),
    [({"g_2": 530.0}, "537.5"), ({"sigma_0": 36e6}, "735.2"), ({"g_1": 130.0}, "607.5")],
)
def test_gains_with_complex_eigenvalues_are_refused_with_the_range(changes, bound):
    with pytest.raises(InputError, match=r"needs g_2 >= g_1 \+ 2\*sqrt\(2\*sigma_0/J\).*" + bound):
        LAW.with_values(**changes)


def transition(a, law=LAW):
    """Return the matrix of the sampled errors of the observer at a constant stiffness, with the force in units of J g_1."""
    step, p, unit = law.component.step, law.parameters._replace(F_C=1e30, sigma_0=a), M * 60.0
    still, columns = Reference(0.0, 0.0, 0.0, 0.0), []
    for start in ({"v_hat": 1.0}, {"f_hat": unit}):
        _, after = step(law.component.State(**start), still, 0.0, DT, p)
        columns.append((after.v_hat, after.f_hat / unit))
    return np.array(columns).T


def poles(law, a):
    return np.linalg.eigvals(transition(a, law))


def test_the_poles_in_sliding_are_those_of_the_design():
    assert sorted(poles(LAW, 0.0)) == pytest.approx(
        sorted((1.0 / (1.0 + 60.0 * DT), 1.0 / (1.0 + 600.0 * DT)))
    )


def test_the_slowest_pole_is_the_dominant_pole_at_every_stiffness():
    tight = LAW.with_values(g_2=60.0 + 2.0 * math.sqrt(2.0 * 18e6 / M) + 1e-6)
    for a in np.linspace(0.0, 2.0 * 18e6, 41):
        found = poles(tight, float(a))
        assert np.max(np.abs(np.imag(found))) < 1e-6
        assert np.max(np.real(found)) <= 1.0 / (1.0 + 60.0 * DT) + 1e-12
    # Beyond the largest stiffness, the same gains have complex poles.
    assert np.max(np.abs(np.imag(poles(tight, 2.2 * 18e6)))) > 1e-3


def test_no_change_of_the_stiffness_makes_the_errors_grow():
    # The worst of 300 sequences of stiffness, switched at random times: a Lyapunov function that all of them share bounds it.
    matrices = [transition(0.0), transition(2.0 * 18e6)]
    generator, worst = np.random.default_rng(3), 0.0
    for _ in range(300):
        error = np.array([1.0, 0.0])
        for hold in generator.integers(1, 60, 30):
            error = np.linalg.matrix_power(matrices[generator.integers(2)], int(hold)) @ error
        worst = max(worst, float(np.linalg.norm(error)))
    assert worst < 0.1


def stepped(positions, law=LAW):
    state, sides = law.component.start(positions[0], 0.0, 0.0, DT, law.parameters), []
    for place in positions:
        _, state = law.component.step(
            state, Reference(place, 0.0, 0.0, 0.0), place, DT, law.parameters
        )
        sides.append(state.side)
    return sides


def test_counts_of_an_encoder_are_no_reversals():
    # One count back and forth while the axis moves on: the direction stays.
    forward = 1e-6 * np.array([0.0, 0.125, 0.25, 0.375, 0.25, 0.375, 0.5, 0.375, 0.5, 0.625])
    assert stepped(forward)[2:] == [1] * 8
    assert stepped(np.concatenate((forward, 1e-6 * np.array([0.5, 0.375, 0.25]))))[-3:] == [
        1,
        -1,
        -1,
    ]


def test_a_law_that_takes_over_continues_its_effort():
    component, p = LAW.component, LAW.parameters
    begun = component.start(1e-3, 2e-3, 0.0, DT, p)
    assert (begun.side, begun.f_hat) == (1, 0.0)
    still = Reference(1e-3, 2e-3, 0.0, 5.0)
    resumed = component.resume(begun, still, 1e-3, 55.0, DT, p)
    assert resumed.f_hat == pytest.approx(50.0)
    assert component.resume(begun, still, 1e-3, math.nan, DT, p) == begun
    # At a steady speed in sliding, with no following error, the law asks for the same effort again.
    assert component.step(resumed, still, 1e-3, DT, p)[0] == pytest.approx(55.0)


def test_an_integral_stops_at_the_limit():
    law = controllers.asymptotic_observer(**GAINS, **OBSERVER, K_I=20.0, limit=1.0)
    _, limited = law.component.step(
        law.component.State(), Reference(1e-5, 0.0, 0.0, 0.0), 0.0, DT, law.parameters
    )
    free = law.with_values(limit=math.inf)
    _, moved = free.component.step(
        free.component.State(), Reference(1e-5, 0.0, 0.0, 0.0), 0.0, DT, free.parameters
    )
    assert (limited.integral, moved.integral) == (0.0, pytest.approx(DT * 150.0 * 1e-5))
