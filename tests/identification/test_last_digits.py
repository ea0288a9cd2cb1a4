"""Statuses do not depend on the last digits of a log: rounding decides no flat fit."""

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.engine import force_along

pytestmark = pytest.mark.slow

MOTION = sines(duration=6.0)
PLAIN = br.friction.find("coulomb_viscous")(F_C=8.0, F_v=30.0)
FALLING = br.friction.find("stribeck")(F_C=8.0, F_S=14.0, v_S=0.02, F_v=30.0)


def log_with(friction, seed=None):
    effort = 12.0 * MOTION.acceleration + force_along(friction, MOTION.velocity, 1e-3)
    effort = effort + np.random.default_rng(1).normal(0.0, 0.05, effort.size)
    if seed is not None:
        effort = effort + 1e-13 * np.ptp(effort) * np.random.default_rng(seed).uniform(-1.0, 1.0, effort.size)
    return log_of(MOTION, effort)


def fitted(log, model):
    return br.identify(log, model, draws=0, blocks=0).best


@pytest.fixture(scope="module")
def plain():
    return fitted(log_with(PLAIN), "stribeck+asymmetry")


def test_an_invisible_fall_is_fixed_at_the_edge_of_the_search(plain):
    v_S = plain.parameters["v_S"]
    assert v_S.status == "unidentifiable"
    assert v_S.std is None
    assert v_S.reason.code in ("no_fall", "no_fall")
    assert "v_S" not in plain.correlation_names
    assert [diagnostic.parameter for diagnostic in plain.diagnostics].count("v_S") == 1
    assert plain.parameters["F_C_pos"].value == pytest.approx(8.0, rel=0.02)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_last_digits_do_not_change_a_status(plain, seed):
    again = fitted(log_with(PLAIN, seed), "stribeck+asymmetry")
    for name, estimate in plain.parameters.items():
        other = again.parameters[name]
        assert other.status == estimate.status, name
        assert other.value == pytest.approx(estimate.value, rel=1e-4, abs=1e-6), name
        if estimate.std is not None:
            assert other.std == pytest.approx(estimate.std, rel=1e-3), name


def test_a_visible_fall_is_found():
    v_S = fitted(log_with(FALLING), "stribeck").parameters["v_S"]
    assert v_S.status == "identified"
    assert v_S.value == pytest.approx(0.02, rel=0.1)
