"""A contact led slowly along a path of the table, and what the torque at the screw was."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bristle.core.contracts import Model
from bristle.engine import Contact, response

__all__ = ["Walk", "follow", "walk"]

STEP = 5e-9  # of the table [m]


class Walk(NamedTuple):
    """Where the table went and what friction was there."""

    x: np.ndarray
    torque: np.ndarray
    turns: np.ndarray

    @property
    def at_turns(self) -> np.ndarray:
        """Friction torque where it turned [N*m]."""
        return self.torque[self.turns]

    def leg(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and torques between turning point `index` and the one before it."""
        start = self.turns[index - 1] if index else 0
        part = slice(int(start), int(self.turns[index]) + 1)
        return self.x[part], self.torque[part]


def walk(model: Model, turns: Iterable[float], speed: float, arm: float, *, step: float = STEP) -> Walk:
    """Lead a virgin contact from the origin from turning point to turning point."""
    contact, position, path = Contact(model), 0.0, list(turns)
    start = arm * contact.force(math.copysign(0.0, path[0])) if path else 0.0
    x, torque, ends = [np.zeros(1)], [np.array([start])], []
    for turn in path:
        distance = turn - position
        count = max(math.ceil(abs(distance) / step - 1e-9), 1)
        if distance != 0.0:
            torque.append(arm * contact.move(distance, speed, count))
            x.append(position + distance * (np.arange(count) + 0.5) / count)
        position = turn
        x.append(np.array([position]))
        torque.append(np.array([arm * contact.force(math.copysign(0.0, distance))]))
        ends.append(sum(part.size for part in x) - 1)
    return Walk(np.concatenate(x), np.concatenate(torque), np.array(ends))


def follow(operator: Model, turns: Iterable[float], arm: float, *, step: float = STEP) -> Walk:
    """Lead a hysteresis operator, virgin at the origin, from turning point to turning point."""
    path = [0.0, *turns]
    counts = [max(math.ceil(abs(b - a) / step - 1e-9), 1) for a, b in pairwise(path)]
    legs = [np.linspace(a, b, n + 1)[1:] for (a, b), n in zip(pairwise(path), counts, strict=True)]
    x = np.concatenate([np.zeros(1), *legs])
    return Walk(x, arm * response(operator, x), np.cumsum(counts))
