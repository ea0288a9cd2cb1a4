"""Coverage of intervals from replicates, in comparison with plain intervals."""

import benchmarks.bootstrap
import numpy as np
import pytest
from benchmarks.coverage import AXIS, FITTED, MAXWELL, UNSEEN, motion, recorded
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle import friction
from bristle.core import Axis, InputError
from bristle.identification.bootstrap import bootstrap, turned
from bristle.identification.half_cycles import Disturbance
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.least_squares import linear
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.prediction import predict

PAIRS = 15


def problem_of(moved, effort, cutoff=50.0, **segments):
    dataset = treat(log_of(moved, effort, **segments), Axis(), cutoff, 5)
    return InverseDynamics(dataset, parameters_of(friction.find("coulomb_viscous"), PriorKnowledge(), dataset))


def test_a_replicate_and_its_mirror_image_lie_on_both_sides_of_the_model():
    twin = RowReplicates(problem_of(sines(), sliding_effort(sines())), TRUTH)
    disturbance = Disturbance(0.065, 0.3, 0.0, 1e-7, 0.5)
    item, other, still = (twin.log(disturbance, np.random.default_rng(5), side) for side in (1.0, -1.0, 0.0))
    for signal in ("effort", "position"):
        middle = 0.5 * (getattr(item, signal).values + getattr(other, signal).values)
        np.testing.assert_allclose(middle, getattr(still, signal).values, atol=1e-9)
        assert np.std(getattr(item, signal).values - middle) > 0.0


def test_a_replicate_has_the_segments_of_its_log():
    parts = (slice(0, 4000), slice(4000, 7000), slice(7000, 10_000))
    problem = problem_of(sines(), sliding_effort(sines()), segments=parts)
    twin = RowReplicates(problem, TRUTH).log(Disturbance(0.0, 0.0, 0.0), np.random.default_rng(5))
    assert twin.segments == parts
    for part in parts:
        np.testing.assert_allclose(twin.position.values[part], sines().position[part], atol=1e-4)
        np.testing.assert_array_equal(twin.time.values[part], sines().time[part])


@pytest.mark.parametrize("scatter", [0.0, 0.1])
def test_scatter_of_a_level_is_recovered(scatter):
    moved = sines(6.0, frequencies=(1.1, 2.9, 5.3))
    levels = 1.0 + scatter * np.random.default_rng(2).standard_normal(200)
    half_cycle = np.cumsum(np.diff(np.sign(moved.velocity), prepend=0.0) != 0.0)
    noise = 0.1 * np.random.default_rng(3).standard_normal(moved.time.size)
    effort = 12.0 * moved.acceleration + 8.0 * levels[half_cycle] * np.sign(moved.velocity) + 30.0 * moved.velocity + noise
    problem = problem_of(moved, effort, 100.0)
    result = bootstrap(problem, linear(problem), 6, linear=True).scatter
    true = float(np.std(levels[1 : half_cycle[-1]]))
    assert result.value == pytest.approx(true, rel=0.25, abs=0.01)
    assert result.low <= result.value <= result.high
    if scatter:
        assert result.low < true < result.high


@pytest.mark.slow
def test_bands_contain_measurements_of_a_different_true_model():
    log, unseen = recorded(MAXWELL, motion(*FITTED, pairs=PAIRS), seed=1), recorded(MAXWELL, motion(*UNSEEN, pairs=9), seed=2)
    fit = identify(log, "dahl", axis=AXIS, blocks=0, draws=40).best
    assert 85.0 < predict(fit.plant, fit.friction, unseen, AXIS, bands=fit.resampling.bands).inside_percent < 99.5


@pytest.mark.slow
def test_elements_that_slip_have_intervals_on_their_level_stiffness_and_virgin_curve():
    fit = identify(recorded(MAXWELL, motion(*FITTED, pairs=PAIRS), seed=3), "maxwell_slip", axis=AXIS, blocks=0, draws=40).best
    low, high = fit.parameters["F_C"].interval
    assert low < MAXWELL.values["F_C"] < high
    x, force, low, high = np.array(fit.resampling.curve).T
    assert np.all(np.diff(x) > 0.0)
    assert np.all((low <= high) & (low < force + 1e-9) & (force < high + 1e-9))
    # Up to the last threshold a virgin curve rises.
    assert np.all(np.diff(force) >= 0.0)


@pytest.mark.slow
def test_bootstrap_of_white_noise_agrees_with_least_squares():
    fit = identify(log_of(sines(10.0), sliding_effort(sines(10.0), noise=0.3)), "coulomb_viscous", axis=STATED, blocks=0, draws=150).best
    for name, truth in TRUTH.items():
        item = fit.parameters[name]
        assert np.ptp(item.interval) == pytest.approx(2.0 * 1.96 * item.std, rel=0.45)
        assert abs(item.value - truth) < 5.0 * item.std


def test_biased_replicates_are_reflected_and_pairs_share_an_edge():
    space = ParameterSpace(("level", "damping"), np.array([-np.inf, 0.0]), np.full(2, np.inf))
    thetas = np.array([[12.0, 0.0], [13.0, 0.4], [11.0, 0.2]])
    solution = Solution(space, np.array([10.0, 0.0]), np.zeros((1, 2)), {"damping": "smallest"})
    drawn = turned(solution, thetas, solution.theta)
    # What one of a pair has above the edge, its mirror image has not.
    np.testing.assert_allclose([draw.numbers for draw in drawn], [[8.0, 0.4], [7.0, 0.0], [9.0, 0.2]])
    assert [draw.values["level"] for draw in drawn] == [8.0, 7.0, 9.0]
    # Where more is in doubt than replicates know of, draws lie farther from their middle, which stays.
    wider = turned(solution, thetas, solution.theta, wide=np.array([2.5, 1.0]))
    np.testing.assert_allclose([draw.numbers for draw in wider], [[8.0, 0.4], [5.5, 0.0], [10.5, 0.2]])
    # Replicates of a level of 9 that come out at 12 in the mean leave 7 for one of 10.
    levels = [draw.numbers[0] for draw in turned(solution, np.repeat(thetas, 40, axis=0), np.array([9.0, 0.0]), doubt=0.3)]
    assert np.mean(levels) == pytest.approx(7.0, abs=0.01)
    assert np.std(levels) == pytest.approx(np.hypot(np.std(thetas[:, 0]), 0.3 * 3.0), rel=0.2)


class OneAboveTheOther(ParameterSpace):
    """A level, and a break-away force that is sought in its excess over the level."""

    def values(self, theta):
        return dict(zip(self.names, self.numbers(theta).tolist(), strict=True))

    def numbers(self, theta):
        return np.array([theta[0], theta[0] + 1e6 * theta[1]])

    def derivative(self, theta):
        return np.array([[1.0, 0.0], [1.0, 1e6]])


def test_wider_draws_of_an_excess_widen_the_sum_and_not_its_base():
    space = OneAboveTheOther(("level", "break_away"), np.full(2, -np.inf), np.full(2, np.inf))
    solution = Solution(space, np.array([10.0, 2e-6]), np.zeros((1, 2)))
    # Where the level is high, its excess is low: the break-away force is known better than either.
    thetas = np.array([[11.0, 1.1e-6], [9.0, 2.9e-6], [12.0, -0.1e-6], [8.0, 4.1e-6]])
    plain, wide = (
        np.array([draw.numbers for draw in turned(solution, thetas, solution.theta, wide=values)])
        for values in (None, np.array([1.0, 2.5]))
    )
    np.testing.assert_allclose(wide[:, 0], plain[:, 0])
    np.testing.assert_allclose(wide[:, 1] - 12.0, 2.5 * (plain[:, 1] - 12.0), atol=1e-9)


class OneOfNothing(ParameterSpace):
    """A level, and a number beside it that depends on nothing."""

    @property
    def reported(self):
        return ("level", "constant")

    def derivative(self, theta):
        return np.array([[1.0], [0.0]])


def test_parameters_without_effect_leave_draws_finite():
    solution = Solution(OneOfNothing(("level",), np.array([-np.inf]), np.array([np.inf])), np.array([1.0]), np.eye(1))
    drawn = turned(solution, np.array([[2.0], [0.0]]), solution.theta, wide=np.array([1.0, 2.5]))
    np.testing.assert_allclose([draw.numbers[0] for draw in drawn], [0.0, 2.0])


def test_too_few_draws_are_refused():
    with pytest.raises(InputError, match="draws"):
        identify(log_of(sines(), sliding_effort(sines())), "coulomb_viscous", axis=STATED, draws=5)


@pytest.mark.slow
def test_benchmark_of_intervals_finds_the_functions_that_it_times(monkeypatch):
    for name, count in (("DRAWS", 2), ("RUNS", 1), ("AFRESH", 1)):
        monkeypatch.setattr(benchmarks.bootstrap, name, count)
    (ratio,) = benchmarks.bootstrap.bootstrap()
    assert ratio.ours > 0.0
