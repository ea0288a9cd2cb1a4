r"""An incremental encoder: the position in whole counts, read with noise.

.. math:: q = \Delta \left\lfloor \frac{x + \eta}{\Delta} + \tfrac12 \right\rfloor, \qquad \eta \sim N(0, \sigma^2)

With :math:`\Delta = 0` the output is the position with its noise. The noise of sample `k` is a function of the seed and
of `k` only: equal seeds give equal noise.
"""

import math
from typing import Annotated, NamedTuple

from bristle.core import Sensor, Variable, kernel
from bristle.core.random_numbers import SEED_MAX, normal

# Beyond it every number is already a whole count, and does not fit an integer of compiled code.
COUNTS_MAX = 2.0**52


class Parameters(NamedTuple):
    """Parameters of the encoder."""

    resolution: Annotated[
        float, Variable("length", "size of one count; 0 for no rounding", min=0.0, nominal=1e-7)
    ] = 0.0
    noise: Annotated[
        float, Variable("length", "standard deviation of the noise before counting", min=0.0)
    ] = 0.0
    seed: Annotated[int, Variable("1", "seed of the noise", min=0, max=SEED_MAX)] = 0


class State(NamedTuple):
    """State of the encoder."""

    samples: Annotated[int, Variable("1", "samples read so far", min=0)] = 0


@kernel
def step(state, x, dt, p):
    """Return the position in whole counts [m or rad], and the state."""
    read = x + p.noise * normal(p.seed, state.samples) if p.noise > 0.0 else x
    state_next = State(state.samples + 1)
    if p.resolution <= 0.0 or abs(read) >= COUNTS_MAX * p.resolution:
        return read, state_next
    return p.resolution * math.floor(read / p.resolution + 0.5), state_next


MODEL = encoder = Sensor(
    name="encoder",
    description="position in whole counts, with noise",
    Parameters=Parameters,
    State=State,
    step=step,
)
