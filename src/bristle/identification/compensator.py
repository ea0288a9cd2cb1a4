r"""A compensator from what a loop can log: the reading of its encoder and the effort that it commands.

Along a slow motion before break-away the effort is friction and a little inertia. It is fitted by stops in parallel
with weights that are not negative, a spring and a constant,

.. math:: u = M\ddot q + \sum_i k_i\,\mathcal S_{r_i}[q] + k\,q + u_0, \qquad k_i, k \ge 0

at thresholds :math:`r_i` given in advance, so that the problem is convex and has one solution. Encoder and effort pass
one zero-phase low-pass, and so does each stop; the effort is taken later by the time it needs to act (delay, half a
sample of its hold, lag of the drive). What cannot be told apart is not asked for: in pre-sliding an asymmetry of the
directions is, once the contact is conditioned, an offset.

References
----------
.. [1] K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
   Prandtl-Ishlinskii approach", European Journal of Control 9(4), 2003. doi:10.3166/ejc.9.407-418
"""

from __future__ import annotations

import numpy as np

from bristle import friction, hysteresis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.variable import Kind
from bristle.engine import response
from bristle.identification.regression import low_passed

__all__ = ["identify_compensator"]

CUTOFF = 15.0  # [Hz]
STOPS = 25
SMALLEST = 0.015  # threshold, of half the range of the motion
EDGE_PERIODS = 5  # of the cut-off: the transient of the filter
ROWS_PER_PERIOD = 4  # of the cut-off
NEVER = 1e3  # the spring as a stop: its threshold over half the range of the motion


def identify_compensator(
    position: np.ndarray, effort: np.ndarray, sample_time: float, *, mass: float, delay: float = 0.0,
    cutoff: float = CUTOFF, stops: int = STOPS, kind: Kind = "translational",
) -> Model:  # fmt: skip
    """Return a compensator for pre-sliding, from the log of a slow motion.

    Parameters
    ----------
    position : ndarray, shape (sample,)
        Encoder reading [m or rad], from a contact that begins virgin or is conditioned by the largest loop.
    effort : ndarray, shape (sample,)
        Effort commanded [N or N*m].
    sample_time : float
        Sample time [s].
    mass : float
        Mass or inertia [kg or kg*m^2].
    delay : float
        Time from a command to the middle of its action [s].
    cutoff : float
        Cut-off of the zero-phase filter [Hz].
    stops : int
        Number of thresholds, evenly spaced in their logarithm up to half the range of the motion.
    kind : {"translational", "rotational"}
        Kind of axis.

    Returns
    -------
    Model
        ``maxwell_slip`` with an offset; the spring is an element that never slips.

    Raises
    ------
    InputError
        If the axis does not move, or the log is too short for the filter.
    """
    dropped = max(round(EDGE_PERIODS / (cutoff * sample_time)), 1)
    half = 0.5 * float(np.ptp(position))
    if not (half > 0.0 and position.size > 4 * dropped):
        raise InputError(
            "is no motion that a compensator can be taken from", path="position", value=f"{position.size} samples over "
            f"{2.0 * half:g}", mend="Record loops of several sizes before break-away",
        )  # fmt: skip
    motion = low_passed(position, cutoff, sample_time)
    motion -= motion[0]
    later = np.interp(np.arange(effort.size) - delay / sample_time, np.arange(effort.size), effort)
    acceleration = np.gradient(np.gradient(motion, sample_time), sample_time)
    target = low_passed(later, cutoff, sample_time) - mass * low_passed(acceleration, cutoff, sample_time)
    thresholds = half * np.geomspace(SMALLEST, 1.0, stops)
    columns = [response(hysteresis.stop(kind=kind, r=r), motion) for r in thresholds]
    columns = [low_passed(column, cutoff, sample_time) for column in (*columns, motion)]
    columns += [np.ones_like(motion), -np.ones_like(motion)]
    rows = slice(dropped, -dropped, max(round(1.0 / (ROWS_PER_PERIOD * cutoff * sample_time)), 1))
    k, offset = _not_negative(np.stack(columns, axis=1)[rows], target[rows])
    return _as_elements(k, np.append(thresholds, NEVER * half), offset, kind)


def _not_negative(columns: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the stiffness of each element, and the constant as the difference of the last two weights."""
    from scipy.optimize import nnls

    size = np.linalg.norm(columns, axis=0)
    weights = nnls(columns / size, target)[0] / size
    return weights[:-2], float(weights[-2] - weights[-1])


def _as_elements(k: np.ndarray, thresholds: np.ndarray, offset: float, kind: Kind) -> Model:
    kept = k > 0.0
    limits = k[kept] * thresholds[kept]
    return friction.find("maxwell_slip")(
        kind=kind, F_C=float(limits.sum()), k_i=k[kept], nu_i=limits / limits.sum(), offset=offset
    )
