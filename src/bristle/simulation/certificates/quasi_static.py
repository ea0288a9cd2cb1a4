"""Contact in motion so slow that viscosity and micro-damping vanish: to a position, or to a force.

The speed is far below every Stribeck velocity, so friction reaches its break-away force. Forces are read
at rest, as the limits from both sides.
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
    """Range of forces of a contact at rest, and the distance over which its force builds up."""

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
        """Whether the force builds up over a distance to a break-away force."""
        return self.distance > 0.0 and self.breaks_away

    @property
    def breaks_away(self) -> bool:
        """Whether the contact rests under some forces and slides under others."""
        return 0.0 < self.half < math.inf


def holding_of(model: Model) -> Holding:
    """Return the range of forces of a friction model at rest, and the distance over which its force builds up."""
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
    if abs(after - before) <= 1e-3 * abs(after):
        return after
    return side * math.inf


class Path:
    """A virgin contact moved to positions or forces, from origin 0.

    Parameters
    ----------
    model : Model
        A friction model with pre-sliding.
    holding : Holding
        Its range of forces at rest.
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
        """The path so far: positions in the middle of steps and at turning points [m or rad], and the forces."""
        x, force = zip(*self._trace, strict=True)
        return np.concatenate(x), np.concatenate(force)

    def _note(self, start: float, force: np.ndarray) -> None:
        """Store the results of the steps from `start` to here."""
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
        """Move until the friction force is `target` [N or N*m]; return False if the contact slides before."""
        if self._contact.force(0.0) < target:
            return self._climb(target, 1.0)
        if self._contact.force(-0.0) > target:
            return self._climb(target, -1.0)
        # The force at rest is an interval that contains the target: no motion.
        return True

    def _climb(self, target: float, side: float) -> bool:
        self._side = side
        for _ in range(2000):
            before = self._contact.copy()
            start = self.x
            force = self._contact.move(side * CHUNK * self._step, CREEP, CHUNK)
            beyond = np.flatnonzero(side * (force - target) >= 0.0)
            if beyond.size or side * (self.force - target) >= 0.0:
                steps = int(beyond[0]) if beyond.size else CHUNK - 1
                below, forces = self._below(before, target, steps)
                self._contact = below
                self._note(start, forces)
                self._contact = _stopped_at(
                    below, target, side, (steps + 1 - forces.size) * self._step
                )
                self._note(self.x, np.empty(0))
                return True
            self._note(start, force)
        return False

    def _below(self, before: Contact, target: float, steps: int) -> tuple[Contact, np.ndarray]:
        """Return the contact after so many steps, or fewer until its force at rest is below; and mean forces."""
        # After steps with mean forces below the target, the force at rest may be above it.
        for count in range(steps, 0, -1):
            contact = before.copy()
            forces = contact.move(self._side * count * self._step, CREEP, count)
            if self._side * (contact.force(self._side * 0.0) - target) < 0.0:
                return contact, forces
        return before, np.empty(0)


def _stopped_at(contact: Contact, target: float, side: float, farthest: float) -> Contact:
    """Return the contact moved, by `farthest` at most, to the point where its force is `target`."""
    from scipy.optimize import root_scalar

    def excess(distance: float) -> float:
        ahead = contact.copy()
        ahead.move(side * distance, CREEP)
        return side * (ahead.force(side * 0.0) - target)

    if excess(0.0) < 0.0 < excess(farthest):
        solution = root_scalar(
            excess, bracket=(0.0, farthest), method="brentq", xtol=1e-15 * farthest
        )
        contact.move(side * solution.root, CREEP)
    elif excess(0.0) < 0.0:
        contact.move(side * farthest, CREEP)
    return contact


def traced(
    model: Model, lead: Callable[[Path, float], Any], ends: list[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the path of a virgin contact that moves slowly from force to force, or from position to position.

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
