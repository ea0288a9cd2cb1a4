"""Fewer rows if twice differentiated noise of a coarse encoder would hide friction."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core.axis import Axis, Cogging
from bristle.identification import identify
from bristle.report.messages import assumptions_of

pytestmark = pytest.mark.slow

FAST = {"amplitudes": (0.02, 0.004, 0.0015), "frequencies": (0.5, 3.1, 7.3), "phases": (0.3, 1.1, 2.5)}
AXIS = Axis(kind="translational")


@cache
def coarse_log(step, seconds=20.0):
    motion = sines(seconds, 5e-4, **FAST)
    return log_of(motion, sliding_effort(motion, noise=0.05), step=step)


@cache
def coarsely(**named):
    """An encoder whose steps make more noise in the acceleration than friction takes."""
    return result(coarse_log(2.5e-5), **named)


def result(log, axis=AXIS, **named):
    return identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=0, **named)


def test_noise_of_a_coarse_encoder_does_not_hide_friction():
    usual, calm = coarsely(decimation=10), coarsely()
    assert usual.best.metrics["friction_error_percent"] > 40.0
    assert calm.best.metrics["friction_error_percent"] < 8.0
    assert calm.treatment["decimation"] > 20
    for name in ("F_C", "F_v", "offset"):
        assert calm.best.parameters[name].value == pytest.approx(TRUTH[name], rel=0.02)


def test_fewer_rows_are_reported_with_their_cost():
    (message,) = (text for text in assumptions_of(coarsely().best) if "the usual number of rows" in text)
    share = float(message.split(" % of friction")[0].split()[-1])
    # White noise of a step over the root of twelve, in acceleration up to 100 Hz, times the inertia.
    motion = sines(20.0, 5e-4, **FAST)
    turned = np.fft.rfftfreq(motion.time.size, 5e-4)
    white = 2.5e-5 / 12.0**0.5 * np.sqrt(np.mean(np.where(turned < 100.0, (2.0 * np.pi * turned) ** 4, 0.0)))
    friction = np.std(TRUTH["F_C"] * np.sign(motion.velocity) + TRUTH["F_v"] * motion.velocity)
    assert share == pytest.approx(100.0 * TRUTH["M"] * white / friction, rel=0.15)


def test_fewer_rows_are_reported_if_cogging_repeats_the_search_for_the_delay():
    cogs = replace(AXIS, cogging=Cogging("motor", 0.012))
    assert any("the usual number of rows" in text for text in assumptions_of(result(coarse_log(2.5e-5), cogs).best))


def test_noise_above_friction_is_reported_in_plain_numbers():
    (message,) = (text for text in assumptions_of(result(coarse_log(8e-5)).best) if "the usual number of rows" in text)
    assert 100.0 < float(message.split(" % of friction")[0].split()[-1]) < 500.0
    assert "e+" not in message


def test_a_stated_decimation_is_kept():
    assert coarsely(decimation=10).treatment["decimation"] == 10
    assert result(coarse_log(2.5e-5, 7.0), replace(AXIS, decimation=12)).treatment["decimation"] == 12
