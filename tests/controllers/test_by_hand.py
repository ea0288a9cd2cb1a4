"""One sample of each law by hand: what the error asks for, what is kept, and what a limit takes."""

import math

import pytest

from bristle.controllers import adaptive_hysteresis, cascade, disturbance_observer, lugre_observer, open_loop, sliding_mode, super_twisting
from bristle.controllers.limits import within_drive
from bristle.controllers.velocity import FILTERED_DIFFERENCE, TRACKING_OBSERVER, motion_before, observed, samples_before
from bristle.core.contracts import Reference

DT = 0.1
# 0.02 m behind, at 0.5 m/s where 0.7 m/s are asked for: with a slope of 10 the surface is 0.2 + 0.2 = 0.4 m/s.
ASKED = Reference(0.07, 0.7, 3.0, 5.0)
SURFACE = {"J": 2.0, "lambda_": 10.0, "K_1": 4.0}
PULL = 2.0 * (3.0 + 10.0 * 0.2 + 4.0 * 0.4) + 5.0


def stepped(law, reference=ASKED, measured=0.05, **state):
    begun = law.component.initial_state(law.parameters)._replace(**state)
    return law.component.step(begun, reference, measured, DT, law.parameters)


def test_a_cascade_commands_a_velocity_and_then_an_effort():
    law = cascade(k_p=10.0, k_v=100.0, k_i=50.0, k_ff=0.5)
    effort, state = stepped(law, q_1=0.03, r_1=0.05, integral=7.0)
    # 10 * 0.02 + 0.5 * 0.2 - 0.2 m/s, and 50 * 0.1 * 0.1 N more in the integral.
    assert effort == pytest.approx(100.0 * 0.1 + 7.5 + 5.0)
    assert state == pytest.approx((0.05, 0.03, 7.5, 0.07, 0.05))


def test_a_cascade_may_average_its_velocities_over_two_samples():
    law = cascade(k_p=10.0, k_v=100.0, k_ff=0.5, averaging=2)
    effort, _ = stepped(law, q_1=9.0, q_2=0.01, r_1=9.0, r_2=0.03)
    assert effort == pytest.approx(100.0 * (0.2 + 0.5 * 0.2 - 0.2) + 5.0)


@pytest.mark.parametrize(("limit", "effort", "integral"), [(100.0, 30.0, 10.0), (25.0, 25.0, 5.0)])
def test_an_integral_stops_at_the_limit(limit, effort, integral):
    law = cascade(k_p=10.0, k_v=100.0, k_i=250.0, limit=limit)
    reached, state = stepped(law, Reference(0.07, 0.0, 0.0, 0.0), q_1=0.05, integral=5.0)
    assert (reached, state.integral) == pytest.approx((effort, integral))


def test_an_integral_moves_back_from_the_limit():
    law = cascade(k_p=10.0, k_v=100.0, k_i=250.0, limit=25.0)
    effort, state = stepped(law, Reference(0.03, 0.0, 0.0, 0.0), q_1=0.05, integral=80.0)
    assert (effort, state.integral) == pytest.approx((25.0, 75.0))


def test_a_cascade_that_takes_over_has_the_previous_samples_and_effort():
    law = cascade(k_p=10.0, k_v=100.0, k_i=50.0, k_ff=1.0)
    component, p = law.component, law.parameters
    begun = component.start(0.05, 0.5, 2.0, DT, p)
    assert begun == pytest.approx((0.05 - 0.05 + 0.01, 0.05 - 0.1 + 0.04, 0.0, 0.0, 0.0))
    resumed = component.resume(begun, ASKED, 0.05, 30.0, DT, p)
    assert resumed.r_1 == pytest.approx(0.07 - 0.07 + 0.015)
    assert resumed.r_2 == pytest.approx(0.07 - 0.14 + 0.06)
    # Without an integral the law asks for 100 (0.2 + 0.55 - 0.4) + 5 N.
    assert resumed.integral == pytest.approx(30.0 - 40.0)
    assert component.resume(begun, ASKED, 0.05, math.nan, DT, p).integral == 0.0
    bare = cascade(k_p=10.0, k_v=100.0)
    assert component.resume(begun, ASKED, 0.05, 30.0, DT, bare.parameters).integral == 0.0


@pytest.mark.parametrize(("phi", "share"), [(0.0, 1.0), (0.8, 0.5), (0.4, 1.0), (0.1, 1.0)])
def test_a_sliding_mode_switches_beyond_its_layer(phi, share):
    law = sliding_mode(**SURFACE, K_2=6.0, phi=phi)
    effort, state = stepped(law, q=0.0)
    assert effort == pytest.approx(PULL + 2.0 * 6.0 * share)
    assert state == pytest.approx((0.05, 0.5))
    behind, _ = stepped(law, Reference(0.03, 0.3, 3.0, 5.0), q=0.0)
    assert behind == pytest.approx(2.0 * (3.0 - 2.0 - 1.6) + 5.0 - 12.0 * share)


def test_no_switching_on_the_surface():
    law = sliding_mode(**SURFACE, K_2=6.0)
    assert stepped(law, Reference(0.05, 0.5, 3.0, 5.0), q=0.0)[0] == pytest.approx(11.0)
    assert stepped(sliding_mode(**SURFACE, K_2=6.0, limit=9.0), q=0.0)[0] == 9.0


def test_super_twisting_adds_the_root_of_the_surface_and_integrates_its_sign():
    law = super_twisting(**SURFACE, k_1=3.0, k_2=20.0)
    effort, state = stepped(law, q=0.0, w=1.0)
    assert state.w == pytest.approx(3.0)
    assert effort == pytest.approx(PULL + 2.0 * (3.0 * math.sqrt(0.4) + 3.0))
    limited, kept = stepped(super_twisting(**SURFACE, k_1=3.0, k_2=20.0, limit=10.0), q=0.0, w=1.0)
    assert (limited, kept.w) == (10.0, 1.0)
    back, moved = stepped(super_twisting(**SURFACE, k_1=3.0, k_2=20.0, limit=10.0), q=0.0, w=-90.0)
    assert (back, moved.w) == (-10.0, -88.0)
    assert stepped(law, Reference(0.05, 0.5, 3.0, 5.0), q=0.0, w=1.0)[1].w == 1.0


def test_super_twisting_that_takes_over_integrates_the_remaining_effort():
    law = super_twisting(**SURFACE, k_1=3.0, k_2=20.0)
    begun = law.component.initial_state(law.parameters)
    resumed = law.component.resume(begun, ASKED, 0.05, 60.0, DT, law.parameters)
    assert resumed.w == pytest.approx((60.0 - PULL - 2.0 * 3.0 * math.sqrt(0.4)) / 2.0)
    assert law.component.resume(begun, ASKED, 0.05, math.nan, DT, law.parameters) == begun
    for changes in ({"k_2": 0.0}, {"J": 0.0}):
        without = law.with_values(**changes)
        assert law.component.resume(begun, ASKED, 0.05, 60.0, DT, without.parameters) == begun


def test_a_disturbance_observer_feeds_back_the_unexplained_force():
    law = disturbance_observer(**SURFACE, g=20.0)
    effort, state = stepped(law, q=0.0, z=4.0, feedback=9.0)
    # Toward the effort of the last sample and g J v = 20 N by 1 - exp(-2).
    z = 4.0 + (1.0 - math.exp(-2.0)) * (9.0 + 20.0 - 4.0)
    assert state.z == pytest.approx(z)
    assert effort == pytest.approx(PULL + z - 20.0)
    assert state.feedback == pytest.approx(effort - 5.0)
    begun = law.component.start(0.05, 0.5, 2.0, DT, law.parameters)
    assert begun == pytest.approx((0.01, 0.3, 20.0 * 2.0 * 0.3, 4.0))
    resumed = law.component.resume(begun, ASKED, 0.05, 12.0, DT, law.parameters)
    assert (resumed.z, resumed.feedback) == pytest.approx((12.0 + 7.0 - 4.0, 7.0))
    assert law.component.resume(begun, ASKED, 0.05, math.nan, DT, law.parameters) == begun


def test_motion_and_error_move_the_bristles_of_a_friction_observer():
    bristles = {"F_C": 20.0, "F_S": 28.0, "v_S": 0.5, "sigma_0": 100.0, "sigma_2": 3.0, "k": 0.25}
    law = lugre_observer(**SURFACE, **bristles)
    effort, state = stepped(law, q=0.0, z=0.02)
    slip = 100.0 * 0.5 / (20.0 + 8.0 * math.exp(-1.0)) * 0.1
    z = 0.02 * math.exp(-slip) + 0.1 * (1.0 - math.exp(-slip)) / slip * (0.5 + 0.25 * 0.4)
    assert state == pytest.approx((0.05, 0.5, z))
    assert effort == pytest.approx(PULL + 100.0 * z + 1.5)
    limited, kept = stepped(lugre_observer(**SURFACE, **bristles, limit=5.0), q=0.0, z=0.02)
    assert (limited, kept.z) == (5.0, 0.02)


def test_an_adaptive_law_compensates_with_stops_and_learns_outside_its_dead_zone():
    law = adaptive_hysteresis(**SURFACE, reach=0.12, Gamma=50.0, w_max=8.0, delta=0.1)
    weights = {f"w_{i}": 1.0 for i in range(1, 7)}
    effort, state = stepped(law, q=0.0, r=0.05, w_0=2.0, **weights)
    # 0.02 m further: the stops of 0.02, 0.04 ... 0.12 m have taken all, half ... a sixth of it.
    stops = [1.0 / i for i in range(1, 7)]
    assert [getattr(state, f"E_{i}") for i in range(1, 7)] == pytest.approx(stops)
    assert effort == pytest.approx(PULL + 2.0 + sum(stops))
    # The surface lies 0.3 outside of the dead zone: 50 * 0.1 * 0.3 N for a stop that is strained.
    assert state.w_0 == pytest.approx(3.5)
    assert [getattr(state, f"w_{i}") for i in range(1, 7)] == pytest.approx([1.0 + 1.5 * share for share in stops])
    assert state[:3] == pytest.approx((0.05, 0.5, 0.07))


def test_an_adaptive_law_keeps_its_stops_and_its_strengths_within_bounds():
    law = adaptive_hysteresis(**SURFACE, reach=0.12, Gamma=1e6, w_max=8.0)
    _, up = stepped(law, q=0.0, r=-1.0)
    assert [up.E_1, up.E_6, up.w_0, up.w_1, up.w_6] == [1.0, 1.0, 8.0, 8.0, 8.0]
    _, down = stepped(law, Reference(0.03, 0.3, 3.0, 5.0), q=0.0, r=-1.0)
    assert [down.w_0, down.w_1, down.w_6] == [-8.0, 0.0, 0.0]
    _, back = stepped(law, q=0.0, r=1.0)
    assert [back.E_1, back.E_6] == [-1.0, -1.0]
    _, still = stepped(law.with_values(limit=1.0), q=0.0, r=0.05, w_0=2.0)
    assert still.w_0 == 2.0
    begun = law.component.start(0.05, 0.5, 2.0, DT, law.parameters)
    assert begun == pytest.approx((0.01, 0.3, 0.01, *[0.0] * 13))


def test_the_command_of_an_open_loop_is_the_feedforward():
    assert stepped(open_loop()) == (5.0, ())
    assert open_loop().component.start(0.0, 0.0, 0.0, DT, open_loop().parameters) == ()


def test_a_velocity_is_a_filtered_difference_or_that_of_an_observer():
    pole = math.exp(-2.0 * math.pi * 0.5)
    assert observed(0.0, 0.3, 0.05, DT, FILTERED_DIFFERENCE, 5.0) == pytest.approx((0.05, 0.3 + (1.0 - pole) * 0.2))
    assert observed(0.0, 0.3, 0.05, DT, FILTERED_DIFFERENCE, math.inf) == pytest.approx((0.05, 0.5))
    ahead, surprise = 0.03, 0.02
    expected = (ahead + (1.0 - pole**2) * surprise, 0.3 + (1.0 - pole) ** 2 * surprise / DT)
    assert observed(0.0, 0.3, 0.05, DT, TRACKING_OBSERVER, 5.0) == pytest.approx(expected)


def test_samples_before_lie_on_the_parabola_of_the_motion():
    assert samples_before(1.0, 2.0, 3.0, DT) == pytest.approx((1.0 - 0.2 + 0.015, 1.0 - 0.4 + 0.06))
    assert motion_before(1.0, 2.0, 3.0, DT) == pytest.approx((0.815, 1.7))


def test_a_law_respects_the_limit_of_its_drive_and_injected_inputs():
    law = cascade(k_p=1.0, k_v=1.0)
    assert within_drive(law, 30.0).values["limit"] == 30.0
    assert within_drive(law, 30.0, [4.0, -7.0]).values["limit"] == 37.0
    assert within_drive(law, 30.0, []).values["limit"] == 30.0
    tighter = law.with_values(limit=20.0)
    assert within_drive(tighter, 30.0) is tighter
    assert within_drive(open_loop(), 30.0) == open_loop()
