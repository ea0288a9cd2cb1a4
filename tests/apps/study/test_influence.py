"""Which cause matters: of functions of which it is known."""

import numpy as np
import pytest
from scipy import stats

from bristle.apps.study.influence import _ranked, rank_correlations, sobol_indices, spread_of
from bristle.apps.study.plan import Sampling
from bristle.apps.study.store import Runs


def runs_of(function, sampling, status="ok"):
    drawn = sampling.numbers(0, sampling.count)
    names = sampling.names
    columns = {
        "run": np.arange(sampling.count),
        "status": np.full(sampling.count, status, dtype="U12"),
        "f": function(drawn),
    }
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
    indices = sobol_indices(
        runs_of(ishigami, Sampling(method, 5, ("x", "y", "z"), 1024, indices=True))
    )
    assert [index["cause"] for index in indices] == ["x", "y", "z"]
    for index, first, total in zip(indices, FIRST, TOTAL, strict=True):
        assert index["first_interval"][0] <= first <= index["first_interval"][1]
        assert index["total_interval"][0] <= total <= index["total_interval"][1]
        assert index["first_interval"][1] - index["first_interval"][0] < 0.25


def test_rank_correlations_are_those_of_scipy():
    runs = runs_of(
        lambda u: np.exp(3.0 * u[:, 0]) - 5.0 * u[:, 1], Sampling("random", 5, ("x", "y", "z"), 300)
    )
    result = {entry["cause"]: entry for entry in rank_correlations(runs)}
    for name in ("x", "y", "z"):
        expected = stats.spearmanr(runs.columns[name], runs.columns["f"]).statistic
        assert result[name]["value"] == pytest.approx(expected, abs=1e-12)
        assert result[name]["interval"][0] <= expected <= result[name]["interval"][1]
    assert result["z"]["interval"][0] < 0.0 < result["z"]["interval"][1]
    assert result["x"]["interval"][0] > 0.8
    assert result["y"]["interval"][1] < 0.0


@pytest.mark.slow
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


def test_a_distribution_of_few_numbers_is_known_by_hand():
    spread = spread_of(np.array([4.0, 1.0, np.inf, 2.0, 3.0, np.nan, 5.0]))
    assert [spread[name] for name in ("count", "mean", "median", "low", "high")] == pytest.approx(
        [5, 3.0, 3.0, 1.2, 4.8]
    )
    assert spread["std"] == pytest.approx(np.sqrt(2.5))
    half = 1.96 * np.sqrt(2.5 / 5.0)
    assert spread["mean_interval"] == pytest.approx((3.0 - half, 3.0 + half))
    dependent = spread_of(np.arange(5.0), independent=False)
    assert np.all(
        np.isnan(
            [dependent[name] for name in ("mean_interval", "median_interval", "high_interval")]
        )
    )
    assert spread_of(np.array([np.nan]))["count"] == 0
    assert np.isnan(spread_of(np.array([np.nan]))["mean"])
    assert np.isnan(spread_of(np.array([2.0]))["std"])


def test_a_median_lies_between_the_ranks_that_the_count_allows():
    # Of 100 numbers between 40 and 60 lie below the median, 19 times of 20.
    spread = spread_of(np.arange(100.0))
    assert spread["median_interval"] == (39.0, 60.0)
    assert spread["high_interval"] == (89.0, 99.0)


def test_ranks_are_within_their_group_and_around_zero():
    ranks = _ranked(np.array([10.0, 30.0, 20.0, 20.0, 5.0, 7.0]), np.array([0, 0, 0, 0, 1, 1]))
    assert ranks.tolist() == [-0.375, 0.375, 0.0, 0.0, -0.25, 0.25]


def drawn(count=12, **changes):
    """Runs of which the metric rises with x, falls with a name and has nothing to do with z."""
    x = np.linspace(0.0, 1.0, count)
    columns = {
        "run": np.arange(count),
        "status": np.full(count, "ok"),
        "f": x**3,
        "x": x,
        "z": np.zeros(count),
    }
    columns["name"] = np.array(sorted("abcdefghijklmnopqrstuvwxyz"[:count], reverse=True))
    roles = {name: {"role": "drawn", "unit": ""} for name in ("x", "name", "z")} | {
        "f": {"role": "metric", "unit": ""}
    }
    described = {"grid": {}, "metrics": ["f"], "columns": roles, "sobol_indices": False}
    return Runs(described, columns | changes)


def test_names_are_ranked_by_the_alphabet_and_constants_are_left_out():
    entries = rank_correlations(drawn())
    assert [(entry["cause"], entry["metric"], round(entry["value"], 9)) for entry in entries] == [
        ("x", "f", 1.0),
        ("name", "f", -1.0),
    ]
    assert all(-1.0 <= end <= 1.0 for entry in entries for end in entry["interval"])
    assert rank_correlations(drawn(f=np.ones(12))) == []


def test_fewer_than_ten_runs_have_no_correlation():
    f = np.linspace(0.0, 1.0, 12)
    f[:2] = np.nan
    assert len(rank_correlations(drawn(f=f))) == 2
    f[2] = np.nan
    assert rank_correlations(drawn(f=f)) == []
    status = np.array(["ok"] * 9 + ["refused", "raised", "not_finite"])
    assert rank_correlations(drawn(status=status)) == []
    assert (
        len(
            rank_correlations(
                drawn(status=np.array(["ok"] * 9 + ["tolerance_missed", "raised", "not_finite"]))
            )
        )
        == 2
    )


def test_draws_are_ranked_within_each_point_of_the_grid():
    runs = drawn(
        24,
        name=np.zeros(24),
        x=np.repeat(np.arange(12.0), 2),
        z=np.tile([0.0, 1.0], 12),
        f=np.repeat(np.arange(12.0), 2),
    )
    runs.columns["f"] += np.tile([0.0, 100.0], 12)  # the point of the grid hides the draw
    described = dict(runs.described) | {"grid": {"z": [0.0, 1.0]}}
    described["columns"] = dict(described["columns"]) | {"z": {"role": "grid", "unit": ""}}
    entries = {
        entry["cause"]: entry["value"] for entry in rank_correlations(Runs(described, runs.columns))
    }
    assert entries["x"] == pytest.approx(1.0)
    assert 0.8 < entries["z"] < 0.9


def test_indices_take_as_many_points_as_a_power_of_two():
    runs = runs_of(lambda drawn: drawn[:, 0], Sampling("random", 5, ("x", "y"), 32, indices=True))
    whole = sobol_indices(runs)
    assert [entry["cause"] for entry in whole] == ["x", "y"]
    assert whole[0]["total"] == pytest.approx(1.0, abs=0.2)
    assert whole[1]["first"] == pytest.approx(0.0, abs=0.2)
    runs.columns["status"][0] = "refused"  # 31 points are left, of which 16 are taken
    part = sobol_indices(runs)
    half = runs_of(lambda drawn: drawn[:, 0], Sampling("random", 5, ("x", "y"), 32, indices=True))
    columns = {name: column[4:68] for name, column in half.columns.items()} | {"run": np.arange(64)}
    alone = sobol_indices(Runs(dict(half.described) | {"draws": 64}, columns))
    assert [entry["first"] for entry in part] == pytest.approx([entry["first"] for entry in alone])
    assert sobol_indices(Runs(dict(runs.described) | {"sobol_indices": False}, runs.columns)) == []
    constant = runs_of(
        lambda drawn: np.ones(len(drawn)), Sampling("random", 5, ("x",), 32, indices=True)
    )
    assert sobol_indices(constant) == []
    few = runs_of(lambda drawn: drawn[:, 0], Sampling("random", 5, ("x",), 8, indices=True))
    assert sobol_indices(few) == []
