"""Step doubling: what a step costs, and that it asks for no more than numbers can hold."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle import friction
from bristle.core import FrictionModel, Variable
from bristle.core.mathematics import direction
from bristle.core.status import Status
from bristle.engine import interpreted, run_adaptive
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
