"""Step doubling: what a step costs, and that it asks for no more than numbers can hold."""

import numpy as np
import pytest

from bristle import friction
from bristle.engine import run_adaptive
from bristle.engine.entry_points import ACCELERATION, FAILED, FORCE, MechanismVectors
from bristle.engine.instance import Instance
from bristle.engine.step_doubling import (
    Course,
    DoublingEntries,
    Half,
    Limits,
    Samples,
    astray,
    doubling,
    extrapolate,
    length_factor,
    make_rest_time,
    on_cubic,
    remember,
    reserve,
    sampled,
    slides,
)
from bristle.models.plants import inertia, pulled_inertia


@pytest.mark.parametrize("time", [1e-3, 1.0, 1e3])
def test_break_away_is_found_after_any_time(time):
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
def test_the_step_length_follows_this_and_the_last_error_within_bounds(error, last, order, factor):
    assert length_factor(error, last, order) == pytest.approx(factor)


CUBIC = np.polynomial.Polynomial([1.0, 2.0, 3.0, -1.0])


@pytest.mark.parametrize("part", [0.0, 0.25, 0.5, 1.0])
def test_samples_inside_a_step_follow_the_cubic_through_its_ends(part):
    x, v = CUBIC, CUBIC.deriv()
    assert on_cubic(part, 0.5, x(0.0), v(0.0), x(0.5), v(0.5)) == pytest.approx(x(0.5 * part))


@pytest.mark.parametrize(
    ("h", "v_0", "x_1", "v_1", "distance"),
    [
        (1.0, 0.0, 0.3, 1.0, 0.0),  # no stop
        (1.0, 1.0, 1.5, 2.0, 0.0),
        (1.0, 1.0, 0.0, -1.0, 0.0),  # a parabola throughout
        # Brakes evenly from 1 m/s within a half or a quarter of a second, and rests.
        (1.0, 1.0, 0.25, 0.0, 1.0 / 128.0),
        (1.0, 1.0, 0.125, 0.0, 9.0 / 256.0),
        (1.0, -1.0, -0.125, 0.0, 9.0 / 256.0),
        # The same way to the stop over twice the time: twice as far.
        (2.0, 1.0, 0.25, 0.0, 9.0 / 128.0),
    ],
)
def test_a_cubic_deviates_if_the_body_stops_inside(h, v_0, x_1, v_1, distance):
    assert astray(h, 5.0, v_0, 5.0 + x_1, v_1) == pytest.approx(distance)


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
def test_a_contact_slides_if_both_halves_are_long_without_a_reversal(
    before, middle, after, far, along
):
    assert slides(before, *middle, after, far) is along


def test_an_extrapolation_cancels_a_second_order_error():
    fine = np.array([3.0 + 0.01, -2.0 - 0.5])
    extrapolate(fine, np.array([3.0 + 0.04, -2.0 - 2.0]))
    assert fine == pytest.approx([3.0, -2.0])


def test_the_mechanism_before_a_step_is_stored_with_its_memory():
    now, before = (
        MechanismVectors(*(np.full(2, value + k) for k in range(6))) for value in (0.0, 10.0)
    )
    remember(now, before)
    assert [part[0] for part in before] == [10.0, 1.0, 12.0, 3.0, 4.0, 15.0]


COULOMB, STAGE = friction.coulomb(F_C=20.0), inertia(M=2.0)


@pytest.mark.parametrize(
    ("model", "effort", "left"),
    [
        *(
            (COULOMB, effort, left)
            for effort, left in (
                (0.0, 20.0),
                (12.0, 8.0),
                (-12.0, 8.0),
                (25.0, -5.0),
                (-25.0, -5.0),
            )
        ),
        (friction.coulomb_viscous(F_C=20.0, F_v=900.0), 12.0, 8.0),
        (friction.viscous(F_v=3.0), 5.0, float("inf")),  # on a film a body cannot rest
    ],
)
def test_the_reserve_of_a_body_at_rest_is_friction_minus_effort(model, effort, left):
    at_rest, p = STAGE.component.State(0.7, 0.0), model.parameters
    assert reserve(
        at_rest, model.component.initial_state(p), (), effort, 1e-3, STAGE.parameters, p
    ) == pytest.approx(left)


@pytest.mark.parametrize(
    ("effort", "end", "time"),
    [
        (0.0, 80.0, 0.125),
        (10.0, -70.0, 0.1875),
        (10.0, 19.0, 0.5),
        (20.0, 60.0, 0.0),
        (30.0, 60.0, 0.0),
        (0.0, 0.0, 0.5),
    ],
)
def test_a_body_rests_until_the_effort_reaches_friction(effort, end, time):
    plant, contact = Instance(STAGE), Instance(COULOMB)
    entry = make_rest_time(*plant.structures, *contact.structures)
    vectors = MechanismVectors(
        plant.parameters, plant.state, contact.parameters, contact.state, np.zeros(0), np.zeros(0)
    )
    assert entry(vectors, effort, end, 0.5, 1) == pytest.approx(time, abs=1e-9)


class Driven:
    """A body on exact steps, with a force of 3 N and a failed solve in each, and what it was asked for."""

    def __init__(self, step, rest_time=lambda vectors, effort, effort_end, dt, steps: dt):
        self.step, self.rest_time, self.asked = step, rest_time, []
        self.vectors = [
            MechanismVectors(*(np.zeros(size) for size in (0, 2, 0, 0, 1, 8))) for _ in range(3)
        ]
        self.report = np.zeros(4)

    def substeps(self, vectors, effort, effort_end, dt, steps):
        self.asked.append((effort, effort_end, dt))
        x, v = vectors.plant_state
        vectors.plant_state[:] = self.step(x, v, effort, effort_end, dt)
        vectors.memory[0] += 1.0
        vectors.out[FORCE], vectors.out[FAILED] = 3.0, 1.0

    def run(self, course, limits, times):
        samples = Samples(times, *np.zeros((3, times.size)))
        vectors, before, full = self.vectors
        full = full._replace(memory=vectors.memory)
        entries = DoublingEntries(self.substeps, self.rest_time)
        return doubling(
            entries, vectors, before, full, course, limits, samples, self.report
        ), samples


def thrown(x, v, effort, effort_end, dt):
    return x + v * dt + 0.5 * effort * dt * dt, v + 0.5 * (effort + effort_end) * dt


def course_of(*efforts, knots):
    return Course(np.array(knots), np.array(efforts[::2]), np.array(efforts[1::2]))


def test_exact_steps_grow_to_the_limit_and_give_every_sample():
    body, times = Driven(thrown), np.linspace(0.0, 10.0, 41)
    course = course_of(2.0, 2.0, -1.0, -1.0, knots=[0.0, 4.0, 10.0])
    reached, samples = body.run(course, Limits(1e-6, 1e-3, 1.5, 1e-9, 1e-3, 1e9, 1e-6), times)
    late = np.maximum(times - 4.0, 0.0)
    assert reached == 41
    assert samples.v == pytest.approx(2.0 * np.minimum(times, 4.0) - late)
    assert samples.x == pytest.approx(np.minimum(times, 4.0) ** 2 + 8.0 * late - 0.5 * late**2)
    assert samples.impulse == pytest.approx(3.0 * times)
    lengths = [dt for _, _, dt in body.asked[::3]]
    assert lengths[:3] == pytest.approx([1e-3, 4e-3, 4e-3 * 0.9 * 10.0**0.6])
    assert max(lengths) == 1.5
    assert sum(lengths) == pytest.approx(10.0)
    assert [dt for _, _, dt in body.asked[1::3]] == pytest.approx([0.5 * h for h in lengths])
    accepted, rejected, missed, failed = body.report
    assert (accepted, rejected, missed, failed) == (len(lengths), 0.0, 0.0, 2.0 * len(lengths))
    # Each accepted step is remembered once for each of its halves.
    assert body.vectors[0].memory[0] == 2.0 * accepted


def test_an_effort_is_linear_over_both_halves_of_a_step():
    body = Driven(thrown)
    body.run(
        course_of(1.0, 5.0, knots=[0.0, 2.0]),
        Limits(1e-9, 1e9, 9.0, 0.5, 0.5, 1e9, 1e9),
        np.zeros(0),
    )
    whole, first, second = body.asked[:3]
    assert whole == pytest.approx((1.0, 2.0, 0.5))
    assert first == pytest.approx((1.0, 1.5, 0.25))
    assert second == pytest.approx((1.5, 2.0, 0.25))


def test_each_solve_starts_from_the_extrapolated_acceleration():
    told = []

    class Told(Driven):
        def substeps(self, vectors, effort, effort_end, dt, steps):
            told.append(float(vectors.out[ACCELERATION]))
            super().substeps(vectors, effort, effort_end, dt, steps)
            # The mean acceleration of a mass of 1 kg.
            vectors.out[ACCELERATION] = 0.5 * (effort + effort_end)

    Told(thrown).run(
        course_of(1.0, 9.0, knots=[0.0, 8.0]),
        Limits(1e9, 1e9, 1.0, 1.0, 1.0, 1e9, 1e9),
        np.zeros(0),
    )
    whole, first, second = np.reshape(told, (-1, 3)).T
    middles = 1.5 + np.arange(8.0)  # of the effort over each step of 1 s
    assert second == pytest.approx(middles + 0.25)
    assert whole[1:] == pytest.approx(middles[1:])
    assert first[1:] == pytest.approx(middles[1:] - 0.25)


def bent(x, v, effort, effort_end, dt):
    """Miss by a hundredth of the cube of the step."""
    return x + v * dt + 0.01 * dt**3, v


def test_an_inexact_step_is_rejected_without_effect():
    body = Driven(bent)
    # Over 1 s both results differ by 0.0075; 1e-3 is allowed a second.
    body.run(
        course_of(0.0, 0.0, knots=[0.0, 4.0]),
        Limits(1e-3, 1e9, 9.0, 1e-6, 1.0, 1e9, 1e9),
        np.zeros(0),
    )
    accepted, rejected, missed, _ = body.report
    assert body.asked[3][2] == pytest.approx(0.9 * 7.5**-0.35)
    assert (rejected, missed) == (2.0, 0.0)
    assert body.vectors[0].memory[0] == 2.0 * accepted
    lengths = [dt for _, _, dt in body.asked[6::3]]  # behind both that were rejected
    assert sum(lengths) == pytest.approx(4.0)
    assert max(0.0075 * h**2 / 1e-3 for h in lengths) <= 1.0


def sped(x, v, effort, effort_end, dt):
    """Miss the velocity by a hundredth of the cube of the step, which counts over two steps."""
    return x, v + 0.01 * dt**3


@pytest.mark.parametrize(
    ("step", "per_time", "per_step", "missed"),
    [(bent, 1e-3, 1e9, 7.5), (bent, 1.0, 1e-3, 7.5), (sped, 1e-3, 1e9, 15.0)],
)
def test_the_error_of_a_step_is_allowed_by_its_length_and_bounded(step, per_time, per_step, missed):
    body = Driven(step)
    body.run(
        course_of(0.0, 0.0, knots=[0.0, 4.0]),
        Limits(per_time, per_step, 9.0, 1e-6, 1.0, 1e9, 1e9),
        np.zeros(0),
    )
    assert body.asked[3][2] == pytest.approx(0.9 * missed**-0.35)


def test_too_many_steps_that_miss_the_tolerance_end_a_run():
    body = Driven(lambda x, v, effort, effort_end, dt: (x + 1.0, v))
    reached, _ = body.run(
        course_of(0.0, 0.0, knots=[0.0, 1e9]),
        Limits(1e-9, 1e-9, 1.0, 0.5, 0.5, 1e9, 1e-9),
        np.array([0.0, 1e8]),
    )
    # The one more than a thousand is counted, and the next one ends it.
    assert (reached, body.report[0], body.report[2]) == (1, 1001.0, 1001.0)


def test_a_diverged_run_ends_at_once():
    body = Driven(lambda x, v, effort, effort_end, dt: (x, v + 1e101 * dt))
    reached, _ = body.run(
        course_of(0.0, 0.0, knots=[0.0, 1e3]),
        Limits(1e200, 1e200, 1.0, 1.0, 1.0, 1e300, 1e200),
        np.array([0.0, 0.5, 500.0]),
    )
    assert reached == 2


def held_to_three(x, v, effort, effort_end, dt):
    """Rest in a step that begins below an effort of 3, and move on at 1 m/s^2 from there."""
    return (x + v * dt + 0.5 * dt * dt, v + dt) if effort >= 3.0 - 1e-9 else (x, 0.0)


def test_a_step_from_rest_ends_at_break_away():
    def rest_time(vectors, effort, effort_end, dt, steps):
        return min(dt, max(3.0 - effort, 0.0)) if effort_end > effort else dt

    body, times = Driven(held_to_three, rest_time), np.linspace(0.0, 8.0, 33)
    _, samples = body.run(
        course_of(0.0, 8.0, knots=[0.0, 8.0]), Limits(1e-6, 1e-3, 8.0, 1e-9, 2.5, 1e9, 1e-9), times
    )
    assert samples.x == pytest.approx(0.5 * np.maximum(times - 3.0, 0.0) ** 2, abs=1e-9)
    assert any(effort == pytest.approx(3.0, abs=1e-9) for effort, _, _ in body.asked[::3])
    assert np.all(samples.v[times <= 3.0] == 0.0)


def gliding(x, v, effort, effort_end, dt):
    """Move at 1 m/s, with an error of the position that goes with the cube of the step."""
    return x + dt + 0.01 * dt**3, v


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_extrapolation_in_sliding_corrects_position_and_middle(way):
    body, times = (
        Driven(lambda x, v, *about: (x + way * (gliding(0.0, v, *about)[0]), v)),
        np.linspace(0.0, 4.0, 33),
    )
    body.vectors[0].plant_state[:] = 3.0, way
    _, samples = body.run(
        course_of(0.0, 0.0, knots=[0.0, 4.0]), Limits(1e-2, 1e9, 9.0, 1e-6, 1.0, 0.0, 1e9), times
    )
    assert samples.x == pytest.approx(3.0 + way * times, abs=1e-12)
    # Of a difference of 0.0075 m in a way of 1 m a hundred times its square is left.
    assert body.asked[3][2] == pytest.approx(0.9 * (100.0 * 0.0075**2 / 1e-2) ** -0.35)
    assert body.report[1] == 0.0


def test_extrapolation_in_sliding_corrects_the_velocity():
    body = Driven(lambda x, v, effort, effort_end, dt: (x + dt, v + 0.01 * dt**3))
    body.vectors[0].plant_state[1] = 1.0
    _, samples = body.run(
        course_of(0.0, 0.0, knots=[0.0, 4.0]),
        Limits(1e-2, 1e9, 1.0, 1e-6, 1.0, 0.0, 1e9),
        np.linspace(0.0, 4.0, 33),
    )
    assert samples.v == pytest.approx(np.ones(33), abs=1e-12)
