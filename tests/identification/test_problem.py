"""Standard errors of a fit and their differences away from reversals; how draws move."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, Motion, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle import friction
from bristle.identification import problem as contrast
from bristle.identification.bootstrap import bootstrap
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Linearised, Search, between as part_of, linear
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.problem import Away, Contrast, between, covariance_of

RNG = np.random.default_rng(1)
ROWS = 800


def solution_of(jacobian, at_edge=(), low=-np.inf, high=np.inf, derivative=None, theta=None):
    count = jacobian.shape[1]
    names = tuple("abcdef"[:count])
    space = SimpleNamespace(
        names=names, reported=names, low=np.full(count, low), high=np.full(count, high)
    )
    theta = np.ones(count) if theta is None else theta
    return SimpleNamespace(
        space=space,
        theta=theta,
        jacobian=jacobian,
        at_edge=dict.fromkeys(at_edge, "smallest"),
        derivative=derivative or np.eye(count),
    )


def test_errors_of_white_noise_are_those_of_the_normal_equations():
    columns = np.column_stack(
        [np.ones(ROWS), np.linspace(-1.0, 1.0, ROWS), 1e6 * np.sin(np.arange(ROWS))]
    )
    noise = 0.5 * RNG.standard_normal(ROWS)
    residual = noise - columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
    covariance = covariance_of(solution_of(columns), residual)
    expected = np.sqrt(
        np.diag(np.linalg.inv(columns.T @ columns)) * np.sum(residual**2) / (ROWS - 3)
    )
    assert covariance.std == pytest.approx(expected)
    assert covariance.robust_std == pytest.approx(expected, rel=0.4)
    assert np.diag(covariance.correlation) == pytest.approx(1.0)
    assert covariance.condition_number < 1.2  # columns of one length


def test_nearly_equal_columns_are_correlated_and_equal_columns_have_no_error():
    first = RNG.standard_normal(ROWS)
    near = covariance_of(
        solution_of(np.column_stack([first, first + 0.1 * RNG.standard_normal(ROWS)])),
        np.ones(ROWS),
    )
    assert near.correlation[0, 1] < -0.99
    assert near.condition_number > 10.0
    same = covariance_of(
        solution_of(np.column_stack([first, 2.0 * first, RNG.standard_normal(ROWS)])),
        RNG.standard_normal(ROWS),
    )
    assert np.isinf(same.std[:2]).all()
    assert np.isfinite(same.std[2])
    unseen = covariance_of(
        solution_of(np.column_stack([first, 0.0 * first])), RNG.standard_normal(ROWS)
    )
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
    usual = 20.0 + np.random.default_rng(6).standard_normal((400, 1))
    errors = 0.1 * np.random.default_rng(7).standard_normal((400, 1))
    assert between(np.array([21.5]), usual, errors, np.random.default_rng(8)) == pytest.approx(0.0)


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
        problem = SimpleNamespace(
            residual=residual, linearised=lambda place: (residual(place), None)
        )
        search = Search(problem, None, None, 1.0, simulates=simulates)
        object.__setattr__(
            search, "space", SimpleNamespace(values=lambda theta: theta, high=np.array(high))
        )
        return Linearised(search, slice(None))

    near = linearised([2.0, 5.0], simulates=False)
    np.testing.assert_allclose(
        near.jacobian(np.array([2.0, 4.0])), [[4.0, 0.0], [0.0, 3.0], [4.0, 2.0]], atol=1e-4
    )
    assert all(np.all(place <= [2.0, 5.0]) for place in requested)
    count = len(requested)
    assert near.at(np.array([2.0, 4.0]))[1].tolist() == [4.0, 12.0, 8.0]
    assert len(requested) == count  # remembered
    linearised([1e9, 1e9], simulates=True).jacobian(np.array([1000.0, 0.5]))
    assert max(place[0] for place in requested) - 1000.0 == pytest.approx(1e-2)  # of a coordinate
    # Of 1
    assert max(place[1] for place in requested if place[0] > 900.0) - 0.5 == pytest.approx(1e-5)


def test_a_part_of_the_work_reports_its_share_of_the_total():
    listed = []
    part_of(lambda share, remark="": listed.append((share, remark)), 0.2, 0.6)(0.5, "half")
    assert listed == [(pytest.approx(0.4), "half")]


@pytest.mark.parametrize(("count", "forces"), [(49, 1), (50, 3)])
def test_waves_are_sought_in_at_least_fifty_rows(count, forces):
    away = Away(
        np.ones(count, dtype=bool),
        np.ones(count, dtype=bool),
        np.linspace(0.0, 1.0, count),
        np.full(count, 0.1),
        12.0,
    )
    assert away.beside(np.sin(2.0 * np.pi * 5.3 * away.position)).shape == (count, forces)


DT = 1e-3


def motion_of(seed: int, seconds: float = 5.0) -> Motion:
    return sines(seconds, phases=tuple(np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)))


def uneven(motion: Motion) -> np.ndarray:
    """Damping that is larger in one direction."""
    return 3.0 * np.abs(motion.velocity)


def turned_late(motion: Motion) -> np.ndarray:
    """Friction that turns 5 ms after the motion."""
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    return TRUTH["F_C"] * (np.roll(side, 5) - side)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "noise", "name", "least"), [(uneven, 0.3, "offset", 5), (turned_late, 0.1, "F_C", 4)]
)
def test_what_differs_away_from_reversals_has_a_wide_enough_interval(force, noise, name, least):
    estimates = [
        identify(
            log_of(motion, sliding_effort(motion, seed, noise) + force(motion)),
            "coulomb_viscous",
            axis=STATED,
            blocks=0,
            draws=40,
        ).best.parameters[name]
        for seed, motion in enumerate(map(motion_of, range(6)))
    ]
    # By least squares alone none of them does, always to one side.
    assert sum(item.interval[0] <= TRUTH[name] <= item.interval[1] for item in estimates) >= least
    assert len({np.sign(item.value - TRUTH[name]) for item in estimates}) == 1


@cache
def problem_of(model: str) -> InverseDynamics:
    """Rows of an axis whose damping is larger in one direction."""
    motion = motion_of(0, 2.5)
    rows = treat(log_of(motion, sliding_effort(motion) + uneven(motion)), STATED)
    return InverseDynamics(rows, parameters_of(friction.find(model), PriorKnowledge(), rows))


@pytest.mark.slow
def test_a_difference_away_from_reversals_widens_the_interval_of_its_parameter_alone(monkeypatch):
    problem = problem_of("coulomb_viscous")
    wide = bootstrap(problem, linear(problem), 6, linear=True)
    monkeypatch.setattr(contrast, "BETWEEN", (0.0, 0.0))
    narrow = bootstrap(problem, linear(problem), 6, linear=True)
    assert np.ptp(wide.interval("offset")) > 2.0 * np.ptp(narrow.interval("offset"))
    assert wide.interval("F_C") == narrow.interval("F_C")


def contrast_of(problem: InverseDynamics, away: Away | None = None) -> tuple[Contrast, np.ndarray]:
    solution = linear(problem)
    return Contrast.of(solution, away or problem.away), problem.residual(solution.values)


def test_rows_near_reversals_and_rests_do_not_count():
    problem = problem_of("coulomb_viscous")
    dataset, away = problem.dataset, problem.away.rows
    assert 0.3 < np.mean(away) < 0.95
    assert np.min(dataset.samples_from_reversal[away]) > 2.0 / (dataset.cutoff * DT)
    part, residual = contrast_of(problem)
    changed = residual + np.where(away, 0.0, 1e3)
    np.testing.assert_array_equal(part.change(changed), part.change(residual))


def test_a_model_that_has_a_damping_by_direction_does_not_share_it_with_another():
    problem = problem_of("coulomb_viscous+asymmetry")
    part, residual = contrast_of(problem)
    alone, _ = contrast_of(problem, replace(problem.away, velocity=0.0 * residual))
    np.testing.assert_array_equal(part.change(residual), alone.change(residual))


def test_parameters_invisible_away_from_reversals_are_kept():
    problem = problem_of("coulomb_viscous")
    # All that is left is one direction, in which a constant force and Coulomb's are one.
    rows = problem.away.rows & (problem.dataset.velocity > 0.0)
    part, residual = contrast_of(
        problem, replace(problem.away, rows=rows, velocity=np.zeros(rows.size))
    )
    still = {
        name
        for name, change in zip(problem.parameters.free, part.change(residual), strict=True)
        if change == 0.0
    }
    assert len(still & {"F_C", "offset"}) == 1
    assert "M" not in still


def test_disturbed_rows_near_reversals_spread_draws_over_both_fits():
    rng = np.random.default_rng(2)
    sure, errors = rng.normal((0.0, 0.0), (0.1, 1.0), (400, 2)).T[:, :, None]
    # The fit errs by 1.5 of its standard errors, the other one hardly.
    draws = 1.5 - errors + between(np.array([-1.5]), sure - errors, errors, rng)
    assert np.mean(np.abs(draws) < 0.5) > 0.3
    assert np.ptp(np.percentile(draws, [2.5, 97.5])) < 1.2 * np.ptp(
        np.percentile(errors, [2.5, 97.5])
    )
