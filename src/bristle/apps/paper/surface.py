r"""Whether the surface of (19) is reached, and the distance of the loop from it: (20) and (21) with residual friction.

With the law (23) and an estimate :math:`\hat F` instead of :math:`F_p`, :math:`\varsigma = \dot e + \lambda e`
obeys

.. math::
    \dot\varsigma = -K_1 \varsigma - K_2 \operatorname{sgn}\varsigma + d, \qquad d = (F_p - \hat F)/J, \quad |d| \le D

and :math:`V = \tfrac12\varsigma^2` falls with :math:`\dot V \le -K_1\varsigma^2 - (K_2 - D)|\varsigma|`. In sampled
time :math:`u` is constant for :math:`T`, acts :math:`m` samples late, and comes from a surface measured with an error.
The proof of each bound is in the documentation, theory/compensation.
"""

import math

# The bound depends on itself, and converges at once unless sample time and delay are nearly too long for it.
ITERATIONS = 10_000


def reaching_time(start: float, *, K_1: float, K_2: float, residual: float) -> float:
    """Return the longest time to the surface [s]; infinite if it may never be reached."""
    excess = K_2 - residual
    if excess <= 0.0 and start:
        return math.inf
    if excess <= 0.0:
        return 0.0
    if K_1 > 0.0:
        return math.log1p(K_1 * abs(start) / excess) / K_1
    return abs(start) / excess


def ultimate_bound(*, K_1: float, K_2: float, residual: float, phi: float = 0.0) -> float:
    """Return the largest final distance from the surface [m/s or rad/s], in continuous time."""
    outside = max(residual - K_2, 0.0) / K_1
    if phi > 0.0:
        return max(outside, residual * phi / (K_1 * phi + K_2))
    return outside


def sampled_bound(
    *,
    lambda_: float,
    K_1: float,
    K_2: float,
    residual: float,
    sample_time: float,
    delay: int = 0,
    position_error: float = 0.0,
    velocity_error: float = 0.0,
    lag: float = 0.0,
    jerk: float = 0.0,
    phi: float = 0.0,
) -> float:
    """Return the largest final distance from the surface [m/s or rad/s], in sampled time; infinite if no bound exists."""
    # For small sample time and errors it approaches `ultimate_bound`. An encoder of the count c has a position error of c/2.
    # The velocity from the difference of two samples has a lag of T/2, and an error of c/T and T/2 times the largest
    # acceleration of the command.
    oldest = (delay + 1.0) * sample_time  # the largest age of a reading in effect
    margin = 1.0 - K_1 * oldest
    if min(margin, 1.0 - (lambda_ + K_1) * lag) <= 0.0:
        return math.inf
    bound = 0.0
    for _ in range(ITERATIONS):
        # The largest acceleration of the error, for the age of a reading.
        constant = (lambda_ + K_1) * velocity_error + K_1 * lambda_ * position_error
        acceleration = residual + oldest * jerk + K_2 + (K_1 + 2.0 * lambda_) * bound + constant
        acceleration /= 1.0 - (lambda_ + K_1) * lag
        velocity_off = velocity_error + lag * acceleration
        surface_off = velocity_off + lambda_ * position_error
        push = residual + oldest * (jerk + lambda_ * acceleration) + lambda_ * velocity_off
        excess = surface_off + ultimate_bound(K_1=K_1, K_2=K_2, residual=push, phi=phi)
        before, bound = bound, (excess + oldest * (K_2 + push + K_1 * surface_off)) / margin
        if bound - before <= 1e-12 * bound:
            return bound
    return math.inf
