"""Intervals from replicates: draws, the scatter of the level, bands, and coverage."""

from dataclasses import replace

import benchmarks.bootstrap
import numpy as np
import pytest
from benchmarks.coverage import AXIS, FITTED, MAXWELL, UNSEEN, motion, recorded
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle import friction, plants
from bristle.core import Axis, InputError
from bristle.identification.bootstrap import CERTAIN, ChiSquare, Level, Levels, bootstrap, turned
from bristle.identification.half_cycles import Disturbance, Groups
from bristle.identification.inverse_dynamics import InverseDynamics, RowReplicates
from bristle.identification.least_squares import linear
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.result import Bands
from bristle.prediction import predict

PAIRS = 15


def problem_of(moved, effort, cutoff=50.0, **segments):
    dataset = treat(log_of(moved, effort, **segments), Axis(), cutoff, 5)
    return InverseDynamics(
        dataset, parameters_of(friction.find("coulomb_viscous"), PriorKnowledge(), dataset)
    )


def test_a_replicate_and_its_mirror_image_lie_on_both_sides_of_the_model():
    twin = RowReplicates(problem_of(sines(), sliding_effort(sines())), TRUTH)
    disturbance = Disturbance(0.065, 0.3, 0.0, 1e-7, 0.5)
    item, other, still = (
        twin.log(disturbance, np.random.default_rng(5), side) for side in (1.0, -1.0, 0.0)
    )
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
    effort = (
        12.0 * moved.acceleration
        + 8.0 * levels[half_cycle] * np.sign(moved.velocity)
        + 30.0 * moved.velocity
        + noise
    )
    problem = problem_of(moved, effort, 100.0)
    result = bootstrap(problem, linear(problem), 6, linear=True).scatter
    true = float(np.std(levels[1 : half_cycle[-1]]))
    assert result.value == pytest.approx(true, rel=0.25, abs=0.01)
    assert result.low <= result.value <= result.high
    if scatter:
        assert result.low < true < result.high


@pytest.mark.slow
def test_bands_contain_measurements_of_a_different_true_model():
    log, unseen = (
        recorded(MAXWELL, motion(*FITTED, pairs=PAIRS), seed=1),
        recorded(MAXWELL, motion(*UNSEEN, pairs=9), seed=2),
    )
    fit = identify(log, "dahl", axis=AXIS, blocks=0, draws=40).best
    assert (
        85.0
        < predict(fit.plant, fit.friction, unseen, AXIS, bands=fit.resampling.bands).inside_percent
        < 99.5
    )


@pytest.mark.slow
def test_elements_that_slip_have_intervals_on_their_level_stiffness_and_virgin_curve():
    fit = identify(
        recorded(MAXWELL, motion(*FITTED, pairs=PAIRS), seed=3),
        "maxwell_slip",
        axis=AXIS,
        blocks=0,
        draws=40,
    ).best
    low, high = fit.parameters["F_C"].interval
    assert low < MAXWELL.values["F_C"] < high
    x, force, low, high = np.array(fit.resampling.curve).T
    assert np.all(np.diff(x) > 0.0)
    assert np.all((low <= high) & (low < force + 1e-9) & (force < high + 1e-9))
    # Up to the last threshold a virgin curve rises.
    assert np.all(np.diff(force) >= 0.0)


@pytest.mark.slow
def test_bootstrap_of_white_noise_agrees_with_least_squares():
    fit = identify(
        log_of(sines(10.0), sliding_effort(sines(10.0), noise=0.3)),
        "coulomb_viscous",
        axis=STATED,
        blocks=0,
        draws=150,
    ).best
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
    np.testing.assert_allclose(
        [draw.numbers for draw in drawn], [[8.0, 0.4], [7.0, 0.0], [9.0, 0.2]]
    )
    assert [draw.values["level"] for draw in drawn] == [8.0, 7.0, 9.0]
    # Where more is in doubt than replicates know of, draws lie farther from their middle, which stays.
    wider = turned(solution, thetas, solution.theta, wide=np.array([2.5, 1.0]))
    np.testing.assert_allclose(
        [draw.numbers for draw in wider], [[8.0, 0.4], [5.5, 0.0], [10.5, 0.2]]
    )
    # Replicates of a level of 9 that come out at 12 in the mean leave 7 for one of 10.
    levels = [
        draw.numbers[0]
        for draw in turned(solution, np.repeat(thetas, 40, axis=0), np.array([9.0, 0.0]), doubt=0.3)
    ]
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
    solution = Solution(
        OneOfNothing(("level",), np.array([-np.inf]), np.array([np.inf])),
        np.array([1.0]),
        np.eye(1),
    )
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


MEAN = 0.0025


def squares(freedom: int, count: int) -> np.ndarray:
    """Mean squares of so many normal numbers."""
    return MEAN * np.mean(
        np.random.default_rng(freedom).standard_normal((count, freedom)) ** 2, axis=1
    )


@pytest.mark.parametrize("freedom", [3, 10, 40])
def test_mean_and_freedom_are_recovered(freedom):
    result = ChiSquare.of(squares(freedom, 20_000))
    assert result.mean == pytest.approx(MEAN, rel=0.02)
    assert result.freedom == pytest.approx(freedom, rel=0.06)


@pytest.mark.parametrize("freedom", [10, 40])
def test_share_of_deviations_below_a_quantile_is_right(freedom):
    drawn = squares(freedom, 20_000)
    result = ChiSquare.of(drawn)
    for share in (0.025, 0.5, 0.975):
        below = np.mean(np.sqrt(drawn / MEAN) < result.deviation(share))
        assert below == pytest.approx(share, abs=0.008)


def test_an_outlier_in_a_hundred_changes_little():
    drawn = squares(40, 100)
    result = ChiSquare.of(drawn)
    drawn[7] *= 1e4
    astray = ChiSquare.of(drawn)
    assert astray.mean == pytest.approx(result.mean, rel=0.05)
    assert astray.freedom == pytest.approx(result.freedom, rel=0.25)
    # By moments there would be hardly one degree of freedom left.
    assert 2.0 * np.mean(drawn) ** 2 / np.var(drawn) < 0.1


def test_equal_estimates_have_no_uncertainty():
    assert ChiSquare.of(np.zeros(5)) == CERTAIN
    assert ChiSquare.of(np.full(5, MEAN)).deviation(0.975) == 1.0


def test_without_apparent_scatter_the_ratio_gives_the_scatter():
    level = Level(0.04, 0.0, 1.0, ChiSquare(0.04, 9.0))
    assert level.scatter() == pytest.approx(0.2)
    for deviation in (0.5, 2.0):
        assert level.scatter(deviation) == pytest.approx(0.2 / deviation)
        assert level.visible_of(level.scatter(deviation)) == pytest.approx(0.2 / deviation)


def test_an_invisible_scatter_may_exist():
    level = Level(0.9, 1.0, 0.5, ChiSquare(1.0, 8.0))
    assert level.scatter() == level._replace(gain=0.0).scatter() == 0.0
    assert level.scatter(level.squares.deviation(0.025)) > 0.5
    assert level.scatter(level.squares.deviation(0.975)) == 0.0


@pytest.mark.parametrize("corner", [0.0, 5.0])
def test_errors_next_to_reversals_are_not_scatter(corner):
    rng, count, rows = np.random.default_rng(4), 24, 40
    cycles, place = Groups(np.repeat(np.arange(count), rows)), np.tile(np.arange(rows), count)
    slope, away = np.where(cycles.of_rows % 2, -1.0, 1.0), (place > 4) & (place < rows - 4)
    levels = 0.05 * rng.standard_normal(count)
    residual = levels[cycles.of_rows] * slope + 0.01 * rng.standard_normal(slope.size)
    residual += np.where(away, 0.0, corner * rng.standard_normal(slope.size))
    assert Levels.of(cycles, slope, away).scatter(residual) == pytest.approx(
        np.std(levels), rel=0.1
    )


def test_all_rows_count_if_most_half_cycles_have_no_rows_away_from_reversals():
    cycles = Groups(np.repeat(np.arange(10), 20))
    assert Levels.of(cycles, np.ones(200), cycles.of_rows < 4).rows.all()
    assert not Levels.of(cycles, np.ones(200), cycles.of_rows < 6).rows.all()


NOISE = 0.3
PLANT = plants.inertia(M=TRUTH["M"])
FRICTION = friction.coulomb_viscous(**{name: TRUTH[name] for name in ("F_C", "F_v")})


# Bands of a model that is known exactly, and has no noise.
KNOWN = Bands(
    {name: np.full(40, TRUTH[name]) for name in ("M", "F_C", "F_v")},
    scatter=0.0,
    noise=0.0,
    unexplained=0.0,
)


@pytest.fixture(scope="module")
def log():
    motion = sines(6.0)
    return log_of(motion, sliding_effort(motion, noise=NOISE, offset=0.0))


@pytest.mark.parametrize(("cutoff", "decimation"), [(100.0, 10), (100.0, 1), (30.0, 5), (200.0, 2)])
def test_bands_of_noise_contain_19_of_20_rows(log, cutoff, decimation):
    assert (
        92.0
        < predict(
            PLANT,
            FRICTION,
            log,
            cutoff=cutoff,
            decimation=decimation,
            bands=replace(KNOWN, noise=NOISE),
        ).inside_percent
        < 98.0
    )


def test_unexplained_force_and_uncertainty_add_their_squares(log):
    levels = TRUTH["F_C"] + np.random.default_rng(0).normal(0.0, 0.5, 40)
    lacking, unsure, both = (
        np.median(predict(PLANT, FRICTION, log, bands=replace(KNOWN, **changes)).half_width)
        for changes in (
            {"unexplained": 0.7},
            {"draws": KNOWN.draws | {"F_C": levels}},
            {"unexplained": 0.7, "draws": KNOWN.draws | {"F_C": levels}},
        )
    )
    assert lacking == pytest.approx(1.96 * 0.7, rel=1e-3)
    # Sliding, the force is as unsure as its level.
    assert unsure == pytest.approx(1.96 * np.std(levels, ddof=1), rel=0.02)
    assert both == pytest.approx(np.hypot(lacking, unsure), rel=1e-3)


def test_bands_of_a_scattering_level_are_as_wide_as_its_friction(log):
    half_width = predict(PLANT, FRICTION, log, bands=replace(KNOWN, scatter=0.05)).half_width
    assert np.median(half_width) == pytest.approx(1.96 * 0.05 * TRUTH["F_C"], rel=0.15)
