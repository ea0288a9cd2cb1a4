"""A friction model of a user's own, in a file."""

from pathlib import Path

import pytest

OWN = '''
from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction


class Parameters(NamedTuple):
    F_0: Annotated[float, Variable("force", "force against the motion", min=0.0, directional=True)]
    lambda_: Annotated[float, Variable("1", "a parameter with the name of a keyword")] = 1.0


class State(NamedTuple):
    """None."""


class Move(NamedTuple):
    """None."""


@kernel
def trial(state, memory, motion, dt, p):
    return p.F_0 * direction(motion.v), Move()


@kernel
def commit(state, memory, move, p):
    return state


MODEL = FrictionModel(
    name="own", description="mine", Parameters=Parameters, State=State, trial=trial, commit=commit
)
'''


@pytest.fixture
def own_model(tmp_path) -> Path:
    """The file of a user's own model."""
    path = tmp_path / "own.py"
    path.write_text(OWN)
    return path
