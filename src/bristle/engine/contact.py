"""A contact moved by hand: friction with its state and memory, a few steps at a time."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.instance import Instance
from bristle.engine.motion import force_along_entry

__all__ = ["Contact"]


class Contact:
    """A friction model that is moved along a prescribed path, and looked at in between.

    Parameters
    ----------
    model : Model
        A friction model with parameters; it starts virgin, at position 0.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.x = 0.0
        self._part = Instance(model)
        self._memory = model.component.new_memory(model.parameters)
        self._entry = force_along_entry(self._part)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_entry"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._entry = force_along_entry(self._part)

    @property
    def state(self) -> np.ndarray:
        """The scalars of the state, in the order of its fields."""
        return self._part.state.copy()

    def copy(self) -> Contact:
        """Return a contact in the same state, which moves on its own from here."""
        other = copy.copy(self)
        other._part = copy.copy(self._part)
        other._part.state, other._memory = self._part.state.copy(), self._memory.copy()
        return other

    def move(self, distance: float, speed: float, count: int = 1) -> np.ndarray:
        """Move in equal steps at constant speed.

        Parameters
        ----------
        distance : float
            How far [m or rad], signed.
        speed : float
            How fast [m/s or rad/s], positive.
        count : int
            Number of steps.

        Returns
        -------
        ndarray, shape (count,)
            Mean friction force of each step [N or N*m].
        """
        v = np.full(count, np.copysign(speed, distance))
        x = self.x + distance * (np.arange(1, count + 1) / count)
        force = self._follow(self._part.state, self._memory, v, x, abs(distance) / speed / count)
        self.x += distance
        return force

    def force(self, v: float) -> float:
        """Return the friction force [N or N*m] at velocity `v` [m/s or rad/s] here and now; nothing moves."""
        at = np.array([self.x])
        return float(self._follow(self._part.state.copy(), self._memory.copy(), np.array([v]), at, 0.0)[0])

    def _follow(self, state: np.ndarray, memory: Any, v: np.ndarray, x: np.ndarray, dt: float) -> np.ndarray:
        force = np.empty(v.size)
        around = np.repeat(list(self._part.motion._field_defaults.values()), v.size)
        self._entry(self._part.parameters, state, memory, v, x, around, float(dt), force)
        return force
