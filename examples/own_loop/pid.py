r"""A control law of your own: a PID controller with feedforward.

.. math:: u = K_P\,e + K_I \int e\,dt + K_D\,\dot e + u_{ff}

Check it with ``bristle check pid.py``. The file `rig.toml` of the same folder uses it.
"""

from typing import Annotated, NamedTuple

from bristle.core import Controller, Variable, kernel


class Parameters(NamedTuple):
    K_P: Annotated[float, Variable("force/length", "proportional gain", min=0.0)]
    K_I: Annotated[float, Variable("force/length/time", "integral gain", min=0.0)] = 0.0
    K_D: Annotated[float, Variable("force*time/length", "derivative gain", min=0.0)] = 0.0


class State(NamedTuple):
    e: Annotated[float, Variable("length", "error one sample ago")] = 0.0
    total: Annotated[float, Variable("length*time", "integral of the error")] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    e = reference.position - measured
    total = state.total + e * dt
    effort = p.K_P * e + p.K_I * total + p.K_D * (e - state.e) / dt + reference.effort
    return effort, State(e, total)


@kernel
def start(measured, velocity, acceleration, dt, p):
    return State()


MODEL = Controller(
    name="pid",
    description="PID controller",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    example={"K_P": 4e6, "K_I": 4e7, "K_D": 4e4},
)
