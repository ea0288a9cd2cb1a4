r"""A mass on a spring with a damper: a structure that rings, or a table on flexures.

.. math:: M \ddot x + c\,\dot x + k\,x = u - F

Over a step of length `h` the spring and the damper act with their forces at the mean position and the mean velocity.
The mean velocity

.. math:: v_m = \frac{v_0 + \frac{h}{2M}\left[u - k\,x_0 - F\right]}{1 + \frac{h}{2M}\left[c + \tfrac12 h k\right]}

is affine in the friction force. The free motion of a step loses energy in the damper only.
"""

from typing import Annotated, NamedTuple

from bristle.core import Plant, Variable, kernel


class Parameters(NamedTuple):
    """Parameters of the oscillator."""

    M: Annotated[
        float, Variable("mass", "moving mass or inertia", min=1e-15, excitation="acceleration")
    ]
    c: Annotated[
        float, Variable("force*time/length", "damping to the ground", min=0.0, excitation="speed")
    ]
    k: Annotated[
        float,
        Variable("force/length", "stiffness to the ground", min=0.0, excitation="displacement"),
    ]


class State(NamedTuple):
    """State of the oscillator."""

    x: Annotated[float, Variable("length", "position")] = 0.0
    v: Annotated[float, Variable("length/time", "velocity")] = 0.0


@kernel
def port(state, effort, dt, p):
    """Return `a` [m/s or rad/s] and `b` [m/(N*s) or rad/(N*m*s)]: mean velocity ``a + b * force`` over the step."""
    half = 0.5 * dt / p.M
    give = 1.0 / (1.0 + half * (p.c + 0.5 * dt * p.k))
    return (state.v + half * (effort - p.k * state.x)) * give, -half * give


@kernel
def step(state, effort, force, dt, p):
    """Return the position [m or rad] after the step and the state, for a mean friction `force` [N or N*m]."""
    a, b = port(state, effort, dt, p)
    v_mean = a + b * force
    x_next = state.x + dt * v_mean
    return x_next, State(x_next, 2.0 * v_mean - state.v)


@kernel
def rest(state, effort, dt, p):
    """Return the state after a time `dt` [s] with the port held at rest."""
    return State(state.x, 0.0)


@kernel
def rate(state, effort, force, p):
    """Return the time derivative of the state."""
    return State(state.v, (effort - force - p.c * state.v - p.k * state.x) / p.M)


def inverse(x, v, a, p):
    """Return the effort [N or N*m] of the motion without friction; all arrays have the same shape."""
    return p.M * a + p.c * v + p.k * x


MODEL = oscillator = Plant(
    name="oscillator",
    description="one mass or inertia on a spring and a damper to the ground",
    Parameters=Parameters,
    State=State,
    port=port,
    step=step,
    rest=rest,
    rate=rate,
    inverse=inverse,
)
