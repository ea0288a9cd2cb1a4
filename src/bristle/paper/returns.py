"""Paths before break-away that come back to where they turned, and what is missing there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bristle.core.errors import InputError
from bristle.paper.reproduced import percent
from bristle.paper.setting import Setting
from bristle.paper.walk import Walk, walk

__all__ = ["CLOSED", "closure_text", "comes_back", "missing_at", "must_return", "traces", "walks_of"]

CLOSED = 0.005  # of the largest torque: what a torque sensor would not tell from nothing


def walks_of(setting: Setting, *needed: str) -> dict[str, Walk]:
    """Return the walks of all contacts along the path; those that are `needed` must be among them."""
    for name in needed:
        setting.contact(name)
    turns, speed = setting["path", "turns"], setting["path", "speed"]
    return {name: walk(model, turns, speed, setting.arm) for name, model in setting.contacts.items()}


def traces(walks: Mapping[str, Walk]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return positions [m] and torques [N*m] by name, as figures take them."""
    return {name: (path.x, path.torque) for name, path in walks.items()}


def missing_at(path: Walk, returns: tuple[int, int]) -> float:
    """Return the torque missing at a return to a turning point, over the largest torque on the path."""
    left, back = (path.at_turns[index] for index in returns)
    return float(back - left) / float(np.max(np.abs(path.torque)))


def closure_text(share: float) -> str:
    """Return for a title what is missing at a return."""
    return f"{percent(share)} at the return" if abs(share) >= CLOSED else "closes"


def comes_back(share: float, letter: str) -> str:
    """Return in words what is missing back at a letter."""
    if abs(share) < CLOSED:
        return f"closes at {letter}"
    word = "missing" if share < 0.0 else "too much"
    return f"back at {letter}, {percent(abs(share))} of the largest torque is {word}"


def must_return(setting: Setting, pairs: tuple[tuple[int, int], ...]) -> None:
    """Refuse a path that does not come back to where it turned."""
    turns = setting["path", "turns"]
    for first, second in pairs:
        if turns.size <= max(first, second) or turns[first] != turns[second]:
            raise InputError(
                f"must come back: its entries {first + 1} and {second + 1} must be the same",
                path=f"{setting.source}: path.turns",
                value=turns.tolist(),
            )
