"""Estimates at the edge of their model or search range."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, sliding_log, slow_log
from tests.identification.rigid import identify

from bristle.friction import find
from bristle.report.messages import warnings_of


@pytest.mark.parametrize(("F_S", "v_S", "status"), [(10.0, 3e-3, "identified"), (9.0, 1e-3, "unidentifiable")])
def test_break_away_force_and_stribeck_velocity_are_identified_only_together(F_S, v_S, status):
    # The slowest half of a percent of the rows moves at 1.3 mm/s.
    motion = sines(phases=tuple(np.random.default_rng(0).uniform(0.0, 6.0, 3)))
    falls = (F_S - TRUTH["F_C"]) * np.exp(-((motion.velocity / v_S) ** 2)) * np.sign(motion.velocity)
    parameters = identify(log_of(motion, sliding_effort(motion) + falls), "stribeck", axis=STATED, blocks=0, draws=0).best.parameters
    assert {parameters[name].status for name in ("F_S", "v_S")} == {status}
    if status == "identified":
        assert (parameters["F_S"].value, parameters["v_S"].value) == (pytest.approx(F_S, rel=0.02), pytest.approx(v_S, rel=0.1))


def test_a_force_is_compared_with_the_effort_without_that_of_the_inertia():
    """Of an effort of 65 N friction takes 16: a third of that is less than its level, a third of the effort is not."""
    log, third = sliding_log(), {"beyond_effort": 0.3}
    fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0, settings=third).best
    assert np.max(np.abs(log.effort.values)) > 4.0 * TRUTH["F_C"]
    assert fit.parameters["F_C"].reason.code == "beyond_effort"
    assert TRUTH["F_C"] < fit.parameters["F_C"].reason.numbers["effort"] < 0.5 * np.max(np.abs(log.effort.values))


@pytest.mark.slow
@pytest.mark.parametrize(("v_S", "told"), [(2e-3, False), (10.0, True)])
def test_a_level_at_slow_speeds_is_reported_as_such(v_S, told):
    truth = find("lugre")(F_C=8.0, F_S=11.0, v_S=v_S, sigma_0=3e5, sigma_1=600.0, sigma_2=0.0 if told else 30.0)
    fit = identify(slow_log(truth), "lugre", axis=STATED, blocks=0, draws=20).best
    assert fit.parameters["F_C"].status == "identified"
    assert any("is the friction at the speeds of this log" in text for text in warnings_of(fit)) is told


def test_a_level_with_a_known_viscous_friction_is_valid_at_all_speeds():
    fit = identify(slow_log(find("coulomb_viscous")(F_C=8.0, F_v=90.0), duration=10.0), "stribeck", axis=STATED, blocks=0, draws=0).best
    statuses = {name: fit.parameters[name].status == "identified" for name in ("F_C", "F_v", "v_S")}
    assert statuses == {"F_C": True, "F_v": True, "v_S": False}
    assert "level_as_seen" not in [diagnostic.code for diagnostic in fit.diagnostics]
