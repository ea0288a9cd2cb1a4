r"""Linear least squares, :math:`\min_x |A x - b|`, free, within bounds, and without negative parts.

The only place where linear solvers are called: on numbers whose squares are not finite they write beyond their memory or
never return, so what is out of reach is scaled by a power of two, which changes no digit.
"""

import math

import numpy as np

from bristle.core.errors import InputError

REACH = 1e100  # largest number, and the inverse of the smallest, that is left as it is


def unbounded(A: np.ndarray, b: np.ndarray, *, rcond: float | None = None) -> np.ndarray:
    """Return the least-squares solution, the shortest where there are several."""
    A, b, unit = _in_reach(A, b)
    return np.linalg.lstsq(A, b, rcond=rcond)[0] * unit


def normal(gram: np.ndarray, right: np.ndarray, *, rcond: float) -> np.ndarray:
    """Return the solution of normal equations, their diagonal made ones; shapes (..., n, n) and (..., n)."""
    scale = np.sqrt(np.maximum(np.diagonal(gram, axis1=-2, axis2=-1), np.finfo(float).tiny))
    A, b, unit = _in_reach(gram / (scale[..., None] * scale[..., None, :]), right / scale)
    values, vectors = np.linalg.eigh(A)
    clear = np.abs(values) > rcond * np.max(np.abs(values), axis=-1, keepdims=True)
    parts = np.where(clear, (b[..., None, :] @ vectors)[..., 0, :], 0.0) / np.where(clear, values, 1.0)
    return (vectors @ parts[..., None])[..., 0] * unit / scale


def left_out(A: np.ndarray, b: np.ndarray, count: int, *, rcond: float) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return each of so many blocks of equations, columns of `A` and parts of `b`, and the solution of all others."""
    blocks = np.array_split(A, count, 1), np.array_split(b, count)
    pairs = list(zip(*blocks, strict=True))
    grams = A @ A.T - np.array([part @ part.T for part, _ in pairs])
    rights = A @ b - np.array([part @ of_b for part, of_b in pairs])
    return list(zip(*blocks, normal(grams, rights, rcond=rcond), strict=True))


def bounded(A: np.ndarray, b: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares solution between bounds, and -1, 0 or 1 for each part that is at a bound or is not."""
    from scipy.optimize import lsq_linear

    A, b, unit = _in_reach(A, b)
    solution = lsq_linear(A, b, (low / unit, high / unit), method="bvls")
    return solution.x * unit, solution.active_mask


def non_negative(A: np.ndarray, b: np.ndarray, *, rounds: int | None = None) -> np.ndarray:
    """Return the least-squares solution of which no part is negative."""
    from scipy.optimize import nnls

    A, b, unit = _in_reach(A, b)
    return nnls(A, b, maxiter=rounds)[0] * unit


def _in_reach(A: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return what a solver can square, and what its solution is multiplied by."""
    shift, shift_of_b = _exponent(A), _exponent(b)
    if shift == shift_of_b == 0:
        return A, b, 1.0
    return np.ldexp(A, -shift), np.ldexp(b, -shift_of_b), math.ldexp(1.0, max(min(shift_of_b - shift, 1000), -1000))


def _exponent(values: np.ndarray) -> int:
    """Return the power of two to take out of an array; none where it is within reach."""
    largest = float(np.max(np.abs(values), initial=0.0))
    if not math.isfinite(largest):
        raise InputError(
            "leaves the range of numbers",
            path="the fit",
            mend="Look for units, factors and values that are far off in the log, the axis file and the model",
        )
    return 0 if largest == 0.0 or 1.0 / REACH < largest < REACH else math.frexp(largest)[1]
