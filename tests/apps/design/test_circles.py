"""Circles, bandwidths, shares of progress and causes of error, without a whole design."""

import math
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from tests.apps.design.conftest import COMPENSATOR, SLIDING, TRUTH, loop

from bristle import controllers, friction, plants, references, sensors
from bristle.apps.design import budget
from bristle.apps.design.analysis import (
    SAMPLES_LEAST,
    Circle,
    _axis,
    _bandwidth,
    _circles,
    _friction_at,
    circle_of,
    design,
)
from bristle.apps.design.budget import best_gain, causes_of, error_budget, nominal
from bristle.core.errors import InputError
from bristle.core.experiment import Experiment, Feedforward
from bristle.engine import interpreted

ANGLE = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)


def test_glitches_are_swings_within_30_degrees_of_a_reversal():
    deviation = np.zeros(720)
    # In half degrees
    for place, size in (
        (2, 1.0),
        (-2, -2.0),
        (180 + 58, 3.0),
        (360 - 61, 4.0),
        (540, -5.0),
        (540 + 62, 7.0),
    ):
        deviation[place] = size
    circle = Circle("x", 0.02, 0.05, ANGLE, deviation)
    assert circle.glitches == (3.0, 3.0, 0.0, 5.0)
    assert circle.peak_to_peak == 12.0


def test_the_circle_of_a_motion_has_half_its_travel_as_radius():
    radius, feed = circle_of(loop(reference=references.sine(amplitude=3e-3, frequency=0.5)))
    assert (radius, feed) == (
        pytest.approx(3e-3, rel=1e-4),
        pytest.approx(math.pi * 3e-3, rel=1e-4),
    )
    assert circle_of(loop(reference=references.circle(radius=0.02, feed=0.05))) == (0.02, 0.05)


def test_each_axis_of_a_circle_has_separate_noise_and_time_to_settle():
    rough = friction.maxwell_stribeck(
        F_C=20.0, F_S=28.0, v_S=2e-3, k_i=[6e6, 3e6], nu_i=[0.5, 0.5], scatter=0.05, seed=4
    )
    variant = loop(
        friction=rough,
        sensor=sensors.encoder(resolution=1e-6, noise=1e-7, seed=7),
        disturbance=np.ones(4000),
    )
    x, y = (_axis(variant, 0.02, 0.05, name) for name in ("x", "y"))
    assert (x.name, y.name) == ("fed, x", "fed, y")
    assert [each.friction.values["seed"] for each in (x, y)] == [4, 5]
    assert [each.sensor.values["seed"] for each in (x, y)] == [7, 8]
    revolution = 2.0 * math.pi * 0.02 / 0.05
    assert (x.run.settle, x.run.duration) == (
        pytest.approx(revolution),
        pytest.approx(2.0 * revolution),
    )
    assert (x.run.seeds, x.disturbance, x.injected, x.learning) == (1, None, None, None)
    assert (x.reference.values["radius"], x.reference.values["feed"]) == (0.02, 0.05)


def test_a_circle_whose_samples_do_not_show_it_is_not_run():
    still = loop(reference=references.sine(amplitude=0.0, frequency=1.0))
    assert _circles(still, (), None) == ()
    # A revolution takes 2 pi radius over feed: of 400 samples of a millisecond at least.
    feed = 2.0 * math.pi * 1e-4 / (SAMPLES_LEAST * 1e-3)
    assert (
        _circles(loop(reference=references.circle(radius=1e-4, feed=1.01 * feed)), (), None) == ()
    )
    (circle,) = _circles(loop(reference=references.circle(radius=1e-4, feed=0.99 * feed)), (), None)
    assert (circle.variant, circle.radius) == ("without compensation", 1e-4)
    assert circle.angle.size == pytest.approx(404, abs=1)
    assert np.all(np.diff(circle.angle) >= 0.0)


def test_friction_at_a_speed_counts_that_of_the_table_at_its_arm():
    plain = loop(friction=friction.coulomb_viscous(F_C=20.0, F_v=100.0))
    assert _friction_at(plain, 0.1) == pytest.approx(30.0)
    assert _friction_at(plain, 0.0) == 0.0
    screw = plants.ball_screw(kind="rotational", J=1e-3, M=50.0, lead=2e-3 * math.pi, k=1e8, d=2e3)
    motor = friction.coulomb_viscous(kind="rotational", F_C=0.02, F_v=1e-3)
    axis = loop(plant=screw, friction=motor, table=friction.coulomb_viscous(F_C=30.0, F_v=200.0))
    # At 10 rad/s an arm of 1 mm is 10 mm/s: 0.03 N m of the motor, and 32 N over the arm.
    assert _friction_at(axis, 10.0) == pytest.approx(0.02 + 0.01 + 1e-3 * 32.0)


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        (30.0, 30.0),
        ("30 rad/s", 30.0),
        ("30 Hz", 2.0 * math.pi * 30.0),
        ("60 1/min", 2.0 * math.pi),
    ],
)
def test_a_bandwidth_is_an_angular_frequency(raw, expected):
    assert _bandwidth(raw, "bandwidth", None) == pytest.approx(expected)


@pytest.mark.parametrize("raw", [0.0, -1.0, "0 Hz", "-3 rad/s", "3 mm", "30", math.inf, "inf Hz"])
def test_an_invalid_bandwidth_is_refused(raw):
    with pytest.raises(InputError, match="bandwidth"):
        _bandwidth(raw, "bandwidth", None)


def test_an_experiment_without_a_loop_is_not_designed():
    with pytest.raises(InputError, match="has no variants"):
        design(Experiment("bench", "translational", ()))


# --- causes ----------------------------------------------------------------------------------------------------------


def names(variant):
    return [cause.name for cause in causes_of(variant)]


def text_of(variant, name):
    return next(cause.description for cause in causes_of(variant) if cause.name == name)


def test_causes_state_their_size():
    rough = friction.maxwell_stribeck(
        F_C=20.0, F_S=28.0, v_S=2e-3, k_i=[6e6, 3e6], nu_i=[0.5, 0.5], scatter=0.05, seed=1
    )
    assert (
        text_of(loop(friction=rough), "irregularity") == "friction scatter of 5 % between reversals"
    )
    half = loop(
        compensator=nominal(TRUTH),
        feedforward=Feedforward(mass=20.0, friction=nominal(TRUTH), gain=0.5),
    )
    assert text_of(half, "amplitude") == "the compensator is 0.5 times the nominal friction"
    noisy = loop(sensor=sensors.encoder(resolution=1e-6, noise=1e-7))
    assert text_of(noisy, "encoder") == "resolution and noise of the encoder"
    assert text_of(loop(), "encoder") == "resolution of the encoder"


def test_an_amplitude_is_mended_by_the_factor_that_is_missing():
    half = loop(feedforward=Feedforward(mass=20.0, friction=nominal(TRUTH), gain=0.5))
    cause = next(item for item in causes_of(half) if item.name == "amplitude")
    assert cause.without(half).feedforward.gain == pytest.approx(1.0, rel=1e-6)
    shape = next(item for item in causes_of(loop()) if item.name == "shape").without(loop())
    assert shape.feedforward.friction == nominal(TRUTH)
    assert shape.feedforward.gain == pytest.approx(1.0 / best_gain(loop()))


EXACT = loop(sensor=sensors.encoder(), run=replace(loop().run, delay=0), friction=COMPENSATOR)


def fed(**changed):
    return {"feedforward": replace(EXACT.feedforward, **changed)}


def test_exact_components_are_no_cause():
    assert names(EXACT) == []
    assert names(replace(EXACT, **fed(gain=0.0))) == ["no compensation"]
    assert names(replace(EXACT, **fed(gain=1.1))) == ["amplitude"]


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"run": replace(EXACT.run, current_lag=1e-4)}, "delay"),
        ({"run": replace(EXACT.run, delay=2)}, "delay"),
        ({"run": replace(EXACT.run, delay=3, current_lag=1e-4)}, "delay"),
        ({"disturbance": np.ones(4000)}, "unexplained"),
        ({"sensor": sensors.encoder(resolution=1e-6, noise=1e-7)}, "encoder"),
        (fed(offset=1.0), "asymmetry"),
        (fed(offset=1.0, asymmetry=0.1), "asymmetry"),
    ],
)
def test_removing_a_cause_removes_its_error(changed, name):
    (cause,) = causes_of(replace(EXACT, **changed))
    assert cause.name == name
    assert cause.without(replace(EXACT, **changed)) == EXACT


def test_a_loop_without_a_compensator_needs_no_gain():
    assert best_gain(loop(compensator=None)) == 1.0
    still = loop(reference=references.sine(amplitude=0.0, frequency=1.0))
    assert best_gain(still) == 1.0


@interpreted()
def test_the_best_gain_is_a_projection_where_shapes_differ():
    # Of 30 N forward and 10 N backward on a compensator of 20 N: the mean.
    uneven = friction.find("coulomb+asymmetry")(F_C_pos=30.0, F_C_neg=10.0)
    assert best_gain(
        loop(friction=uneven, compensator=friction.coulomb(F_C=40.0))
    ) == pytest.approx(0.5)
    stribeck = friction.lugre(
        F_C=36.0, F_S=44.0, sigma_2=160.0, **(SLIDING | {"sigma_0": 1e7, "sigma_1": 2e3})
    )
    assert best_gain(loop(friction=stribeck, compensator=COMPENSATOR)) == pytest.approx(
        2.0, rel=1e-6
    )


def test_a_budget_sorts_causes_by_benefit_and_runs_loops_at_most_twice(monkeypatch):
    class Outcome:
        def __init__(self, size):
            self.status, self.time = None, np.arange(3.0)
            self.following_error = budget.statistics_of(np.array([0.0, size]))

    sizes = {"everything": 9.0, "nothing": 0.5}
    sizes |= {
        f"without {name}": size
        for name, size in (("amplitude", 7.0), ("shape", 3.0), ("asymmetry", 5.0), ("delay", 8.0))
    }
    ran = []

    def simulated(experiment, progress):
        ran.extend(experiment.variants)
        return type(
            "Result",
            (),
            {
                "variants": {
                    each.name: Outcome(sizes.get(each.name, 1.0)) for each in experiment.variants
                }
            },
        )

    monkeypatch.setattr(budget, "simulate", simulated)
    variant = loop(sensor=sensors.encoder(), run=replace(loop().run, seeds=5))
    result = error_budget(variant)
    assert [entry.cause for entry in result.entries] == ["shape", "asymmetry", "amplitude", "delay"]
    assert (result.variant, result.runs) == ("fed", 2)
    assert (result.all_causes.peak_to_peak, result.no_cause.peak_to_peak) == (9.0, 0.5)
    assert {each.run.seeds for each in ran} == {2}
    assert result.entries[0].alone.peak_to_peak == 1.0
    by_name = {each.name: each for each in ran}
    assert by_name["everything"] == replace(
        variant, name="everything", run=replace(variant.run, seeds=2)
    )
    assert causes_of(by_name["nothing"]) == ()
    assert names(by_name["delay alone"]) == ["delay"]
    assert "delay" not in names(by_name["without delay"])
    assert (
        error_budget(loop(controller=controllers.cascade(k_p=80.0, k_v=4000.0, k_ff=1.0))).runs == 1
    )


def test_the_progress_of_a_design_ends_with_its_circles(monkeypatch):
    reported = []

    def part(*passed):
        progress = passed[-1]
        for share in (0.0, 1.0):
            progress(share, "x")
        return ()

    module = import_module("bristle.apps.design.analysis")
    monkeypatch.setattr(module, "error_budget", part)
    monkeypatch.setattr(module, "_circles", part)
    monkeypatch.setattr(
        module, "proposals_for", lambda chosen, **requested: part(requested["progress"])
    )
    variants = (loop("plain", None), loop())
    designed = design(
        Experiment("bench", "translational", variants),
        progress=lambda share, text: reported.append(share),
    )
    assert reported == pytest.approx([0.0, 0.6, 0.6, 0.85, 0.85, 1.0])
    assert designed.variant.name == "fed"
    assert designed.budget == ()
    bare = Experiment("bench", "translational", (loop("first", None), loop("second", None)))
    assert design(bare, progress=lambda share, text: None).variant.name == "first"
    assert (
        design(bare, variant="second", progress=lambda share, text: None).variant.name == "second"
    )
