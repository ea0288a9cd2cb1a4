r"""The Bouc-Wen model with its usual amplitudes: the restoring force yields or hardens without limit.

.. math::
    F = z + \sigma_2 v, \qquad
    \frac{dz}{dt} = \alpha\,v - \beta\left(\gamma\,|v|\,|z|^{\nu-1} z + \delta\,v\,|z|^{\nu}\right)

where the exponents apply to the numerical value of `z` in N (N*m). The slope in loading is
:math:`dz/dx = \alpha - \beta(\gamma + \delta)|z|^\nu`, in unloading
:math:`dz/dx = \alpha + \beta(\gamma - \delta)|z|^\nu`. For :math:`\gamma + \delta > 0` the force is bounded and the
contact slides, as in ``bouc_wen``. For :math:`\gamma + \delta < 0` the force hardens: this occurs in structures and
joints, but not in friction. For :math:`\gamma \ge 0` a closed cycle dissipates energy.

The amplitudes are redundant: the force depends on :math:`\beta\gamma` and :math:`\beta\delta` only, for every
:math:`\nu`. No log identifies :math:`\beta` alone.

References
----------
.. [1] Y.-K. Wen, "Method for random vibration of hysteretic systems", Journal of the Engineering Mechanics Division
   102(2), 1976. doi:10.1061/JMCEA3.0002106
.. [2] M. Ismail, F. Ikhouane, J. Rodellar, "The hysteresis Bouc-Wen model, a survey", Archives of Computational
   Methods in Engineering 16, 2009. doi:10.1007/s11831-009-9031-8
"""

from typing import Annotated, NamedTuple

from bristle.core import Variable, kernel
from bristle.core.contracts import FrictionModel, Redundancy
from bristle.core.mathematics import direction, exp, log, power
from bristle.models.friction.slip_law import SlipLaw, stretch

SMALL = 1e-4  # exponent below which a series is more accurate than the exponential
LARGEST = 500.0  # exponent beyond which hardening is no longer followed


class Parameters(NamedTuple):
    """Parameters of the Bouc-Wen model with its usual amplitudes."""

    alpha: Annotated[
        float,
        Variable(
            "force/length", "stiffness at rest", min=1e-9, nominal=1e6, excitation="displacement"
        ),
    ]
    gamma: Annotated[
        float, Variable("1", "amplitude of the energy loss in a cycle", excitation="displacement")
    ]
    delta: Annotated[
        float,
        Variable("1", "amplitude of yielding; below 0 for hardening", excitation="displacement"),
    ]
    beta: Annotated[
        float, Variable("1/length", "common factor of gamma and delta", min=1e-12, nominal=1e3)
    ] = 1.0
    nu: Annotated[float, Variable("1", "exponent, how sharp the knee is", min=1.0, max=20.0)] = 1.0
    sigma_2: Annotated[
        float,
        Variable("force*time/length", "viscous friction coefficient", min=0.0, excitation="speed"),
    ] = 0.0


class State(NamedTuple):
    """State of the Bouc-Wen model."""

    z: Annotated[float, Variable("force", "hysteretic part of the force")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    z_next: float


@kernel
def decay(y, p):
    """Return the rate [1/m or 1/rad] in ``dy/dl = alpha - rate * y`` of a force `y`, along the motion."""
    steepness = p.beta * (1.0 if p.nu == 1.0 else power(abs(y), p.nu - 1.0))
    return steepness * (p.gamma + (p.delta if y >= 0.0 else -p.delta))


@kernel
def linear(y, rate, length, p):
    """Return the change of `y` [N or N*m] along ``dy/dl = alpha - rate * y``: its mean, and its end value."""
    q = max(rate * length, -LARGEST)
    slope = (p.alpha - rate * y) * length
    if abs(q) < SMALL:
        return slope * (0.5 - q / 6.0 + q * q / 24.0), slope * (1.0 - 0.5 * q + q * q / 6.0)
    share = (1.0 - exp(-q)) / q
    return slope * (1.0 - share) / q, slope * share


@kernel
def to_zero(y, rate, p):
    """Return the length [m or rad] after which a force `y` < 0 reaches zero, along ``dy/dl = alpha - rate * y``."""
    q = -rate * y / p.alpha
    if abs(q) < SMALL:
        return -y / p.alpha * (1.0 - 0.5 * q + q * q / 3.0)
    return log(1.0 + q) / rate


@kernel
def on_one_side(y, length, p):
    """Return the change of `y` over a length on which it keeps its sign: its mean, and its end value.

    Exact for the exponent 1, otherwise of second order, with the rate of the middle.
    """
    rate = decay(y, p)
    if p.nu != 1.0:
        _, half = linear(y, rate, 0.5 * length, p)
        rate = decay(y + half, p)
    return linear(y, rate, length, p)


@kernel
def through_zero(y, length, p):
    """Return the change of `y` [N or N*m] over a length: its mean, and its end value; the rate changes at zero."""
    rate = decay(y if p.nu == 1.0 else 0.5 * y, p)
    # If delta exceeds gamma, unloading slows down and may never reach zero.
    first = length if y >= 0.0 or p.alpha <= rate * y else to_zero(y, rate, p)
    if first >= length:
        return on_one_side(y, length, p)
    mean, _ = linear(y, rate, first, p)
    mean_after, change_after = on_one_side(0.0, length - first, p)
    return (first * mean + (length - first) * (mean_after - y)) / length, change_after - y


@kernel
def along(y, length, p):
    """Return the change of `y` [N or N*m] over a length [m or rad] of motion: its mean, and its end value."""
    yielding = p.gamma + p.delta
    if p.nu == 1.0 or yielding <= 0.0:
        return through_zero(y, length, p)
    # A bounded force takes steps of any length, in dimensionless numbers.
    bound = power(p.alpha / (p.beta * yielding), 1.0 / p.nu)
    law = SlipLaw(-1.0, p.nu, (p.gamma - p.delta) / yielding)
    stretched = stretch(y / bound, p.alpha * length / bound, law)
    return bound * stretched.mean_change, bound * stretched.change


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the hysteretic force at its end."""
    v = motion.v
    side = direction(v)
    length = abs(v) * dt
    mean = 0.0
    change = 0.0
    if length > 0.0:
        mean, change = along(side * state.z, length, p)
    return state.z + side * mean + p.sigma_2 * v, Move(state.z + side * change)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.z_next)


@kernel
def rate(state, motion, p):
    """Return the force [N or N*m] and the time derivative of the state [N/s or N*m/s]."""
    v = motion.v
    y = direction(v) * state.z
    return state.z + p.sigma_2 * v, State(v * (p.alpha - decay(y, p) * y))


MODEL = bouc_wen_classic = FrictionModel(
    name="bouc_wen_classic",
    description="Bouc-Wen hysteresis with its usual amplitudes: yields or hardens",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    rate=rate,
    redundancies=(Redundancy("beta", ("gamma", "delta")),),
    reference="doi:10.1061/JMCEA3.0002106",
    example={"alpha": 1e7, "beta": 1e6, "gamma": 0.3, "delta": 0.2, "sigma_2": 200.0},
)
