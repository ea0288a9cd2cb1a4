r"""A sensor of your own: a resolver whose error repeats twice per turn.

.. math:: q = x + a \sin\left(4 \pi x / L\right)

Check it with ``bristle check resolver.py``. The file `rig.toml` of the same folder uses it.
"""

from typing import Annotated, NamedTuple

from bristle.core import Sensor, Variable, kernel
from bristle.core.mathematics import sin

FOUR_PI = 12.566370614359172


class Parameters(NamedTuple):
    a: Annotated[float, Variable("length", "largest error", min=0.0)]
    L: Annotated[float, Variable("length", "travel per turn", min=1e-9)]


class State(NamedTuple):
    """Empty: a reading does not depend on earlier samples."""


@kernel
def step(state, x, dt, p):
    return x + p.a * sin(FOUR_PI * x / p.L), state


MODEL = Sensor(
    name="resolver",
    description="resolver with an error of two periods per turn",
    Parameters=Parameters,
    State=State,
    step=step,
    example={"a": 2.5e-6, "L": 10e-3},
)
