"""The motion to record next: which of the motions that `excite` designs narrows open intervals, and by how much."""

from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_log

import bristle.excitation
from bristle.core import Axis, InputError
from bristle.friction import lugre
from bristle.identification import identify
from bristle.report.next_motion import is_open, next_motion


@pytest.fixture(scope="module")
def fit():
    return identify(sliding_log(), "stribeck", axis=STATED, blocks=0, draws=0).best


def opened(fit, **statuses):
    """The same fit, in which these parameters matter and have this status; all others are identified."""
    changed = [
        replace(estimate, status=statuses.get(estimate.name, "identified"), effect=1.0 if estimate.name in statuses else 0.0)
        for estimate in fit.estimates
    ]
    return replace(fit, estimates=tuple(changed))


def rehearsals(monkeypatch, fit, widths, off=1.0, exceeded=()):
    """Stand in for `excite`: by purposes, the half-width in percent that a rehearsal gives each parameter."""
    asked = []

    def excite(axis, *, model, purposes, duration, travel, draws):
        asked.append((purposes, axis, travel))
        if purposes not in widths:
            raise InputError("cannot be planned", path="purposes")
        found = [
            replace(
                estimate,
                status="identified",
                interval=tuple(
                    off * estimate.value * (1.0 + side * widths[purposes].get(estimate.name, 200.0) / 100.0) for side in (-1.0, 1.0)
                ),
            )
            for estimate in fit.estimates
        ]
        return Some(rehearsal=Some(identification=Some(best=Some(estimates=found))), exceeded=exceeded)

    monkeypatch.setattr(bristle.excitation, "excite", excite)
    return asked


def test_a_parameter_that_does_not_matter_or_is_known_is_not_open(fit):
    estimate = next(estimate for estimate in fit.estimates if estimate.name == "F_S")
    known = replace(estimate, status="identified", effect=1.0, interval=(0.9 * estimate.value, 1.1 * estimate.value))
    assert not is_open(known)
    assert is_open(replace(known, status="unidentifiable"))
    assert not is_open(replace(known, status="unidentifiable", effect=0.0))
    assert is_open(replace(known, interval=(0.5 * estimate.value, 1.5 * estimate.value)))


def test_a_fit_without_open_intervals_asks_for_no_motion(fit, monkeypatch):
    asked = rehearsals(monkeypatch, fit, {})
    assert next_motion(opened(fit), Axis(), sliding_log()) is None
    assert asked == []


def test_the_motion_names_the_half_widths_that_its_rehearsal_gives(fit, monkeypatch):
    rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0, "v_S": 90.0}})
    motion = next_motion(opened(fit, F_S="unidentifiable", v_S="unidentifiable"), Axis(), sliding_log())
    assert motion.purposes == "stribeck"
    assert motion.text == "F_S open → ± 4.0 %"
    assert motion.half_widths["F_S"][1] == pytest.approx(4.0)


def test_a_rehearsal_whose_interval_misses_its_own_truth_promises_no_half_width(fit, monkeypatch):
    rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0}}, off=1.1)
    assert next_motion(opened(fit, F_S="unidentifiable"), Axis(), sliding_log()) is None


def test_a_motion_beyond_the_limits_of_the_axis_is_not_proposed(fit, monkeypatch):
    rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0, "v_S": 90.0}}, exceeded=("effort",))
    assert next_motion(opened(fit, F_S="at_edge", v_S="unidentifiable"), Axis(), sliding_log()) is None


def test_the_motion_that_narrows_more_intervals_is_proposed(fit, monkeypatch):
    fit = replace(fit, friction=lugre(F_C=20.0, F_S=30.0, v_S=4e-3, sigma_0=1e6))
    estimate = next(estimate for estimate in fit.estimates if estimate.name == "F_S")
    fit = replace(fit, estimates=tuple(replace(estimate, name=name) for name in ("F_S", "sigma_0", "sigma_1")))
    unknown = opened(fit, F_S="unidentifiable", sigma_0="unidentifiable", sigma_1="unidentifiable")
    gentle, slow = "presliding,break-away,damping", "stribeck"
    for better, worse in ((gentle, slow), (slow, gentle)):
        asked = rehearsals(monkeypatch, fit, {better: {"F_S": 4.0, "sigma_0": 9.0}, worse: {"sigma_1": 2.0}})
        assert next_motion(unknown, Axis(), sliding_log()).purposes == better
        assert {purposes for purposes, *_ in asked} == {gentle, slow}


def test_an_axis_without_limits_gets_those_of_its_log(fit, monkeypatch):
    asked = rehearsals(monkeypatch, fit, {"stribeck": {"F_S": 4.0}})
    motion = next_motion(opened(fit, F_S="unidentifiable"), Axis(acceleration_limit=3.0), sliding_log())
    ((_, axis, travel),) = asked
    fastest = float(np.max(np.abs(fit.traces.velocity)))
    assert axis.velocity_limit == pytest.approx(fastest, rel=0.05)
    assert axis.acceleration_limit == 3.0
    assert motion.limits == (f'velocity = "{axis.velocity_limit:g} m/s"',)
    assert motion.options[-1] == travel


def test_a_motion_that_the_axis_does_not_allow_is_left_out(fit, monkeypatch):
    assert rehearsals(monkeypatch, fit, {}) == []
    assert next_motion(opened(fit, F_S="unidentifiable"), Axis(), sliding_log()) is None


@pytest.mark.slow
def test_slow_motion_is_proposed_where_the_fall_of_friction_is_open():
    motion = sines(10.0, amplitudes=(0.02, 0.0, 0.0))
    level = 20.0 + 10.0 * np.exp(-((motion.velocity / 0.004) ** 2))
    effort = 12.0 * motion.acceleration + np.where(motion.velocity < 0.0, -level, level) + 40.0 * motion.velocity
    log = log_of(motion, effort + np.random.default_rng(0).normal(0.0, 1.0, motion.time.size), step=1e-7)
    axis = Axis(resolution=1e-7, method="inverse_dynamics")
    best = identify(log, "lugre", axis=axis, draws=20).best
    found = next_motion(best, axis, log)
    assert found.purposes == "stribeck"
    assert found.half_widths["F_S"][1] < 10.0
