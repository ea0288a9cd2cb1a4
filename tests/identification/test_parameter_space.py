"""The coordinates of a search: relations hold at each of them, and derivatives go through what one hangs on another."""

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.friction import find
from bristle.friction.slots import slotted
from bristle.identification.parameter_space import TransformedSpace
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.sliding_friction import context_of

CASES = {
    "as it is": ("elastoplastic", False, {}),
    "the factor is known": ("elastoplastic", False, {"sigma_0": 1e6}),
    "what it must stay below is known": ("elastoplastic", False, {"F_C": 12.0}),
    "each direction has its own": ("elastoplastic", True, {}),
    "excess over another": ("lugre", False, {}),
}


def space_of(case):
    name, by_direction, fixed = CASES[case]
    model = find(name)
    model = slotted(model, asymmetry=True) if by_direction else model
    dataset = treat(log_of(sines(2.0), sliding_effort(sines(2.0))), Axis())
    parameters = parameters_of(model, PriorKnowledge(values=fixed), dataset)
    return TransformedSpace.within(parameters, context_of(dataset, PriorKnowledge()).scales)


def anywhere(space, rng):
    """Return coordinates within their bounds; where there is none, up to 3 typical magnitudes."""
    return rng.uniform(np.maximum(space.low, -3.0), np.where(np.isfinite(space.high), space.high, 3.0))


@pytest.mark.parametrize("case", CASES)
def test_relations_hold_wherever_a_search_goes(case):
    space, rng = space_of(case), np.random.default_rng(3)
    for _ in range(200):
        values = space.parameters.complete(space.values(anywhere(space, rng)))
        coulomb, static = ([value for name, value in values.items() if name.startswith(of)] for of in ("F_C", "F_S"))
        assert all(above >= below for above, below in zip(static, coulomb, strict=True))
        if "z_ba" in values:
            assert 0.0 <= values["sigma_0"] * values["z_ba"] < min(coulomb)


@pytest.mark.parametrize("case", CASES)
def test_coordinates_come_back_from_their_parameters(case):
    space, rng = space_of(case), np.random.default_rng(4)
    for _ in range(20):
        theta = anywhere(space, rng)
        values = space.parameters.complete(space.values(theta))
        np.testing.assert_allclose(space.theta(values), theta, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_a_derivative_is_the_limit_of_differences(case):
    space, rng = space_of(case), np.random.default_rng(5)
    for _ in range(10):
        theta = anywhere(space, rng)
        steps = 1e-6 * np.eye(theta.size)
        differences = np.stack([space.numbers(theta + step) - space.numbers(theta - step) for step in steps], axis=1)
        size = np.abs(space.numbers(theta))[:, None] + 1e-12
        np.testing.assert_allclose(space.derivative(theta) / size, 0.5e6 * differences / size, rtol=1e-5, atol=1e-6)
