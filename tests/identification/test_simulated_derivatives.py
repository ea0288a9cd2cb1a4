"""Output error in open and in closed loop: its derivatives are those of the simulated signal, which keeps its bits."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.loops import AXIS, recorded_in_loop
from tests.identification import test_output_error
from tests.identification.test_sensitivities import own_model, own_trial

from bristle import friction, plants
from bristle.core import InputWarning
from bristle.friction import find
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.output_error import LAG, OutputError
from bristle.identification.outputs import Effort, Position
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat

VALUES = {"M": 19.0, "F_C": 21.0, "F_S": 27.0, "v_S": 4e-3, "F_v": 210.0, "delta_S": 1.8, "offset": 0.2, LAG: 1e-3}
VALUES |= {"sigma_0": 4e6, "sigma_1": 2e3, "sigma_2": 190.0}
YIELDING = {"offset": 0.1, "M": 2.1, "c": 45.0, "k": 4.8e4, "alpha": 3.8e4, "beta": 1.1e3, "gamma": 0.85, "delta": 0.25}


@pytest.fixture(scope="module")
def log():
    """Two stretches of a loop whose drive lags; the second one begins in motion."""
    log = recorded_in_loop(friction.stribeck(F_C=20.0, F_S=28.0, v_S=3e-3, F_v=200.0), 3, pairs=2, scatter=0.0, lag=0.8e-3, pulses=6.0)
    return replace(log, segments=(slice(0, 600), slice(700, 1300)))


def problem_of(loop, log, axis, component, plant):
    dataset = treat(log, axis)
    return OutputError.of(loop, InverseDynamics(dataset, parameters_of(component, PriorKnowledge(plant=plant), dataset)), [log], [axis])


def compare(problem, values):
    values = {name: values[name] for name in problem.parameters.free}
    residual, derivatives = problem.linearised(values)
    assert residual.tobytes() == problem.residual(values).tobytes()
    for column, (name, value) in zip(derivatives.T, values.items(), strict=True):
        step = 1e-6 * (abs(value) or 1.0)
        high, low = (problem.residual({**values, name: value + change}) for change in (step, -step))
        assert np.linalg.norm(column - (low - high) / (2.0 * step)) < 1e-4 * np.linalg.norm(column), name


@pytest.mark.parametrize("name", ["stribeck", "lugre"])
def test_derivatives_of_the_effort_of_a_loop_are_those_of_its_simulation(log, name):
    compare(problem_of(Effort, log, replace(AXIS, seeks_lag=True, presliding=5e-6), find(name), plants.inertia), VALUES)


def test_derivatives_of_a_settled_position_are_those_of_its_simulation():
    log = test_output_error.recorded()
    problem = problem_of(Position, log, test_output_error.AXIS, find("bouc_wen_classic"), plants.oscillator)
    assert problem.outputs[0].loop.periodic
    compare(problem, YIELDING)


def test_an_untranslatable_model_is_differentiated_by_differences_with_a_warning(log, monkeypatch):
    own = own_model(own_trial)
    problem = problem_of(Effort, log, AXIS, own, plants.inertia)
    values = {name: (VALUES | {"sigma_2": 200.0})[name] for name in problem.parameters.free}
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    with pytest.warns(InputWarning, match="bristle differentiates own by finite differences: .*math.tanh"):
        residual, derivatives = problem.linearised(values)
    assert (residual.tolist(), derivatives) == ([1.0] * 3, None)


def constant_trial(state, memory, motion, dt, p):
    return 0.0, state


def test_a_constant_force_is_differentiated_by_differences(log, monkeypatch):
    own = own_model(constant_trial)
    problem = problem_of(Effort, log, AXIS, own, plants.inertia)
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    with pytest.warns(InputWarning, match="returns a constant force"):
        assert problem.linearised({name: VALUES[name] for name in problem.parameters.free})[1] is None


class HalvedOutputError(OutputError):
    """An estimator of one's own, which differs in its residual only."""

    def residual(self, free):
        return np.full(3, 0.5)


def test_an_overridden_residual_is_used(log):
    problem = problem_of(Effort, log, AXIS, find("coulomb_viscous"), plants.inertia)
    residual, derivatives = HalvedOutputError(problem.inverse, problem.outputs).linearised(
        {name: VALUES[name] for name in problem.parameters.free}
    )
    assert (residual.tolist(), derivatives) == ([0.5] * 3, None)


def test_known_columns_of_the_log_require_differences(log, monkeypatch):
    problem = problem_of(Effort, log, AXIS, find("coulomb_viscous"), plants.inertia)
    beside = replace(problem, outputs=tuple(replace(output, regressors=(output.position,)) for output in problem.outputs))
    monkeypatch.setattr(OutputError, "residual", lambda self, free: np.ones(3))
    assert beside.linearised({name: VALUES[name] for name in problem.parameters.free})[1] is None
