"""Confounded parameters are fixed or rejected with a reason."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, Motion, log_of, sines, sliding_effort, sliding_log

from bristle.core import Axis, InputError
from bristle.identification import identify
from bristle.report.messages import assumptions_of, message, note_of, warnings_of

pytestmark = pytest.mark.usefixtures("of_one_mass")


def one_way(forward: bool = True) -> Motion:
    t = 1e-3 * np.arange(10_000)
    w = 2.0 * np.pi
    q, v, a = 0.1 * t + 0.01 * np.sin(w * t), 0.1 + 0.01 * w * np.cos(w * t), -0.01 * w * w * np.sin(w * t)
    side = 1.0 if forward else -1.0
    return Motion(t, side * q, side * v, side * a)


def test_offset_is_fixed_with_asymmetry_and_reported():
    log = sliding_log()
    at_zero = identify(log, "coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0).best
    assert at_zero.parameters["offset"].status == "held"
    assert at_zero.parameters["offset"].value == 0.0
    assert any("F_C_pos and F_C_neg" in sentence for sentence in assumptions_of(at_zero))
    at_known = identify(log, "coulomb_viscous+asymmetry", axis=replace(STATED, offset=1.5), blocks=0, draws=0).best
    assert at_known.parameters["offset"].value == 1.5
    # Sliding shows two levels only: whatever the offset is held at, they are the same, and so is the fit.
    for side, sign in (("F_C_pos", 1.0), ("F_C_neg", -1.0)):
        level = at_zero.parameters[side].value
        assert at_known.parameters[side].value + sign * 1.5 == pytest.approx(level, rel=1e-9)
    assert at_known.force_error_percent == pytest.approx(at_zero.force_error_percent, rel=1e-9)


@pytest.mark.parametrize("forward", [True, False])
def test_one_direction_fixes_the_offset(forward):
    motion = one_way(forward)
    fit = identify(log_of(motion, sliding_effort(motion, offset=0.0)), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["offset"].status == "held"
    assert ("forward only" if forward else "backward only") in note_of(fit.parameters["offset"])
    assert fit.parameters["F_C"].value == pytest.approx(8.0, rel=0.02)


def test_one_direction_leaves_the_offset_to_a_model_without_a_level():
    motion = one_way()
    fit = identify(log_of(motion, sliding_effort(motion, F_C=0.0)), "viscous", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["offset"].value == pytest.approx(1.5, abs=4.0 * fit.parameters["offset"].std)


def test_one_direction_does_not_show_the_other():
    motion = one_way()
    with pytest.raises(InputError, match="only forward motion") as caught:
        identify(log_of(motion, sliding_effort(motion)), "coulomb_viscous+asymmetry", axis=STATED, draws=0)
    assert "drop +asymmetry" in caught.value.mend


@pytest.mark.parametrize("known", [{}, {"mass": 12.0}, {"mass": 12.0, "offset": 0.0}, {"axis": Axis(mass=12.0)}])
def test_a_reversed_effort_is_detected_for_any_prior_knowledge(known):
    motion = sines(5.0)
    fit = identify(log_of(motion, -sliding_effort(motion)), "coulomb_viscous", blocks=0, draws=0, **known).best
    (text,) = [diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "sign_reversed"]
    assert text.severity == "error"
    assert "sign = -1" in message(text)


def test_unidentifiably_small_friction_is_not_a_reversed_effort():
    motion = sines(5.0)
    for seed in range(3):
        log = log_of(motion, sliding_effort(motion, seed, noise=0.3, F_C=0.0, F_v=0.0))
        fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
        assert fit.parameters["M"].value == pytest.approx(12.0, rel=0.01)
        assert "sign_reversed" not in {diagnostic.code for diagnostic in fit.diagnostics}


@pytest.mark.parametrize(("length", "force"), [(1.0, 1.0), (2.0**10, 2.0**-10), (2.0**-10, 2.0**10)])
def test_friction_that_adds_energy_is_reported_for_any_magnitude(length, force):
    moved = sines(4.0)
    motion = Motion(moved.time, *(length * item for item in moved[1:]))
    # The inertia has its sign, which is no excuse.
    effort = 500.0 * moved.position + sliding_effort(moved, F_C=-8.0, F_v=-30.0, offset=0.0)
    fit = identify(log_of(motion, force * effort), "coulomb_viscous", axis=Axis(plant="oscillator"), blocks=0, draws=0).best
    assert "sign_reversed" in [diagnostic.code for diagnostic in fit.diagnostics]


def test_an_effort_of_zero_is_rejected():
    motion = sines()
    with pytest.raises(InputError, match="zero throughout"):
        identify(log_of(motion, np.zeros(motion.time.size)), "coulomb_viscous", axis=STATED, draws=0)


def test_a_log_without_effort_is_rejected():
    motion = sines()
    log = log_of(motion, sliding_effort(motion))
    bare = type(log)(log.time, log.position, sample_time=log.sample_time, segments=log.segments)
    with pytest.raises(InputError, match="no effort"):
        identify(bare, "coulomb_viscous", axis=STATED, draws=0)


@pytest.fixture(scope="module")
def driven_log():
    """A log whose friction has the sign of the motion: as where the effort is turned and the inertia is known."""
    motion = sines()
    return log_of(motion, sliding_effort(motion, noise=0.05, F_C=-8.0, F_v=0.0, offset=0.0))


@pytest.mark.parametrize("model", ["coulomb_viscous", "maxwell_slip"])
def test_an_effort_of_the_other_sign_is_fitted_and_its_causes_are_named(driven_log, model):
    fit = identify(driven_log, model, mass=12.0, draws=0, blocks=0).best
    estimate = fit.parameters["F_C"]
    assert (estimate.status, estimate.reason.code) == ("at_edge", "no_friction")
    assert fit.friction.values["F_C"] < 1e-3 * driven_log.effort.values.std()
    warnings = " ".join(warnings_of(fit))
    for cause in ("no force opposes the motion", "gravity", "reversed sign of the effort"):
        assert cause in warnings


def test_with_positive_damping_no_cause_is_sought_in_the_sign():
    motion = sines(5.0)
    effort = sliding_effort(motion, noise=0.05, F_C=-2.0, F_v=60.0, offset=0.0)
    estimate = identify(log_of(motion, effort), "coulomb_viscous", mass=12.0, draws=0, blocks=0).best.parameters["F_C"]
    assert (estimate.status, estimate.reason.code) == ("at_edge", "edge_of_model")
