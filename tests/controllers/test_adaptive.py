"""Laws that learn friction, or observe it: what they learn is friction, and it stays bounded."""

import math
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle import controllers, friction, sensors
from bristle.core import FrictionModel, InputError, Variable, kernel
from bristle.core.contracts import Reference
from bristle.engine import interpreted, run_closed_loop
from bristle.plants import inertia

DT, M, REACH = 5e-4, 600.0, 6e-6
GAINS = {"J": M, "lambda_": 150.0, "K_1": 150.0}
LEARNING = {"reach": REACH, "Gamma": 8e5, "w_max": 60.0}
WEIGHTS = np.array([4.0, 0.0, 9.0, 0.0, 5.0, 12.0])
HALF = 50.0


class Parameters(NamedTuple):
    """Elements that stick and slip, stronger after a while."""

    f: Annotated[np.ndarray, Variable("force", "limit of each element", min=0.0)]
    reach: Annotated[float, Variable("length", "largest break-away distance", min=1e-12)]
    half: Annotated[float, Variable("time", "when the level changes", min=0.0)]
    more: Annotated[float, Variable("1", "the level from then on", min=0.0)]


class State(NamedTuple):
    """How long it lasts."""

    t: Annotated[float, Variable("time", "time")] = 0.0


class Move(NamedTuple):
    """A step."""

    dx: Annotated[float, Variable("length", "displacement")]
    dt: Annotated[float, Variable("time", "length of the step")]


@kernel
def stretched(memory, i, dx, p):
    return max(-1.0, min(1.0, memory[i] + dx * len(p.f) / ((i + 1) * p.reach)))


@kernel
def trial(state, memory, motion, dt, p):
    dx = motion.v * dt
    force = 0.0
    for i in range(len(p.f)):
        force += p.f[i] * 0.5 * (memory[i] + stretched(memory, i, dx, p))
    return (p.more if state.t > p.half else 1.0) * force, Move(dx, dt)


@kernel
def commit(state, memory, move, p):
    for i in range(len(p.f)):
        memory[i] = stretched(memory, i, move.dx, p)
    return State(state.t + move.dt)


AGEING = FrictionModel(
    name="ageing",
    description="elements whose level changes",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    memory_size=lambda p: len(p.f),
)


def motion(duration):
    """Return a desired motion within pre-sliding: two frequencies, so that no loop is the one before."""
    t = DT * np.arange(round(duration / DT))
    parts = [(4e-6, 2.0 * math.pi * 0.25), (2e-6, 2.0 * math.pi * 0.61)]
    x = sum(a * (1.0 - np.cos(w * t)) for a, w in parts)
    v = sum(a * w * np.sin(w * t) for a, w in parts)
    a = sum(a * w * w * np.cos(w * t) for a, w in parts)
    return np.array([x, v, a, np.zeros(t.size)])


def follow(law, duration, *, level=1.0, half=HALF, resolution=0.0):
    ageing = AGEING(f=WEIGHTS, reach=REACH, half=half, more=level)
    sensor = sensors.encoder(resolution=resolution) if resolution else sensors.encoder()
    return run_closed_loop(inertia(M=M), ageing, law, sensor, motion(duration), DT, steps=4)


def rms(trace, first, last):
    e = motion(trace.time.size * DT)[0] - trace.position
    return float(np.sqrt(np.mean(e[(trace.time >= first) & (trace.time < last)] ** 2)))


@pytest.fixture(scope="module")
def learned():
    return follow(controllers.adaptive_hysteresis(**GAINS, **LEARNING), 2.0 * HALF, level=1.6)


@pytest.mark.slow
def test_friction_of_the_same_form_is_learned_from_zero(learned):
    without = follow(controllers.adaptive_hysteresis(**GAINS, **{**LEARNING, "Gamma": 0.0}), 20.0)
    assert rms(learned, 40.0, HALF) < 0.02 * rms(without, 10.0, 20.0)
    assert rms(learned, 40.0, HALF) < 0.3 * rms(learned, 0.0, 4.0)


@pytest.mark.slow
def test_a_level_that_changes_is_learned_again(learned):
    assert rms(learned, HALF, HALF + 1.0) > 3.0 * rms(learned, 40.0, HALF)
    assert rms(learned, 2.0 * HALF - 8.0, 2.0 * HALF) < 1.7 * rms(learned, 40.0, HALF)


def test_elements_close_their_loops_and_end_at_their_thresholds():
    law = controllers.adaptive_hysteresis(**GAINS, **LEARNING)
    p, state = law.parameters, law.component.start(0.0, 0.0, 0.0, DT, law.parameters)
    positions = np.concatenate([np.linspace(0.0, 2.0, 40), np.linspace(2.0, 1.0, 20), np.linspace(1.0, 2.0, 20)]) * 1e-6
    turned = []
    for r in positions:
        _, state = law.component.step(state, Reference(float(r), 0.0, 0.0, 0.0), float(r), DT, p)
        turned.append(state[4:10])
    # An element of the threshold i reach / 6 = i um has gone i um to its end; a loop within closes.
    assert turned[39] == pytest.approx([1.0, 1.0, 2.0 / 3.0, 0.5, 0.4, 1.0 / 3.0], abs=1e-12)
    assert turned[-1] == pytest.approx(turned[39], abs=1e-12)
    assert turned[59] == pytest.approx([0.0, 0.5, 1.0 / 3.0, 0.25, 0.2, 1.0 / 6.0], abs=1e-12)


@pytest.mark.slow
def test_weights_stay_bounded_for_a_thousand_seconds_with_an_encoder():
    law = controllers.adaptive_hysteresis(**GAINS, **LEARNING, delta=2e-5, cutoff=400.0)
    trace = follow(law, 1000.0, level=1.6, half=500.0, resolution=0.125e-6)
    for first in (20.0, 480.0, 980.0):
        assert rms(trace, first, first + 20.0) < 0.15e-6
    assert np.max(np.abs(trace.command)) < 2.0 * 1.6 * np.sum(WEIGHTS)


@pytest.mark.slow
def test_weights_carry_to_another_motion(learned):
    # The law of the run that learned begins with its weights: at first try it follows a motion of other amplitudes and frequencies.
    law = controllers.adaptive_hysteresis(**GAINS, **LEARNING)
    other = motion(8.0)[:, ::2] * np.array([[0.7], [1.4], [2.8], [0.0]])
    same = AGEING(f=WEIGHTS, reach=REACH, half=0.0, more=1.6)

    def error(chosen):
        trace = run_closed_loop(inertia(M=M), same, chosen, sensors.encoder(), other, DT, steps=4)
        return float(np.sqrt(np.mean((other[0] - trace.position) ** 2)))

    carried = learned.controller
    assert carried.values["w_6"] > 5.0
    assert error(carried) < 0.7 * error(law)
    frozen = carried.with_values(Gamma=0.0)
    assert error(frozen) < 0.15 * error(law.with_values(Gamma=0.0))
    begun = frozen.component.start(0.0, 0.0, 0.0, DT, frozen.parameters)
    assert [getattr(begun, f"w_{i}") for i in range(7)] == [carried.values[f"w_{i}"] for i in range(7)]


def test_weights_above_their_bound_are_refused():
    with pytest.raises(InputError, match=r"needs w_max >= w_0 to w_6.*Raise w_max"):
        controllers.adaptive_hysteresis(**GAINS, **LEARNING, w_0=-61.0)


def test_the_law_of_a_run_has_what_it_learned_unless_the_loop_diverges():
    calm = controllers.adaptive_hysteresis(**GAINS, **LEARNING)
    wild = controllers.adaptive_hysteresis(**{**GAINS, "K_1": -0.0, "lambda_": 1e7}, **LEARNING)
    with interpreted():
        learned, lost = follow(calm, 0.2), follow(wild, 1.0)
    assert learned.controller.values["w_1"] > 0.0
    assert (lost.status.name, lost.controller == wild) == ("NOT_FINITE", True)


# --- the observer of LuGre --------------------------------------------------------------------------------------

BRISTLES = {"F_C": 20.0, "F_S": 26.0, "v_S": 2e-3, "sigma_0": 2e6, "sigma_2": 30.0}


def test_at_a_steady_speed_the_observer_has_the_friction_of_the_model():
    v, law = 1.5e-3, controllers.lugre_observer(**GAINS, **BRISTLES)
    model = friction.lugre(**BRISTLES, sigma_1=0.0)
    p, state = law.parameters, law.component.start(0.0, v, 0.0, DT, law.parameters)
    for k in range(2000):
        effort, state = law.component.step(state, Reference(k * v * DT, v, 0.0, 0.0), k * v * DT, DT, p)
    G = 20.0 + 6.0 * math.exp(-((v / 2e-3) ** 2))
    assert effort == pytest.approx(G + 30.0 * v, rel=1e-9)
    assert model.F_C < effort < model.F_S


@pytest.mark.slow
def test_the_error_corrects_the_bristles_to_the_friction():
    # At rest the observer integrates the error: what a constant force leaves goes, and without the gain it stays.
    def left(k):
        law = controllers.lugre_observer(**GAINS, **BRISTLES, k=k)
        rest = np.zeros((4, 6000))
        trace = run_closed_loop(inertia(M=M), friction.viscous(F_v=0.0), law, sensors.encoder(), rest, DT, disturbance=np.full(6000, 5.0))
        return abs(trace.position[-1])

    assert left(0.2) < 1e-3 * left(0.0)
    # Without it the bristles are one more spring, beside that of the law.
    assert left(0.0) == pytest.approx(5.0 / (M * 150.0**2 - 2e6), rel=0.02)
