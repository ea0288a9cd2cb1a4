"""A parameter that the log sees in one direction is seen, though in the other one it may go for nothing."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core import FrictionModel
from bristle.core.mathematics import direction
from bristle.core.variable import Variable
from bristle.identification import identify


class Spring(NamedTuple):
    F_C: Annotated[float, Variable("force", "level", min=0.0, excitation="sliding")]
    stiffness: Annotated[float, Variable("force/length", "of a spring", min=1e-9, excitation="place")]
    reach: Annotated[float, Variable("length", "where its force stays", min=1e-9, excitation="place")]


class Nothing(NamedTuple):
    pass


def along_spring(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) + p.stiffness * min(max(motion.x, -p.reach), p.reach), Nothing()


def as_it_was(state, memory, move, p):
    return state


SPRING = FrictionModel(
    name="spring", description="ends", Parameters=Spring, State=Nothing, trial=along_spring, commit=as_it_was
)


@pytest.mark.parametrize(("noise", "seed", "status"), [(8.0, 2, "identified"), (25.0, 5, "unidentifiable")])
def test_what_shows_when_it_shrinks_is_seen_though_it_may_grow_for_nothing(noise, seed, status):
    motion = sines(6.0, amplitudes=(0.02,), frequencies=(1.0,), phases=(0.3,))
    # A spring that gives way shortly before the motion turns: were it longer, next to nothing would change.
    spring = 500.0 * np.clip(motion.position, -0.0192, 0.0192)
    effort = sliding_effort(motion, seed, noise, F_v=0.0, offset=0.0) + spring
    fit = identify(log_of(motion, effort), [SPRING], mass=TRUTH["M"], offset=0.0, blocks=0, draws=20).best
    reach = fit.parameters["reach"]
    assert reach.status == status
    # What is hidden by noise but shows is not held for the sake of the others: it has an interval.
    assert reach.interval is not None
    assert reach.interval[0] < reach.value < reach.interval[1]
