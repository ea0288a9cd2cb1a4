"""What a motion cannot tell: one amplitude, and the same again."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, strokes
from tests.identification.test_elements import elements_log

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.engine import force_along
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.excitation import about_repeated_logs, repeats_after, stroke_lengths
from bristle.identification.preprocessing import treat, treat_all
from bristle.identification.settings import DEFAULT
from bristle.report.messages import warnings_of

TRUTH = {"F_C": 20.0, "nu_i": [0.3, 0.4, 0.3], "k_i": [3e6, 8e6 / 6.0, 0.4e6]}


def one_amplitude(length=60e-6):
    motion = strokes(12, length=length, move=0.6, dwell=0.3)
    friction = force_along(find("maxwell_slip")(**TRUTH), motion.velocity, 1e-3, motion.position)
    return log_of(motion, friction + np.random.default_rng(0).normal(0.0, 0.05, friction.size))


def beginnings(fit):
    return [warning.split(":")[0] for warning in warnings_of(fit)]


def test_one_amplitude_and_repetition_are_told():
    log = one_amplitude()
    identification = identify(log, "dahl,maxwell_slip", axis=STATED, mass=1e-3, cutoff=50.0, decimation=2, draws=0)
    for fit in identification.fits:
        message = " ".join(warnings_of(fit))
        assert "all 23 half-cycles go the same way of 60 µm" in message or "all 22 half-cycles" in message
        assert "dahl" in message
        assert "maxwell_slip" in message
        assert "the motion repeats itself every 1.8 s" in message
    static = identify(log, "coulomb_viscous", axis=STATED, mass=1e-3, draws=0).best
    assert not any("half-cycles" in beginning for beginning in beginnings(static))


def test_nested_loops_are_not_one_amplitude_and_a_motion_of_three_sines_repeats_nothing():
    fit = identify(elements_log(), "maxwell_slip", axis=STATED, mass=12.0, cutoff=80.0, decimation=2, draws=0).best
    assert not any("half-cycles" in beginning or "repeats" in beginning for beginning in beginnings(fit))


def test_half_cycles_leave_trembles_out():
    motion = strokes(6, length=60e-6, move=0.6, dwell=0.3)
    shaken = motion._replace(position=motion.position + 0.2e-6 * np.sin(400.0 * motion.time))
    ways = stroke_lengths(treat(log_of(shaken, np.ones(motion.time.size)), None, 100.0))
    assert ways == pytest.approx(60e-6, rel=0.03)


def test_the_period_is_that_of_the_motion():
    assert repeats_after(treat(log_of(strokes(6), np.ones(21_600)), None)) == pytest.approx(3.6, abs=0.01)
    assert repeats_after(treat(log_of(sines(20.0), np.ones(20_000)), None)) is None


def test_a_log_that_begins_within_a_cycle_is_run_in_along_it():
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
    with pytest.raises(InputError, match="does not come back to where it began"):
        treat(log_of(away, np.ones(2000)), Axis(in_cycle=True), decimation=1)


def test_rests_are_kept_where_the_axis_says_so():
    log = one_amplitude()
    kept, dropped = (treat(log, Axis(keeps_rests=keeps)) for keeps in (True, False))
    assert dropped.effort.size < 0.75 * kept.effort.size
    assert kept.rest_share == dropped.rest_share > 0.2


def cut(log, first, last):
    part = slice(first, last)
    channels = {name: replace(channel, values=channel.values[part]) for name, channel in log.channels() if channel is not None}
    return replace(log, **channels, segments=())


def test_logs_that_repeat_one_another_are_no_test_of_the_model():
    motion, other = strokes(12, length=60e-6), strokes(6, length=25e-6, move=0.9)
    effort = 20.0 * np.sign(motion.velocity) + motion.acceleration
    log = log_of(motion, effort)
    half = motion.time.size // 2
    # The second half begins elsewhere in its period.
    halves = [cut(log, 0, half), cut(log, half + 700, motion.time.size)]
    message = "what was held out is the motion that was fitted"
    fit = identify(halves, "coulomb", axis=STATED, mass=1.0, draws=0).best
    first = next(item for item in warnings_of(fit) if item.startswith("each log repeats the motion of another one: "))
    assert message in first
    third = log_of(other, 20.0 * np.sign(other.velocity) + other.acceleration)
    fit = identify([*halves, third], "coulomb", axis=STATED, mass=1.0, draws=0).best
    assert any(item.startswith("2 of 3 logs repeat the motion") for item in warnings_of(fit))
    fit = identify([halves[0], third], "coulomb", axis=STATED, mass=1.0, draws=0).best
    assert not any("repeat" in item for item in warnings_of(fit))


@pytest.mark.parametrize(("larger", "repeats"), [(1.05, True), (1.5, False)])
@pytest.mark.parametrize("first", [0, 1])
def test_the_same_motion_at_another_amplitude_is_another_one(larger, repeats, first):
    logs = [log_of(motion, sliding_effort(motion)) for motion in (strokes(3), strokes(3, length=0.05 * larger))]
    dataset = treat_all([logs[first], logs[1 - first]], [None, None])
    assert bool(about_repeated_logs(dataset, DEFAULT)) == repeats
