r"""Proportional-integral-derivative control with a reduced-order observer of velocity and friction force.

With the error :math:`e = r - q` and the surface :math:`\varsigma = \dot e + \lambda e`

.. math::
    u = J\left[\ddot r + \lambda\,\dot e + K_1 \left(\varsigma + K_I {\textstyle\int} \varsigma\, dt\right)\right]
        + \hat f + \hat F

:math:`\hat F` is the feedforward, :math:`\hat f` the observed rest of the friction. The friction force is a state,
with the stiffness of pre-sliding as a time-varying element of the system matrix. Only the position is measured:

.. math::
    \dot{\hat v} &= \tfrac{1}{J}\left(u - \hat F - \hat f\right) + (g_1 + g_2)\,(\dot q - \hat v) \\
    \dot{\hat f} &= a(t)\,\hat v - J g_1 g_2\,(\dot q - \hat v), \qquad
    a(t) = \sigma_0 \max\left(0, \min\left(2, 1 - s\,\frac{\hat f}{F_C}\right)\right)

The errors of the observer follow :math:`\ddot\epsilon + (g_1 + g_2)\,\dot\epsilon + (g_1 g_2 + a/J)\,\epsilon = 0` with
:math:`0 \le a \le 2\sigma_0`. Its eigenvalues are real and negative for every :math:`a` if

.. math:: g_2 \ge g_1 + 2\sqrt{2\sigma_0/J}

bristle refuses other gains. The slowest pole is :math:`-g_1`, in sliding. The direction :math:`s` changes when the
measured position is farther than a band behind its last extreme, so that no sign of a noisy velocity enters. The
implicit step of the integration is stable for every :math:`g_2`.

Only the abstract and the opening of both papers by Ruderman were readable [1]_ [2]_. From them come the friction state,
the reduced-order observer without measured velocity, the real eigenvalues, the dominant pole and the compensator beside
a PID. The equations are derived here, with Dahl's stiffness. Ruderman proves stability by Ignatyev's criterion [3]_,
which needs a bounded rate of :math:`a`. Here the circle criterion proves it for any rate: the condition of real
eigenvalues implies :math:`\sqrt{g_1 g_2 + 2\sigma_0/J} < g_1 + g_2 + \sqrt{g_1 g_2}`.

On simulated axes (``python -m benchmarks.laws observer``), the error of the observed force is 1.0 to 1.4 N rms, and that
of a disturbance observer with the same dominant pole 2.6 to 3.0 N. With an identified friction model fed forward, the
disturbance observer follows more accurately. Set :math:`\sigma_0 = 0` with such a model: the rest of the friction lacks
the stiffness of pre-sliding.

References
----------
.. [1] M. Ruderman, "Reduced-order asymptotic observer of nonlinear friction for precise motion control", 2025.
   arXiv:2504.21316
.. [2] M. Ruderman, "Robust asymptotic observer of motion states with nonlinear friction", 2023. arXiv:2305.15870
.. [3] A. O. Ignatyev, "Stability of a linear oscillator with variable parameters", Electronic Journal of Differential
   Equations 1997(17), 1997.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Controller, Relation, Variable, kernel
from bristle.core.mathematics import relaxation
from bristle.models.controllers import quantities
from bristle.models.controllers.surface import surface_at
from bristle.models.controllers.velocity import motion_before

MOST = 1e9  # travel over F_C/sigma_0 in a sample; more occurs only in a loop that diverges


class Parameters(NamedTuple):
    """Parameters of the law with an asymptotic observer."""

    J: Annotated[float, Variable("mass", "mass or inertia that the law assumes", min=1e-12)]
    lambda_: quantities.SurfaceSlope
    K_1: quantities.ApproachRate
    g_1: Annotated[
        float, Variable("1/time", "dominant, slowest pole of the observer", min=1e-9, nominal=60.0)
    ]
    g_2: Annotated[
        float, Variable("1/time", "fast pole of the observer in sliding", min=0.0, nominal=600.0)
    ]
    F_C: Annotated[float, Variable("force", "Coulomb friction force of the observer", min=1e-12)]
    sigma_0: Annotated[
        float,
        Variable("force/length", "pre-sliding stiffness of the observer at zero force", min=0.0),
    ]
    K_I: Annotated[float, Variable("1/time", "rate of the integral part", min=0.0)] = 0.0
    band: Annotated[
        float,
        Variable(
            "length", "travel back from an extreme of the position that is a reversal", min=0.0
        ),
    ] = 0.0
    estimator: quantities.Estimator = 0
    cutoff: quantities.Cutoff = math.inf
    limit: quantities.EffortLimit = math.inf


class State(NamedTuple):
    """State of the law with an asymptotic observer."""

    q: quantities.PositionBefore = 0.0
    v: quantities.VelocityBefore = 0.0
    measured: Annotated[float, Variable("length", "measured position one sample ago")] = 0.0
    v_hat: Annotated[float, Variable("length/time", "velocity of the observer")] = 0.0
    f_hat: Annotated[float, Variable("force", "friction force of the observer")] = 0.0
    extreme: Annotated[float, Variable("length", "last extreme of the measured position")] = 0.0
    side: Annotated[int, Variable("1", "direction of the motion: 1 or -1, 0 before it moves")] = 0
    integral: Annotated[float, Variable("length", "integral of the surface")] = 0.0
    feedback: Annotated[
        float, Variable("force", "effort one sample ago, minus the feedforward")
    ] = 0.0


@kernel
def observe(state, measured, dt, p):
    """Return velocity and friction force of the observer, the last extreme and the direction, after a sample."""
    extreme, side = state.extreme, state.side
    if side * (measured - extreme) > 0.0:
        extreme = measured
    elif abs(measured - extreme) > p.band:
        side = 1 if measured > extreme else -1
        extreme = measured
    moved, slow = measured - state.measured, p.J * p.g_1 * p.g_2
    loaded = side * state.f_hat if side != 0 else abs(state.f_hat)
    # Dahl's force is exponential in the travel: its mean stiffness over the sample.
    travel = min(MOST, p.sigma_0 * max(abs(moved), dt * abs(state.v_hat)) / p.F_C)
    a = p.sigma_0 * max(0.0, min(2.0, 1.0 - loaded / p.F_C)) * relaxation(travel)
    damping, f = p.g_1 + p.g_2, state.f_hat - slow * moved
    known = state.v_hat + damping * moved + dt * (state.feedback - f) / p.J
    v_hat = known / (1.0 + dt * damping + dt * dt * (a + slow) / p.J)
    return v_hat, f + dt * (a + slow) * v_hat, extreme, side


@kernel
def step(state, reference, measured, dt, p):
    """Return the effort [N or N*m] and the state, for one sample."""
    motion, e_dot, surface = surface_at(state, reference, measured, dt, p)
    v_hat, f_hat, extreme, side = observe(state, measured, dt, p)
    integral = state.integral + dt * surface
    pull = reference.acceleration + p.lambda_ * e_dot + p.K_1 * (surface + p.K_I * integral)
    demand = p.J * pull + f_hat + reference.effort
    effort = max(-p.limit, min(p.limit, demand))
    if effort != demand and surface * demand > 0.0:
        integral = state.integral
    return effort, State(
        motion.q,
        motion.v,
        measured,
        v_hat,
        f_hat,
        extreme,
        side,
        integral,
        effort - reference.effort,
    )


@kernel
def start(measured, velocity, acceleration, dt, p):
    """Return the state of a law that takes over a motion at `velocity` [m/s or rad/s] and `acceleration`."""
    before = motion_before(measured, velocity, acceleration, dt)
    side = 0 if velocity == 0.0 else (1 if velocity > 0.0 else -1)
    return State(
        before.q, before.v, before.q, before.v, 0.0, before.q, side, 0.0, p.J * acceleration
    )


@kernel
def resume(state, reference, measured, effort, dt, p):
    """Return the state of a law after a known effort: the part beyond its inertia was friction."""
    if math.isnan(effort):
        return state
    feedback = effort - reference.effort
    f_hat = state.f_hat + feedback - state.feedback
    return State(
        state.q,
        state.v,
        state.measured,
        state.v_hat,
        f_hat,
        state.extreme,
        state.side,
        state.integral,
        feedback,
    )


def least(p):
    """Return the smallest g_2 [1/s] whose eigenvalues are real at every stiffness of pre-sliding."""
    return p.g_1 + 2.0 * math.sqrt(2.0 * p.sigma_0 / p.J)


MODEL = asymptotic_observer = Controller(
    name="asymptotic_observer",
    description="proportional-integral-derivative law with a reduced-order observer of velocity and friction",
    Parameters=Parameters,
    State=State,
    step=step,
    start=start,
    resume=resume,
    reference="arXiv:2504.21316",
    relations=(
        Relation(
            "g_2 >= g_1 + 2*sqrt(2*sigma_0/J) for real eigenvalues of the observer",
            lambda p: p.g_2 >= least(p),
            "Raise g_2, or lower g_1 or sigma_0",
            allowed=lambda p: f"g_2 >= {least(p):.4g} 1/s",
        ),
    ),
    example={
        "J": 100.0,
        "lambda_": 150.0,
        "K_1": 150.0,
        "g_1": 60.0,
        "g_2": 400.0,
        "F_C": 10.0,
        "sigma_0": 1e6,
    },
)
