"""Intervals include differences from a fit away from reversals, and only those."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, Motion, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle import friction
from bristle.identification import problem as contrast
from bristle.identification.bootstrap import bootstrap
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import linear
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.problem import Away, Contrast, between

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
@pytest.mark.parametrize(("force", "noise", "name", "least"), [(uneven, 0.3, "offset", 5), (turned_late, 0.1, "F_C", 4)])
def test_what_differs_away_from_reversals_has_a_wide_enough_interval(force, noise, name, least):
    estimates = [
        identify(
            log_of(motion, sliding_effort(motion, seed, noise) + force(motion)), "coulomb_viscous", axis=STATED, blocks=0, draws=40
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
    part, residual = contrast_of(problem, replace(problem.away, rows=rows, velocity=np.zeros(rows.size)))
    still = {name for name, change in zip(problem.parameters.free, part.change(residual), strict=True) if change == 0.0}
    assert len(still & {"F_C", "offset"}) == 1
    assert "M" not in still


def test_a_difference_as_in_replicates_does_not_count():
    rng = np.random.default_rng(1)
    usual, errors = rng.normal((20.0, 0.0), 1.0, (200, 2)).T[:, :, None]
    assert np.all(between(np.array([20.0]), usual, errors, rng) == 0.0)


def test_disturbed_rows_near_reversals_spread_draws_over_both_fits():
    rng = np.random.default_rng(2)
    sure, errors = rng.normal((0.0, 0.0), (0.1, 1.0), (400, 2)).T[:, :, None]
    # The fit errs by 1.5 of its standard errors, the other one hardly.
    draws = 1.5 - errors + between(np.array([-1.5]), sure - errors, errors, rng)
    assert np.mean(np.abs(draws) < 0.5) > 0.3
    assert np.ptp(np.percentile(draws, [2.5, 97.5])) < 1.2 * np.ptp(np.percentile(errors, [2.5, 97.5]))
