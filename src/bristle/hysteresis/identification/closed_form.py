r"""A Preisach operator in closed form from a few loops: stiffness :math:`s`, saturation :math:`f_p`, and the kernel.

Two numbers for each kernel, a third for the exponent of ``dahl_masing``. The kernel ``reformed_dahl_exact`` is the
model that the source paper fits to its loops. All kernels are tried; the one that fits best is returned.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model, make_model
from bristle.core.errors import InputError
from bristle.engine import response
from bristle.hysteresis import preisach
from bristle.hysteresis.everett import KERNELS
from bristle.hysteresis.identification.trace import Rows, outputs_of
from bristle.logs.curves import Curves

EVALUATIONS = 60
CURVES_MOST = 25
STARTS = (0.3, 3.0, 30.0)  # of s x over f_p at the largest input
STIFFEST = (1e-3, 1e4)  # the same, between which it is sought
EXPONENTS = (0.5, 4.0)


class ClosedFormFit(NamedTuple):
    """A `preisach` operator from data, and the constant output beside it."""

    operator: Model
    offset: float
    rms: float


def fit_closed_form(recorded: Curves, *, kernel: str | None = None, rows: Rows = None) -> ClosedFormFit:
    """Fit stiffness, saturation and exponent to recorded hysteresis, by one kernel or the best of all.

    Raises
    ------
    InputError
        If input or output does not move, or there is no such kernel.
    """
    if kernel is not None and kernel not in KERNELS:
        raise InputError("no such kernel", path="kernel", value=kernel, allowed=", ".join(KERNELS))
    # Two or three numbers need no more than some curves, evenly chosen.
    step = -(-len(recorded.curves) // CURVES_MOST)
    recorded, rows = replace(recorded, curves=recorded.curves[::step]), None if rows is None else rows[::step]
    extent, spread = max(abs(recorded.low), abs(recorded.high)), float(np.ptp(outputs_of(recorded)))
    if not (extent > 0.0 and spread > 0.0):
        raise InputError("does not move", path="input", value=f"{extent} in, {spread} out")
    fits = [_Search(recorded, name, extent, 0.5 * spread, rows).best() for name in ([kernel] if kernel else KERNELS)]
    return min(fits, key=lambda fit: fit.rms)


class _Search:
    """Least squares in the logarithms of f_p over half the range of the output, of s x/f_p, and in the exponent."""

    def __init__(self, recorded: Curves, kernel: str, extent: float, level: float, rows: Rows) -> None:
        self.recorded, self.kernel, self.extent, self.level, self.rows = recorded, kernel, extent, level, rows
        self.target = outputs_of(recorded, rows)
        self.shaped = kernel == "dahl_masing"

    def operator(self, x: np.ndarray) -> Model:
        f_p = self.level * math.exp(x[0])
        values = {"s": f_p * math.exp(x[1]) / self.extent, "f_p": f_p}
        if self.shaped:
            values["exponent"] = float(x[2])
        return make_model(preisach, values | {"kernel": self.kernel}, kind=self.recorded.kind, validate=True)

    def output(self, x: np.ndarray) -> np.ndarray:
        operator = self.operator(x)
        outputs = [response(operator, curve.u, history=self.recorded.history(curve)) for curve in self.recorded.curves]
        if self.rows is not None:
            outputs = [output[rows] for output, rows in zip(outputs, self.rows, strict=True)]
        return np.concatenate(outputs)

    def residual(self, x: np.ndarray) -> np.ndarray:
        error = self.output(x) - self.target
        return (error - error.mean()) / self.level

    def best(self) -> ClosedFormFit:
        from scipy.optimize import least_squares

        low, high = ([math.log(level), math.log(stiffness)] for level, stiffness in zip((0.1, 100.0), STIFFEST, strict=True))
        if self.shaped:
            low, high = [*low, EXPONENTS[0]], [*high, EXPONENTS[1]]
        starts = [np.array([0.3, math.log(k), 2.0][: len(low)]) for k in STARTS]
        start = min(starts, key=lambda x: float(np.sum(self.residual(x) ** 2)))
        solution = least_squares(self.residual, start, bounds=(low, high), max_nfev=EVALUATIONS, xtol=1e-9, ftol=1e-10)
        offset = float(np.mean(self.target - self.output(solution.x)))
        return ClosedFormFit(self.operator(solution.x), offset, self.level * float(np.sqrt(np.mean(solution.fun**2))))
