r"""A friction model of your own: losses of a gear in proportion to the effort that it transmits.

.. math::
    h\,\dot z = v - |v| z, \qquad
    F = \mu_\text{avg} |\tau| z + \mu_\text{dif}\,\tau z^2 + \sigma_2 v

The side :math:`z` of the teeth changes over the distance `h`. A step at constant velocity has the closed form
:math:`z_1 = s + (z_0 - s) e^{-|\Delta x|/h}` with :math:`s = \operatorname{sgn} v`; the mean force is exact, too. A motor
that drives the load (:math:`\tau v > 0`) loses the share :math:`\mu_\text{avg} + \mu_\text{dif}`, a load that drives the
motor :math:`\mu_\text{avg} - \mu_\text{dif}`: record both. The effort :math:`\tau` to the load follows from the plant, so
the axis file needs ``gravity``, or a known column.

Check it with ``bristle check efficiency.py``; fit it with ``bristle identify LOG --axis axis.toml --model efficiency.py``.

References
----------
.. [1] A. Abate, "Torque-proportional loss in dcmotor", 2026.
   https://github.com/google-deepmind/mujoco/issues/3528
"""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp, relaxation
from bristle.core.surroundings import OF_MOTION
from bristle.friction.level import TRANSMITTED


class Parameters(NamedTuple):
    mu_avg: Annotated[float, TRANSMITTED]
    mu_dif: Annotated[float, Variable("1", "half the difference of the losses in driving and back-driving", excitation="place")]
    h: Annotated[float, Variable("length", "distance of a change of side", min=1e-12, nominal=1e-3, excitation="presliding")]
    sigma_2: Annotated[float, Variable("force*time/length", "viscous friction", min=0.0, excitation="speed")] = 0.0


class State(NamedTuple):
    z: Annotated[float, Variable("1", "side of the teeth, from -1 to 1")] = 0.0


class Move(NamedTuple):
    z_next: float


@kernel
def trial(state, memory, motion, dt, p):
    side, way = direction(motion.v), abs(motion.v) * dt / p.h
    left, mean = state.z - side, relaxation(way)
    z = side + left * mean
    z_square = side * side + 2.0 * side * left * mean + left * left * relaxation(2.0 * way)
    force = p.mu_avg * abs(motion.transmitted) * z + p.mu_dif * motion.transmitted * z_square
    return force + p.sigma_2 * motion.v, Move(side + left * exp(-way))


@kernel
def commit(state, memory, move, p):
    return State(move.z_next)


@dataclass(frozen=True, kw_only=True)
class GearModel(FrictionModel):
    """A friction model whose force depends on the transmitted effort."""

    @property
    def surroundings(self) -> tuple[Any, ...]:
        return (OF_MOTION["transmitted"],)


MODEL = GearModel(
    name="efficiency",
    description="losses of a gear in proportion to the transmitted effort, other in driving than in back-driving",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    example={"mu_avg": 0.2, "mu_dif": 0.05, "h": 1e-4, "sigma_2": 20.0},
)
