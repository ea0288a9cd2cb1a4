r"""Static friction that falls or rises with speed before it becomes constant: a Stribeck curve of either sign.

.. math::
    F = G(v) \operatorname{sgn} v + F_v\,v, \qquad G(v) = F_C + (F_0 - F_C)\,e^{-|v/v_S|^{\delta_S}}

For :math:`F_0 > F_C` this is the Stribeck effect, as in ``stribeck``. For :math:`F_0 < F_C` friction rises over the
first few :math:`v_S`, as in sheared grease or seals and in preloaded rolling balls. Friction then has no break-away peak
that could cause stick-slip. At rest :math:`F \in [-F_0, F_0]`.

References
----------
.. [1] B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, "A survey of models, analysis tools and compensation
   methods for the control of machines with friction", Automatica 30(7), 1994. doi:10.1016/0005-1098(94)90209-7
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction
from bristle.models.friction.quantities import CoulombForce, StribeckVelocity, ViscousCoefficient
from bristle.models.friction.stribeck import stribeck_force


class Parameters(NamedTuple):
    """Parameters of friction that falls or rises with speed."""

    F_C: CoulombForce
    F_0: Annotated[
        float,
        Variable(
            "force",
            "friction force as motion begins; below F_C if friction rises with speed",
            min=0.0,
            directional=True,
            excitation="stribeck",
        ),
    ]
    v_S: StribeckVelocity
    F_v: ViscousCoefficient
    delta_S: Annotated[float, Variable("1", "exponent of the curve", min=0.1, max=10.0)] = 2.0


class State(NamedTuple):
    """A static model has no state."""


class Move(NamedTuple):
    """An empty move."""


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and an empty move."""
    G = stribeck_force(motion.v, p.F_C, p.F_0, p.v_S, p.delta_S)
    return G * direction(motion.v) + p.F_v * motion.v, Move()


@kernel
def commit(state, memory, move, p):
    """Return the state after the step, which is empty."""
    return state


MODEL = stribeck_free = FrictionModel(
    name="stribeck_free",
    description="static map from velocity to force that falls or rises with speed before it becomes constant",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    reference="doi:10.1016/0005-1098(94)90209-7",
    example={"F_C": 24.0, "F_0": 18.0, "v_S": 2e-3, "F_v": 200.0},
)
