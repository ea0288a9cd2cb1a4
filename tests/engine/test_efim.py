"""The solve of a step: how near it comes to the root of an equation that has one in closed form."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from bristle import friction
from bristle.core import dispatch
from bristle.core.mathematics import Bracket, direction
from bristle.engine import interpreted, run_batch, run_open_loop
from bristle.engine.efim import (
    Start,
    advance,
    is_narrow,
    is_set_valued,
    is_solved,
    next_guess,
    slope_from,
    solve,
    stop_and_go_on,
    stopping_time,
)
from bristle.files.user_model import load_code
from bristle.models.plants import inertia

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"


@pytest.mark.parametrize("v", [0.0, 0.3])
def test_the_force_of_a_step_is_found_to_a_billionth(v):
    # 2 M (w - v)/dt = u - F_C - F_q w^2 is a quadratic in the mean velocity w of the step.
    M, F_C, F_q, dt = 2.0, 1.5, 150.0, 0.05
    model = load_code(EXAMPLE)(F_C=F_C, F_q=F_q)
    for u in np.geomspace(4.0, 4000.0, 40):
        with interpreted():
            friction = run_open_loop(inertia(M=M), model, np.full(2, u), dt, v=v).friction[0]
        inert, drag = 2.0 * M / dt, F_q
        driven = inert * v + u - F_C
        w = 2.0 * driven / (inert + np.sqrt(inert**2 + 4.0 * drag * driven))
        assert friction == pytest.approx(driven + F_C - inert * w, rel=1e-9)


def test_a_body_stopped_by_friction_does_not_reverse():
    # At rest after two to five whole steps, which rounding puts just before or just behind the end of one.
    generator, M, dt = np.random.default_rng(0), 1.0, 0.1
    F_C, steps = generator.uniform(0.5, 2.0, 400), generator.integers(2, 6, 400)
    v = F_C * steps * dt / M
    trace = run_batch(
        inertia(M=M), [friction.coulomb(F_C=item) for item in F_C], np.zeros(8), dt, v=v
    )
    assert np.all(trace.velocity >= 0.0)
    assert np.all(trace.velocity[:, 6:] == 0.0)
    assert trace.position[:, -1] == pytest.approx(0.5 * M * v**2 / F_C, rel=1e-12)


@pytest.mark.parametrize("steps", [1, 3, 8])
def test_a_linear_effort_gives_the_momentum_of_its_integral(steps):
    effort, dt = np.random.default_rng(1).normal(0.0, 5.0, 30), 0.01
    with interpreted():
        trace = run_open_loop(
            inertia(M=2.0), friction.viscous(F_v=30.0), effort, dt, steps=steps, hold="linear"
        )
    values = np.cumsum(0.5 * dt * (effort[1:] + effort[:-1]))
    taken = np.cumsum(dt * trace.friction[:-1])
    assert 2.0 * trace.velocity[1:] == pytest.approx(values - taken, abs=1e-12)


@pytest.mark.parametrize(
    ("v", "residual", "v_last", "residual_last", "slope"),
    [
        (2.0, 0.5, 1.0, -1.0, 1.5),
        (2.0, 0.5, 1.0, 0.6, 1.0),
        (2.0, 0.5, 2.0, -1.0, 7.0),
        (2.0, 0.5, 1.0, 0.0, 7.0),
    ],
)
def test_the_slope_is_that_of_a_rising_secant(v, residual, v_last, residual_last, slope):
    assert slope_from(7.0, v, residual, v_last, residual_last) == slope


@pytest.mark.parametrize(
    ("low", "high", "guess"),
    [(0.0, 3.0, 1.75), (-math.inf, 3.0, 1.75), (1.9, math.inf, 1.0), (1.9, 3.0, None)],
)
def test_the_next_guess_is_the_secant_the_middle_or_an_extrapolation(low, high, guess):
    result = next_guess(Bracket(low, -1.0, high, 1.0, 0.0), 2.0, 0.5, 2.0)
    assert result == guess if guess is not None else low < result < high


@pytest.mark.parametrize(
    ("residual", "force", "v", "allowed", "solved"),
    [
        (1.9e-9, 2.0, 0.0, 0.0, True),
        (2.1e-9, 2.0, 0.0, 0.0, False),
        (-1.9e-11, 0.0, -2.0, 0.0, True),
        (2.1e-11, 0.0, -2.0, 0.0, False),
        (0.3, 0.0, 0.0, 0.3, True),
    ],
)
def test_a_residual_is_small_relative_to_force_velocity_or_tolerance(
    residual, force, v, allowed, solved
):
    assert is_solved(residual, force, v, -1.0, allowed) is solved


@pytest.mark.parametrize(("width", "narrow"), [(3e-16, True), (6e-16, False)])
def test_a_bracket_is_narrow_when_no_number_lies_between_its_ends(width, narrow):
    assert is_narrow(1.0, 1.0 + width, 1.0) is narrow


ASKED = []


class Nothing(NamedTuple):
    F: float


def never(state, memory, motion, dt, p):
    ASKED.append(motion.v)
    return math.nan, ()


dispatch.register("friction", Nothing, {"trial": never, "commit": lambda state, *_: state})


def test_a_solve_gives_up_after_a_hundred_evaluations():
    ASKED.clear()
    solution = solve((), (), 0.0, 0.0, 0.1, Nothing(1.0), 1.0, -1.0, Start(0.5, 1.0, 0.0))
    assert (len(ASKED), solution.failures) == (100, 1.0)


@pytest.mark.parametrize(("residual_last", "slope"), [(0.498, 2e-3), (0.4995, 1.0), (0.5, 1.0)])
def test_a_nearly_flat_secant_is_not_used_as_a_slope(residual_last, slope):
    assert slope_from(7.0, 2.0, 0.5, 1.0, residual_last) == pytest.approx(slope)


class DryFilm(NamedTuple):
    F_C: float
    F_v: float


def rubbing(state, memory, motion, dt, p):
    ASKED.append(motion.v)
    return p.F_C * direction(motion.v) + p.F_v * motion.v, ()


dispatch.register("friction", DryFilm, {"trial": rubbing, "commit": lambda state, *_: state})
STAGE = inertia(M=2.0)
Body = STAGE.component.State


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("film", "effort", "time"), [(DryFilm(4.0, 0.0), 0.0, 1.0), (DryFilm(4.0, 3.0), 1.0, 2.0 / 3.0)]
)
def test_a_body_stops_when_its_momentum_is_zero(way, film, effort, time):
    ASKED.clear()
    outcome = stopping_time(Body(0.3, way * 2.0), (), (), way * effort, 3.0, STAGE.parameters, film)
    # M v = (F - u) t, with the friction at the mean velocity v / 2.
    assert outcome == pytest.approx(time, rel=1e-14)
    assert set(ASKED) == {way}
    assert len(ASKED) < 12


@pytest.mark.parametrize("F_C", [1.3, 3.7])
def test_the_search_for_a_stop_ends_at_rounding(F_C):
    ASKED.clear()
    stopping_time(Body(0.0, 0.7), (), (), 0.1, 3.0, STAGE.parameters, DryFilm(F_C, 0.3))
    assert len(ASKED) < 20


@pytest.mark.parametrize(
    ("film", "is_interval"),
    [
        (DryFilm(4.0, 0.0), True),
        (DryFilm(4.0, 90.0), True),
        (DryFilm(0.0, 3.0), False),
        (DryFilm(0.0, 0.0), False),
    ],
)
def test_a_force_at_rest_is_an_interval_if_both_limits_differ(film, is_interval):
    ASKED.clear()
    assert is_set_valued((), (), 0.3, 1.0, 0.1, film) is is_interval
    assert [(v, math.copysign(1.0, v)) for v in ASKED] == [(0.0, 1.0), (0.0, -1.0)]


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("effort", "x", "v", "force", "v_mean"),
    [
        (0.0, 0.25, 0.0, 2.0, 0.0),  # half a second to the stop, then at rest
        (-3.0, 1.0 / 7.0, 0.0, (4.0 * 2.0 - 3.0 * 5.0) / 7.0, 0.0),  # the effort is held
        (-6.0, 0.1 - 0.32, -0.8, (4.0 * 1.0 - 4.0 * 4.0) / 5.0, -0.4),  # it turns around
    ],
)
def test_a_step_with_a_stop_is_split_at_the_stop(way, effort, x, v, force, v_mean):
    film = DryFilm(4.0, 0.0)
    gone = stop_and_go_on(
        Body(0.0, way * 1.0), (), (), way * effort, 1.0, STAGE.parameters, film, 1.0
    )
    assert (gone.plant_state.x, gone.plant_state.v) == pytest.approx((way * x, way * v), abs=1e-12)
    assert (gone.force, gone.v_mean, gone.failures) == pytest.approx(
        (way * force, way * v_mean, 0.0), abs=1e-12
    )
    whole = advance(
        Body(0.0, way * 1.0),
        (),
        (),
        way * effort,
        1.0,
        STAGE.parameters,
        film,
        Start(way * 0.5, 1.0, 0.0),
    )
    assert whole[:4] == gone[:4]
