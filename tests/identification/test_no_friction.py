"""A log without friction is fitted, and the likely causes are reported."""

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines

from bristle.identification import identify
from bristle.report.messages import warnings_of

pytestmark = pytest.mark.usefixtures("of_one_mass")


@pytest.fixture(scope="module")
def driven_log():
    """A log whose friction has the sign of the motion: as where the effort is turned and the inertia is known."""
    motion = sines()
    scatter = np.random.default_rng(4).normal(0.0, 0.05, motion.time.size)
    return log_of(motion, 12.0 * motion.acceleration - 8.0 * np.sign(motion.velocity) + scatter)


@pytest.mark.parametrize("model", ["coulomb_viscous", "maxwell_slip"])
def test_an_effort_of_the_other_sign_is_fitted_and_its_causes_are_named(driven_log, model):
    fit = identify(driven_log, model, mass=12.0, draws=0, blocks=0).best
    estimate = next(item for item in fit.estimates if item.name == "F_C")
    assert estimate.status == "at_edge"
    assert estimate.reason.code == "no_friction"
    assert fit.friction.values["F_C"] < 1e-3 * driven_log.effort.values.std()
    warnings = " ".join(warnings_of(fit))
    assert "no force opposes the motion" in warnings
    assert "gravity" in warnings
    assert "reversed sign of the effort" in warnings


def test_with_positive_damping_no_cause_is_sought_in_the_sign():
    motion = sines(5.0)
    scatter = np.random.default_rng(4).normal(0.0, 0.05, motion.time.size)
    log = log_of(motion, 12.0 * motion.acceleration + 60.0 * motion.velocity - 2.0 * np.sign(motion.velocity) + scatter)
    fit = identify(log, "coulomb_viscous", mass=12.0, draws=0, blocks=0).best
    estimate = next(item for item in fit.estimates if item.name == "F_C")
    assert (estimate.status, estimate.reason.code) == ("at_edge", "edge_of_model")
