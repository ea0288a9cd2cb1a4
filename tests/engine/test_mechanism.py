"""A plant behind a drive: what a command moves in one sample."""

import math
from typing import NamedTuple

import pytest

from bristle import friction
from bristle.core import dispatch
from bristle.engine.mechanism import Mechanism, drive_over, mechanism
from bristle.models.plants import inertia

PLANT = inertia(M=2.0)
Body = PLANT.component.State


def after(command, end, lag=0.0, dt=0.5, steps=10, *, model, effort=0.0, v=0.0):
    before = Mechanism(
        Body(0.0, v), model.component.initial_state(model.parameters), effort, 0.0, 0.0, 0.0, 0.0
    )
    memory = model.component.new_memory(model.parameters)
    return mechanism(
        before, memory, command, end, lag, 0.0, dt, steps, PLANT.parameters, model.parameters
    )


def test_a_drive_without_lag_follows_at_once():
    assert drive_over(0.1, 3.0, 0.0) == (3.0, 0.0, 0.0)
    assert drive_over(0.1, 3.0, -1.0) == (3.0, 0.0, 0.0)


def test_a_drive_with_lag_approaches_the_command_exponentially():
    # After one time constant 1/e of the distance is left, and in the mean over it 1 - 1/e.
    drive = drive_over(0.2, 3.0, 0.2)
    assert drive == pytest.approx((3.0, math.exp(-1.0), 1.0 - math.exp(-1.0)))
    assert drive_over(0.4, 3.0, 0.2).at_end == pytest.approx(math.exp(-2.0))


def test_a_linear_effort_acts_by_its_mean():
    result = after(2.0, 6.0, model=friction.viscous(F_v=0.0))
    assert result.plant.v == pytest.approx(0.5 * 4.0 / 2.0)
    # The position is twice the integral of 1 + 4 t.
    assert result.plant.x == pytest.approx(0.5 * 0.5**2 + 4.0 * 0.5**3 / 6.0, rel=3e-3)
    assert result.effort == pytest.approx(5.8)  # in the middle of the last of ten steps
    assert (result.force, result.failures) == (0.0, 0.0)


def test_a_lag_reduces_the_impulse_by_time_constant_times_command_step():
    lag, dt = 0.05, 0.5
    result = after(4.0, 4.0, lag, model=friction.viscous(F_v=0.0))
    left = math.exp(-dt / lag)
    assert result.effort == pytest.approx(4.0 * (1.0 - left))
    assert 2.0 * result.plant.v == pytest.approx(4.0 * (dt - lag * (1.0 - left)))
    assert after(
        4.0, 4.0, lag, model=friction.viscous(F_v=0.0), effort=4.0
    ).plant.v == pytest.approx(1.0)


@pytest.mark.parametrize("steps", [1, 50])
def test_the_start_acceleration_of_a_step_is_that_of_the_last_step(steps):
    result = after(6.0, 6.0, steps=steps, model=friction.coulomb(F_C=2.0), v=1.0)
    assert result.acceleration == pytest.approx((6.0 - 2.0) / 2.0)
    assert result.force == pytest.approx(2.0)
    assert result.plant.v == pytest.approx(1.0 + 2.0 * 0.5)


def test_the_start_slope_is_divided_by_the_step_length():
    # The residual of a step of length h rises by 1 + h F_v / (2 M).
    slopes = [
        after(6.0, 6.0, dt=dt, steps=4, model=friction.viscous(F_v=3.0), v=0.1).slope
        for dt in (0.4, 0.8)
    ]
    assert slopes == pytest.approx([3.0 / 4.0, 3.0 / 4.0])


def test_the_friction_of_a_sample_is_the_mean_over_its_steps():
    # What the effort gives and friction takes is the momentum.
    result = after(6.0, 6.0, model=friction.viscous(F_v=3.0), v=0.1)
    assert 0.5 * (6.0 - result.force) == pytest.approx(2.0 * (result.plant.v - 0.1))


ASKED = []


class CountedFilm(NamedTuple):
    F_v: float


def counted(state, memory, motion, dt, p):
    ASKED.append(motion.v)
    return p.F_v * motion.v, ()


dispatch.register("friction", CountedFilm, {"trial": counted, "commit": lambda state, *_: state})


@pytest.mark.parametrize(
    ("acceleration", "slope", "evaluations"),
    [(2.0 * (1.15 / 1.075 - 1.0) / 0.1, 0.0, 1), (0.0, 0.75, 2), (0.0, 0.0, 3)],
)
def test_a_step_begins_with_acceleration_and_slope_of_the_last_step(
    acceleration, slope, evaluations
):
    ASKED.clear()
    before = Mechanism(Body(0.0, 1.0), (), 0.0, slope, acceleration, 0.0, 0.0)
    # 2 v' = 6 - 3 v from 1 m/s on over 0.1 s: the mean velocity is 1.15 / 1.075.
    result = mechanism(before, (), 6.0, 6.0, 0.0, 0.0, 0.1, 1, PLANT.parameters, CountedFilm(3.0))
    assert len(ASKED) == evaluations
    assert ASKED[-1] == pytest.approx(1.15 / 1.075)
    assert result.acceleration == pytest.approx(2.0 * (1.15 / 1.075 - 1.0) / 0.1)


def test_failed_solves_are_counted():
    before = Mechanism(Body(0.0, 1.0), (), 0.0, 0.0, 0.0, 0.0, 0.0)
    assert (
        mechanism(
            before, (), 6.0, 6.0, 0.0, 0.0, 0.1, 3, PLANT.parameters, CountedFilm(math.nan)
        ).failures
        == 3.0
    )
