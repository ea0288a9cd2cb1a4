"""The coordinates of a search: relations are always satisfied, and derivatives include dependencies."""

from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.core import Axis, FrictionModel, Relation, Variable
from bristle.friction import find
from bristle.friction.slots import slotted
from bristle.identification.estimation import context_of
from bristle.identification.parameter_space import TransformedSpace
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat

CASES = {
    "as it is": ("elastoplastic", False, {}),
    "the factor is known": ("elastoplastic", False, {"sigma_0": 1e6}),
    "what it must stay below is known": ("elastoplastic", False, {"F_C": 12.0}),
    "each direction has its own": ("elastoplastic", True, {}),
    "excess over another": ("lugre", False, {}),
    "excess over both directions": ("preisach_lugre", True, {}),
}


def space_of(case):
    name, by_direction, fixed = CASES[case]
    model = find(name)
    model = slotted(model, asymmetry=True) if by_direction else model
    return space_for(model, fixed)


def space_for(model, fixed=None):
    dataset = treat(log_of(sines(2.0), sliding_effort(sines(2.0))), Axis())
    parameters = parameters_of(model, PriorKnowledge(values=fixed or {}), dataset)
    return TransformedSpace.within(parameters, context_of(dataset, PriorKnowledge()).scales)


def anywhere(space, rng):
    """Return coordinates within their bounds; where there is none, up to 3 typical magnitudes."""
    return rng.uniform(np.maximum(space.low, -3.0), np.where(np.isfinite(space.high), space.high, 3.0))


@pytest.mark.parametrize("case", CASES)
def test_relations_are_satisfied_everywhere_in_a_search(case):
    space, rng = space_of(case), np.random.default_rng(3)
    for _ in range(200):
        values = space.parameters.complete(space.values(anywhere(space, rng)))
        coulomb, static = ([value for name, value in values.items() if name.startswith(of)] for of in ("F_C", "F_S"))
        assert all(above >= below for above, below in zip(static, coulomb, strict=True))
        assert values.get("f_p", np.inf) > max(static)
        if "z_ba" in values:
            assert 0.0 <= values["sigma_0"] * values["z_ba"] < min(coulomb)


@pytest.mark.parametrize("case", CASES)
def test_coordinates_and_parameters_convert_both_ways(case):
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


def test_a_reflection_has_the_same_distance_within_the_bounds():
    space, rng = space_of("excess over another"), np.random.default_rng(6)
    best, names = 0.5 * (anywhere(space, rng) + anywhere(space, rng)), space.names
    near = best + 0.01 * rng.standard_normal(best.size)
    present, middle, here = (
        dict(zip(names, item, strict=True)) for item in (space.turned(near, best).numbers, space.numbers(best), space.numbers(near))
    )
    for name in set(names) - {"F_S"}:
        side = middle[name] ** 2 / here[name] if name in space.logarithmic else 2.0 * middle[name] - here[name]
        assert present[name] == pytest.approx(side)
    # Farther than the excess reaches down, F_S is F_C.
    excess = list(names).index("F_S")
    far = space.turned(np.where(np.arange(best.size) == excess, 3.0 * best, best), best)
    assert far.values["F_S"] == far.values["F_C"]
    assert far.numbers.tolist() == list(far.values.values())


class State(NamedTuple):
    pass


def commit(state, memory, move, p):
    return state


def trial(state, memory, motion, dt, p):
    return p.F_C * np.sign(motion.v), state


def own_model(relations, **ranges):
    """Return a model of a person's own, with what its parameters may be, and relations between them."""
    least = {"a": 1e-3, "b": 0.0, "F_C": 1e-3, "F_S": 0.0} | ranges
    quantities = {"a": "force/length", "b": "length", "F_C": "force", "F_S": "force"}
    fields: Any = [
        (name, Annotated[float, Variable(quantity, f"parameter {name}", min=least[name], excitation="sliding")])
        for name, quantity in quantities.items()
    ]
    return FrictionModel(
        name="own",
        description="relations of all kinds",
        Parameters=NamedTuple("Parameters", fields),
        State=State,
        trial=trial,
        commit=commit,
        relations=tuple(Relation(relation, lambda p: True, "Lower b") for relation in relations),
    )


@pytest.mark.parametrize(
    ("relations", "ranges"),
    [
        (["a * b < F_C"], {"b": -np.inf}),  # b may be negative: a share would never be
        (["a * b < F_C"], {"a": 0.0}),  # with a of zero there is no largest b
        (["a * b < F_C"], {"F_C": 0.0}),  # nothing is below zero
        (["2 * b < a"], {}),  # a number is no parameter
        (["F_S >= F_C", "a * F_C < F_S"], {"F_S": 1e-3}),  # F_S hangs on F_C already
        (["F_S >= F_C", "a * F_S < F_C"], {}),  # F_S has a floor
    ],
)
def test_a_relation_without_share_is_left_to_the_validation_of_the_model(relations, ranges):
    space = space_for(own_model(relations, **ranges))
    assert not any(transform.ceiling for transform in space.transforms)
    theta = space.theta(dict.fromkeys(space.names, 1.0))
    assert np.all(np.isfinite(space.numbers(theta)))


def test_a_share_of_a_share_is_computed_after_it():
    space = space_for(own_model(["a * b < F_C", "b * a < F_S"], b=1e-3, F_S=1e-3))
    (ceiling,) = [transform.name for transform in space.transforms if transform.ceiling]
    assert ceiling == "b"  # a in turn would hang on itself
    assert space.names.index("b") > max(space.names.index(name) for name in ("a", "F_C"))


def test_of_two_mutual_relations_the_first_makes_an_excess():
    space = space_for(own_model(["F_S >= F_C", "F_C >= F_S"]))
    assert [(transform.name, transform.above) for transform in space.transforms if transform.above] == [("F_S", ("F_C",))]
