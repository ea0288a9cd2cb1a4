"""Slots along the axis: the pitch of a screw is found in a log, or taken from the axis file."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.identification import identify

pytestmark = pytest.mark.usefixtures("of_one_mass")

PITCH = 2.5e-3


def screw_log(**changes):
    motion = sines(10.0)
    angle = 2.0 * np.pi * motion.position / PITCH
    wave = 0.8 * np.cos(angle) - 0.5 * np.sin(angle)
    return log_of(motion, sliding_effort(motion, noise=0.2) + wave, **changes)


def test_the_pitch_is_found_and_the_wave_with_it():
    fit = identify(screw_log(), "coulomb_viscous+periodic", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["pitch"].value == pytest.approx(PITCH, rel=2e-3)
    known = identify(screw_log(), "coulomb_viscous+periodic", axis=replace(STATED, pitch=PITCH), blocks=0, draws=0).best
    assert known.parameters["pitch"].value == PITCH
    assert known.parameters["c_1"].value == pytest.approx(0.8, abs=0.03)
    assert known.parameters["s_1"].value == pytest.approx(-0.5, abs=0.03)
    assert known.parameters["F_C"].value == pytest.approx(TRUTH["F_C"], rel=0.02)
    assert {known.parameters[name].status for name in ("c_1", "s_1")} == {"identified"}


def test_the_pitch_of_a_level_that_reverses_with_the_motion_is_found():
    motion = sines(10.0)
    level = 0.8 * np.cos(2.0 * np.pi * motion.position / PITCH) * np.sign(motion.velocity)
    fit = identify(log_of(motion, sliding_effort(motion, noise=0.2) + level), "coulomb_viscous+ripple", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["pitch"].value == pytest.approx(PITCH, rel=2e-3)
    assert fit.parameters["h_c1"].value == pytest.approx(0.8, abs=0.05)


def test_a_search_fits_slots():
    fit = identify(screw_log(), "coulomb_viscous+periodic+position", axis=replace(STATED, pitch=PITCH), blocks=0, draws=0).best
    assert np.hypot(fit.parameters["c_1"].value, fit.parameters["s_1"].value) == pytest.approx(0.943, abs=0.05)
    for name in ("p_1", "p_2", "a_1", "a_2"):
        assert abs(fit.parameters[name].value) < 0.2, name


def test_a_range_of_less_than_three_turns_does_not_show_a_pitch():
    motion = sines(10.0, amplitudes=(2e-3, 0.0, 0.0))
    with pytest.raises(InputError, match="covers too few turns to find the pitch"):
        identify(log_of(motion, sliding_effort(motion)), "coulomb_viscous+periodic", cutoff=2.0, draws=0)


def test_the_share_of_the_range_goes_from_end_to_end():
    # Not about the zero of the axis, and in two parts, of which one has not been to the ends.
    motion = sines(6.0)
    aside = motion._replace(position=motion.position + 0.07)
    log = log_of(aside, sliding_effort(motion), segments=(slice(0, 1000), slice(1000, 6000)))
    fit = identify(log, "coulomb_viscous+position", axis=STATED, blocks=0, draws=0).best
    x_0, x_L = (fit.parameters[name].value for name in ("x_0", "x_L"))
    ends = (log.position.values.min(), log.position.values.max())
    assert [(x - x_0) / x_L for x in ends] == pytest.approx([-1.0, 1.0], abs=1e-3)


def test_a_wave_along_the_screw_has_the_position_of_the_samples():
    motion = sines(6.0, 2e-3, (0.02, 0.006), (0.5, 1.3), (0, 1))
    angle = 2.0 * np.pi * motion.position / PITCH
    log = log_of(motion, sliding_effort(motion, noise=0.0) + 0.8 * np.cos(angle) - 0.5 * np.sin(angle))
    fit = identify(log, "coulomb_viscous+periodic", axis=Axis(pitch=PITCH), cutoff=200.0, decimation=1, blocks=0, draws=0).best
    assert fit.parameters["c_1"].value == pytest.approx(0.8, abs=3e-3)
    assert fit.parameters["s_1"].value == pytest.approx(-0.5, abs=3e-3)
    # At up to 110 mm/s half a sample is a quarter of a radian, and leaves 1 %.
    assert fit.force_error_percent < 0.1
