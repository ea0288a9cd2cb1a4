r"""What becomes of a friction force on its way to the drive: gain, asymmetry, offset and limits.

.. math:: u_\text{ff} = g\,\hat F\,(1 + a \operatorname{sgn} \hat F) + u_0

limited in amplitude and in rate. A gain below 1 leaves room for what a compensator does not know; the asymmetry and
the offset are for directions that differ in a way that the model does not.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core.kernel import kernel
from bristle.core.variable import Variable

__all__ = ["Shape", "shaped"]


class Shape(NamedTuple):
    """How a friction force is fed forward."""

    gain: Annotated[float, Variable("1", "factor on the friction")] = 1.0
    offset: Annotated[float, Variable("force", "constant that is added to it")] = 0.0
    asymmetry: Annotated[
        float, Variable("1", "share by which positive friction is raised and negative lowered", min=-1.0, max=1.0)
    ] = 0.0
    limit: Annotated[float, Variable("force", "largest friction fed forward", min=0.0)] = math.inf
    rate_limit: Annotated[float, Variable("force/time", "fastest change of it", min=0.0)] = math.inf


@kernel
def shaped(force, before, dt, shape):
    """Return the effort [N or N*m] fed forward for a friction `force`; `before` is that of the last sample."""
    wanted = shape.gain * force * (1.0 + shape.asymmetry * math.copysign(1.0, force)) + shape.offset
    wanted = max(-shape.limit, min(shape.limit, wanted))
    change = shape.rate_limit * dt
    return max(before - change, min(before + change, wanted))
