r"""A single inertia: the mass of a table, or the inertia of a screw.

.. math:: M \ddot x = u - F

Equation (18) of the source paper is this equation for a rotation, with the inertia J. Over a step of length `h` with
constant effort and friction, the mean velocity is :math:`v_0 + \frac{h}{2M}(u - F)`, affine in the friction force.
"""

from typing import Annotated, NamedTuple

from bristle.core import Plant, Variable, kernel


class Parameters(NamedTuple):
    """Parameters of the inertia."""

    M: Annotated[
        float, Variable("mass", "moving mass or inertia", min=1e-15, excitation="acceleration")
    ]


class State(NamedTuple):
    """State of the inertia."""

    x: Annotated[float, Variable("length", "position")] = 0.0
    v: Annotated[float, Variable("length/time", "velocity")] = 0.0


@kernel
def port(state, effort, dt, p):
    """Return `a` [m/s or rad/s] and `b` [m/(N*s) or rad/(N*m*s)]: mean velocity ``a + b * force`` over the step."""
    half = 0.5 * dt / p.M
    return state.v + half * effort, -half


@kernel
def step(state, effort, force, dt, p):
    """Return the position [m or rad] after the step and the state, for a mean friction `force` [N or N*m]."""
    v_next = state.v + dt / p.M * (effort - force)
    x_next = state.x + 0.5 * dt * (state.v + v_next)
    return x_next, State(x_next, v_next)


@kernel
def rest(state, effort, dt, p):
    """Return the state after a time `dt` [s] with the port held at rest."""
    return State(state.x, 0.0)


@kernel
def rate(state, effort, force, p):
    """Return the time derivative of the state."""
    return State(state.v, (effort - force) / p.M)


def inverse(x, v, a, p):
    """Return the effort [N or N*m] of the motion without friction; all arrays have the same shape."""
    return p.M * a


MODEL = inertia = Plant(
    name="inertia",
    description="one mass or inertia, driven by the effort against the friction",
    Parameters=Parameters,
    State=State,
    port=port,
    step=step,
    rest=rest,
    rate=rate,
    inverse=inverse,
)
