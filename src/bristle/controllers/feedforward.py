r"""What becomes of a friction force on its way to the drive: gain, asymmetry, offset and limits.

.. math:: u_\text{ff} = g\,\hat F\,(1 + a \operatorname{sgn} \hat F) + u_0

limited in amplitude and in rate. A gain below 1 leaves room for what a compensator does not know; the asymmetry and
the offset are for directions that differ in a way that the model does not.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core.experiment import FEEDFORWARD
from bristle.core.kernel import kernel

__all__ = ["Shape", "shaped"]


class Shape(NamedTuple):
    """How a friction force is fed forward."""

    gain: Annotated[float, FEEDFORWARD["gain"]] = 1.0
    offset: Annotated[float, FEEDFORWARD["offset"]] = 0.0
    asymmetry: Annotated[float, FEEDFORWARD["asymmetry"]] = 0.0
    limit: Annotated[float, FEEDFORWARD["limit"]] = math.inf
    rate_limit: Annotated[float, FEEDFORWARD["rate_limit"]] = math.inf


@kernel
def shaped(force, before, dt, shape):
    """Return the effort [N or N*m] fed forward for a friction `force`; `before` is that of the last sample."""
    wanted = shape.gain * force * (1.0 + shape.asymmetry * math.copysign(1.0, force)) + shape.offset
    wanted = max(-shape.limit, min(shape.limit, wanted))
    change = shape.rate_limit * dt
    return max(before - change, min(before + change, wanted))
