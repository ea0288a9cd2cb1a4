"""What is said of loops whose poles and margins are known: verdicts, causes, limits and doubts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.apps.design.conftest import loop

from bristle import controllers, friction, plants, references
from bristle.core.experiment import Feedforward, Run
from bristle.simulation.assessment import (
    Assessment,
    Friction,
    Motions,
    Stiffness,
    Verdict,
    WorkingPoint,
    assess,
    law_stiffness,
    motion_of,
    top_speed,
)
from bristle.simulation.linear_system import LinearSystem, SampledLoop

DT = 1e-3
STILL = np.zeros(0)


def constant(gain):
    return LinearSystem(np.zeros((0, 0)), STILL, STILL, gain)


def point(gain, delay=0, motions=Motions.ALL, under=Friction.NONE):
    """An integrator under a gain: its pole is 1 - gain without delay; with a sample of delay it is stable up to 1."""
    plant = LinearSystem(np.eye(1), np.ones(1), np.ones(1), 0.0)
    return WorkingPoint(motions, under, SampledLoop(plant, constant(-gain), delay, DT))


def assessed(*points, **changed):
    return Assessment("x", "translational", points, **changed)


GOOD, BAD = 0.3, 2.5  # of a gain without delay


@pytest.mark.parametrize(
    ("points", "verdict"),
    [
        ([point(GOOD)], Verdict.STABLE),
        ([point(BAD)], Verdict.DIVERGES),
        (
            [point(GOOD, motions=Motions.LARGE), point(BAD, motions=Motions.SMALL)],
            Verdict.OSCILLATES,
        ),
        ([point(BAD, motions=Motions.LARGE), point(GOOD, motions=Motions.SMALL)], Verdict.DIVERGES),
        (
            [
                point(BAD, motions=Motions.LARGE),
                point(GOOD, motions=Motions.LARGE, under=Friction.SLIDING),
            ],
            Verdict.OSCILLATES,
        ),
        ([point(BAD), point(BAD, under=Friction.SLIDING)], Verdict.DIVERGES),
        ([point(BAD, motions=Motions.SMALL)], Verdict.OSCILLATES),
    ],
)
def test_a_loop_with_growing_large_motions_diverges_under_any_friction(points, verdict):
    assert assessed(*points).verdict is verdict


def test_the_worst_point_is_without_friction_where_such_a_point_is_unstable():
    free, stuck = point(2.1), point(2.9, under=Friction.STUCK)
    assert assessed(free, stuck).worst is free
    assert assessed(point(GOOD), stuck).worst is stuck
    near = point(0.1)
    assert assessed(near, point(0.5)).worst is near
    assert assessed(free, stuck).bare == (free,)


def test_a_stable_loop_is_noted_with_its_largest_pole():
    result = assessed(point(GOOD), point(0.1, under=Friction.SLIDING)).finding
    assert (result.code, result.severity, dict(result.numbers), result.kind) == (
        "loop_stable",
        "note",
        {"radius": pytest.approx(0.9)},
        "translational",
    )


def at_most(gain_percent):
    """The largest gain is found from below."""
    return pytest.approx(gain_percent * 0.99, rel=0.0105)


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        # With one sample of delay an integrator is stable up to a gain of 1, without delay up to 2.
        (
            [point(1.5, 1)],
            {
                "why": "delay",
                "motions": "all",
                "delay": 1,
                "longest_delay": 0,
                "largest_gain_percent": at_most(100.0 / 1.5),
            },
        ),
        # No delay is short enough.
        (
            [point(BAD, 0)],
            {"why": "gains", "longest_delay": None, "largest_gain_percent": at_most(80.0)},
        ),
        ([point(3.0, 2)], {"why": "gains", "longest_delay": None}),
        # Every shorter delay is stable: 2 sin(pi/(2 (2 d + 1))) is 2, 1, 0.618, 0.445 for 0 to 3 samples.
        ([point(0.7, 3)], {"longest_delay": 1, "delay": 3}),
        # A law of the wrong sign has no gain that helps.
        ([point(-0.5)], {"why": "none", "largest_gain_percent": None}),
        # Friction that falls asks for gains.
        (
            [point(GOOD), point(BAD, under=Friction.SLIDING)],
            {"why": "falling_friction", "mend": "raise_gains"},
        ),
    ],
)
def test_an_unstable_loop_is_reported_with_its_cause_and_its_limits(points, expected):
    numbers = dict(assessed(*points).finding.numbers)
    assert {name: numbers.get(name) for name in expected} == expected


def test_a_finding_is_an_error_where_large_motions_diverge():
    result = assessed(point(1.5, 1)).finding
    assert (result.code, result.severity) == ("loop_diverges", "error")
    assert (
        assessed(point(GOOD, motions=Motions.LARGE), point(BAD, motions=Motions.SMALL)).finding.code
        == "loop_oscillates"
    )


@pytest.mark.parametrize(
    ("left", "under", "why", "mend"),
    [
        (0.0, Friction.STUCK, "stiffness_taken", "feed_desired"),
        (1.0, Friction.STUCK, "stuck", None),
        (-1.0, Friction.NONE, "gains", "feed_desired"),
        (1.0, Friction.NONE, "gains", None),
    ],
)
def test_stiffness_that_is_taken_asks_for_the_desired_motion(left, under, why, mend):
    points = [point(BAD)] if under is Friction.NONE else [point(GOOD), point(BAD, under=under)]
    kept = Stiffness(law=2.0, friction=3.0, compensation=5.0 - left)
    assert kept.left == left
    numbers = dict(assessed(*points, stiffness=kept).finding.numbers)
    assert (numbers["why"], numbers.get("mend")) == (why, mend)


def codes(assessment):
    return {item.code: dict(item.numbers) for item in assessment.doubts}


def test_margins_are_doubted_below_30_degrees_and_a_factor_of_two():
    # Without delay the phase margin is 90 degrees less asin(k/2), the gain margin 2/k.
    assert codes(assessed(point(0.9))) == {}
    tight = codes(assessed(point(1.1)))["small_margin"]
    assert (tight["phase"], tight["enough"], tight["motions"]) == (
        pytest.approx(90.0 - math.degrees(math.asin(0.55))),
        30.0,
        "all",
    )
    assert tight["gain"] == pytest.approx(2.0 / 1.1)
    assert codes(assessed(point(GOOD), point(1.1, under=Friction.STUCK))) == {}
    assert (
        codes(assessed(point(0.9), point(1.1, motions=Motions.SMALL)))["small_margin"]["motions"]
        == "small"
    )
    assert codes(assessed(point(BAD))) == {}  # an unstable loop has no margin


def test_the_least_phase_margin_without_friction_counts():
    # As above; at gains beyond 2 there is no crossover.
    least = pytest.approx(90.0 - math.degrees(math.asin(0.45)))
    assert assessed(point(GOOD), point(BAD), point(0.9), point(0.5)).least_phase == least
    assert (
        assessed(
            point(0.9), point(1.5, under=Friction.STUCK), point(1.5, under=Friction.SLIDING)
        ).least_phase
        == least
    )
    assert assessed(point(BAD), point(GOOD, under=Friction.STUCK)).least_phase is None


def test_a_law_that_switches_is_doubted():
    assert codes(assessed(point(GOOD), switches=True)) == {"switching_law": {}}


@pytest.mark.parametrize(("taken", "doubted"), [(2.4, False), (2.6, True)])
def test_half_of_the_stiffness_may_be_taken(taken, doubted):
    result = codes(
        assessed(point(GOOD), stiffness=Stiffness(law=2.0, friction=3.0, compensation=taken))
    )
    assert result == (
        {"stiffness_taken": {"taken": taken, "whole": 5.0, "law": 2.0}} if doubted else {}
    )


# --- of a variant ----------------------------------------------------------------------------------------------------


def test_the_motion_of_a_reference_has_a_sample_more_than_the_run():
    x, v = motion_of(loop())
    assert x.shape == v.shape == (4001,)
    assert np.max(np.abs(x)) == pytest.approx(5e-3)
    assert top_speed(loop()) == pytest.approx(2.0 * math.pi * 0.5 * 5e-3)
    assert top_speed(loop(reference=references.sine(amplitude=0.0, frequency=1.0))) == 0.0


def test_stiffness_of_a_law_at_low_frequency():
    lasting = LinearSystem(np.array([[0.5]]), np.ones(1), np.array([-1.0]), -3.0)
    assert law_stiffness(lasting) == pytest.approx(5.0, rel=1e-6)
    assert law_stiffness(LinearSystem(np.eye(1), np.ones(1), np.array([-1.0]), 0.0)) == math.inf


def test_friction_is_stuck_for_small_motions_and_slides_at_the_top_speed():
    kinds = {(item.motions, item.friction) for item in assess(loop()).points}
    assert kinds == {
        (Motions.ALL, Friction.NONE),
        (Motions.ALL, Friction.STUCK),
        (Motions.ALL, Friction.SLIDING),
    }
    resting = assess(loop(reference=references.sine(amplitude=0.0, frequency=1.0)))
    assert {item.friction for item in resting.points} == {Friction.NONE, Friction.STUCK}


LUGRE = friction.lugre(F_C=18.0, F_S=22.0, v_S=5e-3, sigma_0=5e6, sigma_1=1e3, sigma_2=80.0)


@pytest.mark.parametrize("gain", [0.5, 1.0])
def test_friction_fed_along_the_measured_motion_takes_stiffness_away(gain):
    fed = Feedforward(mass=20.0, friction=LUGRE, gain=gain, along="measured")
    kept = assess(loop(feedforward=fed, friction=LUGRE)).stiffness
    assert kept.law == pytest.approx(80.0 * 4000.0, rel=1e-6)
    assert (kept.friction, kept.compensation) == (
        pytest.approx(5e6, rel=1e-4),
        pytest.approx(gain * 5e6, rel=1e-4),
    )
    assert assess(loop(feedforward=replace(fed, along="desired"), friction=LUGRE)).stiffness is None
    dry = replace(fed, friction=friction.coulomb(F_C=18.0))
    assert assess(loop(feedforward=dry, friction=LUGRE)).stiffness is None


def test_feedforward_along_measured_motion_responds_like_its_friction():
    # Beside a free mass the whole of a compensator cancels the spring that holds it: what is left is the law.
    fed = Feedforward(mass=20.0, friction=LUGRE, gain=1.0, along="measured")
    weak = loop(
        feedforward=fed,
        friction=LUGRE,
        controller=controllers.cascade(k_p=1e-3, k_v=1e-3),
        run=Run(4.0, 1e-3, settle=1.0),
    )
    (stuck,) = [item for item in assess(weak).points if item.friction is Friction.STUCK]
    z = np.exp(1j * np.array([1e-4, 1e-3]))
    law = stuck.loop.law.response(z)
    # A spring over the mean of two positions and a damper over their difference.
    spring, damper = 5e6 * (1.0 + 1.0 / z) / 2.0, (1e3 + 80.0) * (1.0 - 1.0 / z) / 1e-3
    assert law == pytest.approx(spring + damper, rel=1e-3)


def test_a_table_behind_a_screw_slides_at_the_speed_of_its_arm():
    screw = plants.ball_screw(kind="rotational", J=1e-3, M=50.0, lead=5e-3, k=1e8, d=2e3)
    guide = friction.coulomb_viscous(F_C=25.0, F_v=3e4)
    axis = loop(
        compensator=None,
        plant=screw,
        friction=friction.coulomb_viscous(kind="rotational", F_C=0.02, F_v=1e-3),
        table=guide,
        sensor_at="motor",
        controller=controllers.cascade(kind="rotational", k_p=80.0, k_v=0.2),
        reference=references.sine(kind="rotational", amplitude=1.0, frequency=0.5),
        feedforward=Feedforward(),
    )
    (free,) = (item for item in assess(axis).points if item.friction is Friction.NONE)
    (sliding,) = (item for item in assess(axis).points if item.friction is Friction.SLIDING)
    # 3e4 N s/m are 0.019 N m s/rad beside a gain of 0.2
    assert sliding.margins.phase > free.margins.phase + 0.5
