"""Uncertainty of delay, filter and hold of a log is included in a fit."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort

from bristle import friction
from bristle.core.normal import NORMAL_95
from bristle.identification.dataset import Alignment
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.parameters import Fixed, PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat

DT = 1e-3
AMPLITUDES, FREQUENCIES = np.array([1.0, 0.4, 0.1]), np.array([0.5, 3.0, 8.0])


def effort_behind(channel):
    """A smooth effort behind a channel, which has a gain for each angular frequency."""
    time, w = DT * np.arange(6000), 2.0 * np.pi * FREQUENCIES
    return np.sum(AMPLITUDES * np.imag(channel(w) * np.exp(1j * np.outer(time, w))), axis=1)


def problem_of(alignment, held=None, motion=None, effort=None, step=0.0):
    motion = sines(6.0, DT) if motion is None else motion
    effort = effort_behind(np.ones_like) if effort is None else effort
    rows = replace(treat(log_of(motion, effort, step=step), STATED), alignment=alignment, held=held)
    return InverseDynamics(rows, parameters_of(friction.find("coulomb_viscous"), PriorKnowledge(), rows))


def rows_of(problem, effort):
    return np.interp(problem.dataset.time, DT * np.arange(effort.size), effort)


def test_a_delay_has_its_standard_error():
    std = 0.7e-3
    problem = problem_of(Alignment(delay=5e-3, delay_half_width=std * NORMAL_95))
    (change,) = problem.found_first()
    early = effort_behind(lambda w: np.exp(1j * w * std)) - effort_behind(np.ones_like)
    np.testing.assert_allclose(change, rows_of(problem, early), atol=0.03 * np.ptp(early))


def test_an_unknown_hold_has_an_interval_of_half_a_sample_to_either_side():
    problem = problem_of(Alignment())
    (change,) = problem.found_first()
    half = effort_behind(lambda w: np.exp(0.5j * w * DT)) - effort_behind(np.ones_like)
    np.testing.assert_allclose(NORMAL_95 * change, rows_of(problem, half), atol=0.03 * np.ptp(half))
    assert problem_of(Alignment(), held=True).found_first() == []
    assert problem_of(Alignment(), held=False).found_first() == []
    assert problem_of(Alignment(sought=False)).found_first() == []


def test_a_removed_filter_has_its_standard_error_at_the_same_delay():
    constant, std = 4e-3, 0.3e-3

    def lag(w, seconds):
        # Its delay was found beside it.
        return np.exp(1j * w * seconds) / (1.0 + 1j * w * seconds)

    known = Alignment(delay=0.0, delay_half_width=0.0, smoothing=constant, smoothing_half_width=std * NORMAL_95)
    problem = problem_of(known)
    (change,) = problem.found_first()
    more = effort_behind(lambda w: lag(w, constant + std)) - effort_behind(lambda w: lag(w, constant))
    away = slice(100, -100)
    np.testing.assert_allclose(np.abs(change[away]), np.abs(rows_of(problem, more)[away]), atol=0.12 * np.ptp(more))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_replicates_have_the_errors_of_delay_and_filter_of_the_log(side):
    def spread(alignment):
        problem = problem_of(alignment, effort=sliding_effort(sines(6.0, DT)))
        values = problem.parameters.complete({"M": 12.0, "F_C": 8.0, "F_v": 30.0, "offset": 1.5})
        replicates = RowReplicates(problem, values)
        drawn = [replicates._wrong(np.random.default_rng(seed), side)[:2] for seed in range(400)]
        return np.std(drawn, axis=0)

    sure = Alignment(delay=0.0, delay_half_width=1e-3, smoothing=2e-3, smoothing_half_width=5e-4)
    late, bent = spread(sure)
    assert late == pytest.approx(1e-3 / NORMAL_95, rel=0.1)
    assert bent == pytest.approx(2e-3 * 5e-4 / NORMAL_95, rel=0.1)


def test_replicates_have_the_error_of_a_measured_inertia():
    problem = problem_of(Alignment(delay=0.0, delay_half_width=0.0), effort=sliding_effort(sines(6.0, DT)))
    known = {"M": Fixed(12.0, "found first", half_width=0.4)}
    fixed = replace(problem.parameters, fixed={**problem.parameters.fixed, **known})
    problem = replace(problem, parameters=fixed)
    replicates = RowReplicates(problem, {"M": 12.0, "F_C": 8.0, "F_v": 30.0, "offset": 1.5})
    drawn = [replicates._wrong(np.random.default_rng(seed), 1.0)[2].parameters.M for seed in range(400)]
    assert np.mean(drawn) == pytest.approx(12.0, abs=0.05)
    assert np.std(drawn) == pytest.approx(0.4 / NORMAL_95, rel=0.1)


def test_the_offset_of_fits_to_replicates_is_doubted_more_with_invisible_reversals():
    motion = sines(6.0, DT)

    def doubt(step):
        problem = problem_of(Alignment(), motion=motion, effort=sliding_effort(motion), step=step)
        values = problem.parameters.complete({"M": 12.0, "F_C": 8.0, "F_v": 30.0, "offset": 1.5})
        return RowReplicates(problem, values).doubt

    # Beyond the filter an encoder of half a millimetre shows nothing, and a smooth motion has nothing to be seen.
    assert 1.0 < doubt(5e-4) < 1.3
    corner = replace_by_corners(motion)
    problem = problem_of(Alignment(), motion=corner, effort=sliding_effort(motion), step=1e-9)
    values = problem.parameters.complete({"M": 12.0, "F_C": 8.0, "F_v": 30.0, "offset": 1.5})
    assert 0.6 < RowReplicates(problem, values).doubt < 1.0


def replace_by_corners(motion):
    """A motion that turns at once: a triangle."""
    period = 0.5
    phase = np.mod(motion.time, period) / period
    q = 0.01 * np.abs(2.0 * phase - 1.0)
    v = np.gradient(q, DT)
    return motion._replace(position=q, velocity=v, acceleration=np.gradient(v, DT))
