"""Laws that learn friction, or observe it: what they learn is friction, and it stays bounded."""

import math

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.core import InputError
from bristle.core.contracts import Reference
from bristle.engine import interpreted, run_closed_loop
from bristle.models.plants import inertia

DT, M, REACH = 5e-4, 600.0, 6e-6
GAINS = {"J": M, "lambda_": 150.0, "K_1": 150.0}
LEARNING = {"reach": REACH, "Gamma": 8e5, "w_max": 60.0}
LAW = controllers.adaptive_hysteresis(**GAINS, **LEARNING)
# Elements of the thresholds that the law has, i reach / 6.
NUMBERS, WEIGHTS = np.array([1.0, 3.0, 5.0, 6.0]), np.array([4.0, 9.0, 5.0, 12.0])


def sliders(level=1.0):
    total = level * np.sum(WEIGHTS)
    return friction.maxwell_slip(
        F_C=total, k_i=level * WEIGHTS * 6.0 / (NUMBERS * REACH), nu_i=level * WEIGHTS / total
    )


def motion(duration):
    """Return a desired motion within pre-sliding: two frequencies, so that no loop is the one before."""
    t = DT * np.arange(round(duration / DT))
    parts = [(4e-6, 2.0 * math.pi * 0.25), (2e-6, 2.0 * math.pi * 0.61)]
    x = sum(a * (1.0 - np.cos(w * t)) for a, w in parts)
    v = sum(a * w * np.sin(w * t) for a, w in parts)
    a = sum(a * w * w * np.cos(w * t) for a, w in parts)
    return np.array([x, v, a, np.zeros(t.size)])


def follow(law, desired, level=1.0, sensor=None):
    return run_closed_loop(
        inertia(M=M), sliders(level), law, sensor or sensors.encoder(), desired, DT, steps=4
    )


def error_of(trace, desired, first=0.0, last=math.inf):
    """Root mean square of the error over a part of the time."""
    part = (trace.time >= first) & (trace.time < last)
    return float(np.sqrt(np.mean((desired[0] - trace.position)[part] ** 2)))


DESIRED = motion(50.0)


@pytest.fixture(scope="module")
def learned():
    return follow(LAW, DESIRED)


def test_friction_of_the_same_form_is_learned_from_zero(learned):
    desired = motion(20.0)
    without = follow(LAW.with_values(Gamma=0.0), desired)
    late = error_of(learned, DESIRED, 40.0)
    assert late < 0.02 * error_of(without, desired, 10.0)
    assert late < 0.3 * error_of(learned, DESIRED, 0.0, 4.0)


def test_a_level_that_changes_is_learned_again_and_weights_carry_to_another_motion(learned):
    again = follow(learned.controller, DESIRED, 1.6)
    late = error_of(again, DESIRED, 42.0)
    assert error_of(again, DESIRED, 0.0, 1.0) > 3.0 * late
    assert late < 1.7 * error_of(learned, DESIRED, 40.0)
    # At first try the law follows a motion of other amplitudes and frequencies.
    other = motion(8.0)[:, ::2] * np.array([[0.7], [1.4], [2.8], [0.0]])
    assert again.controller.values["w_6"] > 5.0
    assert error_of(follow(again.controller, other, 1.6), other) < 0.7 * error_of(
        follow(LAW, other, 1.6), other
    )
    frozen, empty = (law.with_values(Gamma=0.0) for law in (again.controller, LAW))
    assert error_of(follow(frozen, other, 1.6), other) < 0.15 * error_of(
        follow(empty, other, 1.6), other
    )
    begun = frozen.component.start(0.0, 0.0, 0.0, DT, frozen.parameters)
    assert [getattr(begun, f"w_{i}") for i in range(7)] == [
        frozen.values[f"w_{i}"] for i in range(7)
    ]


def test_elements_close_their_loops_and_end_at_their_thresholds():
    p, state = LAW.parameters, LAW.component.start(0.0, 0.0, 0.0, DT, LAW.parameters)
    positions = (
        np.concatenate(
            [np.linspace(0.0, 2.0, 40), np.linspace(2.0, 1.0, 20), np.linspace(1.0, 2.0, 20)]
        )
        * 1e-6
    )
    turned = []
    for r in positions:
        _, state = LAW.component.step(state, Reference(float(r), 0.0, 0.0, 0.0), float(r), DT, p)
        turned.append(state[4:10])
    # An element of the threshold i reach / 6 = i um has gone i um to its end; a loop within closes.
    assert turned[39] == pytest.approx([1.0, 1.0, 2.0 / 3.0, 0.5, 0.4, 1.0 / 3.0], abs=1e-12)
    assert turned[-1] == pytest.approx(turned[39], abs=1e-12)
    assert turned[59] == pytest.approx([0.0, 0.5, 1.0 / 3.0, 0.25, 0.2, 1.0 / 6.0], abs=1e-12)


@pytest.mark.slow
def test_weights_stay_bounded_for_a_thousand_seconds_with_an_encoder():
    law, desired = LAW.with_values(delta=2e-5, cutoff=400.0), motion(1000.0)
    trace = follow(law, desired, sensor=sensors.encoder(resolution=0.125e-6))
    for first in (20.0, 480.0, 980.0):
        assert error_of(trace, desired, first, first + 20.0) < 0.15e-6
    assert np.max(np.abs(trace.command)) < 2.5 * np.sum(WEIGHTS)


def test_weights_above_their_bound_are_refused():
    with pytest.raises(InputError, match=r"needs w_max >= w_0 to w_6.*Raise w_max"):
        LAW.with_values(w_0=-61.0)


def test_a_loop_that_diverges_has_learned_nothing():
    wild = LAW.with_values(K_1=-0.0, lambda_=1e7)
    with interpreted():
        trace = follow(wild, motion(1.0))
    assert trace.status.name == "NOT_FINITE"
    assert trace.controller == wild


# --- the observer of LuGre --------------------------------------------------------------------------------------

BRISTLES = {"F_C": 20.0, "F_S": 26.0, "v_S": 2e-3, "sigma_0": 2e6, "sigma_2": 30.0}


def test_at_a_steady_speed_the_observer_has_the_friction_of_the_model():
    v, law = 1.5e-3, controllers.lugre_observer(**GAINS, **BRISTLES)
    p, state = law.parameters, law.component.start(0.0, v, 0.0, DT, law.parameters)
    for k in range(2000):
        effort, state = law.component.step(
            state, Reference(k * v * DT, v, 0.0, 0.0), k * v * DT, DT, p
        )
    G = 20.0 + 6.0 * math.exp(-((v / 2e-3) ** 2))
    assert effort == pytest.approx(G + 30.0 * v, rel=1e-9)


@pytest.mark.slow
def test_the_error_corrects_the_bristles_to_the_friction():
    # At rest the observer integrates the error: what a constant force leaves goes, and without the gain it stays.
    def left(k):
        law = controllers.lugre_observer(**GAINS, **BRISTLES, k=k)
        rest = np.zeros((4, 6000))
        trace = run_closed_loop(
            inertia(M=M),
            friction.viscous(F_v=0.0),
            law,
            sensors.encoder(),
            rest,
            DT,
            disturbance=np.full(6000, 5.0),
        )
        return abs(trace.position[-1])

    assert left(0.2) < 1e-3 * left(0.0)
    # Without it the bristles are one more spring, beside that of the law.
    assert left(0.0) == pytest.approx(5.0 / (M * 150.0**2 - 2e6), rel=0.02)
