r"""Stops in parallel as a measure, so that a friction model can deflect them like an operator with turning points.

The places of the sliders are the whole memory. A move from them follows a single curve without turning points: the
virgin curve of `bristle.models.hysteresis.turning_points`. Its output is computed by the function of
`bristle.models.hysteresis.prandtl_ishlinskii`. By Masing's rule the Everett function is
:math:`E(\alpha, \beta) = \varphi((\alpha - \beta)/2)`, with the virgin curve
:math:`\varphi(x) = k x + \sum_i w_i \min(x, r_i)`.
"""

from typing import NamedTuple

import numpy as np

from bristle.core.dispatch import register
from bristle.core.kernel import kernel
from bristle.models.hysteresis.prandtl_ishlinskii import force_of_sliders


class Sliders(NamedTuple):
    """Stops in parallel, and the places of their sliders."""

    thresholds: np.ndarray
    weights: np.ndarray
    spring: float
    places: np.ndarray


@kernel
def value(alpha, beta, q):
    """Return E(alpha, beta) [N or N*m], alpha >= beta [m or rad]."""
    x = 0.5 * (alpha - beta)
    f = q.spring * x
    for i in range(q.thresholds.size):
        f += q.weights[i] * min(x, q.thresholds[i])
    return f


@kernel
def slope(alpha, beta, side, q):
    """Return the derivative of E with respect to its moving end [N/m or N*m/rad], the same for both ends."""
    x = 0.5 * (alpha - beta)
    k = 0.5 * q.spring
    for i in range(q.thresholds.size):
        if x < q.thresholds[i]:
            k += 0.5 * q.weights[i]
    return k


@kernel
def onward_output(u, q):
    """Return the output [N or N*m] at the input `u` [m or rad], reached in one move from the places of the sliders."""
    return force_of_sliders(q.places, u, q)


@kernel
def onward_slope(u, q):
    """Return the derivative of `onward_output` [N/m or N*m/rad]: the stiffness of the stops that do not slip there."""
    k = q.spring
    for i in range(q.thresholds.size):
        if abs(u - q.places[i]) < q.thresholds[i]:
            k += q.weights[i]
    return k


register(
    "everett",
    Sliders,
    {"value": value, "slope": slope, "virgin": onward_output, "virgin_slope": onward_slope},
)
