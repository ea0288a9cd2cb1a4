"""One sample of each law by hand: what the error asks for, what is kept, and what a limit takes."""

import math

import pytest

from bristle.core.contracts import Reference
from bristle.models.controllers import (
    adaptive_hysteresis,
    cascade,
    disturbance_observer,
    lugre_observer,
    open_loop,
    sliding_mode,
    super_twisting,
)
from bristle.models.controllers.limits import within_drive
from bristle.models.controllers.velocity import (
    FILTERED_DIFFERENCE,
    TRACKING_OBSERVER,
    motion_before,
    observed,
    samples_before,
)

DT = 0.1
# 0.02 m behind, at 0.5 m/s where 0.7 m/s are asked for: with a slope of 10 the surface is 0.2 + 0.2 = 0.4 m/s.
ASKED = Reference(0.07, 0.7, 3.0, 5.0)
SURFACE = {"J": 2.0, "lambda_": 10.0, "K_1": 4.0}
PULL = 2.0 * (3.0 + 10.0 * 0.2 + 4.0 * 0.4) + 5.0


def stepped(law, reference=ASKED, measured=0.05, **state):
    begun = law.component.initial_state(law.parameters)._replace(**state)
    return law.component.step(begun, reference, measured, DT, law.parameters)


BEHIND = Reference(0.03, 0.3, 3.0, 5.0)
ON_SURFACE = Reference(0.05, 0.5, 3.0, 5.0)
INTEGRAL = cascade(k_p=10.0, k_v=100.0, k_i=250.0, limit=25.0)
SWITCHING = sliding_mode(**SURFACE, K_2=6.0)
TWISTING = super_twisting(**SURFACE, k_1=3.0, k_2=20.0)
BRISTLES = {"F_C": 20.0, "F_S": 28.0, "v_S": 0.5, "sigma_0": 100.0, "sigma_2": 3.0, "k": 0.25}
OBSERVER = lugre_observer(**SURFACE, **BRISTLES)
SLIP = 100.0 * 0.5 / (20.0 + 8.0 * math.exp(-1.0)) * 0.1
Z = 0.02 * math.exp(-SLIP) + 0.1 * (1.0 - math.exp(-SLIP)) / SLIP * (0.5 + 0.25 * 0.4)
LEARNING = adaptive_hysteresis(**SURFACE, reach=0.12, Gamma=50.0, w_max=8.0, delta=0.1)
EAGER = LEARNING.with_values(Gamma=1e6, delta=0.0)
# 0.02 m further: the stops of 0.02, 0.04 ... 0.12 m have taken all, half ... a sixth of it.
STOPS = [1.0 / i for i in range(1, 7)]
STRONG = {f"w_{i}": 1.0 for i in range(1, 7)}


@pytest.mark.parametrize(
    ("law", "reference", "before", "effort", "after"),
    [
        pytest.param(
            cascade(k_p=10.0, k_v=100.0, k_i=50.0, k_ff=0.5),
            ASKED,
            {"q_1": 0.03, "r_1": 0.05, "integral": 7.0},
            # 10 * 0.02 + 0.5 * 0.2 - 0.2 m/s, and 50 * 0.1 * 0.1 N more in the integral.
            100.0 * 0.1 + 7.5 + 5.0,
            {"q_1": 0.05, "q_2": 0.03, "integral": 7.5, "r_1": 0.07, "r_2": 0.05},
            id="a cascade commands a velocity and then an effort",
        ),
        pytest.param(
            cascade(k_p=10.0, k_v=100.0, k_ff=0.5, averaging=2),
            ASKED,
            {"q_1": 9.0, "q_2": 0.01, "r_1": 9.0, "r_2": 0.03},
            100.0 * (0.2 + 0.5 * 0.2 - 0.2) + 5.0,
            {},
            id="over two samples",
        ),
        *(
            pytest.param(
                INTEGRAL.with_values(limit=limit),
                Reference(place, 0.0, 0.0, 0.0),
                {"q_1": 0.05, "integral": start},
                effort,
                {"integral": integral},
                id=claim,
            )
            for limit, place, start, effort, integral, claim in (
                (100.0, 0.07, 5.0, 30.0, 10.0, "an integral grows"),
                (25.0, 0.07, 5.0, 25.0, 5.0, "stops at the limit"),
                (25.0, 0.03, 80.0, 25.0, 75.0, "and moves back from it"),
            )
        ),
        *(
            pytest.param(
                SWITCHING.with_values(phi=phi),
                ASKED,
                {"q": 0.0},
                PULL + 12.0 * share,
                {"q": 0.05, "v": 0.5},
                id=f"phi {phi}",
            )
            for phi, share in ((0.0, 1.0), (0.8, 0.5), (0.4, 1.0), (0.1, 1.0))
        ),
        pytest.param(
            SWITCHING,
            BEHIND,
            {"q": 0.0},
            2.0 * (3.0 - 2.0 - 1.6) + 5.0 - 12.0,
            {},
            id="switching on the other side",
        ),
        pytest.param(SWITCHING, ON_SURFACE, {"q": 0.0}, 11.0, {}, id="no switching on the surface"),
        pytest.param(SWITCHING.with_values(limit=9.0), ASKED, {"q": 0.0}, 9.0, {}, id="a limit"),
        pytest.param(
            TWISTING,
            ASKED,
            {"q": 0.0, "w": 1.0},
            PULL + 2.0 * (3.0 * math.sqrt(0.4) + 3.0),
            {"w": 3.0},
            id="the root and its sign",
        ),
        pytest.param(
            TWISTING,
            ON_SURFACE,
            {"q": 0.0, "w": 1.0},
            13.0,
            {"w": 1.0},
            id="no sign on the surface",
        ),
        pytest.param(
            TWISTING.with_values(limit=10.0),
            ASKED,
            {"q": 0.0, "w": 1.0},
            10.0,
            {"w": 1.0},
            id="no integration at a limit",
        ),
        pytest.param(
            TWISTING.with_values(limit=10.0),
            ASKED,
            {"q": 0.0, "w": -90.0},
            -10.0,
            {"w": -88.0},
            id="but away from it",
        ),
        pytest.param(
            OBSERVER,
            ASKED,
            {"q": 0.0, "z": 0.02},
            PULL + 100.0 * Z + 1.5,
            {"q": 0.05, "v": 0.5, "z": Z},
            id="motion and error move the bristles of an observer",
        ),
        pytest.param(
            OBSERVER.with_values(limit=5.0),
            ASKED,
            {"q": 0.0, "z": 0.02},
            5.0,
            {"z": 0.02},
            id="none at a limit",
        ),
        pytest.param(
            LEARNING,
            ASKED,
            {"q": 0.0, "r": 0.05, "w_0": 2.0} | STRONG,
            PULL + 2.0 + sum(STOPS),
            # The surface lies 0.3 outside of the dead zone: 50 * 0.1 * 0.3 N for a stop that is strained.
            {f"E_{i}": 1.0 / i for i in range(1, 7)}
            | {f"w_{i}": 1.0 + 1.5 / i for i in range(1, 7)}
            | {"w_0": 3.5, "q": 0.05, "v": 0.5, "r": 0.07},
            id="stops compensate and are learned",
        ),
        pytest.param(
            LEARNING.with_values(delta=0.5),
            ASKED,
            {"q": 0.0, "r": 0.05},
            PULL,
            {"w_0": 0.0, "w_1": 0.0},
            id="not near 0",
        ),
        pytest.param(
            EAGER.with_values(limit=1.0),
            ASKED,
            {"q": 0.0, "r": 0.05, "w_0": 2.0},
            1.0,
            {"w_0": 2.0},
            id="nor at a limit",
        ),
        pytest.param(
            EAGER,
            ASKED,
            {"q": 0.0, "r": -1.0},
            PULL,
            {"E_1": 1.0, "E_6": 1.0, "w_0": 8.0, "w_1": 8.0, "w_6": 8.0},
            id="bounds",
        ),
        pytest.param(
            EAGER,
            BEHIND,
            {"q": 0.0, "r": -1.0},
            3.8,
            {"w_0": -8.0, "w_1": 0.0, "w_6": 0.0},
            id="on either side",
        ),
        pytest.param(
            EAGER, ASKED, {"q": 0.0, "r": 1.0}, PULL, {"E_1": -1.0, "E_6": -1.0}, id="and stops"
        ),
        pytest.param(
            open_loop(), ASKED, {}, 5.0, {}, id="the command of an open loop is the feedforward"
        ),
    ],
)
def test_a_sample_of_each_law(law, reference, before, effort, after):
    result, state = stepped(law, reference, **before)
    assert result == pytest.approx(effort)
    assert {name: getattr(state, name) for name in after} == pytest.approx(after)


CASCADE = cascade(k_p=10.0, k_v=100.0, k_i=50.0, k_ff=1.0)
DISTURBED = disturbance_observer(**SURFACE, g=20.0)


@pytest.mark.parametrize(
    ("law", "begun"),
    [
        (CASCADE, (0.05 - 0.05 + 0.01, 0.05 - 0.1 + 0.04, 0.0, 0.0, 0.0)),
        (DISTURBED, (0.01, 0.3, 20.0 * 2.0 * 0.3, 4.0)),
        (LEARNING, (0.01, 0.3, 0.01, *[0.0] * 13)),
        (open_loop(), ()),
    ],
)
def test_a_law_begins_with_the_motion_so_far(law, begun):
    assert law.component.start(0.05, 0.5, 2.0, DT, law.parameters) == pytest.approx(begun)


@pytest.mark.parametrize(
    ("law", "effort", "after"),
    [
        # Without an integral the law asks for 100 (0.2 + 0.55 - 0.4) + 5 N.
        (
            CASCADE,
            30.0,
            {"r_1": 0.07 - 0.07 + 0.015, "r_2": 0.07 - 0.14 + 0.06, "integral": 30.0 - 40.0},
        ),
        (CASCADE, math.nan, {"integral": 0.0}),
        (CASCADE.with_values(k_i=0.0), 30.0, {"integral": 0.0}),
        # From rest, the surface is 0.2 + 0.7 m/s.
        (
            TWISTING,
            60.0,
            {
                "w": (
                    60.0 - 2.0 * (3.0 + 10.0 * 0.2 + 4.0 * 0.4) - 5.0 - 2.0 * 3.0 * math.sqrt(0.4)
                )
                / 2.0
            },
        ),
        (TWISTING, math.nan, {"w": 0.0}),
        (TWISTING.with_values(k_2=0.0), 60.0, {"w": 0.0}),
        (TWISTING.with_values(J=0.0), 60.0, {"w": 0.0}),
        (DISTURBED, 12.0, {"z": 12.0 + 7.0 - 4.0, "feedback": 7.0}),
        (DISTURBED, math.nan, {"z": 12.0, "feedback": 4.0}),
    ],
)
def test_a_law_that_takes_over_continues_the_effort(law, effort, after):
    motion = (0.0, 0.0, 0.0) if law.component is super_twisting else (0.05, 0.5, 2.0)
    begun = law.component.start(*motion, DT, law.parameters)
    resumed = law.component.resume(begun, ASKED, 0.05, effort, DT, law.parameters)
    assert {name: getattr(resumed, name) for name in after} == pytest.approx(after)


def test_a_disturbance_observer_feeds_back_the_unexplained_force():
    effort, state = stepped(DISTURBED, q=0.0, z=4.0, feedback=9.0)
    # Toward the effort of the last sample and g J v = 20 N by 1 - exp(-2).
    z = 4.0 + (1.0 - math.exp(-2.0)) * (9.0 + 20.0 - 4.0)
    assert (effort, state.z, state.feedback) == pytest.approx((PULL + z - 20.0, z, PULL + z - 25.0))


POLE = math.exp(-2.0 * math.pi * 0.5)


@pytest.mark.parametrize(
    ("estimator", "cutoff", "expected"),
    [
        (FILTERED_DIFFERENCE, 5.0, (0.05, 0.3 + (1.0 - POLE) * 0.2)),
        (FILTERED_DIFFERENCE, math.inf, (0.05, 0.5)),
        # 0.03 m ahead, and surprised by 0.02 m.
        (
            TRACKING_OBSERVER,
            5.0,
            (0.03 + (1.0 - POLE**2) * 0.02, 0.3 + (1.0 - POLE) ** 2 * 0.02 / DT),
        ),
    ],
)
def test_a_velocity_is_a_filtered_difference_or_that_of_an_observer(estimator, cutoff, expected):
    assert observed(0.0, 0.3, 0.05, DT, estimator, cutoff) == pytest.approx(expected)


def test_samples_before_lie_on_the_parabola_of_the_motion():
    assert samples_before(1.0, 2.0, 3.0, DT) == pytest.approx((1.0 - 0.2 + 0.015, 1.0 - 0.4 + 0.06))
    assert motion_before(1.0, 2.0, 3.0, DT) == pytest.approx((0.815, 1.7))


@pytest.mark.parametrize(
    ("law", "injected", "limit"),
    [
        (20.0, (), 20.0),
        (math.inf, (), 30.0),
        (math.inf, ([4.0, -7.0],), 37.0),
        (math.inf, ([],), 30.0),
    ],
)
def test_a_law_respects_the_limit_of_its_drive_and_injected_inputs(law, injected, limit):
    assert (
        within_drive(cascade(k_p=1.0, k_v=1.0, limit=law), 30.0, *injected).values["limit"] == limit
    )
    assert within_drive(open_loop(), 30.0) == open_loop()
