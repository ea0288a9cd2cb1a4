r"""A mass pulled through a spring whose far end moves at constant velocity: the usual test bench for stick-slip.

.. math:: M \ddot x = u + k\,(x_e - x) - F, \qquad \dot x_e = v_e

Over a step of length `h` the spring acts with its force at the mean positions of both ends. The mean velocity

.. math:: v_m = \frac{v_0 + \frac{h}{2M}\left[u + k\,(x_e + \tfrac12 h v_e - x_0) - F\right]}{1 + \frac{k h^2}{4M}}

is affine in the friction force.

References
----------
.. [1] C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with friction",
   IEEE Transactions on Automatic Control 40(3), 1995, section on stick-slip motion. doi:10.1109/9.376053
"""

from typing import Annotated, NamedTuple

from bristle.core import Plant, Variable, kernel


class Parameters(NamedTuple):
    """Parameters of the pulled mass."""

    M: Annotated[
        float, Variable("mass", "moving mass or inertia", min=1e-15, excitation="acceleration")
    ]
    k: Annotated[float, Variable("force/length", "stiffness of the spring", min=0.0)]
    v_e: Annotated[float, Variable("length/time", "velocity of the far end of the spring")]


class State(NamedTuple):
    """State of the pulled mass."""

    x: Annotated[float, Variable("length", "position")] = 0.0
    v: Annotated[float, Variable("length/time", "velocity")] = 0.0
    x_e: Annotated[float, Variable("length", "position of the far end of the spring")] = 0.0


@kernel
def port(state, effort, dt, p):
    """Return `a` [m/s or rad/s] and `b` [m/(N*s) or rad/(N*m*s)]: mean velocity ``a + b * force`` over the step."""
    half = 0.5 * dt / p.M
    give = 1.0 / (1.0 + 0.5 * half * p.k * dt)
    pull = effort + p.k * (state.x_e + 0.5 * dt * p.v_e - state.x)
    return (state.v + half * pull) * give, -half * give


@kernel
def step(state, effort, force, dt, p):
    """Return the position [m or rad] after the step and the state, for a mean friction `force` [N or N*m]."""
    a, b = port(state, effort, dt, p)
    v_mean = a + b * force
    x_next = state.x + dt * v_mean
    return x_next, State(x_next, 2.0 * v_mean - state.v, state.x_e + dt * p.v_e)


@kernel
def rest(state, effort, dt, p):
    """Return the state after a time `dt` [s] with the port held at rest, while the far end moves."""
    return State(state.x, 0.0, state.x_e + dt * p.v_e)


@kernel
def rate(state, effort, force, p):
    """Return the time derivative of the state."""
    return State(state.v, (effort + p.k * (state.x_e - state.x) - force) / p.M, p.v_e)


MODEL = pulled_inertia = Plant(
    name="pulled_inertia",
    description="one mass or inertia, pulled through a spring whose far end moves at constant velocity",
    Parameters=Parameters,
    State=State,
    port=port,
    step=step,
    rest=rest,
    rate=rate,
    reference="doi:10.1109/9.376053",
)
