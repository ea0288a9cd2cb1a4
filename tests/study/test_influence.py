"""Which cause matters: of functions of which it is known."""

import numpy as np
import pytest
from scipy import stats

from bristle.study.influence import rank_correlations, sobol_indices, spread_of
from bristle.study.plan import Sampling
from bristle.study.store import Runs


def runs_of(function, sampling, status="ok"):
    drawn = sampling.numbers(0, sampling.count)
    names = sampling.names
    columns = {"run": np.arange(sampling.count), "status": np.full(sampling.count, status), "f": function(drawn)}
    columns |= {name: drawn[:, place] for place, name in enumerate(names)}
    roles = {name: {"role": "drawn", "unit": ""} for name in names}
    described = {
        "draws": sampling.count,
        "sobol_indices": sampling.indices,
        "causes": {name: [name] for name in names},
        "metrics": ["f"],
        "grid": {},
        "columns": roles | {"f": {"role": "metric", "unit": ""}},
    }
    return Runs(described, columns)


def ishigami(drawn):
    """Return the function whose indices are known in closed form (Ishigami and Homma, 1990)."""
    x, y, z = (np.pi * (2.0 * drawn - 1.0)).T
    return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)  # doi:10.1016/j.envsoft.2006.10.004


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_sobol_indices_of_a_known_function_lie_in_their_intervals(method):
    indices = sobol_indices(runs_of(ishigami, Sampling(method, 5, ("x", "y", "z"), 1024, indices=True)))
    assert [index["cause"] for index in indices] == ["x", "y", "z"]
    for index, first, total in zip(indices, FIRST, TOTAL, strict=True):
        assert index["first_interval"][0] <= first <= index["first_interval"][1]
        assert index["total_interval"][0] <= total <= index["total_interval"][1]
        assert index["first_interval"][1] - index["first_interval"][0] < 0.25


def test_points_with_a_failed_run_are_left_out_of_the_indices():
    runs = runs_of(ishigami, Sampling("random", 5, ("x", "y", "z"), 256, indices=True))
    runs.columns["f"][:30] = 1e9
    runs.columns["status"][:30] = "refused"
    indices = sobol_indices(runs)
    assert all(0.0 < index["total"] < 1.0 for index in indices)


def test_rank_correlations_are_those_of_scipy():
    runs = runs_of(lambda u: np.exp(3.0 * u[:, 0]) - 5.0 * u[:, 1], Sampling("random", 5, ("x", "y", "z"), 300))
    result = {entry["cause"]: entry for entry in rank_correlations(runs)}
    for name in ("x", "y", "z"):
        expected = stats.spearmanr(runs.columns[name], runs.columns["f"]).statistic
        assert result[name]["value"] == pytest.approx(expected, abs=1e-12)
        assert result[name]["interval"][0] <= expected <= result[name]["interval"][1]
    assert result["z"]["interval"][0] < 0.0 < result["z"]["interval"][1]
    assert result["x"]["interval"][0] > 0.8
    assert result["y"]["interval"][1] < 0.0


def test_intervals_of_rank_correlations_hold_the_true_one():
    true = 6.0 / np.pi * np.arcsin(0.5 / 2.0)  # of two normal numbers whose correlation is a half
    fixed = 0
    for seed in range(40):
        sampling = Sampling("random", seed, ("x", "y"), 100)
        normal = stats.norm.ppf(sampling.numbers(0, 100))
        runs = runs_of(lambda u: 0.5 * normal[:, 0] + np.sqrt(0.75) * normal[:, 1], sampling)  # noqa: B023
        interval = rank_correlations(runs)[0]["interval"]
        fixed += interval[0] <= true <= interval[1]
    assert fixed >= 34


def test_many_draws_are_told_as_closely_as_they_are_known():
    few, many = (
        rank_correlations(runs_of(lambda u: u[:, 0] + u[:, 1], Sampling("random", 1, ("x", "y"), count)))[0]["interval"]
        for count in (2000, 50_000)
    )
    assert (many[1] - many[0]) / (few[1] - few[0]) == pytest.approx(0.2, rel=0.25)


def test_draws_at_several_points_count_once():
    def interval(points):
        sampling = Sampling("random", 2, ("x",), 200)
        drawn = np.repeat(sampling.numbers(0, 200)[:, 0], points)
        noise = np.repeat(np.random.default_rng(1).standard_normal(200), points)
        runs = runs_of(lambda u: u[:, 0], Sampling("random", 2, ("x",), 200 * points))
        runs.columns.update(x=drawn, f=drawn + noise)
        described = dict(runs.described) | {"grid": {"g": list(range(points))}}
        return rank_correlations(Runs(described, runs.columns))[0]["interval"]

    assert np.ptp(interval(5)) == pytest.approx(np.ptp(interval(1)), rel=0.1)


def test_a_distribution_is_told_with_its_intervals():
    fixed = {"mean": 0, "median": 0, "high": 0}
    for seed in range(200):
        spread = spread_of(np.random.default_rng(seed).exponential(size=400))
        for name, true in (("mean", 1.0), ("median", np.log(2.0)), ("high", np.log(20.0))):
            low, high = spread[f"{name}_interval"]
            fixed[name] += low <= true <= high
    assert all(182 <= count <= 199 for count in fixed.values()), fixed
    assert np.isnan(spread_of(np.arange(5.0))["high_interval"][1])
    assert spread_of(np.array([np.nan, 2.0]))["count"] == 1
