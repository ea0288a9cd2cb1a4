r"""Proportional-derivative control with an adaptive hysteresis compensator: a Prandtl-Ishlinskii sum, learned online.

With the error :math:`e = r - q` and the surface :math:`\varsigma = \dot e + \lambda e`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \varsigma\right] + w_0 + \sum_{i=1}^{6} w_i E_i[r] + \hat F

:math:`\hat F` is the feedforward. :math:`E_i` are normalised stop operators of the desired motion. Their thresholds
divide the reach :math:`\rho` of pre-sliding evenly:

.. math::
    E_i \leftarrow \max\left(-1, \min\left(1, E_i + \frac{\Delta r}{\rho_i}\right)\right), \quad
    \rho_i = \frac{i}{6}\,\rho

The effort is linear in the weights, so the weights follow the gradient of the energy :math:`J\varsigma^2/2`,

.. math::
    \dot w_i = \Gamma E_i \varsigma_\delta, \quad \dot w_0 = \Gamma \varsigma_\delta, \quad
    \varsigma_\delta = \varsigma - \max(-\delta, \min(\delta, \varsigma))

The dead zone :math:`\delta` keeps the counts of the encoder out of the learning. A projection keeps
:math:`0 \le w_i \le w_{max}` and :math:`|w_0| \le w_{max}`, so the weights are always bounded. If some weights give
:math:`F = w_0 + \sum w_i E_i[r]`, then :math:`V = J\varsigma^2/2 + \sum \tilde w_i^2/(2\Gamma)` falls outside the dead
zone, with the errors :math:`\tilde w_i` of the learned weights.

The weights belong to the state of the operators, not to the time, so they carry to other references. A run begins with
the weights of its parameters. The result of a simulation has the law with the learned weights, for the next run; trials
of an experiment with learning pass them on. With :math:`\Gamma = 0` the weights are a feedforward.

References
----------
.. [1] K. Kuhnen, P. Krejci, "Compensation of complex hysteresis and creep effects in piezoelectrically actuated
   systems: a new Preisach modeling approach", IEEE Transactions on Automatic Control 54(3), 2009.
   doi:10.1109/TAC.2009.2012984
.. [2] J.-J. E. Slotine, W. Li, "Applied Nonlinear Control", Prentice Hall, 1991, chapter 8.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Relation, Variable, kernel
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before

ELEMENTS = 6.0
WEIGHTS = ("w_0", "w_1", "w_2", "w_3", "w_4", "w_5", "w_6")

Stress = Annotated[float, Variable("1", "normalised output of a stop operator", min=-1.0, max=1.0)]
Weight = Annotated[float, Variable("force", "learned strength of a stop operator", min=0.0)]

FirstWeight = Annotated[
    float, Variable("force", "strength of a stop operator at the start", min=0.0)
]


class Parameters(NamedTuple):
    """Parameters of the law with an adaptive compensator."""

    J: quantities.KnownInertia
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    reach: Annotated[
        float, Variable("length", "distance after a reversal over which friction rises", min=1e-12)
    ]
    Gamma: Annotated[float, Variable("force/length", "rate of learning", min=0.0)]
    w_max: Annotated[
        float,
        Variable("force", "largest strength of each element, and of the constant part", min=0.0),
    ]
    delta: Annotated[
        float,
        Variable("length/time", "dead zone of the learning, in units of the surface", min=0.0),
    ] = 0.0
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf
    w_0: Annotated[float, Variable("force", "constant part at the start")] = 0.0
    w_1: FirstWeight = 0.0
    w_2: FirstWeight = 0.0
    w_3: FirstWeight = 0.0
    w_4: FirstWeight = 0.0
    w_5: FirstWeight = 0.0
    w_6: FirstWeight = 0.0


class State(NamedTuple):
    """State of the law with an adaptive compensator."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    r: Annotated[float, Variable("length", "desired position one sample ago")] = 0.0
    w_0: Annotated[float, Variable("force", "learned constant part")] = 0.0
    E_1: Stress = 0.0
    E_2: Stress = 0.0
    E_3: Stress = 0.0
    E_4: Stress = 0.0
    E_5: Stress = 0.0
    E_6: Stress = 0.0
    w_1: Weight = 0.0
    w_2: Weight = 0.0
    w_3: Weight = 0.0
    w_4: Weight = 0.0
    w_5: Weight = 0.0
    w_6: Weight = 0.0


@kernel
def stop(E, dr, i, p):
    """Return the output of the i-th stop operator after a step of the desired position by `dr` [m or rad]."""
    return max(-1.0, min(1.0, E + dr * ELEMENTS / (i * p.reach)))


@kernel
def learned(w, E, surface, least, dt, p):
    """Return a weight [N or N*m] after a sample, between `least` times the largest and the largest."""
    return max(least * p.w_max, min(p.w_max, w + dt * p.Gamma * E * surface))


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    dr = reference.position - state.r
    E_1, E_2, E_3 = (
        stop(state.E_1, dr, 1.0, p),
        stop(state.E_2, dr, 2.0, p),
        stop(state.E_3, dr, 3.0, p),
    )
    E_4, E_5, E_6 = (
        stop(state.E_4, dr, 4.0, p),
        stop(state.E_5, dr, 5.0, p),
        stop(state.E_6, dr, 6.0, p),
    )
    held = (
        state.w_1 * E_1
        + state.w_2 * E_2
        + state.w_3 * E_3
        + state.w_4 * E_4
        + state.w_5 * E_5
        + state.w_6 * E_6
    )
    demand = (
        p.J * (reference.acceleration + p.lambda_ * e_dot + p.K_1 * surface)
        + state.w_0
        + held
        + reference.effort
    )
    effort = max(-p.limit, min(p.limit, demand))
    # A limited effort does not correspond to the weights, so they do not learn from it.
    beyond = 0.0 if effort != demand else surface - max(-p.delta, min(p.delta, surface))
    return effort, State(
        motion.q,
        motion.v,
        reference.position,
        learned(state.w_0, 1.0, beyond, -1.0, dt, p),
        E_1,
        E_2,
        E_3,
        E_4,
        E_5,
        E_6,
        learned(state.w_1, E_1, beyond, 0.0, dt, p),
        learned(state.w_2, E_2, beyond, 0.0, dt, p),
        learned(state.w_3, E_3, beyond, 0.0, dt, p),
        learned(state.w_4, E_4, beyond, 0.0, dt, p),
        learned(state.w_5, E_5, beyond, 0.0, dt, p),
        learned(state.w_6, E_6, beyond, 0.0, dt, p),
    )


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    return State(
        before.q,
        before.v,
        before.q,
        p.w_0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        p.w_1,
        p.w_2,
        p.w_3,
        p.w_4,
        p.w_5,
        p.w_6,
    )


def learned_parameters(state, p):
    """Return the parameters with the learned weights, for the next run."""
    return p._replace(**{name: float(getattr(state, name)) for name in WEIGHTS})


def largest(p):
    """Return the largest weight at the start [N or N*m]."""
    return max(abs(getattr(p, name)) for name in WEIGHTS)


MODEL = adaptive_hysteresis = Controller(
    name="adaptive_hysteresis",
    description="proportional-derivative law that learns a Prandtl-Ishlinskii compensator online",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    learned=learned_parameters,
    relations=(
        Relation(
            "w_max >= w_0 to w_6",
            lambda p: largest(p) <= p.w_max,
            "Raise w_max, or lower the weights",
        ),
    ),
    reference="doi:10.1109/TAC.2009.2012984",
)
