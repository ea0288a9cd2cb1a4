"""Influence of causes: rank correlations with intervals, and Sobol indices from draws designed for them."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bristle.apps.study.block import FAILED
from bristle.apps.study.store import Runs

RESAMPLES = 400
SEED = 20_110_517
FEWEST = 10
LEVELS = (2.5, 97.5)  # [%]


def spread_of(numbers: np.ndarray, *, independent: bool = True) -> dict[str, Any]:
    """Return 5 and 95 % quantiles of a metric over runs without NaN, and 95 % intervals by standard error or ranks."""
    usable = np.sort(numbers[np.isfinite(numbers)])
    count = len(usable)
    intervals = [(math.nan, math.nan)] * 3
    names = (
        "count",
        "mean",
        "std",
        "median",
        "low",
        "high",
        "mean_interval",
        "median_interval",
        "high_interval",
    )
    if not count:
        return dict(zip(names, (0, *[math.nan] * 5, *intervals), strict=True))
    mean = float(usable.mean())
    std = math.nan
    if count > 1:
        std = float(usable.std(ddof=1))
    low, median, high = (float(np.quantile(usable, share)) for share in (0.05, 0.5, 0.95))
    if independent:
        half = 1.96 * std / math.sqrt(count)
        intervals = [(mean - half, mean + half), _by_ranks(usable, 0.5), _by_ranks(usable, 0.95)]
    return dict(zip(names, (count, mean, std, median, low, high, *intervals), strict=True))


def _by_ranks(ordered: np.ndarray, share: float) -> tuple[float, float]:
    """Return the 95 % interval of a quantile: the count of values below it has a binomial distribution."""
    from scipy.stats import binom

    count = len(ordered)
    low = int(binom.ppf(0.025, count, share)) - 1
    high = int(binom.ppf(0.975, count, share))
    lower = upper = math.nan  # with too few values
    if low >= 0:
        lower = float(ordered[low])
    if high < count:
        upper = float(ordered[high])
    return lower, upper


def rank_correlations(runs: Runs) -> list[dict[str, Any]]:
    """Return the rank correlation of each metric with each varied value, with its interval.

    Resampling takes whole draws with all their grid points: runs of a draw are not independent. Drawn values are ranked
    within each grid point, so that the grid does not hide their effect.
    """
    columns = runs.columns
    described = runs.described
    causes = [
        name for name, about in described["columns"].items() if about["role"] in ("drawn", "grid")
    ]
    points = int(np.prod([len(values) for values in described["grid"].values()], dtype=int))
    entries = []
    for metric in described["metrics"]:
        usable = np.flatnonzero(~np.isin(columns["status"], FAILED) & np.isfinite(columns[metric]))
        if len(usable) < FEWEST:
            continue
        draws, at = np.divmod(columns["run"][usable].astype(int), points)
        for cause in causes:
            within = at
            if described["columns"][cause]["role"] == "grid":
                within = np.zeros_like(at)
            values = columns[cause]
            if values.dtype.kind == "U":  # names in alphabetical order
                values = np.unique(values, return_inverse=True)[1].astype(float)
            values = _ranked(values[usable], within)
            numbers = _ranked(columns[metric][usable], within)
            if np.ptp(values) > 0.0 and np.ptp(numbers) > 0.0:
                value, interval = _correlation(values, numbers, draws)
                entries.append(
                    {"cause": cause, "metric": metric, "value": value, "interval": interval}
                )
    return entries


def _ranked(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Return ranks within each group, from -0.5 to 0.5."""
    from scipy.stats import rankdata

    ranks = np.empty(len(values))
    for number in np.unique(group):
        chosen = group == number
        ranks[chosen] = (rankdata(values[chosen]) - 0.5) / chosen.sum() - 0.5
    return ranks


def _correlation(
    a: np.ndarray, b: np.ndarray, draws: np.ndarray
) -> tuple[float, tuple[float, float]]:
    """Return the correlation of ranks, and its interval over draws."""
    value = float(np.corrcoef(a, b)[0, 1])
    _, member = np.unique(draws, return_inverse=True)
    groups = int(member[-1]) + 1
    generator = np.random.default_rng(SEED)
    share = min(groups, 2000)  # the interval is scaled to the count of all groups
    # Correlations of resamples follow from sums over each draw, weighted by its count in the resample.
    products = (np.ones_like(a), a, b, a * a, b * b, a * b)
    sums = np.stack([np.bincount(member, weights=part, minlength=groups) for part in products])
    resampled = np.full(RESAMPLES, np.nan)
    for place in range(RESAMPLES):
        resample = generator.integers(0, groups, share)
        n, x, y, xx, yy, xy = sums[:, resample].sum(axis=1)
        spread = (xx - x * x / n) * (yy - y * y / n)
        if spread > 0.0:
            resampled[place] = (xy - x * y / n) / np.sqrt(spread)
    # Fisher's transformation: intervals near 1 stay below it.
    transformed = np.arctanh(np.clip(resampled[np.isfinite(resampled)], -1.0 + 1e-12, 1.0 - 1e-12))
    centre = np.arctanh(np.clip(value, -1.0 + 1e-12, 1.0 - 1e-12))
    if not transformed.size:
        return value, (np.nan, np.nan)
    low, high = np.percentile(transformed - centre, LEVELS) * np.sqrt(share / groups)
    return value, (float(np.tanh(centre + low)), float(np.tanh(centre + high)))


def sobol_indices(runs: Runs) -> list[dict[str, Any]]:
    """Return the Sobol indices of each metric; empty unless the draws were designed for them."""
    # Points with a missing or failed run do not count. Of the others, the largest power of two is used.
    if not runs.described["sobol_indices"]:
        return []
    causes: Mapping[str, Any] = runs.described["causes"]
    width = len(causes) + 2
    count = runs.described["draws"]
    entries = []
    for metric in runs.described["metrics"]:
        numbers = np.full(count, np.nan)
        usable = ~np.isin(runs.columns["status"], FAILED)
        numbers[runs.columns["run"][usable].astype(int)] = runs.columns[metric][usable]
        rows = numbers.reshape(-1, width)
        rows = rows[np.all(np.isfinite(rows), axis=1)]
        if len(rows):
            rows = rows[: 2 ** (len(rows).bit_length() - 1)]
        if len(rows) >= FEWEST and np.ptp(rows) > 0.0:
            generator = np.random.default_rng(SEED)
            values = _estimated(rows)
            resampled = [
                _estimated(rows[generator.integers(0, len(rows), len(rows))])
                for _ in range(RESAMPLES)
            ]
            # Of shape (end, kind of index, cause)
            ends = np.percentile(np.array(resampled), LEVELS, axis=0)
            for place, cause in enumerate(causes):
                entry: dict[str, Any] = {"cause": cause, "metric": metric}
                for kind, name in enumerate(("first", "total")):
                    entry |= {
                        name: float(values[kind, place]),
                        f"{name}_interval": tuple(ends[:, kind, place].tolist()),
                    }
                entries.append(entry)
    return entries


def _estimated(rows: np.ndarray) -> np.ndarray:
    """Return the indices of first order and the total ones, shape (2, cause)."""
    from scipy.stats import sobol_indices as indices_of

    own = rows[:, 0]
    second = rows[:, 1]
    exchanged = rows[:, 2:].T
    result = indices_of(
        func={"f_A": own[np.newaxis], "f_B": second[np.newaxis], "f_AB": exchanged[:, np.newaxis]},
        n=len(rows),
    )
    return np.array([result.first_order, result.total_order]).reshape(2, -1)
