"""Lanes: how one iterate follows another, and when a lane steps aside."""

import math

import numpy as np
import pytest

from bristle import friction
from bristle.engine import interpreted, lanes, run_batch
from bristle.engine.efim import evaluate
from bristle.engine.lanes import ASIDE, LANES, OPEN, SOLVED, Iterate, first_guess, next_iterate
from bristle.models.plants import inertia

FREE = Iterate(2.0, 1.0, 0.0, 0.0, -math.inf, math.inf, OPEN)


def test_a_solve_begins_at_the_velocity_after_half_a_step():
    assert first_guess(3.0, 4.0, 0.1) == pytest.approx(3.2)
    assert first_guess(0.0, 4.0, 0.1) == 0.0


def test_an_iterate_follows_the_secant_and_closes_its_bracket():
    first = next_iterate(FREE, 0.5, solved=False)
    assert first == Iterate(1.5, 1.0, 2.0, 0.5, -math.inf, 2.0, OPEN)
    # From 2 to 1.5 the residual fell by 0.75: a slope of 1.5, and 0.25 / 1.5 ahead.
    second = next_iterate(first, -0.25, solved=False)
    assert second == Iterate(pytest.approx(1.5 + 0.25 / 1.5), 1.5, 1.5, -0.25, 1.5, 2.0, OPEN)


def test_a_solved_lane_keeps_its_velocity():
    done = next_iterate(FREE, 0.5, solved=True)
    assert done == FREE._replace(status=SOLVED)
    assert next_iterate(done, 0.5, solved=False) == done


@pytest.mark.parametrize(
    ("iterate", "residual"),
    [
        (FREE, 2.5),  # crosses zero
        (FREE._replace(v=-2.0), -2.5),
        (FREE, 2.0),  # meets zero
        (FREE._replace(low=1.9), 0.5),  # leaves its bracket
        (FREE._replace(high=2.1), -0.5),
        (FREE._replace(low=2.0 * (1.0 - 2e-16)), 1e-17),  # has no room left
    ],
)
def test_an_exceptional_lane_is_marked_for_a_separate_step(iterate, residual):
    assert next_iterate(iterate, residual, solved=False) == iterate._replace(status=ASIDE)
    assert next_iterate(iterate._replace(status=ASIDE), 0.1, solved=True).status == ASIDE


def test_load_dependent_friction_in_lanes_is_identical_to_serial_runs():
    model = friction.find("coulomb_viscous+transmitted")(F_C=20.0, F_v=30.0, c_T=0.2)
    effort = 60.0 + 20.0 * np.sin(np.linspace(0.0, 3.0, 5)) * np.linspace(0.5, 1.0, 32)[:, None]
    with interpreted():
        lanes, alone = (
            run_batch(inertia(M=2.0), model, effort, 1e-3, v=0.1, in_lanes=in_lanes)
            for in_lanes in (True, False)
        )
    for field in ("position", "velocity", "friction"):
        assert np.array_equal(getattr(lanes, field), getattr(alone, field)), field
    # F = 20 + 30 * 0.1 + 0.2 (60 - F)
    assert lanes.friction[:, 0] == pytest.approx(35.0 / 1.2, rel=0.01)


def test_evaluation_ends_when_all_lanes_are_solved(monkeypatch):
    evaluated = []

    def counted(*arguments):
        evaluated.append(arguments[2])
        return evaluate(*arguments)

    monkeypatch.setattr(lanes, "evaluate", counted)
    with interpreted():
        run_batch(
            inertia(M=2.0),
            friction.viscous(F_v=3.0),
            np.full((LANES, 3), 6.0),
            0.1,
            v=1.0,
            in_lanes=True,
        )
    # The residual of a film is a line: what the start misses two evaluations find, once its slope is known one.
    assert len(evaluated) % LANES == 0
    assert 3 <= len(evaluated) // LANES <= 2 + 3 * 2
