"""The columns of elements agree with the model and its slots, computed by the kernels of friction."""

import numpy as np
import pytest
from tests.identification.test_elements import MASS, elements_log

from bristle import plants
from bristle.friction import find
from bristle.identification.element_models import elements_of
from bristle.identification.estimation import context_of
from bristle.identification.fixed_shape import shaped
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.preprocessing import treat
from bristle.identification.problem import covariance_of

T = 1e-3 * np.arange(3000)
AROUND = {"load": 1.0 + 0.3 * np.sin(9.0 * T), "temperature": 293.15 + 10.0 * np.cos(3.7 * T)}


@pytest.mark.parametrize(
    ("name", "plant", "known"),
    [
        ("maxwell_slip", "inertia", {"M": MASS}),
        ("maxwell_slip+position", "inertia", {}),
        ("maxwell_slip+periodic", "oscillator", {}),
        ("maxwell_slip+load+temperature", "inertia", {"M": MASS}),
        ("maxwell_slip+position+periodic+load+temperature", "inertia", {}),
        ("maxwell_slip+position+periodic+load+temperature+asymmetry", "inertia", {}),
    ],
)
def test_columns_times_values_are_the_effort_of_the_model_with_its_slots(name, plant, known):
    dataset = treat(elements_log(duration=3.0, **AROUND), None, cutoff=80.0, decimation=2)
    context = context_of(dataset, PriorKnowledge(None, known, getattr(plants, plant), 2e-5))
    elements = elements_of(context, find(name))
    rng, r = np.random.default_rng(3), elements.thresholds
    stiffness = np.zeros(r.size)
    stiffness[[4, 11, 20]] = 3e6, 1e6, 4e5
    values = elements.parameters.complete({factor: 0.1 * rng.standard_normal() for factor in elements.parameters.free})
    values |= dict.fromkeys(elements._levels, float(stiffness @ r)) | {"s": float(np.sum(stiffness))}
    assert set(values) == {*elements.parameters.variables, "s"} - {"k_i", "nu_i"}

    columns = elements._for_factors(np.array([values[factor] for factor in elements._factors]), slice(None)).columns
    explained = columns @ np.concatenate([stiffness, [values.get(factor, 0.0) for factor in elements._single]])
    view = shaped(find(name), stiffness[stiffness > 0.0], (stiffness * r)[stiffness > 0.0])
    wanted = InverseDynamics(dataset, context.parameters(view)).predicted(values)
    assert explained + dataset.effort - elements._target == pytest.approx(wanted, rel=1e-9, abs=1e-9 * float(np.max(np.abs(wanted))))


def test_errors_of_level_and_stiffness_are_those_of_sums_over_free_elements():
    dataset = treat(elements_log(duration=3.0, noise=0.5), None, cutoff=80.0, decimation=2)
    elements = elements_of(context_of(dataset, PriorKnowledge(None, {"M": MASS})), find("maxwell_slip"))
    problem, solution = elements.solution()
    residual = problem.residual(solution.values)
    result = dict(zip(solution.space.reported, covariance_of(solution, residual).std.tolist(), strict=True))
    best = elements._best(slice(None))
    pressed, count = best.stiffness > 0.0, best.stiffness.size
    assert np.sum(pressed) > 2
    columns = best.columns[:, np.concatenate([pressed, np.ones(best.columns.shape[1] - count, dtype=bool)])]
    square = float(residual @ residual) / (residual.size - len(result))
    covariance = square * np.linalg.inv(columns.T @ columns)[: np.sum(pressed), : np.sum(pressed)]
    for name, share in (("F_C", elements.thresholds[pressed]), ("s", np.ones(np.sum(pressed)))):
        assert result[name] == pytest.approx((share @ covariance @ share) ** 0.5, rel=1e-3), name
