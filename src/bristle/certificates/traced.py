"""What the figures of drift and closure show: where a contact goes, with which force."""

from __future__ import annotations

import numpy as np

from bristle.certificates.quasi_static import Path, holding_of
from bristle.core.contracts import Model

__all__ = ["traced_by_force", "traced_by_position"]


def traced_by_force(model: Model, levels: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the path of a contact that is led slowly from force to force.

    Parameters
    ----------
    model : Model
        A friction model with pre-sliding; it starts virgin.
    levels : list of float
        Forces [N or N*m], below break-away.

    Returns
    -------
    x, force : ndarray, shape (point,)
        Positions [m or rad] and friction forces [N or N*m].
    """
    path = Path(model, holding_of(model))
    for level in levels:
        path.to_force(level)
    return path.trace


def traced_by_position(model: Model, turns: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the path of a contact that is led slowly from position to position.

    Parameters
    ----------
    model : Model
        A friction model with pre-sliding; it starts virgin.
    turns : list of float
        Positions [m or rad].

    Returns
    -------
    x, force : ndarray, shape (point,)
        Positions [m or rad] and friction forces [N or N*m].
    """
    path = Path(model, holding_of(model))
    for turn in turns:
        path.to_position(turn)
    return path.trace
