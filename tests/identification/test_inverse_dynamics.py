"""Rows of plant and friction: responses, undisturbed rows, and errors of delay, filter, hold and mass in a fit."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort

from bristle import friction
from bristle.core import InputError
from bristle.core.normal import NORMAL_95
from bristle.identification.dataset import Alignment
from bristle.identification.estimation import sliding_problem
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.parameters import Fixed, PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.settings import DEFAULT
from bristle.models.friction import find
from bristle.models.plants import inertia

DT = 1e-3
MOTION = sines(6.0)
LOG = log_of(MOTION, sliding_effort(MOTION, noise=0.0))
PRIOR = PriorKnowledge(plant=inertia)


@pytest.fixture(scope="module")
def problem():
    return sliding_problem(treat(LOG, STATED, 100.0, 10), PRIOR)


def with_alignment(problem, held=None, **known):
    """The same problem with this known of its channels."""
    return replace(
        problem, dataset=replace(problem.dataset, held=held, alignment=Alignment(**known))
    )


def test_responses_of_rows_to_their_parameters_sum_to_the_prediction(problem):
    assert set(problem.parameters.free) == set(TRUTH)
    together = problem.columns @ np.array([TRUTH[name] for name in problem.parameters.free])
    assert together + problem.fixed_effort == pytest.approx(problem.predicted(TRUTH), abs=1e-9)
    assert np.all(problem.fixed_effort == 0.0)
    assert problem.mechanical(TRUTH) + problem.friction(TRUTH) == pytest.approx(
        problem.predicted(TRUTH), abs=1e-9
    )
    assert np.std(problem.residual(TRUTH)) < 0.1 * np.std(problem.measured)


def without_mass(problem, fixed):
    """The same problem with a fixed mass."""
    free = tuple(name for name in problem.parameters.free if name != "M")
    return replace(problem, parameters=replace(problem.parameters, free=free, fixed={"M": fixed}))


def test_a_fixed_parameter_contributes_its_effort(problem):
    held = without_mass(problem, Fixed(3.0, "given"))
    assert held.fixed_effort == pytest.approx(3.0 * problem.dataset.acceleration)
    assert held.columns.shape == (problem.measured.size, 3)
    assert held.unit("F_C")["M"] == 0.0
    assert replace(held, parameters=replace(held.parameters, free=())).columns.shape == (
        problem.measured.size,
        0,
    )


@pytest.mark.parametrize(
    ("name", "turned"),
    [
        ("coulomb_viscous", {"F_C": 8.0, "F_v": 30.0}),
        ("gap_slider", {"F_C": 8.0, "give": 0.02, "gap": 1e-3, "n": 2.0, "share": 0.1}),
    ],
)
def test_an_initially_turned_contact_affects_friction_and_prediction_equally(problem, name, turned):
    rows = InverseDynamics(problem.dataset, parameters_of(find(name), PRIOR, problem.dataset))
    values = dict.fromkeys(rows.parameters.variables, 0.0) | {"M": 12.0} | turned
    assert rows.mechanical(values) + rows.friction(values) == pytest.approx(
        rows.predicted(values), abs=1e-9
    )


@pytest.mark.parametrize(
    ("held", "known", "std"),
    [
        (None, {}, 0.5 * DT / 3.0**0.5),  # of a hold, whose half sample is not known
        (True, {}, 0.0),
        (False, {}, 0.0),
        (None, {"sought": False}, 0.0),
        (None, {"delay": 2e-3, "delay_half_width": 1.96e-4}, 1e-4),
        (True, {"delay": 2e-3, "delay_half_width": 1.96e-4}, 1e-4),
        (None, {"delay": 2e-3}, 0.0),
    ],
)
def test_a_delay_has_its_uncertainty_or_that_of_a_hold(problem, held, known, std):
    assert with_alignment(problem, held, **known).delay_std == pytest.approx(
        std, rel=0.2 if std > 1.1e-4 else 1e-4
    )


@pytest.mark.parametrize(
    ("known", "std"),
    [
        ({"smoothing": -3e-3, "smoothing_half_width": 1.96e-3}, 3e-6),
        ({"smoothing": 3e-3}, 0.0),
        ({"smoothing_half_width": 1.0}, 0.0),
    ],
)
def test_a_removed_filter_has_the_error_of_its_half_square(problem, known, std):
    assert with_alignment(problem, **known).bend_std == pytest.approx(std, rel=1e-4)


def test_known_mass_delay_and_filter_contribute_their_standard_errors(problem):
    aligned = with_alignment(
        problem, delay=0.0, delay_half_width=1.96e-4, smoothing=2e-3, smoothing_half_width=1.96e-3
    )
    mass, delay, bend = without_mass(aligned, Fixed(12.0, "given", half_width=0.98)).found_first()
    rate = np.gradient(problem.dataset.segments[0].effort, DT)
    rates, bends = (problem.dataset.rows_of([signal]) for signal in (rate, np.gradient(rate, DT)))
    assert mass == pytest.approx(0.5 * problem.dataset.acceleration, rel=1e-4)
    assert np.corrcoef(delay, rates)[0, 1] > 0.99
    assert np.std(delay) == pytest.approx(1e-4 * np.std(rates), rel=0.05)
    assert np.std(bend) == pytest.approx(2e-6 * np.std(bends), rel=0.15)
    assert problem.found_first() == []


@pytest.mark.parametrize(("cutoff", "least"), [(100.0, 0.02), (200.0, 0.015)])
def test_rows_away_are_two_periods_from_a_reversal_and_steady_ones_six_times_as_far(cutoff, least):
    rows = sliding_problem(treat(LOG, STATED, cutoff, 1), PRIOR)
    time = rows.dataset.samples_from_rest * DT
    assert np.array_equal(rows.away.rows, time > least * (1.0 + 1e-9))
    assert np.array_equal(rows.away.far, time > 6.0 * least * (1.0 + 1e-9))
    assert rows.away.rows.sum() > rows.away.far.sum() > 0


def test_time_blocks_are_held_out(problem):
    _, folds = problem.folds(3, DEFAULT)
    assert np.sum([fold.held_out for fold in folds], axis=0).tolist() == [1] * problem.measured.size
    assert not any(np.any(fold.fitted & fold.held_out) for fold in folds)
    with pytest.raises(InputError, match="are too many for this log"):
        problem.folds(400, DEFAULT)


def test_the_time_between_rows_includes_decimated_samples_and_rows_as_recorded_are_sure(problem):
    assert problem.row_time == pytest.approx(10.0 * DT)
    assert (problem.delay_std, problem.bend_std) == (0.0, 0.0)  # of rows without an alignment


AMPLITUDES, FREQUENCIES = np.array([1.0, 0.4, 0.1]), np.array([0.5, 3.0, 8.0])


def effort_behind(channel):
    """A smooth effort behind a channel, which has a gain for each angular frequency."""
    time, w = DT * np.arange(6000), 2.0 * np.pi * FREQUENCIES
    return np.sum(AMPLITUDES * np.imag(channel(w) * np.exp(1j * np.outer(time, w))), axis=1)


def problem_of(alignment, held=None, motion=None, effort=None, step=0.0):
    motion = sines(6.0, DT) if motion is None else motion
    effort = effort_behind(np.ones_like) if effort is None else effort
    rows = replace(treat(log_of(motion, effort, step=step), STATED), alignment=alignment, held=held)
    return InverseDynamics(
        rows, parameters_of(friction.find("coulomb_viscous"), PriorKnowledge(), rows)
    )


def rows_of(problem, effort):
    return np.interp(problem.dataset.time, DT * np.arange(effort.size), effort)


def test_an_unknown_hold_has_an_interval_of_half_a_sample_to_either_side():
    problem = problem_of(Alignment())
    (change,) = problem.found_first()
    half = effort_behind(lambda w: np.exp(0.5j * w * DT)) - effort_behind(np.ones_like)
    np.testing.assert_allclose(NORMAL_95 * change, rows_of(problem, half), atol=0.03 * np.ptp(half))


def test_a_removed_filter_has_its_standard_error_at_the_same_delay():
    constant, std = 4e-3, 0.3e-3

    def lag(w, seconds):
        # Its delay was found beside it.
        return np.exp(1j * w * seconds) / (1.0 + 1j * w * seconds)

    known = Alignment(
        delay=0.0, delay_half_width=0.0, smoothing=constant, smoothing_half_width=std * NORMAL_95
    )
    problem = problem_of(known)
    (change,) = problem.found_first()
    more = effort_behind(lambda w: lag(w, constant + std)) - effort_behind(
        lambda w: lag(w, constant)
    )
    away = slice(100, -100)
    np.testing.assert_allclose(
        np.abs(change[away]), np.abs(rows_of(problem, more)[away]), atol=0.12 * np.ptp(more)
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_replicates_have_the_errors_of_delay_and_filter_of_the_log(side):
    def spread(alignment):
        problem = problem_of(alignment, effort=sliding_effort(sines(6.0, DT)))
        replicates = RowReplicates(problem, TRUTH)
        drawn = [replicates._wrong(np.random.default_rng(seed), side)[:2] for seed in range(400)]
        return np.std(drawn, axis=0)

    sure = Alignment(delay=0.0, delay_half_width=1e-3, smoothing=2e-3, smoothing_half_width=5e-4)
    late, bent = spread(sure)
    assert late == pytest.approx(1e-3 / NORMAL_95, rel=0.1)
    assert bent == pytest.approx(2e-3 * 5e-4 / NORMAL_95, rel=0.1)


def test_replicates_have_the_error_of_a_measured_inertia():
    problem = problem_of(
        Alignment(delay=0.0, delay_half_width=0.0), effort=sliding_effort(sines(6.0, DT))
    )
    known = {"M": Fixed(12.0, "found first", half_width=0.4)}
    fixed = replace(problem.parameters, fixed={**problem.parameters.fixed, **known})
    problem = replace(problem, parameters=fixed)
    replicates = RowReplicates(problem, TRUTH)
    drawn = [
        replicates._wrong(np.random.default_rng(seed), 1.0)[2].parameters.M for seed in range(400)
    ]
    assert np.mean(drawn) == pytest.approx(12.0, abs=0.05)
    assert np.std(drawn) == pytest.approx(0.4 / NORMAL_95, rel=0.1)


def test_the_offset_of_fits_to_replicates_is_doubted_more_with_invisible_reversals():
    motion = sines(6.0, DT)

    def doubt(step):
        problem = problem_of(Alignment(), motion=motion, effort=sliding_effort(motion), step=step)
        return RowReplicates(problem, TRUTH).doubt

    # Beyond the filter an encoder of half a millimetre shows nothing, and a smooth motion has nothing to be seen.
    assert 1.0 < doubt(5e-4) < 1.3
    corner = replace_by_corners(motion)
    problem = problem_of(Alignment(), motion=corner, effort=sliding_effort(motion), step=1e-9)
    assert 0.6 < RowReplicates(problem, TRUTH).doubt < 1.0


def replace_by_corners(motion):
    """A motion that turns at once: a triangle."""
    period = 0.5
    phase = np.mod(motion.time, period) / period
    q = 0.01 * np.abs(2.0 * phase - 1.0)
    v = np.gradient(q, DT)
    return motion._replace(position=q, velocity=v, acceleration=np.gradient(v, DT))
