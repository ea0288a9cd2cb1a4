r"""Linear systems in discrete time, measured on the functions that the simulation runs.

.. math:: s_{k+1} = A\,s_k + B\,u_k, \qquad y_k = C\,s_k + D\,u_k

Each column is the difference between two steps, one to either side: for a function that is straight between the two,
which control laws and mechanisms are piece by piece, the slope is exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model, Reference
from bristle.core.packing import pack, structure_of, unpacker

__all__ = ["LARGE", "SMALL", "LinearSystem", "linear_law", "measured_on", "varied_in"]

SMALL = 1e-12
"""Amplitude [SI] within every boundary layer, dead band and backlash."""
LARGE = 1e6
"""Amplitude [SI] so large that what is bounded (a switching term, a backlash) no longer counts beside it."""


class LinearSystem(NamedTuple):
    """State, input and output matrices, of shapes (n, n), (n,), (n,) and a number."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: float

    def is_like(self, system: LinearSystem, tolerance: float) -> bool:
        """Return whether each number of both is the same to a relative tolerance."""
        return all(np.allclose(a, b, rtol=tolerance, atol=0.0) for a, b in zip(self, system, strict=True))

    def without_what_fades(self, larger: LinearSystem) -> LinearSystem:
        """Return the system without the numbers that are less than half as large at ten times the amplitude."""
        pairs = zip(self, larger, strict=True)
        A, B, C, D = (np.where(np.abs(large) < 0.5 * np.abs(small), 0.0, small) for small, large in pairs)
        return LinearSystem(A, B, C, float(D))

    def beside(self, system: LinearSystem) -> LinearSystem:
        """Return both systems side by side: one input, the sum of their outputs."""
        n, m = self.B.size, system.B.size
        A = np.block([[self.A, np.zeros((n, m))], [np.zeros((m, n)), system.A]])
        return LinearSystem(A, np.append(self.B, system.B), np.append(self.C, system.C), self.D + system.D)

    def response(self, z: np.ndarray) -> np.ndarray:
        """Return the transfer function at points `z` of the complex plane, shape (point,)."""
        if not self.B.size:
            return np.full(z.shape, self.D, dtype=complex)
        resolvent = z[:, None, None] * np.eye(self.B.size) - self.A
        states = np.linalg.solve(resolvent, np.broadcast_to(self.B[:, None], (z.size, self.B.size, 1)))
        return states[:, :, 0] @ self.C + self.D


def linear_law(controller: Model, dt: float, amplitude: float) -> LinearSystem:
    """Return a control law from the measured position to the effort, about rest."""
    component, p = controller.component, controller.parameters
    if "limit" in p._fields:
        p = p._replace(limit=float("inf"))
    rest = component.start(0.0, 0.0, 0.0, dt, p)
    load, still = unpacker(structure_of(rest)), Reference(0.0, 0.0, 0.0, 0.0)

    def sample(state: np.ndarray, measured: float) -> tuple[np.ndarray, float]:
        effort, after = component.step(load(state), still, measured, dt, p)
        return pack(after), effort

    return measured_on(sample, pack(rest), varied_in(structure_of(rest)), amplitude)


def varied_in(structure: Any) -> np.ndarray:
    """Return which numbers of a packed state are states of a linear system: counters and modes are not."""
    flags: list[bool] = []
    for part in structure[1]:
        flags.extend(varied_in(part) if isinstance(part, tuple) else [part == "number"])
    return np.array(flags, dtype=bool)


def measured_on(
    sample: Callable[[np.ndarray, float], tuple[np.ndarray, float]], rest: np.ndarray, varied: np.ndarray, amplitude: float
) -> LinearSystem:
    """Return the linear system of a function of state and input that returns the next state and the output."""
    directions = [np.where(np.arange(rest.size) == i, amplitude, 0.0) for i in np.flatnonzero(varied)]
    moves = [(direction, 0.0) for direction in directions] + [(np.zeros(rest.size), amplitude)]
    columns, outputs = [], []
    for move, push in moves:
        (plus, out_plus), (minus, out_minus) = sample(rest + move, push), sample(rest - move, -push)
        columns.append((plus - minus)[varied] / (2.0 * amplitude))
        outputs.append((out_plus - out_minus) / (2.0 * amplitude))
    matrix = np.array(columns).T.reshape(-1, len(moves))
    return LinearSystem(matrix[:, :-1], matrix[:, -1], np.array(outputs[:-1]), float(outputs[-1]))
