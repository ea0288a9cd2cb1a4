r"""Losses of a gear in proportion to the effort that it transmits, different in driving and in back-driving.

.. math::
    h\,\dot z = v - |v| z, \qquad
    F = \left(F_\text{idle} + \mu(v)\,|\tau|\right) z + \mu_\text{dif}\,\tau z^2 + \sigma_2 v, \qquad
    \mu(v) = \mu_\text{avg} + \mu_\text{fall}\, e^{-(v/v_S)^2}

The side :math:`z` of the teeth changes over the distance :math:`h`. A motor that drives the load (:math:`\tau v > 0`)
loses the share :math:`\mu + \mu_\text{dif}`, a load that drives the motor :math:`\mu - \mu_\text{dif}` [3]_: a log
of both identifies the two coefficients. The effort :math:`\tau` to the load follows from the plant. Identification therefore
needs gravity, a spring or a known column in the axis file.

The published law [1]_ has no friction without load and no fall over speed: :math:`F_\text{idle}` and
:math:`\mu_\text{fall}` are zero by default. A geared arm [2]_ under more than 9 N*m of gravity broke away at 2.4 to
3.3 N*m and slid at 2.1, 1.4 and 0.7 N*m from slow to fast: this ratio of 4 needs :math:`\mu_\text{fall}`. Its 0.65 N*m
in the rest pose need :math:`F_\text{idle}`, if gravity is zero there. A step at constant velocity has the closed form
:math:`z_1 = s + (z_0 - s) e^{-|\Delta x|/h}` with :math:`s = \operatorname{sgn} v`. The mean force is exact, too.

References
----------
.. [1] A. Abate, "Torque-proportional loss in dcmotor", 2026.
   https://github.com/google-deepmind/mujoco/issues/3528
.. [2] axol, MuJoCo Menagerie pull request 317, 2026: friction of a geared arm in two poses.
.. [3] A. Wang, S. Kim, "Directional efficiency in geared transmissions: characterization of backdrivability towards
   improved proprioceptive control", IEEE International Conference on Robotics and Automation, 2015.
   doi:10.1109/ICRA.2015.7139307
"""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

from bristle.core import FrictionModel, Relation, Variable, kernel
from bristle.core.mathematics import direction, exp, relaxation
from bristle.core.surroundings import OF_MOTION
from bristle.models.friction.level import TRANSMITTED
from bristle.models.friction.quantities import ViscousCoefficient

_FORWARD_AND_BACK = "half the difference of the losses in driving and back-driving"


class Parameters(NamedTuple):
    """Parameters of the losses of a gear."""

    mu_avg: Annotated[float, TRANSMITTED]
    mu_dif: Annotated[float, Variable("1", _FORWARD_AND_BACK, nominal=0.01, excitation="place")]
    h: Annotated[
        float,
        Variable(
            "length",
            "distance of a change of side",
            min=1e-12,
            nominal=1e-3,
            excitation="presliding",
        ),
    ]
    sigma_2: ViscousCoefficient = 0.0
    mu_fall: Annotated[
        float, Variable("1", "part of the losses that disappears with speed", min=0.0, nominal=0.1)
    ] = 0.0
    v_S: Annotated[float, Variable("length/time", "Stribeck velocity", min=1e-9, nominal=1e-2)] = (
        1e-2
    )
    F_idle: Annotated[
        float, Variable("force", "friction without a transmitted effort", min=0.0)
    ] = 0.0


class State(NamedTuple):
    """State of a gear."""

    z: Annotated[float, Variable("1", "side of the teeth, from -1 to 1")] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    z_next: float


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the side of the teeth at its end."""
    side, way, ratio = direction(motion.v), abs(motion.v) * dt / p.h, motion.v / p.v_S
    left, mean = state.z - side, relaxation(way)
    z_square = side * side + 2.0 * side * left * mean + left * left * relaxation(2.0 * way)
    of_both = p.F_idle + (p.mu_avg + p.mu_fall * exp(-ratio * ratio)) * abs(motion.transmitted)
    force = of_both * (side + left * mean) + p.mu_dif * motion.transmitted * z_square
    return force + p.sigma_2 * motion.v, Move(side + left * exp(-way))


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.z_next)


@dataclass(frozen=True, kw_only=True)
class GearModel(FrictionModel):
    """A friction model whose force depends on the effort transmitted to the load."""

    @property
    def surroundings(self) -> tuple[Any, ...]:
        """The transmitted effort."""
        return (OF_MOTION["transmitted"],)


MODEL = efficiency = GearModel(
    name="efficiency",
    description="losses of a gear in proportion to the transmitted effort, different in driving and in back-driving",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    relations=(
        Relation(
            "mu_avg >= |mu_dif|",
            lambda p: p.mu_avg >= abs(p.mu_dif),
            "Raise mu_avg, or mu_dif nearer to zero",
        ),
    ),
    reference="doi:10.1109/ICRA.2015.7139307",
    example={
        "mu_avg": 0.2,
        "mu_dif": 0.05,
        "h": 2e-6,
        "sigma_2": 200.0,
        "mu_fall": 0.1,
        "v_S": 2e-3,
        "F_idle": 20.0,
    },
)
