"""`Passage`: a part of a log in which one kind of experiment was made."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

__all__ = ["KINDS", "Passage", "nesting"]

KINDS = {
    "constant_velocity": "slides at constant velocity",
    "loops": "loops before sliding",
    "break_away": "break-away from rest",
    "chirp": "oscillation of changing frequency",
    "oscillation": "oscillation of one frequency",
    "moves": "ordinary moves",
    "rest": "rest",
}


@dataclass(frozen=True)
class Passage:
    """A part of a log in which one kind of experiment was made."""

    kind: str
    samples: slice
    begin: float
    end: float
    legs: int = 0
    speeds: tuple[float, float] = (0.0, 0.0)
    amplitudes: tuple[float, float] = (0.0, 0.0)
    levels: int = 0
    depth: int = 0
    frequencies: tuple[float, float] = (0.0, 0.0)

    def as_data(self) -> dict[str, Any]:
        """Return it in numbers, in SI of the axis."""
        record = {name: value for name, value in vars(self).items() if name != "samples"}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in record.items()}


def nesting(turning: Iterable[float]) -> int:
    """Return how many turning points a contact must remember at most: those that lie inside one another.

    Examples
    --------
    >>> nesting([0, 7, -7, 7, -7]), nesting([0, 7, 1, 5, 3, 4])
    (2, 6)
    """
    points: list[float] = []
    most = 0
    for point in turning:
        # A turning point as far out as an earlier one wipes out what lies between them.
        while len(points) > 1 and abs(point - points[-1]) >= abs(points[-1] - points[-2]):
            points = points[:-2] if len(points) > 2 else points[1:]
        points.append(point)
        most = max(most, len(points))
    return most
