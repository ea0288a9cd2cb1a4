r"""The surface that control laws bring to zero, and the observed motion.

With the error :math:`e = r - q` and the velocity :math:`\hat v` from the measured position

.. math:: \dot e = \dot r - \hat v, \qquad \varsigma = \dot e + \lambda e
"""

from typing import NamedTuple

from bristle.core.kernel import kernel
from bristle.models.controllers.velocity import ObservedMotion, observed


class Surface(NamedTuple):
    """The motion observed at a sample, the error of its velocity, and the surface."""

    motion: ObservedMotion
    e_dot: float
    surface: float


@kernel
def surface_at(state, reference, measured, dt, p):
    """Return the `Surface` at a sample, for a law with the previous motion in its state."""
    motion = observed(state.q, state.v, measured, dt, p.estimator, p.cutoff)
    e_dot = reference.velocity - motion.v
    return Surface(motion, e_dot, e_dot + p.lambda_ * (reference.position - measured))
