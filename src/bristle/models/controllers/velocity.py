r"""The velocity of a control law, from sampled positions.

``filtered_difference``: the backward difference through a first-order low-pass of cut-off :math:`f_c`,

.. math:: \hat v_k = \hat v_{k-1} + \left(1 - e^{-2\pi f_c T_s}\right)
          \left(\frac{q_k - q_{k-1}}{T_s} - \hat v_{k-1}\right)

``tracking_observer``: a kinematic observer with both poles at :math:`p = e^{-2\pi f_c T_s}`. It is the least-squares
line through all earlier positions, each with the weight :math:`p` to the power of its age in samples,

.. math:: \tilde q_k = \hat q_{k-1} + T_s \hat v_{k-1}, \quad
          \hat q_k = \tilde q_k + (1 - p^2)(q_k - \tilde q_k), \quad
          \hat v_k = \hat v_{k-1} + \frac{(1 - p)^2}{T_s}(q_k - \tilde q_k)

The observer follows a steady motion without lag, and its velocity has smaller jumps from the counts of an encoder.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Variable, exp, kernel

ESTIMATORS = ("filtered_difference", "tracking_observer")
FILTERED_DIFFERENCE, TRACKING_OBSERVER = range(2)


class ObservedMotion(NamedTuple):
    """Position and velocity estimated by a control law."""

    q: Annotated[float, Variable("length", "position")]
    v: Annotated[float, Variable("length/time", "velocity")]


@kernel
def observed(q, v, measured, dt, estimator, cutoff):
    """Return the `ObservedMotion` at a sample, from that of the previous sample and the measured position [m or rad]."""
    pole = exp(-2.0 * math.pi * min(cutoff * dt, 1e3))
    if estimator == TRACKING_OBSERVER:
        ahead = q + dt * v
        surprise = measured - ahead
        return ObservedMotion(
            ahead + (1.0 - pole * pole) * surprise, v + (1.0 - pole) * (1.0 - pole) / dt * surprise
        )
    return ObservedMotion(measured, v + (1.0 - pole) * ((measured - q) / dt - v))


@kernel
def samples_before(position, velocity, acceleration, dt):
    """Return the position of a motion one sample and two samples before."""
    return (
        position - velocity * dt + 0.5 * acceleration * dt * dt,
        position - 2.0 * velocity * dt + 2.0 * acceleration * dt * dt,
    )


@kernel
def motion_before(measured, velocity, acceleration, dt):
    """Return the observed motion one sample before a control law takes over."""
    before, _ = samples_before(measured, velocity, acceleration, dt)
    return ObservedMotion(before, velocity - acceleration * dt)
