"""Whether the effort of a log has the right sign: friction takes energy out, it never puts any in."""

from __future__ import annotations

import numpy as np

from bristle.core.edge import guarded, instance
from bristle.core.least_squares import unbounded
from bristle.logs.log_data import LogData

__all__ = ["REVERSED", "dissipated_share", "sign_of_effort"]

REVERSED = (
    "the sign of effort seems reversed: over the log, friction would put energy in; "
    "turn its sign in the axis file (sign = -1 where it has none or 1, else 1)"
)
STRIDE = 10  # samples over which velocity and effort are averaged, against quantisation
DOUBT = 0.1  # share of the work below which the log says nothing


@guarded(log=instance(LogData, "a log", "Write read_log(...)"))
def sign_of_effort(log: LogData) -> str | None:
    """Return a warning if the effort of `log` seems to have the wrong sign, else None."""
    if log.effort is None:
        return None
    return REVERSED if dissipated_share(log) < -DOUBT else None


def dissipated_share(log: LogData) -> float:
    """Return the work that friction takes, over the work that would be taken if it always opposed the motion.

    What is proportional to the acceleration (inertia) and what is constant (gravity) is taken off the effort
    first, by least squares.

    Parameters
    ----------
    log : Log
        A log with an effort.

    Returns
    -------
    float
        Between -1 (the sign of the effort is reversed) and 1; 0 where the log does not tell.
    """
    if log.effort is None:
        return 0.0
    velocity, acceleration, effort = [], [], []
    for segment in log.segments:
        x, u = log.position.values[segment], log.effort.values[segment]
        count = (x.size - 1) // STRIDE
        if count < 3:
            continue
        v = np.diff(x[: count * STRIDE + 1 : STRIDE]) / (STRIDE * log.sample_time)
        velocity.append(v[1:-1])
        acceleration.append((v[2:] - v[:-2]) / (2 * STRIDE * log.sample_time))
        effort.append(u[: count * STRIDE].reshape(count, STRIDE).mean(axis=1)[1:-1])
    if not velocity:
        return 0.0
    v, a, u = map(np.concatenate, (velocity, acceleration, effort))
    regressors = np.column_stack([a, np.ones_like(a)])
    rest = u - regressors @ unbounded(regressors, u)
    total = float(np.abs(rest) @ np.abs(v))
    return float(rest @ v) / total if total > 0 else 0.0
