r"""Least squares on Gram matrices of folds: a fit is a choice of groups of columns.

The weights minimise

.. math:: \sum_k |y_k - X_k \beta|^2 + \sum_g \lambda_g \beta_g^T P_g \beta_g

over the folds :math:`k`, non-negative where a group demands it [1]_. The penalties :math:`\lambda_g` maximise the restricted
likelihood over the columns in use [2]_, by the fixed point :math:`\lambda_g = (n_g - \lambda_g \mathrm{tr}(A^{-1} P_g))\,
\sigma^2 / (\beta_g^T P_g \beta_g)`. A fold consists of three stretches of time that are far apart. Sandwich errors sum the
scores of these stretches [3]_.

.. [1] C. L. Lawson, R. J. Hanson: Solving Least Squares Problems. Prentice-Hall, 1974, chapter 23.
.. [2] D. A. Harville: Maximum likelihood approaches to variance component estimation. J. Am. Stat. Assoc. 72 (1977).
   https://doi.org/10.1080/01621459.1977.10480998
.. [3] K.-Y. Liang, S. L. Zeger: Longitudinal data analysis using generalized linear models. Biometrika 73 (1986).
   https://doi.org/10.1093/biomet/73.1.13
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from bristle.identification.dictionary import Group

FOLDS = 20
STRETCHES = 3  # of a fold, far apart in time
ROUNDING = 1e-9  # of the rows: ridge against rounding
NO_PENALTY = 1e-7  # of the rows: penalty of a column without a penalty
FIRST_PENALTY = 1e-2  # of the rows
LEAST_PENALTY = 1e-6  # of the rows
MOST_PENALTY = 1e3  # of the rows
MOST_CHANGE = 30.0  # factor of a penalty from one iteration to the next
ITERATIONS = 12  # of the penalties
SETTLED = 0.05  # change of the logarithm of the penalties that ends the iteration
LEAST_ERROR = 1e-12  # of the power of a fold: smaller errors are rounding
MOST_RISE = 1.04  # factor of the squared error, above which two fits differ
APART = 2.0  # standard errors at which two fits differ


def non_negative(
    A: np.ndarray, b: np.ndarray, is_free: np.ndarray, support: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Minimise x'Ax/2 - b'x with x >= 0 where not free, from a first support; return x and its support."""
    x = np.zeros(b.size)
    active = support | is_free
    scale = np.sqrt(np.diag(A))
    is_feasible = False
    for _ in range(6 * b.size + 60):
        at = np.flatnonzero(active)
        z = np.linalg.solve(A[np.ix_(at, at)], b[at])
        bad = (z <= 0.0) & ~is_free[at]
        if bad.any() and not is_feasible:
            active[at[bad]] = False
            continue
        if bad.any():
            # Along the line to the new point, up to the first weight that reaches zero.
            reach = x[at[bad]] / (x[at[bad]] - z[bad] + np.finfo(float).tiny)
            x[at] += reach.min() * (z - x[at])
            zeroed = at[~is_free[at] & (x[at] <= 1e-12 * (1.0 + np.abs(z)))]
            x[zeroed] = 0.0
            active[zeroed] = False
            continue
        x[:] = 0.0
        x[at] = z
        is_feasible = True
        slope = (b - A @ x) / scale
        slope[active | (slope <= 1e-9 * np.abs(b / scale) + 1e-10)] = 0.0
        if not slope.any():
            break
        active[int(np.argmax(slope))] = True
    return x, active & (is_free | (x > 0.0))


Penalties = dict[str, float]


class Fitted(NamedTuple):
    """Penalties of the groups, weights of the scaled columns, and the columns in use."""

    penalties: Penalties
    weights: np.ndarray  # shape (column,)
    support: np.ndarray  # shape (column,) of bool


class Equations:
    """All candidate columns as Gram matrices of folds; a fit is a choice of groups."""

    def __init__(self, groups: Sequence[Group], y: np.ndarray, weight: np.ndarray) -> None:
        self.groups = list(groups)
        self.unit = math.sqrt(float(np.mean(y**2)))
        X = np.hstack([group.columns for group in groups])
        self.scale = np.sqrt(np.mean(X**2, axis=0)) + np.finfo(float).tiny
        ends = np.cumsum([0, *(group.columns.shape[1] for group in groups)]).tolist()
        self.spans = dict[str, np.ndarray]()
        for group, (begin, end) in zip(groups, pairwise(ends), strict=True):
            self.spans[group.name] = np.arange(begin, end)
            if group.is_curve:
                self.scale[begin:end] = max(rms(self.scale[begin:end]), np.finfo(float).tiny)
        self.X = X / self.scale
        signs = [np.full(group.columns.shape[1], group.is_positive) for group in groups]
        self.is_free = ~np.concatenate(signs)
        self.count = len(y)
        self.edges = np.linspace(0, len(y), STRETCHES * FOLDS + 1).astype(int).tolist()
        self.y = y
        self.weigh(weight)

    def weigh(self, weight: np.ndarray) -> None:
        """Set the weights of the rows."""
        self.weight = weight
        X = self.X * np.sqrt(weight)[:, None]
        parts = [slice(*pair) for pair in pairwise(self.edges)]
        self.grams = folded([X[part].T @ X[part] for part in parts])
        self.gram = self.grams.sum(axis=0)
        self.retarget(self.y)

    def retarget(self, y: np.ndarray) -> None:
        """Set the effort of the rows."""
        self.y = y
        self.rights, self.powers = self.targets()
        self.right = self.rights.sum(axis=0)

    def targets(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the right sides, shape (fold, column), and the powers of the effort, shape (fold,)."""
        y = self.y / self.unit
        weighted = self.weight * y
        parts = [slice(*pair) for pair in pairwise(self.edges)]
        rights = folded([self.X[part].T @ weighted[part] for part in parts])
        powers = folded([weighted[part] @ y[part] for part in parts])
        return rights, powers

    def columns_of(self, chosen: Sequence[Group]) -> np.ndarray:
        """Return the columns of a choice of groups."""
        return np.concatenate([self.spans[group.name] for group in chosen])

    def penalty(self, chosen: Sequence[Group], penalties: Penalties) -> np.ndarray:
        """Return the penalty on the weights, shape (column, column)."""
        P = np.zeros_like(self.gram)
        for group in chosen:
            span = self.spans[group.name]
            P[np.ix_(span, span)] = self.penalty_of(group, penalties)
        return P

    def penalty_of(self, group: Group, penalties: Penalties) -> np.ndarray:
        """Return the penalty on the weights of a group."""
        if group.penalty is None:
            return NO_PENALTY * self.count * np.eye(self.spans[group.name].size)
        return penalties[group.name] * group.penalty

    def solve(
        self,
        chosen: Sequence[Group],
        penalties: Penalties,
        support: np.ndarray | None = None,
        right: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return weights and support of a choice of groups, each of shape (column,)."""
        at = self.columns_of(chosen)
        return self.solve_columns(at, self.penalty(chosen, penalties), support, right)

    def solve_columns(
        self,
        at: np.ndarray,
        P: np.ndarray,
        support: np.ndarray | None = None,
        right: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return weights and support of a choice of columns."""
        first = np.zeros(self.right.size, dtype=bool) if support is None else support
        b = self.right if right is None else right
        A = (self.gram + P)[np.ix_(at, at)]
        weights = np.zeros(self.right.size)
        active = np.zeros(self.right.size, dtype=bool)
        weights[at], active[at] = non_negative(A, b[at], self.is_free[at], first[at])
        return weights, active

    def likeliest(
        self, chosen: Sequence[Group], penalties: Penalties, support: np.ndarray
    ) -> Penalties:
        """Return the penalties that maximise the restricted likelihood over the columns in use: a fixed point."""
        penalties = dict(penalties)
        at = np.flatnonzero(support)
        place = np.full(support.size, -1)
        place[at] = np.arange(at.size)
        active = dict[str, np.ndarray]()
        for group in chosen:
            span = self.spans[group.name]
            if group.penalty is not None and support[span].any():
                active[group.name] = place[span[support[span]]]
        shapes = self.shapes(chosen, support)
        G = self.gram[np.ix_(at, at)]
        b = self.right[at]
        power = float(self.powers.sum())
        for _ in range(ITERATIONS):
            inverse = np.linalg.inv(G + self.penalty(chosen, penalties)[np.ix_(at, at)])
            x = inverse @ b
            residual = max(power - 2.0 * float(x @ b) + float(x @ G @ x), 1e-12 * power)
            variance = residual / max(self.count - float(np.sum(inverse * G)), 1.0)
            change = 0.0
            for name, columns in active.items():
                P = shapes[name]
                before = penalties[name]
                trace = float(np.sum(inverse[np.ix_(columns, columns)] * P))
                used = max(columns.size - before * trace, 1e-9)
                roughness = max(float(x[columns] @ P @ x[columns]), np.finfo(float).tiny)
                least = max(before / MOST_CHANGE, LEAST_PENALTY * self.count)
                most = min(before * MOST_CHANGE, MOST_PENALTY * self.count)
                penalties[name] = min(max(used * variance / roughness, least), most)
                change = max(change, abs(math.log(penalties[name] / before)))
            if change < SETTLED:
                break
        return penalties

    def shapes(self, chosen: Sequence[Group], support: np.ndarray) -> dict[str, np.ndarray]:
        """Return the penalty of each group on its columns in use."""
        shapes = dict[str, np.ndarray]()
        for group in chosen:
            if group.penalty is not None:
                active = support[self.spans[group.name]]
                shapes[group.name] = group.penalty[active][:, active]
        return shapes

    def fit(
        self,
        chosen: Sequence[Group],
        penalties: Mapping[str, float] | None = None,
        support: np.ndarray | None = None,
        rounds: int = 3,
    ) -> Fitted:
        """Fit penalties and weights in turn."""
        current = {group.name: FIRST_PENALTY * self.count for group in self.groups}
        current |= dict(penalties or {})
        weights, active = self.solve(chosen, current, support)
        for _ in range(rounds):
            current = self.likeliest(chosen, current, active)
            weights, active = self.solve(chosen, current, active)
        return Fitted(current, weights, active)

    def held_out(
        self, chosen: Sequence[Group], penalties: Penalties, support: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the error of each fold, fitted without it on the support of all folds, and this support."""
        _, active = self.solve(chosen, penalties, support)
        at = np.flatnonzero(active)
        P = self.penalty(chosen, penalties)[np.ix_(at, at)]
        G = self.grams[:, at][:, :, at]
        b = self.rights[:, at]
        x = np.linalg.solve(G.sum(axis=0) - G + P, (b.sum(axis=0) - b)[..., None])[..., 0]
        return self.fold_errors(at, x), active

    def errors_of(self, weights: np.ndarray, at: np.ndarray) -> np.ndarray:
        """Return the squared error of each fold with the same weights of some columns."""
        return self.fold_errors(at, np.broadcast_to(weights[at], (FOLDS, at.size)))

    def fold_errors(self, at: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return the squared error of each fold with its weights of some columns, shape (fold, column)."""
        G = self.grams[:, at][:, :, at]
        bent = np.einsum("ki,kij,kj->k", x, G, x)
        errors = self.powers - 2.0 * np.sum(x * self.rights[:, at], axis=1) + bent
        return np.maximum(errors, LEAST_ERROR * self.powers.mean())

    def unique_shares(self, group: Group, beside: Sequence[Group]) -> tuple[float, float]:
        """Return the least and the largest share of a combination of the columns of a group that columns beside it leave."""
        at = self.columns_of(beside)
        own = self.spans[group.name]
        A = self.gram[np.ix_(at, at)] + ROUNDING * self.count * np.eye(at.size)
        B = self.gram[np.ix_(at, own)]
        G = self.gram[np.ix_(own, own)]
        factor = np.linalg.cholesky(G + ROUNDING * self.count * np.eye(own.size))
        left = np.linalg.solve(factor, G - B.T @ np.linalg.solve(A, B))
        shares = np.linalg.eigvalsh(np.linalg.solve(factor, left.T)).tolist()
        return shares[0], shares[-1]

    def covariance(self, at: np.ndarray, P: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Return the covariance of the weights of some columns: sandwich over stretches of time."""
        residual = self.weight * (self.y / self.unit - self.X @ weights)
        X = self.X[:, at]
        scores = [X[a:b].T @ residual[a:b] for a, b in pairwise(self.edges)]
        S = np.stack(scores)
        inverse = np.linalg.inv((self.gram + P)[np.ix_(at, at)])
        return inverse @ (S.T @ S) @ inverse * len(S) / (len(S) - 1)

    def physical(self, group: Group, weights: np.ndarray) -> np.ndarray:
        """Return the weights of a group in SI units."""
        span = self.spans[group.name]
        return self.unit * weights[span] / self.scale[span]


def folded(parts: Sequence[Any]) -> np.ndarray:
    """Return the sums over the stretches of each fold."""
    stacked = np.stack(parts)
    return stacked.reshape(STRETCHES, FOLDS, *stacked.shape[1:]).sum(axis=0)


def are_alike(errors: np.ndarray, best: np.ndarray) -> bool:
    """Whether the errors of the folds do not tell a fit from the best one."""
    ratios = np.log(errors / best)
    error = float(ratios.std(ddof=1)) / math.sqrt(ratios.size)
    is_close = float(errors.sum()) < MOST_RISE * float(best.sum())
    return is_close and float(ratios.mean()) < APART * error + 1e-12


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))
