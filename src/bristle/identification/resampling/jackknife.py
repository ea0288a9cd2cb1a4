"""Jackknife over half-cycles: the cross-check of the bootstrap, which takes nothing for known but the model."""

from __future__ import annotations

import numpy as np

from bristle.core.least_squares import unbounded
from bristle.identification.resampling.half_cycles import Groups
from bristle.identification.resampling.refit import Space

__all__ = ["jackknife_std"]

FEWEST = 5  # half-cycles


def jackknife_std(space: Space, cycles: Groups, residual: np.ndarray) -> dict[str, float]:
    r"""Return the standard error of each parameter [SI] by leaving out one half-cycle after the other.

    Without half-cycle `k` the solution moves, to first order, by

    .. math:: \delta_k = -\left(J^T J - J_k^T J_k\right)^{-1} J_k^T r_k

    and :math:`\tfrac{n - 1}{n} \sum_k (\delta_k - \bar\delta)^2` is the variance. What is common to all half-cycles, as
    the error of the encoder is, it does not see.

    Parameters
    ----------
    space : Space
        The coordinates of the solution; those on a bound stay there.
    cycles : Groups
        Of its log.
    residual : ndarray, shape (row,)
        Measured minus predicted effort [N or N*m].

    Returns
    -------
    dict
        Empty with fewer than five half-cycles.
    """
    if cycles.count < FEWEST:
        return {}
    inner = (space.theta > space.low) & (space.theta < space.high) & (np.linalg.norm(space.jacobian, axis=0) > 0.0)
    columns = space.jacobian[:, inner]
    scale = np.linalg.norm(columns, axis=0)
    columns = columns / scale
    parts = np.stack([columns[rows].T @ columns[rows] for rows in cycles.parts])
    pulls = cycles.summed(columns * residual[:, None])
    whole = np.sum(parts, axis=0)
    moved = np.stack([-unbounded(whole - part, pull, rcond=1e-12) for part, pull in zip(parts, pulls, strict=True)])
    told = moved @ (space.derivative[:, inner] / scale).T
    count = len(moved)
    std = np.sqrt((count - 1) / count * np.sum((told - told.mean(axis=0)) ** 2, axis=0))
    return {name: float(one) for name, one in zip(space.told, std, strict=True) if name not in space.at_edge}
