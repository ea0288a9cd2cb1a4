"""Unidentified parameters are named with their confounded partners."""

from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle.report.messages import warnings_of


def test_a_rich_log_identifies_every_parameter():
    motion = sines(4.0)
    fit = identify(log_of(motion, sliding_effort(motion)), "coulomb_viscous", axis=STATED, blocks=0, draws=20).best
    assert {estimate.status for estimate in fit.estimates} == {"identified"}
    for estimate in fit.estimates:
        assert estimate.interval[0] < estimate.value < estimate.interval[1]
        assert estimate.interval[0] - estimate.larger_std < TRUTH[estimate.name] < estimate.interval[1] + estimate.larger_std


def test_an_inertia_of_small_effect_is_not_identified():
    motion = sines(6.0, amplitudes=(0.02,), frequencies=(0.1,), phases=(0.3,))
    fit = identify(log_of(motion, sliding_effort(motion, noise=0.3, M=0.4)), "coulomb_viscous", axis=STATED, blocks=0, draws=20).best
    assert fit.parameters["M"].status == "unidentifiable"
    assert fit.parameters["F_C"].status == "identified"
    assert any("M cannot be identified" in item for item in warnings_of(fit))
