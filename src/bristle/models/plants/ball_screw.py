r"""A ball screw: a motor turns a screw that pulls a table. Friction acts on both sides.

.. math::
    J\,\ddot\theta &= u - F_m - r\,f_s, \qquad M \ddot x = f_s - F_t, \qquad r = \ell/2\pi \\
    f_s &= k\,\delta + d\,\dot\delta, \qquad \delta = D_g(r\theta - x)

:math:`\theta` is the angle of the motor, :math:`x` the travel of the table, :math:`\ell` the lead; :math:`D_g` is the
dead zone of the backlash, of half gap :math:`g`: inside it the nut touches neither flank and transmits no force.
:math:`F_m` is the friction of motor and bearings, :math:`F_t` that of guides and nut [1]_.

A linear motor behind a coupling has the same equations with :math:`r = 1`: position for :math:`\theta`, mass for :math:`J`.

The plant has two ports for friction: motor and table. The port of the motor has the form of the port of an `inertia`.
For every trial velocity of the motor the engine solves the equations of screw and table.

References
----------
.. [1] Y. Altintas, A. Verl, C. Brecher, L. Uriarte, G. Pritschow, "Machine tool feed drives", CIRP Annals 60(2), 2011.
   doi:10.1016/j.cirp.2011.05.010
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.contracts import Plant, Screw
from bristle.models.plants.inertia import (
    Parameters as Inertia,
    State,
    port as port_of,
    rest as rest_of,
    step as step_of,
)


class Parameters(NamedTuple):
    """Parameters of the ball screw."""

    J: Annotated[
        float,
        Variable(
            "mass", "inertia of motor, coupling and screw", min=1e-15, excitation="acceleration"
        ),
    ]
    M: Annotated[float, Variable("mass of travel", "mass of the table", min=1e-9, nominal=10.0)]
    lead: Annotated[
        float, Variable("travel", "travel per turn; of a linear motor 2*pi", min=1e-6, nominal=5e-3)
    ]
    k: Annotated[
        float,
        Variable(
            "force of travel/travel",
            "stiffness of screw, nut and bearings along the travel",
            min=1.0,
            nominal=1e8,
        ),
    ]
    d: Annotated[
        float,
        Variable("force of travel*time/travel", "damping in parallel with this stiffness", min=0.0),
    ] = 0.0
    backlash: Annotated[float, Variable("travel", "travel lost at a reversal", min=0.0)] = 0.0


@kernel
def port(state, effort, dt, p):
    """Return `a` [rad/s] and `b` [rad/(N*m*s)]: mean velocity ``a + b * force`` of the motor over the step."""
    return port_of(state, effort, dt, Inertia(p.J))


@kernel
def step(state, effort, force, dt, p):
    """Return the angle of the motor [rad] after the step and the state, for a mean torque `force` [N*m]."""
    return step_of(state, effort, force, dt, Inertia(p.J))


@kernel
def rest(state, effort, dt, p):
    """Return the state after a time `dt` [s] with the motor held at rest."""
    return rest_of(state, effort, dt, Inertia(p.J))


def screw(p: Parameters) -> Screw:
    """Return the transmission between the motor and the friction of the table."""
    return Screw(p.M, p.k, p.d, 0.5 * p.backlash, p.lead / (2.0 * math.pi))


MODEL = ball_screw = Plant(
    name="ball_screw",
    description="a motor that pulls a table by an elastic screw with backlash, with friction on both sides",
    Parameters=Parameters,
    State=State,
    port=port,
    step=step,
    rest=rest,
    screw=screw,
    reference="doi:10.1016/j.cirp.2011.05.010",
    example={"J": 1e-4, "M": 20.0, "lead": 5e-3, "k": 1e8, "d": 2e3, "backlash": 0.0},
)
