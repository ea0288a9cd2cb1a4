"""Gains that a delay allows, the circle that two axes run, and the design as a whole."""

import math
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from tests.apps.design.conftest import TRUTH, loop
from tests.apps.design.laws import rig

from bristle import controllers, friction, plants, references, sensors
from bristle.apps.design import Verdict, assess, delays_of, design, run_circles
from bristle.apps.design.budget import causes_of
from bristle.core import InputError
from bristle.core.experiment import Experiment, Feedforward, Run
from bristle.simulation.assessment import law_stiffness
from bristle.simulation.linear_system import LARGE, linear_law
from bristle.simulation.tuning import PHASE, count_response, inertia_of, proposals_for, tuned


def margins(variant, law, lag=None):
    """Return the margins of a loop with a law, and with another lag of its current loop [s]."""
    run = variant.run if lag is None else replace(variant.run, current_lag=lag)
    return [item.margins for item in assess(replace(variant, controller=law, run=run)).bare]


def keeps(variant, law):
    """Return whether a loop keeps its margins: with its lag and half a millisecond more, or over 0.2 to 1 ms."""
    stated = variant.run.current_lag
    requested = ((stated, 40.0), (stated + 5e-4, 30.0)) if stated else ((2e-4, 40.0), (1e-3, 40.0))
    return all(
        margin.phase >= least and margin.gain >= 2.0
        for lag, least in requested
        for margin in margins(variant, law, lag)
    )


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0, 1, 3])
@pytest.mark.parametrize("name", ["sliding_mode", "disturbance_observer"])
def test_tuned_gains_keep_the_margins_and_no_higher_ones_do(name, delay):
    variant = rig(delay)
    law = tuned(variant, name).law
    assert keeps(variant, law)
    higher = law.with_values(
        **{
            key: 1.12 * law.values[key]
            for key in ("lambda_", "K_1", "K_2", "g")
            if key in law.values
        }
    )
    assert not keeps(variant, higher)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sliding_mode", "disturbance_observer"])
def test_an_unstated_lag_does_not_count_as_zero(name):
    lagging = rig(0)
    unstated = replace(lagging, run=replace(lagging.run, current_lag=0.0))
    law = tuned(unstated, name).law
    assert keeps(unstated, law)
    for lag in np.linspace(2e-4, 1e-3, 9):  # every lag between, too
        assert all(
            margin.phase >= 40.0 and margin.gain >= 2.0 for margin in margins(unstated, law, lag)
        )
    short = replace(lagging, run=replace(lagging.run, current_lag=1e-4))
    assert tuned(short, name).bandwidth > 1.1 * tuned(unstated, name).bandwidth


@pytest.mark.slow
def test_a_boundary_layer_that_a_person_set_is_not_made_thinner():
    variant = rig(1)
    custom = tuned(variant, "sliding_mode").law.values["phi"]
    wide = replace(variant, controller=variant.controller.with_values(phi=50.0 * custom))
    assert tuned(wide, "sliding_mode").law.values["phi"] == pytest.approx(50.0 * custom)


@pytest.mark.slow
def test_less_delay_allows_more_gain():
    gains = [tuned(rig(delay), "sliding_mode").law.values["lambda_"] for delay in range(4)]
    assert gains == sorted(gains, reverse=True)
    assert gains[0] > 1.5 * gains[3]


def test_tuned_gains_are_near_the_rule_of_thumb():
    variant = rig(1, switching=0.0, layer=0.0)
    values = tuned(variant, "sliding_mode").law.values
    assert 0.5 <= (values["lambda_"] + values["K_1"]) * delays_of(variant).total <= 1.0


def test_a_law_that_no_gains_are_known_for_is_left_alone():
    assert (
        tuned(
            replace(rig(1), controller=controllers.cascade(k_p=1.0, k_v=1.0, kind="rotational")),
            "layered",
        )
        is None
    )


def test_the_delay_of_a_loop_is_the_sum_of_its_parts():
    parts = delays_of(rig(1))
    assert (parts.hold, parts.computation, parts.drive) == (2.5e-4, 5e-4, 2e-4)
    # A difference over a sample lags by half of it, the low-pass by (1 - a)/a samples.
    share = -math.expm1(-2.0 * math.pi * 400.0 * 5e-4)
    assert parts.velocity == pytest.approx(5e-4 * (0.5 + (1.0 - share) / share), rel=0.01)
    assert parts.total == sum(parts)


@pytest.mark.parametrize(("averaging", "samples"), [(1, 0.5), (2, 1.0)])
def test_a_cascade_lags_by_its_averaging(averaging, samples):
    law = controllers.cascade(k_p=40.0, k_v=3000.0, k_i=2e4, averaging=averaging)
    assert delays_of(loop(controller=law)).velocity == pytest.approx(samples * 1e-3, rel=0.02)


def test_mass_and_stiffness_are_those_of_the_loop():
    assert inertia_of(loop()) == pytest.approx(20.0, rel=1e-3)
    assert law_stiffness(
        linear_law(controllers.cascade(k_p=80.0, k_v=4000.0), 1e-3, LARGE)
    ) == pytest.approx(80.0 * 4000.0, rel=1e-6)
    assert (
        law_stiffness(linear_law(controllers.cascade(k_p=80.0, k_v=4000.0, k_i=1e4), 1e-3, LARGE))
        == math.inf
    )
    # A count in one sample is a velocity of 1 mm/s.
    assert count_response(loop()) == pytest.approx(4000.0 * (1e-3 + 80.0 * 1e-6), rel=1e-6)


# --- the circle ---------------------------------------------------------------------------------------------------


def test_friction_makes_a_circle_bulge_where_an_axis_reverses_and_compensation_flattens_it():
    plain, fed = run_circles((loop("plain", None), loop("fed", TRUTH)), 5e-3, 5e-3)
    assert plain.angle[0] < 0.02
    assert plain.angle[-1] > 2.0 * math.pi - 0.02
    elsewhere = np.abs(np.abs(plain.angle % (0.5 * np.pi) - 0.25 * np.pi)) < 0.1
    assert min(plain.glitches) > 5.0 * np.ptp(
        plain.deviation[elsewhere & (plain.angle < 0.5 * np.pi)]
    )
    assert max(fed.glitches) < 0.2 * min(plain.glitches)
    assert plain.peak_to_peak >= max(plain.glitches)


# --- the whole ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_proposals_keep_margins_and_reduce_the_error():
    soft = controllers.cascade(k_p=40.0, k_v=2000.0, k_ff=1.0)
    present, *rest = proposals_for(loop(controller=soft, run=Run(1.5, 1e-3, delay=1, settle=0.5)))
    assert [other.name for other in rest] == ["tuned", "with an observer"]
    for other in rest:
        assert other.assessment.verdict is Verdict.STABLE
        assert min(point.margins.phase for point in other.assessment.bare) >= PHASE
        assert other.following_error.peak_to_peak < present.following_error.peak_to_peak
        assert other.effort_rms < 1.1 * present.effort_rms


def test_the_first_variant_that_feeds_friction_forward_is_designed(designed):
    assert designed.variant.name == "fed"
    assert designed.is_stable
    assert [assessment.name for assessment in designed.assessments] == ["plain", "fed"]
    assert designed.circles[0].variant == "without compensation"


def test_a_loop_that_diverges_has_no_budget(monkeypatch):
    monkeypatch.setattr(
        import_module("bristle.apps.design.analysis"), "proposals_for", lambda variant, **asked: ()
    )
    result = design(Experiment("slow", "translational", (loop(run=replace(loop().run, delay=9)),)))
    assert (result.is_stable, result.budget) == (False, None)


def test_a_name_that_is_no_variant_is_refused():
    with pytest.raises(InputError, match="no such variant") as refused:
        design(Experiment("bench", "translational", (loop(),)), variant="fedd")
    assert "Did you mean 'fed'?" in str(refused.value)


def test_a_bandwidth_that_is_asked_for_is_given_as_far_as_the_margins_allow():
    variant = rig(1)
    widest = tuned(variant, "sliding_mode")
    requested = tuned(variant, "sliding_mode", 0.5 * widest.bandwidth)
    assert requested.bandwidth == requested.law.values["lambda_"] == 0.5 * widest.bandwidth
    too_much = tuned(variant, "sliding_mode", 3.0 * widest.bandwidth)
    assert too_much.bandwidth == pytest.approx(widest.bandwidth, rel=0.05)


def test_an_axis_with_a_screw_is_stable_and_errs_by_its_backlash():
    screw = plants.ball_screw(
        kind="rotational", J=1e-3, M=50.0, lead=5e-3, k=1e8, d=2e3, backlash="3 um"
    )
    motor = friction.coulomb_viscous(kind="rotational", F_C=0.02, F_v=1e-3)
    guide = friction.find("coulomb_viscous+asymmetry")(
        F_C_pos=30.0, F_C_neg=20.0, F_v_pos=200.0, F_v_neg=200.0
    )
    axis = loop(
        compensator=None,
        plant=screw,
        friction=motor,
        table=guide,
        sensor_at="motor",
        controller=controllers.cascade(kind="rotational", k_p=80.0, k_v=0.2),
        sensor=sensors.encoder(kind="rotational", resolution=1e-5),
        reference=references.sine(kind="rotational", amplitude=1.0, frequency=0.5),
        feedforward=Feedforward(),
        run=Run(2.0, 1e-3, delay=1, settle=0.5),
    )
    assert assess(axis).verdict is Verdict.STABLE
    assert {cause.name for cause in causes_of(axis)} == {
        "lag",
        "asymmetry",
        "encoder",
        "delay",
        "backlash",
    }
    assert inertia_of(axis) == pytest.approx(1e-3 + 50.0 * (5e-3 / (2.0 * math.pi)) ** 2, rel=0.01)
