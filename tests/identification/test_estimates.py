"""What is said of an estimate at the edge of its model or of what was searched."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, sliding_log

from bristle.identification import identify


def codes(fit, name):
    return [one.code for one in fit.diagnostics if one.parameter == name]


@pytest.mark.parametrize(("F_v", "expected"), [(30.0, []), (-3.0, ["edge_of_model"])])
def test_a_coefficient_that_would_be_negative_stays_at_the_edge_of_its_model(F_v, expected):
    fit = identify(sliding_log(F_v=F_v), "coulomb_viscous", draws=0, blocks=0).best
    assert codes(fit, "F_v") == expected
    assert fit.parameters["F_v"].value == pytest.approx(max(F_v, 0.0), abs=1.0)


@pytest.mark.parametrize(
    ("F_S", "v_S", "known", "fall"),
    [(10.0, 3e-3, "identified", "identified"), (9.0, 1e-3, "unidentifiable", "at_edge")],
)
def test_a_break_away_force_is_known_together_with_the_speed_that_friction_falls_with_or_not(F_S, v_S, known, fall):
    # The slowest half of a percent of the rows moves at 1.3 mm/s.
    motion = sines(phases=tuple(np.random.default_rng(0).uniform(0.0, 6.0, 3)))
    falls = (F_S - TRUTH["F_C"]) * np.exp(-((motion.velocity / v_S) ** 2)) * np.sign(motion.velocity)
    log = log_of(motion, sliding_effort(motion) + falls)
    found = identify(log, "stribeck", axis=STATED, blocks=0, draws=0).best.parameters
    assert (found["F_S"].status, found["v_S"].status) == (known, fall)
    if known == "identified":
        assert found["F_S"].value == pytest.approx(F_S, rel=0.02)
        assert found["v_S"].value == pytest.approx(v_S, rel=0.1)
