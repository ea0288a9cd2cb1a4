r"""Iterative learning: what a repeated motion teaches is fed forward in the next trial.

.. math:: u_{j+1} = Q\left[u_j + k_e\,e_j + k_d\,\dot e_j\right]

`Q` is a zero-phase low-pass: the whole trial is known, so that the filter may look ahead. It bounds the band in which
the loop learns, and with it what it learns of noise. Where :math:`k_e` is the stiffness of the loop itself, what the
feedback had to do in one trial is fed forward in the next. Learned is what repeats: friction that scatters from trial
to trial is not.

References
----------
.. [1] D. A. Bristow, M. Tharayil, A. G. Alleyne, "A survey of iterative learning control", IEEE Control Systems
   Magazine 26(3), 2006. doi:10.1109/MCS.2006.1636313
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bristle.core.errors import InputError
from bristle.core.experiment import Learning
from bristle.core.status import Status
from bristle.simulation.result import VariantResult

__all__ = ["learn"]

ORDER = 2  # of the filter, which passes forward and backward
SEEDS_APART = 1000  # of the trials of one run


def learn(
    learning: Learning, once: Callable[[np.ndarray, int], VariantResult], desired: np.ndarray, number: int, dt: float
) -> VariantResult:
    """Return the last of several trials; all of them begin alike, with other noise."""
    from scipy.signal import butter, sosfiltfilt

    if not learning.cutoff < 0.5 / dt:
        raise InputError(
            "out of range",
            path="controller.learning.cutoff",
            value=learning.cutoff,
            allowed=f"below half the sampling frequency, {0.5 / dt:g} Hz",
        )
    low_pass = butter(ORDER, learning.cutoff, fs=1.0 / dt, output="sos")
    learned = np.zeros(desired.shape[1])
    errors: list[float] = []
    while True:
        result = once(desired + np.outer((0.0, 0.0, 0.0, 1.0), learned), number + SEEDS_APART * len(errors))
        errors.append(result.following_error.peak_to_peak)
        if len(errors) == learning.trials or result.status is Status.NOT_FINITE:
            return replace(result, trials=tuple(errors))
        error = result.reference - result.measured
        learned = sosfiltfilt(low_pass, learned + learning.k_e * error + learning.k_d * np.gradient(error, dt))
