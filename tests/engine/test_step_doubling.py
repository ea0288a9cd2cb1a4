"""Step doubling: what a step costs, and that it asks for no more than numbers can hold."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle import friction
from bristle.core import FrictionModel, Variable
from bristle.core.mathematics import direction
from bristle.core.status import Status
from bristle.engine import interpreted, run_adaptive
from bristle.engine.entry_points import MechanismVectors
from bristle.engine.instance import Instance
from bristle.engine.step_doubling import (
    Half,
    Samples,
    astray,
    extrapolate,
    length_factor,
    make_rest_time,
    on_cubic,
    remember,
    reserve,
    sampled,
    slides,
)
from bristle.plants import inertia, pulled_inertia


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)]
    F_q: Annotated[float, Variable("force*time^2/length^2", "drag over the square of the speed", min=0.0)]


class State(NamedTuple):
    """None."""


class Move(NamedTuple):
    """None."""


def test_a_solve_begins_where_the_last_ones_point_to():
    evaluations = []

    def trial(state, memory, motion, dt, p):
        evaluations.append(motion.v)
        return p.F_C * direction(motion.v) + p.F_q * motion.v * abs(motion.v), Move()

    drag = FrictionModel(name="counted", description="drag", Parameters=Parameters, State=State, trial=trial, commit=lambda s, *_: s)
    with interpreted():
        trace = run_adaptive(pulled_inertia(M=1.0, k=1.0, v_e=2.0), drag(F_C=1.0, F_q=2.0), np.zeros(100), 0.025, tolerance=1e-7, v=1.5)
    # Each step is three solves of a curved equation; begun at the last velocity they would take three evaluations.
    assert np.min(trace.velocity) > 0.0
    assert len(evaluations) <= 2.28 * 3 * (trace.steps + trace.rejected)


def test_far_away_no_error_is_asked_for_that_is_less_than_rounding():
    model = friction.lugre(F_C=1.0, F_S=1.5, v_S=0.1, sigma_0=1e3, sigma_1=30.0, sigma_2=0.4)
    effort = 2.0 + np.sin(0.03 * np.arange(100))
    options = {"tolerance": 1e-7, "v": 1.0}
    here, far = (run_adaptive(inertia(M=1.0), model, effort, 0.1, x=x, **options) for x in (0.0, 1e6))
    assert far.status == Status.OK
    assert far.position - 1e6 == pytest.approx(here.position, abs=1e-7)
    assert far.steps + far.rejected <= here.steps + here.rejected


@pytest.mark.parametrize("time", [1e-3, 1.0, 1e3])
def test_break_away_is_found_whatever_the_time_that_it_takes(time):
    # The spring pulls with F_S after 0.7 of that time.
    F_S, k = 2.0, 100.0
    plant = pulled_inertia(M=1e-3 * time**2, k=k, v_e=F_S / k / (0.7 * time))
    model = friction.stribeck(F_C=1.0, F_S=F_S, v_S=1e-3 / time, F_v=0.0)
    trace = run_adaptive(plant, model, np.zeros(101), 0.01 * time, tolerance=1e-7)
    assert np.all(trace.velocity[:70] == 0.0)
    assert np.all(trace.position[72:75] > 0.0)
    assert np.all(np.diff(trace.friction[:70]) > 0.0)


@pytest.mark.parametrize(
    ("error", "last", "order", "factor"),
    [
        (1.0, 1.0, 2.0, 0.9),
        (4.0, 1.0, 2.0, 0.9 * 2.0**-0.7),
        (1.0, 4.0, 2.0, 0.9 * 2.0**0.4),
        (4.0, 1.0, 4.0, 0.9 * 2.0**-0.35),
        (1e-4, 1e-4, 2.0, 0.9 * 10.0**0.6),
        (1e-9, 1e-9, 2.0, 0.9 * 10.0**0.6),
        (1e-4, 1.0, 2.0, 4.0),
        (1e4, 1.0, 2.0, 0.2),
        (float("inf"), 1.0, 2.0, 0.2),
        (float("nan"), 1.0, 2.0, 0.2),
    ],
)
def test_a_step_grows_and_shrinks_by_its_error_and_the_last_one_within_bounds(error, last, order, factor):
    assert length_factor(error, last, order) == pytest.approx(factor)


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5, 1.0])
def test_samples_inside_a_step_lie_on_the_cubic_through_its_ends(part):
    def x(t):
        return 1.0 + 2.0 * t + 3.0 * t**2 - t**3

    def v(t):
        return 2.0 + 6.0 * t - 3.0 * t**2

    assert on_cubic(part, 0.5, x(0.0), v(0.0), x(0.5), v(0.5)) == pytest.approx(x(0.5 * part))


@pytest.mark.parametrize(
    ("v_0", "x_1", "v_1", "distance"),
    [
        (0.0, 0.3, 1.0, 0.0),  # no stop
        (1.0, 1.5, 2.0, 0.0),
        (1.0, 0.0, -1.0, 0.0),  # a parabola throughout
        # Brakes evenly from 1 m/s within a half or a quarter of a second, and rests.
        (1.0, 0.25, 0.0, 1.0 / 128.0),
        (1.0, 0.125, 0.0, 9.0 / 256.0),
        (-1.0, -0.125, 0.0, 9.0 / 256.0),
    ],
)
def test_a_cubic_leads_astray_where_the_body_stops_inside(v_0, x_1, v_1, distance):
    assert astray(1.0, 5.0, v_0, 5.0 + x_1, v_1) == pytest.approx(distance)


def test_a_cubic_over_a_stop_is_no_farther_astray_than_the_longer_the_step():
    # The same way to the stop over twice the time: twice as far.
    assert astray(2.0, 5.0, 1.0, 5.25, 0.0) == pytest.approx(2.0 * 9.0 / 256.0)


def test_samples_of_both_halves_have_position_velocity_and_the_impulse_of_friction():
    times = np.array([0.0, 0.25, 0.5, 0.625, 1.0, 1.5])
    samples = Samples(10.0 + times, *np.full((3, 6), -1.0))
    # The position is t^2; friction rises from 0 to 4 and is 1 and 3 in the mean of both halves.
    first = Half(10.0, 1.0, 0.0, 0.0, 0.0, 0.25, 1.0, 1.0, 3.0, 7.0)
    second = Half(10.5, 1.0, 0.5, 0.25, 1.0, 1.0, 2.0, 1.0, 3.0, 7.0)
    assert (sampled(0, first, samples), sampled(3, second, samples)) == (3, 5)
    assert samples.x[:5] == pytest.approx(times[:5] ** 2)
    assert samples.v[:5] == pytest.approx(2.0 * times[:5])
    assert samples.impulse[:5] == pytest.approx(7.0 + 2.0 * times[:5] ** 2)
    assert [signal[5] for signal in samples[1:]] == [-1.0] * 3


@pytest.mark.parametrize(
    ("before", "middle", "after", "far", "along"),
    [
        ((0.0, 1.0), (1.0, 1.0), (2.0, 1.0), 0.9, True),
        ((0.0, -1.0), (-1.0, -1.0), (-2.0, -1.0), 0.9, True),
        ((0.0, 1.0), (1.0, 1.0), (2.0, 1.0), 1.0, False),
        ((0.0, 1.0), (0.5, 1.0), (2.0, 1.0), 0.9, False),
        ((0.0, 1.0), (1.0, 1.0), (1.5, 1.0), 0.9, False),
        ((0.0, -1.0), (1.0, 1.0), (2.0, 1.0), 0.9, False),
        ((0.0, 1.0), (1.0, -1.0), (2.0, 1.0), 0.9, False),
        ((0.0, 1.0), (1.0, 1.0), (2.0, -1.0), 0.9, False),
        ((0.0, -1.0), (-1.0, 1.0), (-2.0, -1.0), 0.9, False),
        ((0.0, 0.0), (1.0, 1.0), (2.0, 1.0), 0.9, False),
    ],
)
def test_a_contact_is_carried_along_where_each_half_goes_far_and_none_turns(before, middle, after, far, along):
    assert slides(before, *middle, after, far) is along


def test_an_extrapolation_cancels_an_error_that_a_double_step_has_four_times():
    fine = np.array([3.0 + 0.01, -2.0 - 0.5])
    extrapolate(fine, np.array([3.0 + 0.04, -2.0 - 2.0]))
    assert fine == pytest.approx([3.0, -2.0])


def test_what_a_mechanism_was_before_a_step_is_kept_with_its_memory():
    now, before = (MechanismVectors(*(np.full(2, value + k) for k in range(6))) for value in (0.0, 10.0))
    remember(now, before)
    assert [part[0] for part in before] == [10.0, 1.0, 12.0, 3.0, 4.0, 15.0]


COULOMB, STAGE = friction.coulomb(F_C=20.0), inertia(M=2.0)


@pytest.mark.parametrize(("effort", "left"), [(0.0, 20.0), (12.0, 8.0), (-12.0, 8.0), (25.0, -5.0), (-25.0, -5.0)])
def test_the_reserve_of_a_body_at_rest_is_what_the_effort_leaves_of_friction(effort, left):
    at_rest, p = STAGE.component.State(0.0, 0.0), COULOMB.parameters
    assert reserve(at_rest, COULOMB.component.initial_state(p), (), effort, 1e-3, STAGE.parameters, p) == pytest.approx(left)


def test_nothing_rests_on_a_film():
    film, at_rest = friction.viscous(F_v=3.0), STAGE.component.State(0.0, 0.0)
    assert reserve(at_rest, film.component.initial_state(film.parameters), (), 5.0, 1e-3, STAGE.parameters, film.parameters) == float("inf")


@pytest.mark.parametrize(
    ("effort", "end", "time"),
    [(0.0, 80.0, 0.125), (10.0, -70.0, 0.1875), (10.0, 19.0, 0.5), (20.0, 60.0, 0.0), (30.0, 60.0, 0.0), (0.0, 0.0, 0.5)],
)
def test_a_body_rests_until_the_effort_reaches_friction(effort, end, time):
    plant, contact = Instance(STAGE), Instance(COULOMB)
    entry = make_rest_time(*plant.structures, *contact.structures)
    vectors = MechanismVectors(plant.parameters, plant.state, contact.parameters, contact.state, np.zeros(0), np.zeros(0))
    assert entry(vectors, effort, end, 0.5, 1) == pytest.approx(time, abs=1e-9)
