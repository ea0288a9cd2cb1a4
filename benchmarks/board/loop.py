"""The closed loop of an axis whose effort a competitor predicts along any motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from benchmarks.board.record import Record
from bristle import friction, plants
from bristle.core import Experiment
from bristle.simulation import compensation_experiment, simulate

# Loops; earlier passes that determine the next motion; share of the change in it.
PASSES, MEMORY, RELAXED = (12, 4, 0.5)
SETTLED = 1e-3  # of the largest change of the first pass


class _DivergedError(Exception):
    """A loop is not finite."""


def following_error(
    effort_along: Callable[[Record], np.ndarray], reference: Record, mass: float
) -> np.ndarray:
    r"""Return the following error of the known loop along a reference [m or rad], shape (sample,); not finite if the first pass diverges.

    A pass :math:`G` simulates the loop of a mass, with the rest of the effort along a motion `x` as a disturbance. Its fixed
    point :math:`G(x) = x` is the loop of the axis with this effort, for any mass. Plain passes diverge where a contact is
    stiffer than the loop, but Anderson mixing [1]_ converges. The result is the pass that changes its motion least.

    References
    ----------
    .. [1] D. G. Anderson, "Iterative procedures for nonlinear integral equations", Journal of the ACM 12(4), 1965.
       doi:10.1145/321296.321305
    """
    from scipy.optimize import NoConvergence, anderson

    passes = list[tuple[float, np.ndarray]]()

    def change(position: np.ndarray) -> np.ndarray:
        motion = Record.of(reference.time, position, None, reference.axis)
        followed = _followed(effort_along(motion) - mass * motion.acceleration, reference, mass)
        passes.append((float(np.sum((followed - position) ** 2)), followed))
        return followed - position

    with suppress(NoConvergence, _DivergedError):
        anderson(
            change,
            reference.position,
            alpha=RELAXED,
            M=MEMORY,
            maxiter=PASSES - 1,
            f_tol=np.inf,
            f_rtol=SETTLED,
            line_search=None,
        )
    if not passes:
        return np.full(reference.position.shape, np.nan)
    return reference.position - min(passes, key=lambda entry: entry[0])[1]


def _followed(disturbance: np.ndarray, reference: Record, mass: float) -> np.ndarray:
    """Return the measured motion of a mass in the loop, with a disturbance."""
    axis = reference.axis
    still = friction.coulomb(kind=axis.kind, F_C=0.0)
    loops = compensation_experiment(
        plants.inertia(kind=axis.kind, M=mass),
        still,
        still,
        axis.controller,  # type: ignore[arg-type]
        reference.position,
        reference.sample_time,
        resolution=axis.resolution or 0.0,
        disturbance=disturbance,
        effort_limit=axis.effort_limit or math.inf,
    )
    first = loops.variants[0]
    measured = simulate(Experiment("loop", axis.kind, (first,))).variants[first.name].measured
    if measured.shape != reference.position.shape or not np.all(np.isfinite(measured)):
        raise _DivergedError
    return measured
