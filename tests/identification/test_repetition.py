"""Periodic motions."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, strokes

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.engine import force_along
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.excitation import repeats_after
from bristle.identification.preprocessing import treat

pytestmark = pytest.mark.usefixtures("of_one_mass")

TRUTH = {"F_C": 20.0, "nu_i": [0.3, 0.4, 0.3], "k_i": [3e6, 8e6 / 6.0, 0.4e6]}


def one_amplitude(length=60e-6):
    motion = strokes(5, length=length, move=0.6, dwell=0.3)
    friction = force_along(find("maxwell_slip")(**TRUTH), motion.velocity, 1e-3, motion.position)
    return log_of(motion, friction + np.random.default_rng(0).normal(0.0, 0.05, friction.size))


def test_the_period_is_that_of_the_motion():
    assert repeats_after(treat(log_of(strokes(6), np.ones(21_600)), None)) == pytest.approx(3.6, abs=0.01)
    assert repeats_after(treat(log_of(sines(20.0), np.ones(20_000)), None)) is None


def test_a_log_that_starts_within_a_cycle_is_run_in():
    whole = one_amplitude()
    first = 1800 + 130  # early in the stroke there, of the second cycle
    part = {name: replace(getattr(whole, name), values=getattr(whole, name).values[first:]) for name in ("time", "position", "effort")}
    cut = replace(whole, **part, segments=(slice(0, len(whole) - first),))
    errors = {}
    for in_cycle in (False, True):
        axis = Axis(seeks_delay=False, mass=1e-3, cutoff=200.0, decimation=2, in_cycle=in_cycle, keeps_rests=True)
        errors[in_cycle] = identify(cut, "maxwell_slip", axis=axis, blocks=0, draws=0).best.force_error_percent
    assert errors[True] < 1.5
    assert errors[False] > 3.0 * errors[True]
    away = sines(2.0, amplitudes=(0.02, 0.0, 0.0), frequencies=(0.05, 1.0, 1.0), phases=(0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="never returns to its first value"):
        treat(log_of(away, np.ones(2000)), Axis(in_cycle=True), decimation=1)


def test_rests_are_kept_if_the_axis_requires_it():
    log = one_amplitude()
    kept, dropped = (treat(log, Axis(keeps_rests=keeps)) for keeps in (True, False))
    assert dropped.effort.size < 0.75 * kept.effort.size
    assert kept.rest_share == dropped.rest_share > 0.2
