"""Standard errors of a fit: of white noise, of rows that last, of half-cycles left out; and how draws move."""

from types import SimpleNamespace

import numpy as np
import pytest

from bristle.identification.least_squares import Linearised, Search
from bristle.identification.least_squares import between as part_of
from bristle.identification.problem import Away, Contrast, between, covariance_of

RNG = np.random.default_rng(1)
ROWS = 800


def solution_of(jacobian, at_edge=(), low=-np.inf, high=np.inf, derivative=None, theta=None):
    count = jacobian.shape[1]
    names = tuple("abcdef"[:count])
    space = SimpleNamespace(names=names, reported=names, low=np.full(count, low), high=np.full(count, high))
    theta = np.ones(count) if theta is None else theta
    return SimpleNamespace(
        space=space, theta=theta, jacobian=jacobian, at_edge=dict.fromkeys(at_edge, "smallest"), derivative=derivative or np.eye(count)
    )


def test_errors_of_white_noise_are_those_of_the_normal_equations():
    columns = np.column_stack([np.ones(ROWS), np.linspace(-1.0, 1.0, ROWS), 1e6 * np.sin(np.arange(ROWS))])
    noise = 0.5 * RNG.standard_normal(ROWS)
    residual = noise - columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
    covariance = covariance_of(solution_of(columns), residual)
    expected = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)) * np.sum(residual**2) / (ROWS - 3))
    assert covariance.std == pytest.approx(expected)
    assert covariance.robust_std == pytest.approx(expected, rel=0.4)
    assert np.diag(covariance.correlation) == pytest.approx(1.0)
    assert covariance.condition_number < 1.2  # columns of one length


def test_nearly_equal_columns_are_correlated_and_equal_columns_have_no_error():
    first = RNG.standard_normal(ROWS)
    near = covariance_of(solution_of(np.column_stack([first, first + 0.1 * RNG.standard_normal(ROWS)])), np.ones(ROWS))
    assert near.correlation[0, 1] < -0.99
    assert near.condition_number > 10.0
    same = covariance_of(solution_of(np.column_stack([first, 2.0 * first, RNG.standard_normal(ROWS)])), RNG.standard_normal(ROWS))
    assert np.isinf(same.std[:2]).all()
    assert np.isfinite(same.std[2])
    unseen = covariance_of(solution_of(np.column_stack([first, 0.0 * first])), RNG.standard_normal(ROWS))
    assert np.isfinite(unseen.std[0])
    assert np.isinf(unseen.std[1])


def test_a_parameter_on_an_edge_has_no_error_and_does_not_affect_others():
    columns = np.column_stack([np.ones(ROWS), np.linspace(0.0, 1.0, ROWS)])
    residual = RNG.standard_normal(ROWS)
    on_edge = covariance_of(solution_of(columns, at_edge=("b",)), residual)
    assert np.isnan(on_edge.std[1])
    assert on_edge.std[0] == pytest.approx(np.sqrt(np.sum(residual**2) / (ROWS - 2) / ROWS))


def test_correlated_residuals_widen_only_the_robust_error():
    lasting = np.repeat(RNG.standard_normal(40), 20)
    covariance = covariance_of(solution_of(np.ones((ROWS, 1))), lasting)
    assert covariance.robust_std[0] / covariance.std[0] == pytest.approx(20.0**0.5, rel=0.15)


def test_an_error_of_all_rows_at_once_adds_to_the_robust_error():
    columns, residual = np.ones((ROWS, 1)), 0.1 * RNG.standard_normal(ROWS)
    covariance = covariance_of(solution_of(columns), residual, [np.full(ROWS, 0.3)])
    assert covariance.robust_std[0] == pytest.approx(0.3, rel=0.01)
    assert covariance.std[0] == pytest.approx(0.1 / ROWS**0.5, rel=0.1)


def test_draws_cover_the_whole_difference_if_the_other_fit_is_more_certain():
    rng = np.random.default_rng(4)
    errors = rng.standard_normal((400, 2))
    usual = np.column_stack([-0.5 * errors[:, 0], 0.5 * rng.standard_normal(400)])
    change = np.array([10.0, 10.0])
    moves = between(change, usual, errors, np.random.default_rng(5))
    share = moves[:, 1] / (change[1] - np.mean(usual[:, 1]))
    beyond = np.sqrt(1.0 - 4.0 * np.var(usual[:, 1]) / (change[1] - np.mean(usual[:, 1])) ** 2)
    shares = share / beyond
    assert shares.min() >= -0.2
    assert shares.max() <= 1.2
    assert shares[::2] + shares[1::2] == pytest.approx(1.0)  # pairs share an edge
    assert moves[:, 0] == pytest.approx(shares * (change[0] - usual[:, 0]))


def test_an_insignificant_change_moves_no_draw():
    usual = np.random.default_rng(6).standard_normal((400, 1))
    errors = 0.1 * np.random.default_rng(7).standard_normal((400, 1))
    assert between(np.array([1.5]), usual, errors, np.random.default_rng(8)) == pytest.approx(0.0)


def away_of(count=ROWS):
    rows = np.arange(count) % 4 != 0
    velocity = np.where(np.arange(count) % 100 < 50, 0.1, -0.2)
    return Away(rows, rows, np.linspace(0.0, 1.0, count), velocity, 30.0)


def test_a_fit_away_from_reversals_differs_by_the_result_of_these_rows():
    away = away_of()
    columns = np.column_stack([np.ones(ROWS), np.sign(away.velocity), RNG.standard_normal(ROWS)])
    contrast = Contrast.of(solution_of(columns), away)
    assert contrast.determined.all()
    disturbed = np.where(away.rows, columns @ np.array([0.5, -2.0, 3.0]), 99.0)
    change = contrast.change(disturbed)
    assert change[2] == pytest.approx(3.0)
    nowhere = Contrast.of(solution_of(columns), Away.nowhere(ROWS))
    assert not nowhere.determined.any()
    assert nowhere.change(disturbed).tolist() == [0.0, 0.0, 0.0]
    few = away_of()
    few.rows[49:] = False
    assert not Contrast.of(solution_of(columns), few).determined.any()


def test_waves_added_to_friction_explain_a_twentieth_of_the_residual():
    away = away_of(4000)
    wave = np.sin(2.0 * np.pi * 9.3 * away.position)
    noise = np.random.default_rng(9).standard_normal(4000)
    speed = np.abs(away.velocity)
    assert away.beside().shape == (4000, 1)
    assert away.beside()[:, 0] == pytest.approx(speed)
    shown = away.beside(0.6 * wave + noise)
    assert shown.shape == (4000, 3)
    basis = np.linalg.qr(shown[:, 1:])[0]
    assert np.linalg.norm(basis.T @ wave) == pytest.approx(np.linalg.norm(wave), rel=0.02)
    assert away.beside(0.1 * wave + noise).shape == (4000, 1)


def test_a_derivative_is_never_taken_beyond_a_bound():
    requested = []

    def residual(place):
        requested.append(place.copy())
        return np.array([place[0] ** 2, 3.0 * place[1], place[0] * place[1]])

    def linearised(high, *, simulates):
        problem = SimpleNamespace(residual=residual, linearised=lambda place: (residual(place), None))
        search = Search(problem, None, None, 1.0, simulates=simulates)
        object.__setattr__(search, "space", SimpleNamespace(values=lambda theta: theta, high=np.array(high)))
        return Linearised(search, slice(None))

    near = linearised([2.0, 5.0], simulates=False)
    np.testing.assert_allclose(near.jacobian(np.array([2.0, 4.0])), [[4.0, 0.0], [0.0, 3.0], [4.0, 2.0]], atol=1e-4)
    assert all(np.all(place <= [2.0, 5.0]) for place in requested)
    count = len(requested)
    assert near.at(np.array([2.0, 4.0]))[1].tolist() == [4.0, 12.0, 8.0]
    assert len(requested) == count  # remembered
    linearised([1e9, 1e9], simulates=True).jacobian(np.array([1000.0, 0.5]))
    assert max(place[0] for place in requested) - 1000.0 == pytest.approx(1e-2)  # of a coordinate
    assert max(place[1] for place in requested if place[0] > 900.0) - 0.5 == pytest.approx(1e-5)  # of 1


def test_a_part_of_the_work_reports_its_share_of_the_total():
    listed = []
    part_of(lambda share, remark="": listed.append((share, remark)), 0.2, 0.6)(0.5, "half")
    assert listed == [(pytest.approx(0.4), "half")]


@pytest.mark.parametrize(("count", "forces"), [(49, 1), (50, 3)])
def test_waves_are_sought_in_at_least_fifty_rows(count, forces):
    away = Away(np.ones(count, dtype=bool), np.ones(count, dtype=bool), np.linspace(0.0, 1.0, count), np.full(count, 0.1), 12.0)
    assert away.beside(np.sin(2.0 * np.pi * 5.3 * away.position)).shape == (count, forces)
