"""A search: derivatives that the steps of a simulation do not disturb."""

from dataclasses import replace

import numpy as np
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.friction import find
from bristle.identification.estimation import context_of
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat

STEP = 1e-8  # N


class Stepped(InverseDynamics):
    """What is left over jumps, as where the stops of a body move from one step of an integration to the next."""

    def residual(self, free):
        return STEP * np.round(super().residual(free) / STEP)


def test_small_jumps_of_a_simulation_do_not_disturb_a_derivative():
    dataset = treat(log_of(sines(2.0), sliding_effort(sines(2.0))), Axis())
    context, parameters = (context_of(dataset, PriorKnowledge()), parameters_of(find("coulomb_viscous"), PriorKnowledge(), dataset))
    exact, stepped = (context.search(problem(dataset, parameters), 1.0, simulates=True) for problem in (InverseDynamics, Stepped))
    theta = exact.space.theta(TRUTH)
    result, wanted = (item.descend(theta, limit=1).jacobian for item in (stepped, exact))
    np.testing.assert_allclose(result, wanted, atol=2e-3 * np.max(np.abs(wanted)))
    # As finely as a computed residual allows, the jumps would be a good part of it.
    fine = replace(stepped, simulates=False).descend(theta, limit=1).jacobian
    assert np.max(np.abs(fine - wanted)) > 0.02 * np.max(np.abs(wanted))
