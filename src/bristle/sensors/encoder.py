r"""An incremental encoder: the position in whole counts.

.. math:: q = \Delta \left\lfloor \frac{x}{\Delta} + \tfrac12 \right\rfloor

With :math:`\Delta = 0` the position itself.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core.contracts import Sensor
from bristle.core.kernel import kernel
from bristle.core.variable import Variable

# Beyond it every number is a whole count already, and compiled code has no whole number to hold it.
COUNTS_MAX = 2.0**53


class Parameters(NamedTuple):
    """Parameters of the encoder."""

    resolution: Annotated[float, Variable("length", "one count; 0 for a perfect sensor", min=0.0, nominal=1e-7)] = 0.0


class State(NamedTuple):
    """The encoder has no state."""


@kernel
def step(state, x, dt, p):
    """Return the position in whole counts [m or rad], and the state."""
    if p.resolution <= 0.0 or abs(x) >= COUNTS_MAX * p.resolution:
        return x, state
    return p.resolution * math.floor(x / p.resolution + 0.5), state


MODEL = Sensor(
    name="encoder",
    description="position in whole counts",
    Parameters=Parameters,
    State=State,
    step=step,
)
