r"""The semi-implicit step: one evaluation of the friction model, no solve. For many trajectories, and for small steps.

The friction force is taken at the velocity at which the step begins; its own state is advanced as the model
does it, exactly or exponentially fitted, so that a stiff contact in sliding does not limit the step. In pre-sliding
the step must resolve the contact: :math:`h < 2/\omega_0` with :math:`\omega_0 = \sqrt{\sigma_0/M}`, and some
micro-damping keeps the oscillation from growing. Order 1. A set-valued model does not stick, it trembles around rest:
EFIM is for those.
"""

from typing import Any, NamedTuple

from bristle.core.contracts import NOMINAL_LOAD, NOMINAL_TEMPERATURE, Motion
from bristle.core.dispatch import friction_commit, friction_trial, plant_step
from bristle.core.kernel import kernel


class Advance(NamedTuple):
    """Where a step led to."""

    plant_state: Any
    friction_state: Any
    force: float


@kernel
def advance(plant_state, friction_state, memory, effort, dt, q, p):
    """Return the `Advance` over one step of `dt` [s] under a constant `effort` [N or N*m]."""
    v = plant_state.v
    force, move = friction_trial(
        friction_state, memory, Motion(v, plant_state.x + dt * v, NOMINAL_LOAD, NOMINAL_TEMPERATURE, effort), dt, p
    )
    friction_next = friction_commit(friction_state, memory, move, p)
    _, plant_next = plant_step(plant_state, effort, force, dt, q)
    return Advance(plant_next, friction_next, force)
