"""A contact moved so slowly that neither viscosity nor micro-damping shows: by position, or until a force is reached.

The speed is far below every Stribeck velocity, so friction holds all it can hold: its break-away force. Forces are read
at rest, as the limits from either side.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.engine.contact import Contact

CREEP = 1e-15  # [m/s or rad/s]
LONGEST = 1e3  # [m or rad]
RESOLUTION = 200  # steps over the distance in which half of the break-away force builds up
CHUNK = 100  # steps


@dataclass(frozen=True)
class Holding:
    """What a contact holds at rest, and over what distance its force builds up."""

    backward: float
    forward: float
    distance: float

    @property
    def half(self) -> float:
        """Half of the interval: the break-away force F_S of a symmetric contact [N or N*m]."""
        return 0.5 * (self.forward - self.backward)

    def level(self, share: float) -> float:
        """Return the force at a share of the way from the middle of the interval to break-away [N or N*m]."""
        return 0.5 * (self.forward + self.backward) + share * self.half

    @property
    def has_presliding(self) -> bool:
        """Whether the force builds up over a distance, and there is a break-away force to build up to."""
        return self.distance > 0.0 and self.breaks_away

    @property
    def breaks_away(self) -> bool:
        """Whether there is a force that it holds, and one that it does not."""
        return 0.0 < self.half < math.inf


def holding_of(model: Model) -> Holding:
    """Return what a friction model holds at rest, and over what distance its force builds up."""
    forward, backward = (_slid_to_the_end(model, side) for side in (1.0, -1.0))
    holding = Holding(backward, forward, 0.0)
    if not holding.breaks_away:
        return holding
    contact = Contact(model)
    if contact.force(0.0) >= holding.level(0.5):
        return holding
    for reach in np.geomspace(1e-15, LONGEST, 400):
        contact.move(reach - contact.x, CREEP)
        if contact.force(0.0) >= holding.level(0.5):
            return Holding(backward, forward, float(reach))
    return holding


def _slid_to_the_end(model: Model, side: float) -> float:
    contact = Contact(model)
    for reach in np.geomspace(1e-12, LONGEST, 100):
        contact.move(side * reach - contact.x, CREEP)
    before = contact.force(side * 0.0)
    contact.move(contact.x, CREEP)
    after = contact.force(side * 0.0)
    return after if abs(after - before) <= 1e-3 * abs(after) else side * math.inf


class Path:
    """A virgin contact led by position or by force, from origin 0.

    Parameters
    ----------
    model : Model
        A friction model with pre-sliding.
    holding : Holding
        What it holds at rest.
    """

    def __init__(self, model: Model, holding: Holding) -> None:
        self._contact = Contact(model)
        self._step = holding.distance / RESOLUTION
        self._side = 1.0
        self._trace: list[tuple[np.ndarray, np.ndarray]] = [(np.zeros(1), np.array([self.force]))]

    @property
    def x(self) -> float:
        """Position [m or rad]."""
        return self._contact.x

    @property
    def force(self) -> float:
        """Friction force [N or N*m] on the branch of the last motion."""
        return self._contact.force(self._side * 0.0)

    @property
    def trace(self) -> tuple[np.ndarray, np.ndarray]:
        """Where it has been so far: positions in the middle of steps and where it turned [m or rad], and the forces."""
        x, force = zip(*self._trace, strict=True)
        return np.concatenate(x), np.concatenate(force)

    def _note(self, start: float, force: np.ndarray) -> None:
        """Keep what steps to here, from `start`, have shown."""
        between = start + (self.x - start) * (np.arange(force.size) + 0.5) / max(force.size, 1)
        self._trace.append((np.append(between, self.x), np.append(force, self.force)))

    def to_position(self, x: float) -> None:
        """Go to a position [m or rad]."""
        start = self.x
        distance = x - start
        if distance == 0.0:
            return
        self._side = math.copysign(1.0, distance)
        count = math.ceil(min(max(abs(distance) / self._step, 1.0), 1e6))
        force = self._contact.move(distance, CREEP, count)
        self._contact.x = x
        self._note(start, force)

    def to_force(self, target: float) -> bool:
        """Go on until the friction force is `target` [N or N*m]; return False where the contact slides away before."""
        if self._contact.force(0.0) < target:
            return self._climb(target, 1.0)
        if self._contact.force(-0.0) > target:
            return self._climb(target, -1.0)
        # The force at rest is an interval that holds the target: nothing moves.
        return True

    def _climb(self, target: float, side: float) -> bool:
        self._side = side
        for _ in range(2000):
            before, start = self._contact.copy(), self.x
            force = self._contact.move(side * CHUNK * self._step, CREEP, CHUNK)
            beyond = np.flatnonzero(side * (force - target) >= 0.0)
            if beyond.size or side * (self.force - target) >= 0.0:
                steps = int(beyond[0]) if beyond.size else CHUNK - 1
                below, forces = self._below(before, target, steps)
                self._contact = below
                self._note(start, forces)
                self._contact = _stopped_at(below, target, side, (steps + 1 - forces.size) * self._step)
                self._note(self.x, np.empty(0))
                return True
            self._note(start, force)
        return False

    def _below(self, before: Contact, target: float, steps: int) -> tuple[Contact, np.ndarray]:
        """Return the contact moved on by so many steps, or fewer until its force at rest is below; and mean forces."""
        # After steps whose mean forces are below the target, what is held at rest may be above it.
        for count in range(steps, 0, -1):
            contact = before.copy()
            forces = contact.move(self._side * count * self._step, CREEP, count)
            if self._side * (contact.force(self._side * 0.0) - target) < 0.0:
                return contact, forces
        return before, np.empty(0)


def _stopped_at(contact: Contact, target: float, side: float, farthest: float) -> Contact:
    """Return the contact moved on, `farthest` at most, to where its force is `target`."""
    from scipy.optimize import root_scalar

    def excess(distance: float) -> float:
        ahead = contact.copy()
        ahead.move(side * distance, CREEP)
        return side * (ahead.force(side * 0.0) - target)

    if excess(0.0) < 0.0 < excess(farthest):
        solution = root_scalar(excess, bracket=(0.0, farthest), method="brentq", xtol=1e-15 * farthest)
        contact.move(side * solution.root, CREEP)
    elif excess(0.0) < 0.0:
        contact.move(side * farthest, CREEP)
    return contact


def traced(model: Model, lead: Callable[[Path, float], Any], ends: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the path of a virgin contact that is led slowly from force to force, or from position to position.

    Parameters
    ----------
    model : Model
        A friction model with pre-sliding.
    lead : callable
        `Path.to_force` or `Path.to_position`.
    ends : list of float
        Forces below break-away [N or N*m], or positions [m or rad].

    Returns
    -------
    x, force : ndarray, shape (point,)
        Positions [m or rad] and friction forces [N or N*m].
    """
    path = Path(model, holding_of(model))
    for end in ends:
        lead(path, end)
    return path.trace
