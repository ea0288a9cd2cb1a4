"""Elements that slip, identified by observers, on the log of an axis simulated here in plain Python."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import virgin_curve
from tests.identification.rigid import identify
from tests.identification.watched import watched

import bristle as br
from bristle.core import Axis
from bristle.identification import intervals, ladder, observed_elements, observed_fit
from bristle.identification.fixed_shape import TOTAL, shaped
from bristle.identification.observed_elements import SpreadSpace, spread_model, spreads
from bristle.identification.parameter_space import ParameterSpace
from bristle.models.friction import gms, maxwell_slip
from bristle.report.messages import message

MASS, DAMPING, LEVELS, SLIPS = (
    12.0,
    50.0,
    np.array([6.0, 8.0, 10.0]),
    np.array([0.8e-6, 3e-6, 10e-6]),
)
TRUTH = {"F_C": np.sum(LEVELS), "nu_i": LEVELS / np.sum(LEVELS), "k_i": LEVELS / SLIPS}
DT, FINER, STEP = 1e-3, 20, 2e-7
AT = (1e-6, 3e-6, 10e-6)


@pytest.fixture(scope="module")
def columns():
    count, h = 4000, DT / FINER
    speed = np.repeat([0.004, 0.03, 0.01, 0.06], count // 4)
    reference = np.cumsum(speed * np.sin(2.0 * np.pi * 2.2 * DT * np.arange(count))) * DT
    stiffness, x, v, before = LEVELS / SLIPS, 0.0, 0.0, 0.0
    deflection, position, effort = np.zeros(3), np.empty(count), np.empty(count)
    for k in range(count):
        position[k] = STEP * math.floor(x / STEP + 0.5)
        u = effort[k] = 12e4 * (reference[k] - position[k]) - 2000.0 * (position[k] - before) / DT
        before = position[k]
        for _ in range(FINER):
            v += h / MASS * (u - float(stiffness @ deflection) - DAMPING * v)
            x += h * v
            deflection = np.clip(deflection + h * v, -SLIPS, SLIPS)
    return {"time": DT * np.arange(count), "position": position, "effort": effort}


@pytest.fixture(scope="module")
def calls(columns):
    """The calls of an identification that end with its result."""
    places = (
        (intervals, "foreseen"),
        (observed_fit, "climb"),
        (observed_fit, "gathered"),
        (ladder, "sandwich"),
        (intervals, "with_loops"),
    )
    with watched(*places) as calls:
        identify(columns, "maxwell_slip", axis=Axis(resolution=STEP), blocks=0, draws=20)
    return calls


@pytest.fixture(scope="module")
def fits(calls):
    """The fit of inverse dynamics, and that of the observer from it."""
    return [calls["foreseen"][0].given[0], calls["with_loops"][0].returned]


def errors_of(fit):
    return virgin_curve(fit.friction.values, AT) / virgin_curve(TRUTH, AT) - 1.0


def test_an_observer_finds_the_virgin_curve_behind_a_coarse_encoder(fits):
    assert np.max(np.abs(errors_of(fits[1]))) < 0.04
    assert errors_of(fits[0]).tolist() != errors_of(fits[1]).tolist()


def test_an_element_without_force_is_in_the_range_of_a_model_file(calls):
    inverse, solution = calls["gathered"][0].given
    names = inverse.parameters.component.names
    silent = names[len(names) // 2]
    theta = np.where([name == silent for name in solution.space.names], 0.0, solution.theta)
    problem, without = observed_elements.gathered(inverse, replace(solution, theta=theta))
    view = problem.parameters.component
    lists = view.lists(without.values)
    assert np.min(lists["k_i"]) == pytest.approx(observed_elements.SOFTEST)
    maxwell_slip(F_C=lists["F_C"], k_i=lists["k_i"], nu_i=lists["nu_i"], sigma_2=1.0)


def test_variances_of_nearly_redundant_parameters_are_not_negative(calls):
    (rung,) = calls["sandwich"][0].given
    jacobian = rung.solution.jacobian.copy()
    jacobian[:, 1] = jacobian[:, 0] * (
        1.0 + 1e-4 * np.random.default_rng(1).standard_normal(len(jacobian))
    )
    matrix = ladder.sandwich(rung._replace(solution=replace(rung.solution, jacobian=jacobian)))
    assert np.all(np.diag(matrix) >= 0.0)
    assert np.min(np.linalg.eigvalsh(matrix)) >= -1e-12 * np.max(np.linalg.eigvalsh(matrix))


def test_intervals_contain_level_and_curve(fits):
    _, fit = fits
    low, high = fit.parameters["F_C"].interval
    assert low < np.sum(LEVELS) < high
    assert high - low < 0.01 * np.sum(LEVELS)
    x, force, low, high = np.array(fit.resampling.curve).T
    assert force == pytest.approx(virgin_curve(fit.friction.values, x), rel=1e-6)
    truth = virgin_curve(TRUTH, x)
    # A corner between two thresholds is cut, by 3 % at most.
    assert np.all((low <= 1.03 * truth) & (0.97 * truth <= high))
    assert np.all((high - low)[x > 5.0 * STEP] < 0.1 * truth[x > 5.0 * STEP])


def test_elements_that_explain_the_force_less_well_than_inverse_dynamics_are_not_reported(
    calls, fits, monkeypatch
):
    plain, observed = fits
    monkeypatch.setattr(observed_fit, "climb", lambda *_: calls["climb"][0].returned)
    monkeypatch.setattr(
        observed_fit, "errors_of_replicates", lambda rung, *_: np.array([rung.error])
    )
    for share, kept in ((1.3, False), (1.4, True)):
        worse = replace(observed, force_error_percent=share * plain.force_error_percent)
        monkeypatch.setattr(observed_fit, "with_observer", lambda *_, worse=worse: worse)
        result = observed_fit.foreseen(*calls["foreseen"][0].given[:4])
        assert result.estimates == (plain if kept else observed).estimates
    told = message(result.diagnostics[-1])
    assert "with its elements, 1.4 times as much of the force is unexplained" in told


def test_draws_of_a_band_contain_the_lists(fits):
    _, fit = fits
    draws = fit.resampling.bands.draws
    assert TOTAL not in draws
    level, shares, stiffness = draws["F_C"], draws["nu_i"], draws["k_i"]
    assert shares.shape == stiffness.shape == (len(level), len(fit.friction.values["k_i"]))
    assert np.sum(shares, axis=1) == pytest.approx(np.ones(len(level)))
    assert fit.further == len(fit.friction.values["k_i"]) - 2


def test_levels_at_thresholds_are_the_lists_of_the_model():
    model = spread_model(maxwell_slip, (1e-6, 4e-6))
    values = {"f_0": 2.0, "f_1": 6.0, "sigma_2": 3.0}
    lists = model.lists(values)
    assert lists["F_C"] == 8.0
    assert lists["k_i"] == pytest.approx([2e6, 1.5e6])
    assert lists["nu_i"] == pytest.approx([0.25, 0.75])
    assert model.values(model.assemble(values)) == pytest.approx(values)
    assert model.equal(values) == {"f_0": 4.0, "f_1": 4.0}
    assert [
        sum(start[name] for name in model.names) for start in model.starts(values)
    ] == pytest.approx([8.0, 8.0, 8.0])


def test_thresholds_include_those_of_elements_and_more_between_and_below():
    slips = np.array([0.1, 1.0, 1.1, 8.0, 50.0])
    thresholds = observed_elements._thresholds(slips, np.array([1.0, 2.0, 2.0, 5.0, 0.01]), 0.2)
    assert thresholds[0] == 0.2
    assert thresholds[-1] == pytest.approx(observed_elements.BEYOND * 8.0)
    assert 8.0 in thresholds
    assert 1.0 in thresholds
    assert 1.1 not in thresholds
    assert (
        np.max(thresholds[1:] / thresholds[:-1])
        <= 10.0 ** (1.0 / observed_elements.PER_DECADE) + 1e-12
    )
    alone = observed_elements._thresholds(np.array([0.1]), np.array([1.0]), 0.2)
    assert alone[0] == 0.05
    assert 0.1 in alone


def test_level_stiffness_and_curve_are_sums_of_levels():
    model, inner = (
        spread_model(maxwell_slip, (1e-6, 4e-6)),
        ParameterSpace(("M", "f_0", "f_1"), np.zeros(3), np.full(3, np.inf)),
    )
    space = SpreadSpace(
        inner.names, inner.low, inner.high, curve=(2e-6,), inner=inner, component=model
    )
    theta = np.array([5.0, 2.0, 6.0])
    assert space.reported == ("F_C", TOTAL, "M")
    assert space.numbers(theta) == pytest.approx([8.0, 3.5e6, 5.0, 5.0])
    assert space.derivative(theta) @ theta == pytest.approx(space.numbers(theta)[:3])
    below = space.member(np.array([5.0, -2.0, 6.0]))
    assert (below["F_C"], below["nu_i"].tolist()) == (pytest.approx(4.0), pytest.approx([0.0, 1.0]))


def test_elements_with_a_curve_or_two_levels_keep_inverse_dynamics():
    one = np.ones(1)
    assert spreads(shaped(maxwell_slip, one, one))
    assert not spreads(shaped(gms, one, one))
    assert not spreads(shaped(br.friction.find("maxwell_slip+asymmetry"), one, one))
    assert not spreads(maxwell_slip)
