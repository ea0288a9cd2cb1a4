r"""Linear least squares, :math:`\min_x |A x - b|`, unbounded, bounded or non-negative.

The only module that calls linear solvers. If squares of numbers are not finite, solvers write beyond their memory or never
return, so large numbers are scaled by a power of two, which changes no digit.
"""

import math

import numpy as np

from bristle.core.errors import InputError

REACH = 1e100  # numbers between 1/REACH and REACH are not scaled


def unbounded(A: np.ndarray, b: np.ndarray, *, rcond: float | None = None) -> np.ndarray:
    """Return the least-squares solution, or the shortest of several solutions."""
    A, b, unit = _in_reach(A, b)
    return np.linalg.lstsq(A, b, rcond=rcond)[0] * unit


def apart_from(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the part of a column, or of several, that is orthogonal to an orthonormal basis."""
    return columns - basis @ (basis.T @ columns)


def normal(gram: np.ndarray, right: np.ndarray, *, rcond: float) -> np.ndarray:
    """Solve normal equations after scaling their diagonal to 1; shapes (..., n, n) and (..., n)."""
    scale = np.sqrt(np.maximum(np.diagonal(gram, axis1=-2, axis2=-1), np.finfo(float).tiny))
    A, b, unit = _in_reach(gram / (scale[..., None] * scale[..., None, :]), right / scale)
    values, vectors = np.linalg.eigh(A)
    clear = np.abs(values) > rcond * np.max(np.abs(values), axis=-1, keepdims=True)
    parts = np.where(clear, (b[..., None, :] @ vectors)[..., 0, :], 0.0) / np.where(
        clear, values, 1.0
    )
    return (vectors @ parts[..., None])[..., 0] * unit / scale


def left_out(
    A: np.ndarray, b: np.ndarray, count: int, *, rcond: float
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return `count` blocks of equations, columns of `A` and parts of `b`, each with the solution of all other blocks."""
    blocks = np.array_split(A, count, 1), np.array_split(b, count)
    pairs = list(zip(*blocks, strict=True))
    grams = A @ A.T - np.array([part @ part.T for part, _ in pairs])
    rights = A @ b - np.array([part @ of_b for part, of_b in pairs])
    return list(zip(*blocks, normal(grams, rights, rcond=rcond), strict=True))


def bounded(
    A: np.ndarray, b: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares solution within bounds, and for each part -1 (lower bound), 0 (free) or 1 (upper bound)."""
    from scipy.optimize import lsq_linear

    A, b, unit = _in_reach(A, b)
    solution = lsq_linear(A, b, (low / unit, high / unit), method="bvls")
    return np.clip(
        solution.x * unit, low, high
    ), solution.active_mask  # the solver rounds beyond the bounds


def non_negative(A: np.ndarray, b: np.ndarray, *, rounds: int | None = None) -> np.ndarray:
    """Return the non-negative least-squares solution."""
    from scipy.optimize import nnls

    A, b, unit = _in_reach(A, b)
    return nnls(A, b, maxiter=rounds)[0] * unit


def _in_reach(A: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Scale a problem for a solver, and return the factor of its solution."""
    shift, shift_of_b = _exponent(A), _exponent(b)
    if shift == shift_of_b == 0:
        return A, b, 1.0
    return (
        np.ldexp(A, -shift),
        np.ldexp(b, -shift_of_b),
        math.ldexp(1.0, max(min(shift_of_b - shift, 1000), -1000)),
    )


def _exponent(values: np.ndarray) -> int:
    """Return the exponent of the power of two to factor out of an array; 0 if it is not too large."""
    largest = float(np.max(np.abs(values), initial=0.0))
    if not math.isfinite(largest):
        raise InputError(
            "exceeds the range of floating-point numbers",
            path="the fit",
            mend="Look for wrong units, factors and values in the log, the axis file and the model",
        )
    return 0 if largest == 0.0 or 1.0 / REACH < largest < REACH else math.frexp(largest)[1]
