"""A friction model of a person's own that is no number where the motion is fast: what entry points must tell."""

import math
from typing import Annotated, NamedTuple

from bristle.core.contracts import FrictionModel
from bristle.core.kernel import kernel
from bristle.core.variable import Variable


class Parameters(NamedTuple):
    """Up to which speed it gives a force, and what beyond."""

    F_C: Annotated[float, Variable("force", "force", min=0.0)]
    v_most: Annotated[float, Variable("length/time", "largest speed", min=0.0)]
    beyond: Annotated[float, Variable("1", "0 for NaN, else infinity")] = 0.0


class State(NamedTuple):
    """It has none."""


class Move(NamedTuple):
    """Nothing moves."""


@kernel
def trial(state, memory, motion, dt, p):
    if abs(motion.v) > p.v_most:
        return math.nan if p.beyond == 0.0 else math.inf, Move()
    return math.copysign(p.F_C, motion.v), Move()


@kernel
def commit(state, memory, move, p):
    return State()


MODEL = FrictionModel(
    name="broken",
    description="no number where fast",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
)
