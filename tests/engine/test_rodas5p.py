"""Rodas5P: its coefficients against the conditions of order, and its samples against a solution that is much finer."""

from math import prod

import numpy as np
import pytest

from bristle import friction
from bristle.engine import rodas5p, run_adaptive
from bristle.plants import pulled_inertia

STAGES = 8


def trees(count):
    """Return the rooted trees of so many nodes, each as the tuple of its branches."""
    return forests(count - 1)


def forests(count):
    if count == 0:
        return [()]
    found = {tuple(sorted((branch, *rest))) for size in range(1, count + 1) for branch in trees(size) for rest in forests(count - size)}
    return sorted(found)


def nodes(tree):
    return 1 + sum(map(nodes, tree))


def density(tree):
    return nodes(tree) * prod(map(density, tree))


def elementary(tree, alpha, beta):
    """Return the weights of a tree in each stage: a branch that is alone goes through the Jacobian as well."""
    if not tree:
        return np.ones(STAGES)
    factors = [elementary(branch, alpha, beta) for branch in tree]
    return beta @ factors[0] if len(tree) == 1 else np.prod([alpha @ one for one in factors], axis=0)


def classical():
    """Return the method in the form of Hairer and Wanner (IV.7): alpha, Gamma, and what turns weights into theirs."""
    a, c = (one.reshape(STAGES, STAGES) for one in (rodas5p.ADVANCES, rodas5p.COUPLINGS))
    Gamma = np.linalg.inv(np.eye(STAGES) / rodas5p.TABLEAU[0] - c)
    return a @ Gamma, Gamma


def order_is(order, weights, part=1.0):
    alpha, Gamma = classical()
    for count in range(1, order + 1):
        for tree in trees(count):
            found = weights @ Gamma @ elementary(tree, alpha, alpha + Gamma)
            assert found == pytest.approx(part**count / density(tree), abs=1e-11), tree


def test_there_are_as_many_conditions_as_rooted_trees():
    assert [len(trees(count)) for count in range(1, 6)] == [1, 1, 2, 4, 9]


def test_the_last_stage_is_the_error_of_a_result_of_order_four_in_one_of_order_five():
    last = rodas5p.ADVANCES.reshape(STAGES, STAGES)[-1]
    order_is(5, last + np.eye(STAGES)[-1])
    order_is(4, last)


@pytest.mark.parametrize("part", [0.1, 0.5, 0.8])
def test_the_interpolant_has_order_four_anywhere_in_a_step(part):
    end = rodas5p.ADVANCES.reshape(STAGES, STAGES)[-1] + np.eye(STAGES)[-1]
    curve = part ** np.arange(3) @ rodas5p.DENSE.reshape(3, STAGES)
    order_is(4, part * (end + (1.0 - part) * curve), part)


def test_time_is_one_more_variable():
    # What depends on time must see the nodes and the drifts of a variable that grows as time does.
    alpha, Gamma = classical()
    assert rodas5p.TABLEAU[1 : 1 + STAGES] == pytest.approx(alpha.sum(axis=1), abs=1e-12)
    assert rodas5p.TABLEAU[1 + STAGES :] == pytest.approx(Gamma.sum(axis=1), abs=1e-12)


def test_all_samples_of_smooth_friction_come_with_order_four_under_an_effort_that_rises():
    # Sliding on a spring, always forward: no kink, and the Stribeck curve bends all the way. Steps hold many samples.
    model = friction.lugre(F_C=1.0, F_S=1.6, v_S=2.0, sigma_0=2.0, sigma_1=1.0, sigma_2=0.3)
    plant, effort = pulled_inertia(M=1.0, k=1.0, v_e=2.0), np.arange(256) / 64.0
    options = {"method": "rosenbrock", "v": 1.5, "x": -1.8, "state": model.component.State(0.7)}
    fine, *rough = (
        run_adaptive(plant, model, effort, 1.0 / 64.0, tolerance=1e6, max_step=h, **options) for h in (0.01, 0.25, 0.125, 0.0625)
    )
    assert np.min(fine.velocity) > 0.5
    for name in ("position", "velocity", "friction"):
        errors = [np.max(np.abs(getattr(one, name) - getattr(fine, name))) for one in rough]
        orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        assert np.all(orders > 4.0), (name, errors, orders)
