"""No feedback: the feedforward is the command, in place of a control law."""

from typing import NamedTuple

from bristle.core import Controller, kernel


class Parameters(NamedTuple):
    """An open loop has no parameters."""


class State(NamedTuple):
    """An open loop has no state."""


@kernel
def step(state, reference, measured, dt, p):
    """Return the feedforward [N or N*m]."""
    return reference.effort, state


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the empty state."""
    return State()


MODEL = open_loop = Controller(
    name="open_loop",
    description="no feedback: the feedforward is the command",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
)
