"""The error budget: what a cause is, and what is left without it."""

import itertools
from dataclasses import replace

import pytest
from tests.apps.design.conftest import COMPENSATOR, TRUTH, loop

from bristle import controllers, friction
from bristle.apps.design.budget import causes_of, nominal
from bristle.core.experiment import Experiment
from bristle.engine import interpreted
from bristle.simulation import simulate
from bristle.simulation.tuning import feeds_inertia, with_known_motion


def test_each_cause_of_the_loop_is_found_and_no_other():
    assert [item.name for item in causes_of(loop())] == [
        "amplitude",
        "shape",
        "asymmetry",
        "encoder",
        "delay",
    ]
    plain = loop(compensator=None)
    assert [item.name for item in causes_of(plain)] == [
        "no compensation",
        "asymmetry",
        "encoder",
        "delay",
    ]


def test_a_loop_without_velocity_and_inertia_feedforward_lags():
    deaf = loop(
        controller=loop().controller.with_values(k_ff=0.0),
        feedforward=replace(loop().feedforward, mass=0.0),
    )
    lag = causes_of(deaf)[0]
    assert lag.name == "lag"
    message = lag.without(deaf)
    assert message.controller == loop().controller
    assert message.feedforward.mass == pytest.approx(20.0, rel=1e-3)
    assert "lag" not in [item.name for item in causes_of(loop())]


def test_inertia_is_fed_forward_once():
    # The sliding mode law feeds the inertia by itself, the cascade does not.
    sliding = controllers.sliding_mode(J=20.0, lambda_=100.0, K_1=100.0)
    assert [feeds_inertia(item, 1e-3) for item in (sliding, loop().controller)] == [True, False]
    assert with_known_motion(loop(controller=sliding)).feedforward.mass == 0.0


def test_a_loop_that_knows_everything_has_no_cause_of_error():
    known = loop()
    for cause in causes_of(known):
        known = cause.without(known)
    assert causes_of(known) == ()


def test_causes_are_removed_in_any_order():
    ways = []
    for order in itertools.permutations(causes_of(loop())):
        left = loop()
        for cause in order:
            left = cause.without(left)
        ways.append(
            replace(
                left, feedforward=replace(left.feedforward, gain=round(left.feedforward.gain, 9))
            )
        )
    assert all(way == ways[0] for way in ways)


def test_the_nominal_friction_is_the_same_in_both_directions():
    even = nominal(TRUTH).values
    assert (even["F_C_pos"], even["F_C_neg"], even["offset"]) == (20.0, 20.0, 0.0)


@interpreted()
def test_the_nominal_friction_repeats_itself():
    rough = friction.maxwell_stribeck(
        F_C=20.0, F_S=28.0, v_S=2e-3, k_i=[6e6, 3e6], nu_i=[0.5, 0.5], scatter=0.05, seed=1
    )
    assert nominal(rough).values["scatter"] == 0.0
    assert "irregularity" in [item.name for item in causes_of(loop(friction=rough))]


def test_the_budget_matches_its_simulated_loops(designed):
    budget = designed.budget
    assert budget.variant == "fed"
    assert {item.cause for item in budget.entries} == {
        "amplitude",
        "shape",
        "asymmetry",
        "encoder",
        "delay",
    }
    entry = next(item for item in budget.entries if item.cause == "asymmetry")
    even = next(item for item in causes_of(loop()) if item.name == "asymmetry").without(
        loop("even")
    )
    result = simulate(Experiment("one", "translational", (loop(), even)))
    assert entry.without == result.variants["even"].following_error
    assert (
        budget.all_causes
        == simulate(Experiment("one", "translational", (loop(),))).variants["fed"].following_error
    )


def test_a_compensator_of_the_right_size_and_shape_is_no_cause():
    assert nominal(TRUTH) != COMPENSATOR
    assert "shape" not in [item.name for item in causes_of(loop(compensator=nominal(TRUTH)))]
